"""Make cells of a notebook wait until functions have passed their checks."""

from __future__ import annotations

from collections.abc import Callable

from utils.lent.stubs import is_written, own

# Functions that have passed, by name, and whether they got a note. Running a function's cell again
# creates a new function, which is not checked yet.
_PASSED: dict[str, tuple[Callable, bool]] = {}


def record_result(exercise: str, function: Callable, passed: bool, has_notes: bool = False) -> None:
    """Record whether a function has passed its checks, and whether it got a note."""
    if passed:
        _PASSED[exercise] = function, has_notes
    else:
        _PASSED.pop(exercise, None)


def ready(*functions: Callable) -> bool:
    """Return whether functions have passed their checks without a note; print those that have not.

    Use it in cells where a wrong function is worse than an error. For example, an endless loop in
    compiled code cannot be stopped, and a note may say that a function is not compiled.
    """
    waiting = [
        function
        for function in map(own, functions)
        if not has_passed(function.__name__, function, notes_allowed=False)
    ]
    for function in waiting:
        print_waiting(function.__name__, function, "passes its checks without a note")
    return not waiting


def has_passed(exercise: str, function: Callable, notes_allowed: bool = True) -> bool:
    """Return whether a function, or a class that contains the exercise, has passed its checks."""
    passed, has_notes = _PASSED.get(exercise, (None, False))
    return passed is own(function) and (notes_allowed or not has_notes)


def print_waiting(exercise: str, function: Callable, goal: str = "passes its checks") -> None:
    """Print which function a cell waits for, and what has to happen first."""
    print(f"This cell waits until {exercise} {goal if is_written(function) else 'is written'}.")
