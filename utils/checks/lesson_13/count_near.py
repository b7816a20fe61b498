"""Visible checks of `count_near`."""

from collections.abc import Callable

import numpy as np

from utils.checks.assertions import (
    CheckFailed,
    assert_arguments_unchanged,
    brief_text,
    frozen,
    observe,
    precondition,
)
from utils.checks.compiled import assert_compiles
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.lesson_03.iterations_needed import assert_number
from utils.checks.lesson_13.compile_note import COMPILES_TITLE, COMPILES_WHY

# A tilted plane, and two directions in it.
_PLANE = frozen(np.array([0.36, 0.48, 0.8, -0.2]))
_DIRECTIONS = frozen(np.array([[0.8, -0.6, 0.0], [0.48, 0.64, -0.6]]))
_OFFSETS = frozen(np.array([0.22, 0.9, -0.12, -0.31, 0.05, -0.95, 1.4, -0.26, 0.18]))
_TOLERANCE = 0.3  # five of the offsets are within it


def _points_at(offsets: np.ndarray) -> np.ndarray:
    """Return points with these offsets from the plane, each at a different position along it."""
    n = len(offsets)
    along = np.column_stack([np.arange(n) - 2.5, 1.3 * np.arange(n) % 4 - 1]) @ _DIRECTIONS
    return along + (offsets - _PLANE[3])[:, None] * _PLANE[:3]


def _assert_counts(
    count_near: Callable, offsets: np.ndarray, tolerance: float, expected: int
) -> None:
    yours = assert_number(count_near(_points_at(offsets), _PLANE.copy(), tolerance))
    if yours != expected:
        raise CheckFailed(
            "The number of points within the tolerance is wrong.",
            input_text=f"points {brief_text(offsets)} m off the plane, tolerance {tolerance:g} m",
            yours=brief_text(yours[()]),
            expected=str(expected),
        )


@visible_check(
    "count_near",
    title="Counts the points within the tolerance on both sides of the plane",
    why="RANSAC chooses the plane with the largest count. A wrong count leads to a wrong road.",
    hint="For each row i the distance is abs(plane[0] * points[i, 0] + plane[1] * points[i, 1] + "
    "... + plane[3]). Add 1 to the count if the distance is at most the tolerance, and return the "
    "count after the loop.",
)
def counts_both_sides(count_near: Callable) -> None:
    _assert_counts(count_near, _OFFSETS, _TOLERANCE, 5)
    _assert_counts(count_near, -_OFFSETS[::-1], 0.1, 1)
    _assert_counts(count_near, _OFFSETS, 0.93, 7)


@visible_check(
    "count_near",
    title="Also counts points exactly at the tolerance",
    why="The loop should give the same number as NumPy and lesson 03.",
    hint='Write `<=` for "at most".',
)
def counts_points_at_the_tolerance(count_near: Callable) -> None:
    with precondition("the function counts the points within the tolerance"):
        counts_both_sides(count_near)
    level = np.array([0.0, 0.0, 1.0, -1.0])
    points = np.array([[3.0, 1.0, 1.25], [2.0, -4.0, 0.75], [5.0, 2.0, 1.5]])
    yours = assert_number(count_near(points, level, 0.25))
    if yours != 2:
        raise CheckFailed(
            "Two of these points are exactly at the tolerance.",
            input_text="points 0.25, -0.25 and 0.5 m above a level plane, tolerance 0.25 m",
            yours=brief_text(yours[()]),
            expected="2",
        )


@visible_check(
    "count_near",
    title="Returns 0 when the cloud is empty or no point is near",
    why="The sensor may see only sky, and an empty cloud must not crash the program.",
    hint="Set the count to 0 before the loop, and return it after the loop.",
)
def returns_zero(count_near: Callable) -> None:
    _assert_counts(count_near, _OFFSETS[:0], _TOLERANCE, 0)
    _assert_counts(count_near, _OFFSETS, 0.02, 0)


@visible_check(
    "count_near",
    title="Does not change the points",
    why="The next round of RANSAC counts the same points again.",
    hint="Store the distance in a new variable.",
)
def keeps_the_points_unchanged(count_near: Callable) -> None:
    arguments = _points_at(_OFFSETS), _PLANE, _TOLERANCE
    assert_arguments_unchanged(observe(count_near, *arguments), *arguments)


@note_check("count_near", title=COMPILES_TITLE, why=COMPILES_WHY)
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


def _prediction_from_distance(distance: Callable) -> Callable:
    """Return the prediction for a function that counts with another distance."""
    return lambda right, points, plane, tolerance: _count(points, plane, tolerance, distance)


declare_mistakes(
    "count_near",
    Mistake(
        "The function counts all points below the plane, however far away they are, because the "
        "distance keeps its sign.",
        _prediction_from_distance(lambda points, plane: points @ plane[:3] + plane[3]),
        "Put abs(...) around the whole sum.",
    ),
    Mistake(
        "The code leaves out d, so it measures the distance to a plane through the sensor.",
        _prediction_from_distance(lambda points, plane: np.abs(points @ plane[:3])),
        "Also add plane[3], the fourth number of the plane.",
    ),
    Mistake(
        "The code subtracts d, as if the plane were a x + b y + c z = d.",
        _prediction_from_distance(lambda points, plane: np.abs(points @ plane[:3] - plane[3])),
        "Add plane[3] instead of subtracting it.",
    ),
    Mistake(
        "The code leaves out z, so the height does not count.",
        _prediction_from_distance(
            lambda points, plane: np.abs(points[:, :2] @ plane[:2] + plane[3])
        ),
        "Also add the product for z, plane[2] * points[i, 2].",
    ),
    Mistake(
        "The code takes the absolute value of each term instead of the sum.",
        _prediction_from_distance(
            lambda points, plane: np.abs(points * plane[:3]).sum(axis=1) + abs(plane[3])
        ),
        "Put abs(...) around the whole sum.",
    ),
    Mistake(
        "The code compares the square of the distance with the tolerance.",
        _prediction_from_distance(lambda points, plane: (points @ plane[:3] + plane[3]) ** 2),
        "Take abs(...), not the square.",
    ),
    Mistake(
        "The function counts the points that are farther away than the tolerance.",
        lambda right, points, plane, tolerance: len(points) - right,
        "Count points whose distance is at most the tolerance.",
    ),
    Mistake(
        "The loop ends after its first point, because `return` is inside it.",
        lambda right, points, plane, tolerance: _count(points[:1], plane, tolerance),
        "Indent `return` like `for`.",
    ),
    Mistake(
        "The loop never reads the last point.",
        lambda right, points, plane, tolerance: _count(points[:-1], plane, tolerance),
        "Use range(len(points)), which already ends before len(points).",
    ),
    Mistake(
        "The loop never reads the first point.",
        lambda right, points, plane, tolerance: _count(points[1:], plane, tolerance),
        "Use range(len(points)), which begins at 0.",
    ),
    Mistake(
        "The loop runs once per column instead of once per row, so it reads only three points.",
        lambda right, points, plane, tolerance: _count(points[:3], plane, tolerance),
        "Use range(len(points)) or range(points.shape[0]).",
    ),
    Mistake(
        "The count starts at 1.",
        lambda right, points, plane, tolerance: right + 1,
        "Start at 0, because no point has been counted before the loop.",
    ),
    Mistake(
        "The function counts every point, not only the points within the tolerance.",
        lambda right, points, plane, tolerance: len(points),
        is_cheap=True,
    ),
    cases=tuple(_random_case(seed) for seed in range(8)),
    right=_count,
)
