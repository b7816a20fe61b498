"""The program that a worker runs: a notebook's code, given code, and the lesson's rules."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

from utils import in_sandbox

INSTALLED_PACKAGES = in_sandbox.INSTALLED

# If a notebook has more lines than this, messages do not show its lines, because student code could
# send a message by choosing the line that fails. Solved lessons have fewer lines.
MAX_NOTEBOOK_LINES = 4096


def cell_and_line(place: str) -> tuple[int, int] | None:
    """Return the numbers in a place such as ``code cell 3, line 12``; None for any other text."""
    found = re.fullmatch(r"code cell (\d{1,4}), line (\d{1,6})", place)
    return (int(found[1]), int(found[2])) if found else None


@dataclass(frozen=True)
class GivenCode:
    """Code of the lesson that replaces the notebook's own definitions of some names.

    Attributes
    ----------
    names : tuple of str
    source : str
    open_names : tuple of str
        Names that a notebook may redefine. If it does, its own definitions are used.
    """

    names: tuple[str, ...] = ()
    source: str = ""
    open_names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Program:
    """Everything that a worker receives: a notebook's code and the rules of its lesson.

    Attributes
    ----------
    cells : tuple of str
        Source of the notebook's code cells.
    names : tuple of str
        The functions and classes that the judge may call.
    modules : dict of str to str
        Source of the modules that were submitted with the notebook, by name.
    given : GivenCode
    forbidden : tuple of str
        Modules that the lesson does not allow.
    packages : tuple of str
        Installed packages that the lesson allows.
    steps : tuple of str
        Functions that students write in the lesson without earning points. The judge does not call
        them, but a message may name one that is still a stub.
    python : tuple of int
        The version of Python that ran the notebook, such as (3, 12); empty if it is unknown.
    """

    cells: tuple[str, ...]
    names: tuple[str, ...]
    modules: dict[str, str] = field(default_factory=dict)
    given: GivenCode = GivenCode()
    forbidden: tuple[str, ...] = ()
    packages: tuple[str, ...] = INSTALLED_PACKAGES
    steps: tuple[str, ...] = ()
    python: tuple[int, ...] = ()

    @property
    def named_packages(self) -> tuple[str, ...]:
        """Allowed packages whose names occur anywhere in the code, even in a comment."""
        sources = (*self.cells, *self.modules.values(), self.given.source)
        return tuple(name for name in self.packages if any(name in source for source in sources))

    def edited(self, cell: int, first: int, last: int, text: str) -> Program:
        """Return a copy in which `text` replaces lines `first` to `last` of a cell."""
        lines = self.cells[cell - 1].split("\n")
        changed = "\n".join([*lines[: first - 1], text, *lines[last:]])
        return replace(self, cells=(*self.cells[: cell - 1], changed, *self.cells[cell:]))

    def line_at(self, place: str) -> str | None:
        """Return the line at a place such as ``code cell 3, line 12``; None if there is none.

        If the notebook has more than `MAX_NOTEBOOK_LINES` lines, the result is always None.
        """
        found = cell_and_line(place)
        if not found or sum(1 + cell.count("\n") for cell in self.cells) > MAX_NOTEBOOK_LINES:
            return None
        cell, line = found
        lines = self.cells[cell - 1].split("\n") if 0 < cell <= len(self.cells) else []
        return lines[line - 1].strip() if 0 < line <= len(lines) else None
