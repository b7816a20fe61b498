"""What a check is, shown or hidden, and how one ended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """One property that a right answer has, shown in the notebook or asked by the judge alone.

    Attributes
    ----------
    name : str
        Short name, unique within the exercise: by it, and not by its title, it is known.
    exercise : str
        Name of the function under test.
    title : str
        The property, as a statement.
    hint : str
        The first hint for someone who fails it.
    weight : float
        Its share of the exercise's points, relative to the other checks; 0 for a note, which
        says what costs no points and why later cells care.
    why : str
        What goes wrong on the road without it.
    run : callable or None
        Takes the function; raises `CheckFailed` where the property does not hold. None for a
        hidden check, which the judge runs as a test of pytest.
    slow : str
        What to ask of a function that does not come back in this check, where that is rarely a
        loop without an end.
    """

    name: str
    exercise: str
    title: str
    hint: str
    weight: float = 1.0
    why: str = ""
    run: Callable | None = None
    slow: str = ""

    @property
    def lesson(self) -> str:
        """The module or folder that declares it, such as "lesson_05"."""
        return self.run.__module__.removeprefix(f"{__package__}.").partition(".")[0]

    @property
    def is_shown(self) -> bool:
        """True where students see it in the notebook."""
        return self.run is not None

    @property
    def is_note(self) -> bool:
        """True where it costs no points."""
        return self.weight == 0


@dataclass(frozen=True)
class Outcome:
    """What came of asking a check.

    Attributes
    ----------
    check : Check
    failure : Exception or None
        Why it does not hold, None where it does. Whatever a check raised in the judge; a
        `CheckFailed` where it is told.
    """

    check: Check
    failure: Exception | None
