"""Visible checks of `match_boxes`: further properties are judged only if boxes are matched."""

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
    brief,
    frozen,
    needs,
)
from utils.checks.common_checks import Case
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.failures import fixed
from utils.checks.run_cache import once


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


# Four boxes, far from each other, that move by half a metre and come back in another order.
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
        If the answer contains None, holds truth values or has another shape.
    """
    if isinstance(answer, (list, tuple)) and any(entry is None for entry in answer):
        raise WrongForm(
            fixed("None is no index: a box without a partner gets -1."),
            yours=brief(answer),
            expected="whole numbers from -1 up",
        )
    yours = as_array(answer, what="an array of indices")
    if yours.size == 0 and not len(current):
        return np.empty(0)
    if yours.shape == (len(current),) and yours.dtype.kind != "b":
        return yours
    message = ""
    if yours.dtype.kind == "b":
        message = " This is a mask, True or False."
    elif yours.shape == (len(current), len(previous)):
        message = " This has the shape of a table of all pairs: which column does each row choose?"
    elif yours.shape == (len(previous),):
        message = f" There are {len(previous)}, one for each previous box."
    elif yours.ndim == 2 and yours.shape[1] == 2:
        message = (
            " If these are pairs: the second number of each belongs at the place that the first "
            "one names."
        )
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
    look_at: ArrayLike | slice = slice(None),
    given: str | None = None,
) -> None:
    """Assert that the answer has the index of the right previous box for each current box.

    Parameters
    ----------
    answer : object
    expected : array_like of int, shape (N_current,)
        Index of the previous box, or -1 for a new box.
    previous, current : numpy.ndarray, shape (N, 8, 3)
    look_at : array_like or slice
        Rows of the current boxes to compare; by default all.
    given : str, optional
        Other arguments of the function as text, for the message.
    """
    expected = np.asarray(expected, dtype=int).ravel()
    yours = as_indices(answer, previous, current)
    compared = np.arange(len(expected))[look_at]
    wrong = compared[yours[compared] != expected[compared]]
    if not len(wrong):
        return
    first = wrong[0]
    if expected[first] < 0:
        message = f"Current box {first} has no partner, and is not marked as new."
    elif yours[first] not in range(-1, len(previous)):
        message = (
            f"Current box {first} gets {yours[first]:g}, which is no row of previous: there are "
            f"{len(previous)}."
        )
    else:
        message = f"Current box {first} was previous box {expected[first]}."
    raise CheckFailed(
        message,
        given=_centres_text(previous, current, given),
        yours=brief(yours),
        expected=brief(expected),
        hint=_SWAPPED_HINT if _is_inverse(yours, expected) else "",
        draw=functools.partial(_draw_matches, previous, current, yours, expected),
    )


_SWAPPED_HINT = (
    "Read the other way round, your pairs are right: entry k of yours says which current box "
    "previous box k became. answer[row] = column, where rows are current and columns previous."
)


def _is_inverse(yours: np.ndarray, expected: np.ndarray) -> bool:
    """Return whether an answer has the right pairs, with current and previous swapped."""
    indices = np.arange(len(expected))
    return np.array_equal(np.sort(expected), indices) and np.array_equal(
        yours, np.argsort(expected)
    )


def assert_one_to_one(
    answer: object, previous: np.ndarray, current: np.ndarray, given: str | None = None
) -> None:
    """Assert that no previous box has two partners, whether these are right or wrong.

    Parameters
    ----------
    answer : object
    previous, current : numpy.ndarray, shape (N, 8, 3)
    given : str, optional
        Other arguments of the function as text, for the message.
    """
    yours = as_indices(answer, previous, current)
    partners, counts = np.unique(yours[yours >= 0], return_counts=True)
    if (counts > 1).any():
        shared = partners[counts > 1][0]
        owners = np.flatnonzero(yours == shared)
        raise CheckFailed(
            f"Previous box {shared:.0f} is given to several current boxes, for example to "
            f"{owners[0]} and {owners[1]}.",
            given=_centres_text(previous, current, given),
            yours=brief(yours),
            draw=functools.partial(_draw_matches, previous, current, yours, np.empty(0)),
        )


def assert_limit_respected(
    answer: object,
    expected: ArrayLike,
    previous: np.ndarray,
    current: np.ndarray,
    max_distance: float,
) -> None:
    """Assert that close boxes are partners, and that others have no partner.

    Any negative number counts as no partner, because another check asks for -1.

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
            f"There is no previous box, and current box {first} has a partner.", yours=brief(yours)
        )
    gap = np.linalg.norm(previous.mean(axis=1) - current[first].mean(axis=0), axis=1).min()
    text = "it has no partner" if expected[first] < 0 else "that is its partner"
    raise CheckFailed(
        f"Current box {first} is {gap:.2f} m from the nearest previous box, and max_distance is "
        f"{max_distance:g} m: {text}.",
        given=_centres_text(previous, current, f"max_distance {max_distance:g}"),
        yours=brief(yours),
        expected=brief(expected),
        draw=functools.partial(_draw_matches, previous, current, yours, expected),
    )


@once
def require_matching(match_boxes: Callable) -> None:
    """Assert that boxes are found again after a small move; raise `NotYet` if not."""
    with needs("boxes are found again after a small move"):
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


@visible(
    "match_boxes",
    weight=4,
    title="Finds each box again after a small move, in whatever order the boxes come",
    why="Clusters are numbered anew in every frame; without names nobody knows who moved where.",
    hint="The centre of a box is the mean of its corners. Make a table of all distances "
    "between current and previous centres; the smallest entry is a pair.",
)
def finds_again(match_boxes: Callable) -> None:
    answer = match_boxes(_BEFORE.copy(), _AFTER.copy(), 1.5)
    assert_matched(answer, _ORDER, _BEFORE, _AFTER, given="max_distance 1.5")


@visible(
    "match_boxes",
    weight=2,
    title="A box without a partner is new: -1",
    why="Somebody steps out from behind a lorry. They must not inherit the name of the lorry.",
    hint="Start from an array full of -1, as long as current, and write into it.",
)
def marks_new_ones(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    previous, current = cubes([[4, 1], [9, -3]]), cubes([[20, 5], [9.4, -3], [4, 1.5], [-9, 0]])
    answer = match_boxes(previous.copy(), current.copy(), 1.5)
    assert_matched(answer, [-1, 1, 0, -1], previous, current, [0, 3], "max_distance 1.5")


@visible(
    "match_boxes",
    weight=6,
    title="Boxes farther apart than max_distance are no partners",
    why="A name that jumps to somebody far away gives them a speed that they do not have.",
    hint="Compare the distance itself, as np.linalg.norm gives it, with max_distance before you "
    "accept a pair.",
)
def ends_at_the_limit(match_boxes: Callable) -> None:
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


@visible(
    "match_boxes",
    weight=10,
    title="One to one: two boxes never get the same partner",
    why="Two cars under one name are one car to the planner.",
    hint="Once a pair is chosen, strike out its row and its column: neither is free any more.",
)
def is_one_to_one(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    # The nearer current box comes first, then last. No current box is near previous box 0.
    previous, current = cubes([[-20, 0], [5, 0]]), cubes([[5.2, 0], [6.2, 0.3]])
    for ordered in (current, current[::-1]):
        answer = match_boxes(previous.copy(), ordered.copy(), 2.0)
        assert_one_to_one(answer, previous, ordered, "max_distance 2")


@visible(
    "match_boxes",
    weight=4,
    title="Of two that want the same partner the nearer one gets it",
    why="The name goes to whoever happens to stand first in the list, and cars swap names.",
    hint="Take the closest of all pairs first. Going through the current boxes in their order "
    "gives the partner to whoever comes first.",
)
def prefers_the_nearer(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    previous, current = cubes([[-20, 0], [5, 0]]), cubes([[6.2, 0.3], [5.2, 0]])
    answer = match_boxes(previous.copy(), current.copy(), 2.0)
    assert_matched(answer, [-1, 1], previous, current, [1], "max_distance 2")


@visible(
    "match_boxes",
    weight=2,
    title="A box with two earlier ones near by was the nearer of them",
    why="Where a car and a post stood side by side, the car keeps its name, and its speed.",
    hint="Strike out the row of a pair, too: a box that has its partner takes no second one.",
)
def takes_the_nearer(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    previous, current = cubes([[6.3, 0.4], [5, 0]]), cubes([[5.2, 0]])
    answer = match_boxes(previous.copy(), current.copy(), 2.0)
    assert_matched(answer, [1], previous, current, given="max_distance 2")


@visible(
    "match_boxes",
    weight=6,
    title="Goes by the centres: the corners of a box may start elsewhere",
    why="A car that turns, or shows more of itself, gets a box with other corners.",
    hint="The centre is the mean over all eight corners: boxes.mean(axis=1).",
)
def goes_by_the_centres(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    previous = cubes([[4, 1], [15, 2], [-8, -4]], 2.0)
    current = cubes([[15.2, 2], [-8, -4.3], [4.1, 1]], 2.0, turn=2)
    answer = match_boxes(previous.copy(), current.copy(), 1.0)
    assert_matched(answer, [1, 2, 0], previous, current, given="max_distance 1")


@visible(
    "match_boxes",
    weight=3,
    title="Takes no boxes on either side",
    why="The first frame has no frame before it, and an empty road has no boxes.",
    hint="argmin of an empty table is an error: return early, an array of -1 as long as current.",
)
def takes_no_boxes(match_boxes: Callable) -> None:
    require_matching(match_boxes)
    boxes, no_boxes = cubes([[4, 1], [9, -3]]), np.empty((0, 8, 3))
    far = cubes([[40, 7]])
    [marker] = as_indices(match_boxes(boxes.copy(), far.copy(), 2.0), boxes, far)
    for previous, current in ((no_boxes, boxes), (boxes, no_boxes), (no_boxes, no_boxes)):
        answer = match_boxes(previous.copy(), current.copy(), 2.0)
        assert_limit_respected(answer, np.full(len(current), -1), previous, current, 2.0)
        yours = as_indices(answer, previous, current)
        # Skip functions with another marker for new boxes: the check that asks for -1 reports them.
        if marker == -1 and not (yours == marker).all():
            raise CheckFailed(
                "Without a previous box each current one is new, and is not marked as new.",
                given=f"{len(previous)} previous and {len(current)} current boxes",
                yours=brief(yours),
                expected=brief(np.full(len(current), -1)),
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
common_checks.names(
    _MOVED_CASE,
    "keeps_the_names",
    why="Whoever writes match_boxes(before, after, max_distance=1.5) relies on them.",
)
common_checks.untouched(
    _MOVED_CASE,
    "leaves_the_boxes",
    why="The boxes of this frame are the previous ones of the next.",
    hint="Put infinity into a table of your own, and nothing into the boxes.",
)


@noted(
    "match_boxes",
    title="Indices are whole numbers",
    why="The tracker, below, looks names up with them, and 2.0 is no index.",
)
def has_whole_indices(match_boxes: Callable) -> None:
    dtype = as_array(match_boxes(_BEFORE.copy(), _AFTER.copy(), 1.5)).dtype
    if dtype.kind not in "iu":
        raise CheckFailed(f"The indices are of type {dtype}.")


# Eleven small calls that distinguish the usual mistakes: max_distance, previous centres (x, y),
# current centres and the right partners. Each call has a different max_distance, which identifies
# it. In "far" and "near" boxes are large, and their corners start elsewhere in the second frame.
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
    "askew": (1.0, ((0, 0), (10, 0)), ((0.8, -0.8), (10.3, 0)), (-1, 1)),
}


def _arguments_of(name: str) -> tuple[np.ndarray, np.ndarray, float]:
    limit, before, after, _ = _CALLS[name]
    size, turn = (4.0, 2) if name in ("far", "near") else (1.0, 0)
    return cubes(before, size), cubes(after, size, turn), limit


def _right_partners(previous: np.ndarray, current: np.ndarray, max_distance: float) -> np.ndarray:
    return next(np.array(call[3]) for call in _CALLS.values() if call[0] == max_distance)


def _right_except(**answers: tuple) -> Callable:
    """Return a prediction that gives these answers for the named calls, else the right answer."""
    by_limit = {_CALLS[name][0]: np.array(answer) for name, answer in answers.items()}
    return lambda right, previous, current, max_distance: by_limit.get(max_distance, right)


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


mistakes(
    "match_boxes",
    Mistake(
        "A single pair is made, the closest of all. The other boxes are not looked at.",
        _closest_pair_only,
        "Go on with while as long as a pair is close enough, and return behind the loop.",
    ),
    Mistake(
        "Each current box takes the nearest previous one that is close enough, also where that "
        "one has a nearer partner.",
        _right_except(rivals=(1, 1, 2, -1), crowd=(0, 0, 0)),
        "Once a pair is chosen, strike out its row and its column.",
    ),
    Mistake(
        "Whichever current box comes first in the list takes the partner, also where a later one "
        "is nearer.",
        _right_except(rivals=(1, -1, 2, -1), crowd=(0, -1, -1)),
        "Take the closest of all pairs first.",
    ),
    Mistake(
        "max_distance is not looked at: pairs are made as long as there are boxes on both sides.",
        _right_except(
            rivals=(0, 1, 2, -1),
            far=(2, 0, 1),
            small=(0, 2, 1),
            chain=(1, 0),
            gap=(0, 1),
            askew=(0, 1),
        ),
        "Stop at the first pair that is farther apart than max_distance.",
    ),
    Mistake(
        "Each current box takes the nearest previous one, however far it is and whoever else has "
        "it.",
        _right_except(
            rivals=(1, 1, 2, 2),
            crowd=(0, 0, 0),
            far=(2, 0, 1),
            small=(0, 2, 1),
            chain=(1, 1),
            gap=(1, 1),
            askew=(0, 1),
        ),
        "Compare with max_distance, and strike out the row and the column of each pair.",
    ),
    Mistake(
        "Each previous box takes the nearest current one, however far it is: max_distance is not "
        "looked at.",
        _right_except(
            merge=(2,),
            between=(1, 2),
            far=(2, 0, 1),
            small=(0, 2, 1),
            gap=(2, 1),
            askew=(0, 1),
        ),
        "Accept a pair only if it is not farther apart than max_distance.",
    ),
    Mistake(
        "The best sum is sought among all pairs, and those too far apart are dropped only then: "
        "one of them may have taken the place of one that is near enough.",
        _right_except(chain=(-1, -1), gap=(-1, -1)),
        "Before linear_sum_assignment write a huge number where a distance is too large.",
    ),
    Mistake(
        "A box that has its partner gets another, farther one later: its row is not struck out.",
        _right_except(merge=(0,), between=(1, 2)),
        "After each pair put infinity into table[row, :], not into the column alone.",
    ),
    Mistake(
        "The square of the distance is compared with max_distance.",
        _right_except(far=(-1, 0, -1), small=(0, 2, 1), near=(-1, -1)),
        "Take the root, or let np.linalg.norm do it.",
    ),
    Mistake(
        "A fixed distance decides, whatever max_distance is.",
        _right_except(far=(-1, 0, -1), small=(0, 2, 1), askew=(0, 1)),
        "Compare with max_distance, by its name.",
    ),
    Mistake(
        "The answer is the wrong way round: it says for each previous box which current one it "
        "became.",
        _right_except(
            moved=(1, 3, 0, 2),
            rivals=(-1, 1, 2),
            crowd=(1,),
            merge=(-1, 0, -1),
            between=(0, -1, 1),
            far=(1, -1, 0),
            small=(-1, 2, 1),
            chain=(-1, 0),
            gap=(-1, 1, -1),
        ),
        "One entry for each current box; the entries are rows of previous.",
    ),
    Mistake(
        "Box k of the one frame is taken for box k of the other.",
        lambda right, previous, current, max_distance: np.where(
            np.arange(len(current)) < len(previous), np.arange(len(current)), -1
        ),
        "Boxes come in any order: compare their centres.",
        is_cheap=True,
    ),
    Mistake(
        "No box gets a partner: every entry is -1.",
        lambda right, *case: np.full(len(right), -1),
        is_cheap=True,
    ),
    Mistake(
        "0 stands where a box has no partner. That is the index of a previous box.",
        lambda right, *case: np.where(right < 0, 0, right),
        "Start from np.full(len(current), -1).",
    ),
    Mistake(
        "The mean is taken over x, y and z of each corner, and not over the eight corners of each "
        "box.",
        _match_corner_means,
        "boxes.mean(axis=1) is one centre (x, y, z) for each box; axis=2 would mix x with y.",
    ),
    Mistake(
        "Corners are compared, one or all of them, and not centres. Another box may start its "
        "corners elsewhere.",
        _right_except(far=(-1, -1, -1), near=(-1, -1)),
        "Compare the centres: the mean of all eight corners.",
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
            title="Solid lines: your pairs" + ("; dotted: the right ones" if len(expected) else ""),
        )
    chosen = np.nan_to_num(yours, nan=-1).astype(int)
    for pairs, style, width in ((expected, ":", 4.0), (chosen, "-", 1.5)):
        for index, partner in enumerate(pairs):
            if 0 <= partner < len(previous):
                ends = np.stack([previous[partner], current[index]])[:, :, :2].mean(axis=1)
                axes.plot(*ends.T, style, color="black", linewidth=width)
