"""Stored answers of the course, which replace functions that a student has not written yet.

``lesson_NN.json`` contains the answers that a lesson's functions returned in its solved notebook:
labels, boxes and numbers, but no code. With them, a student who is stuck can continue. A stub
returns the stored answers for the calls in the notebook, and shows that they are the course's.

`grader.course.recorded_answers` records the answers. They also replace a function that fails its
check, in cells that fail because of it; see `utils.lent.continuation`.
"""

from __future__ import annotations

import json
from pathlib import Path

from utils.display import shell
from utils.lent.events import LISTENERS, report_check
from utils.lent.recorder import Recorder, record_answers
from utils.lent.stand_ins import Lender
from utils.lent.stubs import is_written, own

__all__ = [
    "Lender",
    "Recorder",
    "report_check",
    "is_written",
    "lend_answers",
    "own",
    "record_answers",
]

_HERE = Path(__file__).resolve().parent
# Keys of the code cells of each lesson, written by `python -m grader build`.
CELLS = _HERE / "cells.json"
# Numbers of the lessons whose stored answers are in use in this kernel.
_LENDING: set[str] = set()


def lend_answers(number: str) -> None:
    """Let stored answers replace the stubs and wrong functions of a lesson from now on.

    Without stored answers, or outside a notebook, nothing happens.

    Parameters
    ----------
    number : str
        Number of the lesson, such as "06".
    """
    path = _HERE / f"lesson_{number}.json"
    if shell() is None or not path.exists() or number in _LENDING:
        return
    from utils.lent.continuation import Continuation

    lender = Lender(json.loads(path.read_text("utf-8")), shell().user_ns)
    cells = json.loads(CELLS.read_text("utf-8")).get(number, [])
    continuation = Continuation(lender, shell().user_ns, cells, shell().showtraceback)
    _LENDING.add(number)
    LISTENERS.append(continuation.record_check)
    shell().showtraceback = continuation.show_traceback
    shell().events.register("pre_run_cell", continuation.before_cell)
    shell().events.register("post_run_cell", continuation.after_cell)
    shell().events.register("post_run_cell", lender.wrap_stubs)
