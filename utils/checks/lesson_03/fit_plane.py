"""Visible checks of `fit_plane`."""

import contextlib
import math
import tracemalloc
from collections.abc import Callable, Iterator

import numpy as np

from utils.checks import common_checks
from utils.checks.assertions import CheckFailed, assert_untouched, frozen, point_text, precondition
from utils.checks.common_checks import Case
from utils.checks.core import visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.lesson_03.planes import (
    TRIANGLES,
    as_plane,
    assert_unit_normal,
    draw_edge_on,
    expected_text,
    plane_text,
    same_plane,
    scattered_plane,
)
from utils.geometry import (
    best_plane,
    distances_from_plane,
    plane_through_point,
    principal_components,
    with_unit_normal,
)
from utils.remote_objects import RemoteProxy

# The uneven floor of the notebook, 4 m by 2 m, with corners 10 cm too high or too low.
_FLOOR = frozen(np.array([[0.0, 0.0, -1.6], [4.0, 0.0, -1.8], [0.0, 2.0, -1.8], [4.0, 2.0, -1.6]]))


def assert_direction(answer: object, points: np.ndarray, input_text: str | None = None) -> None:
    """Assert that no other normal fits better; ignore the length of the normal and d.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    input_text : str, optional
        The input of the function, for the message.
    """
    plane = as_plane(answer)
    best, least = best_plane(points)
    centre = np.asarray(points, dtype=float)[:, :3].mean(axis=0)
    yours = math.sqrt(
        np.mean(distances_from_plane(points, plane_through_point(centre, plane[:3])) ** 2)
    )
    if yours > 1.001 * least + 1e-3:
        raise CheckFailed(
            "Another plane through the mean of these points is closer to them than the one with "
            "your (a, b, c).",
            input_text=input_text,
            yours=f"{plane_text(plane)}, root mean square distance {yours:.4f} m",
            expected=f"{expected_text(plane, best)}, root mean square distance {least:.4f} m",
            draw=lambda: draw_edge_on(np.asarray(points), plane, None, None, best),
        )


def assert_through_the_mean(answer: object, points: np.ndarray) -> None:
    """Assert that the mean of the points lies on the plane; ignore the direction of the plane.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    """
    plane = as_plane(answer)
    centre = np.asarray(points, dtype=float)[:, :3].mean(axis=0)
    gap = distances_from_plane(centre[None], plane)[0]
    if gap > 5e-3:
        best = best_plane(points)[0]
        raise CheckFailed(
            f"The mean of the points, {point_text(centre)}, is {gap:.3g} m away from the plane. "
            "The best plane passes through the mean.",
            yours=plane_text(plane),
            expected=expected_text(plane, best),
            draw=lambda: draw_edge_on(np.asarray(points), plane, None, None, best),
        )


def require_direction(fit_plane: Callable) -> None:
    """Raise `NotYet` if the direction of the normal is wrong."""
    with precondition("(a, b, c) is the direction of least spread"):
        points, _ = scattered_plane(2, 80, 0, noise=0.05)
        assert_direction(fit_plane(points.copy()), points)


@visible_check(
    "fit_plane",
    weight=3,
    title="Finds the direction of least spread, with and without noise",
    why="A plane through three points follows their noise; a fit to a thousand points averages the "
    "noise out.",
    hint="Subtract the mean of the points, then call np.linalg.svd: the normal is the last row "
    "of its third result.",
)
def fits_a_road(fit_plane: Callable) -> None:
    input_text = f"four points: {', '.join(map(point_text, _FLOOR))}"
    assert_direction(fit_plane(_FLOOR.copy()), _FLOOR, input_text)
    for seed, noise in ((1, 0.0), (2, 0.05)):
        points, _ = scattered_plane(seed, 80, 0, noise=noise)
        assert_direction(fit_plane(points.copy()), points)


@visible_check(
    "fit_plane",
    weight=16,
    title="Returns a plane through the mean of the points",
    why="If the plane has the right tilt but the wrong height, the whole road looks like an "
    "obstacle.",
    hint="Compute d = -(normal @ centre), where centre is the mean of the points.",
)
def goes_through_the_mean(fit_plane: Callable) -> None:
    require_direction(fit_plane)
    points, _ = scattered_plane(2, 80, 0, noise=0.05)
    opposite = points - 2 * points.mean(axis=0)  # the origin is on the other side of the plane
    for cloud in (points, opposite, _FLOOR):  # the mean of few points moves far if one is left out
        assert_through_the_mean(fit_plane(cloud.copy()), cloud)


@visible_check(
    "fit_plane",
    weight=1,
    title="Returns a normal of length 1",
    why="If the normal had length 5, all distances from the plane would be five times too large.",
    hint="Return a row of the SVD's third result, which already has length 1. Divide any other "
    "normal and its d by the length.",
)
def fit_has_a_unit_normal(fit_plane: Callable) -> None:
    require_direction(fit_plane)
    points, _ = scattered_plane(2, 80, 0, noise=0.05)
    assert_unit_normal(fit_plane(points.copy()))


@visible_check(
    "fit_plane",
    weight=4,
    title="Fits a wall as well as a road",
    why="A wall is also a plane, but z = α x + β y + γ cannot describe it.",
    hint="Do not solve for z. The SVD treats all three directions alike.",
)
def fits_a_wall(fit_plane: Callable) -> None:
    require_direction(fit_plane)
    for plane in ((0.6, 0.8, 0.0, -4.0), (1.0, 0.0, 0.0, 7.0)):
        points, _ = scattered_plane(3, 60, 0, plane=plane, noise=0.03)
        assert_direction(fit_plane(points.copy()), points)


@visible_check(
    "fit_plane",
    weight=1,
    title="Works far from the sensor",
    why="Most planes do not pass through the sensor. The SVD finds their normal only if the "
    "points are centred.",
    hint="Subtract the mean first, and use it again to compute d.",
)
def fits_far_away(fit_plane: Callable) -> None:
    require_direction(fit_plane)
    points, _ = scattered_plane(4, 60, 0, plane=(0.0, 0.28, 0.96, 55.0), noise=0.02)
    points += [70.0, 0.0, 0.0]
    assert_direction(fit_plane(points.copy()), points)


@visible_check(
    "fit_plane",
    weight=4,
    title="Ignores intensity in a fourth column, whether it varies much or little",
    why="The intensity is not a direction in space, so bright points must not tilt the plane.",
    hint="Select points[:, :3] before anything else.",
)
def ignores_intensity(fit_plane: Callable) -> None:
    require_direction(fit_plane)
    points, _ = scattered_plane(5, 60, 0, noise=0.05, columns=4)
    for scale in (1.0, 1e-5):  # the intensity has the largest spread, then the least
        cloud = points * [1, 1, 1, scale]
        assert_direction(fit_plane(cloud.copy()), cloud)


@visible_check(
    "fit_plane",
    weight=1,
    title="Works on three points",
    why="Three points are the fewest that define a plane, and the best plane passes through all "
    "three.",
    hint="Use the same code for three points. With full_matrices=False, the third result of the "
    "SVD has three rows for any number of points.",
)
def fits_three_points(fit_plane: Callable) -> None:
    require_direction(fit_plane)
    for triangle in TRIANGLES[2:]:
        assert_direction(fit_plane(triangle.copy()), triangle)


@visible_check(
    "fit_plane",
    weight=2,
    title="Works on thousands of points without an n × n matrix",
    why="A road has thousands of points, and for 50,000 points, an n × n matrix needs 20 "
    "gigabytes.",
    hint="Use np.linalg.svd(..., full_matrices=False). Without it, the first result has a row "
    "and a column for each point.",
)
def fits_many_points(fit_plane: Callable) -> None:
    require_direction(fit_plane)
    # The judge limits memory. A notebook only measures it, so it uses a smaller cloud.
    n = 25_000 if isinstance(fit_plane, RemoteProxy) else 3_000
    points, _ = scattered_plane(6, n, 0, noise=0.05)
    try:
        with _peak_memory() as used:
            answer = fit_plane(points.copy())
    except Exception as error:
        if "MemoryError" not in type(error).__name__ + getattr(error, "type_name", ""):
            raise
        raise CheckFailed(f"There is not enough memory to fit a plane to {n:,} points.") from None
    if used() > 40e6:
        raise CheckFailed(
            f"Fitting a plane to {n:,} points takes far more memory than the points themselves.",
            yours=f"{used() / 1e6:.0f} MB",
            expected=f"a few times {points.nbytes / 1e6:.1f} MB",
        )
    assert_direction(answer, points)


@contextlib.contextmanager
def _peak_memory() -> Iterator[Callable[[], int]]:
    """Measure the peak memory of arrays and objects inside the block, in bytes."""
    was_counting, peak = tracemalloc.is_tracing(), [0]
    tracemalloc.start()
    tracemalloc.reset_peak()
    before = tracemalloc.get_traced_memory()[0]
    try:
        yield lambda: peak[0]
    finally:
        peak[0] = tracemalloc.get_traced_memory()[1] - before
        if not was_counting:
            tracemalloc.stop()


@visible_check(
    "fit_plane",
    weight=1,
    title="Does not change its input",
    why="If the fit moved the cloud, all later distances would be wrong.",
    hint="Write points[:, :3] - centre, which makes a new array. points[:, :3] -= centre moves "
    "the cloud.",
)
def leaves_the_points(fit_plane: Callable) -> None:
    require_direction(fit_plane)
    points, _ = scattered_plane(2, 80, 0, noise=0.05)
    assert_untouched(fit_plane, points)


common_checks.promise_names(
    Case(
        __name__,
        "fit_plane",
        {"points": frozen(scattered_plane(2, 80, 0, noise=0.05)[0])},
        expected=None,  # `assert_direction` computes it
        compare=lambda answer, points, _: assert_direction(answer, points),
        precondition=require_direction,
    ),
    "keeps_points",
    title="Keeps the name of its parameter, points",
    why="Other code may pass the argument by name, as in fit_plane(points=...).",
)


def _through_the_mean(points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    return plane_through_point(points[:, :3].mean(axis=0), normal)


def _column_of_the_svd(points: np.ndarray) -> np.ndarray:
    """Return the last column of the SVD's third result, which may be confused with the row."""
    return np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][:, 2]


def _fit_along_z(points: np.ndarray) -> np.ndarray:
    """Return the plane a x + b y - z + d = 0 with the least squared errors along z; shape (4,)."""
    table = np.column_stack([points[:, :2], np.ones(len(points))])
    a, b, d = np.linalg.solve(table.T @ table, table.T @ points[:, 2])
    return np.array([a, b, -1.0, d])


declare_mistakes(
    "fit_plane",
    Mistake(
        "The points are not centred, so their spread is measured around the sensor.",
        lambda right, points: _through_the_mean(points, np.linalg.eigh(points.T @ points)[1][:, 0]),
        "Subtract the mean of the points before the SVD.",
    ),
    Mistake(
        "The normal is the direction of largest spread; it must be the direction of least spread.",
        lambda right, points: _through_the_mean(points, principal_components(points)[2][:, 2]),
        "The directions are sorted from largest to least spread: take the last row.",
    ),
    Mistake(
        "The normal is the direction of second-largest spread; it must be the direction of "
        "least spread.",
        lambda right, points: _through_the_mean(points, principal_components(points)[2][:, 1]),
        "The directions are sorted from largest to least spread: take the last row.",
    ),
    Mistake(
        "The normal is a column of the SVD's third result, but the directions are its rows.",
        lambda right, points: _through_the_mean(points, _column_of_the_svd(points)),
        "Take the last row, [-1], not the last column, [:, -1].",
    ),
    Mistake(
        "a, b and c are right, but d has the wrong sign.",
        lambda right, points: right * [1, 1, 1, -1],
        "Compute d = -(normal @ centre), where centre is the mean of the points.",
    ),
    Mistake(
        "d is always 0, so the plane passes through the sensor instead of the points.",
        lambda right, points: right * [1, 1, 1, 0],
        "Compute d = -(normal @ centre), where centre is the mean of the points.",
    ),
    Mistake(
        "The plane depends only on the first three points. It should be closest to all of them.",
        lambda right, points: best_plane(points[:3])[0],
        "Use all points: subtract their mean, then take the SVD.",
        is_cheap=True,
    ),
    Mistake(
        "The function measures the errors along z, not perpendicular to the plane.",
        lambda right, points: with_unit_normal(_fit_along_z(points)),
        "Do not solve for z. The SVD treats all three directions alike.",
    ),
    Mistake(
        "The function measures the errors along z, and does not divide the normal (a, b, -1) by "
        "its length.",
        lambda right, points: _fit_along_z(points),
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
    is_same=same_plane,
)
