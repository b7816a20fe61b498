"""Checks, visible or hidden, and their outcomes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """One property of a right answer, checked in the notebook or by the judge alone.

    Attributes
    ----------
    name : str
        Short name, unique within the exercise, which identifies the check; titles may change.
    exercise : str
        Name of the function under test.
    title : str
        The property, as a statement.
    hint : str
        The first hint after a failure.
    weight : float
        Share of the exercise's points, relative to the other checks; 0 for a note, which costs no
        points.
    why : str
        The consequence for the car, or for later cells, if the function lacks the property.
    run : callable or None
        Takes the function; raises `CheckFailed` if the function lacks the property. None for a
        hidden check, which the judge runs as a pytest test.
    slow : str
        Question to show after a timeout; if empty, a general question is shown.
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
        """Name of the module or package that declares the check, such as "lesson_05"."""
        return self.run.__module__.removeprefix(f"{__package__}.").partition(".")[0]

    @property
    def is_shown(self) -> bool:
        """Whether students see the check in the notebook."""
        return self.run is not None

    @property
    def is_note(self) -> bool:
        """Whether the check costs no points."""
        return self.weight == 0


@dataclass(frozen=True)
class Outcome:
    """The result of one check.

    Attributes
    ----------
    check : Check
    failure : Exception or None
        None if the check passed. In the judge, any exception that the check raised; in messages
        to students, a `CheckFailed`.
    """

    check: Check
    failure: Exception | None
