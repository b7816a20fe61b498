"""A traceback shows the lines that somebody wrote in a notebook, and none of the course's.

Nor does it leave empty axes behind, which would be all that a picture shows that came to no end.
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Iterator
from pathlib import Path
from types import FrameType, TracebackType

from utils.display import shell

_OURS = str(Path(__file__).parent)  # as Python calls it, which may be by a link


def show_no_frames_of_ours() -> None:
    """From now on, leave out of each traceback what is the course's, and what that calls."""
    if shell() is None or hasattr(shell().showtraceback, "leaves_out"):
        return
    show = shell().showtraceback

    @functools.wraps(show)
    def show_theirs(exc_tuple: tuple | None = None, *arguments: object, **options: object) -> None:
        kind, error, trace = exc_tuple or sys.exc_info()
        for one in _chain(error):
            one.__traceback__ = without_ours(one.__traceback__)
        if error is not None:
            trace = without_ours(trace)
        show((kind, error, trace), *arguments, **options)
        _close_empty_figures()

    show_theirs.leaves_out = True
    shell().showtraceback = show_theirs


def without_ours(trace: TracebackType | None) -> TracebackType | None:
    """A traceback less the course's frames, and what libraries do on their behalf.

    Returns
    -------
    types.TracebackType or None
        A new one; None where nothing is left.
    """
    kept, ours = [], False
    while trace:
        frame = trace.tb_frame
        if frame.f_code.co_filename.startswith(_OURS):
            ours = True
        elif _is_of_a_notebook(frame):
            ours = False
        if not ours:
            kept.append(trace)
        trace = trace.tb_next
    rest = None
    for one in reversed(kept):
        rest = TracebackType(rest, one.tb_frame, one.tb_lasti, one.tb_lineno)
    return rest


def _close_empty_figures() -> None:
    pyplot = sys.modules.get("matplotlib.pyplot")
    for number in pyplot.get_fignums() if pyplot else ():
        figure = pyplot.figure(number)
        if not figure.texts and not any(axes.has_data() for axes in figure.axes):
            pyplot.close(figure)


def _is_of_a_notebook(frame: FrameType) -> bool:
    """What is run from text has no file: a cell, or a function fetched from another notebook."""
    return frame.f_globals.get("__name__") == "__main__" or "__file__" not in frame.f_globals


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """An exception, and those while which, or because of which, it was raised."""
    seen = set()
    while error is not None and id(error) not in seen:
        seen.add(id(error))
        yield error
        error = error.__cause__ or error.__context__
