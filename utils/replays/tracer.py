"""Look on while a student's function runs: at every line, and at all that it calls.

The function is not changed, and gets what it would get anyway. Python itself tells of each line
(`sys.settrace`), so it does not matter how somebody wrote it, as long as it is Python; code that
was compiled, as by Numba, is not seen.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import FrameType

from utils.checks.limits import TimeUp, limited

# More than any right answer needs for a few points, though it is watched.
SECONDS = 3  # of processor time, so that a busy machine shows the same
PATIENCE = 5  # by the clock on the wall it may take so many times as long


class Enough(BaseException):
    """The function is not to go on; not an Exception, which student code may catch."""


@dataclass(frozen=True)
class Ending:
    """How a run ended.

    Attributes
    ----------
    answer : object
        What came back.
    error : Exception or None
        What was raised.
    stopped : bool
        Whether it was ended from outside, for want of an end.
    """

    answer: object = None
    error: Exception | None = None
    stopped: bool = False

    @property
    def came_back(self) -> bool:
        """Whether there is an answer."""
        return self.error is None and not self.stopped


def record(
    function: Callable, arguments: tuple, see: Callable[[FrameType, str, object], None]
) -> Ending:
    """Call a function, and show what it does.

    Parameters
    ----------
    function : callable
    arguments : tuple
        It gets these very objects.
    see : callable
        Takes a frame of the notebook, an event and its value, as what `sys.settrace` takes does.
        It raises `Enough` to end the run; another exception ends the recording alone.
    """
    home, due = getattr(function, "__globals__", None), time.process_time() + SECONDS

    def look(frame: FrameType, event: str, value: object) -> Callable | None:
        if frame.f_globals is not home:
            return None
        if time.process_time() > due:
            raise Enough
        try:
            see(frame, event, value)
        except Exception:  # whatever is wrong here is not the student's fault
            sys.settrace(before)
            return None
        return look

    before = sys.gettrace()
    try:
        # The clock of `limited` comes later: for what is no line of the notebook, or catches all.
        with limited(PATIENCE * SECONDS):
            before = sys.gettrace()
            try:
                sys.settrace(look)
                return Ending(function(*arguments))
            finally:
                sys.settrace(before)
    except (Enough, TimeUp):
        return Ending(stopped=True)
    except Exception as error:
        return Ending(error=error)


def values_in(frame: FrameType) -> Iterator[tuple[object, object]]:
    """What a frame can reach: its variables, and those of objects of the notebook's own classes.

    Yields
    ------
    (hashable, object)
        A name that is the same whenever the same variable is met, and its value.
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
