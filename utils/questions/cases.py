"""Small cases, which a lesson declares in ``utils/questions/lesson_NN.py``.

The module defines `CASES`: a tuple of `Case` objects for each exercise. Cases are small enough for
paper and contain no answers. They share no data with hidden tests, because students see them.
"""

from __future__ import annotations

import ast
import functools
import importlib
import pkgutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Case:
    """A small call of a student's function.

    Attributes
    ----------
    code : str
        Statements that students read and run; the last one is an expression. The name `np` is
        NumPy. The name `rng` is a seed; no outcome may depend on its value.
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
        """The statements that run."""
        return self.run or self.code


def shown_code(code: str) -> str:
    """Return the statements of a case as students read them, with a value for `rng`."""
    return f"rng = 7  # the result is the same for every seed\n{code}" if "rng" in code else code


def shown_together(cases: Mapping[str, str]) -> str:
    """Return the codes of several cases, each below its heading; shared definitions come first."""
    shared = _shared_definitions([*cases.values()])
    parts = [
        f"# {heading}\n{shown_code(code.removeprefix(shared).lstrip())}"
        for heading, code in cases.items()
    ]
    return "\n\n".join([shared.rstrip(), *parts] if shared else parts)


def _shared_definitions(codes: Sequence[str]) -> str:
    """Return the text with which all codes begin, up to the last function or class in it."""
    lines = codes[0].split("\n")
    ends = [
        node.end_lineno
        for node in ast.parse(codes[0]).body
        if isinstance(node, (ast.FunctionDef, ast.ClassDef))
    ]
    texts = ["\n".join(lines[:end]) + "\n" for end in ends]
    return next((text for text in texts[::-1] if all(c.startswith(text) for c in codes)), "")


def value_phrase(code: str) -> str:
    """Return the words with which a question refers to the value of a case."""
    is_long = "\n" in code.strip()
    return "the value of the last line below" if is_long else "the value of this expression"


def cases_of(exercise: str) -> tuple[Case, ...]:
    """Return the cases of an exercise; empty if its lesson declares none."""
    return _all_cases().get(exercise, ())


def exercises_with_cases() -> list[str]:
    """Return the names of all exercises that have cases, in the order of the course."""
    return list(_all_cases())


@functools.cache
def _all_cases() -> dict[str, tuple[Case, ...]]:
    package = importlib.import_module("utils.questions")
    names = [module.name for module in pkgutil.iter_modules(package.__path__)]
    modules = [
        importlib.import_module(f"{package.__name__}.{name}")
        for name in names
        if name.startswith("lesson_")
    ]
    return {exercise: cases for module in modules for exercise, cases in module.CASES.items()}
