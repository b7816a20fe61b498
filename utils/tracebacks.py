"""Tracebacks that show only the lines of a notebook, without the course's own code.

After an error, empty figures are closed, because an interrupted plot would show only empty axes.
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Iterator
from pathlib import Path
from types import FrameType, TracebackType

from utils.display import shell

_COURSE_FOLDER = str(Path(__file__).parent)  # not resolved, because frames may name a symbolic link


def hide_course_frames() -> None:
    """Remove the course's frames, and the frames they call, from all later tracebacks."""
    if shell() is None or hasattr(shell().showtraceback, "leaves_out"):
        return
    show = shell().showtraceback

    @functools.wraps(show)
    def show_student_frames(
        exc_tuple: tuple | None = None, *arguments: object, **options: object
    ) -> None:
        kind, error, trace = exc_tuple or sys.exc_info()
        for link in _chain(error):
            link.__traceback__ = without_course_frames(link.__traceback__)
        if error is not None:
            trace = without_course_frames(trace)
        show((kind, error, trace), *arguments, **options)
        _close_empty_figures()

    show_student_frames.leaves_out = True
    shell().showtraceback = show_student_frames


def without_course_frames(trace: TracebackType | None) -> TracebackType | None:
    """Return a traceback without the course's frames and the library frames that they call.

    Returns
    -------
    types.TracebackType or None
        A new traceback; None if no frame is left.
    """
    kept, ours = [], False
    while trace:
        frame = trace.tb_frame
        if frame.f_code.co_filename.startswith(_COURSE_FOLDER):
            ours = True
        elif _is_notebook_frame(frame):
            ours = False
        if not ours:
            kept.append(trace)
        trace = trace.tb_next
    rest = None
    for entry in reversed(kept):
        rest = TracebackType(rest, entry.tb_frame, entry.tb_lasti, entry.tb_lineno)
    return rest


def _close_empty_figures() -> None:
    pyplot = sys.modules.get("matplotlib.pyplot")
    for number in pyplot.get_fignums() if pyplot else ():
        figure = pyplot.figure(number)
        if not figure.texts and not any(axes.has_data() for axes in figure.axes):
            pyplot.close(figure)


def _is_notebook_frame(frame: FrameType) -> bool:
    """Return whether a frame runs a cell, or a function loaded from another notebook.

    Code that is run from a string has no `__file__`.
    """
    return frame.f_globals.get("__name__") == "__main__" or "__file__" not in frame.f_globals


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an exception, then its cause or context, and so on."""
    seen = set()
    while error is not None and id(error) not in seen:
        seen.add(id(error))
        yield error
        error = error.__cause__ or error.__context__
