"""Find the loops that a function was in when it exceeded its time limit."""

from __future__ import annotations

import ast
import contextlib
import inspect
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import CodeType

from utils.checks.tips import function_name, student_frames
from utils.remote_objects import ENDLESS_LOOP_HINT


@dataclass(frozen=True)
class Loop:
    """A loop in a cell.

    Attributes
    ----------
    line : int
        Number of its first line in the function's cell.
    function : str
        Name of the function that contains the loop.
    text : str
        Text of its first line.
    condition : str
        The condition of a `while` loop; empty for a `for` loop.
    """

    line: int
    function: str
    text: str
    condition: str

    def __str__(self) -> str:
        return f"line {self.line} of the cell of {self.function}, `{self.text}`"


def loops_around(error: BaseException, function: Callable) -> list[Loop]:
    """Return the loops in which a student's code was interrupted, the innermost first.

    Parameters
    ----------
    error : BaseException
        The interrupt, with its traceback.
    function : callable
        The student's function.

    Returns
    -------
    list of Loop
        Only the `while` loops, if there are any, because most `for` loops end by themselves.
    """
    found = [
        loop
        for code, line in reversed(student_frames(error, function))
        for loop in _loops_around_line(code, line)
    ]
    return [loop for loop in found if loop.condition] or found


def _loops_around_line(code: CodeType, line: int) -> Iterator[Loop]:
    """Yield the loops of a function around a line of its cell, the innermost first."""
    with contextlib.suppress(OSError, TypeError, SyntaxError):
        lines, first = inspect.getsourcelines(code)
        rows = textwrap.dedent("".join(lines)).split("\n")
        nodes = [
            node
            for node in ast.walk(ast.parse("\n".join(rows)))
            if _is_loop_around(node, line - first)
        ]
        for node in sorted(nodes, key=lambda node: -node.lineno):
            condition = ast.unparse(node.test) if isinstance(node, ast.While) else ""
            text = rows[node.lineno - 1].strip()
            yield Loop(first + node.lineno - 1, function_name(code), text, condition)


def _is_loop_around(node: ast.AST, row: int) -> bool:
    """Return whether a node is a loop around a row, counted from 0."""
    return isinstance(node, ast.While | ast.For) and node.lineno - 1 <= row < node.end_lineno


def explanation(loops: list[Loop], question: str) -> str:
    """Return the text that follows "f did not return within 15 s".

    Parameters
    ----------
    loops : list of Loop
        From `loops_around`.
    question : str
        The question that the check suggests; may be empty.
    """
    if not loops:
        return f": {question or ENDLESS_LOOP_HINT}"
    where = f". It was in the loop in {loops[0]}"
    if len(loops) > 1:
        where += f", inside the loop in {loops[1]}"
    return f"{where}. {question[:1].upper() + question[1:] or _question_about(loops)}"


def _question_about(loops: list[Loop]) -> str:
    first = loops[0]
    if not first.condition:
        return "Does the loop add items to the list it runs over, or are there far too many items?"
    if len(loops) > 1:
        return "Which of the two loops never ends?"
    if first.condition in ("True", "1"):
        return "Does the loop ever reach its `break` or `return`?"
    return f"Which line of the loop makes `{first.condition}` false?"
