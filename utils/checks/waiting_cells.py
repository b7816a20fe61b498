"""Cells that wait until functions have passed their checks."""

from __future__ import annotations

from collections.abc import Callable

from utils.lent.stubs import is_written, own

# Which function of a name has passed: who runs its cell again has another one.
_PASSED: dict[str, Callable] = {}


def remember(exercise: str, function: Callable, passed: bool) -> None:
    """Remember what came of checking a function."""
    if passed:
        _PASSED[exercise] = function
    else:
        _PASSED.pop(exercise, None)


def ready(*functions: Callable) -> bool:
    """Whether functions have passed their checks, and without a note; says what a cell waits for.

    For cells in which a wrong one would do worse than fail: compiled, a loop without an end can
    not be stopped.
    """
    waiting = [one for one in map(own, functions) if _PASSED.get(one.__name__) is not one]
    for one in waiting:
        wrong = "has not passed its check, or not without a note"
        why = wrong if is_written(one) else "is not written yet"
        print(f"{one.__name__} {why}: this cell waits for it.")
    return not waiting
