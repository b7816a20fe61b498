"""Visible checks of `plane_through`."""

import math
from collections.abc import Callable

import numpy as np

from utils.checks import common_checks
from utils.checks.assertions import (
    CheckFailed,
    as_array,
    brief,
    frozen,
    needs,
    point_text,
)
from utils.checks.common_checks import Case
from utils.checks.core import visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.failures import fixed
from utils.checks.lesson_03.planes import (
    LARGE_AND_SMALL,
    TRIANGLES,
    as_plane,
    assert_unit_normal,
    expected_text,
    plane_text,
    same_plane,
    triangle_text,
)
from utils.geometry import best_plane, gaps_from, plane_at

_TINY = frozen(np.array([[3.0, 1.0, -1.7], [3.1, 1.0, -1.7], [3.0, 1.08, -1.68]]))
_LINES = frozen(
    np.array(
        [
            [[1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [5.0, 5.0, 5.0]],
            [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [4.0, 0.0, 1.0]],
            [[1.0, 2.0, 3.0], [4.0, 0.0, 1.0], [4.0, 0.0, 1.0]],
            [[2.0, 2.0, 2.0], [2.0, 2.0, 2.0], [2.0, 2.0, 2.0]],
        ]
    )
)


def as_plane_of_triangle(answer: object, triangle: np.ndarray) -> np.ndarray:
    """Return the four numbers of the answer for three points that have a plane.

    Parameters
    ----------
    answer : object
    triangle : numpy.ndarray, shape (3, 3)

    Returns
    -------
    numpy.ndarray, shape (4,)

    Raises
    ------
    CheckFailed
        If the answer is None or is not a plane.
    """
    if answer is None:
        raise CheckFailed(
            "The function returned None for three points that have a plane.",
            given=triangle_text(triangle),
            yours="None",
            expected="four numbers (a, b, c, d)",
            hint="None is for points on one line alone. Does every other way through the function "
            "end with `return` and the four numbers?",
        )
    return as_plane(answer)


def assert_perpendicular(answer: object, triangle: np.ndarray) -> None:
    """Assert that the normal is perpendicular to a triangle; its length and d are ignored.

    Parameters
    ----------
    answer : object
    triangle : numpy.ndarray, shape (3, 3)
    """
    plane = as_plane_of_triangle(answer, triangle)
    sides = np.roll(triangle, -1, axis=0) - triangle
    lengths = np.linalg.norm(sides, axis=1) * np.linalg.norm(plane[:3])
    angle = np.degrees(np.arcsin(np.clip(np.abs(sides @ plane[:3]) / lengths, 0, 1))).max()
    if angle > 0.1:
        raise CheckFailed(
            f"(a, b, c) is not perpendicular to the triangle: it is off by {angle:.1f} degrees.",
            given=triangle_text(triangle),
            yours=plane_text(plane),
            expected=expected_text(plane, best_plane(triangle)[0]),
        )


def assert_contains_points(answer: object, triangle: np.ndarray) -> None:
    """Assert that the three points of a triangle lie on the plane.

    Parameters
    ----------
    answer : object
    triangle : numpy.ndarray, shape (3, 3)
    """
    plane = as_plane_of_triangle(answer, triangle)
    worst = triangle[np.argmax(gaps_from(triangle, plane))]
    if gaps_from(worst[None], plane)[0] > 2e-3:
        raise CheckFailed(
            f"The points do not lie on the plane: at {point_text(worst)}, for example, "
            f"a x + b y + c z + d is {worst @ plane[:3] + plane[3]:.3g}, {fixed('not 0')}.",
            given=triangle_text(triangle),
            yours=plane_text(plane),
            expected=expected_text(plane, best_plane(triangle)[0]),
        )


def assert_no_plane(answer: object, line: np.ndarray, nearly: str = "") -> None:
    """Assert that the answer for three points on one line is None.

    Parameters
    ----------
    answer : object
    line : numpy.ndarray, shape (3, 3)
    nearly : str
        A clause about their distance from the line, for the message.
    """
    if answer is not None:
        raise CheckFailed(
            f"These three points lie on one line{nearly}: infinitely many planes go through them.",
            given=triangle_text(line),
            yours=brief(as_array(answer, what="None, or four numbers")),
            expected="None",
        )


def require_perpendicular_normals(plane_through: Callable) -> None:
    """Assert that the normal is perpendicular to triangles; raise `NotYet` if not."""
    with needs("the normal is perpendicular to the triangle"):
        for triangle in TRIANGLES[2:]:
            assert_perpendicular(plane_through(*triangle.copy()), triangle)


def require_planes(plane_through: Callable) -> None:
    """Assert that points which have a plane get one; raise `NotYet` if not."""
    with needs("three points that are not on one line give a plane"):
        for triangle in TRIANGLES[:2]:
            as_plane_of_triangle(plane_through(*triangle.copy()), triangle)


@visible(
    "plane_through",
    weight=3,
    title="(a, b, c) is perpendicular to the triangle",
    why="The normal is the direction of the plane: a road whose normal leans runs into the sky.",
    hint="The cross product of q - p and r - p is perpendicular to both.",
)
def stands_upright(plane_through: Callable) -> None:
    for triangle in TRIANGLES:
        assert_perpendicular(plane_through(*triangle.copy()), triangle)


@visible(
    "plane_through",
    weight=18,
    title="The three points lie on the plane",
    why="Everything else, distances and inliers, is measured from this plane.",
    hint="Choose d so that a x + b y + c z + d is 0 at p, with the same a, b, c that you return.",
)
def holds_its_points(plane_through: Callable) -> None:
    require_perpendicular_normals(plane_through)
    for triangle in TRIANGLES:
        for points in (triangle, triangle[::-1]):  # reversed points flip the normal
            assert_contains_points(plane_through(*points.copy()), points)


@visible(
    "plane_through",
    weight=5,
    title="The normal has length 1",
    why="Only then is a x + b y + c z + d a distance in metres, and 0.2 means 20 cm.",
    hint="Divide the cross product by np.linalg.norm of it, and compute d afterwards.",
)
def has_a_unit_normal(plane_through: Callable) -> None:
    require_perpendicular_normals(plane_through)
    for triangle in LARGE_AND_SMALL:
        assert_unit_normal(as_plane_of_triangle(plane_through(*triangle.copy()), triangle))


@visible(
    "plane_through",
    weight=4,
    title="Returns None for points on one line",
    why="Three such points fix no plane, and 0 / 0 would spread through all distances. On a "
    "drive with ten scans a second even what is rare comes up.",
    hint="When the cross product has length 0, return None before dividing by it.",
)
def refuses_a_line(plane_through: Callable) -> None:
    require_planes(plane_through)
    for line in _LINES:
        assert_no_plane(plane_through(*line.copy()), line)


@visible(
    "plane_through",
    weight=2,
    title="Sees a line through rounding errors",
    why="Measured points are never whole numbers: the cross product of a line is hardly ever "
    "exactly 0.",
    hint="Do not compare a computed length with exactly 0: compare it with something tiny, "
    "such as 1e-9.",
)
def sees_through_rounding(plane_through: Callable) -> None:
    require_planes(plane_through)
    with needs("points that lie exactly on one line have no plane"):
        assert_no_plane(plane_through(*_LINES[0].copy()), _LINES[0])
    start, step = np.array([0.1, 0.2, 0.3]), np.array([0.7, 0.1, -0.3])
    line = np.array([start, start + 0.1 * step, start + 0.7 * step])
    nearly = ", but for the last digit of a float"
    assert_no_plane(plane_through(*line.copy()), line, nearly)


@visible(
    "plane_through",
    weight=2,
    title="A small triangle has a plane, too",
    why="Neighbouring returns are centimetres apart: their cross product is short, but not 0.",
    hint="Refuse only what is as good as 0, such as a length below 1e-9.",
)
def takes_a_small_triangle(plane_through: Callable) -> None:
    require_perpendicular_normals(plane_through)
    answer = plane_through(*_TINY.copy())
    if answer is None:
        raise CheckFailed(
            fixed("These points are 8 and 10 cm apart and not on one line: they have a plane."),
            given=triangle_text(_TINY),
            yours="None",
            expected=plane_text(best_plane(_TINY)[0]),
        )
    assert_perpendicular(answer, _TINY)


_SLOPE_CASE = Case(
    __name__,
    "plane_through",
    dict(zip("pqr", TRIANGLES[2], strict=True)),
    expected=TRIANGLES[2],
    compare=lambda answer, p, q, r, triangle: assert_perpendicular(answer, triangle),
    precondition=require_perpendicular_normals,
)
common_checks.untouched(
    _SLOPE_CASE,
    "leaves_its_points",
    title="Leaves its points untouched",
    why="The sample is part of the cloud: a point that moves is a wrong point for ever.",
    hint="Give q - p and r - p names of their own; q -= p would move q.",
)
common_checks.names(
    _SLOPE_CASE,
    "keeps_p_q_r",
    title="The parameters keep their names: p, q and r",
    why="Whoever reads the docstring calls plane_through(p=..., q=..., r=...).",
)


def _cross_length(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> float:
    """Return twice the area of a triangle, the length of the cross product of its sides."""
    a, b, c = math.dist(p, q), math.dist(q, r), math.dist(r, p)
    return math.sqrt((a + b + c) * (b + c - a) * (c + a - b) * (a + b - c)) / 2


mistakes(
    "plane_through",
    Mistake(
        "The sign of d is wrong: a x + b y + c z + d must be 0 at the points, so d is minus the "
        "sum at p.",
        lambda right, *points: right * [1, 1, 1, -1],
    ),
    Mistake(
        "d is computed with the long normal, (a, b, c) are divided by its length: the four "
        "numbers do not belong together.",
        lambda right, *points: right * [1, 1, 1, _cross_length(*points)],
        "Divide by the length first, and compute d from what comes out.",
    ),
    Mistake(
        "The cross product is not divided by its length.",
        lambda right, *points: right * _cross_length(*points),
        "Divide it by np.linalg.norm of it, and compute d afterwards.",
    ),
    Mistake(
        "The cross product is that of the points p and q themselves: it belongs to the plane "
        "through p, q and the sensor.",
        lambda right, p, q, r: best_plane(np.array([0 * p, p, q]))[0],
        "The sides of the triangle, q - p and r - p, lie in the plane; p and q do not.",
    ),
    Mistake(
        "p is subtracted from q, but not from r.",
        lambda right, p, q, r: plane_at(p, best_plane(np.array([0 * p, q - p, r]))[0][:3]),
        "Both sides begin at p: q - p and r - p.",
    ),
    Mistake(
        "d is always 0: that is the parallel plane through the sensor.",
        lambda right, *points: right * [1, 1, 1, 0],
        "Choose d so that a x + b y + c z + d is 0 at p.",
    ),
    cases=(
        tuple(np.array([[0.0, 0.0, -1.0], [10.0, 0.0, 1.0], [3.0, 4.0, -2.0]])),
        tuple(np.array([[5.0, 1.0, 2.0], [7.0, 4.0, 1.0], [4.0, 6.0, 3.0]])),
        tuple(np.array([[2.0, 5.0, 0.5], [8.0, 5.0, 1.0], [5.0, 5.0, -1.5]])),
    ),
    right=lambda *points: best_plane(np.array(points))[0],
    same=same_plane,
)
