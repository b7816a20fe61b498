"""Find functions and classes of the lesson that a sheet uses but does not print."""

from __future__ import annotations

import ast
import functools
import re
from collections.abc import Iterable, Sequence

from grader.course.lessons import Lesson
from grader.intake.preflight import cells_as_released
from grader.questions.answer import ListedLine
from grader.questions.question import Question

_CALL = re.compile(r"(?<![\w.])(\w+)\(")


def called_helpers(
    lesson: Lesson, exercise: str, lines: Iterable[ListedLine], questions: Iterable[Question]
) -> tuple[str, ...]:
    """Return the lesson's functions and classes that code on a sheet calls but that it lacks."""
    code = "\n".join([*(line.text for line in lines), *(question.code for question in questions)])
    printed = {exercise, *re.findall(r"\b(?:def|class) (\w+)", code)}
    called = dict.fromkeys(_CALL.findall(code))
    return tuple(name for name in called if name in _names_of(lesson) and name not in printed)


def sentence_about(helpers: Sequence[str]) -> str:
    """Return the sentence that names helpers on a sheet; empty without any."""
    *first, last = (f"`{name}`" for name in helpers or ("",))
    names = f"{', '.join(first)} and {last}" if first else last
    return f"The code also calls {names} from the lesson." if helpers else ""


@functools.cache
def _names_of(lesson: Lesson) -> frozenset[str]:
    """Return the functions and classes that a lesson's notebook defines or imports from `utils`."""
    names = set()
    for cell in cells_as_released(lesson):
        if cell.kind == "code":
            names.update(_names_in(cell.source))
    return frozenset(names)


def _names_in(source: str) -> Iterable[str]:
    try:
        tree = ast.parse(source)
    except SyntaxError:  # the cell contains an IPython magic
        return
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            yield node.name
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("utils"):
            yield from (alias.asname or alias.name for alias in node.names)
