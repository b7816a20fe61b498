"""Describe how a run ended."""

from collections.abc import Callable

from utils.checks.assertions import brief_text
from utils.checks.tips import locate, unwritten_function
from utils.remote_objects import ENDLESS_LOOP_HINT
from utils.replays.tracer import Ending


def describe_ending(ending: Ending, function: Callable) -> str:
    """Describe the returned value, or the reason why there is none.

    Parameters
    ----------
    ending : utils.replays.tracer.Ending
    function : callable
        The student's function.
    """
    if ending.stopped:
        return f"Your function was stopped because it did not end. {ENDLESS_LOOP_HINT.capitalize()}"
    if stub := unwritten_function(ending.error, function):
        return f"{stub} is not written yet, so the player cannot continue."
    if ending.error is not None:
        kind, (_, place, line) = type(ending.error).__name__, locate(ending.error, function)
        where = f", in {place}" + (f": `{line}`" if line else "") if place else ""
        return f"Here your function raised {kind}: {ending.error}{where}"
    return f"Your function returned {brief_text(ending.answer)}."
