"""Visible checks of `match_boxes`; most wait until boxes are found again after a small move."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks import common_checks
from utils.checks.assertions import (
    CheckFailed,
    WrongForm,
    as_array,
    brief_text,
    frozen,
    precondition,
)
from utils.checks.common_checks import Case
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.failures import fixed
from utils.checks.run_cache import once_per_run


def cubes(centres: ArrayLike, size: float = 1.0, turn: int = 0) -> np.ndarray:
    """Return cubes with these centres.

    Parameters
    ----------
    centres : array_like, shape (N, 2) or (N, 3)
    size : float
        Length of an edge in metres.
    turn : int
        Number of places by which the corners are shifted, in the same cyclic order.

    Returns
    -------
    numpy.ndarray, shape (N, 8, 3)
    """
    centres = np.atleast_2d(np.asarray(centres, dtype=float)).reshape(len(centres), -1)
    if centres.shape[1] < 3:
        centres = np.column_stack([centres, np.zeros((len(centres), 3 - centres.shape[1]))])
    floor = np.roll([[1, 1, -1], [-1, 1, -1], [-1, -1, -1], [1, -1, -1]], turn, axis=0)
    return centres[:, None] + size / 2 * np.vstack([floor, floor + [0, 0, 2]])


# Four boxes, far from each other, that move by half a metre and are then listed in another order.
_ORDER = frozen(np.array([2, 0, 3, 1]))
_BEFORE = frozen(cubes([[4, 1], [9, -3], [15, 2], [-6, -4]]))
_AFTER = frozen(_BEFORE[_ORDER] + [-0.5, 0.1, 0.0])


def as_indices(answer: object, previous: np.ndarray, current: np.ndarray) -> np.ndarray:
    """Convert an answer to an array with one index for each current box.

    Parameters
    ----------
    answer : object
    previous, current : numpy.ndarray, shape (N, 8, 3)

    Returns
    -------
    numpy.ndarray, shape (N_current,)

    Raises
    ------
    WrongForm
        If the answer contains None or truth values, or has another shape.
    """
    if isinstance(answer, (list, tuple)) and any(entry is None for entry in answer):
        raise WrongForm(
            fixed("None is not an index: a box without a partner gets -1."),
            yours=brief_text(answer),
            expected="whole numbers, -1 or more",
        )
    yours = as_array(answer, description="an array of indices")
    if yours.size == 0 and not len(current):
        return np.empty(0)
    if yours.shape == (len(current),) and yours.dtype.kind != "b":
        return yours
    message = ""
    if yours.dtype.kind == "b":
        message = " Your answer is a mask of True and False."
    elif yours.shape == (len(current), len(previous)):
        message = (
            " This has the shape of a table of all pairs. Return the index of one column for each "
            "row."
        )
    elif yours.shape == (len(previous),):
        message = f" Your answer has {len(previous)}, one for each previous box."
    elif yours.ndim == 2 and yours.shape[1] == 2:
        message = " If these are pairs, write answer[first] = second for each pair."
    raise WrongForm(
        f"There must be one index for each of the {len(current)} current boxes.{message}",
        yours=f"shape {yours.shape}",
        expected=f"shape ({len(current)},)",
    )


def assert_matched(
    answer: object,
    expected: ArrayLike,
    previous: np.ndarray,
    current: np.ndarray,
    compared_rows: ArrayLike | slice = slice(None),
    input_text: str | None = None,
) -> None:
    """Assert that the answer contains the index of the right previous box for each current box.

    Parameters
    ----------
    answer : object
    expected : array_like of int, shape (N_current,)
        Index of the previous box, or -1 for a new box.
    previous, current : numpy.ndarray, shape (N, 8, 3)
    compared_rows : array_like or slice
        Rows of the current boxes to compare; by default all.
    input_text : str, optional
        Other arguments of the function as text, for the message.
    """
    expected = np.asarray(expected, dtype=int).ravel()
    yours = as_indices(answer, previous, current)
    compared = np.arange(len(expected))[compared_rows]
    wrong = compared[yours[compared] != expected[compared]]
    if not len(wrong):
        return
    first = wrong[0]
    if expected[first] < 0:
        message = f"Current box {first} has no partner but is not marked as new."
    elif yours[first] not in range(-1, len(previous)):
        message = (
            f"Current box {first} gets {yours[first]:g}, which is not a row of previous: there "
            f"are {len(previous)} rows."
        )
    else:
        message = f"The partner of current box {first} should be previous box {expected[first]}."
    raise CheckFailed(
        message,
        input_text=_centres_text(previous, current, input_text),
        yours=brief_text(yours),
        expected=brief_text(expected),
        hint=_SWAPPED_HINT if _is_inverse(yours, expected) else "",
        draw=functools.partial(_draw_matches, previous, current, yours, expected),
    )


_SWAPPED_HINT = (
    "Your pairs are right but the wrong way round: your entry k is the current box that previous "
    "box k became. Write answer[row] = column, with a row for each current box and a column for "
    "each previous box."
)


def _is_inverse(yours: np.ndarray, expected: np.ndarray) -> bool:
    """Return whether an answer has the right pairs with current and previous swapped."""
    indices = np.arange(len(expected))
    return np.array_equal(np.sort(expected), indices) and np.array_equal(
        yours, np.argsort(expected)
    )


def assert_one_to_one(
    answer: object, previous: np.ndarray, current: np.ndarray, input_text: str | None = None
) -> None:
    """Assert that no previous box has two partners, whether they are right or wrong.

    Parameters
    ----------
    answer : object
    previous, current : numpy.ndarray, shape (N, 8, 3)
    input_text : str, optional
        Other arguments of the function as text, for the message.
    """
    yours = as_indices(answer, previous, current)
    partners, counts = np.unique(yours[yours >= 0], return_counts=True)
    if (counts > 1).any():
        shared = partners[counts > 1][0]
        owners = np.flatnonzero(yours == shared)
        raise CheckFailed(
            f"Previous box {shared:.0f} is the partner of several current boxes, for example of "
            f"{owners[0]} and {owners[1]}.",
            input_text=_centres_text(previous, current, input_text),
            yours=brief_text(yours),
            draw=functools.partial(_draw_matches, previous, current, yours, np.empty(0)),
        )


def assert_limit_respected(
    answer: object,
    expected: ArrayLike,
    previous: np.ndarray,
    current: np.ndarray,
    max_distance: float,
) -> None:
    """Assert that close boxes are partners and that others have no partner.

    Any negative number counts as no partner, because another check tests for -1.

    Parameters
    ----------
    answer : object
    expected : array_like of int, shape (N_current,)
        Index of the previous box, or -1 if none is close enough.
    previous, current : numpy.ndarray, shape (N, 8, 3)
    max_distance : float
        The limit that the function was given, in metres.
    """
    expected = np.asarray(expected, dtype=int)
    yours = as_indices(answer, previous, current)
    wrong = np.flatnonzero(np.where(expected < 0, yours >= 0, yours != expected))
    if not len(wrong):
        return
    first = wrong[0]
    if not len(previous):
        raise CheckFailed(
            f"There is no previous box, but current box {first} has a partner.",
            yours=brief_text(yours),
        )
    gap = np.linalg.norm(previous.mean(axis=1) - current[first].mean(axis=0), axis=1).min()
    text = (
        "it should not have a partner" if expected[first] < 0 else "that box should be its partner"
    )
    raise CheckFailed(
        f"Current box {first} is {gap:.2f} m from the nearest previous box, and max_distance is "
        f"{max_distance:g} m, so {text}.",
        input_text=_centres_text(previous, current, f"max_distance {max_distance:g}"),
        yours=brief_text(yours),
        expected=brief_text(expected),
        draw=functools.partial(_draw_matches, previous, current, yours, expected),
    )


@once_per_run
def require_matching(match_boxes: Callable) -> None:
    """Assert that boxes are found again after a small move; raise `NotYet` if not."""
    with precondition("the function finds each box again after a small move"):
        answer = match_boxes(_BEFORE.copy(), _AFTER.copy(), 1.5)
        assert_matched(answer, _ORDER, _BEFORE, _AFTER)


def _centres_text(previous: np.ndarray, current: np.ndarray, more: str | None = None) -> str | None:
    """Return the centres of the boxes as text, or None if there are more than eight boxes."""
    if len(previous) + len(current) > 8:
        return None
    parts = []
    for name, boxes in (("previous", previous), ("current", current)):
        places = [f"({x:g}, {y:g})" for x, y in boxes.mean(axis=1)[:, :2].round(2)]
        parts.append(f"{name} at {' '.join(places) or 'no place'}")
    return "; ".join([*parts, more] if more else parts)


@visible_check(
    "match_boxes",
    weight=4,
    title="Finds each box again after a small move, whatever the order of the boxes",
    why="Clusters are numbered from 1 again in every frame. Only matching shows which box moved "
    "where.",
    hint="Make a table of the distances between all current and previous centres, "
    "boxes.mean(axis=1). The smallest entry is the first pair.",
)
def finds_again(match_boxes: Callable) -> None:
    answer = match_boxes(_BEFORE.copy(), _AFTER.copy(), 1.5)
    assert_matched(answer, _ORDER, _BEFORE, _AFTER, input_text="max_distance 1.5")


@visible_check(
    "match_boxes",
    weight=2,
    title="Returns -1 for a new box, which has no partner",
    why="When a pedestrian steps out from behind a lorry, the new box must not get the lorry's "
    "track ID.",
    hint="Start from np.full(len(current), -1), and write the partners into it.",
)
def marks_new_boxes(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    previous, current = cubes([[4, 1], [9, -3]]), cubes([[20, 5], [9.4, -3], [4, 1.5], [-9, 0]])
    answer = match_boxes(previous.copy(), current.copy(), 1.5)
    assert_matched(answer, [-1, 1, 0, -1], previous, current, [0, 3], "max_distance 1.5")


@visible_check(
    "match_boxes",
    weight=6,
    title="Does not pair boxes that are farther apart than max_distance",
    why="If a track ID jumps to a distant object, that object seems to have a high speed.",
    hint="Compare the distance itself, which np.linalg.norm returns, with max_distance before you "
    "accept a pair.",
)
def respects_max_distance(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    previous = cubes([[0, 0], [20, 0], [40, 0]])
    # The last box has moved diagonally by 1.4 m.
    current = cubes([[40, 2.6], [0, 0.4], [19.16, -1.12]])
    for limit, expected in (
        (3.0, [2, 0, 1]),
        (2.0, [-1, 0, 1]),
        (1.41, [-1, 0, 1]),
        (1.39, [-1, 0, -1]),
        (0.3, [-1, -1, -1]),
    ):
        answer = match_boxes(previous.copy(), current.copy(), limit)
        assert_limit_respected(answer, expected, previous, current, limit)
    # A search for the smallest sum would choose the two pairs that are too far apart.
    previous, current = cubes([[0, 0], [4, 0]]), cubes([[3.2, 0], [7.2, 0]])
    assert_limit_respected(
        match_boxes(previous.copy(), current.copy(), 2.0), [1, -1], previous, current, 2.0
    )


@visible_check(
    "match_boxes",
    weight=10,
    title="Never gives two boxes the same partner",
    why="Two cars with the same track ID look like a single car to the tracker.",
    hint="After each pair, set table[row, :] and table[:, column] to np.inf, because neither box "
    "is free any more.",
)
def is_one_to_one(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    # The nearer current box comes first, then last. No current box is near previous box 0.
    previous, current = cubes([[-20, 0], [5, 0]]), cubes([[5.2, 0], [6.2, 0.3]])
    for ordered in (current, current[::-1]):
        answer = match_boxes(previous.copy(), ordered.copy(), 2.0)
        assert_one_to_one(answer, previous, ordered, "max_distance 2")


@visible_check(
    "match_boxes",
    weight=4,
    title="Gives a partner to the nearer of two rival boxes",
    why="If the first box in the list wins, the result depends on the order, and cars swap track "
    "IDs.",
    hint="Take the closest of all pairs first, with table.argmin(). If you go through the current "
    "boxes in order, the first box gets the partner.",
)
def prefers_the_nearer_rival(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    previous, current = cubes([[-20, 0], [5, 0]]), cubes([[6.2, 0.3], [5.2, 0]])
    answer = match_boxes(previous.copy(), current.copy(), 2.0)
    assert_matched(answer, [-1, 1], previous, current, [1], "max_distance 2")


@visible_check(
    "match_boxes",
    weight=2,
    title="Pairs a box with the nearer of two previous boxes",
    why="A car next to a post must keep its own track ID and speed, and must not get those of the "
    "post.",
    hint="Also set table[row, :] to np.inf, because a box that has a partner must not get a "
    "second one.",
)
def prefers_the_nearer_previous_box(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    previous, current = cubes([[6.3, 0.4], [5, 0]]), cubes([[5.2, 0]])
    answer = match_boxes(previous.copy(), current.copy(), 2.0)
    assert_matched(answer, [1], previous, current, input_text="max_distance 2")


@visible_check(
    "match_boxes",
    weight=6,
    title="Compares centres, even if the corners of a box are in another order",
    why="When a car turns or more of it becomes visible, the order of its corners may change.",
    hint="Compare the means over all eight corners, boxes.mean(axis=1).",
)
def compares_centres(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    previous = cubes([[4, 1], [15, 2], [-8, -4]], 2.0)
    current = cubes([[15.2, 2], [-8, -4.3], [4.1, 1]], 2.0, turn=2)
    answer = match_boxes(previous.copy(), current.copy(), 1.0)
    assert_matched(answer, [1, 2, 0], previous, current, input_text="max_distance 1")


@visible_check(
    "match_boxes",
    weight=3,
    title="Works when either list is empty",
    why="There are no boxes before the first frame and on an empty road, and that must not "
    "crash the tracker.",
    hint="If the table of distances is empty, return np.full(len(current), -1), because argmin of "
    "an empty table raises an error.",
)
def works_without_boxes(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    boxes, no_boxes = cubes([[4, 1], [9, -3]]), np.empty((0, 8, 3))
    far = cubes([[40, 7]])
    [marker] = as_indices(match_boxes(boxes.copy(), far.copy(), 2.0), boxes, far)
    for previous, current in ((no_boxes, boxes), (boxes, no_boxes), (no_boxes, no_boxes)):
        answer = match_boxes(previous.copy(), current.copy(), 2.0)
        assert_limit_respected(answer, np.full(len(current), -1), previous, current, 2.0)
        yours = as_indices(answer, previous, current)
        # Skip functions with another marker for new boxes, because another check tests for -1.
        if marker == -1 and not (yours == marker).all():
            raise CheckFailed(
                fixed(
                    "Without previous boxes, every current box is new, but not all are marked "
                    "with -1."
                ),
                input_text=f"{len(previous)} previous and {len(current)} current boxes",
                yours=brief_text(yours),
                expected=brief_text(np.full(len(current), -1)),
            )


_MOVED_CASE = Case(
    __name__,
    "match_boxes",
    {"previous": _BEFORE, "current": _AFTER, "max_distance": 1.5},
    expected=_ORDER,
    compare=lambda answer, previous, current, _, order: assert_matched(
        answer, order, previous, current
    ),
    precondition=require_matching,
)
common_checks.promise_names(
    _MOVED_CASE,
    "keeps_the_names",
    why="Other code may call match_boxes(before, after, max_distance=1.5).",
)
common_checks.promise_untouched(
    _MOVED_CASE,
    "keeps_the_boxes_unchanged",
    why="The boxes of this frame are the previous boxes of the next frame.",
    hint="Write np.inf into your own table of distances, and do not write into the boxes.",
)


@note_check(
    "match_boxes",
    title="Returns whole numbers as indices",
    why="The tracker below looks up track IDs with the indices, and 2.0 is not an index.",
)
def returns_whole_indices(match_boxes: Callable) -> None:
    dtype = as_array(match_boxes(_BEFORE.copy(), _AFTER.copy(), 1.5)).dtype
    if dtype.kind not in "iu":
        raise CheckFailed(f"The indices are of type {dtype}.")


# Eleven small calls that distinguish the usual mistakes: max_distance, previous centres (x, y),
# current centres and the right partners. Each call has a different max_distance, which identifies
# it. In "far" and "near", boxes are large, and their corners have another order in the second
# frame.
_ROW = ((0, 0), (10, 0), (20, 0))
_CALLS = {
    "moved": (2.0, (*_ROW, (30, 0)), ((20, 1.15), (0, 1.1), (30, 1.2), (10, 1.25)), (2, 0, 3, 1)),
    "rivals": (1.9, _ROW, ((10.9, 0.8), (10.2, 0), (20.8, 0), (40, 0)), (-1, 1, 2, -1)),
    "crowd": (1.7, ((0, 0),), ((1.2, 0), (0.2, 0), (0, 0.9)), (-1, 0, -1)),
    "merge": (1.6, ((1.2, 0), (0.2, 0), (0, -0.9)), ((0, 0),), (1,)),
    "between": (1.4, ((0, 0), (1.1, 0), (10, 0)), ((0.4, 0), (10.3, 0)), (0, 2)),
    "far": (3.0, _ROW, ((20, 2.5), (0, 0.8), (10, 6)), (2, 0, -1)),
    "small": (0.5, _ROW, ((0, 0.6), (20, 0.3), (10, 0.45)), (-1, 2, 1)),
    "near": (1.3, _ROW[:2], ((10, 1.2), (0, 1.25)), (1, 0)),
    "chain": (1.8, ((0, 0), (4, 0)), ((3.2, 0), (7.2, 0)), (1, -1)),
    "gap": (2.5, ((0, 0), (4, 0), (20, 0)), ((7, 0), (3.1, 0)), (-1, 1)),
    "diagonal": (1.0, ((0, 0), (10, 0)), ((0.8, -0.8), (10.3, 0)), (-1, 1)),
}


def _arguments_of(name: str) -> tuple[np.ndarray, np.ndarray, float]:
    limit, before, after, _ = _CALLS[name]
    size, turn = (4.0, 2) if name in ("far", "near") else (1.0, 0)
    return cubes(before, size), cubes(after, size, turn), limit


def _right_partners(previous: np.ndarray, current: np.ndarray, max_distance: float) -> np.ndarray:
    return next(np.array(call[3]) for call in _CALLS.values() if call[0] == max_distance)


def _prediction_with_answers(**answers: tuple) -> Callable:
    """Return a prediction: these answers for the named calls, the right answer for all others."""
    by_limit = {_CALLS[name][0]: np.array(answer) for name, answer in answers.items()}
    return lambda right, previous, current, max_distance: by_limit.get(max_distance, right)


def _invert(
    right: np.ndarray, previous: np.ndarray, current: np.ndarray, max_distance: float
) -> np.ndarray:
    """Return the partner of each previous box instead of the partner of each current box."""
    partners = np.full(len(previous), -1)
    has_partner = right >= 0
    partners[right[has_partner]] = np.flatnonzero(has_partner)
    return partners


def _match_corner_means(
    right: np.ndarray, previous: np.ndarray, current: np.ndarray, max_distance: float
) -> np.ndarray:
    """Match boxes by eight numbers, the mean of x, y and z of each corner, not by the centre."""
    table = np.linalg.norm(current.mean(axis=2)[:, None] - previous.mean(axis=2), axis=2)
    partners = np.full(len(current), -1)
    while table.min() <= max_distance:
        row, column = np.unravel_index(table.argmin(), table.shape)
        partners[row] = column
        table[row, :] = table[:, column] = np.inf
    return partners


def _closest_pair_only(
    right: np.ndarray, previous: np.ndarray, current: np.ndarray, max_distance: float
) -> np.ndarray:
    """Keep only the closest pair of the right answer."""
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1), axis=2)
    closest = table.min(axis=1)
    is_closest = (closest == closest.min()) & (closest <= max_distance)
    return np.where(is_closest, right, -1)


declare_mistakes(
    "match_boxes",
    Mistake(
        "The function matches only the closest pair and ignores all other boxes.",
        _closest_pair_only,
        "Write a `while` loop that runs as long as a pair is close enough, and return after the "
        "loop.",
    ),
    Mistake(
        "Each current box takes the nearest previous box that is close enough, even if that box "
        "has a nearer partner.",
        _prediction_with_answers(rivals=(1, 1, 2, -1), crowd=(0, 0, 0)),
        "After each pair, set table[row, :] and table[:, column] to np.inf.",
    ),
    Mistake(
        "The first current box in the list takes the partner, even if a later box is nearer.",
        _prediction_with_answers(rivals=(1, -1, 2, -1), crowd=(0, -1, -1)),
        "Take the closest of all pairs first.",
    ),
    Mistake(
        "The function ignores max_distance and pairs boxes as long as both lists have free boxes.",
        _prediction_with_answers(
            rivals=(0, 1, 2, -1),
            far=(2, 0, 1),
            small=(0, 2, 1),
            chain=(1, 0),
            gap=(0, 1),
            diagonal=(0, 1),
        ),
        "Stop at the first pair that is farther apart than max_distance.",
    ),
    Mistake(
        "Each current box takes the nearest previous box, however far away it is and even if it "
        "has a partner.",
        _prediction_with_answers(
            rivals=(1, 1, 2, 2),
            crowd=(0, 0, 0),
            far=(2, 0, 1),
            small=(0, 2, 1),
            chain=(1, 1),
            gap=(1, 1),
            diagonal=(0, 1),
        ),
        "Compare the distance with max_distance, and set the row and the column of each pair to "
        "np.inf.",
        is_cheap=True,
    ),
    Mistake(
        "Each previous box takes the nearest current box, however far away it is, because the "
        "function ignores max_distance.",
        _prediction_with_answers(
            merge=(2,),
            between=(1, 2),
            far=(2, 0, 1),
            small=(0, 2, 1),
            gap=(2, 1),
            diagonal=(0, 1),
        ),
        "Accept a pair only if it is not farther apart than max_distance.",
    ),
    Mistake(
        "The code first finds the pairs with the smallest total distance and then drops the pairs "
        "that are too far apart. A dropped pair may have replaced a pair that is close enough.",
        _prediction_with_answers(chain=(-1, -1), gap=(-1, -1)),
        "Before you call linear_sum_assignment, replace each distance that is too large with a "
        "huge number.",
    ),
    Mistake(
        "A box that already has a partner gets a second, farther partner, because its row is not "
        "crossed out.",
        _prediction_with_answers(merge=(0,), between=(1, 2)),
        "After each pair, also set table[row, :] to np.inf, not only the column.",
    ),
    Mistake(
        "The function compares the square of the distance with max_distance.",
        _prediction_with_answers(far=(-1, 0, -1), small=(0, 2, 1), near=(-1, -1)),
        "Take the square root, or use np.linalg.norm.",
    ),
    Mistake(
        "The function uses a fixed limit, whatever max_distance is.",
        _prediction_with_answers(far=(-1, 0, -1), small=(0, 2, 1), diagonal=(0, 1)),
        "Compare with the parameter max_distance.",
    ),
    Mistake(
        "The answer is the wrong way round: it says for each previous box which current box it "
        "became.",
        _invert,
        "Return one entry for each current box. The entries are rows of previous.",
    ),
    Mistake(
        "The function matches box k of one frame with box k of the other.",
        lambda right, previous, current, max_distance: np.where(
            np.arange(len(current)) < len(previous), np.arange(len(current)), -1
        ),
        "Compare the centres of the boxes, because boxes may come in any order.",
        is_cheap=True,
    ),
    Mistake(
        "No box gets a partner: every entry is -1.",
        lambda right, *case: np.full(len(right), -1),
        is_cheap=True,
    ),
    Mistake(
        "A box without a partner gets 0, which is the index of a previous box.",
        lambda right, *case: np.where(right < 0, 0, right),
        "Start from np.full(len(current), -1).",
    ),
    Mistake(
        "The function takes the mean over x, y and z of each corner, not over the eight corners "
        "of each box.",
        _match_corner_means,
        "Use boxes.mean(axis=1), which returns one centre (x, y, z) for each box. axis=2 mixes x, "
        "y and z.",
    ),
    Mistake(
        "The function compares corners, not centres. In the next frame, the corners of a box may "
        "be in another order.",
        _prediction_with_answers(far=(-1, -1, -1), near=(-1, -1)),
        "Compare the centres, boxes.mean(axis=1).",
    ),
    cases=tuple(_arguments_of(name) for name in _CALLS),
    right=_right_partners,
)


def _draw_matches(
    previous: np.ndarray, current: np.ndarray, yours: np.ndarray, expected: np.ndarray
) -> None:
    axes = utils.plots.boxes(previous, reference=True, names=True, label="previous")
    if len(current):
        corners = np.vstack([previous, current])[:, :, :2].reshape(-1, 2)
        axes.set_xlim(corners[:, 0].min() - 2, corners[:, 0].max() + 2)
        axes.set_ylim(corners[:, 1].min() - 2, corners[:, 1].max() + 2)
        utils.plots.boxes(
            current,
            names=True,
            label="current",
            axes=axes,
            title="Solid lines: your pairs"
            + ("; dotted lines: the right pairs" if len(expected) else ""),
        )
    chosen = np.nan_to_num(yours, nan=-1).astype(int)
    for pairs, style, width in ((expected, ":", 4.0), (chosen, "-", 1.5)):
        for index, partner in enumerate(pairs):
            if 0 <= partner < len(previous):
                ends = np.stack([previous[partner], current[index]])[:, :, :2].mean(axis=1)
                axes.plot(*ends.T, style, color="black", linewidth=width)
