"""Visible checks of `correct_boxes`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from utils.checks.assertions import (
    CheckFailed,
    WrongForm,
    as_array,
    assert_arguments_unchanged,
    brief_text,
    frozen,
    observe,
    precondition,
)
from utils.checks.core import visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.failures import fixed
from utils.checks.lesson_12.match_boxes import cubes
from utils.checks.lesson_12.steps import as_boxes, as_pair, centres_of, same_pair

_EXPECTED = frozen(cubes([[10, 0], [20, -1]]))
_FOUND = frozen(np.vstack([cubes([[10.4, 0.2]]), cubes([[19, -1, 0.4]], 2.0, turn=2)]))
_VELOCITIES = frozen(np.array([[-5.0, 0, 0], [-12.0, 1.0, 0.5]]))
_RESULT_NAMES = "boxes", "velocities"


def _right_correction(
    expected: np.ndarray, velocities: np.ndarray, found: np.ndarray, gain: float, seconds: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return boxes and velocities corrected by an alpha-beta filter.

    A corrected box is z - (1 - gain) r. Here z is the detected box, and r is its offset from the
    expected box.
    """
    offset = _mean_corners(found) - _mean_corners(expected)
    beta = 2 * (1 - np.sqrt(1 - gain)) ** 2
    return found - ((1 - gain) * offset)[:, None], velocities + beta * offset / seconds


def _mean_corners(boxes: np.ndarray) -> np.ndarray:
    return boxes.sum(axis=1) / 8


def _call_correct_boxes(correct_boxes: Callable, gain: float, seconds: float) -> tuple:
    arguments = (_EXPECTED.copy(), _VELOCITIES.copy(), _FOUND.copy(), gain, seconds)
    boxes, velocities = as_pair(correct_boxes(*arguments), _RESULT_NAMES)
    if np.shape(boxes) == _VELOCITIES.shape and np.shape(velocities) == _FOUND.shape:
        raise WrongForm(
            "The two results are in the wrong order: boxes come first, then velocities.",
            yours=f"shapes {np.shape(boxes)} and {np.shape(velocities)}",
            expected=f"shapes {_FOUND.shape} and {_VELOCITIES.shape}",
        )
    description = "velocities with three numbers each"
    velocities = as_array(velocities, columns=3, description=description, row_noun="velocity")
    if len(velocities) != len(_FOUND):
        raise WrongForm(
            f"There must be one velocity for each of the {len(_FOUND)} boxes.",
            yours=f"shape {velocities.shape}",
            expected=f"shape {_VELOCITIES.shape}",
        )
    return as_boxes(boxes, len(_FOUND)), velocities


def _given_text(row: int, gain: float, seconds: float) -> str:
    return (
        f"expected at {brief_text(centres_of(_EXPECTED)[row])}, "
        f"found at {brief_text(centres_of(_FOUND)[row])}, "
        f"velocity {brief_text(_VELOCITIES[row])} m/s, gain {gain:g}, {seconds:g} s"
    )


def _assert_placed(correct_boxes: Callable, gain: float, seconds: float) -> None:
    yours, _ = _call_correct_boxes(correct_boxes, gain, seconds)
    right, _ = _right_correction(_EXPECTED, _VELOCITIES, _FOUND, gain, seconds)
    is_wrong = ~np.isclose(centres_of(yours), centres_of(right), rtol=0, atol=1e-3).all(axis=1)
    if is_wrong.any():
        row = np.flatnonzero(is_wrong)[0]
        raise CheckFailed(
            f"The centre of box {row} is not at the expected centre plus gain times the offset to "
            "the found centre.",
            input_text=_given_text(row, gain, seconds),
            yours=f"centre at {brief_text(centres_of(yours)[row])}",
            expected=f"centre at {brief_text(centres_of(right)[row])}",
        )


@visible_check(
    "correct_boxes",
    title="Places each box between its expected and its found position",
    why="A detected box wobbles. With a gain below 1, the track wobbles less.",
    hint="Compute difference = found.mean(axis=1) - expected.mean(axis=1). The new centre is the "
    "centre of expected plus gain times the difference.",
)
def places_boxes_between(correct_boxes: Callable) -> None:
    for gain, seconds in ((0.5, 0.1), (0.75, 0.2)):
        _assert_placed(correct_boxes, gain, seconds)


@visible_check(
    "correct_boxes",
    title="Returns the found box, moved as a whole",
    why="The size and heading of the found box were measured just now. Those of "
    "the expected box are out of date.",
    hint="Move all corners of found back by the same fraction of the difference: "
    "found - (1 - gain) * difference[:, None].",
)
def keeps_the_shape(correct_boxes: Callable) -> None:
    with precondition("each box is between its expected and its found position"):
        places_boxes_between(correct_boxes)
    yours, _ = _call_correct_boxes(correct_boxes, 0.5, 0.1)
    right, _ = _right_correction(_EXPECTED, _VELOCITIES, _FOUND, 0.5, 0.1)
    wrong = np.flatnonzero(~np.isclose(yours, right, rtol=0, atol=1e-3).all(axis=(1, 2)))
    if len(wrong):
        row = wrong[0]
        raise CheckFailed(
            f"Box {row} does not have the size and corners of the found box.",
            input_text="a found box that is twice as large as the expected box and starts with "
            "another corner",
            yours=f"corners 0 and 1 at {brief_text(yours[row, 0])} and {brief_text(yours[row, 1])}",
            expected=f"corners 0 and 1 at {brief_text(right[row, 0])} and "
            f"{brief_text(right[row, 1])}",
        )


@visible_check(
    "correct_boxes",
    title="Corrects the velocity with its own gain, beta",
    why="Without this correction, a track never learns that a car is coming towards the ego car. "
    "If beta is too large, every wobble of a box looks like a velocity.",
    hint="Compute beta = 2 * (1 - np.sqrt(1 - gain)) ** 2, and return velocities + "
    "beta * difference / seconds as the new velocities.",
)
def corrects_the_velocity(correct_boxes: Callable) -> None:
    for gain, seconds in ((0.5, 0.1), (0.75, 0.2)):
        _, yours = _call_correct_boxes(correct_boxes, gain, seconds)
        _, right = _right_correction(_EXPECTED, _VELOCITIES, _FOUND, gain, seconds)
        wrong = np.flatnonzero(~np.isclose(yours, right, rtol=0, atol=2e-3).all(axis=1))
        if len(wrong):
            row = wrong[0]
            raise CheckFailed(
                f"The velocity of track {row} is wrong.",
                input_text=_given_text(row, gain, seconds),
                yours=f"{brief_text(yours[row])} m/s",
                expected=f"{brief_text(right[row])} m/s",
            )


@visible_check(
    "correct_boxes",
    title="Uses the expected position at gain 0 and the found position at gain 1",
    why="The gain is the weight of the found box. A gain of 0 ignores the found box, and a gain "
    "of 1 ignores the expected box.",
    hint="Write found - (1 - gain) * difference[:, None]. With a gain of 1, the result is then "
    "the found box.",
)
def uses_extreme_gains(correct_boxes: Callable) -> None:
    for gain in (0.0, 1.0):
        _assert_placed(correct_boxes, gain, 0.1)
    _, yours = _call_correct_boxes(correct_boxes, 0.0, 0.1)
    if not np.allclose(yours, _VELOCITIES, atol=1e-3):
        raise CheckFailed(
            fixed("With a gain of 0, a velocity must not change."),
            input_text=_given_text(0, 0.0, 0.1),
            yours=brief_text(yours[0]),
            expected=brief_text(_VELOCITIES[0]),
        )


@visible_check(
    "correct_boxes",
    title="Does not change its input",
    why="A later cell draws the boxes that were found.",
    hint="Write found - ... and velocities + ..., which create new arrays. -= and += change the "
    "input.",
)
def keeps_its_input_unchanged(correct_boxes: Callable) -> None:
    arguments = _EXPECTED, _VELOCITIES, _FOUND, 0.5, 0.1
    assert_arguments_unchanged(observe(correct_boxes, *arguments), *arguments)


def _prediction_from_velocity_rule(
    velocity_rule: Callable = lambda velocities, offset, gain, beta, seconds: (
        velocities + beta * offset / seconds
    ),
    share: Callable = lambda gain: gain,
) -> Callable:
    """Return a prediction with another rule for the velocity or another gain for the position."""

    def predict(right: tuple, *case: object) -> tuple:
        expected, velocities, found, gain, seconds = case
        offset = _mean_corners(found) - _mean_corners(expected)
        beta = 2 * (1 - np.sqrt(1 - gain)) ** 2
        moved = found - ((1 - share(gain)) * offset)[:, None]
        return moved, velocity_rule(velocities, offset, gain, beta, seconds)

    return predict


declare_mistakes(
    "correct_boxes",
    Mistake(
        "The code does not divide the change of the velocity by the time, so it adds metres to "
        "metres per second.",
        _prediction_from_velocity_rule(
            lambda velocities, offset, gain, beta, seconds: velocities + beta * offset
        ),
        "Return velocities + beta * difference / seconds.",
    ),
    Mistake(
        "The code also corrects the velocity with gain. It should use beta.",
        _prediction_from_velocity_rule(
            lambda velocities, offset, gain, beta, seconds: velocities + gain * offset / seconds
        ),
        "Compute beta = 2 * (1 - np.sqrt(1 - gain)) ** 2, the gain of the velocity.",
    ),
    Mistake(
        "The code corrects the velocity with expected minus found. It should use found minus "
        "expected.",
        _prediction_from_velocity_rule(
            lambda velocities, offset, gain, beta, seconds: velocities - beta * offset / seconds
        ),
        "Use found minus expected, because an object that is ahead of its expected place is "
        "faster than expected.",
    ),
    Mistake(
        "The function returns only the correction, without the old velocity.",
        _prediction_from_velocity_rule(
            lambda velocities, offset, gain, beta, seconds: beta * offset / seconds
        ),
        "Add the correction to velocities.",
    ),
    Mistake(
        "The function returns the velocities unchanged. It should correct them with beta.",
        _prediction_from_velocity_rule(lambda velocities, offset, gain, beta, seconds: velocities),
        "Return velocities + beta * difference / seconds.",
    ),
    Mistake(
        "The code uses the gain as the weight of the expected box. It should be the weight of the "
        "found box.",
        _prediction_from_velocity_rule(share=lambda gain: 1 - gain),
        "Write found - (1 - gain) * difference[:, None]. With a gain of 1, the result is then "
        "the found box.",
    ),
    Mistake(
        "The function returns the found boxes unchanged, whatever the gain is.",
        _prediction_from_velocity_rule(share=lambda gain: 1.0),
        "Return found - (1 - gain) * difference[:, None].",
    ),
    Mistake(
        "The code mixes expected and found boxes corner by corner. If a box grows or starts with "
        "another corner, the result does not have the size and sides of the found box.",
        lambda right, expected, velocities, found, gain, seconds: (
            expected + gain * (found - expected),
            right[1],
        ),
        "Move the found box as a whole with difference[:, None], which moves all its corners "
        "alike.",
    ),
    cases=((_EXPECTED, _VELOCITIES, _FOUND, 0.4, 0.1), (_EXPECTED, _VELOCITIES, _FOUND, 0.8, 0.25)),
    right=_right_correction,
    is_same=same_pair,
)
