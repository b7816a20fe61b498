"""Copy functions of earlier lessons into a lesson during the build.

Students paste the functions that they wrote in earlier lessons into a cell tagged `earlier`. In the
source of the lesson, this cell only names the functions, between nbgrader's solution marks:

    ### BEGIN SOLUTION
    # from 06_filter_ground: filter_ground, voxel_grid
    ### END SOLUTION

In the instructor's notebook, the build inserts the code of the functions, and other code of their
lesson that they need. The student's notebook contains neither the reference nor the code. Each
algorithm is therefore written only once.
"""

from __future__ import annotations

import functools
import re

from grader.course.paths import PROJECT
from utils.notebooks import pasting

TAG = "earlier"
REFERENCE = re.compile(r"^# from (\d\d_\w+): (\w+(?:, \w+)*)$", re.M)
SOLUTION_MARKS = ("### BEGIN SOLUTION", "### END SOLUTION")
SOLUTION_REGION = re.compile(r"\n?### BEGIN SOLUTION\n.*?### END SOLUTION", re.S)


def insert_functions(text: str) -> str:
    """Insert the code of functions from earlier lessons at the references to them.

    Parameters
    ----------
    text : str
        Source of a cell or of a whole lesson.

    Raises
    ------
    ValueError
        If the lesson does not exist or does not define the function.
    """
    code_by_reference: dict[str, list[str]] = {
        found[0]: statements_of(found[1], found[2].split(", "))
        for found in REFERENCE.finditer(text)
    }
    imports = [
        part for code in code_by_reference.values() for part in code if pasting.is_import(part)
    ]
    copied_statements: set[str] = set()
    for line, code in code_by_reference.items():
        # Code that two earlier lessons share is inserted only once.
        definitions = [
            part for part in code if not pasting.is_import(part) and part not in copied_statements
        ]
        copied_statements.update(definitions)
        header = "\n".join(dict.fromkeys(imports)) + "\n\n\n" if imports else ""
        imports = []  # placed before the functions of the first lesson
        text = text.replace(line, f"{header}{line}\n" + "\n\n\n".join(definitions) + "\n\n")
    return text


def remove_solution(text: str) -> str:
    """Return the text of a cell without its solution, as students get it."""
    return SOLUTION_REGION.sub("", text)


def statements_of(lesson: str, names: list[str]) -> list[str]:
    """Return the source of some functions of a lesson and of the code that they need.

    The source does not contain the solution marks.

    Parameters
    ----------
    lesson : str
        Name of a lesson, such as ``06_filter_ground``.
    names : list of str

    Returns
    -------
    list of str
        Source of each statement, in the order of the lesson.
    """
    path = next((PROJECT / "solutions").glob(f"*/{lesson}/lesson.py"), None)
    if path is None:
        raise ValueError(f"There is no lesson {lesson!r} to take functions from.")
    try:
        return list(_cached_statements(tuple(names), path.read_text("utf-8"), lesson))
    except LookupError as error:
        raise ValueError(str(error)) from None


@functools.lru_cache(maxsize=256)
def _cached_statements(names: tuple[str, ...], source: str, lesson: str) -> tuple[str, ...]:
    """Return the statements. The result is cached, because several lessons need it."""
    return tuple(_remove_marks(text) for text in pasting.source_texts(names, [source], lesson))


def _remove_marks(text: str) -> str:
    return "\n".join(line for line in text.splitlines() if line.strip() not in SOLUTION_MARKS)
