"""Visible checks of `count_near`."""

from collections.abc import Callable

import numpy as np

from utils.checks.assertions import (
    CheckFailed,
    assert_arguments_unchanged,
    brief,
    frozen,
    needs,
    observe,
)
from utils.checks.compiled import assert_compiles
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.lesson_03.iterations_needed import assert_number
from utils.checks.lesson_13.words import COMPILES_TITLE, COMPILES_WHY

# A tilted plane, and two directions in it.
_PLANE = frozen(np.array([0.36, 0.48, 0.8, -0.2]))
_DIRECTIONS = frozen(np.array([[0.8, -0.6, 0.0], [0.48, 0.64, -0.6]]))
_OFFSETS = frozen(np.array([0.22, 0.9, -0.12, -0.31, 0.05, -0.95, 1.4, -0.26, 0.18]))
_TOLERANCE = 0.3  # five of the offsets are within it


def _points_at(offsets: np.ndarray) -> np.ndarray:
    """Return points with these offsets from the plane, each at a different place along it."""
    n = len(offsets)
    along = np.column_stack([np.arange(n) - 2.5, 1.3 * np.arange(n) % 4 - 1]) @ _DIRECTIONS
    return along + (offsets - _PLANE[3])[:, None] * _PLANE[:3]


def _assert_counts(
    count_near: Callable, offsets: np.ndarray, tolerance: float, expected: int
) -> None:
    yours = assert_number(count_near(_points_at(offsets), _PLANE.copy(), tolerance))
    if yours != expected:
        raise CheckFailed(
            "This is not how many of the points lie within the tolerance.",
            given=f"points {brief(offsets)} m off the plane, tolerance {tolerance:g} m",
            yours=brief(yours[()]),
            expected=str(expected),
        )


@visible(
    "count_near",
    title="Counts the points within the tolerance, on both sides of the plane",
    why="RANSAC takes the plane with the largest count: a wrong count is another road.",
    hint="For each row i the distance is abs(plane[0] * points[i, 0] + plane[1] * points[i, 1] + "
    "... + plane[3]); add one to the count where it is at most the tolerance, and return after "
    "the loop.",
)
def counts_both_sides(count_near: Callable) -> None:
    _assert_counts(count_near, _OFFSETS, _TOLERANCE, 5)
    _assert_counts(count_near, -_OFFSETS[::-1], 0.1, 1)
    _assert_counts(count_near, _OFFSETS, 0.93, 7)


@visible(
    "count_near",
    title="A point at exactly the tolerance counts",
    why="The loop is to give the same number as NumPy, and as lesson 03.",
    hint="At most the tolerance is `<=`.",
)
def counts_the_edge(count_near: Callable) -> None:
    with needs("the points within the tolerance are counted"):
        counts_both_sides(count_near)
    level = np.array([0.0, 0.0, 1.0, -1.0])
    points = np.array([[3.0, 1.0, 1.25], [2.0, -4.0, 0.75], [5.0, 2.0, 1.5]])
    yours = assert_number(count_near(points, level, 0.25))
    if yours != 2:
        raise CheckFailed(
            "Two of these points are exactly as far away as the tolerance.",
            given="points 0.25, -0.25 and 0.5 m above a level plane, tolerance 0.25 m",
            yours=brief(yours[()]),
            expected="2",
        )


@visible(
    "count_near",
    title="Of no points, and of none that is near, there are 0",
    why="An empty cloud is no error: the sensor may see only sky.",
    hint="Start at 0 before the loop, and return after it: a loop over nothing does nothing.",
)
def counts_none(count_near: Callable) -> None:
    _assert_counts(count_near, _OFFSETS[:0], _TOLERANCE, 0)
    _assert_counts(count_near, _OFFSETS, 0.02, 0)


@visible(
    "count_near",
    title="Leaves the points as they are",
    why="The next round counts the same points again.",
    hint="Put the distance into a variable of its own.",
)
def leaves_the_points(count_near: Callable) -> None:
    arguments = _points_at(_OFFSETS), _PLANE, _TOLERANCE
    assert_arguments_unchanged(observe(count_near, *arguments), *arguments)


@noted("count_near", title=COMPILES_TITLE, why=COMPILES_WHY)
def count_near_compiles(count_near: Callable) -> None:
    points, plane = _points_at(_OFFSETS), _PLANE.copy()
    assert_compiles(count_near, lambda function: int(function(points, plane, _TOLERANCE)))


def _count(
    points: np.ndarray,
    plane: np.ndarray,
    tolerance: float,
    distance: Callable = lambda points, plane: np.abs(points @ plane[:3] + plane[3]),
) -> int:
    return int(np.sum(distance(points, plane) <= tolerance))


def _random_case(seed: int) -> tuple:
    """Return the arguments of a call with random distances from the plane."""
    offsets = np.random.default_rng(seed).uniform(-0.8, 0.8, 11)
    return frozen(_points_at(offsets)), _PLANE, _TOLERANCE


def _counted_with(distance: Callable) -> Callable:
    """Return the prediction of a count with another distance."""
    return lambda right, points, plane, tolerance: _count(points, plane, tolerance, distance)


mistakes(
    "count_near",
    Mistake(
        "All that lies below the plane counts, however far: the sign is left in the distance.",
        _counted_with(lambda points, plane: points @ plane[:3] + plane[3]),
        "abs(...) around the whole sum.",
    ),
    Mistake(
        "d is left out: the distance is to a plane through the sensor.",
        _counted_with(lambda points, plane: np.abs(points @ plane[:3])),
        "The fourth number of the plane, plane[3], is added, too.",
    ),
    Mistake(
        "d is subtracted, as if the plane were a x + b y + c z = d.",
        _counted_with(lambda points, plane: np.abs(points @ plane[:3] - plane[3])),
        "Add plane[3].",
    ),
    Mistake(
        "z is left out.",
        _counted_with(lambda points, plane: np.abs(points[:, :2] @ plane[:2] + plane[3])),
        "There are three products and d.",
    ),
    Mistake(
        "The absolute value is taken of each part, and not of their sum.",
        _counted_with(lambda points, plane: np.abs(points * plane[:3]).sum(axis=1) + abs(plane[3])),
        "abs(...) around the whole sum.",
    ),
    Mistake(
        "The square of the distance is compared with the tolerance.",
        _counted_with(lambda points, plane: (points @ plane[:3] + plane[3]) ** 2),
        "Take abs(...), not the square.",
    ),
    Mistake(
        "What is farther away than the tolerance is counted.",
        lambda right, points, plane, tolerance: len(points) - right,
        "Count where the distance is at most the tolerance.",
    ),
    Mistake(
        "The loop ends with its first point: `return` stands inside it.",
        lambda right, points, plane, tolerance: _count(points[:1], plane, tolerance),
        "`return` as far to the left as `for`.",
    ),
    Mistake(
        "The last point is never looked at.",
        lambda right, points, plane, tolerance: _count(points[:-1], plane, tolerance),
        "range(len(points)) ends before len(points) by itself.",
    ),
    Mistake(
        "The first point is never looked at.",
        lambda right, points, plane, tolerance: _count(points[1:], plane, tolerance),
        "range(len(points)) begins at 0.",
    ),
    Mistake(
        "As many as there are columns are looked at, and not as many as there are rows.",
        lambda right, points, plane, tolerance: _count(points[:3], plane, tolerance),
        "range(len(points)), or points.shape[0].",
    ),
    Mistake(
        "The count begins at 1.",
        lambda right, points, plane, tolerance: right + 1,
        "Before the loop nobody has been counted: 0.",
    ),
    Mistake(
        "Every point counts.",
        lambda right, points, plane, tolerance: len(points),
        is_cheap=True,
    ),
    cases=tuple(_random_case(seed) for seed in range(8)),
    right=_count,
)
