"""Visible checks of `point_plane_distance`."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from utils.checks import common_checks
from utils.checks.assertions import (
    CheckFailed,
    as_array,
    assert_untouched,
    brief,
    frozen,
    in_shape,
    needs,
    point_text,
)
from utils.checks.common_checks import Case
from utils.checks.core import visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.run_cache import once

# A unit normal, and points in front of the plane with this normal through the sensor.
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


def exact_distances(points: np.ndarray, plane: ArrayLike) -> np.ndarray:
    """Return the right answer to `point_plane_distance`, computed point by point.

    Parameters
    ----------
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    plane : (4,) array_like

    Returns
    -------
    numpy.ndarray, shape (n,)
    """
    return np.array([abs(distance) for distance in _signed_distances(points, plane)])


def _signed_distances(points: np.ndarray, plane: ArrayLike) -> list[float]:
    a, b, c, d = map(float, plane)
    return [math.fsum((a * x, b * y, c * z, d)) for x, y, z in points[:, :3].astype(float).tolist()]


def assert_distances(answer: object, points: np.ndarray, plane: ArrayLike) -> None:
    """Assert that the answer is the distance of each point from a plane.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    plane : (4,) array_like
        A plane with a unit normal.
    """
    expected = exact_distances(points, plane)
    yours = as_array(answer, what="an array of distances")
    yours = in_shape(
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
    """Assert that distances are the same with and without a fourth column, right or wrong.

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
        one_per_point = f"one distance for each of the {len(cloud)} points"
        in_shape(distances, (len(cloud),), one_per_point, columns=4)
    if not np.abs(yours - plain).max() <= 1e-3:
        raise CheckFailed(
            "With the intensity in a fourth column the distances are others than without it.",
            given=f"a plane with d = {plane[3]:.3g}",
            yours=brief(yours),
            expected=brief(plain),
        )


@once
def require_plain_distances(point_plane_distance: Callable) -> None:
    """Assert that points in front of planes through the sensor are right; raise `NotYet` if not."""
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
    require_plain_distances(point_plane_distance)
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
    require_plain_distances(point_plane_distance)
    plane = np.array([*_NORMAL, 0.0])
    assert_distances(
        point_plane_distance(_BEHIND[:, :3].copy(), plane.copy()), _BEHIND[:, :3], plane
    )
    points = np.concatenate([_IN_FRONT, _BEHIND])[:, :3]
    assert_distances(point_plane_distance(points.copy(), -plane), points, -plane)


@visible(
    "point_plane_distance",
    weight=18,
    title="The absolute value is that of the whole sum, d included",
    why="A road is below the sensor: there a x + b y + c z and d have opposite signs.",
    hint="np.abs around everything: first the sum with d, then its absolute value.",
)
def takes_abs_last(point_plane_distance: Callable) -> None:
    with needs("d counts, and no distance has a sign"):
        adds_d(point_plane_distance)
        forgets_the_sign(point_plane_distance)
    points = np.concatenate([_IN_FRONT, _BEHIND])[:, :3]
    for offset in (2.0, -2.0):
        plane = np.array([*_NORMAL, offset])
        assert_distances(point_plane_distance(points.copy(), plane.copy()), points, plane)


@visible(
    "point_plane_distance",
    weight=5,
    title="The fourth column does not count",
    why="(n, 4) times (4,) works without an error, and multiplies brightness with d.",
    hint="Take points[:, :3] and the first three numbers of the plane; add the last one.",
)
def ignores_intensity(point_plane_distance: Callable) -> None:
    require_plain_distances(point_plane_distance)
    plane = np.array([*_NORMAL, 1.5])
    assert_ignores_intensity(point_plane_distance, _IN_FRONT * [1, 1, 1, 255], plane)


@visible(
    "point_plane_distance",
    weight=2,
    title="The plane may be a tuple",
    why="plane_through may return one.",
    hint="A tuple does not calculate: take its numbers one by one, or np.asarray(plane).",
)
def takes_a_tuple(point_plane_distance: Callable) -> None:
    require_plain_distances(point_plane_distance)
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
    require_plain_distances(point_plane_distance)
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
    require_plain_distances(point_plane_distance)
    assert_untouched(point_plane_distance, _BEHIND[:, :3], np.array([*_NORMAL, 2.0]))


common_checks.names(
    Case(
        __name__,
        "point_plane_distance",
        {"points": _IN_FRONT[:, :3], "plane": frozen(np.array([*_NORMAL, 0.0]))},
        expected=None,  # `assert_distances` computes it
        compare=lambda answer, points, plane, _: assert_distances(answer, points, plane),
        precondition=require_plain_distances,
    ),
    "keeps_points_and_plane",
    title="The parameters keep their names: points and plane",
    why="Whoever reads the docstring calls point_plane_distance(points=..., plane=...).",
)


@visible(
    "point_plane_distance",
    weight=1,
    title="The distances are a NumPy array",
    why="ransac_plane compares all of them with its threshold at once; a list cannot do that.",
    hint="Whole columns give an array. If you build a list, wrap it in np.array(...).",
)
def gives_an_array(point_plane_distance: Callable) -> None:
    require_plain_distances(point_plane_distance)
    answer = point_plane_distance(_IN_FRONT[:, :3].copy(), np.array([*_NORMAL, 0.0]))
    if not isinstance(answer, np.ndarray):
        raise CheckFailed(
            "These are the right numbers, but they are no array.",
            yours=f"{type(answer).__name__} {brief(answer)}",
            expected="a NumPy array",
        )


def _absolute_terms(points: np.ndarray, plane: ArrayLike) -> np.ndarray:
    """Return the absolute values of a x, b y, c z and d for each point; shape (n, 4)."""
    return np.abs(np.column_stack([points[:, :3], np.ones(len(points))]) * np.asarray(plane))


mistakes(
    "point_plane_distance",
    Mistake(
        "No absolute value is taken: behind the plane the distances are negative.",
        lambda right, points, plane: _signed_distances(points, plane),
        "np.abs of the whole sum.",
    ),
    Mistake(
        "d is missing: these are the distances from the parallel plane through the sensor.",
        lambda right, points, plane: exact_distances(points, [*plane[:3], 0]),
        "Add d to a x + b y + c z.",
    ),
    Mistake(
        "d is subtracted; it must be added.",
        lambda right, points, plane: exact_distances(points, [*plane[:3], -plane[3]]),
    ),
    Mistake(
        "The absolute value is taken of a x + b y + c z, and d is added after that.",
        lambda right, points, plane: exact_distances(points, [*plane[:3], 0]) + plane[3],
        "np.abs around everything: first the sum with d, then its absolute value.",
    ),
    Mistake(
        "The absolute values of a x + b y + c z and of d are taken apart and then added.",
        lambda right, points, plane: exact_distances(points, [*plane[:3], 0]) + abs(plane[3]),
        "np.abs around everything: first the sum with d, then its absolute value.",
    ),
    Mistake(
        "The absolute value is taken of each product, and then they are added.",
        lambda right, points, plane: _absolute_terms(points, plane)[:, :3].sum(axis=1) + plane[3],
        "np.abs around everything: first the sum with d, then its absolute value.",
    ),
    Mistake(
        "The absolute value is taken of a x, of b y, of c z and of d, and then they are added.",
        lambda right, points, plane: _absolute_terms(points, plane).sum(axis=1),
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
            np.subtract(_signed_distances(points, plane), plane[3] * (1 - points[:, 3]))
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
    right=exact_distances,
)
