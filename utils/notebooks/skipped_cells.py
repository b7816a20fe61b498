"""Describe the code cells that the judge skips, and the functions that they would define."""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass

from utils.notebooks.magics import hiding_magic, parse_cell
from utils.notebooks.newer_syntax import parse_newer_syntax

LONGEST_LINE = 80
_CORRECT = "Correct it, run the cell, and submit the notebook again."
_TYPE_AGAIN = (
    "Delete that character and type it again. Text that was copied from a page or a PDF may "
    "contain characters that only look right."
)


@dataclass(frozen=True)
class SkippedCell:
    """A code cell whose statements do not become part of the notebook's program.

    Attributes
    ----------
    number : int
    source : str
    reason : str
        Why the cell was skipped, as the rest of a sentence, such as "is not valid Python".
    detail : str
        Python's message and the line that it is about; may be empty.
    remedy : str
        One or more sentences.
    magic : str
        The magic that keeps the cell's names from the notebook; empty if there is none.
    newer : ast.Module or None
        The code, if only a newer Python can run it; empty if its syntax is unknown. See
        `newer_syntax.parse_newer_syntax`.
    """

    number: int
    source: str
    reason: str
    detail: str = ""
    remedy: str = _CORRECT
    magic: str = ""
    newer: ast.Module | None = None

    @property
    def sentence(self) -> str:
        """A sentence about the cell."""
        return f"Code cell {self.number} {self.reason}, so it was skipped{self._detail}."

    def describe_missing(self, name: str) -> str:
        """Return sentences about a function that is missing because the cell was skipped."""
        return (
            f"{name} is in code cell {self.number}, which was skipped, because it "
            f"{self.reason}{self._detail}. {self.remedy}"
        )

    def defines(self, name: str) -> bool:
        """Return whether the cell seems to define a function, a class or a method."""
        if name not in self.source:
            return False
        python = rf"^[ \t]*(?:async[ \t]+|cdef[ \t]+)?(?:def|class)[ \t]+{name}\b|^{name}[ \t]*="
        cython = rf"^[ \t]*cp?def[ \t][^\n(]*\b{name}[ \t]*\("  # a type may precede the name
        pattern = f"{python}|{cython}"
        return bool(re.search(pattern, self.source, re.MULTILINE))

    @property
    def _detail(self) -> str:
        return f": {self.detail}" if self.detail else ""


def hidden_cell(number: int, source: str) -> SkippedCell | None:
    """Describe a cell whose magic keeps its code from the notebook; return None for other cells."""
    magic = hiding_magic(source)[:20]
    remedy = "Delete that line, and write the function in plain Python."
    return SkippedCell(number, source, f"begins with {magic}", "", remedy, magic) if magic else None


def invalid_cell(
    number: int, source: str, error: Exception, python: tuple[int, ...]
) -> SkippedCell:
    """Describe a cell that Python cannot parse.

    Parameters
    ----------
    number : int
    source : str
    error : Exception
        The exception that the parser raised.
    python : tuple of int
        The version of Python that ran the notebook; empty if it is unknown.
    """
    found = parse_newer_syntax(source, parse_cell, python)
    if found:
        tree, version = found
        reason = f"needs Python {'.'.join(map(str, version))} or later"
        return SkippedCell(number, source, reason, newer=tree)
    if "\0" in source:
        line = source.count("\n", 0, source.index("\0")) + 1
        detail = f"it contains the character NUL (line {line})"
        return SkippedCell(number, source, "is not valid Python", detail, _TYPE_AGAIN)
    if not isinstance(error, SyntaxError):
        return SkippedCell(number, source, f"could not be read ({type(error).__name__})")
    text = (error.text or "").strip()[:LONGEST_LINE]
    where = f" (line {error.lineno}: {text!r})" if error.lineno else ""
    remedy = _TYPE_AGAIN if re.search(r"character .*U\+", error.msg) else _CORRECT
    return SkippedCell(number, source, "is not valid Python", f"{error.msg}{where}", remedy)
