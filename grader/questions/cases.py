"""Small cases, which a lesson declares in ``questions.py`` in its folder in ``solutions/``.

A lesson's ``questions.py`` defines `CASES`: a tuple of `Case` objects for each exercise. Cases are
small enough for paper and share no data with hidden tests, because students see them.
"""

from __future__ import annotations

import functools
import importlib.util
from dataclasses import dataclass

from grader.course.lessons import Lesson


@dataclass(frozen=True)
class Case:
    """A small call of a student's function.

    Attributes
    ----------
    code : str
        Statements that students read and the sandbox runs; the last one is an expression. The name
        `np` is NumPy. The name `rng` is a seed; no outcome may depend on its value.
    larger : str
        The same call with more input, for questions about cost.
    asked : str
        A question about the call, if it does not ask for the value of the last expression.
    run : str
        Statements that run in place of `code` to answer `asked`.
    kind : str
        Kind of a question with `asked`: "trace" or "cost".
    """

    code: str
    larger: str = ""
    asked: str = ""
    run: str = ""
    kind: str = "trace"

    @property
    def executed(self) -> str:
        """The statements that the sandbox runs."""
        return self.run or self.code


def shown_code(code: str) -> str:
    """Return the statements of a case as students read them, with a value for `rng`."""
    return f"rng = 7  # the result is the same for every seed\n{code}" if "rng" in code else code


@functools.cache
def cases_of(lesson: Lesson) -> dict[str, tuple[Case, ...]]:
    """Return the cases of a lesson by exercise; empty if the lesson declares none."""
    path = lesson.folder / "questions.py"
    if not path.is_file():
        return {}
    spec = importlib.util.spec_from_file_location(f"questions_{lesson.name}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.CASES
