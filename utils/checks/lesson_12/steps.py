"""Visible checks of four steps of a tracker: predict, correct, coast and confirm.

The steps give no points, so they can be skipped.
"""

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
from utils.checks.diagnosis import Mistake, declare_mistakes, same_array
from utils.checks.failures import fixed
from utils.checks.lesson_12.match_boxes import cubes

_NO_BOXES = frozen(np.empty((0, 8, 3)))


def _centres(boxes: np.ndarray) -> np.ndarray:
    """Return the centres of boxes, rounded to a tenth of a millimetre."""
    return np.round(boxes.mean(axis=1), 4) + 0.0


def _as_boxes(answer: object, n: int, noun: str = "boxes") -> np.ndarray:
    boxes = as_array(answer, description=f"an array of {noun}")
    if boxes.size == 0 and n == 0:
        return _NO_BOXES
    if boxes.shape != (n, 8, 3):
        note = " These are centres: move all eight corners." if boxes.shape == (n, 3) else ""
        raise WrongForm(
            f"There must be eight corners for each of the {n} {noun}.{note}",
            yours=f"shape {boxes.shape}",
            expected=f"shape ({n}, 8, 3)",
        )
    return boxes


def _as_pair(answer: object, names: tuple[str, str]) -> tuple[object, object]:
    """Return the two results of a step."""
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        raise WrongForm(
            f"The step must return two results: {' and '.join(names)}.",
            yours=brief_text(answer),
            expected=", ".join(names),
        )
    return answer[0], answer[1]


def _as_counts_and_flags(
    answer: object, names: tuple[str, str], n: int, noun: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return the two results of a step: a count, and True or False, for each of the n rows."""
    counts, flags = map(as_array, _as_pair(answer, names))
    if counts.dtype.kind == "b" and flags.dtype.kind in "iuf":
        raise WrongForm(
            f"The two results are in the wrong order: {names[0]} comes first, then {names[1]}.",
            yours=f"{brief_text(counts)}, {brief_text(flags)}",
            expected="numbers, then True or False",
        )
    for name, values in zip(names, (counts, flags), strict=True):
        if values.shape != (n,) and not values.size == n == 0:
            raise WrongForm(
                f"There must be one entry of {name} for each of the {n} {noun}.",
                yours=f"shape {values.shape}: {brief_text(values)}",
                expected=f"shape ({n},)",
            )
    return counts, flags.astype(bool)


def _same_pair(answer: object, predicted: tuple) -> bool:
    return (
        isinstance(answer, tuple | list)
        and len(answer) == len(predicted)
        and all(map(same_array, answer, predicted))
    )


# ---- predict_boxes -----------------------------------------------------------------------------

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
    yours = _as_boxes(predict_boxes(boxes.copy(), velocities.copy(), seconds), len(boxes))
    right = _right_moved_boxes(boxes, velocities, seconds)
    wrong = np.flatnonzero(~np.isclose(yours, right, rtol=0, atol=1e-3).all(axis=(1, 2)))
    if not len(wrong):
        return
    row = wrong[0]
    input_text = (
        f"a box at {brief_text(_centres(boxes)[row])}, velocity {brief_text(velocities[row])} m/s, "
        f"{seconds:g} s"
    )
    if np.allclose(_centres(yours)[row], _centres(right)[row], atol=1e-3):
        raise CheckFailed(
            f"Box {row} has the right centre but wrong corners.",
            input_text=input_text,
            yours=f"corner 0 at {brief_text(yours[row, 0])}",
            expected=f"corner 0 at {brief_text(right[row, 0])}",
        )
    raise CheckFailed(
        f"Box {row} has not moved by its velocity times the time.",
        input_text=input_text,
        yours=f"centre at {brief_text(_centres(yours)[row])}",
        expected=f"centre at {brief_text(_centres(right)[row])}",
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
    _as_boxes(predict_boxes(_NO_BOXES.copy(), np.empty((0, 3)), 0.1), 0)


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


# ---- correct_boxes -----------------------------------------------------------------------------

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
    boxes, velocities = _as_pair(correct_boxes(*arguments), _RESULT_NAMES)
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
    return _as_boxes(boxes, len(_FOUND)), velocities


def _given_text(row: int, gain: float, seconds: float) -> str:
    return (
        f"expected at {brief_text(_centres(_EXPECTED)[row])}, "
        f"found at {brief_text(_centres(_FOUND)[row])}, "
        f"velocity {brief_text(_VELOCITIES[row])} m/s, gain {gain:g}, {seconds:g} s"
    )


def _assert_placed(correct_boxes: Callable, gain: float, seconds: float) -> None:
    yours, _ = _call_correct_boxes(correct_boxes, gain, seconds)
    right, _ = _right_correction(_EXPECTED, _VELOCITIES, _FOUND, gain, seconds)
    is_wrong = ~np.isclose(_centres(yours), _centres(right), rtol=0, atol=1e-3).all(axis=1)
    if is_wrong.any():
        row = np.flatnonzero(is_wrong)[0]
        raise CheckFailed(
            f"The centre of box {row} is not at the expected centre plus gain times the offset to "
            "the found centre.",
            input_text=_given_text(row, gain, seconds),
            yours=f"centre at {brief_text(_centres(yours)[row])}",
            expected=f"centre at {brief_text(_centres(right)[row])}",
        )


@visible_check(
    "correct_boxes",
    title="Places each box between its expected and its found position",
    why="A detected box wobbles. With a gain below 1, the track wobbles less.",
    hint="Compute off = found.mean(axis=1) - expected.mean(axis=1). The new centre is the centre "
    "of expected plus gain times off.",
)
def places_boxes_between(correct_boxes: Callable) -> None:
    for gain, seconds in ((0.5, 0.1), (0.75, 0.2)):
        _assert_placed(correct_boxes, gain, seconds)


@visible_check(
    "correct_boxes",
    title="Returns the found box, moved as a whole",
    why="The size and heading of the found box were measured just now. Those of "
    "the expected box are out of date.",
    hint="Move all corners of found back by the same fraction of off: found - (1 - gain) * "
    "off[:, None].",
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
    hint="Compute beta = 2 * (1 - np.sqrt(1 - gain)) ** 2, and return velocities + beta * off / "
    "seconds as the new velocities.",
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
    hint="Write found - (1 - gain) * off[:, None]. With a gain of 1, the result is then the found "
    "box.",
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
        "Return velocities + beta * off / seconds.",
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
        "Return velocities + beta * off / seconds.",
    ),
    Mistake(
        "The code uses the gain as the weight of the expected box. It should be the weight of the "
        "found box.",
        _prediction_from_velocity_rule(share=lambda gain: 1 - gain),
        "Write found - (1 - gain) * off[:, None]. With a gain of 1, the result is then the found "
        "box.",
    ),
    Mistake(
        "The function returns the found boxes unchanged, whatever the gain is.",
        _prediction_from_velocity_rule(share=lambda gain: 1.0),
        "Return found - (1 - gain) * off[:, None].",
    ),
    Mistake(
        "The code mixes expected and found boxes corner by corner. If a box grows or starts with "
        "another corner, the result does not have the size and sides of the found box.",
        lambda right, expected, velocities, found, gain, seconds: (
            expected + gain * (found - expected),
            right[1],
        ),
        "Move the found box as a whole with off[:, None], which moves all its corners alike.",
    ),
    cases=(
        (_EXPECTED, _VELOCITIES, _FOUND, 0.4, 0.1),
        (_EXPECTED, _VELOCITIES, _FOUND, 0.8, 0.25),
    ),
    right=_right_correction,
    is_same=_same_pair,
)


# ---- coast -------------------------------------------------------------------------------------

_MISSED = frozen(np.array([2, 3, 2, 1, 1]))
_PARTNERS = frozen(np.array([-1, 3, 0, -1]))
_GIVEN = "missed [2, 3, 2, 1, 1], partners [-1, 3, 0, -1], patience 3"
_RIGHT_COUNTS = frozen(np.array([0, 4, 3, 0, 2]))


def _right_counts(
    missed: np.ndarray, partners: np.ndarray, patience: int
) -> tuple[np.ndarray, np.ndarray]:
    partners = set(np.asarray(partners).tolist())
    counts = [0 if row in partners else count + 1 for row, count in enumerate(missed.tolist())]
    counts = np.array(counts, dtype=int)
    return counts, counts <= patience


def _call_coast(coast: Callable, *case: object) -> tuple[np.ndarray, np.ndarray]:
    """Return the two results of a call: a count for each track, and whether the track is kept."""
    missed, partners, patience = case
    answer = coast(missed.copy(), partners.copy(), patience)
    return _as_counts_and_flags(answer, ("missed", "kept"), len(missed), "tracks")


@visible_check(
    "coast",
    title="Resets the count of each track that has a box, and adds 1 to all others",
    why="If a count is never reset, a track is dropped although it has a box in every second "
    "frame.",
    hint=fixed(
        "Call np.isin(np.arange(len(missed)), partners), which is True for the tracks that have a "
        "box."
    ),
)
def counts_missed_frames(coast: Callable) -> None:
    yours, _ = _call_coast(coast, _MISSED, _PARTNERS, 3)
    wrong = np.flatnonzero(yours != _RIGHT_COUNTS)
    if len(wrong):
        row = wrong[0]
        state = "has a box" if row in _PARTNERS else "has no box"
        raise CheckFailed(
            f"Track {row} {state}, but its count is wrong.",
            input_text=_GIVEN,
            yours=f"missed {brief_text(yours)}",
            expected=f"missed {brief_text(_RIGHT_COUNTS)}",
        )


@visible_check(
    "coast",
    title="Keeps a track that has missed at most patience frames in a row",
    why="If a track is dropped too early, its object gets a new track ID. If it is dropped too "
    "late, another object gets its track ID.",
    hint="Compare the new counts with patience: missed <= patience.",
)
def drops_tracks_after_patience(coast: Callable) -> None:
    for patience in (3, 0, 2, 10):
        _, yours = _call_coast(coast, _MISSED, _PARTNERS, patience)
        right = patience >= _RIGHT_COUNTS
        if not np.array_equal(yours, right):
            row = np.flatnonzero(yours != right)[0]
            verb = "kept" if right[row] else "dropped"
            raise CheckFailed(
                f"Track {row} has missed {_RIGHT_COUNTS[row]} frames in a row and should be {verb}."
                if _RIGHT_COUNTS[row]
                else f"Track {row} has a box and should be kept.",
                input_text=_GIVEN.replace("patience 3", f"patience {patience}"),
                yours=f"kept {brief_text(yours)}",
                expected=f"kept {brief_text(right)}",
            )


@visible_check(
    "coast",
    title="Works when there are no boxes or no tracks",
    why="In fog a whole frame may be empty, and the tracks must last until the boxes return.",
    hint="Work with whole arrays, without a special case.",
)
def works_on_empty_frames(coast: Callable) -> None:
    empty = np.empty(0, dtype=int)
    for missed, partners in ((_MISSED, empty), (empty, empty), (empty, np.array([-1, -1]))):
        counts, kept = _call_coast(coast, missed, partners, 10)
        right_counts, right_kept = _right_counts(missed, partners, 10)
        if not (same_array(counts, right_counts) and same_array(kept, right_kept)):
            raise CheckFailed(
                "In a frame without boxes, every track misses one more frame.",
                input_text=f"missed {brief_text(missed)}, partners {brief_text(partners)}, "
                "patience 10",
                yours=f"missed {brief_text(counts)}, kept {brief_text(kept)}",
                expected=f"missed {brief_text(right_counts)}, kept {brief_text(right_kept)}",
            )


@visible_check(
    "coast",
    title="Does not change the counts",
    why="If the function changes the counts, a second call for the same frame counts this frame "
    "twice.",
    hint="Begin with missed = missed + 1, which creates a new array. missed += 1 changes the "
    "input.",
)
def keeps_the_counts_unchanged(coast: Callable) -> None:
    assert_arguments_unchanged(observe(coast, _MISSED, _PARTNERS, 3), _MISSED, _PARTNERS, 3)


def _prediction_from_counts(count: Callable) -> Callable:
    """Return a prediction with another rule for the counts, which decide which tracks stay."""

    def predict(right: tuple, missed: np.ndarray, partners: np.ndarray, patience: int) -> tuple:
        has_box = np.isin(np.arange(len(missed)), partners)
        counts = count(missed, has_box, partners)
        return counts, counts <= patience

    return predict


def _count_last_track(missed: np.ndarray, has_box: np.ndarray, partners: np.ndarray) -> np.ndarray:
    """Return the counts if -1 is used as an index, which means the last track."""
    counts = missed + 1
    counts[partners] = 0
    return counts


declare_mistakes(
    "coast",
    Mistake(
        fixed(
            "The last track counts as seen whenever a box is new, because the index -1 means the "
            "last row."
        ),
        _prediction_from_counts(_count_last_track),
        fixed(
            "Leave out -1 with partners[partners >= 0], or use np.isin(np.arange(len(missed)), "
            "partners)."
        ),
    ),
    Mistake(
        "A track is dropped one frame too early: `<` should be `<=`.",
        lambda right, missed, partners, patience: (right[0], right[0] < patience),
        "Write missed <= patience, because a track that has missed exactly patience frames is "
        "still kept.",
    ),
    Mistake(
        "The function compares the old counts with patience, so a track is kept one frame too "
        "long.",
        lambda right, missed, partners, patience: (right[0], missed <= patience),
        "Compare the new counts with patience.",
    ),
    Mistake(
        "A track with a box keeps its old count, which should become 0.",
        _prediction_from_counts(
            lambda missed, has_box, partners: np.where(has_box, missed, missed + 1)
        ),
        "Write np.where(seen, 0, missed + 1), where seen is the mask of the tracks that have a "
        "box.",
    ),
    Mistake(
        "Every count goes up by 1, whether the track has a box or not.",
        _prediction_from_counts(lambda missed, has_box, partners: missed + 1),
        "Write np.where(seen, 0, missed + 1), where seen is the mask of the tracks that have a "
        "box.",
    ),
    Mistake(
        "The count of a track without a box is always 1, however many frames it has missed.",
        _prediction_from_counts(lambda missed, has_box, partners: np.where(has_box, 0, 1)),
        "Write np.where(seen, 0, missed + 1), where seen is the mask of the tracks that have a "
        "box.",
    ),
    Mistake(
        "Tracks with a box are treated as if they had none, and the other way round.",
        _prediction_from_counts(lambda missed, has_box, partners: np.where(has_box, missed + 1, 0)),
        "Reset the tracks in partners, because these are the tracks that have a box.",
    ),
    Mistake(
        "Only tracks with a box in this frame are kept, so no track coasts.",
        lambda right, missed, partners, patience: (right[0], right[0] == 0),
        "Return missed <= patience as kept, with the new counts.",
    ),
    Mistake(
        "The second result says which tracks are dropped. It should say which tracks are kept.",
        lambda right, missed, partners, patience: (right[0], right[0] > patience),
    ),
    cases=(
        (np.array([2, 3, 2, 1, 1, 4]), np.array([-1, 3, 0, -1]), 3),
        (np.array([2, 1, 0, 2, 2, 1, 2]), np.array([4, -1, 1, -1]), 2),
    ),
    right=_right_counts,
    is_same=_same_pair,
)


# ---- confirm -----------------------------------------------------------------------------------

_HITS = frozen(np.array([4, 1, 2, 3]))
_TRACK_OF_BOX = frozen(np.array([2, -1, 0, 1, -1]))
_GIVEN_HITS = "hits [4, 1, 2, 3], partners [2, -1, 0, 1, -1], needed 3"
_RIGHT_HITS = frozen(np.array([3, 1, 5, 2, 1]))


def _right_hits(
    hits: np.ndarray, partners: np.ndarray, needed: int
) -> tuple[np.ndarray, np.ndarray]:
    counts = [hits[partner] + 1 if partner >= 0 else 1 for partner in partners.tolist()]
    counts = np.array(counts, dtype=int)
    return counts, counts >= needed


def _call_confirm(confirm: Callable, *case: object) -> tuple[np.ndarray, np.ndarray]:
    """Return the two results of a call: a count for each box, and whether its track counts."""
    hits, partners, needed = case
    answer = confirm(hits.copy(), partners.copy(), needed)
    return _as_counts_and_flags(answer, ("hits", "confirmed"), len(partners), "boxes")


@visible_check(
    "confirm",
    title="Adds 1 to the count of each box's track, and counts 1 for a new track",
    why="If a new track begins with the count of another track, a ghost is confirmed at once.",
    hint=fixed(
        "Call np.append(hits, 0). Then -1 is the index of the 0, and partners selects an old count "
        "for each box."
    ),
)
def counts_frames_with_a_box(confirm: Callable) -> None:
    yours, _ = _call_confirm(confirm, _HITS, _TRACK_OF_BOX, 3)
    wrong = np.flatnonzero(yours != _RIGHT_HITS)
    if len(wrong):
        box, track = wrong[0], _TRACK_OF_BOX[wrong[0]]
        state = "is new" if track < 0 else f"belongs to track {track}"
        raise CheckFailed(
            f"Box {box} {state}, but its count is wrong.",
            input_text=_GIVEN_HITS,
            yours=f"hits {brief_text(yours)}",
            expected=f"hits {brief_text(_RIGHT_HITS)}",
        )


@visible_check(
    "confirm",
    title="Confirms a track that has had a box in at least needed frames",
    why="If a track is confirmed too early, the car brakes for a ghost. If it is confirmed too "
    "late, the car brakes too late for a pedestrian.",
    hint="Compare the new counts with needed: hits >= needed.",
)
def confirms_tracks_after_enough_frames(confirm: Callable) -> None:
    for needed in (3, 1, 2, 5):
        _, yours = _call_confirm(confirm, _HITS, _TRACK_OF_BOX, needed)
        right = needed <= _RIGHT_HITS
        if not np.array_equal(yours, right):
            box = np.flatnonzero(yours != right)[0]
            frames = f"{_RIGHT_HITS[box]} frame{'s' if _RIGHT_HITS[box] > 1 else ''}"
            raise CheckFailed(
                f"The track of box {box} has had a box in {frames} and should be "
                f"{'confirmed' if right[box] else 'tentative'}.",
                input_text=_GIVEN_HITS.replace("needed 3", f"needed {needed}"),
                yours=f"confirmed {brief_text(yours)}",
                expected=f"confirmed {brief_text(right)}",
            )


@visible_check(
    "confirm",
    title="Works when there are no boxes or no tracks",
    why="In the first frame there are no tracks, so every box is new.",
    hint=fixed("Append the 0 before you use partners as an index. An empty array has no last row."),
)
def works_without_boxes_or_tracks(confirm: Callable) -> None:
    empty = np.empty(0, dtype=int)
    for hits, partners in ((_HITS, empty), (empty, empty), (empty, np.array([-1, -1]))):
        counts, confirmed = _call_confirm(confirm, hits, partners, 3)
        right_counts, right_confirmed = _right_hits(hits, partners, 3)
        if not (same_array(counts, right_counts) and same_array(confirmed, right_confirmed)):
            raise CheckFailed(
                "In a frame without tracks, every box begins a tentative track.",
                input_text=f"hits {brief_text(hits)}, partners {brief_text(partners)}, needed 3",
                yours=f"hits {brief_text(counts)}, confirmed {brief_text(confirmed)}",
                expected=f"hits {brief_text(right_counts)}, confirmed "
                f"{brief_text(right_confirmed)}",
            )


@visible_check(
    "confirm",
    title="Does not change its input",
    why="If the function changes the counts, a second call for the same frame counts this frame "
    "twice.",
    hint="Begin with hits = np.append(hits, 0), which creates a new array. hits += 1 changes the "
    "input.",
)
def keeps_its_arrays_unchanged(confirm: Callable) -> None:
    arguments = _HITS, _TRACK_OF_BOX, 3
    assert_arguments_unchanged(observe(confirm, *arguments), *arguments)


def _prediction_from_hits(count: Callable) -> Callable:
    """Return a prediction with another rule for the counts, which decide which tracks count."""

    def predict(right: tuple, hits: np.ndarray, partners: np.ndarray, needed: int) -> tuple:
        counts = count(right[0], hits, partners)
        return counts, counts >= needed

    return predict


declare_mistakes(
    "confirm",
    Mistake(
        fixed(
            "A new track begins with the count of the last track, because the index -1 means the "
            "last row."
        ),
        _prediction_from_hits(lambda counts, hits, partners: hits[partners] + 1),
        fixed("Write np.append(hits, 0)[partners] + 1. Then the last row is a 0."),
    ),
    Mistake(
        "The count of a new track is 0. It should be 1, because the track has a box in this frame.",
        _prediction_from_hits(lambda counts, hits, partners: counts * (partners >= 0)),
        fixed("Write np.append(hits, 0)[partners] + 1, which adds 1 for new tracks also."),
    ),
    Mistake(
        "The counts do not include this frame.",
        _prediction_from_hits(lambda counts, hits, partners: counts - 1),
        "Add 1 to the count of each box, because each box is in this frame.",
    ),
    Mistake(
        "The count of every box is 1, however many boxes its track has had.",
        _prediction_from_hits(lambda counts, hits, partners: np.ones_like(counts)),
        fixed(
            "Use partners as an index: np.append(hits, 0)[partners] is the old count of each box."
        ),
    ),
    Mistake(
        "A track is confirmed one frame too late.",
        lambda right, hits, partners, needed: (right[0], right[0] > needed),
        "Compare the new counts with needed, and use >=.",
    ),
    Mistake(
        "A track is confirmed only in the frame in which its count is exactly needed.",
        lambda right, hits, partners, needed: (right[0], right[0] == needed),
        "Write hits >= needed, because a confirmed track stays confirmed.",
    ),
    Mistake(
        fixed("A track is always confirmed after 3 frames, whatever needed is."),
        lambda right, hits, partners, needed: (right[0], right[0] >= 3),
        "Compare the new counts with needed.",
    ),
    Mistake(
        "The second result says which tracks are tentative. It should say which tracks are "
        "confirmed.",
        lambda right, hits, partners, needed: (right[0], right[0] < needed),
    ),
    cases=(
        (np.array([4, 1, 3, 3, 2, 6]), np.array([2, -1, 0, 5, 1, -1, 4]), 4),
        (np.array([1, 2, 1, 5, 2]), np.array([3, -1, 1, 0, -1, 2, 4]), 2),
    ),
    right=_right_hits,
    is_same=_same_pair,
)
