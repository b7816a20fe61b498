"""Observe a student's function while it runs: every line, and every function that it calls.

The function and its arguments are not changed. Python itself reports each line (`sys.settrace`),
so any Python code can be observed. Compiled code, such as Numba's, cannot.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import FrameType

from utils.checks.limits import TimeUp, limit_resources

# More than any correct answer needs for a few points, even while it is observed.
SECONDS = 3  # processor time, so that a busy machine gives the same result
PATIENCE = 5  # the limit of wall-clock time is this many times SECONDS


class RecordingComplete(BaseException):
    """Signal to end the function; not an `Exception`, because student code may catch those."""


@dataclass(frozen=True)
class Ending:
    """Result of a run.

    Attributes
    ----------
    answer : object
        Returned value.
    error : Exception or None
        Exception that the function raised.
    stopped : bool
        Whether the run was stopped from outside because it did not end.
    """

    answer: object = None
    error: Exception | None = None
    stopped: bool = False

    @property
    def returned_normally(self) -> bool:
        """Whether the function returned."""
        return self.error is None and not self.stopped


def record(
    function: Callable, arguments: tuple, see: Callable[[FrameType, str, object], None]
) -> Ending:
    """Call a function and report every event to an observer.

    Parameters
    ----------
    function : callable
        Function of a notebook.
    arguments : tuple
        Arguments, which are passed on without copying.
    see : callable
        Takes a frame of the notebook, an event and its value, like a trace function of `sys`.
        It raises `RecordingComplete` to end the run; any other exception ends only the recording.
    """
    home, due = getattr(function, "__globals__", None), time.process_time() + SECONDS

    def look(frame: FrameType, event: str, value: object) -> Callable | None:
        if frame.f_globals is not home:
            return None
        if time.process_time() > due:
            raise RecordingComplete
        try:
            see(frame, event, value)
        except Exception:  # an error in the observer must not affect the student's function
            sys.settrace(before)
            return None
        return look

    before = sys.gettrace()
    try:
        # `limit_resources` also ends code outside the notebook, and code that catches
        # `RecordingComplete`.
        with limit_resources(PATIENCE * SECONDS):
            before = sys.gettrace()
            try:
                sys.settrace(look)
                return Ending(function(*arguments))
            finally:
                sys.settrace(before)
    except (RecordingComplete, TimeUp):
        return Ending(stopped=True)
    except Exception as error:
        return Ending(error=error)


def values_in(frame: FrameType) -> Iterator[tuple[object, object]]:
    """Yield the variables of a frame, and the attributes of objects of the notebook's classes.

    Yields
    ------
    (hashable, object)
        Key that identifies the variable in every event, and its value.
    """
    home = frame.f_globals.get("__name__")
    for name, value in list(frame.f_locals.items()):
        yield (frame.f_code, name), value
        kind = type(value)
        if kind.__module__ == home and hasattr(value, "__dict__"):
            for attribute, inner in list(vars(value).items()):
                yield (kind, attribute), inner
    for name in frame.f_code.co_names:
        if name in frame.f_globals:
            yield (None, name), frame.f_globals[name]
