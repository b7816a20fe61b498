"""Visible checks of lesson 03: planes through points, distances, RANSAC, refit, rounds.

What is asserted here is the judge's, too. A plane and its negative are the same plane: everything
here accepts both. The length of the normal is a property of its own: the others do not look at it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes, same_array
from utils.checks.failures import WrongForm
from utils.checks.remembering import once
from utils.checks.vocabulary import (
    CheckFailed,
    as_array,
    assert_shape,
    assert_untouched,
    brief,
    frozen,
    needs,
    point_text,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# A level road, a wall, a slope, a plane through the sensor, and one far away.
_TRIANGLES = frozen(
    np.array(
        [
            [[4.0, 1.0, -1.7], [9.0, -2.0, -1.7], [6.0, 3.0, -1.7]],
            [[2.0, 5.0, 0.0], [8.0, 5.0, 1.0], [5.0, 5.0, -1.5]],
            [[0.0, 0.0, -1.0], [10.0, 0.0, 1.0], [3.0, 4.0, -2.0]],
            [[0.0, 0.0, 0.0], [3.0, 1.0, 0.5], [-2.0, 4.0, 1.0]],
            [[61.0, -40.0, 2.0], [64.0, -39.0, 2.5], [62.0, -35.0, -1.0]],
        ]
    )
)
_LARGE_AND_SMALL = frozen(
    np.array(
        [
            [[0.0, 0.0, 1.0], [50.0, 0.0, 1.0], [0.0, 40.0, 3.0]],
            [[0.0, 0.0, 1.0], [0.5, 0.0, 1.0], [0.0, 0.4, 1.2]],
        ]
    )
)
_TINY = frozen(np.array([[3.0, 1.0, -1.7], [3.1, 1.0, -1.7], [3.0, 1.08, -1.68]]))
# The small case of the notebook: five points on a floor, two above it.
_SEVEN = frozen(
    np.array(
        [
            [0.0, 0.0, -1.7],
            [4.0, 0.0, -1.7],
            [1.0, 3.0, -1.7],
            [5.0, 4.0, -1.7],
            [2.0, 5.0, -1.7],
            [1.5, 1.0, -0.2],
            [3.0, 2.0, 0.5],
        ]
    )
)
# The rough floor of the notebook: 4 m by 2 m, its corners 10 cm too high or too low.
_FLOOR = frozen(np.array([[0.0, 0.0, -1.6], [4.0, 0.0, -1.8], [0.0, 2.0, -1.8], [4.0, 2.0, -1.6]]))
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


def best_plane(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Least-squares plane by the covariance matrix, and its root mean square distance.

    Parameters
    ----------
    points : numpy.ndarray, shape (n, 3) or (n, 4)

    Returns
    -------
    plane : numpy.ndarray, shape (4,)
    distance : float
    """
    centre, variances, directions = _spread_of(points)
    return _plane_at(centre, directions[:, 0]), math.sqrt(max(variances[0], 0.0))


def _spread_of(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean of some points, and variances and directions (as columns) of their spread, rising."""
    xyz = np.asarray(points, dtype=float)[:, :3]
    centre = xyz.mean(axis=0)
    return centre, *np.linalg.eigh((xyz - centre).T @ (xyz - centre) / len(xyz))


def _plane_at(place: np.ndarray, normal: np.ndarray) -> np.ndarray:
    return np.append(normal, -normal @ place)


def as_plane(answer: object) -> np.ndarray:
    """An answer as the four numbers of a plane, with a normal of whatever length.

    Parameters
    ----------
    answer : object

    Returns
    -------
    numpy.ndarray, shape (4,)
    """
    plane = as_array(answer, what="four numbers (a, b, c, d)")
    if plane.shape != (4,):
        words = " The fourth, d, is missing." if plane.shape == (3,) else ""
        raise WrongForm(
            f"A plane is four numbers (a, b, c, d).{words}",
            yours=f"shape {plane.shape}",
            expected="shape (4,)",
        )
    plane = plane.astype(float)
    if not np.isfinite(plane).all():
        raise CheckFailed("Some of the four numbers are not finite.", yours=brief(plane))
    if not plane[:3].any():
        raise CheckFailed(
            "The normal (a, b, c) is (0, 0, 0), which is no direction.", yours=_text(plane)
        )
    return plane


def gaps_from(points: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """Distance of each point from a plane whose normal may have any length; shape (n,)."""
    gaps = np.asarray(points, dtype=float)[:, :3] @ plane[:3] + plane[3]
    return np.abs(gaps) / np.linalg.norm(plane[:3])


def assert_unit_normal(answer: object) -> None:
    """The normal has length 1; whether it is the right one is another property.

    Parameters
    ----------
    answer : object
    """
    plane = as_plane(answer)
    length = np.linalg.norm(plane[:3])
    if abs(length - 1) > 1e-3:
        raise CheckFailed(
            f"The normal (a, b, c) has length {length:.4g}, not 1.",
            yours=_text(plane),
            expected=_text(plane / length),
        )


def plane_of(answer: object, triangle: np.ndarray) -> np.ndarray:
    """The answer to three points that have a plane: four numbers.

    Parameters
    ----------
    answer : object
    triangle : numpy.ndarray, shape (3, 3)

    Returns
    -------
    numpy.ndarray, shape (4,)
    """
    if answer is None:
        raise CheckFailed(
            "The function returned None for three points that have a plane.",
            given=_three(triangle),
            yours="None",
            expected="four numbers (a, b, c, d)",
            hint="None is for points on one line alone. Does every other way through the function "
            "end with `return` and the four numbers?",
        )
    return as_plane(answer)


def assert_upright(answer: object, triangle: np.ndarray) -> None:
    """The normal is perpendicular to a triangle; its length and d are not looked at.

    Parameters
    ----------
    answer : object
    triangle : numpy.ndarray, shape (3, 3)
    """
    plane = plane_of(answer, triangle)
    sides = np.roll(triangle, -1, axis=0) - triangle
    lengths = np.linalg.norm(sides, axis=1) * np.linalg.norm(plane[:3])
    leaning = np.degrees(np.arcsin(np.clip(np.abs(sides @ plane[:3]) / lengths, 0, 1))).max()
    if leaning > 0.1:
        raise CheckFailed(
            f"(a, b, c) is not perpendicular to the triangle: it is off by {leaning:.1f} degrees.",
            given=_three(triangle),
            yours=_text(plane),
            expected=_beside(plane, best_plane(triangle)[0]),
        )


def assert_through(answer: object, triangle: np.ndarray) -> None:
    """Three points lie on the plane.

    Parameters
    ----------
    answer : object
    triangle : numpy.ndarray, shape (3, 3)
    """
    plane = plane_of(answer, triangle)
    worst = triangle[np.argmax(gaps_from(triangle, plane))]
    if gaps_from(worst[None], plane)[0] > 2e-3:
        raise CheckFailed(
            f"The points do not lie on the plane: at {point_text(worst)}, for example, "
            f"a x + b y + c z + d is {worst @ plane[:3] + plane[3]:.3g}, not 0.",
            given=_three(triangle),
            yours=_text(plane),
            expected=_beside(plane, best_plane(triangle)[0]),
        )


def assert_no_plane(answer: object, line: np.ndarray, nearly: str = "") -> None:
    """The answer to three points on one line is None.

    Parameters
    ----------
    answer : object
    line : numpy.ndarray, shape (3, 3)
    nearly : str
        How far they lie beside it, for the message.
    """
    if answer is not None:
        raise CheckFailed(
            f"These three points lie on one line{nearly}: infinitely many planes go through them.",
            given=_three(line),
            yours=brief(as_array(answer, what="None, or four numbers")),
            expected="None",
        )


def assert_fits_triangles(plane_through: Callable) -> None:
    """The normal is right; where not, its length and d cannot be looked at."""
    with needs("the normal is perpendicular to the triangle"):
        for triangle in _TRIANGLES[2:]:
            assert_upright(plane_through(*triangle.copy()), triangle)


def assert_gives_planes(plane_through: Callable) -> None:
    """There is a plane for points that have one; where not, None for others says nothing."""
    with needs("three points that are not on one line give a plane"):
        for triangle in _TRIANGLES[:2]:
            plane_of(plane_through(*triangle.copy()), triangle)


def _three(triangle: np.ndarray) -> str:
    return ", ".join(f"{name} {point_text(p)}" for name, p in zip("pqr", triangle, strict=True))


def _beside(plane: np.ndarray, expected: np.ndarray) -> str:
    """The right plane as text, with the sign that stands nearer to another one."""
    return f"{_text(expected if expected[:3] @ plane[:3] >= 0 else -expected)} or its negative"


def _text(plane: np.ndarray | None) -> str:
    if plane is None:
        return "None"
    return f"[{', '.join(f'{value:.6g}' for value in np.round(plane, 3) + 0.0)}]"


@visible(
    "plane_through",
    weight=3,
    title="(a, b, c) is perpendicular to the triangle",
    why="The normal is the direction of the plane: a road whose normal leans runs into the sky.",
    hint="The cross product of q - p and r - p is perpendicular to both.",
)
def stands_upright(plane_through: Callable) -> None:
    for triangle in _TRIANGLES:
        assert_upright(plane_through(*triangle.copy()), triangle)


@visible(
    "plane_through",
    weight=2,
    title="The three points lie on the plane",
    why="Everything else, distances and inliers, is measured from this plane.",
    hint="Choose d so that a x + b y + c z + d is 0 at p, with the same a, b, c that you return.",
)
def holds_its_points(plane_through: Callable) -> None:
    assert_fits_triangles(plane_through)
    for triangle in _TRIANGLES:
        assert_through(plane_through(*triangle.copy()), triangle)


@visible(
    "plane_through",
    weight=2,
    title="The normal has length 1",
    why="Only then is a x + b y + c z + d a distance in metres, and 0.2 means 20 cm.",
    hint="Divide the cross product by np.linalg.norm of it, and compute d afterwards.",
)
def has_a_unit_normal(plane_through: Callable) -> None:
    assert_fits_triangles(plane_through)
    for triangle in _LARGE_AND_SMALL:
        assert_unit_normal(plane_of(plane_through(*triangle.copy()), triangle))


@visible(
    "plane_through",
    weight=2,
    title="Returns None for points on one line",
    why="Three such points fix no plane, and 0 / 0 would spread through all distances. On a "
    "drive with ten scans a second even what is rare comes up.",
    hint="When the cross product has length 0, return None before dividing by it.",
)
def refuses_a_line(plane_through: Callable) -> None:
    assert_gives_planes(plane_through)
    for line in _LINES:
        assert_no_plane(plane_through(*line.copy()), line)


@visible(
    "plane_through",
    weight=1,
    title="Sees a line through rounding errors",
    why="Measured points are never whole numbers: the cross product of a line is hardly ever "
    "exactly 0.",
    hint="Do not compare a computed length with exactly 0: compare it with something tiny, "
    "such as 1e-9.",
)
def sees_through_rounding(plane_through: Callable) -> None:
    assert_gives_planes(plane_through)
    with needs("points that lie exactly on one line have no plane"):
        assert_no_plane(plane_through(*_LINES[0].copy()), _LINES[0])
    start, step = np.array([0.1, 0.2, 0.3]), np.array([0.7, 0.1, -0.3])
    line = np.array([start, start + 0.1 * step, start + 0.7 * step])
    nearly = ", but for the last digit of a float"
    assert_no_plane(plane_through(*line.copy()), line, nearly)


@visible(
    "plane_through",
    weight=1,
    title="A small triangle has a plane, too",
    why="Neighbouring returns are centimetres apart: their cross product is short, but not 0.",
    hint="Refuse only what is as good as 0, such as a length below 1e-9.",
)
def takes_a_small_triangle(plane_through: Callable) -> None:
    assert_fits_triangles(plane_through)
    answer = plane_through(*_TINY.copy())
    if answer is None:
        raise CheckFailed(
            "These points are 8 and 10 cm apart and not on one line: they have a plane.",
            given=_three(_TINY),
            yours="None",
            expected=_text(best_plane(_TINY)[0]),
        )
    assert_upright(answer, _TINY)


@visible(
    "plane_through",
    weight=1,
    title="Leaves its points untouched",
    why="The sample is part of the cloud: a point that moves is a wrong point for ever.",
    hint="Give q - p and r - p names of their own; q -= p would move q.",
)
def leaves_its_points(plane_through: Callable) -> None:
    assert_fits_triangles(plane_through)
    assert_untouched(plane_through, *_TRIANGLES[2].copy())


@visible(
    "plane_through",
    weight=1,
    title="The parameters keep their names: p, q and r",
    why="Whoever reads the docstring calls plane_through(p=..., q=..., r=...).",
    hint="Keep the first line of the function as it was given.",
)
def keeps_p_q_r(plane_through: Callable) -> None:
    assert_fits_triangles(plane_through)
    p, q, r = _TRIANGLES[2].copy()
    assert_upright(plane_through(p=p, q=q, r=r), _TRIANGLES[2])


def _same_plane(answer: object, predicted: object) -> bool:
    """Whether an answer is these four numbers, or their negatives."""
    return same_array(answer, predicted) or same_array(answer, -np.asarray(predicted))


def _long_side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> float:
    """Twice the area of a triangle, from the lengths of its sides: as long is the cross product."""
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
        lambda right, *points: right * [1, 1, 1, _long_side(*points)],
        "Divide by the length first, and compute d from what comes out.",
    ),
    Mistake(
        "The cross product is not divided by its length.",
        lambda right, *points: right * _long_side(*points),
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
        lambda right, p, q, r: _plane_at(p, best_plane(np.array([0 * p, q - p, r]))[0][:3]),
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
    same=_same_plane,
)


# A unit normal in no special direction, and points in front of the plane through the sensor.
_NORMAL = (0.6, 0.0, 0.8)
_IN_FRONT = frozen(
    np.array(
        [
            [0.0, 0.0, 2.0, 0.9],
            [0.0, 5.0, 0.5, 0.1],
            [3.0, -4.0, 1.0, 0.5],
            [10.0, 1.0, -2.0, 0.3],
            [-1.0, 2.0, 9.0, 0.7],
        ]
    )
)
_BEHIND = frozen(_IN_FRONT * [-1, 1, -1, 1] + 0.0)


def distances_by_hand(points: np.ndarray, plane: ArrayLike) -> np.ndarray:
    """The right answer to `point_plane_distance`, point by point.

    Parameters
    ----------
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    plane : (4,) array_like

    Returns
    -------
    numpy.ndarray, shape (n,)
    """
    return np.array([abs(one) for one in _signed(points, plane)])


def _signed(points: np.ndarray, plane: ArrayLike) -> list[float]:
    a, b, c, d = map(float, plane)
    return [math.fsum((a * x, b * y, c * z, d)) for x, y, z in points[:, :3].astype(float).tolist()]


def assert_distances(answer: object, points: np.ndarray, plane: ArrayLike) -> None:
    """The answer is the distance of each point from a plane.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    plane : (4,) array_like
        With a unit normal.
    """
    expected = distances_by_hand(points, plane)
    yours = as_array(answer, what="an array of distances")
    assert_shape(
        yours,
        expected.shape,
        f"one distance for each of the {len(points)} points"
        if len(points) != 1
        else "one distance, in an array, for one point",
        columns=points.shape[1],
    )
    wrong = np.flatnonzero(~(np.abs(yours - expected) <= 1e-3))
    if len(wrong):
        first = wrong[0]
        count = f"{len(wrong)} of {len(expected)} distances {'is' if len(wrong) == 1 else 'are'}"
        raise CheckFailed(
            f"{count if len(expected) > 1 else 'The distance is'} not right.",
            given=f"point {point_text(points[first])}, plane {brief(np.asarray(plane, float))}",
            yours=f"{yours[first]:.4g} m",
            expected=f"{expected[first]:.4g} m",
        )


def assert_ignores_intensity(
    point_plane_distance: Callable, cloud: np.ndarray, plane: np.ndarray
) -> None:
    """A cloud has the same distances with and without its fourth column, right or wrong.

    Parameters
    ----------
    point_plane_distance : callable
    cloud : numpy.ndarray, shape (n, 4)
    plane : numpy.ndarray, shape (4,)
    """
    plain, yours = (
        as_array(point_plane_distance(points.copy(), plane.copy()), what="an array of distances")
        for points in (cloud[:, :3], cloud)
    )
    for distances in (plain, yours):
        each = f"one distance for each of the {len(cloud)} points"
        assert_shape(distances, (len(cloud),), each, columns=4)
    if not np.abs(yours - plain).max() <= 1e-3:
        raise CheckFailed(
            "With the intensity in a fourth column the distances are others than without it.",
            given=f"a plane with d = {plane[3]:.3g}",
            yours=brief(yours),
            expected=brief(plain),
        )


@once
def assert_measures(point_plane_distance: Callable) -> None:
    """The plain case: planes through the sensor, points in front of them."""
    with needs("the distances from a plane through the sensor are right"):
        _assert_plain(point_plane_distance)


def _assert_plain(point_plane_distance: Callable) -> None:
    xyz = _IN_FRONT[:, :3]
    for plane, points in (
        ((*_NORMAL, 0.0), xyz),
        ((0.0, 0.6, 0.8, 0.0), np.abs(xyz)),
        ((1.0, 0.0, 0.0, 0.0), np.abs(xyz)),
    ):
        answer = point_plane_distance(points.copy(), np.array(plane))
        assert_distances(answer, points, plane)


@visible(
    "point_plane_distance",
    weight=4,
    title="Right for planes through the sensor",
    why="A distance that is wrong by a factor makes a threshold of 20 cm one of 5 cm or 80 cm.",
    hint="a x + b y + c z for every point: each coordinate times its own part of the normal.",
)
def measures_distances(point_plane_distance: Callable) -> None:
    _assert_plain(point_plane_distance)


@visible(
    "point_plane_distance",
    weight=2,
    title="Right for planes anywhere: d counts",
    why="The road lies 1.7 m below the sensor; without d every plane goes through the sensor.",
    hint="Add d to a x + b y + c z.",
)
def adds_d(point_plane_distance: Callable) -> None:
    assert_measures(point_plane_distance)
    for offset in (2.0, -0.25):
        plane = np.array([*_NORMAL, offset])
        answer = point_plane_distance(_IN_FRONT[:, :3].copy(), plane.copy())
        assert_distances(answer, _IN_FRONT, plane)


@visible(
    "point_plane_distance",
    weight=2,
    title="A distance has no sign: right on both sides of the plane",
    why="With a sign, everything below the road is nearer than any threshold.",
    hint="A distance is never negative: np.abs.",
)
def forgets_the_sign(point_plane_distance: Callable) -> None:
    assert_measures(point_plane_distance)
    plane = np.array([*_NORMAL, 0.0])
    assert_distances(
        point_plane_distance(_BEHIND[:, :3].copy(), plane.copy()), _BEHIND[:, :3], plane
    )
    both = np.concatenate([_IN_FRONT, _BEHIND])[:, :3]
    assert_distances(point_plane_distance(both.copy(), -plane), both, -plane)


@visible(
    "point_plane_distance",
    weight=1,
    title="The absolute value is that of the whole sum, d included",
    why="A road is below the sensor: there a x + b y + c z and d have opposite signs.",
    hint="np.abs around everything: first the sum with d, then its absolute value.",
)
def takes_abs_last(point_plane_distance: Callable) -> None:
    with needs("d counts, and no distance has a sign"):
        adds_d(point_plane_distance)
        forgets_the_sign(point_plane_distance)
    both = np.concatenate([_IN_FRONT, _BEHIND])[:, :3]
    for offset in (2.0, -2.0):
        plane = np.array([*_NORMAL, offset])
        assert_distances(point_plane_distance(both.copy(), plane.copy()), both, plane)


@visible(
    "point_plane_distance",
    weight=2,
    title="The fourth column does not count",
    why="(n, 4) times (4,) works without an error, and multiplies brightness with d.",
    hint="Take points[:, :3] and the first three numbers of the plane; add the last one.",
)
def ignores_intensity(point_plane_distance: Callable) -> None:
    assert_measures(point_plane_distance)
    plane = np.array([*_NORMAL, 1.5])
    assert_ignores_intensity(point_plane_distance, _IN_FRONT * [1, 1, 1, 255], plane)


@visible(
    "point_plane_distance",
    weight=1,
    title="The plane may be a tuple",
    why="plane_through may return one.",
    hint="A tuple does not calculate: take its numbers one by one, or np.asarray(plane).",
)
def takes_a_tuple(point_plane_distance: Callable) -> None:
    assert_measures(point_plane_distance)
    xyz = _IN_FRONT[:, :3]
    assert_distances(point_plane_distance(xyz.copy(), (*_NORMAL, 0.0)), xyz, (*_NORMAL, 0.0))


@visible(
    "point_plane_distance",
    weight=1,
    title="Takes one point, and none",
    why="After other filters little may be left, or nothing.",
    hint="points[:, :3] @ normal has one number for each row, however many rows there are.",
)
def takes_few_points(point_plane_distance: Callable) -> None:
    assert_measures(point_plane_distance)
    plane = np.array([*_NORMAL, 0.0])
    for points in (_IN_FRONT[2:3, :3], _IN_FRONT[:0, :3]):
        assert_distances(point_plane_distance(points.copy(), plane.copy()), points, plane)


@visible(
    "point_plane_distance",
    weight=1,
    title="Leaves points and plane untouched",
    why="The next plane is measured against the same points.",
    hint="Build a new array: points[:, :3] @ normal does, points *= normal does not.",
)
def leaves_cloud_and_plane(point_plane_distance: Callable) -> None:
    assert_measures(point_plane_distance)
    assert_untouched(point_plane_distance, _BEHIND[:, :3], np.array([*_NORMAL, 2.0]))


@visible(
    "point_plane_distance",
    weight=1,
    title="The parameters keep their names: points and plane",
    why="Whoever reads the docstring calls point_plane_distance(points=..., plane=...).",
    hint="Keep the first line of the function as it was given.",
)
def keeps_points_and_plane(point_plane_distance: Callable) -> None:
    assert_measures(point_plane_distance)
    xyz, plane = _IN_FRONT[:, :3], np.array([*_NORMAL, 0.0])
    assert_distances(point_plane_distance(points=xyz.copy(), plane=plane.copy()), xyz, plane)


@visible(
    "point_plane_distance",
    weight=1,
    title="The distances are a NumPy array",
    why="ransac_plane compares all of them with its threshold at once; a list cannot do that.",
    hint="Whole columns give an array. If you build a list, wrap it in np.array(...).",
)
def gives_an_array(point_plane_distance: Callable) -> None:
    assert_measures(point_plane_distance)
    answer = point_plane_distance(_IN_FRONT[:, :3].copy(), np.array([*_NORMAL, 0.0]))
    if not isinstance(answer, np.ndarray):
        raise CheckFailed(
            "These are the right numbers, but they are no array.",
            yours=f"{type(answer).__name__} {brief(answer)}",
            expected="a NumPy array",
        )


def _each(points: np.ndarray, plane: ArrayLike) -> np.ndarray:
    """The three products and d of each point, without their signs; shape (n, 4)."""
    return np.abs(np.column_stack([points[:, :3], np.ones(len(points))]) * np.asarray(plane))


mistakes(
    "point_plane_distance",
    Mistake(
        "No absolute value is taken: behind the plane the distances are negative.",
        lambda right, points, plane: _signed(points, plane),
        "np.abs of the whole sum.",
    ),
    Mistake(
        "d is missing: these are the distances from the parallel plane through the sensor.",
        lambda right, points, plane: distances_by_hand(points, [*plane[:3], 0]),
        "Add d to a x + b y + c z.",
    ),
    Mistake(
        "d is subtracted; it must be added.",
        lambda right, points, plane: distances_by_hand(points, [*plane[:3], -plane[3]]),
    ),
    Mistake(
        "The absolute value is taken of a x + b y + c z, and d is added after that.",
        lambda right, points, plane: distances_by_hand(points, [*plane[:3], 0]) + plane[3],
        "np.abs around everything: first the sum with d, then its absolute value.",
    ),
    Mistake(
        "The absolute values of a x + b y + c z and of d are taken apart and then added.",
        lambda right, points, plane: distances_by_hand(points, [*plane[:3], 0]) + abs(plane[3]),
        "np.abs around everything: first the sum with d, then its absolute value.",
    ),
    Mistake(
        "The absolute value is taken of each product, and then they are added.",
        lambda right, points, plane: _each(points, plane)[:, :3].sum(axis=1) + plane[3],
        "np.abs around everything: first the sum with d, then its absolute value.",
    ),
    Mistake(
        "The absolute value is taken of a x, of b y, of c z and of d, and then they are added.",
        lambda right, points, plane: _each(points, plane).sum(axis=1),
        "np.abs around everything: first the sum with d, then its absolute value.",
    ),
    Mistake(
        "These are the squares of the distances.",
        lambda right, points, plane: right**2,
        "Nothing has to be squared here: the normal has length 1.",
    ),
    Mistake(
        "The sum is divided by the length of all four numbers of the plane; d is no part of the "
        "normal.",
        lambda right, points, plane: right / math.hypot(*plane),
        "The normal (a, b, c) has length 1 already: nothing has to be divided.",
    ),
    Mistake(
        "Whole rows are multiplied with the plane, so that d is multiplied with the intensity.",
        lambda right, points, plane: np.abs(
            np.subtract(_signed(points, plane), plane[3] * (1 - points[:, 3]))
        ),
        "Take points[:, :3] and the first three numbers of the plane; add the last one.",
    ),
    cases=(
        (
            np.array([[1.0, 2.0, 3.0, 0.5], [-4.0, 1.0, -2.0, 0.3], [0.0, -3.0, 1.0, 0.9]]),
            np.array([0.6, 0.0, 0.8, 1.0]),
        ),
        (
            np.array([[2.0, 9.0, 1.0, 0.2], [-5.0, -2.0, 4.0, 0.7]]),
            np.array([0.0, 0.8, -0.6, -2.0]),
        ),
        (
            np.array([[6.0, 1.0, -2.0, 0.4], [3.0, 3.0, -1.5, 0.8], [-7.0, 2.0, 0.0, 0.1]]),
            np.array([0.0, 0.0, 1.0, 1.7]),
        ),
        (
            np.array([[-1.0, -2.0, -5.0, 0.6], [4.0, 4.0, 4.0, 0.3]]),
            np.array([-2 / 3, 2 / 3, 1 / 3, -0.5]),
        ),
    ),
    right=distances_by_hand,
)


def scattered_plane(
    seed: int,
    n_plane: int,
    n_outliers: int,
    plane: ArrayLike | None = None,
    noise: float = 0.01,
    columns: int = 3,
) -> tuple[np.ndarray, np.ndarray]:
    """Points on a plane, 12 m across, and others beside it, mixed.

    Parameters
    ----------
    seed : int
    n_plane, n_outliers : int
    plane : (4,) array_like, optional
        With a unit normal; by default a slope of 11 to 20 degrees, another one for each seed.
    noise : float
        Standard deviation across the plane in metres.
    columns : {3, 4}

    Returns
    -------
    points : numpy.ndarray, shape (n_plane + n_outliers, columns)
        The fourth column is an intensity from 0 to 255.
    belongs : numpy.ndarray of bool
        True for the points of the plane.
    """
    rng = np.random.default_rng(seed)
    if plane is None:
        tilt, heading = rng.uniform(0.2, 0.35), rng.uniform(0, 2 * np.pi)
        level = np.sin(tilt) * np.array([np.cos(heading), np.sin(heading)])
        plane = (*level, np.cos(tilt), rng.choice((-1, 1)) * rng.uniform(1, 4))
    normal = np.asarray(plane[:3], dtype=float)
    across = np.cross(normal, (1.0, 0.0, 0.0) if abs(normal[0]) < 0.9 else (0.0, 1.0, 0.0))
    across /= np.linalg.norm(across)
    along = np.cross(normal, across)
    n = n_plane + n_outliers
    belongs = rng.permutation(n) < n_plane
    places = rng.uniform(-6, 6, (n, 2))
    gaps = np.where(
        belongs,
        np.clip(rng.normal(0, noise, n), -3 * noise, 3 * noise),
        rng.choice((-1, 1), n) * rng.uniform(0.6, 4.0, n),
    )
    points = places[:, :1] * across + places[:, 1:] * along + (gaps - plane[3])[:, None] * normal
    if columns == 4:
        points = np.column_stack([points, rng.integers(0, 256, n)])
    return points, belongs


def _pair(answer: object) -> Sequence:
    if answer is None:
        raise WrongForm(
            "The function returned None. Does every way through it end with `return`?",
            yours="None",
            expected="(model, inliers)",
        )
    if not isinstance(answer, (tuple, list)) or len(answer) != 2:
        raise WrongForm(
            "Return two things, the model and the mask: `return model, inliers`.",
            yours=brief(answer),
            expected="(model, inliers)",
        )
    return answer


def model_of(answer: object, given: str | None = None) -> np.ndarray:
    """The model of an answer where there is one to find; the mask is not looked at.

    Parameters
    ----------
    answer : object
    given : str, optional
        What the function was given, for the message.

    Returns
    -------
    numpy.ndarray, shape (4,)
        With a normal of whatever length.
    """
    model, _ = _pair(answer)
    if model is None:
        raise CheckFailed(
            "There is a plane, and none was found: the model is None.",
            given=given,
            yours="None",
            expected="four numbers (a, b, c, d)",
        )
    if as_array(model, what="four numbers (a, b, c, d)").dtype.kind == "b":
        raise WrongForm(
            "The first of the two things that are returned is a mask; the model comes first: "
            "`return model, inliers`.",
            yours=brief(model),
            expected="four numbers (a, b, c, d)",
        )
    return as_plane(model)


def mask_of(answer: object, n: int) -> np.ndarray:
    """The mask of an answer; the model is not looked at.

    Parameters
    ----------
    answer : object
    n : int
        Number of points.

    Returns
    -------
    numpy.ndarray of bool, shape (n,)
    """
    mask = as_array(_pair(answer)[1], what="a mask of True and False")
    if mask.shape == (0,) and n == 0:
        return mask.astype(bool)
    if mask.dtype != bool:
        raise WrongForm(
            "The inliers must be a mask, one True or False per point, not numbers or indices.",
            yours=brief(mask),
            expected=f"{n} times True or False",
        )
    assert_shape(mask, (n,), "one True or False for each point")
    return mask


def assert_finds(
    answer: object,
    points: np.ndarray,
    distance_tolerance: float,
    belongs: np.ndarray,
    share: float = 0.9,
    given: str | None = None,
) -> None:
    """At least a share of the points that belong lie near the model; the mask is not looked at.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    distance_tolerance : float
    belongs : numpy.ndarray of bool, shape (n,)
    share : float
    given : str, optional
        What the function was given, for the message.
    """
    plane = model_of(answer, given)
    near = gaps_from(points, plane) <= distance_tolerance
    found, whole = np.count_nonzero(near & belongs), np.count_nonzero(belongs)
    if found < share * whole:
        share_of_all = f"{whole} of the" if whole < len(points) else "all"
        raise CheckFailed(
            "A plane with many more points near it exists: "
            f"{share_of_all} {len(points)} points lie on it.",
            given=given,
            yours=f"{np.count_nonzero(near)} points within {distance_tolerance:g} m",
            expected=f"about {whole}",
            draw=lambda: _draw(
                points, plane, near, distance_tolerance, best_plane(points[belongs])[0]
            ),
        )


def assert_mask_belongs(answer: object, points: np.ndarray) -> None:
    """The inliers are the points nearest to the model; up to which distance is another property.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    """
    plane, mask = model_of(answer), mask_of(answer, len(points))
    gaps = gaps_from(points, plane)
    if not mask.any():
        raise CheckFailed(
            "There is a model, and the mask says that no point is near it.",
            yours="0 inliers",
            expected=f"at least the 3 points that the plane goes through; the nearest point is "
            f"{gaps.min():.2g} m away",
        )
    farthest, nearest = gaps[mask].max(), gaps[~mask].min(initial=np.inf)
    if farthest > nearest + 1e-4:
        raise CheckFailed(
            "The mask does not belong to the returned model: a point that is "
            f"{nearest:.3f} m away from that plane is no inlier, and one that is {farthest:.3f} m "
            "away is.",
            yours=f"{np.count_nonzero(mask)} inliers",
            draw=lambda: _draw(points, plane, mask, None),
        )


def assert_mask_follows(answer: object, points: np.ndarray, distance_tolerance: float) -> None:
    """The inliers are the points within the tolerance of the model; at the border both are right.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    distance_tolerance : float
    """
    plane, mask = model_of(answer), mask_of(answer, len(points))
    gaps = gaps_from(points, plane)
    clear = np.abs(gaps - distance_tolerance) > 1e-4
    wrong = np.flatnonzero((mask != (gaps <= distance_tolerance)) & clear)
    if len(wrong):
        first = wrong[0]
        word = "an" if mask[first] else "no"
        raise CheckFailed(
            f"With distance_tolerance={distance_tolerance:g} a point that is {gaps[first]:.3f} m "
            f"away from the returned plane is {word} inlier.",
            yours=f"{np.count_nonzero(mask)} inliers",
            expected=f"{np.count_nonzero(gaps <= distance_tolerance)} inliers",
            draw=lambda: _draw(points, plane, mask, distance_tolerance),
        )


def assert_nothing_found(answer: object, n: int) -> None:
    """The answer is (None, all False): there is no plane.

    Parameters
    ----------
    answer : object
    n : int
        Number of points.
    """
    model, inliers = _pair(answer)
    if model is not None:
        raise CheckFailed(
            "No plane can be found here: the model must be None.",
            yours=brief(model),
            expected="None",
        )
    if mask_of(answer, n).any():
        raise CheckFailed(
            "Without a model there are no inliers: the mask must be all False.",
            yours=brief(np.asarray(inliers)),
            expected="all False",
        )


def _draw(
    points: np.ndarray,
    plane: np.ndarray,
    inliers: np.ndarray | None,
    tolerance: float | None,
    expected: np.ndarray | None = None,
) -> Axes:
    """Draw points so that a plane is seen edge on, as a line; the right one too, and level."""
    plane = _unit(plane)
    level = plane if expected is None else expected
    level = level * (1 if level[2] >= 0 else -1)
    plane = plane * (1 if plane[:3] @ level[:3] >= 0 else -1)
    # The direction in which the plane rises above the level one, or any where it does not.
    along = plane[:3] - plane[:3] @ level[:3] * level[:3]
    if np.linalg.norm(along) < 1e-6:
        along = np.linalg.svd(level[None, :3])[2][1]
    along /= np.linalg.norm(along)
    turn = np.column_stack([along, np.cross(level[:3], along), level[:3]])
    seen = np.append(plane[:3] @ turn, plane[3])
    turned = points[:, :3] @ turn
    heights = [*turned[:, 2], -level[3], *([-plane[3] / seen[2]] if seen[2] > 0.5 else [])]
    limits = [(min(row) - 0.3, max(row) + 0.3) for row in (turned[:, 0], heights)]
    axes = utils.plots.plane_model(turned, seen, inliers, tolerance, title="yours", limits=limits)
    axes.set_xlabel("along the plane (m)")
    axes.set_ylabel("across it (m)")
    if expected is not None:
        axes.axhline(-level[3], color="black", linestyle="--")
        axes.text(axes.get_xlim()[0], -level[3], " expected", va="bottom")
    return axes


@once
def assert_works(ransac_plane: Callable) -> None:
    """A plane is found among outliers; where not, most properties cannot be looked at."""
    with needs("the plane is found among the outliers"):
        for seed in (1, 2, 3):
            points, belongs = scattered_plane(seed, 60, 20, noise=0.02)
            # One sample in three is good: 0.67^60 < 1e-10.
            answer = ransac_plane(points.copy(), 60, 0.2, np.random.default_rng(seed))
            assert_finds(answer, points, 0.2, belongs)


def assert_runs(ransac_plane: Callable) -> None:
    """Where all points lie on one plane, it comes out, whichever sample it was made from."""
    with needs("a plane is found where there is nothing else"):
        points, belongs = scattered_plane(2, 40, 0)
        answer = ransac_plane(points.copy(), 30, 0.3, np.random.default_rng(2))
        assert_finds(answer, points, 0.5, belongs, share=0.5)


@once
def _assert_masks_belong(ransac_plane: Callable) -> None:
    for seed in range(4):
        points, _ = scattered_plane(10 + seed, 50, 20, noise=0.1)
        rng = np.random.default_rng(seed)
        for iterations in (12, 30):
            assert_mask_belongs(ransac_plane(points.copy(), iterations, 0.2, rng), points)


def ring_on_a_ramp(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Whole-numbered points of the ramp z = y / 4 - 3, most of them on one line, mixed.

    More than half of all samples are no plane, exactly; all others give this one.

    Parameters
    ----------
    rng : numpy.random.Generator

    Returns
    -------
    points : numpy.ndarray, shape (48, 3)
    belongs : numpy.ndarray of bool
        All True.
    """
    ring = np.column_stack([np.arange(40), np.full(40, 4), np.full(40, -2)])
    up = rng.integers(2, 8, 8)
    others = np.column_stack([rng.integers(0, 40, 8), 4 * up, up - 3])
    return rng.permutation(np.concatenate([ring, others])).astype(float), np.ones(48, dtype=bool)


def _crowd_on_a_plane(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of a plane, half of them at one and the same place, mixed."""
    points, belongs = scattered_plane(seed, 40, 0)
    points[:20] = points[0]
    return np.random.default_rng(seed).permutation(points), belongs


@visible(
    "ransac_plane",
    weight=5,
    title="Finds the plane among the outliers",
    why="The largest plane of a street is the road. What is not road may be an obstacle.",
    hint="Take three rows, make a plane, count how many points are near it; keep the plane "
    "with the highest count, and return it after the last round, not inside the loop.",
)
def finds_the_plane(ransac_plane: Callable) -> None:
    on_the_floor = _SEVEN[:, 2] == -1.7
    # Two samples in seven are good: 0.714^80 < 1e-11.
    answer = ransac_plane(_SEVEN.copy(), 80, 0.1, np.random.default_rng(1))
    assert_finds(
        answer, _SEVEN, 0.1, on_the_floor, given="seven points: five on a floor at z = -1.7"
    )
    for seed in (1, 2, 3):
        points, belongs = scattered_plane(seed, 60, 30, noise=0.02)
        rng = np.random.default_rng(seed)
        # More than one sample in five is good: 0.77^90 < 1e-10.
        assert_finds(ransac_plane(points.copy(), 90, 0.2, rng), points, 0.2, belongs)


@visible(
    "ransac_plane",
    weight=3,
    title="Returns the model and the mask that belongs to it",
    why="Who gets the plane of one sample and the inliers of another removes the wrong points.",
    hint="When a sample is better than the best so far, keep both, plane and mask.",
)
def mask_belongs_to_model(ransac_plane: Callable) -> None:
    assert_works(ransac_plane)
    _assert_masks_belong(ransac_plane)


@visible(
    "ransac_plane",
    weight=2,
    title="Inliers are the points within distance_tolerance",
    why="The pavement lies a hand above the road. The threshold decides whether it is an inlier.",
    hint="Compare the distances with distance_tolerance, not with a number of your own.",
)
def follows_the_tolerance(ransac_plane: Callable) -> None:
    assert_works(ransac_plane)
    with needs("the mask belongs to the model"):
        _assert_masks_belong(ransac_plane)
    points, _ = scattered_plane(21, 90, 0, noise=0.2)
    for tolerance in (0.05, 0.12, 0.35):
        answer = ransac_plane(points.copy(), 30, tolerance, np.random.default_rng(5))
        assert_mask_follows(answer, points, tolerance)


@visible(
    "ransac_plane",
    weight=1,
    title="The model's normal has length 1",
    why="The next cells measure heights above the road with these four numbers, in metres.",
    hint="plane_through divides by the length already: return its four numbers as they are.",
)
def model_has_a_unit_normal(ransac_plane: Callable) -> None:
    assert_works(ransac_plane)
    points, _ = scattered_plane(25, 60, 0)
    answer = ransac_plane(points.copy(), 40, 0.2, np.random.default_rng(4))
    model_of(answer)
    assert_unit_normal(answer[0])


@visible(
    "ransac_plane",
    weight=2,
    title="Tries as many samples as max_iterations allows",
    why="Rounds are certainty: the fewer points belong to the plane, the more it takes.",
    hint="for _ in range(max_iterations): one sample in each round, and `return` after the loop.",
)
def tries_enough(ransac_plane: Callable) -> None:
    assert_works(ransac_plane)
    points, belongs = scattered_plane(31, 20, 40)
    rng = np.random.default_rng(6)
    assert_finds(ransac_plane(points.copy(), 800, 0.2, rng), points, 0.2, belongs)


@visible(
    "ransac_plane",
    weight=1,
    title="Tries no more samples than max_iterations",
    why="Rounds are time: the next frame comes in a tenth of a second.",
    hint="for _ in range(max_iterations): one sample in each round.",
)
def tries_no_more(ransac_plane: Callable) -> None:
    assert_works(ransac_plane)
    points, belongs = scattered_plane(32, 20, 40)
    lucky = 0
    for seed in range(24):
        model, _ = _pair(ransac_plane(points.copy(), 1, 0.2, np.random.default_rng(seed)))
        if model is not None:
            near = gaps_from(points, as_plane(model)) <= 0.2
            lucky += np.count_nonzero(near & belongs) > 17
    if lucky > 14:  # expected: less than one
        raise CheckFailed(
            "With max_iterations=1 this plane comes out again and again; one single sample hardly "
            "ever finds it. More are tried than allowed.",
            yours=f"found in {lucky} runs of 24",
            expected="in 1 or 2, perhaps in none",
        )


@visible(
    "ransac_plane",
    weight=3,
    title="Goes on after samples that are no plane",
    why="Duplicates and points in a line are common; one of them must not end the drive.",
    hint="plane_through returns None for them: go on with the next sample. And count that "
    "round, or the loop may never end.",
)
def survives_degenerate_samples(ransac_plane: Callable) -> None:
    for seed in range(4):
        ramp, crowd = ring_on_a_ramp(np.random.default_rng(seed)), _crowd_on_a_plane(40 + seed)
        for (points, belongs), given in (
            (ramp, "48 points of one plane, 40 of them on one line"),
            (crowd, "40 points of one plane, 20 of them at one and the same place"),
        ):
            # Four samples in ten are good: 0.58^40 < 1e-9.
            answer = ransac_plane(points.copy(), 40, 0.2, np.random.default_rng(seed))
            assert_finds(answer, points, 0.2, belongs, given=given)


@visible(
    "ransac_plane",
    weight=2,
    title="Returns (None, all False) for fewer than three points",
    why="After other filters little may be left, and the car must not stop for that.",
    hint="Ask for len(points) < 3 first, and return None and np.zeros(n, dtype=bool).",
)
def gives_up_politely(ransac_plane: Callable) -> None:
    assert_runs(ransac_plane)
    for n in (0, 1, 2):
        for columns in (3, 4):
            points = np.arange(float(n * columns)).reshape(n, columns)
            rng = np.random.default_rng(9)
            assert_nothing_found(ransac_plane(points.copy(), 5, 0.2, rng), n)


@visible(
    "ransac_plane",
    weight=1,
    title="Returns (None, all False) where all points lie on one line",
    why="A single ring of the scanner on a wall is a line: no sample of it is a plane.",
    hint="Begin with model = None and a mask that is all False: where no sample gives a plane, "
    "they are the answer.",
)
def finds_nothing_on_a_line(ransac_plane: Callable) -> None:
    assert_runs(ransac_plane)
    line = np.outer(np.arange(12.0), [1.0, 2.0, 1.0])
    assert_nothing_found(ransac_plane(line.copy(), 20, 0.2, np.random.default_rng(8)), 12)


@visible(
    "ransac_plane",
    weight=2,
    title="Takes three different rows",
    why="A row that comes up twice makes a sample of two points: a round that is lost.",
    hint="rng.choice(len(points), 3, replace=False) never takes a row twice.",
)
def draws_three_rows(ransac_plane: Callable) -> None:
    assert_works(ransac_plane)
    for seed, triangle in enumerate(np.concatenate([_TRIANGLES[:1], _LARGE_AND_SMALL[:1]] * 6)):
        answer = ransac_plane(triangle.copy(), 1, 0.2, np.random.default_rng(seed))
        assert_takes_all_three(answer, triangle)


def assert_takes_all_three(answer: object, triangle: np.ndarray) -> None:
    """The plane goes through three points, where one sample was drawn of just these.

    Parameters
    ----------
    answer : object
    triangle : numpy.ndarray, shape (3, 3)
    """
    model, _ = _pair(answer)
    if model is None or gaps_from(triangle, as_plane(model)).max() > 2e-3:
        raise CheckFailed(
            "Of three points there is only one sample, all three, and it gives a plane; yours "
            "took another sample.",
            given=f"{_three(triangle)}, max_iterations=1",
            yours=_text(model if model is None else as_plane(model)),
            expected=f"{_text(best_plane(triangle)[0])} or its negative",
        )


@visible(
    "ransac_plane",
    weight=2,
    title="The fourth column does not count",
    why="The intensity is no coordinate.",
    hint="Use points[:, :3] for the sample and for the distances.",
)
def searches_without_intensity(ransac_plane: Callable) -> None:
    assert_works(ransac_plane)
    points, belongs = scattered_plane(51, 50, 20, columns=4)
    rng = np.random.default_rng(10)
    assert_finds(ransac_plane(points.copy(), 90, 0.2, rng), points, 0.2, belongs)


@visible(
    "ransac_plane",
    weight=2,
    title="Finds a wall as well as a road",
    why="The largest plane may stand upright; whoever wants roads alone looks at the normal later.",
    hint="Nothing about roads belongs into the loop: the number of inliers decides.",
)
def finds_a_wall(ransac_plane: Callable) -> None:
    assert_works(ransac_plane)
    points, belongs = scattered_plane(52, 50, 20, plane=(0.6, 0.8, 0.0, -4.0))
    rng = np.random.default_rng(11)
    assert_finds(ransac_plane(points.copy(), 90, 0.2, rng), points, 0.2, belongs)


@visible(
    "ransac_plane",
    weight=1,
    title="Leaves its input untouched",
    why="The next search needs the same cloud.",
    hint="points[i, :3] with a list or array of rows is a copy; points[:, :3] is not: build new "
    "arrays from it.",
)
def leaves_the_cloud(ransac_plane: Callable) -> None:
    assert_works(ransac_plane)
    points, _ = scattered_plane(53, 50, 20)
    assert_untouched(ransac_plane, points, 50, 0.2, np.random.default_rng(12))


@visible(
    "ransac_plane",
    weight=2,
    title="Follows rng: one seed one answer, other seeds others",
    why="A result that nobody can repeat cannot be debugged.",
    hint="rng = np.random.default_rng(rng), then draw with rng.choice, never with "
    "np.random.choice or a seed of your own.",
)
def follows_the_generator(ransac_plane: Callable) -> None:
    assert_runs(ransac_plane)
    # One sample of three points is good once in eight times: who refits gets different planes, too.
    points, _ = scattered_plane(61, 30, 30, noise=0.05)
    planes = []
    for seed in range(12):
        once, again = (
            _plane_or_none(ransac_plane(points.copy(), 1, 0.2, np.random.default_rng(seed)))
            for _ in range(2)
        )
        if not _alike(once, again):
            raise CheckFailed(
                "The same seed gave two different planes: not all that is drawn comes from rng.",
                given=f"twice the same points, max_iterations=1, rng=np.random.default_rng({seed})",
                yours=f"{_text(once)} and {_text(again)}",
                expected="twice the same",
            )
        planes.append(once)
    if all(_alike(planes[0], plane) for plane in planes):
        raise CheckFailed(
            "Twelve seeds gave the very same plane: the samples do not come from rng.",
            yours=f"twelve times {_text(planes[0])}",
            expected="different planes",
        )


def _plane_or_none(answer: object) -> np.ndarray | None:
    model, _ = _pair(answer)
    return None if model is None else as_plane(model)


def _alike(one: np.ndarray | None, other: np.ndarray | None) -> bool:
    if one is None or other is None:
        return one is other
    return np.allclose(one, other, atol=1e-6) or np.allclose(one, -other, atol=1e-6)


@visible(
    "ransac_plane",
    weight=1,
    title="rng may be a whole number, too: a seed",
    why="A seed fits into a log file; a generator does not.",
    hint="Begin with rng = np.random.default_rng(rng): it makes a generator of a whole number, "
    "and leaves a generator as it is.",
)
def takes_a_seed(ransac_plane: Callable) -> None:
    assert_works(ransac_plane)
    for seed in (1, 2, 3):
        points, belongs = scattered_plane(70 + seed, 60, 30)
        assert_finds(ransac_plane(points.copy(), 90, 0.2, seed), points, 0.2, belongs)
    generators, seeds = (
        [_plane_or_none(ransac_plane(points.copy(), 1, 0.2, rng)) for rng in pair]
        for pair in ((np.random.default_rng(3), np.random.default_rng(3)), (3, 3))
    )
    if _alike(*generators) and not _alike(*seeds):
        raise CheckFailed(
            "The seed 3, given twice, gave two different planes. Generators of that seed give "
            "the same plane.",
            yours=" and ".join(map(_text, seeds)),
            expected="twice the same",
        )


@visible(
    "ransac_plane",
    weight=1,
    title="The parameters keep their names",
    why="Later cells may call ransac_plane(street, max_iterations=50, distance_tolerance=0.2, "
    "rng=1).",
    hint="Keep the first line of the function as it was given.",
)
def keeps_the_names_of_ransac(ransac_plane: Callable) -> None:
    assert_works(ransac_plane)
    points, belongs = scattered_plane(1, 60, 30, noise=0.02)
    answer = ransac_plane(
        points=points.copy(),
        max_iterations=90,
        distance_tolerance=0.2,
        rng=np.random.default_rng(1),
    )
    assert_finds(answer, points, 0.2, belongs)


@noted(
    "ransac_plane",
    title="The mask is a NumPy array",
    why="The next cells take the points that are left with ~inliers, which a list cannot do. "
    "np.array(...) makes one.",
)
def gives_a_mask_array(ransac_plane: Callable) -> None:
    points, _ = scattered_plane(1, 60, 30)
    _, inliers = ransac_plane(points, 50, 0.2, np.random.default_rng(1))
    if not isinstance(inliers, np.ndarray):
        raise CheckFailed(f"The mask is a {type(inliers).__name__}.")


def assert_direction(answer: object, points: np.ndarray, given: str | None = None) -> None:
    """No other direction fits better; the length of the normal and d are not looked at.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    given : str, optional
        What the function was given, for the message.
    """
    plane = as_plane(answer)
    best, least = best_plane(points)
    centre = np.asarray(points, dtype=float)[:, :3].mean(axis=0)
    yours = math.sqrt(np.mean(gaps_from(points, _plane_at(centre, plane[:3])) ** 2))
    if yours > 1.001 * least + 1e-3:
        raise CheckFailed(
            "Through the mean of these points goes a plane that lies nearer to them than one with "
            "your (a, b, c).",
            given=given,
            yours=f"{_text(plane)}, {yours:.4f} m root mean square distance",
            expected=f"{_beside(plane, best)}, {least:.4f} m",
            draw=lambda: _draw(np.asarray(points), plane, None, None, best),
        )


def assert_through_the_mean(answer: object, points: np.ndarray) -> None:
    """The mean of the points lies on the plane; the rest of it is not looked at.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    """
    plane = as_plane(answer)
    centre = np.asarray(points, dtype=float)[:, :3].mean(axis=0)
    gap = gaps_from(centre[None], plane)[0]
    if gap > 5e-3:
        best = best_plane(points)[0]
        raise CheckFailed(
            f"The mean of the points, {point_text(centre)}, is {gap:.3g} m away from the plane. "
            "It lies on the best one.",
            yours=_text(plane),
            expected=_beside(plane, best),
            draw=lambda: _draw(np.asarray(points), plane, None, None, best),
        )


def assert_fits(fit_plane: Callable) -> None:
    """The direction is right; where not, nothing else can be looked at."""
    with needs("(a, b, c) is the direction of least spread"):
        points, _ = scattered_plane(2, 80, 0, noise=0.05)
        assert_direction(fit_plane(points.copy()), points)


@visible(
    "fit_plane",
    weight=3,
    title="Finds the direction in which points spread least, with and without noise",
    why="Three points carry the noise of three points; a thousand average it away.",
    hint="Subtract the mean of the points, then np.linalg.svd: the normal is the last row "
    "of the third result.",
)
def fits_a_road(fit_plane: Callable) -> None:
    given = f"four points: {', '.join(map(point_text, _FLOOR))}"
    assert_direction(fit_plane(_FLOOR.copy()), _FLOOR, given)
    for seed, noise in ((1, 0.0), (2, 0.05)):
        points, _ = scattered_plane(seed, 80, 0, noise=noise)
        assert_direction(fit_plane(points.copy()), points)


@visible(
    "fit_plane",
    weight=2,
    title="The mean of the points lies on the plane",
    why="A plane with the right tilt at the wrong height calls all of the road an obstacle.",
    hint="d is minus the product of the normal and the mean.",
)
def goes_through_the_mean(fit_plane: Callable) -> None:
    assert_fits(fit_plane)
    points, _ = scattered_plane(2, 80, 0, noise=0.05)
    assert_through_the_mean(fit_plane(points.copy()), points)


@visible(
    "fit_plane",
    weight=1,
    title="The normal has length 1",
    why="Only then do distances from the plane come out in metres.",
    hint="The rows of the SVD's third result have length 1 already; another normal is to be "
    "divided by its length, and d with it.",
)
def fit_has_a_unit_normal(fit_plane: Callable) -> None:
    assert_fits(fit_plane)
    points, _ = scattered_plane(2, 80, 0, noise=0.05)
    assert_unit_normal(fit_plane(points.copy()))


@visible(
    "fit_plane",
    weight=2,
    title="Fits a wall as well as a road",
    why="z = a x + b y + c cannot describe a wall, and this function will meet walls.",
    hint="Do not solve for z. The SVD treats all three directions alike.",
)
def fits_a_wall(fit_plane: Callable) -> None:
    assert_fits(fit_plane)
    for plane in ((0.6, 0.8, 0.0, -4.0), (1.0, 0.0, 0.0, 7.0)):
        points, _ = scattered_plane(3, 60, 0, plane=plane, noise=0.03)
        assert_direction(fit_plane(points.copy()), points)


@visible(
    "fit_plane",
    weight=1,
    title="Works far from the sensor",
    why="A plane need not go through the origin: only the centred points have a plain direction.",
    hint="Subtract the mean first, and put it back into d.",
)
def fits_far_away(fit_plane: Callable) -> None:
    assert_fits(fit_plane)
    points, _ = scattered_plane(4, 60, 0, plane=(0.0, 0.28, 0.96, 55.0), noise=0.02)
    points += [70.0, 0.0, 0.0]
    assert_direction(fit_plane(points.copy()), points)


@visible(
    "fit_plane",
    weight=1,
    title="The fourth column does not count, whether it varies much or little",
    why="Brightness is no direction in space.",
    hint="points[:, :3] before anything else.",
)
def fits_without_intensity(fit_plane: Callable) -> None:
    assert_fits(fit_plane)
    points, _ = scattered_plane(5, 60, 0, noise=0.05, columns=4)
    for scale in (1.0, 1e-5):  # once it spreads most of all, once least
        cloud = points * [1, 1, 1, scale]
        assert_direction(fit_plane(cloud.copy()), cloud)


@visible(
    "fit_plane",
    weight=1,
    title="Three points are enough",
    why="They are the fewest that have a plane, and the best one goes through all of them.",
    hint="The same lines serve every number of points. With full_matrices=False the SVD of three "
    "points has three rows, too.",
)
def fits_three_points(fit_plane: Callable) -> None:
    assert_fits(fit_plane)
    for triangle in _TRIANGLES[2:]:
        assert_direction(fit_plane(triangle.copy()), triangle)


@visible(
    "fit_plane",
    weight=1,
    title="Leaves its input untouched",
    why="The mean is subtracted for the fit alone: the cloud must stay where it is.",
    hint="points[:, :3] - centre is a new array; points[:, :3] -= centre moves the cloud.",
)
def leaves_the_points_where_they_are(fit_plane: Callable) -> None:
    assert_fits(fit_plane)
    points, _ = scattered_plane(2, 80, 0, noise=0.05)
    assert_untouched(fit_plane, points)


@visible(
    "fit_plane",
    weight=1,
    title="The parameter keeps its name: points",
    why="Whoever reads the docstring calls fit_plane(points=...).",
    hint="Keep the first line of the function as it was given.",
)
def keeps_points(fit_plane: Callable) -> None:
    assert_fits(fit_plane)
    points, _ = scattered_plane(2, 80, 0, noise=0.05)
    assert_direction(fit_plane(points=points.copy()), points)


def _through_the_mean(points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    return _plane_at(points[:, :3].mean(axis=0), normal)


def _column_of_the_svd(points: np.ndarray) -> np.ndarray:
    """What stands where the normal is looked for in the wrong direction of the matrix."""
    return np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][:, 2]


def _heights_fitted(points: np.ndarray) -> np.ndarray:
    """Where the errors are measured along z: a x + b y - z + d = 0; shape (4,)."""
    table = np.column_stack([points[:, :2], np.ones(len(points))])
    a, b, d = np.linalg.solve(table.T @ table, table.T @ points[:, 2])
    return np.array([a, b, -1.0, d])


def _unit(plane: np.ndarray) -> np.ndarray:
    return plane / np.linalg.norm(plane[:3])


mistakes(
    "fit_plane",
    Mistake(
        "The points are not centred: the directions of spread are those about the sensor.",
        lambda right, points: _through_the_mean(points, np.linalg.eigh(points.T @ points)[1][:, 0]),
        "Subtract the mean of the points before the SVD.",
    ),
    Mistake(
        "The normal is the direction of largest spread; it must be that of least.",
        lambda right, points: _through_the_mean(points, _spread_of(points)[2][:, 2]),
        "The directions are sorted from most to least: take the last row.",
    ),
    Mistake(
        "The normal is the direction of second largest spread; it must be that of least.",
        lambda right, points: _through_the_mean(points, _spread_of(points)[2][:, 1]),
        "The directions are sorted from most to least: take the last row.",
    ),
    Mistake(
        "The normal is a column of the SVD's third result; its directions are the rows.",
        lambda right, points: _through_the_mean(points, _column_of_the_svd(points)),
        "Take the last row, [-1], and not the last column, [:, -1].",
    ),
    Mistake(
        "The sign of d is wrong: a x + b y + c z + d must be 0 at the mean.",
        lambda right, points: right * [1, 1, 1, -1],
    ),
    Mistake(
        "d is 0: that is the parallel plane through the sensor.",
        lambda right, points: right * [1, 1, 1, 0],
        "d is minus the product of the normal and the mean.",
    ),
    Mistake(
        "Only the first three points decide.",
        lambda right, points: best_plane(points[:3])[0],
        "All points count: subtract their mean, then take the SVD.",
    ),
    Mistake(
        "The errors are measured along z, not square to the plane.",
        lambda right, points: _unit(_heights_fitted(points)),
        "Do not solve for z. The SVD treats all three directions alike.",
    ),
    Mistake(
        "The errors are measured along z, and the normal (a, b, -1) is not divided by its length.",
        lambda right, points: _heights_fitted(points),
        "Do not solve for z. The SVD treats all three directions alike.",
    ),
    cases=(
        (
            np.array(
                [[1.0, 2, 3.5], [4, 1, 6.2], [2, 6, 5.1], [7, 3, 10.4], [5, 8, 9.3], [0, 5, 1.8]]
            ),
        ),
        (
            np.array(
                [[9.0, -1, 0.5], [3, 2, -2.5], [6, -5, 1.5], [2, -3, -2], [8, 4, -2.2], [5, 1, 1]]
            ),
        ),
        (np.array([[4.0, 0, 2], [4.2, 5, 7], [6, 1, 1], [7, 6, 5.5], [9, 2, -2.5]]),),
    ),
    right=lambda points: best_plane(points)[0],
    same=_same_plane,
)


def assert_number(answer: object) -> np.ndarray:
    """The answer is one finite number.

    Parameters
    ----------
    answer : object

    Returns
    -------
    numpy.ndarray, shape ()
    """
    number = as_array(answer, what="a whole number")
    if number.shape != ():
        raise WrongForm(
            "The answer is one number.", yours=f"shape {number.shape}", expected="one whole number"
        )
    return number


def assert_about(answer: object, expected: int, *case: object) -> None:
    """The answer is right but for the rounding, which is another property.

    Parameters
    ----------
    answer : object
    expected : int
    case : object
        The arguments, for the message.
    """
    number = assert_number(answer)
    if not abs(float(number) - expected) <= 1:
        raise CheckFailed(
            "This is not the number of samples that it takes.",
            given=_call(case),
            yours=f"{number:g}",
            expected=str(expected),
        )


def assert_iterations(answer: object, expected: int, *case: object) -> None:
    """The answer is the whole number expected.

    Parameters
    ----------
    answer : object
    expected : int
    case : object
        The arguments, for the message.
    """
    number = assert_number(answer)
    sides = {"given": _call(case), "yours": f"{number:g}", "expected": str(expected)}
    if number != np.round(number):
        raise CheckFailed("Half a round cannot be played: take the next whole number.", **sides)
    if number != expected:
        words = {
            -1: "One sample fewer does not reach the confidence: round up, not down.",
            1: "One sample fewer would be enough.",
        }
        near = words.get(float(number) - expected, "This is not the smallest number that suffices.")
        raise CheckFailed(near, **sides)


def assert_never(answer: object) -> None:
    """The answer says that no number is enough: `math.inf`, None, or a number beyond all patience.

    Parameters
    ----------
    answer : object
    """
    if isinstance(answer, (int, float)) and not isinstance(answer, bool) and answer >= 1e9:
        return
    if answer is None or "beyond 64 bits" in getattr(answer, "type_name", ""):
        return
    raise CheckFailed(
        "Without a single inlier no number of samples is enough.",
        given=_call((0.0, 3, 0.99)),
        yours=brief(answer),
        expected="math.inf",
    )


def _call(case: Sequence) -> str | None:
    names = ("inlier_ratio", "sample_size", "confidence")
    return ", ".join(f"{name} {value}" for name, value in zip(names, case, strict=False)) or None


def assert_reckons(iterations_needed: Callable) -> None:
    """The plain case."""
    with needs("the number of samples is right, give or take one"):
        assert_about(iterations_needed(0.6, 3, 0.99), 19)
        assert_about(iterations_needed(0.3, 3, 0.99), 169)


def assert_falls(iterations_needed: Callable) -> None:
    """More inliers, fewer samples; where not, the ends say nothing."""
    with needs("the more inliers there are, the fewer samples it takes"):
        few, more, most = (
            float(assert_number(iterations_needed(w, 3, 0.99))) for w in (0.2, 0.4, 0.7)
        )
        if not np.inf > few > more > most > 0:
            raise CheckFailed("The number does not fall as the share of inliers grows.")


@visible(
    "iterations_needed",
    weight=3,
    title="Right for a plane, give or take one",
    why="A hundred too few and the road is missed; a thousand too many and the frame is late.",
    hint="Solve 1 - (1 - w^s)^N >= confidence for N: a quotient of two logarithms.",
)
def reckons_the_number(iterations_needed: Callable) -> None:
    for ratio, expected in ((0.6, 19), (0.3, 169), (0.2, 574), (0.7, 11), (0.01, 4605168)):
        answer = iterations_needed(ratio, 3, 0.99)
        assert_about(answer, expected, ratio, 3, 0.99)


@visible(
    "iterations_needed",
    weight=2,
    title="The smallest whole number that reaches the confidence",
    why="One sample too few and the promise is broken.",
    hint="math.ceil rounds up to a whole number.",
)
def smallest_that_suffices(iterations_needed: Callable) -> None:
    assert_reckons(iterations_needed)
    for ratio, expected in ((0.6, 19), (0.4, 70), (0.75, 9), (0.8, 7)):
        assert_iterations(iterations_needed(ratio, 3, 0.99), expected, ratio, 3, 0.99)


@visible(
    "iterations_needed",
    weight=1,
    title="Follows sample_size",
    why="A line needs two points, a plane three: the same inliers, another number.",
    hint="s is sample_size: w is taken to that power.",
)
def follows_the_sample_size(iterations_needed: Callable) -> None:
    assert_reckons(iterations_needed)
    for size, expected in ((1, 7), (2, 17), (4, 72), (5, 146)):
        assert_about(iterations_needed(0.5, size, 0.99), expected, 0.5, size, 0.99)


@visible(
    "iterations_needed",
    weight=1,
    title="Follows confidence",
    why="One failure in a hundred is too many for a car that searches ten times a second.",
    hint="Take the logarithm of 1 - confidence, with the parameter and no number of your own.",
)
def follows_the_confidence(iterations_needed: Callable) -> None:
    assert_reckons(iterations_needed)
    for confidence, expected in ((0.8, 34), (0.9, 49), (0.999, 145), (0.9999, 193)):
        answer = iterations_needed(0.36, 3, confidence)
        assert_about(answer, expected, 0.36, 3, confidence)


@visible(
    "iterations_needed",
    weight=2,
    title="With nothing but inliers, one sample is enough",
    why="log(0) waits here, in an empty car park without a single obstacle.",
    hint="Look at w = 1 before you take logarithms.",
)
def one_is_enough(iterations_needed: Callable) -> None:
    assert_falls(iterations_needed)
    for ratio, size, confidence in ((1.0, 3, 0.99), (1, 2, 0.5)):
        answer = iterations_needed(ratio, size, confidence)
        if assert_number(answer) != 1:
            raise CheckFailed(
                "Every sample is good here: one is enough, and there must be one.",
                given=_call((ratio, size, confidence)),
                yours=brief(answer),
                expected="1",
            )


@visible(
    "iterations_needed",
    weight=2,
    title="Without inliers, no number is enough",
    why="0 would mean: no need to search. The truth is: no use in searching.",
    hint="Return math.inf (or np.inf) when w is 0: a division by log(1) would fail.",
)
def none_is_enough(iterations_needed: Callable) -> None:
    assert_falls(iterations_needed)
    try:
        answer = iterations_needed(0.0, 3, 0.99)
    except Exception as error:  # refusing is an answer, too
        if "ValueError" not in (type(error).__name__, getattr(error, "type_name", "")):
            raise
    else:
        assert_never(answer)


@visible(
    "iterations_needed",
    weight=1,
    title="The parameters keep their names",
    why="Whoever reads the docstring calls iterations_needed(inlier_ratio=..., ...).",
    hint="Keep the first line of the function as it was given.",
)
def keeps_the_names_of_the_parameters(iterations_needed: Callable) -> None:
    assert_reckons(iterations_needed)
    answer = iterations_needed(inlier_ratio=0.6, sample_size=3, confidence=0.99)
    assert_about(answer, 19, 0.6, 3, 0.99)


def iterations_by_trying(ratio: float, size: int, confidence: float) -> int | None:
    """The right answer to `iterations_needed`, counted up in exact arithmetic.

    Parameters
    ----------
    ratio : float
    size : int
    confidence : float

    Returns
    -------
    int or None
        None where rounding could decide, or where 400 samples are not enough.
    """
    bad, remaining = 1 - Fraction(ratio) ** size, Fraction(1)
    allowed = 1 - Fraction(confidence)
    for number in range(1, 400):
        remaining *= bad
        if abs(float(remaining / allowed) - 1) < 1e-6:
            return None
        if remaining <= allowed:
            return number
    return None


mistakes(
    "iterations_needed",
    Mistake(
        "It is rounded down; one sample fewer does not reach the confidence.",
        lambda right, *case: right - 1,
        "math.ceil rounds up; int(...) and // round down.",
    ),
    Mistake(
        "The exponent is missing: w is the chance that one point is good, w^s that a whole "
        "sample is.",
        lambda right, ratio, size, confidence: iterations_by_trying(ratio, 1, confidence),
    ),
    Mistake(
        "The exponent is always 3, whatever sample_size is.",
        lambda right, ratio, size, confidence: iterations_by_trying(ratio, 3, confidence),
        "w ** sample_size",
    ),
    Mistake(
        "The exponent is always 2, whatever sample_size is.",
        lambda right, ratio, size, confidence: iterations_by_trying(ratio, 2, confidence),
        "w ** sample_size",
    ),
    Mistake(
        "Inliers and outliers are swapped: 1 - w is taken where w is asked for.",
        lambda right, ratio, size, confidence: iterations_by_trying(1 - ratio, size, confidence),
    ),
    Mistake(
        "The logarithm is that of the confidence; it must be that of 1 - confidence, the chance "
        "to fail that is allowed.",
        lambda right, ratio, size, confidence: iterations_by_trying(ratio, size, 1 - confidence),
    ),
    Mistake(
        "So many samples give one good one on average; the confidence does not count.",
        lambda right, ratio, size, confidence: math.ceil(1 / ratio**size),
        "Solve 1 - (1 - w^s)^N >= confidence for N.",
    ),
    # With a confidence below a half the logarithms change sides.
    cases=(
        (0.6, 2, 0.9),
        (0.4, 3, 0.95),
        (0.65, 4, 0.99),
        (0.45, 2, 0.8),
        (0.35, 3, 0.3),
        (0.6, 3, 0.99),
    ),
    right=iterations_by_trying,
)
