"""The course's own answers, lent to who has not written a function yet.

``lesson_NN.json`` holds what the functions of a lesson answered in its solved notebook: labels,
boxes, numbers, and no code. Who is stuck can go on: a function that is still a stub answers the
calls that the notebook makes, and says whose answer it is.
`grader.course.recorded_answers` records the answers. A function that does not pass its check is
replaced by them in cells that fail because of it; see `utils.lent.continuation`.
"""

from __future__ import annotations

import json
from pathlib import Path

from utils.display import shell
from utils.lent.events import HEARERS, hear
from utils.lent.recorder import Recorder, record_answers
from utils.lent.stand_ins import Lender
from utils.lent.stubs import is_written, own

__all__ = ["Lender", "Recorder", "hear", "is_written", "lend_answers", "own", "record_answers"]

_HERE = Path(__file__).resolve().parent
# Written by `python -m grader build`: by which the cells of each lesson are known.
CELLS = _HERE / "cells.json"
# Numbers of the lessons whose answers are lent in this kernel.
_LENDING: set[str] = set()


def lend_answers(number: str) -> None:
    """From now on, after each cell, lend answers to the stubs of a lesson, and go on with them.

    Parameters
    ----------
    number : str
        Of the lesson, such as "06". Without stored answers, or outside a notebook, nothing
        happens.
    """
    path = _HERE / f"lesson_{number}.json"
    if shell() is None or not path.exists() or number in _LENDING:
        return
    from utils.lent.continuation import GoingOn

    lender = Lender(json.loads(path.read_text("utf-8")), shell().user_ns)
    cells = json.loads(CELLS.read_text("utf-8")).get(number, [])
    going_on = GoingOn(lender, shell().user_ns, cells, shell().showtraceback)
    _LENDING.add(number)
    HEARERS.append(going_on.hear)
    shell().showtraceback = going_on.show_traceback
    shell().events.register("pre_run_cell", going_on.before_cell)
    shell().events.register("post_run_cell", going_on.after_cell)
    shell().events.register("post_run_cell", lender.look_round)
