"""Declare the visible checks of an exercise in a few lines, as examples and promises.

Each example is a call and its right answer::

    total = Exercise(
        __name__, "total", {"numbers": [3.0, 4.0]}, 7.0,
        title="Adds the numbers", why="...", hint="...",
    )
    total.example("adds_nothing", {"numbers": []}, 0.0, title="...", why="...", hint="...")
    total.promise("untouched", why="Later cells use the same numbers.")

Checks written by hand, with `utils.checks.core.visible_check`, say more about a wrong answer. An
exercise can have both kinds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from utils.checks import common_checks
from utils.checks.assertions import as_array, as_shape, assert_close, brief_text, precondition
from utils.checks.common_checks import Case
from utils.checks.core import visible_check
from utils.checks.failures import CheckFailed, WrongForm

TOLERANCE = 1e-6
# For each promise: the function that declares it, the name of the check, and default texts.
PROMISES = {
    "names": (
        common_checks.promise_names,
        "keeps_the_names",
        {"why": "Other code may pass the arguments by name."},
    ),
    "untouched": (
        common_checks.promise_untouched,
        "leaves_its_input",
        {"why": "Later cells use the same input.", "hint": "Work on a copy."},
    ),
    "three_columns": (
        common_checks.promise_three_columns,
        "takes_three_columns",
        {"hint": "Select the columns x, y and z by index, and use no others."},
    ),
}


class Exercise:
    """The visible checks of one exercise.

    Creating an exercise declares its first check, the plain case. All other checks wait until the
    plain case passes.

    Parameters
    ----------
    lesson : str
        The `__name__` of the module that declares the exercise.
    name : str
        Name of the student's function.
    arguments : mapping of str to object
        The arguments of a plain call by name, in the order of the function's first line.
    expected : object
        The right answer of that call.
    **words : object
        Title, why, hint and weight of the check; see `utils.checks.core.visible_check`.
    """

    def __init__(
        self,
        lesson: str,
        name: str,
        arguments: Mapping[str, object],
        expected: object,
        **words: object,
    ) -> None:
        plain = Case(lesson, name, arguments, expected, compare=_assert_case_answer)

        def require_plain_case(function: Callable) -> None:
            with precondition("a plain call returns the right answer"):
                plain.assert_right(function)

        self._case = replace(plain, precondition=require_plain_case)
        self._declare("plain_case", plain.assert_right, words)

    def example(
        self, name: str, arguments: Mapping[str, object], expected: object, **words: object
    ) -> None:
        """Declare a check that makes another call.

        Parameters
        ----------
        name : str
            Name of the check, unique within the exercise.
        arguments : mapping of str to object
            The arguments that differ from those of the plain call.
        expected : object
            The right answer.
        **words : object
            Title, why, hint and weight.
        """
        case = replace(
            self._case, arguments={**self._case.arguments, **arguments}, expected=expected
        )

        def run(function: Callable) -> None:
            case.precondition(function)
            case.assert_right(function)

        self._declare(name, run, words)

    def promise(self, kind: str, **words: object) -> None:
        """Declare a check that many exercises share.

        Parameters
        ----------
        kind : str
            One of `PROMISES`.
        **words : object
            Why, hint, title and weight; most have a default.

        Raises
        ------
        ValueError
            If there is no such promise.
        """
        if kind not in PROMISES:
            raise ValueError(f"There is no promise {kind!r}. Use one of {', '.join(PROMISES)}.")
        declare, name, usual = PROMISES[kind]
        declare(self._case, name, **(usual | words))

    def _declare(self, name: str, run: Callable, words: Mapping[str, object]) -> None:
        def check(function: Callable) -> None:
            run(function)

        check.__name__, check.__module__ = name, self._case.lesson
        visible_check(self._case.exercise, **words)(check)


def assert_answer(answer: object, expected: object, input_text: str | None = None) -> None:
    """Assert that an answer is right: numbers within a tolerance, everything else exactly.

    Parameters
    ----------
    answer : object
    expected : object
        A number, a text, a truth value, or numbers in a list or array.
    input_text : str, optional
        The arguments of the call, for the message.
    """
    try:
        if _is_numeric(expected) and np.ndim(expected):
            assert_close(answer, expected, "numbers", TOLERANCE)
        elif _is_numeric(expected):
            number = as_shape(as_array(answer, description="a number"), (), "one number")
            if not np.isclose(number, expected, rtol=0, atol=TOLERANCE, equal_nan=True):
                raise CheckFailed("The number is wrong.", **_yours_and_expected(answer, expected))
        elif type(answer) is not type(expected):
            raise WrongForm(
                "The answer has the wrong type.", **_yours_and_expected(answer, expected)
            )
        elif answer != expected:
            raise CheckFailed("The answer is wrong.", **_yours_and_expected(answer, expected))
    except CheckFailed as failure:
        failure.input_text = failure.input_text or input_text
        raise


def _yours_and_expected(answer: object, expected: object) -> dict[str, str]:
    return {"yours": brief_text(answer), "expected": brief_text(expected)}


def _is_numeric(value: object) -> bool:
    if isinstance(value, (bool, str)):
        return False
    try:
        return np.asarray(value).dtype.kind in "iuf"
    except ValueError:  # rows of different lengths
        return False


def _assert_case_answer(answer: object, *arguments_and_expected: object) -> None:
    *arguments, expected = arguments_and_expected
    assert_answer(answer, expected, ", ".join(map(brief_text, arguments)))
