"""The ways in which an answer can fail, each told in its own words.

What two failures have in common is their `cause`: rows with the same one are folded together.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Hashable

NUMBER = re.compile(r"(?<!\w)-?\d+(,\d{3})*(\.\d+)?(e[+-]?\d+)?(?!\w)")
# Stand around a number of the task, as long as nobody reads it.
_BEGIN, _END = "\x0e", "\x0f"


def fixed(text: str) -> str:
    """A piece of a message whose numbers are the same whatever is asked.

    The judge takes the numbers out of what it tells of a hidden check, as they may be a part of
    the question; these it leaves.

    Parameters
    ----------
    text : str
        As it stands in the code; nothing is put into it.
    """
    return NUMBER.sub(rf"{_BEGIN}\g<0>{_END}", text)


def with_numbers(message: str, told: Callable[[str], str]) -> str:
    """A message of a check, in which each number is told in another way, but for what is `fixed`.

    Parameters
    ----------
    message : str
    told : callable
        Takes a number, as text, and returns what is told of it.
    """
    parts = re.split(f"{_BEGIN}(.*?){_END}", message)
    others = [NUMBER.sub(lambda number: told(number[0]), part) for part in parts[::2]]
    return "".join(itertools.chain(*itertools.zip_longest(others, parts[1::2], fillvalue="")))


class CheckFailed(AssertionError):
    """A property does not hold.

    Attributes
    ----------
    message : str
        What is wrong, in a sentence.
    marked : str
        The same, with marks around what is `fixed` in it.
    given, yours, expected : str or None
        Short texts: the input of the smallest case, and the two answers to stand side by side.
    draw : callable or None
        Draws the difference with `utils.plots`; takes nothing.
    tip : str
        What an exception means in plain words.
    hint : str
        The first hint for this very failure; by default the one of the check, where the failure
        is about what the check demands.
    """

    def __init__(
        self,
        message: str,
        *,
        given: str | None = None,
        yours: str | None = None,
        expected: str | None = None,
        draw: Callable | None = None,
        tip: str = "",
        hint: str = "",
    ) -> None:
        self.marked = message
        super().__init__(self.message)
        self.given, self.yours, self.expected = given, yours, expected
        self.draw, self.tip, self.hint = draw, tip, hint

    @property
    def message(self) -> str:  # noqa: D102 (as above)
        return self.marked.replace(_BEGIN, "").replace(_END, "")

    @property
    def cause(self) -> Hashable:
        """Equal for failures that are one and the same; None where nobody can know."""
        return None

    @property
    def is_about_an_answer(self) -> bool:
        """Whether there was an answer to look at, which a mistake may explain."""
        return type(self) in (CheckFailed, WrongForm, FarTooMuch)

    @property
    def is_about_the_check(self) -> bool:
        """Whether the property itself was looked at, and not something that comes before."""
        return type(self) is CheckFailed


class WrongForm(CheckFailed):
    """The answer is not of the kind that was asked for; there is nothing more to look at."""

    @property
    def cause(self) -> Hashable:  # noqa: D102 (as above)
        return "form", re.sub(r"\d+", "#", self.message)


class FarTooMuch(WrongForm):
    """The answer is far larger than any right one: looking at it costs time, and tells nothing."""


class NotYet(CheckFailed):
    """The property cannot be looked at while something more basic is wrong."""

    def __init__(self, basic: str) -> None:
        self.basic = basic
        super().__init__(f"Cannot be judged yet. First: {basic}.")

    @property
    def cause(self) -> Hashable:  # noqa: D102
        return "not yet", self.message


class Raised(CheckFailed):
    """The function raised an exception."""

    def __init__(
        self, message: str, *, kind: str, place: str | None, line: str = "", tip: str = ""
    ) -> None:
        super().__init__(message, tip=tip)
        self.kind, self.place, self.line = kind, place, line

    @property
    def cause(self) -> Hashable:  # noqa: D102
        return "raised", self.kind, self.place or re.sub(r"\d+", "#", self.message)


class NotStarted(CheckFailed):
    """The stub is still there, of this exercise or of one that it calls."""

    def __init__(self, exercise: str, stub: str) -> None:
        self.stub, self.own = stub, stub == exercise
        if self.own:
            message = (
                f"{exercise} is not started: replace `raise NotImplementedError` with your code, "
                "run its cell, then this one."
            )
        else:
            message = f"{exercise} calls {stub}, which is not written yet. Write {stub} first."
        super().__init__(message)

    @property
    def cause(self) -> Hashable:  # noqa: D102
        return "not started", self.stub


class Stopped(CheckFailed):
    """The function did not come back, or took its process with it; for the same reason or not."""

    def __init__(self, message: str, reason: str = "", out_of_time: bool = False) -> None:
        self._reason, self.out_of_time = reason or message, out_of_time
        super().__init__(message)

    @property
    def cause(self) -> Hashable:  # noqa: D102
        return "stopped", self._reason


class Refused(CheckFailed):
    """The lesson does not allow what the function uses."""

    @property
    def cause(self) -> Hashable:  # noqa: D102
        return "refused", self.message
