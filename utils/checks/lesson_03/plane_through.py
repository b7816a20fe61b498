"""Visible checks of `plane_through`."""

import math
from collections.abc import Callable

import numpy as np

from utils.checks import common_checks
from utils.checks.assertions import (
    CheckFailed,
    as_array,
    brief_text,
    frozen,
    point_text,
    precondition,
)
from utils.checks.common_checks import Case
from utils.checks.core import visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
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
from utils.geometry import best_plane, distances_from_plane, plane_through_point

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
    """Return the four numbers of an answer for three points that define a plane.

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
            "The function returned None for three points that define a plane.",
            input_text=triangle_text(triangle),
            yours="None",
            expected="four numbers (a, b, c, d)",
            hint="Return None only for points on one line. Does every other path through the "
            "function end with `return` and the four numbers?",
        )
    return as_plane(answer)


def assert_perpendicular(answer: object, triangle: np.ndarray) -> None:
    """Assert that the normal is perpendicular to a triangle; ignore its length and d.

    Parameters
    ----------
    answer : object
    triangle : numpy.ndarray, shape (3, 3)
    """
    plane = as_plane_of_triangle(answer, triangle)
    sides = np.roll(triangle, -1, axis=0) - triangle
    lengths = np.linalg.norm(sides, axis=1) * np.linalg.norm(plane[:3])
    with np.errstate(invalid="ignore", divide="ignore"):  # the answer may be (0, 0, 0, 0)
        angle = np.degrees(np.arcsin(np.clip(np.abs(sides @ plane[:3]) / lengths, 0, 1))).max()
    if angle > 0.1:
        raise CheckFailed(
            f"(a, b, c) is not perpendicular to the triangle: it is off by {angle:.1f} degrees.",
            input_text=triangle_text(triangle),
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
    worst = triangle[np.argmax(distances_from_plane(triangle, plane))]
    if distances_from_plane(worst[None], plane)[0] > 2e-3:
        raise CheckFailed(
            f"The points do not lie on the plane: at {point_text(worst)}, for example, "
            f"a x + b y + c z + d is {worst @ plane[:3] + plane[3]:.3g}, {fixed('not 0')}.",
            input_text=triangle_text(triangle),
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
        A clause for the message, if the points are not exactly on the line.
    """
    if answer is not None:
        raise CheckFailed(
            f"These three points lie on one line{nearly}: infinitely many planes contain them.",
            input_text=triangle_text(line),
            yours=brief_text(as_array(answer, description="None, or four numbers")),
            expected="None",
        )


def require_perpendicular_normals(plane_through: Callable) -> None:
    """Raise `NotYet` if the normal is not perpendicular to triangles."""
    with precondition("the normal is perpendicular to the triangle"):
        for triangle in TRIANGLES[2:]:
            assert_perpendicular(plane_through(*triangle.copy()), triangle)


def require_planes(plane_through: Callable) -> None:
    """Raise `NotYet` if the function returns no plane for points that define one."""
    with precondition("three points that are not on one line give a plane"):
        for triangle in TRIANGLES[:2]:
            as_plane_of_triangle(plane_through(*triangle.copy()), triangle)


@visible_check(
    "plane_through",
    weight=3,
    title="Returns a normal that is perpendicular to the triangle",
    why="The normal determines the slope of the plane: with a tilted normal, a level road seems to "
    "climb into the sky.",
    hint="Compute np.cross(q - p, r - p), which is perpendicular to both sides.",
)
def normal_is_perpendicular(plane_through: Callable) -> None:
    for triangle in TRIANGLES:
        assert_perpendicular(plane_through(*triangle.copy()), triangle)


@visible_check(
    "plane_through",
    weight=18,
    title="Returns a plane through all three points",
    why="Distances are measured from this plane, and they decide which points are inliers.",
    hint="Choose d so that a x + b y + c z + d is 0 at p, with the same a, b, c that you return.",
)
def contains_its_points(plane_through: Callable) -> None:
    require_perpendicular_normals(plane_through)
    for triangle in TRIANGLES:
        for points in (triangle, triangle[::-1]):  # reversing the points flips the normal
            assert_contains_points(plane_through(*points.copy()), points)


@visible_check(
    "plane_through",
    weight=5,
    title="Returns a normal of length 1",
    why="If the normal had length 5, all distances from the plane would be five times too large.",
    hint="Divide the cross product by its length, np.linalg.norm(...), then compute d.",
)
def has_a_unit_normal(plane_through: Callable) -> None:
    require_perpendicular_normals(plane_through)
    for triangle in LARGE_AND_SMALL:
        assert_unit_normal(as_plane_of_triangle(plane_through(*triangle.copy()), triangle))


@visible_check(
    "plane_through",
    weight=4,
    title="Returns None for points on one line",
    why="Points on one line do not define a plane, and 0 / 0 would make all distances NaN.",
    hint="If the cross product has length 0, return None before you divide by this length.",
)
def returns_none_for_a_line(plane_through: Callable) -> None:
    require_planes(plane_through)
    for line in _LINES:
        assert_no_plane(plane_through(*line.copy()), line)


@visible_check(
    "plane_through",
    weight=2,
    title="Returns None for points on a line in spite of rounding errors",
    why="Measured coordinates are rounded, so the cross product of points on a line is hardly "
    "ever exactly 0.",
    hint="Do not compare a computed length with exactly 0. Compare it with a tiny number such "
    "as 1e-9.",
)
def allows_for_rounding_errors(plane_through: Callable) -> None:
    require_planes(plane_through)
    with precondition("points exactly on one line give None"):
        assert_no_plane(plane_through(*_LINES[0].copy()), _LINES[0])
    start, step = np.array([0.1, 0.2, 0.3]), np.array([0.7, 0.1, -0.3])
    line = np.array([start, start + 0.1 * step, start + 0.7 * step])
    nearly = ", apart from rounding errors"
    assert_no_plane(plane_through(*line.copy()), line, nearly)


@visible_check(
    "plane_through",
    weight=2,
    title="Finds the plane of a small triangle",
    why="Neighbouring returns are only centimetres apart, so their cross product is short but not "
    "0.",
    hint="Return None only if the length is practically 0, for example below 1e-9.",
)
def finds_small_triangles(plane_through: Callable) -> None:
    require_perpendicular_normals(plane_through)
    answer = plane_through(*_TINY.copy())
    if answer is None:
        raise CheckFailed(
            fixed(
                "These points are 8 and 10 cm apart and not on one line, so they define a plane."
            ),
            input_text=triangle_text(_TINY),
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
common_checks.promise_untouched(
    _SLOPE_CASE,
    "leaves_its_points",
    why="p, q and r may be rows of the scan, so changing them would move points of the road.",
    hint="Store q - p and r - p in new variables; q -= p would move q.",
)
common_checks.promise_names(
    _SLOPE_CASE,
    "keeps_p_q_r",
    title="Keeps the names of its parameters: p, q and r",
    why="Other code may pass arguments by name, as in plane_through(p=..., q=..., r=...).",
)


def _cross_length(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> float:
    """Return the length of the cross product of two sides of a triangle, twice its area."""
    a, b, c = math.dist(p, q), math.dist(q, r), math.dist(r, p)
    return math.sqrt((a + b + c) * (b + c - a) * (c + a - b) * (a + b - c)) / 2


declare_mistakes(
    "plane_through",
    Mistake(
        "a, b and c are right, but d has the wrong sign.",
        lambda right, *points: right * [1, 1, 1, -1],
        "Choose d so that a x + b y + c z + d is 0 at p.",
    ),
    Mistake(
        "d is computed before the normal is divided by its length, so the four numbers do not "
        "belong together.",
        lambda right, *points: right * [1, 1, 1, _cross_length(*points)],
        "Divide the normal by its length first, then compute d from the result.",
    ),
    Mistake(
        "The cross product is not divided by its length.",
        lambda right, *points: right * _cross_length(*points),
        "Divide it by its length, np.linalg.norm(...), then compute d.",
    ),
    Mistake(
        "The cross product is computed from the points p and q themselves. It must be computed "
        "from two sides of the triangle.",
        lambda right, p, q, r: best_plane(np.array([0 * p, p, q]))[0],
        "Compute np.cross(q - p, r - p).",
    ),
    *(
        Mistake(
            f"The cross product is computed from the points {names} themselves. It must be "
            "computed from two sides of the triangle.",
            lambda right, *points, pair=pair: plane_through_point(
                points[0], best_plane(np.array([0 * points[0], *(points[k] for k in pair)]))[0][:3]
            ),
            "Compute np.cross(q - p, r - p).",
        )
        for names, pair in (("q and r", (1, 2)), ("p and r", (0, 2)))
    ),
    Mistake(
        "p is subtracted from q, but not from r.",
        lambda right, p, q, r: plane_through_point(
            p, best_plane(np.array([0 * p, q - p, r]))[0][:3]
        ),
        "Subtract p from both: q - p and r - p.",
    ),
    Mistake(
        "d is always 0, so the plane passes through the sensor instead of the points.",
        lambda right, *points: right * [1, 1, 1, 0],
        "Choose d so that a x + b y + c z + d is 0 at p.",
    ),
    cases=(
        tuple(np.array([[0.0, 0.0, -1.0], [10.0, 0.0, 1.0], [3.0, 4.0, -2.0]])),
        tuple(np.array([[5.0, 1.0, 2.0], [7.0, 4.0, 1.0], [4.0, 6.0, 3.0]])),
        tuple(np.array([[2.0, 5.0, 0.5], [8.0, 5.0, 1.0], [5.0, 5.0, -1.5]])),
    ),
    right=lambda *points: best_plane(np.array(points))[0],
    is_same=same_plane,
)
