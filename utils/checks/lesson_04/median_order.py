"""Visible checks of `median_order`."""

from collections.abc import Callable, Iterator

import numpy as np

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
from utils.checks.core import visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.failures import fixed
from utils.checks.lesson_04.cases import QUIZ, distinct_points
from utils.checks.lesson_04.trees import few_points_text
from utils.checks.run_cache import once
from utils.geometry import grown, in_turn, places_of

_SHORT_HINT = (
    "All rows before the median and all rows after it wait as parts, and each part that waits has "
    "its turn: one without rows is skipped, and ends nothing."
)
# With 7 or 15 points every part has a single middle point.
_SEVEN_POINTS = frozen(distinct_points(np.random.default_rng(51), 7, 2))


def as_order(answer: object, n: int) -> np.ndarray:
    """Convert an answer to a permutation of range(n).

    Returns
    -------
    numpy.ndarray of int, shape (n,)
    """
    order = as_array(answer, what="a list of row numbers")
    if order.size == 0:
        order = order.astype(int).ravel()
    if order.ndim != 1 or order.dtype.kind not in "iu":
        raise WrongForm(
            "The order is a flat list of row numbers (whole numbers), not of points.",
            yours=brief(order),
            expected=f"the numbers 0 to {n - 1}",
        )
    invalid = [row for row in order.tolist() if not 0 <= row < n]
    missing = [row for row in range(n) if row not in set(order.tolist())]
    if invalid or missing or len(order) != n:
        problem = (
            f"{invalid[0]} is no row number" if invalid else "some rows are there more than once"
        )
        text = f"row {missing[0]} is missing" if missing else problem
        is_short = not invalid and len(order) == n - len(missing)
        raise CheckFailed(
            fixed("Each row number from 0 to n - 1 must occur exactly once; ") + f"{text}.",
            yours=brief(order),
            expected=f"each of 0 to {n - 1}" if n > 1 else "[0]" if n else "[]",
            hint=_SHORT_HINT if is_short else "",
        )
    return order


def _order_of(answer: object, points: np.ndarray) -> np.ndarray:
    with needs("each row is named exactly once"):
        return as_order(answer, len(points))


def assert_shallow(answer: object, points: np.ndarray) -> None:
    """Assert that inserting points in this order gives a tree of the least depth.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 2) or (n, 3)
    """
    order = _order_of(answer, points)
    root = grown(points[order], order.tolist())
    depth, least = max(map(len, places_of(root)), default=-1) + 1, len(points).bit_length()
    if depth > least:
        raise CheckFailed(
            f"Inserted in this order, {len(points)} points give a tree of depth "
            f"{depth}; medians give {least}.",
            given=few_points_text(points),
            yours=f"depth {depth}",
            expected=f"depth {least}",
            draw=_draw_tree(order, points),
        )


def assert_lower_medians(answer: object, points: np.ndarray) -> None:
    """Assert that the lower median along its axis comes first in every part.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 2) or (n, 3)
    """
    order = _order_of(answer, points)
    wrong_part = next(_wrong_parts(points, order), None)
    if wrong_part is None:
        return
    values, depth, axis, median = wrong_part
    letter = "xyz"[axis]
    point = "The first point of the order"
    if depth:
        point = f"In a part at depth {depth}, the point that comes first"
    raise CheckFailed(
        f"{point} is not the {'lower ' * (len(values) % 2 == 0)}median of the {len(values)} points "
        f"along {letter}.",
        given=f"{letter} of these points, sorted: {_list_text(np.sort(values))}",
        yours=f"{letter} = {values[0]:g}",
        expected=f"{letter} = {median:g}",
        draw=_draw_tree(order, points),
    )


def _wrong_parts(
    points: np.ndarray,
    order: np.ndarray,
    axis_at: Callable[[int, int], int] = in_turn,
    place: Callable[[int], int] = lambda m: (m - 1) // 2,
    deeper: tuple[int, int] = (1, 1),
) -> Iterator[tuple]:
    """Yield every part whose first point is not the expected one.

    Parameters
    ----------
    points : numpy.ndarray, shape (n, k)
    order : numpy.ndarray of int, shape (n,)
    axis_at : callable
        Takes a depth and the number of coordinates; returns the axis.
    place : callable
        Takes the number of points in a part; returns the place of the expected one among them,
        sorted along the axis.
    deeper : tuple of int
        Growth of the depth for the smaller points and for the others.

    Yields
    ------
    tuple
        The coordinates of the part along the axis in the order of the rows, its depth, the axis,
        and the coordinate that should come first.
    """
    pending = [(order, 0)] if len(order) else []
    for rows, depth in pending:  # the list grows inside the loop
        axis = axis_at(depth, points.shape[1])
        values = np.asarray(points, dtype=float)[rows, axis]
        wanted = np.sort(values)[place(len(values))]
        if values[0] != wanted:
            yield values, depth, axis, wanted
        smaller = values[1:] < values[0]
        parts = rows[1:][smaller], rows[1:][~smaller]
        pending += [
            (part, depth + growth) for part, growth in zip(parts, deeper, strict=True) if len(part)
        ]


# The right sequence of axes, and wrong ones along which a function may still halve every part.
_AXIS_RULES = (
    in_turn,
    lambda depth, k: 0,
    lambda depth, k: 1,
    lambda depth, k: (depth + 1) % k,
    lambda depth, k: depth % 2,
)


def assert_halves(answer: object, points: np.ndarray) -> None:
    """Assert that the lower median comes first in every part, along any sequence of axes.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 2) or (n, 3)
    """
    order = _order_of(answer, points)
    if all(next(_wrong_parts(points, order, axis_at), None) for axis_at in _AXIS_RULES):
        assert_lower_medians(order, points)


def _list_text(values: np.ndarray) -> str:
    return ", ".join(f"{value:g}" for value in values[:8]) + ", ..." * (len(values) > 8)


def _draw_tree(order: np.ndarray, points: np.ndarray) -> Callable:
    root = grown(points[order], order.tolist())
    return lambda: utils.plots.kd_tree(root, title="The tree of your order")


@once
def _assert_medians(median_order: Callable) -> None:
    with needs("the median of x, then of y comes first in every part"):
        assert_lower_medians(median_order(_SEVEN_POINTS.copy()), _SEVEN_POINTS)


@once
def _assert_halves(median_order: Callable) -> None:
    with needs("the median comes first in every part"):
        assert_halves(median_order(_SEVEN_POINTS.copy()), _SEVEN_POINTS)


@visible(
    "median_order",
    weight=2,
    title="Names every row exactly once",
    why="A point that is left out is an obstacle that no search will find.",
    hint="np.argsort of a part gives places within the part: rows[np.argsort(...)] leads back to "
    "row numbers. The median goes into the order, and into neither of the two parts that wait.",
)
def names_every_row(median_order: Callable) -> None:
    for points in (QUIZ[:5], _SEVEN_POINTS):
        as_order(median_order(points.copy()), len(points))


@visible(
    "median_order",
    weight=3,
    title="Starts with the median along x",
    why="Only a median halves: any other first point leaves more on one side.",
    hint="Sort the rows by x. Of m rows, the one in the middle stands at place (m - 1) // 2.",
)
def starts_with_the_median(median_order: Callable) -> None:
    for points in (QUIZ[[5, 0, 8]], QUIZ[:3], QUIZ[[6, 9, 1, 7, 3]], _SEVEN_POINTS):
        order = _order_of(median_order(points.copy()), points)
        x, median = points[order[0], 0], np.median(points[:, 0])
        if x != median:
            raise CheckFailed(
                "The first point of the order is not the median along x.",
                given=f"x of the {len(points)} points, sorted: {_list_text(np.sort(points[:, 0]))}",
                yours=f"x = {x:g}",
                expected=f"x = {median:g}",
            )


@visible(
    "median_order",
    weight=4,
    title="The median comes first in every part, before both halves",
    why="One bad split near the root doubles the work of every search below it.",
    hint="A part gives its median to the order and two parts that wait: the rows before it and "
    "the rows after it.",
)
def halves_every_part(median_order: Callable) -> None:
    rng = np.random.default_rng(47)
    for n in (3, 7, 15):
        points = distinct_points(rng, n, 2)
        assert_halves(median_order(points.copy()), points)


@visible(
    "median_order",
    weight=3,
    title="The median is that of x at first, then of y, then of x again",
    why="insert compares x and y in turn. A median of the other one halves nothing.",
    hint="The parts of one level are sorted along another axis: depth % points.shape[1].",
)
def takes_turns(median_order: Callable) -> None:
    _assert_halves(median_order)
    rng = np.random.default_rng(42)
    for n in (3, 7, 15):
        points = distinct_points(rng, n, 2)
        assert_lower_medians(median_order(points.copy()), points)


@visible(
    "median_order",
    weight=2,
    title="Of two in the middle, the lower one comes first",
    why="The same points should make the same tree for everyone.",
    hint="Of m sorted rows the lower median stands at place (m - 1) // 2; m // 2 is the upper "
    "one when m is even.",
)
def takes_the_lower(median_order: Callable) -> None:
    _assert_medians(median_order)
    rng = np.random.default_rng(43)
    for n in (2, 4, 6):
        points = distinct_points(rng, n, 2)
        assert_lower_medians(median_order(points.copy()), points)


@visible(
    "median_order",
    weight=2,
    title="Takes points with three coordinates: x, y, z and x again",
    why="A street is three-dimensional.",
    hint="Count the coordinates with points.shape[1] and do not write 2 into the function.",
)
def takes_three_axes(median_order: Callable) -> None:
    _assert_medians(median_order)
    points = distinct_points(np.random.default_rng(44), 31, 3)
    assert_lower_medians(median_order(points.copy()), points)


@visible(
    "median_order",
    weight=3,
    title="The tree has the least depth possible",
    why="Depth is the price of every insertion and every search: 17 levels for a hundred "
    "thousand points, or a hundred thousand.",
    hint="Print the depth of the tree of your order for 3, 7 and 15 points: it should be 2, 3 "
    "and 4.",
)
def least_depth(median_order: Callable) -> None:
    rng = np.random.default_rng(45)
    for n in (3, 7, 15, 40, 64):
        points = distinct_points(rng, n, 2)
        assert_shallow(median_order(points.copy()), points)


@visible(
    "median_order",
    weight=1,
    title="Takes no points, and one point",
    why="Filters leave nothing now and then.",
    hint="A part without rows adds nothing to the order.",
)
def takes_the_smallest(median_order: Callable) -> None:
    _assert_halves(median_order)
    as_order(median_order(np.empty((0, 2))), 0)
    as_order(median_order(np.array([[1.0, 2.0, 3.0]])), 1)


@visible(
    "median_order",
    weight=1,
    title="Takes points with equal coordinates",
    why="Recordings hold the same point twice, and walls the same coordinate many times.",
    hint="Part the sorted rows by their place, before and after the median, not by comparing "
    "coordinates.",
)
def takes_equal_points(median_order: Callable) -> None:
    _assert_halves(median_order)
    for points in (np.ones((5, 2)), np.repeat(QUIZ[:4], 3, axis=0)):
        as_order(median_order(points.copy()), len(points))


common_checks.untouched(
    Case(
        __name__,
        "median_order",
        {"points": QUIZ},
        expected=None,  # `assert_halves` computes it
        compare=lambda answer, points, _: assert_halves(answer, points),
        precondition=_assert_halves,
    ),
    "leaves_its_input",
    why="The order names rows of the cloud as it was: sorting the cloud makes it a lie.",
    hint="Sort row numbers, not points.",
)


def _begins_every_part(**rule: Callable) -> Callable:
    """Return a prediction: every part of the order begins with the point that a rule names."""
    return lambda *_: lambda points, order: next(_wrong_parts(points, order, **rule), None) is None


def _median_between_parts(points: np.ndarray, order: np.ndarray) -> bool:
    """Return whether the median is between its two parts, in every part."""
    pending = [(order, 0)]
    for rows, depth in pending:  # the list grows inside the loop
        middle = (len(rows) - 1) // 2
        values = points[rows, depth % points.shape[1]]
        before, after = values[:middle], values[middle + 1 :]
        if not (before < values[middle]).all() or not (after > values[middle]).all():
            return False
        parts = rows[:middle], rows[middle + 1 :]
        pending += [(part, depth + 1) for part in parts if len(part)]
    return True


mistakes(
    "median_order",
    Mistake(
        "Of two points in the middle, the upper one comes first.",
        _begins_every_part(place=lambda m: m // 2),
        "The lower one stands at place (number of rows - 1) // 2 of the rows from the smallest to "
        "the largest.",
    ),
    Mistake(
        "x decides in every part: the axis does not change from level to level.",
        _begins_every_part(axis_at=lambda depth, k: 0),
        "The axis is depth % points.shape[1], and a part's parts have depth + 1.",
    ),
    Mistake(
        "The turns begin with y.",
        _begins_every_part(axis_at=lambda depth, k: (depth + 1) % k),
        "The first part has depth 0: x.",
    ),
    Mistake(
        "x and y take turns and z is left out: 2 is written where points.shape[1] is needed.",
        _begins_every_part(axis_at=lambda depth, k: depth % 2),
    ),
    Mistake(
        "The rows before a median are sorted along the axis of the median itself: their depth "
        "does not grow.",
        _begins_every_part(deeper=(0, 1)),
        "Both parts wait with depth + 1.",
    ),
    Mistake(
        "The rows after a median are sorted along the axis of the median itself: their depth does "
        "not grow.",
        _begins_every_part(deeper=(1, 0)),
        "Both parts wait with depth + 1.",
    ),
    Mistake(
        "The rows are sorted by x, and that is all.",
        _begins_every_part(axis_at=lambda depth, k: 0, place=lambda m: 0),
        "A sorted order makes a tree that is a list. Take the median first, then go on with each "
        "half.",
        is_cheap=True,
    ),
    Mistake(
        "The rows are sorted by x, the largest first.",
        _begins_every_part(axis_at=lambda depth, k: 0, place=lambda m: m - 1),
        "The median is the one in the middle, not the largest.",
    ),
    Mistake(
        "The rows stay in the order in which they came.",
        lambda *_: lambda points, order: bool((np.diff(order) == 1).all()),
        is_cheap=True,
    ),
    Mistake(
        "Each median stands between its two parts; it should come before both.",
        lambda *_: _median_between_parts,
        "What comes first is on top: [median] + smaller ones + others.",
    ),
    Mistake(
        "Each median stands after its two parts; it should come before both.",
        lambda *_: lambda points, order: next(_wrong_parts(points, order[::-1]), None) is None,
        "What comes first is on top: [median] + smaller ones + others.",
    ),
    cases=tuple(
        (distinct_points(np.random.default_rng(50), len(order), k), np.array(order))
        for k, order in (
            (2, [5, 0, 1, 4, 3, 2]),
            (3, [7, 0, 2, 9, 4, 6, 3, 8, 10, 1, 5]),
            (3, [2, 0, 1, 3, 10, 11, 5, 7, 9, 8, 4, 6]),
        )
    ),
    right=lambda points, order: (points, order),
    same=lambda answer, predicted: predicted(*answer),
    call=lambda median_order, points, order: (points, as_order(median_order(points), len(points))),
)
