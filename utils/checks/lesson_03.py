"""Visible checks of lesson 03: planes through points, distances, RANSAC, refit, iterations.

`assert_plane`, `assert_consensus` and `assert_iterations` are the judge's, too. A plane and its
negative are the same plane: everything here accepts both.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks.core import visible
from utils.checks.vocabulary import (
    CheckFailed,
    as_array,
    assert_close,
    assert_untouched,
    brief,
    frozen,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# A level road, a wall, a slope, a plane through the sensor, and one far away.
_TRIANGLES = (
    ((4.0, 1.0, -1.7), (9.0, -2.0, -1.7), (6.0, 3.0, -1.7)),
    ((2.0, 5.0, 0.0), (8.0, 5.0, 1.0), (5.0, 5.0, -1.5)),
    ((0.0, 0.0, -1.0), (10.0, 0.0, 1.0), (3.0, 4.0, -2.0)),
    ((0.0, 0.0, 0.0), (3.0, 1.0, 0.5), (-2.0, 4.0, 1.0)),
    ((61.0, -40.0, 2.0), (64.0, -39.0, 2.5), (62.0, -35.0, -1.0)),
)
_SLOPE = frozen(np.array([-0.6, 0.0, 0.8, 2.0]))  # a unit normal, and no special direction but y


def assert_plane(
    answer: object,
    through: ArrayLike | None = None,
    expected: ArrayLike | None = None,
    tolerance: float = 2e-3,
) -> np.ndarray:
    """The answer is a plane with a unit normal: through some points, or a certain one.

    Parameters
    ----------
    answer : object
    through : (m, 3) array_like, optional
        Points that must lie on it.
    expected : (4,) array_like, optional
        The plane itself, unit normal, sign free.
    tolerance : float
        In metres at the points and for the coefficients.

    Returns
    -------
    numpy.ndarray, shape (4,)
    """
    if answer is None:
        raise CheckFailed(
            "The function returned None, but there is such a plane.",
            yours="None",
            expected="four numbers (a, b, c, d)",
        )
    plane = as_array(answer, what="four numbers (a, b, c, d)")
    if plane.shape != (4,):
        raise CheckFailed(
            "A plane is four numbers (a, b, c, d).",
            yours=f"shape {plane.shape}",
            expected="shape (4,)",
        )
    plane = plane.astype(float)
    if not np.isfinite(plane).all():
        raise CheckFailed("Some of the four numbers are not finite.", yours=brief(plane))
    length = np.linalg.norm(plane[:3])
    if abs(length - 1) > 1e-3:
        raise CheckFailed(
            f"The normal (a, b, c) has length {length:.4g}, not 1. Divide by it "
            "before d is computed.",
            yours=brief(plane),
            expected="length 1",
        )
    if through is not None:
        through = np.asarray(through, dtype=float)
        gaps = np.abs(through @ plane[:3] + plane[3])
        if gaps.max() > tolerance:
            mirrored = np.abs(through @ plane[:3] - plane[3]).max() <= tolerance
            raise CheckFailed(
                "The sign of d is wrong: a x + b y + c z + d must be 0 at the points."
                if mirrored
                else f"The points do not lie on the plane: one of them is {gaps.max():.3g} m away.",
                yours=brief(plane),
            )
    if expected is not None:
        expected = np.asarray(expected, dtype=float)
        expected = expected * (1 if expected[:3] @ plane[:3] >= 0 else -1)
        angle = np.degrees(np.arccos(np.clip(plane[:3] @ expected[:3], -1, 1)))
        if not np.allclose(plane, expected, rtol=0, atol=tolerance):
            raise CheckFailed(
                f"This is another plane; its normal is {angle:.1f} degrees off.",
                yours=brief(plane),
                expected=brief(expected),
            )
    return plane


def assert_consensus(
    answer: object, points: np.ndarray, distance_tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """The answer is a model and the mask of the points within the tolerance of that model.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    distance_tolerance : float

    Returns
    -------
    plane : numpy.ndarray, shape (4,)
    inliers : numpy.ndarray of bool, shape (n,)
    """
    model, inliers = _pair(answer)
    plane = assert_plane(model)
    inliers = _as_mask(inliers, len(points))
    gaps = np.abs(points[:, :3].astype(float) @ plane[:3] + plane[3])
    clear = np.abs(gaps - distance_tolerance) > 1e-4
    wrong = np.count_nonzero((inliers != (gaps <= distance_tolerance)) & clear)
    if wrong:
        raise CheckFailed(
            f"The mask does not belong to the returned model: for {wrong} points it says "
            "something else than distance <= distance_tolerance.",
            yours=f"{inliers.sum()} inliers",
            expected=f"{np.count_nonzero(gaps <= distance_tolerance)} inliers",
            draw=lambda: _draw(points, plane, inliers, distance_tolerance),
        )
    return plane, inliers


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
    if _as_mask(inliers, n).any():
        raise CheckFailed(
            "Without a model there are no inliers: the mask must be all False.",
            yours=brief(np.asarray(inliers)),
            expected="all False",
        )


def assert_finds(
    answer: object,
    points: np.ndarray,
    distance_tolerance: float,
    belongs: np.ndarray,
    share: float = 0.9,
) -> tuple[np.ndarray, np.ndarray]:
    """The answer is a consensus that holds at least a share of the points that belong.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    distance_tolerance : float
    belongs : numpy.ndarray of bool, shape (n,)
    share : float

    Returns
    -------
    plane : numpy.ndarray, shape (4,)
    inliers : numpy.ndarray of bool, shape (n,)
    """
    plane, inliers = assert_consensus(answer, points, distance_tolerance)
    found = np.count_nonzero(inliers & belongs)
    if found < share * np.count_nonzero(belongs):
        raise CheckFailed(
            "A plane with many more inliers exists.",
            yours=f"{found} of its points, {np.count_nonzero(inliers)} inliers in all",
            expected=f"nearly all of its {np.count_nonzero(belongs)} points",
            draw=lambda: _draw(
                points, plane, inliers, distance_tolerance, best_plane(points[belongs])[0]
            ),
        )
    return plane, inliers


def assert_iterations(answer: object, expected: float) -> None:
    """The answer is the number expected; `math.inf` is met by whatever says "never".

    Parameters
    ----------
    answer : object
    expected : int or math.inf
    """
    if expected == math.inf:
        if isinstance(answer, (int, float)) and not isinstance(answer, bool) and answer >= 1e9:
            return
        if answer is None or "beyond 64 bits" in getattr(answer, "type_name", ""):
            return
        raise CheckFailed(
            "Without a single inlier no number of samples is enough.",
            yours=brief(answer),
            expected="math.inf",
        )
    number = as_array(answer, what="a whole number")
    if number.shape != ():
        raise CheckFailed(
            "The answer is one number.", yours=f"shape {number.shape}", expected="one whole number"
        )
    if number != np.round(number):
        raise CheckFailed(
            "Half an iteration cannot be made: round up.",
            yours=brief(answer),
            expected=str(expected),
        )
    if number != expected:
        near = (
            " One too few does not reach the confidence: round up, not down."
            if number == expected - 1
            else ""
        )
        raise CheckFailed(
            f"This is not the smallest number that suffices.{near}",
            yours=str(number),
            expected=str(expected),
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
        With a unit normal; by default another one for each seed.
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
        tilt, heading = rng.uniform(0.3, 1.0), rng.uniform(0, 2 * np.pi)
        level = np.sin(tilt) * np.array([np.cos(heading), np.sin(heading)])
        plane = (*level, np.cos(tilt), rng.uniform(-4, 4))
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
    if not isinstance(answer, (tuple, list)) or len(answer) != 2:
        raise CheckFailed(
            "Return two things, the model and the mask: `return model, inliers`.",
            yours=brief(answer),
            expected="(model, inliers)",
        )
    return answer


def _as_mask(inliers: object, n: int) -> np.ndarray:
    mask = as_array(inliers, what="a mask of True and False")
    if mask.shape == (0,) and n == 0:
        return mask.astype(bool)
    if mask.dtype != bool:
        raise CheckFailed(
            "The inliers must be a mask, one True or False per point, not numbers or indices.",
            yours=brief(mask),
            expected=f"{n} times True or False",
        )
    if mask.shape != (n,):
        raise CheckFailed(
            "There must be one True or False for each point.",
            yours=f"shape {mask.shape}",
            expected=f"shape ({n},)",
        )
    return mask


def _draw(
    points: np.ndarray,
    plane: np.ndarray,
    inliers: np.ndarray | None,
    tolerance: float | None,
    expected: np.ndarray | None = None,
) -> Axes:
    """Draw points and a plane from the side, and the right plane dashed beside it."""
    axes = utils.plots.plane_model(points, plane, inliers, tolerance, title="yours")
    if expected is not None and abs(expected[2]) > 0.2:
        ends = np.array(axes.get_xlim())
        heights = -(expected[0] * ends + expected[3]) / expected[2]
        axes.plot(ends, heights, color="black", linestyle="--", scalex=False, scaley=False)
        axes.text(ends[0], heights[0], " expected", va="bottom")
    return axes


def _points(*rows: Sequence[float]) -> list[np.ndarray]:
    return [np.array(row, dtype=float) for row in rows]


@visible(
    "plane_through",
    weight=3,
    title="The three points lie on the plane",
    why="Everything else, distances and inliers, is measured from this plane.",
    hint="The cross product of q - p and r - p stands upright on both. Then choose d so "
    "that a x + b y + c z + d is 0 at p.",
)
def holds_its_points(plane_through: Callable) -> None:
    for triangle in _TRIANGLES:
        assert_plane(plane_through(*_points(*triangle)), through=triangle)


@visible(
    "plane_through",
    weight=2,
    title="The normal has length 1",
    why="Only then is a x + b y + c z + d a distance in metres, and 0.2 means 20 cm.",
    hint="Divide the cross product by np.linalg.norm of it, and compute d afterwards.",
)
def has_a_unit_normal(plane_through: Callable) -> None:
    small, large = (
        ((0.0, 0.0, 1.0), (0.1, 0.0, 1.0), (0.0, 0.2, 1.1)),
        ((0.0, 0.0, 1.0), (50.0, 0.0, 1.0), (0.0, 40.0, 3.0)),
    )
    for triangle in (large, small):
        assert_plane(plane_through(*_points(*triangle)), through=triangle)


@visible(
    "plane_through",
    weight=2,
    title="Returns None for points on one line",
    why="A scanner draws lines on walls and roads: such samples come up all the time, and "
    "0 / 0 would spread through all distances.",
    hint="When the cross product has length 0, return None before dividing by it.",
)
def refuses_a_line(plane_through: Callable) -> None:
    lines = (
        ((1, 1, 1), (2, 2, 2), (5, 5, 5)),
        ((1, 2, 3), (1, 2, 3), (4, 0, 1)),
        ((1, 2, 3), (4, 0, 1), (4, 0, 1)),
        ((2, 2, 2), (2, 2, 2), (2, 2, 2)),
    )
    for line in lines:
        answer = plane_through(*_points(*line))
        if answer is not None:
            raise CheckFailed(
                f"{line[0]}, {line[1]}, {line[2]} lie on one line: infinitely many "
                "planes go through them.",
                yours=brief(answer),
                expected="None",
            )
    assert_plane(plane_through(*_points(*_TRIANGLES[0])), through=_TRIANGLES[0])


@visible(
    "plane_through",
    weight=1,
    title="Sees a line through rounding errors, and a triangle that is small",
    why="Measured points are never whole numbers, and neighbours are centimetres apart.",
    hint="Do not compare a computed length with exactly 0: compare it with something tiny, "
    "such as 1e-9.",
)
def sees_through_rounding(plane_through: Callable) -> None:
    start, step = np.array([0.1, 0.2, 0.3]), np.array([0.7, 0.1, -0.3])
    answer = plane_through(start, start + 0.1 * step, start + 0.7 * step)
    if answer is not None:
        raise CheckFailed(
            "These three points lie on one line, but for the last digit of a float.",
            yours=brief(answer),
            expected="None",
        )
    triangle = (3.0, 1.0, -1.7), (3.1, 1.0, -1.7), (3.0, 1.08, -1.68)
    assert_plane(plane_through(*_points(*triangle)), through=triangle)


@visible(
    "plane_through",
    weight=1,
    title="Leaves its points untouched",
    why="The sample is part of the cloud: a point that moves is a wrong point for ever.",
    hint="Write q - p, not q -= p.",
)
def leaves_its_points(plane_through: Callable) -> None:
    points = _points(*_TRIANGLES[2])
    assert_plane(plane_through(*points), through=_TRIANGLES[2])
    assert_untouched(plane_through, *_points(*_TRIANGLES[2]))


_OFF_PLANE = frozen(
    np.array(
        [
            [0.0, 0.0, 0.0, 0.9],
            [0.0, 5.0, -2.5, 0.1],
            [3.0, -4.0, 1.0, 0.5],
            [10.0, 1.0, 2.0, 0.3],
            [-8.0, 2.0, -9.0, 0.7],
        ]
    )
)
_GAPS = frozen(np.array([2.0, 0.0, 1.0, 2.4, 0.4]))  # from _SLOPE, by hand


def _assert_distances(answer: object, points: np.ndarray, plane: ArrayLike) -> None:
    expected = np.array(
        [
            abs(plane[0] * x + plane[1] * y + plane[2] * z + plane[3])
            for x, y, z in points[:, :3].tolist()
        ]
    )
    yours = as_array(answer, what="an array of distances")
    if yours.shape == expected.shape and len(expected):
        raw = points[:, :3] @ np.asarray(plane[:3])
        slips = {
            "Some are negative: a distance has no sign, so take np.abs.": raw + plane[3],
            "d is missing: these are the distances from a plane through the origin.": np.abs(raw),
            "d is subtracted; it must be added.": np.abs(raw - plane[3]),
            "These are the squares of the distances.": expected**2,
        }
        for sentence, values in slips.items():
            if not np.allclose(values, expected) and np.allclose(yours, values, atol=1e-3):
                raise CheckFailed(sentence, yours=brief(yours), expected=brief(expected))
    assert_close(answer, expected, "distances")


@visible(
    "point_plane_distance",
    weight=4,
    title="Measures distances on both sides of a plane",
    why="A distance that is wrong by a factor makes 20 cm of tolerance 5 cm or 80 cm.",
    hint="a x + b y + c z + d for every point, then the absolute value.",
)
def measures_distances(point_plane_distance: Callable) -> None:
    xyz = _OFF_PLANE[:, :3]
    _assert_distances(point_plane_distance(xyz.copy(), _SLOPE.copy()), xyz, _SLOPE)
    wall = np.array([0.0, 1.0, 0.0, -5.0])
    _assert_distances(point_plane_distance(xyz.copy(), wall.copy()), xyz, wall)


@visible(
    "point_plane_distance",
    weight=2,
    title="A plane and its negative are the same plane",
    why="The sign of a normal depends on the order of the three points, by pure chance.",
    hint="A distance is never negative: np.abs of the whole sum.",
)
def forgets_the_sign(point_plane_distance: Callable) -> None:
    xyz = _OFF_PLANE[:, :3]
    _assert_distances(point_plane_distance(xyz.copy(), -_SLOPE), xyz, -_SLOPE)


@visible(
    "point_plane_distance",
    weight=2,
    title="The fourth column does not count; the plane may be a tuple or a list",
    why="(n, 4) times (4,) works without an error, and multiplies brightness with d.",
    hint="Take points[:, :3] and the first three numbers of the plane; add the last one.",
)
def ignores_intensity(point_plane_distance: Callable) -> None:
    bright = _OFF_PLANE * [1, 1, 1, 255]
    for plane in (tuple(_SLOPE.tolist()), _SLOPE.tolist(), _SLOPE.copy()):
        _assert_distances(point_plane_distance(bright.copy(), plane), bright, _SLOPE)


@visible(
    "point_plane_distance",
    weight=2,
    title="One number per point, for one point and for none; leaves its input untouched",
    why="The mask of inliers needs one entry per row of the cloud.",
    hint="points[:, :3] @ normal has shape (n,); (n, 1) is something else.",
)
def one_number_per_point(point_plane_distance: Callable) -> None:
    cloud = _OFF_PLANE.copy()
    assert_close(point_plane_distance(cloud.copy(), _SLOPE.copy()), _GAPS, "distances")
    assert_untouched(point_plane_distance, _OFF_PLANE, _SLOPE)
    assert_close(point_plane_distance(cloud[2:3].copy(), _SLOPE.copy()), _GAPS[2:3], "distances")
    for columns in (3, 4):
        assert_close(
            point_plane_distance(np.empty((0, columns)), _SLOPE.copy()), np.empty(0), "distances"
        )


@visible(
    "ransac_plane",
    weight=5,
    title="Finds the plane among the outliers",
    why="The largest plane of a street is the road. What is not road may be an obstacle.",
    hint="Draw three rows, make a plane, count how many points are near it; keep the plane "
    "with the highest count. rng = np.random.default_rng(rng) makes a generator of a "
    "whole number, too.",
)
def finds_the_plane(ransac_plane: Callable) -> None:
    for seed in (1, 2, 3):
        points, belongs = scattered_plane(seed, 60, 30)
        rng = np.random.default_rng(seed)
        assert_finds(ransac_plane(points.copy(), 150, 0.1, rng), points, 0.1, belongs)


@visible(
    "ransac_plane",
    weight=3,
    title="Returns the model and the mask that belongs to it",
    why="Who gets the plane of one sample and the inliers of another removes the wrong points.",
    hint="When a sample is better than the best so far, keep both, plane and mask.",
)
def mask_belongs_to_model(ransac_plane: Callable) -> None:
    for seed in range(4):
        points, belongs = scattered_plane(10 + seed, 30, 30, noise=0.05)
        rng = np.random.default_rng(seed)
        for iterations in (2, 7, 80):
            answer = ransac_plane(points.copy(), iterations, 0.1, rng)
            assert_consensus(answer, points, 0.1)
        assert_finds(ransac_plane(points.copy(), 400, 0.2, rng), points, 0.2, belongs, 0.8)


@visible(
    "ransac_plane",
    weight=2,
    title="Follows distance_tolerance",
    why="The pavement lies a hand above the road. The tolerance decides whether it is road.",
    hint="Compare the distances with distance_tolerance, not with a number of your own.",
)
def follows_the_tolerance(ransac_plane: Callable) -> None:
    for seed in (21, 22, 23):
        rng = np.random.default_rng(seed)
        lean, turn = 0.1 * (seed - 20), 2.0 * seed
        normal = np.sin(lean) * np.cos(turn), np.sin(lean) * np.sin(turn), np.cos(lean)
        road, _ = scattered_plane(seed, 50, 0, plane=(*normal, 1.7), noise=0.005)
        pavement, _ = scattered_plane(seed + 100, 30, 0, plane=(*normal, 1.2), noise=0.005)
        order = rng.permutation(80)
        points, low = np.concatenate([road, pavement])[order], order < 50
        _, inliers = assert_finds(ransac_plane(points.copy(), 150, 0.05, rng), points, 0.05, low)
        if np.count_nonzero(inliers & ~low) > 8:
            raise CheckFailed(
                "With a tolerance of 5 cm the pavement, 50 cm higher, is no part of the road.",
                yours=f"{inliers.sum()} inliers",
                expected="about 50",
                draw=functools.partial(_draw, points, None, inliers, None),
            )
    assert_finds(
        ransac_plane(points=points.copy(), max_iterations=150, distance_tolerance=0.7, rng=rng),
        points,
        0.7,
        np.ones(80, dtype=bool),
        share=0.95,
    )


@visible(
    "ransac_plane",
    weight=2,
    title="Tries max_iterations samples",
    why="Iterations are time. Who allows one gets luck; who allows a thousand, certainty.",
    hint="for _ in range(max_iterations): one sample in each round.",
)
def follows_max_iterations(ransac_plane: Callable) -> None:
    points, belongs = scattered_plane(31, 20, 40)
    assert_finds(
        ransac_plane(points.copy(), 900, 0.1, np.random.default_rng(6)), points, 0.1, belongs
    )
    lucky = 0
    for seed in range(24):
        rng = np.random.default_rng(seed)
        _, inliers = assert_consensus(ransac_plane(points.copy(), 1, 0.1, rng), points, 0.1)
        lucky += np.count_nonzero(inliers & belongs) > 17
    if lucky > 14:  # expected: less than one
        raise CheckFailed(
            "One single sample hardly ever finds this plane. Yours tried more than it was allowed.",
            yours=f"found {lucky} times in 24",
            expected="once, perhaps twice",
        )


@visible(
    "ransac_plane",
    weight=3,
    title="Survives samples that are no plane",
    why="Duplicates and points in a line are common; one of them must not end the drive.",
    hint="plane_through returns None for them: go on with the next sample. And count that "
    "round, or the loop may never end.",
)
def survives_degenerate_samples(ransac_plane: Callable) -> None:
    rng = np.random.default_rng(7)
    for seed in (41, 42, 43):
        points, belongs = scattered_plane(seed, 40, 0)
        crowd = np.repeat(points[:1], 40, axis=0)
        both = np.concatenate([crowd, points])
        assert_finds(
            ransac_plane(both.copy(), 300, 0.1, rng),
            both,
            0.1,
            np.concatenate([np.ones(40, dtype=bool), belongs]),
        )
    line = np.outer(np.arange(12.0), [1.0, 2.0, 1.0])
    model, inliers = _pair(ransac_plane(line.copy(), 20, 0.1, np.random.default_rng(8)))
    if model is None:
        assert_nothing_found((model, inliers), 12)
    else:  # rounding may make a plane of it
        assert_consensus((model, inliers), line, 0.1)


@visible(
    "ransac_plane",
    weight=2,
    title="Returns (None, all False) for fewer than three points",
    why="After other filters little may be left, and the car must not stop for that.",
    hint="Ask for len(points) < 3 first, and return None and np.zeros(n, dtype=bool).",
)
def gives_up_politely(ransac_plane: Callable) -> None:
    for n in (0, 1, 2):
        for columns in (3, 4):
            points = np.arange(float(n * columns)).reshape(n, columns)
            rng = np.random.default_rng(9)
            assert_nothing_found(ransac_plane(points.copy(), 5, 0.1, rng), n)
    three = np.array(_TRIANGLES[2])
    plane, _ = assert_consensus(ransac_plane(three.copy(), 20, 0.1, rng), three, 0.1)
    assert_plane(plane, through=three)


@visible(
    "ransac_plane",
    weight=2,
    title="Takes four columns; leaves its input untouched; finds a wall as well as a road",
    why="The intensity is no coordinate, and a plane may stand upright.",
    hint="Use points[:, :3] for the sample and for the distances.",
)
def takes_four_columns(ransac_plane: Callable) -> None:
    points, belongs = scattered_plane(51, 50, 20, plane=(0.6, 0.8, 0.0, -4.0), columns=4)
    rng = np.random.default_rng(10)
    assert_finds(ransac_plane(points.copy(), 150, 0.1, rng), points, 0.1, belongs)
    assert_untouched(ransac_plane, points, 150, 0.1, rng)


@visible(
    "ransac_plane",
    weight=1,
    title="Follows rng: one seed one answer, other seeds others",
    why="A result that nobody can repeat cannot be debugged.",
    hint="rng = np.random.default_rng(rng), then draw with rng.choice, never with "
    "np.random.choice or a seed of your own.",
)
def follows_the_generator(ransac_plane: Callable) -> None:
    # One sample of three points is good once in eight times: who refits gets different planes, too.
    points, _ = scattered_plane(61, 30, 30, noise=0.05)
    planes = []
    for seed in range(12):
        (once, _), (again, _) = (
            assert_consensus(ransac_plane(points.copy(), 1, 0.2, rng), points, 0.2)
            for rng in (np.random.default_rng(seed), np.random.default_rng(seed))
        )
        if not np.allclose(once, again, atol=1e-6):
            raise CheckFailed(
                "The same seed gave two different planes.", yours=brief(again), expected=brief(once)
            )
        planes.append(once * np.sign(once[2]))
    if np.ptp(planes, axis=0).max() < 1e-9:
        raise CheckFailed(
            "Twelve seeds gave the very same plane: the samples do not come from rng.",
            yours=brief(planes[0]),
            expected="different planes",
        )


@visible(
    "ransac_plane",
    weight=1,
    title="rng may be a whole number, too: a seed",
    why="A seed fits into a log file; a generator does not.",
    hint="Begin with rng = np.random.default_rng(rng): it makes a generator of a whole number, "
    "and leaves a generator as it is.",
)
def takes_a_seed(ransac_plane: Callable) -> None:
    for seed in (1, 2, 3):
        points, belongs = scattered_plane(70 + seed, 40, 20)
        assert_finds(ransac_plane(points.copy(), 200, 0.1, seed), points, 0.1, belongs)
        (once, _), (again, _) = (
            assert_consensus(ransac_plane(points.copy(), 1, 0.1, seed), points, 0.1)
            for _ in range(2)
        )
        if not np.allclose(once, again, atol=1e-6):
            raise CheckFailed(
                "The same seed gave two different planes.", yours=brief(again), expected=brief(once)
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
    xyz = np.asarray(points, dtype=float)[:, :3]
    centre = xyz.mean(axis=0)
    variances, directions = np.linalg.eigh((xyz - centre).T @ (xyz - centre) / len(xyz))
    normal = directions[:, 0]
    return np.append(normal, -normal @ centre), math.sqrt(max(variances[0], 0.0))


def assert_best_plane(answer: object, points: np.ndarray) -> None:
    """The answer is a plane whose mean squared distance is the smallest possible.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    """
    plane = assert_plane(answer)
    best, least = best_plane(points)
    xyz = np.asarray(points, dtype=float)[:, :3]
    yours = math.sqrt(np.mean((xyz @ plane[:3] + plane[3]) ** 2))
    if yours > 1.001 * least + 1e-3:
        raise CheckFailed(
            "Another plane lies nearer to these points.",
            yours=f"{yours:.4f} m root mean square distance",
            expected=f"{least:.4f} m",
            draw=lambda: _draw(np.asarray(points), plane, None, None, best),
        )
    assert_plane(plane, expected=best, tolerance=1e-2)


@visible(
    "fit_plane",
    weight=3,
    title="Finds the plane that points lie on, with and without noise",
    why="Three points carry the noise of three points; a thousand average it away.",
    hint="Subtract the mean of the points, then np.linalg.svd: the normal is the last row "
    "of the third result.",
)
def fits_a_road(fit_plane: Callable) -> None:
    for seed, noise in ((1, 0.0), (2, 0.05)):
        points, _ = scattered_plane(seed, 80, 0, noise=noise)
        assert_best_plane(fit_plane(points.copy()), points)


@visible(
    "fit_plane",
    weight=2,
    title="Fits a wall as well as a road",
    why="z = a x + b y + c cannot describe a wall, and this function will meet walls.",
    hint="Do not solve for z. The SVD treats all three directions alike.",
)
def fits_a_wall(fit_plane: Callable) -> None:
    for plane in ((0.6, 0.8, 0.0, -4.0), (1.0, 0.0, 0.0, 7.0)):
        points, _ = scattered_plane(3, 60, 0, plane=plane, noise=0.03)
        assert_best_plane(fit_plane(points.copy()), points)


@visible(
    "fit_plane",
    weight=2,
    title="Works far from the sensor, and leaves its input untouched",
    why="A plane need not go through the origin: only the centred points have a plain direction.",
    hint="Subtract the mean first (in a new array), and put it back into d.",
)
def fits_far_away(fit_plane: Callable) -> None:
    points, _ = scattered_plane(4, 60, 0, plane=(0.0, 0.6, 0.8, 55.0), noise=0.02)
    points += [70.0, 0.0, 0.0]
    assert_best_plane(fit_plane(points.copy()), points)
    assert_untouched(fit_plane, points)


@visible(
    "fit_plane",
    weight=1,
    title="The fourth column does not count",
    why="Brightness is no direction in space.",
    hint="points[:, :3] before anything else.",
)
def fits_without_intensity(fit_plane: Callable) -> None:
    points, _ = scattered_plane(5, 60, 0, noise=0.02, columns=4)
    assert_best_plane(fit_plane(points.copy()), points)


@visible(
    "iterations_needed",
    weight=3,
    title="The smallest number that reaches the confidence",
    why="One sample too few and the promise is broken; a thousand too many and the frame is late.",
    hint="Solve 1 - (1 - w^s)^N >= confidence for N: a quotient of two logarithms, rounded up.",
)
def smallest_that_suffices(iterations_needed: Callable) -> None:
    for arguments, expected in (
        ((0.5, 2, 0.99), 17),
        ((0.6, 3, 0.99), 19),
        ((0.3, 3, 0.999), 253),
        ((0.9, 1, 0.95), 2),
    ):
        assert_iterations(iterations_needed(*arguments), expected)


@visible(
    "iterations_needed",
    weight=1,
    title="Follows all three parameters, by name",
    why="A line needs two points, a plane three: the same inliers, another number.",
    hint="w is inlier_ratio, s is sample_size.",
)
def follows_all_parameters(iterations_needed: Callable) -> None:
    for ratio, size, confidence, expected in (
        (0.7, 3, 0.9, 6),
        (0.7, 2, 0.9, 4),
        (0.7, 3, 0.9999, 22),
        (0.01, 3, 0.99, 4605168),
    ):
        assert_iterations(
            iterations_needed(inlier_ratio=ratio, sample_size=size, confidence=confidence), expected
        )


@visible(
    "iterations_needed",
    weight=2,
    title="With nothing but inliers, one sample is enough",
    why="log(0) waits here, in an empty car park without a single obstacle.",
    hint="Look at w = 1 before you take logarithms.",
)
def one_is_enough(iterations_needed: Callable) -> None:
    assert_iterations(iterations_needed(1.0, 3, 0.99), 1)
    assert_iterations(iterations_needed(1, 2, 0.5), 1)
    assert_iterations(iterations_needed(0.8, 3, 0.99), 7)


@visible(
    "iterations_needed",
    weight=2,
    title="Without inliers, no number is enough",
    why="0 would mean: no need to search. The truth is: no use in searching.",
    hint="Return math.inf (or np.inf) when w is 0: a division by log(1) would fail.",
)
def none_is_enough(iterations_needed: Callable) -> None:
    try:
        answer = iterations_needed(0.0, 3, 0.99)
    except Exception as error:  # refusing is an answer, too
        if "ValueError" not in (type(error).__name__, getattr(error, "type_name", "")):
            raise
    else:
        assert_iterations(answer, math.inf)
    assert_iterations(iterations_needed(0.4, 3, 0.99), 70)
