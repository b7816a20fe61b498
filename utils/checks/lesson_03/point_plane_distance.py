"""Visible checks of `point_plane_distance`."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from utils.checks import common_checks
from utils.checks.assertions import (
    CheckFailed,
    as_array,
    as_shape,
    assert_untouched,
    brief_text,
    frozen,
    point_text,
    precondition,
)
from utils.checks.common_checks import Case
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.run_cache import once_per_run

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
    yours = as_array(answer, description="an array of distances")
    yours = as_shape(
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
            f"{count if len(expected) > 1 else 'The distance is'} wrong.",
            input_text=f"point {point_text(points[first])}, "
            f"plane {brief_text(np.asarray(plane, float))}",
            yours=f"{yours[first]:.4g} m",
            expected=f"{expected[first]:.4g} m",
        )


def assert_ignores_intensity(
    point_plane_distance: Callable, cloud: np.ndarray, plane: np.ndarray
) -> None:
    """Assert that distances, right or wrong, are the same with and without a fourth column.

    Parameters
    ----------
    point_plane_distance : callable
    cloud : numpy.ndarray, shape (n, 4)
    plane : numpy.ndarray, shape (4,)
    """
    plain, yours = (
        as_array(
            point_plane_distance(points.copy(), plane.copy()), description="an array of distances"
        )
        for points in (cloud[:, :3], cloud)
    )
    for distances in (plain, yours):
        one_per_point = f"one distance for each of the {len(cloud)} points"
        as_shape(distances, (len(cloud),), one_per_point, columns=4)
    if not np.abs(yours - plain).max() <= 1e-3:
        raise CheckFailed(
            "With the intensity in a fourth column, the distances differ from those without it.",
            input_text=f"a plane with d = {plane[3]:.3g}",
            yours=brief_text(yours),
            expected=brief_text(plain),
        )


@once_per_run
def require_plain_distances(point_plane_distance: Callable) -> None:
    """Raise `NotYet` if distances are wrong in front of planes through the sensor."""
    with precondition("the distances from a plane through the sensor are right"):
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


@visible_check(
    "point_plane_distance",
    weight=4,
    title="Measures distances from planes through the sensor",
    why="RANSAC compares these distances with its threshold, so a wrong distance adds a point to "
    "the road or removes it.",
    hint="Compute a x + b y + c z for every point: multiply x by a, y by b and z by c.",
)
def measures_distances(point_plane_distance: Callable) -> None:
    _assert_plain(point_plane_distance)


@visible_check(
    "point_plane_distance",
    weight=2,
    title="Works for planes that do not pass through the sensor",
    why="Without d, every plane passes through the sensor. With the wrong sign, the plane is as "
    "far above the sensor as the road is below it.",
    hint="Add d, the last number of the plane, to a x + b y + c z.",
)
def adds_d(point_plane_distance: Callable) -> None:
    require_plain_distances(point_plane_distance)
    for offset in (2.0, -0.25):
        plane = np.array([*_NORMAL, offset])
        answer = point_plane_distance(_IN_FRONT[:, :3].copy(), plane.copy())
        assert_distances(answer, _IN_FRONT, plane)


@visible_check(
    "point_plane_distance",
    weight=2,
    title="Returns no negative distances on either side of the plane",
    why="A negative distance is below any threshold, so everything under the road would be an "
    "inlier.",
    hint="Take np.abs of the whole sum: a distance is never negative.",
)
def returns_no_negative_distances(point_plane_distance: Callable) -> None:
    require_plain_distances(point_plane_distance)
    plane = np.array([*_NORMAL, 0.0])
    assert_distances(
        point_plane_distance(_BEHIND[:, :3].copy(), plane.copy()), _BEHIND[:, :3], plane
    )
    points = np.concatenate([_IN_FRONT, _BEHIND])[:, :3]
    assert_distances(point_plane_distance(points.copy(), -plane), points, -plane)


@visible_check(
    "point_plane_distance",
    weight=18,
    title="Works for points on both sides of a plane that does not pass through the sensor",
    why="A road never passes through the sensor, and its points are on both sides of the plane.",
    hint="Compute the whole sum including d, then take np.abs of it.",
)
def takes_abs_last(point_plane_distance: Callable) -> None:
    with precondition("d is added and no distance is negative"):
        adds_d(point_plane_distance)
        returns_no_negative_distances(point_plane_distance)
    points = np.concatenate([_IN_FRONT, _BEHIND])[:, :3]
    for offset in (2.0, -2.0):
        plane = np.array([*_NORMAL, offset])
        assert_distances(point_plane_distance(points.copy(), plane.copy()), points, plane)


@visible_check(
    "point_plane_distance",
    weight=5,
    title="Ignores intensity in a fourth column",
    why="A product of shapes (n, 4) and (4,) raises no error, but it multiplies the intensity by "
    "d.",
    hint="Multiply points[:, :3] by the first three numbers of the plane, then add the last one.",
)
def ignores_intensity(point_plane_distance: Callable) -> None:
    require_plain_distances(point_plane_distance)
    plane = np.array([*_NORMAL, 1.5])
    assert_ignores_intensity(point_plane_distance, _IN_FRONT * [1, 1, 1, 255], plane)


@visible_check(
    "point_plane_distance",
    weight=2,
    title="Accepts the plane as a tuple",
    why="Your plane_through may return a tuple, and ransac_plane passes it on.",
    hint="Unpack it with a, b, c, d = plane, or convert it with np.asarray(plane).",
)
def accepts_a_tuple(point_plane_distance: Callable) -> None:
    require_plain_distances(point_plane_distance)
    xyz = _IN_FRONT[:, :3]
    assert_distances(point_plane_distance(xyz.copy(), (*_NORMAL, 0.0)), xyz, (*_NORMAL, 0.0))


@visible_check(
    "point_plane_distance",
    weight=1,
    title="Works on a single point and on an empty array",
    why="A filter may leave one point or none, and that must not crash the program.",
    hint="Compute points[:, :3] @ normal, which gives one number per row, however many rows there "
    "are.",
)
def works_on_few_points(point_plane_distance: Callable) -> None:
    require_plain_distances(point_plane_distance)
    plane = np.array([*_NORMAL, 0.0])
    for points in (_IN_FRONT[2:3, :3], _IN_FRONT[:0, :3]):
        assert_distances(point_plane_distance(points.copy(), plane.copy()), points, plane)


@visible_check(
    "point_plane_distance",
    weight=1,
    title="Does not change its input",
    why="The next round of RANSAC needs the original points.",
    hint="Build a new array with points[:, :3] @ normal; points *= normal would change the points.",
)
def leaves_cloud_and_plane(point_plane_distance: Callable) -> None:
    require_plain_distances(point_plane_distance)
    assert_untouched(point_plane_distance, _BEHIND[:, :3], np.array([*_NORMAL, 2.0]))


common_checks.promise_names(
    Case(
        __name__,
        "point_plane_distance",
        {"points": _IN_FRONT[:, :3], "plane": frozen(np.array([*_NORMAL, 0.0]))},
        expected=None,  # `assert_distances` computes it
        compare=lambda answer, points, plane, _: assert_distances(answer, points, plane),
        precondition=require_plain_distances,
    ),
    "keeps_points_and_plane",
    title="Keeps the names of its parameters: points and plane",
    why="Other code may pass arguments by name, as in point_plane_distance(points=..., plane=...).",
)


@note_check(
    "point_plane_distance",
    title="Returns a NumPy array",
    why="ransac_plane compares all distances with its threshold at once, which does not work "
    "with a list. np.array(...) makes an array.",
)
def gives_an_array(point_plane_distance: Callable) -> None:
    answer = point_plane_distance(_IN_FRONT[:, :3].copy(), np.array([*_NORMAL, 0.0]))
    if not isinstance(answer, np.ndarray):
        raise CheckFailed(f"The function returns the distances as a {type(answer).__name__}.")


def _absolute_terms(points: np.ndarray, plane: ArrayLike) -> np.ndarray:
    """Return the absolute values of a x, b y, c z and d for each point; shape (n, 4)."""
    return np.abs(np.column_stack([points[:, :3], np.ones(len(points))]) * np.asarray(plane))


declare_mistakes(
    "point_plane_distance",
    Mistake(
        "Distances on one side of the plane are negative: the absolute value is missing.",
        lambda right, points, plane: _signed_distances(points, plane),
        "Take np.abs of the whole sum.",
    ),
    Mistake(
        "The function measures the distances from the parallel plane through the sensor: d is "
        "missing.",
        lambda right, points, plane: exact_distances(points, [*plane[:3], 0]),
        "Add d, the last number of the plane, to a x + b y + c z.",
    ),
    Mistake(
        "d has the wrong sign.",
        lambda right, points, plane: exact_distances(points, [*plane[:3], -plane[3]]),
        "Add d to a x + b y + c z instead of subtracting it.",
    ),
    Mistake(
        "The function takes the absolute value of a x + b y + c z and then adds d.",
        lambda right, points, plane: exact_distances(points, [*plane[:3], 0]) + plane[3],
        "Compute the whole sum including d, then take np.abs of it.",
    ),
    Mistake(
        "The function adds the absolute values of a x + b y + c z and of d.",
        lambda right, points, plane: exact_distances(points, [*plane[:3], 0]) + abs(plane[3]),
        "Compute the whole sum including d, then take np.abs of it.",
    ),
    Mistake(
        "The function adds the absolute values of a x, b y and c z, and then d.",
        lambda right, points, plane: _absolute_terms(points, plane)[:, :3].sum(axis=1) + plane[3],
        "Compute the whole sum including d, then take np.abs of it.",
    ),
    Mistake(
        "The function adds the absolute values of a x, b y, c z and d.",
        lambda right, points, plane: _absolute_terms(points, plane).sum(axis=1),
        "Compute the whole sum including d, then take np.abs of it.",
    ),
    Mistake(
        "The function returns squared distances.",
        lambda right, points, plane: right**2,
        "Use np.abs instead of the square, so that the result stays in metres.",
    ),
    Mistake(
        "The sum is divided by the length of all four numbers of the plane, but d does not "
        "belong to the normal.",
        lambda right, points, plane: right / math.hypot(*plane),
        "The normal (a, b, c) already has length 1, so do not divide.",
    ),
    Mistake(
        "Whole rows are multiplied by the plane, so the intensity is multiplied by d.",
        lambda right, points, plane: np.abs(
            np.subtract(_signed_distances(points, plane), plane[3] * (1 - points[:, 3]))
        ),
        "Multiply points[:, :3] by the first three numbers of the plane, then add the last one.",
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
