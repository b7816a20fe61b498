"""Exceptions for the ways in which an answer can fail.

The notebook shows failures with the same `cause` in one row.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Hashable

NUMBER = re.compile(r"(?<!\w)-?\d+(,\d{3})*(\.\d+)?(e[+-]?\d+)?(?!\w)")
# Markers around a number that `fixed` protects; they are removed before the message is shown.
_START, _END = "\x0e", "\x0f"


def fixed(text: str) -> str:
    """Protect the numbers in a text that does not depend on the test input.

    The judge removes numbers from the messages of hidden checks, because they may reveal the
    input. It keeps protected numbers.

    Parameters
    ----------
    text : str
        A literal from the source code, without inserted values.
    """
    return NUMBER.sub(rf"{_START}\g<0>{_END}", text)


def with_numbers(message: str, replace: Callable[[str], str]) -> str:
    """Replace each number in the message of a check, except those protected by `fixed`.

    Parameters
    ----------
    message : str
        The message with its markers.
    replace : callable
        Takes a number as text; returns its replacement.
    """
    parts = re.split(f"{_START}(.*?){_END}", message)
    others = [NUMBER.sub(lambda number: replace(number[0]), part) for part in parts[::2]]
    return "".join(itertools.chain(*itertools.zip_longest(others, parts[1::2], fillvalue="")))


class CheckFailed(AssertionError):
    """The function does not have the property that a check tests.

    Attributes
    ----------
    message : str
        The failure in one sentence.
    marked : str
        The message with markers around the numbers that `fixed` protects.
    input_text, yours, expected : str or None
        Short texts that show the input, the student's answer and the right answer.
    draw : callable or None
        Takes no arguments; draws the difference with `utils.plots`.
    tip : str
        An explanation of an exception in plain words.
    hint : str
        The first hint for this failure. If empty, the check's own hint is used, provided that the
        failure is about the property of the check.
    """

    def __init__(
        self,
        message: str,
        *,
        input_text: str | None = None,
        yours: str | None = None,
        expected: str | None = None,
        draw: Callable | None = None,
        tip: str = "",
        hint: str = "",
    ) -> None:
        self.marked = message
        super().__init__(self.message)
        self.input_text, self.yours, self.expected = input_text, yours, expected
        self.draw, self.tip, self.hint = draw, tip, hint

    @property
    def message(self) -> str:  # noqa: D102 (as above)
        return self.marked.replace(_START, "").replace(_END, "")

    @property
    def cause(self) -> Hashable:
        """A value that is equal for failures with the same cause; None if the cause is unknown."""
        return None

    @property
    def is_about_an_answer(self) -> bool:
        """Whether the function returned an answer, which a known mistake may explain."""
        return type(self) in (CheckFailed, WrongForm, AnswerTooLarge)

    @property
    def is_about_the_check(self) -> bool:
        """Whether the property itself failed, not one of its preconditions."""
        return type(self) is CheckFailed


class WrongForm(CheckFailed):
    """The answer does not have the required form, so its content was not compared."""

    @property
    def cause(self) -> Hashable:  # noqa: D102 (as above)
        return "form", re.sub(r"\d+", "#", self.message)


class AnswerTooLarge(WrongForm):
    """The answer is far larger than any right one and was not compared, to save time."""


class NotYet(CheckFailed):
    """The property cannot be judged because a precondition is not met.

    Attributes
    ----------
    requirement : str
        The precondition, as a clause.
    reason : CheckFailed or None
        The failure of the precondition.
    """

    def __init__(self, requirement: str, reason: CheckFailed | None = None) -> None:
        self.requirement, self.reason = requirement, reason
        super().__init__(f"This check waits until {requirement}.")

    @property
    def cause(self) -> Hashable:  # noqa: D102
        return "not yet", self.message


class ExceptionRaised(CheckFailed):
    """The function raised an exception."""

    def __init__(
        self, message: str, *, kind: str, place: str | None, line: str = "", tip: str = ""
    ) -> None:
        super().__init__(message, tip=tip)
        self.kind, self.place, self.line = kind, place, line

    @property
    def cause(self) -> Hashable:  # noqa: D102
        return "raised", self.kind, self.place or re.sub(r"\d+", "#", self.message)


class FunctionSkipped(CheckFailed):
    """The function is missing, because the judge skipped its cell."""

    @property
    def cause(self) -> Hashable:  # noqa: D102
        return "skipped", self.message


class NotStarted(CheckFailed):
    """The exercise, or another one that it calls, is still a stub."""

    def __init__(self, exercise: str, stub: str) -> None:
        self.stub, self.own = stub, stub == exercise
        if self.own:
            message = (
                f"{exercise} is not started. Replace `raise NotImplementedError` with your code, "
                "run that cell, and then run this one."
            )
        else:
            message = f"{exercise} calls {stub}, which is not written yet. Write {stub} first."
        super().__init__(message)

    @property
    def cause(self) -> Hashable:  # noqa: D102
        return "not started", self.stub


class CallStopped(CheckFailed):
    """The function exceeded its time limit or ended its process; `cause` is the reason."""

    def __init__(self, message: str, reason: str = "", out_of_time: bool = False) -> None:
        self._reason, self.out_of_time = reason or message, out_of_time
        super().__init__(message)

    @property
    def cause(self) -> Hashable:  # noqa: D102
        return "stopped", self._reason


class UnusableModule(CheckFailed):
    """The function uses a module that the lesson forbids."""

    @property
    def cause(self) -> Hashable:  # noqa: D102
        return "refused", self.message
