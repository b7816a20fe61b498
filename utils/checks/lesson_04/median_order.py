"""Visible checks of `median_order`."""

from collections.abc import Callable, Iterator

import numpy as np

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
from utils.checks.core import visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.failures import fixed
from utils.checks.lesson_04.cases import ELEVEN_POINTS, distinct_points
from utils.checks.lesson_04.trees import few_points_text
from utils.checks.run_cache import once_per_run
from utils.geometry import alternating_axis, grow_tree, nodes_by_path

_SHORT_HINT = (
    "Put the rows before the median and the rows after it on the list of parts, and process every "
    "part on the list. Skip an empty part, but do not end the loop there."
)
# With seven points, every part has a single middle point.
_SEVEN_POINTS = frozen(distinct_points(np.random.default_rng(51), 7, 2))


def as_order(answer: object, n: int) -> np.ndarray:
    """Convert an answer to a permutation of range(n).

    Returns
    -------
    numpy.ndarray of int, shape (n,)
    """
    order = as_array(answer, description="a list of row numbers")
    if order.size == 0:
        order = order.astype(int).ravel()
    if order.ndim != 1 or order.dtype.kind not in "iu":
        raise WrongForm(
            "The order must be a flat list of row numbers (whole numbers), not of points.",
            yours=brief_text(order),
            expected=f"the numbers 0 to {n - 1}",
        )
    invalid = [row for row in order.tolist() if not 0 <= row < n]
    missing = [row for row in range(n) if row not in set(order.tolist())]
    if invalid or missing or len(order) != n:
        problem = (
            f"{invalid[0]} is not a row number" if invalid else "some rows occur more than once"
        )
        text = f"row {missing[0]} is missing" if missing else problem
        is_short = not invalid and len(order) == n - len(missing)
        raise CheckFailed(
            fixed("Each row number from 0 to n - 1 must occur exactly once; ") + f"{text}.",
            yours=brief_text(order),
            expected=f"each number from 0 to {n - 1}" if n > 1 else "[0]" if n else "[]",
            hint=_SHORT_HINT if is_short else "",
        )
    return order


def _order_of(answer: object, points: np.ndarray) -> np.ndarray:
    with precondition("each row number occurs exactly once"):
        return as_order(answer, len(points))


def assert_minimal_depth(answer: object, points: np.ndarray) -> None:
    """Assert that inserting the points in this order gives a tree with the fewest levels.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 2) or (n, 3)
    """
    order = _order_of(answer, points)
    root = grow_tree(points[order], order.tolist())
    depth, least = max(map(len, nodes_by_path(root)), default=-1) + 1, len(points).bit_length()
    if depth > least:
        raise CheckFailed(
            f"Inserted in this order, {len(points)} points make a tree of {depth} levels; "
            f"with medians first, {least} levels are enough.",
            input_text=few_points_text(points),
            yours=f"{depth} levels",
            expected=f"{least} levels",
            draw=_draw_tree(order, points),
        )


def assert_lower_medians(answer: object, points: np.ndarray) -> None:
    """Assert that every part begins with its lower median along the current axis.

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
        point = f"In a part at depth {depth}, the first point"
    raise CheckFailed(
        f"{point} is not the {'lower ' * (len(values) % 2 == 0)}median of the {len(values)} points "
        f"along {letter}.",
        input_text=f"{letter} of these points, sorted: {_list_text(np.sort(values))}",
        yours=f"{letter} = {values[0]:g}",
        expected=f"{letter} = {median:g}",
        draw=_draw_tree(order, points),
    )


def _wrong_parts(
    points: np.ndarray,
    order: np.ndarray,
    axis_at: Callable[[int, int], int] = alternating_axis,
    place: Callable[[int], int] = lambda m: (m - 1) // 2,
    growths: tuple[int, int] = (1, 1),
) -> Iterator[tuple]:
    """Yield every part whose first point is not the expected one.

    Parameters
    ----------
    points : numpy.ndarray, shape (n, k)
    order : numpy.ndarray of int, shape (n,)
    axis_at : callable
        Takes a depth and the number of coordinates; returns the axis.
    place : callable
        Takes the number of points in a part; returns the position of the expected first point
        when they are sorted along the axis.
    growths : tuple of int
        Amounts added to the depth: first in the part with the smaller coordinates, then in the
        other part.

    Yields
    ------
    tuple
        The coordinates of the part along its axis, in the given order; its depth; its axis; and
        the coordinate that should come first.
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
            (part, depth + growth) for part, growth in zip(parts, growths, strict=True) if len(part)
        ]


# The correct sequence of axes, and wrong ones that still allow a function to halve every part.
_AXIS_RULES = (
    alternating_axis,
    lambda depth, k: 0,
    lambda depth, k: 1,
    lambda depth, k: (depth + 1) % k,
    lambda depth, k: depth % 2,
)


def assert_halves(answer: object, points: np.ndarray) -> None:
    """Assert that every part begins with its lower median, along the axes of any of `_AXIS_RULES`.

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
    root = grow_tree(points[order], order.tolist())
    return lambda: utils.plots.kd_tree(root, title="The tree that your order makes")


@once_per_run
def _assert_medians(median_order: Callable) -> None:
    with precondition("every part begins with its median, along x and y in turn"):
        assert_lower_medians(median_order(_SEVEN_POINTS.copy()), _SEVEN_POINTS)


@once_per_run
def _assert_halves(median_order: Callable) -> None:
    with precondition("every part begins with its median"):
        assert_halves(median_order(_SEVEN_POINTS.copy()), _SEVEN_POINTS)


@visible_check(
    "median_order",
    weight=2,
    title="Returns every row number exactly once",
    why="If a row is missing, no search will ever find its point.",
    hint="Write rows[np.argsort(...)], because np.argsort of a part gives positions within that "
    "part. Append the median to the order, and leave it out of both halves.",
)
def returns_every_row(median_order: Callable) -> None:
    for points in (ELEVEN_POINTS[:5], _SEVEN_POINTS):
        as_order(median_order(points.copy()), len(points))


@visible_check(
    "median_order",
    weight=3,
    title="Starts with the median along x",
    why="Only the median leaves the same number of points on both sides, so the tree has the "
    "fewest levels.",
    hint="Sort the rows by x. The middle one of m rows is at position (m - 1) // 2.",
)
def starts_with_the_median(median_order: Callable) -> None:
    for points in (
        ELEVEN_POINTS[[5, 0, 8]],
        ELEVEN_POINTS[:3],
        ELEVEN_POINTS[[6, 9, 1, 7, 3]],
        _SEVEN_POINTS,
    ):
        order = _order_of(median_order(points.copy()), points)
        x, median = points[order[0], 0], np.median(points[:, 0])
        if x != median:
            raise CheckFailed(
                "The first point of the order is not the median along x.",
                input_text=f"x of the {len(points)} points, sorted: "
                f"{_list_text(np.sort(points[:, 0]))}",
                yours=f"x = {x:g}",
                expected=f"x = {median:g}",
            )


@visible_check(
    "median_order",
    weight=4,
    title="Puts the median first in every part, before both halves",
    why="One uneven split near the root slows down every search below it.",
    hint="For each part, append its median to the order and put two new parts on the list: the "
    "rows before the median and the rows after it.",
)
def halves_every_part(median_order: Callable) -> None:
    rng = np.random.default_rng(47)
    for n in (3, 7, 15):
        points = distinct_points(rng, n, 2)
        assert_halves(median_order(points.copy()), points)


@visible_check(
    "median_order",
    weight=3,
    title="Takes the median along x first, then along y, then along x again",
    why="insert compares x and y in turn. A median along the wrong axis does not halve a part.",
    hint="Sort each part along the axis of its depth: depth % points.shape[1].",
)
def alternates_axes(median_order: Callable) -> None:
    _assert_halves(median_order)
    rng = np.random.default_rng(42)
    for n in (3, 7, 15):
        points = distinct_points(rng, n, 2)
        assert_lower_medians(median_order(points.copy()), points)


@visible_check(
    "median_order",
    weight=2,
    title="Takes the lower of two middle points",
    why="With this rule, the same points always make the same tree.",
    hint="Take position (m - 1) // 2 of m sorted rows for the lower median. If m is even, m // 2 "
    "is the upper one.",
)
def takes_the_lower_median(median_order: Callable) -> None:
    _assert_medians(median_order)
    rng = np.random.default_rng(43)
    for n in (2, 4, 6):
        points = distinct_points(rng, n, 2)
        assert_lower_medians(median_order(points.copy()), points)


@visible_check(
    "median_order",
    weight=2,
    title="Works on points with three coordinates: takes x, y, z and then x again",
    why="insert compares x, y and z in turn. A median along the wrong axis does not halve a part.",
    hint="Use points.shape[1], not 2, as the number of coordinates.",
)
def handles_three_coordinates(median_order: Callable) -> None:
    _assert_medians(median_order)
    points = distinct_points(np.random.default_rng(44), 31, 3)
    assert_lower_medians(median_order(points.copy()), points)


@visible_check(
    "median_order",
    weight=3,
    title="Returns an order that makes a tree with the fewest levels",
    why="Every insertion and every search walks down the levels. A tree of 100,000 points can have "
    "17 levels, or 100,000.",
    hint="Print levels(points, median_order(points)) for 3, 7 and 15 points. The results "
    "should be 2, 3 and 4.",
)
def gives_minimal_depth(median_order: Callable) -> None:
    rng = np.random.default_rng(45)
    for n in (3, 7, 15, 40, 64):
        points = distinct_points(rng, n, 2)
        assert_minimal_depth(median_order(points.copy()), points)


@visible_check(
    "median_order",
    weight=1,
    title="Works on an empty cloud and on a single point",
    why="A filter sometimes removes every point, and that must not crash the program.",
    hint="Skip a part that has no rows, because it adds nothing to the order.",
)
def takes_the_smallest(median_order: Callable) -> None:
    _assert_halves(median_order)
    as_order(median_order(np.empty((0, 2))), 0)
    as_order(median_order(np.array([[1.0, 2.0, 3.0]])), 1)


@visible_check(
    "median_order",
    weight=1,
    title="Works on points with equal coordinates",
    why="A recording may contain the same point twice, and the points of a wall share coordinates.",
    hint="Split the sorted rows into rows[:m] and rows[m + 1:], where m is the position of the "
    "median. Do not compare coordinates.",
)
def handles_equal_points(median_order: Callable) -> None:
    _assert_halves(median_order)
    for points in (np.ones((5, 2)), np.repeat(ELEVEN_POINTS[:4], 3, axis=0)):
        as_order(median_order(points.copy()), len(points))


common_checks.promise_untouched(
    Case(
        __name__,
        "median_order",
        {"points": ELEVEN_POINTS},
        expected=None,  # `assert_halves` computes it
        compare=lambda answer, points, _: assert_halves(answer, points),
        precondition=_assert_halves,
    ),
    "leaves_its_input",
    why="The order refers to the rows of the original cloud. If you sort the cloud, the order "
    "refers to the wrong points.",
    hint="Sort the row numbers, not the points.",
)


def _prediction_from_rule(**rule: object) -> Callable:
    """Return a prediction that every part begins with the point that a wrong rule selects."""
    return lambda *_: lambda points, order: next(_wrong_parts(points, order, **rule), None) is None


def _median_between_parts(points: np.ndarray, order: np.ndarray) -> bool:
    """Return whether the median is between its two halves, in every part."""
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


declare_mistakes(
    "median_order",
    Mistake(
        "The upper of two middle points comes first; it should be the lower one.",
        _prediction_from_rule(place=lambda m: m // 2),
        "Sort the rows from the smallest to the largest, and take position "
        "(number of rows - 1) // 2.",
    ),
    Mistake(
        "Every part is sorted by x; the axis should change from level to level.",
        _prediction_from_rule(axis_at=lambda depth, k: 0),
        "The axis is depth % points.shape[1], and both halves of a part have depth + 1.",
    ),
    Mistake(
        "The first median is along y; it should be along x.",
        _prediction_from_rule(axis_at=lambda depth, k: (depth + 1) % k),
        "The first part has depth 0, so its axis is x.",
    ),
    Mistake(
        "z is never used, because the function uses 2 instead of points.shape[1].",
        _prediction_from_rule(axis_at=lambda depth, k: depth % 2),
    ),
    Mistake(
        "The rows before a median are sorted along the same axis as the median, because their "
        "depth does not grow.",
        _prediction_from_rule(growths=(0, 1)),
        "Give both halves depth + 1.",
    ),
    Mistake(
        "The rows after a median are sorted along the same axis as the median, because their depth "
        "does not grow.",
        _prediction_from_rule(growths=(1, 0)),
        "Give both halves depth + 1.",
    ),
    Mistake(
        "The function only sorts the rows by x. It should put medians first.",
        _prediction_from_rule(axis_at=lambda depth, k: 0, place=lambda m: 0),
        "A sorted order makes a tree with one level per point. Take the median first, then do the "
        "same with each half.",
        is_cheap=True,
    ),
    Mistake(
        "The function sorts the rows by x, with the largest first. It should put medians first.",
        _prediction_from_rule(axis_at=lambda depth, k: 0, place=lambda m: m - 1),
        "Take the point in the middle first, not the largest.",
    ),
    Mistake(
        "The rows stay in their original order. Medians should come first.",
        lambda *_: lambda points, order: bool((np.diff(order) == 1).all()),
        is_cheap=True,
    ),
    Mistake(
        "Each median is placed between its two halves; it should come before both.",
        lambda *_: _median_between_parts,
        "Return [median] + rows before it + rows after it, in this order.",
    ),
    Mistake(
        "Each median is placed after its two halves; it should come before both.",
        lambda *_: lambda points, order: next(_wrong_parts(points, order[::-1]), None) is None,
        "Return [median] + rows before it + rows after it, in this order.",
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
    is_same=lambda answer, predicted: predicted(*answer),
    call=lambda median_order, points, order: (points, as_order(median_order(points), len(points))),
)
