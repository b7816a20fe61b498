"""Hidden tests of lesson 03. Titles and hints are shown to students; the code is not.

RANSAC is judged by what it finds, with so many iterations that a right answer fails less than
once in a thousand million runs: where p is the chance that one sample succeeds, N iterations
fail with probability (1 - p)^N.
"""

import functools
import math
from fractions import Fraction

import numpy as np
import pytest

from grader.judging import samples
from grader.judging.marks import hidden, visible_checks
from utils.checks.lesson_03 import (
    assert_best_plane,
    assert_consensus,
    assert_finds,
    assert_iterations,
    assert_nothing_found,
    assert_plane,
    scattered_plane,
)
from utils.checks.vocabulary import CheckFailed, assert_close


@visible_checks(
    "plane_through", "point_plane_distance", "ransac_plane", "fit_plane", "iterations_needed"
)
def test_visible(student, check):
    check.run(getattr(student, check.exercise))


def random_plane(rng):
    """A unit normal in any direction, and an offset; shape (4,)."""
    normal = rng.normal(size=3)
    return np.append(normal / np.linalg.norm(normal), rng.uniform(-5, 5))


def random_triangle(rng, size=5.0):
    """Three points far from one line; shape (3, 3)."""
    while True:
        triangle = rng.uniform(-size, size, (3, 3))
        sides = triangle[1:] - triangle[0]
        if np.linalg.norm(np.cross(*sides)) > size**2 / 4:
            return triangle


@hidden(
    "plane_through",
    weight=3,
    title="Right for triangles you have not seen",
    hint="The cross product of two sides is upright on the triangle; d makes the plane pass "
    "through p.",
)
def test_random_triangles(student, seed):
    rng = np.random.default_rng(seed)
    for _ in range(8):
        triangle = random_triangle(rng)
        assert_plane(student.plane_through(*triangle.copy()), through=triangle)


@hidden(
    "plane_through",
    weight=2,
    title="Moves with its points; any order gives the same plane",
    hint="Only the sign of the four numbers may change with the order.",
)
def test_order_and_translation(student, seed):
    rng = np.random.default_rng(seed + 1)
    triangle = random_triangle(rng)
    plane = assert_plane(student.plane_through(*triangle.copy()), through=triangle)
    for order in ((1, 0, 2), (2, 0, 1), (2, 1, 0)):
        assert_plane(student.plane_through(*triangle[list(order)]), expected=plane)
    shift = rng.uniform(-30, 30, 3)
    moved = np.append(plane[:3], plane[3] - plane[:3] @ shift)
    assert_plane(student.plane_through(*(triangle + shift)), expected=moved)
    assert_plane(student.plane_through(*triangle.astype(np.float32)), expected=plane)


@hidden(
    "plane_through",
    weight=2,
    title="None for points of one line, however they lie on it",
    hint="The cross product is zero, or as good as zero: compare its length with 1e-9.",
)
def test_lines(student, seed):
    rng = np.random.default_rng(seed + 2)
    for _ in range(4):
        start, step = rng.integers(-9, 9, 3), rng.integers(1, 9, 3)
        factors = rng.permutation([0, 2, 5])[:, None]
        if student.plane_through(*(start + factors * step).astype(float)) is not None:
            raise CheckFailed("Points of one line have no plane: the answer must be None.")
    triangle = random_triangle(rng)
    assert_plane(student.plane_through(*triangle.copy()), through=triangle)


def gaps_by_hand(points, plane):
    a, b, c, d = plane
    return np.array([abs(a * x + b * y + c * z + d) for x, y, z in points[:, :3].tolist()])


@hidden(
    "point_plane_distance",
    weight=3,
    title="Right for the course's own scan",
    hint="a x + b y + c z + d, without its sign.",
)
def test_distances_in_the_course_cloud(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 2000)
    for plane in ((0.0, 0.0, 1.0, 1.73), tuple(random_plane(np.random.default_rng(seed)))):
        assert_close(
            student.point_plane_distance(cloud.copy(), plane),
            gaps_by_hand(cloud, plane),
            "distances",
        )


@hidden(
    "point_plane_distance",
    weight=3,
    title="Turning and moving points and plane together changes no distance",
    hint="All three coordinates count alike.",
)
def test_distances_survive_motion(student, seed):
    rng = np.random.default_rng(seed)
    xyz = rng.uniform(-8, 8, (60, 3))
    plane = random_plane(rng)
    expected = gaps_by_hand(xyz, plane)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    shift = rng.uniform(-20, 20, 3)
    normal = turn @ plane[:3]
    moved = np.append(normal, plane[3] - normal @ shift)
    assert_close(
        student.point_plane_distance(xyz @ turn.T + shift, moved.copy()), expected, "distances"
    )
    assert_close(student.point_plane_distance(xyz.copy(), -plane), expected, "distances")


@hidden(
    "point_plane_distance",
    weight=2,
    title="Right for four columns, single precision, one point and none",
    hint="points[:, :3], and one number per row.",
)
def test_distances_of_small_clouds(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 50)
    plane = random_plane(np.random.default_rng(seed + 3))
    for variant in (
        cloud,
        cloud.astype(np.float32),
        np.asfortranarray(cloud),
        cloud[:1],
        cloud * [1, 1, 1, 255],
        cloud[:3, :3],
        cloud[:4],
        cloud[:0],
    ):
        assert_close(
            student.point_plane_distance(variant.copy(), plane.copy()),
            gaps_by_hand(variant, plane),
            "distances",
        )


def tilted(cloud, rng):
    """The cloud as a scanner sees it that is mounted askew, at any height."""
    lean, heading = rng.uniform(0.2, 0.7), rng.uniform(0, 2 * np.pi)
    axis = np.array([np.cos(heading), np.sin(heading), 0.0])
    upright = np.cross(axis, [0.0, 0.0, 1.0])
    across = np.array([0.0, 0.0, 1.0])
    frame = np.column_stack([axis, upright, across])
    cosine, sine = np.cos(lean), np.sin(lean)
    turn = frame @ np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]]) @ frame.T
    return np.column_stack([cloud[:, :3] @ turn.T + [0.0, 0.0, rng.uniform(-3, 3)], cloud[:, 3:]])


@functools.lru_cache(maxsize=256)
def street_and_its_best(name, street, run, tolerance):
    """Points of a street, the mask of its largest plane, and iterations that surely find it.

    The oracle tries 1 500 samples at once; the share of them that hold 85 % of the best one's
    inliers is the chance of a single sample. A tenth is left as a margin for its own error.
    """
    cloud = samples.course_cloud() if name == "course" else samples.fresh_street(street)
    near, low = (np.abs(cloud[:, :2]) < (12, 8)).all(axis=1), cloud[:, 2] < -0.9
    rng = np.random.default_rng((street, run))
    # A quarter are obstacles: three rows of the cloud are rarely all in the road.
    rows = [rng.choice(np.flatnonzero(near & low), 370, replace=False)]
    rows += [rng.choice(np.flatnonzero(near & ~low), 130, replace=False)]
    points = tilted(cloud[rng.permutation(np.concatenate(rows))], rng)
    triples = points[np.array([rng.choice(500, 3, replace=False) for _ in range(1500)]), :3]
    normals = np.cross(triples[:, 1] - triples[:, 0], triples[:, 2] - triples[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    normals, triples = normals[lengths > 1e-6], triples[lengths > 1e-6]
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    offsets = (normals * triples[:, 0]).sum(axis=1)
    masks = np.abs(points[:, :3] @ normals.T - offsets) <= tolerance
    counts = masks.sum(axis=0)
    chance = 0.9 * np.mean(counts >= 0.85 * counts.max())
    return points, int(counts.max()), min(900, math.ceil(25 / chance))


@hidden(
    "ransac_plane",
    weight=4,
    title="Finds the road in a street",
    hint="Draw your plane from the side, as in the notebook: does it lie in the road?",
)
@pytest.mark.parametrize("name", ["course", "fresh"])
def test_streets(student, seed, name):
    for run in range(3):
        points, most, iterations = street_and_its_best(name, seed, run, 0.15)
        answer = student.ransac_plane(points.copy(), iterations, 0.15, np.random.default_rng(run))
        _, inliers = assert_consensus(answer, points, 0.15)
        found = np.count_nonzero(inliers)
        if found < 0.82 * most:
            raise CheckFailed(
                "A plane with many more inliers exists.",
                yours=f"{found} inliers",
                expected=f"about {most} inliers",
            )


@hidden(
    "ransac_plane",
    weight=4,
    title="Finds planes in any direction, run after run",
    hint="A wall, a ramp and a road are the same to it. Look also at how the best plane is kept.",
)
def test_any_direction(student, seed):
    rng = np.random.default_rng(seed)
    for run in range(6):
        points, belongs = scattered_plane(seed + run, 40, 25, random_plane(rng))
        # One sample in four is good and half of those lie well: 0.87^200 < 1e-12.
        answer = student.ransac_plane(points.copy(), 200, 0.12, np.random.default_rng(run))
        assert_finds(answer, points, 0.12, belongs)


@hidden(
    "ransac_plane",
    weight=3,
    title="Finds the plane among twice as many outliers",
    hint="Every round needs three new rows, and the best of all rounds counts, not the last.",
)
def test_many_outliers(student, seed):
    for run in range(2):
        points, belongs = scattered_plane(
            seed + 10 + run, 25, 50, random_plane(np.random.default_rng(seed + run))
        )
        # One sample in thirty, of which two thirds lie well: 0.977^1000 < 1e-10.
        answer = student.ransac_plane(points.copy(), 1000, 0.12, np.random.default_rng(run))
        assert_finds(answer, points, 0.12, belongs, share=0.85)


@hidden(
    "ransac_plane",
    weight=2,
    title="Draws three different rows",
    hint="rng.choice(n, 3, replace=False): with replacement a row comes up twice.",
)
def test_three_points(student, seed):
    rng = np.random.default_rng(seed)
    for run in range(12):
        triangle = random_triangle(rng)
        plane, inliers = assert_consensus(
            student.ransac_plane(triangle.copy(), 1, 0.1, np.random.default_rng(run)), triangle, 0.1
        )
        assert_plane(plane, through=triangle)
        if not inliers.all():
            raise CheckFailed("Three points have one sample, and all three lie on its plane.")


@hidden(
    "ransac_plane",
    weight=2,
    title="Right for single precision, other memory orders, duplicates and four columns",
    hint="Use points[:, :3] and the rows as they come.",
)
def test_forms(student, seed):
    rng = np.random.default_rng(seed)
    forms = (lambda points: points.astype(np.float32), np.asfortranarray, lambda p: p[:, :3])
    for run, form in enumerate(forms):
        points, belongs = scattered_plane(seed + 20 + run, 40, 20, columns=4)
        variant = form(points)
        assert_finds(student.ransac_plane(variant.copy(), 250, 0.12, rng), variant, 0.12, belongs)
    twice, belongs = np.repeat(points, 2, axis=0), np.repeat(belongs, 2)
    assert_finds(student.ransac_plane(twice.copy(), 300, 0.12, rng), twice, 0.12, belongs)


@hidden(
    "ransac_plane",
    weight=2,
    title="Goes on when nearly all samples lie on one line",
    hint="A sample without a plane is skipped, and it counts as a round.",
)
def test_degenerate(student, seed):
    rng = np.random.default_rng(seed)
    pole = np.column_stack([np.full(30, 3.0), np.full(30, 1.0), np.arange(30.0)])
    wall = np.column_stack([np.full(20, 3.0), rng.integers(-40, 40, 20), rng.integers(0, 30, 20)])
    points = np.concatenate([pole, wall]).astype(float)
    # The pole stands in the wall x = 3: every sample that is no line gives this plane.
    answer = student.ransac_plane(points.copy(), 300, 0.1, rng)
    plane, _ = assert_finds(answer, points, 0.1, np.ones(50, dtype=bool))
    assert_plane(plane, expected=(1.0, 0.0, 0.0, -3.0))
    for n in (0, 1, 2):
        assert_nothing_found(student.ransac_plane(points[:n].copy(), 50, 0.1, rng), n)


@hidden(
    "fit_plane",
    weight=3,
    title="Right for planes in any direction, with noise",
    hint="Centre the points, take the SVD, and the direction with the smallest spread.",
)
def test_fit_any_direction(student, seed):
    rng = np.random.default_rng(seed)
    for run in range(4):
        points, _ = scattered_plane(seed + run, 50, 0, random_plane(rng), noise=0.1)
        assert_best_plane(student.fit_plane(points.copy()), points)


@hidden(
    "fit_plane",
    weight=2,
    title="Right for pieces of the course's own scan",
    hint="Any cloud has a best plane, flat or not.",
)
def test_fit_course_cloud(student, seed):
    cloud = samples.course_cloud()
    near = (np.abs(cloud[:, 0] - 6) < 6) & (np.abs(cloud[:, 1]) < 5) & (cloud[:, 2] < -1.3)
    rows = np.random.default_rng(seed).choice(np.flatnonzero(near), 800, replace=False)
    assert_best_plane(student.fit_plane(cloud[rows].copy()), cloud[rows])


@hidden(
    "fit_plane",
    weight=2,
    title="Right for three points, single precision and duplicates",
    hint="Three points have a best plane, too: the one through them.",
)
def test_fit_small(student, seed):
    rng = np.random.default_rng(seed)
    triangle = random_triangle(rng)
    assert_plane(student.fit_plane(triangle.copy()), through=triangle)
    points, _ = scattered_plane(seed + 30, 40, 0, random_plane(rng), noise=0.05, columns=4)
    for variant in (
        points.astype(np.float32),
        np.asfortranarray(points),
        np.repeat(points, 3, axis=0),
    ):
        assert_best_plane(student.fit_plane(variant.copy()), variant)


def iterations_by_trying(ratio, size, confidence):
    """Smallest N, counted up in exact arithmetic; None where rounding could decide."""
    bad, remaining = 1 - Fraction(ratio) ** size, Fraction(1)
    allowed = 1 - Fraction(confidence)
    for number in range(1, 400):
        remaining *= bad
        if abs(float(remaining / allowed) - 1) < 1e-6:
            return None
        if remaining <= allowed:
            return number
    return None


@hidden(
    "iterations_needed",
    weight=4,
    title="Right for numbers you have not seen",
    hint="log(1 - confidence) / log(1 - w^s), rounded up.",
)
def test_iterations(student, seed):
    rng = np.random.default_rng(seed)
    tried = 0
    while tried < 15:
        ratio, confidence = rng.choice(np.arange(30, 96)) / 100, rng.choice([0.9, 0.99, 0.995])
        size = int(rng.integers(1, 5))
        expected = iterations_by_trying(ratio, size, confidence)
        if expected is not None:
            assert_iterations(
                student.iterations_needed(float(ratio), size, float(confidence)), expected
            )
            tried += 1
