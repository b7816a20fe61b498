"""Visible checks of `predict_boxes`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from utils.checks.assertions import (
    CheckFailed,
    assert_arguments_unchanged,
    brief_text,
    frozen,
    observe,
)
from utils.checks.core import visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.lesson_12.match_boxes import cubes
from utils.checks.lesson_12.steps import NO_BOXES, as_boxes, centres_of

_PARKED = frozen(cubes([[10, 2], [20, -1], [-4, 3]]))
_PARKED_VELOCITIES = frozen(np.array([[-5.0, 0, 0], [-13.0, 0.5, 0], [2.0, -4.0, 1.0]]))
# As many boxes as a box has corners, so that wrong broadcasting raises no exception.
_EIGHT = frozen(cubes([[3.0 * number, number % 3] for number in range(8)]))
_EIGHT_VELOCITIES = frozen(np.array([[number - 3.0, 2.0 - number, 0.0] for number in range(8)]))


def _right_moved_boxes(boxes: np.ndarray, velocities: np.ndarray, seconds: float) -> np.ndarray:
    return np.stack(
        [box + seconds * velocity for box, velocity in zip(boxes, velocities, strict=True)]
    )


def _assert_moved(
    predict_boxes: Callable, boxes: np.ndarray, velocities: np.ndarray, seconds: float
) -> None:
    yours = as_boxes(predict_boxes(boxes.copy(), velocities.copy(), seconds), len(boxes))
    right = _right_moved_boxes(boxes, velocities, seconds)
    wrong = np.flatnonzero(~np.isclose(yours, right, rtol=0, atol=1e-3).all(axis=(1, 2)))
    if not len(wrong):
        return
    row = wrong[0]
    input_text = (
        f"a box at {brief_text(centres_of(boxes)[row])}, "
        f"velocity {brief_text(velocities[row])} m/s, {seconds:g} s"
    )
    if np.allclose(centres_of(yours)[row], centres_of(right)[row], atol=1e-3):
        raise CheckFailed(
            f"Box {row} has the right centre but wrong corners.",
            input_text=input_text,
            yours=f"corner 0 at {brief_text(yours[row, 0])}",
            expected=f"corner 0 at {brief_text(right[row, 0])}",
        )
    raise CheckFailed(
        f"Box {row} has not moved by its velocity times the time.",
        input_text=input_text,
        yours=f"centre at {brief_text(centres_of(yours)[row])}",
        expected=f"centre at {brief_text(centres_of(right)[row])}",
    )


@visible_check(
    "predict_boxes",
    title="Moves each box by its own velocity for a tenth of a second",
    why="The tracker looks for the next box of an object where the object should be by now.",
    hint="Add seconds * velocities[:, None] to boxes, which moves all corners of a box alike. "
    "velocities has the shape (N, 3), and boxes has the shape (N, 8, 3).",
)
def moves_the_boxes(predict_boxes: Callable) -> None:
    _assert_moved(predict_boxes, _PARKED, _PARKED_VELOCITIES, 0.1)


@visible_check(
    "predict_boxes",
    title="Moves boxes twice as far in twice the time",
    why="Some scanners turn only five times a second, and some frames are lost, so the time "
    "between two frames varies.",
    hint="Multiply the velocities by seconds.",
)
def uses_the_time(predict_boxes: Callable) -> None:
    for seconds in (0.2, 0.05, 0.0):
        _assert_moved(predict_boxes, _PARKED, _PARKED_VELOCITIES, seconds)


@visible_check(
    "predict_boxes",
    title="Moves each of eight boxes as a whole",
    why="With eight boxes, NumPy may silently move each corner by the velocity of another box, "
    "which tears the boxes apart.",
    hint="Use velocities[:, None], which applies the three numbers of a row to a whole box.",
)
def moves_eight_boxes(predict_boxes: Callable) -> None:
    _assert_moved(predict_boxes, _EIGHT, _EIGHT_VELOCITIES, 0.1)


@visible_check(
    "predict_boxes",
    title="Works without boxes",
    why="On an empty road there are no boxes, and that must not crash the tracker.",
    hint="Work with whole arrays, without a loop and without a special case.",
)
def predicts_no_boxes(predict_boxes: Callable) -> None:
    as_boxes(predict_boxes(NO_BOXES.copy(), np.empty((0, 3)), 0.1), 0)


@visible_check(
    "predict_boxes",
    title="Does not change boxes or velocities",
    why="A later cell predicts from the same boxes and velocities again.",
    hint="Write boxes + ..., which creates new boxes. boxes += ... changes the input.",
)
def keeps_boxes_and_velocities(predict_boxes: Callable) -> None:
    assert_arguments_unchanged(
        observe(predict_boxes, _PARKED, _PARKED_VELOCITIES, 0.1), _PARKED, _PARKED_VELOCITIES, 0.1
    )


declare_mistakes(
    "predict_boxes",
    Mistake(
        "The code ignores seconds and adds the whole velocity, as if one second had passed.",
        lambda right, boxes, velocities, seconds: _right_moved_boxes(boxes, velocities, 1.0),
        "Multiply the velocities by seconds.",
    ),
    Mistake(
        "The boxes always move for a tenth of a second. They should move for `seconds`.",
        lambda right, boxes, velocities, seconds: _right_moved_boxes(boxes, velocities, 0.1),
        "Multiply the velocities by the parameter seconds.",
    ),
    Mistake(
        "The boxes move backwards, because the code subtracts the distance.",
        lambda right, boxes, velocities, seconds: _right_moved_boxes(boxes, velocities, -seconds),
        "Add the distance, because a velocity points in the direction of motion.",
    ),
    Mistake(
        "The code divides the velocity by the time. It should multiply the velocity by the time.",
        lambda right, boxes, velocities, seconds: _right_moved_boxes(
            boxes, velocities, 1 / seconds
        ),
        "Multiply the velocities by seconds.",
    ),
    Mistake(
        "Row k of velocities moves corner k of every box instead of box k.",
        lambda right, boxes, velocities, seconds: boxes + seconds * velocities,
        "Use velocities[:, None], which moves all corners of a box alike.",
    ),
    Mistake(
        "All boxes move by the velocity of the first box.",
        lambda right, boxes, velocities, seconds: boxes + seconds * velocities[0],
        "Use one row for each box: velocities[:, None], not velocities[0].",
    ),
    Mistake(
        "The boxes stay where they are. They should move by velocity times time.",
        lambda right, boxes, velocities, seconds: boxes,
        is_cheap=True,
    ),
    cases=((_EIGHT, _EIGHT_VELOCITIES, 0.25), (_EIGHT[::-1], _EIGHT_VELOCITIES, 0.4)),
    right=_right_moved_boxes,
)
