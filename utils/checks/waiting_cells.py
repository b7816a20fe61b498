"""Make cells of a notebook wait until functions have passed their checks."""

from __future__ import annotations

from collections.abc import Callable

from utils.lent.stubs import is_written, own

# Functions that have passed, by name. Running a function's cell again creates a new function, which
# is not checked yet.
_PASSED: dict[str, Callable] = {}


def record_result(exercise: str, function: Callable, passed: bool) -> None:
    """Record whether a function has passed its checks."""
    if passed:
        _PASSED[exercise] = function
    else:
        _PASSED.pop(exercise, None)


def ready(*functions: Callable) -> bool:
    """Return whether functions have passed their checks without a note; print those that have not.

    Use it in cells where a wrong function is worse than an error. For example, an endless loop in
    compiled code cannot be stopped.
    """
    waiting = [
        function for function in map(own, functions) if not has_passed(function.__name__, function)
    ]
    for function in waiting:
        print_waiting(function.__name__, function)
    return not waiting


def has_passed(exercise: str, function: Callable) -> bool:
    """Return whether a function, or a class that contains the exercise, has passed its checks."""
    return _PASSED.get(exercise) is own(function)


def print_waiting(exercise: str, function: Callable) -> None:
    """Print which function a cell waits for, and what has to happen first."""
    goal = "passes its checks without a note" if is_written(function) else "is written"
    print(f"This cell waits until {exercise} {goal}.")
