"""What a lesson takes over from earlier ones, copied out of their sources at build.

A cell tagged `earlier` is where students paste functions that they wrote before. In the source of
the lesson it names them, between the marks of a solution:

    ### BEGIN SOLUTION
    # from 06_filter_ground: filter_ground, voxel_grid
    ### END SOLUTION

The instructor's notebook has the functions in their place, and all that these use of their own
notebook; the student's has neither. So each algorithm stands in its lesson and nowhere else.
"""

from __future__ import annotations

import ast
import re

from grader.course.paths import PROJECT
from utils.notebooks import slicing

TAG = "earlier"
LINE = re.compile(r"^# from (\d\d_\w+): (\w+(?:, \w+)*)$", re.M)
MARKS = ("### BEGIN SOLUTION", "### END SOLUTION")
REGION = re.compile(r"\n?### BEGIN SOLUTION\n.*?### END SOLUTION", re.S)


def filled(text: str) -> str:
    """A text with the functions that it names in the place of their names.

    Parameters
    ----------
    text : str
        Of a cell, or of a whole source.

    Returns
    -------
    str

    Raises
    ------
    ValueError
        There is no such lesson, or it defines no such function.
    """
    parts: dict[str, list[str]] = {
        found[0]: statements_of(found[1], found[2].split(", ")) for found in LINE.finditer(text)
    }
    imports = [part for code in parts.values() for part in code if _is_import(part)]
    for line, code in parts.items():
        definitions = [part for part in code if not _is_import(part)]
        above = "\n".join(dict.fromkeys(imports)) + "\n\n\n" if imports else ""
        imports = []  # all of them stand before the first lesson's functions
        text = text.replace(line, f"{above}{line}\n" + "\n\n\n".join(definitions) + "\n\n")
    return text


def emptied(text: str) -> str:
    """The same cell as students get it."""
    return REGION.sub("", text)


def statements_of(lesson: str, names: list[str]) -> list[str]:
    """Source of some functions of a lesson and of what they need, the marks of solutions left out.

    Parameters
    ----------
    lesson : str
        Such as ``06_filter_ground``.
    names : list of str

    Returns
    -------
    list of str
        One for each statement, in the order of the lesson.
    """
    path = next((PROJECT / "solutions").glob(f"*/{lesson}.py"), None)
    if path is None:
        raise ValueError(f"There is no lesson {lesson!r}, from which functions are wanted.")
    text = path.read_text("utf-8")
    statements, _ = slicing.parse_notebook([text])
    missing = set(names).difference(*(statement.binds for statement in statements))
    if missing:
        raise ValueError(f"{lesson} does not define {' or '.join(sorted(missing))}.")
    lines = text.splitlines()
    found = []
    for statement in slicing.slice_for(names, statements):
        first = min(
            part.lineno for part in (statement.node, *getattr(statement.node, "decorator_list", ()))
        )
        chosen = lines[first - 1 : statement.node.end_lineno]
        found.append("\n".join(line for line in chosen if line.strip() not in MARKS))
    return found


def _is_import(part: str) -> bool:
    return isinstance(ast.parse(part).body[0], (ast.Import, ast.ImportFrom))
