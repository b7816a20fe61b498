"""Visible checks of the three steps of a tracker: `predict_boxes`, `correct_boxes`, `coast`.

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
    brief,
    frozen,
    needs,
    observe,
)
from utils.checks.core import visible
from utils.checks.diagnosis import Mistake, mistakes, same_array
from utils.checks.failures import fixed
from utils.checks.lesson_12.match_boxes import cubes

_NO_BOXES = frozen(np.empty((0, 8, 3)))


def _centres(boxes: np.ndarray) -> np.ndarray:
    """Return the centres of boxes, rounded to a tenth of a millimetre."""
    return np.round(boxes.mean(axis=1), 4) + 0.0


def _as_boxes(answer: object, n: int, what: str = "boxes") -> np.ndarray:
    boxes = as_array(answer, what=f"an array of {what}")
    if boxes.size == 0 and n == 0:
        return _NO_BOXES
    if boxes.shape != (n, 8, 3):
        note = " These are centres: move all eight corners." if boxes.shape == (n, 3) else ""
        raise WrongForm(
            f"There must be eight corners for each of the {n} {what}.{note}",
            yours=f"shape {boxes.shape}",
            expected=f"shape ({n}, 8, 3)",
        )
    return boxes


def _pair(answer: object, names: tuple[str, str]) -> tuple[object, object]:
    """Return the two results of a step."""
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        raise WrongForm(
            f"The step returns two things: {' and '.join(names)}.",
            yours=brief(answer),
            expected=", ".join(names),
        )
    return answer[0], answer[1]


def _same_pair(answer: object, predicted: tuple) -> bool:
    return (
        isinstance(answer, tuple | list)
        and len(answer) == len(predicted)
        and all(map(same_array, answer, predicted))
    )


# ---- predict_boxes -----------------------------------------------------------------------------

_PARKED = frozen(cubes([[10, 2], [20, -1], [-4, 3]]))
_PARKED_VELOCITIES = frozen(np.array([[-5.0, 0, 0], [-13.0, 0.5, 0], [2.0, -4.0, 1.0]]))
# As many boxes as a box has corners, so that wrong broadcasting does not raise an exception.
_EIGHT = frozen(cubes([[3.0 * number, number % 3] for number in range(8)]))
_EIGHT_VELOCITIES = frozen(np.array([[number - 3.0, 2.0 - number, 0.0] for number in range(8)]))


def _moved(boxes: np.ndarray, velocities: np.ndarray, seconds: float) -> np.ndarray:
    return np.stack(
        [box + seconds * velocity for box, velocity in zip(boxes, velocities, strict=True)]
    )


def _assert_moved(
    predict_boxes: Callable, boxes: np.ndarray, velocities: np.ndarray, seconds: float
) -> None:
    yours = _as_boxes(predict_boxes(boxes.copy(), velocities.copy(), seconds), len(boxes))
    right = _moved(boxes, velocities, seconds)
    wrong = np.flatnonzero(~np.isclose(yours, right, rtol=0, atol=1e-3).all(axis=(1, 2)))
    if not len(wrong):
        return
    row = wrong[0]
    given = (
        f"a box at {brief(_centres(boxes)[row])}, velocity {brief(velocities[row])} m/s, "
        f"{seconds:g} s"
    )
    if np.allclose(_centres(yours)[row], _centres(right)[row], atol=1e-3):
        raise CheckFailed(
            f"Box {row} has the right centre, and its corners are not where they should be.",
            given=given,
            yours=f"corner 0 at {brief(yours[row, 0])}",
            expected=f"corner 0 at {brief(right[row, 0])}",
        )
    raise CheckFailed(
        f"Box {row} is not where its velocity takes it.",
        given=given,
        yours=f"centre at {brief(_centres(yours)[row])}",
        expected=f"centre at {brief(_centres(right)[row])}",
    )


@visible(
    "predict_boxes",
    title="Each box moves by its own velocity, for a tenth of a second",
    why="Where a thing should be by now is where its next box is looked for.",
    hint="Way is velocity times time. velocities is (N, 3) and boxes (N, 8, 3): "
    "velocities[:, None] is (N, 1, 3), one way for all corners of a box.",
)
def moves_the_boxes(predict_boxes: Callable) -> None:
    _assert_moved(predict_boxes, _PARKED, _PARKED_VELOCITIES, 0.1)


@visible(
    "predict_boxes",
    title="Twice the time is twice the way",
    why="Some scanners turn five times a second, and some frames are lost.",
    hint="Multiply the velocities by seconds.",
)
def takes_the_time(predict_boxes: Callable) -> None:
    for seconds in (0.2, 0.05, 0.0):
        _assert_moved(predict_boxes, _PARKED, _PARKED_VELOCITIES, seconds)


@visible(
    "predict_boxes",
    title="Eight boxes move, too, each as a whole",
    why="With eight boxes NumPy takes velocities for ways of corners, without a word, and every "
    "box is torn.",
    hint="velocities[:, None] says that the three numbers of a row are for a whole box.",
)
def moves_eight_boxes(predict_boxes: Callable) -> None:
    _assert_moved(predict_boxes, _EIGHT, _EIGHT_VELOCITIES, 0.1)


@visible(
    "predict_boxes",
    title="Takes no boxes",
    why="An empty road is no error.",
    hint="Whole arrays do it all: no loop and no special case is needed.",
)
def predicts_nothing(predict_boxes: Callable) -> None:
    _as_boxes(predict_boxes(_NO_BOXES.copy(), np.empty((0, 3)), 0.1), 0)


@visible(
    "predict_boxes",
    title="Leaves boxes and velocities as they are",
    why="What was found a moment ago is drawn after this.",
    hint="boxes + ... makes new boxes; boxes += ... writes into the old ones.",
)
def leaves_what_was(predict_boxes: Callable) -> None:
    assert_arguments_unchanged(
        observe(predict_boxes, _PARKED, _PARKED_VELOCITIES, 0.1), _PARKED, _PARKED_VELOCITIES, 0.1
    )


mistakes(
    "predict_boxes",
    Mistake(
        "The whole velocity is added, as if a second had gone by: seconds is not looked at.",
        lambda right, boxes, velocities, seconds: _moved(boxes, velocities, 1.0),
        "The way is velocity times time.",
    ),
    Mistake(
        "A fixed time decides, a tenth of a second, whatever seconds is.",
        lambda right, boxes, velocities, seconds: _moved(boxes, velocities, 0.1),
        "Multiply by seconds, by its name.",
    ),
    Mistake(
        "The boxes move backwards: the way is subtracted.",
        lambda right, boxes, velocities, seconds: _moved(boxes, velocities, -seconds),
        "A velocity points to where a thing goes: add it.",
    ),
    Mistake(
        "The velocity is divided by the time.",
        lambda right, boxes, velocities, seconds: _moved(boxes, velocities, 1 / seconds),
        "Way is velocity times time.",
    ),
    Mistake(
        "Row k of velocities is taken for the way of corner k, and not of box k.",
        lambda right, boxes, velocities, seconds: boxes + seconds * velocities,
        "velocities[:, None] is one way for all corners of a box.",
    ),
    Mistake(
        "All boxes move by the velocity of the first one.",
        lambda right, boxes, velocities, seconds: boxes + seconds * velocities[0],
        "Leave the rows apart: velocities[:, None], not velocities[0].",
    ),
    Mistake(
        "The boxes stay where they are.",
        lambda right, boxes, velocities, seconds: boxes,
        is_cheap=True,
    ),
    cases=((_EIGHT, _EIGHT_VELOCITIES, 0.25), (_EIGHT[::-1], _EIGHT_VELOCITIES, 0.4)),
    right=_moved,
)


# ---- correct_boxes -----------------------------------------------------------------------------

_EXPECTED = frozen(cubes([[10, 0], [20, -1]]))
_FOUND = frozen(np.vstack([cubes([[10.4, 0.2]]), cubes([[19, -1, 0.4]], 2.0, turn=2)]))
_VELOCITIES = frozen(np.array([[-5.0, 0, 0], [-12.0, 1.0, 0.5]]))
_RESULT_NAMES = "boxes", "velocities"


def _filtered(
    expected: np.ndarray, velocities: np.ndarray, found: np.ndarray, gain: float, seconds: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return boxes and velocities corrected by an alpha-beta filter.

    A box is z - (1 - gain) r, where z is the box found and r its offset from the expected box.
    """
    offset = _mean_corners(found) - _mean_corners(expected)
    beta = 2 * (1 - np.sqrt(1 - gain)) ** 2
    return found - ((1 - gain) * offset)[:, None], velocities + beta * offset / seconds


def _mean_corners(boxes: np.ndarray) -> np.ndarray:
    return boxes.sum(axis=1) / 8


def _corrected(correct_boxes: Callable, gain: float, seconds: float) -> tuple:
    arguments = (_EXPECTED.copy(), _VELOCITIES.copy(), _FOUND.copy(), gain, seconds)
    boxes, velocities = _pair(correct_boxes(*arguments), _RESULT_NAMES)
    if np.shape(boxes) == _VELOCITIES.shape and np.shape(velocities) == _FOUND.shape:
        raise WrongForm(
            "The two answers are exchanged: boxes come first, then velocities.",
            yours=f"shapes {np.shape(boxes)} and {np.shape(velocities)}",
            expected=f"shapes {_FOUND.shape} and {_VELOCITIES.shape}",
        )
    description = "velocities, three numbers each"
    velocities = as_array(velocities, columns=3, what=description, each="velocity")
    if len(velocities) != len(_FOUND):
        raise WrongForm(
            f"There must be one velocity for each of the {len(_FOUND)} boxes.",
            yours=f"shape {velocities.shape}",
            expected=f"shape {_VELOCITIES.shape}",
        )
    return _as_boxes(boxes, len(_FOUND)), velocities


def _given_text(row: int, gain: float, seconds: float) -> str:
    return (
        f"expected at {brief(_centres(_EXPECTED)[row])}, found at {brief(_centres(_FOUND)[row])}, "
        f"velocity {brief(_VELOCITIES[row])} m/s, gain {gain:g}, {seconds:g} s"
    )


def _assert_placed(correct_boxes: Callable, gain: float, seconds: float) -> None:
    yours, _ = _corrected(correct_boxes, gain, seconds)
    right, _ = _filtered(_EXPECTED, _VELOCITIES, _FOUND, gain, seconds)
    is_wrong = ~np.isclose(_centres(yours), _centres(right), rtol=0, atol=1e-3).all(axis=1)
    if is_wrong.any():
        row = np.flatnonzero(is_wrong)[0]
        raise CheckFailed(
            f"Box {row} is not the gain's share of the way from expected to found.",
            given=_given_text(row, gain, seconds),
            yours=f"centre at {brief(_centres(yours)[row])}",
            expected=f"centre at {brief(_centres(right)[row])}",
        )


@visible(
    "correct_boxes",
    title="A box lies between where it was expected and where it is found",
    why="A box that wobbles pulls less at the track.",
    hint="off = found.mean(axis=1) - expected.mean(axis=1) is how far off the expectation was. The "
    "centre is that of expected, plus gain times off.",
)
def lies_between(correct_boxes: Callable) -> None:
    for gain, seconds in ((0.5, 0.1), (0.75, 0.2)):
        _assert_placed(correct_boxes, gain, seconds)


@visible(
    "correct_boxes",
    title="It is the box that was found, moved as a whole",
    why="How large a thing is and how it stands, nobody expected: that was measured just now.",
    hint="Move all corners of found back by what the gain does not believe: "
    "found - (1 - gain) * off[:, None].",
)
def keeps_the_shape(correct_boxes: Callable) -> None:
    with needs("a box lies between where it was expected and where it is found"):
        lies_between(correct_boxes)
    yours, _ = _corrected(correct_boxes, 0.5, 0.1)
    right, _ = _filtered(_EXPECTED, _VELOCITIES, _FOUND, 0.5, 0.1)
    wrong = np.flatnonzero(~np.isclose(yours, right, rtol=0, atol=1e-3).all(axis=(1, 2)))
    if len(wrong):
        row = wrong[0]
        raise CheckFailed(
            f"Box {row} has other corners than the box that was found.",
            given="a box found twice as large as expected, its corners counted from elsewhere",
            yours=f"corners 0 and 1 at {brief(yours[row, 0])} and {brief(yours[row, 1])}",
            expected=f"corners 0 and 1 at {brief(right[row, 0])} and {brief(right[row, 1])}",
        )


@visible(
    "correct_boxes",
    title="The velocity changes by the second gain, times how far off, per second",
    why="It is how a track learns that a car comes towards us, and how a wobble becomes speed "
    "where nothing moves.",
    hint="beta = 2 * (1 - np.sqrt(1 - gain)) ** 2; the new velocities are velocities + beta "
    "* off / seconds.",
)
def learns_the_velocity(correct_boxes: Callable) -> None:
    for gain, seconds in ((0.5, 0.1), (0.75, 0.2)):
        _, yours = _corrected(correct_boxes, gain, seconds)
        _, right = _filtered(_EXPECTED, _VELOCITIES, _FOUND, gain, seconds)
        wrong = np.flatnonzero(~np.isclose(yours, right, rtol=0, atol=2e-3).all(axis=1))
        if len(wrong):
            row = wrong[0]
            raise CheckFailed(
                f"Track {row} has another velocity.",
                given=_given_text(row, gain, seconds),
                yours=f"{brief(yours[row])} m/s",
                expected=f"{brief(right[row])} m/s",
            )


@visible(
    "correct_boxes",
    title="A gain of 0 believes nothing new, a gain of 1 nothing old",
    why="These are the two ends between which the gain is chosen.",
    hint="With a gain of 0 the box lies where it was expected and keeps its velocity; with 1 it "
    "lies where it was found.",
)
def has_two_ends(correct_boxes: Callable) -> None:
    for gain in (0.0, 1.0):
        _assert_placed(correct_boxes, gain, 0.1)
    _, yours = _corrected(correct_boxes, 0.0, 0.1)
    if not np.allclose(yours, _VELOCITIES, atol=1e-3):
        raise CheckFailed(
            fixed("With a gain of 0 a velocity stays as it is."),
            given=_given_text(0, 0.0, 0.1),
            yours=brief(yours[0]),
            expected=brief(_VELOCITIES[0]),
        )


@visible(
    "correct_boxes",
    title="Leaves what it was given as it is",
    why="The boxes that were found are drawn after this.",
    hint="found - ... makes new boxes, and velocities + ... new velocities; -= and += write into "
    "the old ones.",
)
def leaves_what_was_given(correct_boxes: Callable) -> None:
    arguments = _EXPECTED, _VELOCITIES, _FOUND, 0.5, 0.1
    assert_arguments_unchanged(observe(correct_boxes, *arguments), *arguments)


def _corrected_by(
    velocity_rule: Callable = lambda velocities, offset, gain, beta, seconds: (
        velocities + beta * offset / seconds
    ),
    share: Callable = lambda gain: gain,
) -> Callable:
    """Return a prediction with another rule for the velocity or another share of the distance."""

    def predicts(right: tuple, *case: object) -> tuple:
        expected, velocities, found, gain, seconds = case
        offset = _mean_corners(found) - _mean_corners(expected)
        beta = 2 * (1 - np.sqrt(1 - gain)) ** 2
        moved = found - ((1 - share(gain)) * offset)[:, None]
        return moved, velocity_rule(velocities, offset, gain, beta, seconds)

    return predicts


mistakes(
    "correct_boxes",
    Mistake(
        "The change of the velocity is not divided by the time: metres are added to metres per "
        "second.",
        _corrected_by(lambda velocities, offset, gain, beta, seconds: velocities + beta * offset),
        "velocities + beta * off / seconds.",
    ),
    Mistake(
        "The first gain corrects the velocity, too.",
        _corrected_by(
            lambda velocities, offset, gain, beta, seconds: velocities + gain * offset / seconds
        ),
        "The velocity has a gain of its own, beta.",
    ),
    Mistake(
        "How far off is taken the wrong way round, expected minus found, for the velocity.",
        _corrected_by(
            lambda velocities, offset, gain, beta, seconds: velocities - beta * offset / seconds
        ),
        "found minus expected: a thing that is ahead of where it should be is faster.",
    ),
    Mistake(
        "The old velocity is forgotten: only the correction is returned.",
        _corrected_by(lambda velocities, offset, gain, beta, seconds: beta * offset / seconds),
        "Add the correction to velocities.",
    ),
    Mistake(
        "The velocities come back as they went in.",
        _corrected_by(lambda velocities, offset, gain, beta, seconds: velocities),
        "velocities + beta * off / seconds.",
    ),
    Mistake(
        "The gain is the share of the expectation, where it should be the share of what was found.",
        _corrected_by(share=lambda gain: 1 - gain),
        "A gain of 1 believes what was found.",
    ),
    Mistake(
        "The boxes are taken as they were found, whatever the gain is.",
        _corrected_by(share=lambda gain: 1.0),
        "found - (1 - gain) * off[:, None].",
    ),
    Mistake(
        "Expected and found are mixed corner by corner. Where a box grows or starts its corners "
        "elsewhere, neither its size nor its sides are those of the box that was found.",
        lambda right, expected, velocities, found, gain, seconds: (
            expected + gain * (found - expected),
            right[1],
        ),
        "Move the found box as a whole: off[:, None] is one way for all its corners.",
    ),
    cases=(
        (_EXPECTED, _VELOCITIES, _FOUND, 0.4, 0.1),
        (_EXPECTED, _VELOCITIES, _FOUND, 0.8, 0.25),
    ),
    right=_filtered,
    same=_same_pair,
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


def _coasted(coast: Callable, *case: object) -> tuple[np.ndarray, np.ndarray]:
    """Return the two results of a call: for each track a count, and whether it is kept."""
    missed, partners, patience = case
    counts, kept = _pair(coast(missed.copy(), partners.copy(), patience), ("missed", "kept"))
    counts, kept = as_array(counts), as_array(kept)
    if counts.dtype.kind == "b" and kept.dtype.kind in "iuf":
        raise WrongForm(
            "The two answers are exchanged: the counts come first, then who is kept.",
            yours=f"{brief(counts)}, {brief(kept)}",
            expected="numbers, then True or False",
        )
    for name, values in (("missed", counts), ("kept", kept)):
        if values.shape != missed.shape and not values.size == missed.size == 0:
            raise WrongForm(
                f"There must be one entry of {name} for each of the {len(missed)} tracks.",
                yours=f"shape {values.shape}: {brief(values)}",
                expected=f"shape {missed.shape}",
            )
    return counts, kept.astype(bool)


@visible(
    "coast",
    title="What has a box starts again at 0, what has none counts one more",
    why="A track that never starts again is dropped although it is seen every second frame.",
    hint=fixed("np.isin(np.arange(len(missed)), partners) tells which tracks have a box: -1 is ")
    + "the row of none of them.",
)
def counts_what_is_missed(coast: Callable) -> None:
    yours, _ = _coasted(coast, _MISSED, _PARTNERS, 3)
    wrong = np.flatnonzero(yours != _RIGHT_COUNTS)
    if len(wrong):
        row = wrong[0]
        state = "has a box" if row in _PARTNERS else "has no box"
        raise CheckFailed(
            f"Track {row} {state}, and its count is wrong.",
            given=_GIVEN,
            yours=f"missed {brief(yours)}",
            expected=f"missed {brief(_RIGHT_COUNTS)}",
        )


@visible(
    "coast",
    title="A track is kept as long as it misses no more frames than patience",
    why="Dropped too early, a thing comes back as a stranger; too late, its name goes to somebody "
    "else.",
    hint="Compare the new counts with patience: missed <= patience.",
)
def waits_for_patience(coast: Callable) -> None:
    for patience in (3, 0, 2, 10):
        _, yours = _coasted(coast, _MISSED, _PARTNERS, patience)
        right = patience >= _RIGHT_COUNTS
        if not np.array_equal(yours, right):
            row = np.flatnonzero(yours != right)[0]
            verb = "kept" if right[row] else "dropped"
            raise CheckFailed(
                f"Track {row} misses its frame number {_RIGHT_COUNTS[row]}, and should be {verb}."
                if _RIGHT_COUNTS[row]
                else f"Track {row} has a box, and should be kept.",
                given=_GIVEN.replace("patience 3", f"patience {patience}"),
                yours=f"kept {brief(yours)}",
                expected=f"kept {brief(right)}",
            )


@visible(
    "coast",
    title="Takes frames without boxes, and no tracks",
    why="In fog a whole frame may be empty: just then the tracks are needed.",
    hint="Whole arrays do it all: no special case is needed.",
)
def takes_empty_frames(coast: Callable) -> None:
    empty = np.empty(0, dtype=int)
    for missed, partners in ((_MISSED, empty), (empty, empty), (empty, np.array([-1, -1]))):
        counts, kept = _coasted(coast, missed, partners, 10)
        right_counts, right_kept = _right_counts(missed, partners, 10)
        if not (same_array(counts, right_counts) and same_array(kept, right_kept)):
            raise CheckFailed(
                "Without a box every track misses one frame more.",
                given=f"missed {brief(missed)}, partners {brief(partners)}, patience 10",
                yours=f"missed {brief(counts)}, kept {brief(kept)}",
                expected=f"missed {brief(right_counts)}, kept {brief(right_kept)}",
            )


@visible(
    "coast",
    title="Leaves the counts as they were",
    why="Who runs the cell above a second time would count twice.",
    hint="np.where(..., 0, missed + 1) makes new counts; missed[...] = 0 writes into the old ones.",
)
def leaves_the_counts(coast: Callable) -> None:
    assert_arguments_unchanged(observe(coast, _MISSED, _PARTNERS, 3), _MISSED, _PARTNERS, 3)


def _counted_by(count: Callable) -> Callable:
    """Return a prediction with another rule for the counts, and the tracks that they keep."""

    def predicts(right: tuple, missed: np.ndarray, partners: np.ndarray, patience: int) -> tuple:
        has_box = np.isin(np.arange(len(missed)), partners)
        counts = count(missed, has_box, partners)
        return counts, counts <= patience

    return predicts


def _count_last_track(missed: np.ndarray, has_box: np.ndarray, partners: np.ndarray) -> np.ndarray:
    """Count as if -1, used as an index, were the last track."""
    counts = missed + 1
    counts[partners] = 0
    return counts


mistakes(
    "coast",
    Mistake(
        fixed("The last track counts as seen wherever a box is new: as an index, -1 is the last ")
        + "row.",
        _counted_by(_count_last_track),
        fixed("Leave -1 out, partners[partners >= 0], or ask np.isin(np.arange(n), partners)."),
    ),
    Mistake(
        "A track is dropped one frame too early: `<` stands where `<=` is asked for.",
        lambda right, missed, partners, patience: (right[0], right[0] < patience),
        "A track that has missed as many frames as patience says is kept.",
    ),
    Mistake(
        "The old counts are compared with patience: a track lives one frame too long.",
        lambda right, missed, partners, patience: (right[0], missed <= patience),
        "Compare the new counts.",
    ),
    Mistake(
        "What has a box goes on with its old count, and never starts again at 0.",
        _counted_by(lambda missed, has_box, partners: np.where(has_box, missed, missed + 1)),
        "np.where(seen, 0, missed + 1).",
    ),
    Mistake(
        "Every track counts one more, whether it has a box or not.",
        _counted_by(lambda missed, has_box, partners: missed + 1),
        "np.where(seen, 0, missed + 1).",
    ),
    Mistake(
        "What has no box starts again at 1, however long it has had none.",
        _counted_by(lambda missed, has_box, partners: np.where(has_box, 0, 1)),
        "np.where(seen, 0, missed + 1).",
    ),
    Mistake(
        "What has a box and what has none are exchanged.",
        _counted_by(lambda missed, has_box, partners: np.where(has_box, missed + 1, 0)),
        "The entries of partners are the tracks that have a box.",
    ),
    Mistake(
        "Only what has a box in this frame is kept: nothing coasts.",
        lambda right, missed, partners, patience: (right[0], right[0] == 0),
        "kept is missed <= patience, with the new counts.",
    ),
    Mistake(
        "The second answer says who is dropped; it should say who is kept.",
        lambda right, missed, partners, patience: (right[0], right[0] > patience),
    ),
    cases=(
        (np.array([2, 3, 2, 1, 1, 4]), np.array([-1, 3, 0, -1]), 3),
        (np.array([2, 1, 0, 2, 2, 1, 2]), np.array([4, -1, 1, -1]), 2),
    ),
    right=_right_counts,
    same=_same_pair,
)
