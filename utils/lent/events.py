"""Listeners for the results of checks."""

from __future__ import annotations

from collections.abc import Callable

# Each listener is called with the arguments of `report_check`.
LISTENERS: list[Callable[[str, bool, bool], None]] = []


def report_check(exercise: str, passed: bool, hangs: bool = False) -> None:
    """Notify all listeners of the result of checking an exercise.

    Parameters
    ----------
    exercise : str
    passed, hangs : bool
        Whether every check passed, and whether the function exceeded its time limit.
    """
    for listener in LISTENERS:
        listener(exercise, passed, hangs)
