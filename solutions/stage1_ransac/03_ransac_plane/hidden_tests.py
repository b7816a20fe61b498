"""Hidden tests of lesson 03. Titles and hints are shown to students; the code is not.

RANSAC is judged by its result, with so many iterations that a right answer fails less than once in
a thousand million runs. If p is the chance that one sample succeeds, N iterations fail with
probability (1 - p)^N.
"""

import functools
import math

import numpy as np
import pytest

from extension import samples
from grader.judging.hidden_tests import generator_for_students, hidden
from utils.checks.assertions import CheckFailed, needs
from utils.checks.lesson_03.fit_plane import (
    assert_direction,
    assert_through_the_mean,
    require_direction,
)
from utils.checks.lesson_03.iterations_needed import (
    assert_iterations,
    assert_nearly,
    iterations_by_counting,
    require_plain_cases,
)
from utils.checks.lesson_03.plane_through import (
    as_plane_of_triangle,
    assert_contains_points,
    assert_no_plane,
    assert_perpendicular,
    require_perpendicular_normals,
    require_planes,
)
from utils.checks.lesson_03.planes import assert_unit_normal, scattered_plane
from utils.checks.lesson_03.point_plane_distance import (
    assert_distances,
    assert_ignores_intensity,
    require_plain_distances,
)
from utils.checks.lesson_03.ransac_plane import (
    assert_no_round_is_missing,
    assert_rows_differ,
    assert_three_are_enough,
    ramp_with_collinear_points,
    require_plane_among_outliers,
    require_plane_without_outliers,
)
from utils.checks.lesson_03.results import (
    as_mask,
    as_model,
    assert_finds,
    assert_inliers_within_tolerance,
    assert_nearest_are_inliers,
    assert_nothing_found,
)
from utils.geometry import gaps_from


def random_plane(rng):
    """Return a random unit normal and an offset, shape (4,)."""
    normal = rng.normal(size=3)
    return np.append(normal / np.linalg.norm(normal), rng.uniform(-5, 5))


def random_triangle(rng, size=5.0):
    """Return three points that are far from collinear, shape (3, 3)."""
    while True:
        triangle = rng.uniform(-size, size, (3, 3))
        sides = triangle[1:] - triangle[0]
        if np.linalg.norm(np.cross(*sides)) > size**2 / 4:
            return triangle


@hidden(
    "plane_through",
    weight=3,
    title="Upright on triangles you have not seen",
    hint="The cross product of two sides is perpendicular to the triangle.",
)
def test_random_triangles(student, seed):
    rng = np.random.default_rng(seed)
    for _ in range(8):
        triangle = random_triangle(rng)
        assert_perpendicular(student.plane_through(*triangle.copy()), triangle)


@hidden(
    "plane_through",
    weight=14,
    title="Triangles you have not seen lie on their planes, near and far",
    hint="d makes the plane pass through p; it is computed from the a, b, c that are returned.",
)
def test_offsets(student, seed):
    rng = np.random.default_rng(seed + 1)
    require_perpendicular_normals(student.plane_through)
    for reach in (1, 10, 60):
        triangle = random_triangle(rng) + rng.uniform(-reach, reach, 3)
        for way_round in (triangle, triangle[::-1]):  # with the normal on either side
            assert_contains_points(student.plane_through(*way_round.copy()), triangle)


@hidden(
    "plane_through",
    weight=5,
    title="The normal has length 1, however large the triangle",
    hint="Divide the cross product by its length.",
)
def test_lengths(student, seed):
    rng = np.random.default_rng(seed + 2)
    require_perpendicular_normals(student.plane_through)
    for size in (0.5, 3, 30):
        triangle = random_triangle(rng, size)
        assert_unit_normal(as_plane_of_triangle(student.plane_through(*triangle.copy()), triangle))


@hidden(
    "plane_through",
    weight=1,
    title="The order of the points does not matter, nor does single precision",
    hint="Only the sign of the four numbers may change with the order.",
)
def test_order(student, seed):
    triangle = random_triangle(np.random.default_rng(seed + 3))
    require_perpendicular_normals(student.plane_through)
    for order in ((0, 1, 2), (1, 0, 2), (2, 0, 1), (2, 1, 0)):
        turned = triangle[list(order)]
        for points in (turned, turned.astype(np.float32)):
            assert_perpendicular(student.plane_through(*points.copy()), turned)


@hidden(
    "plane_through",
    weight=4,
    title="None for points of one line, however they lie on it",
    hint="The cross product is zero, or as good as zero: compare its length with 1e-9.",
)
def test_lines(student, seed):
    rng = np.random.default_rng(seed + 4)
    require_planes(student.plane_through)
    for _ in range(4):
        start, step = rng.integers(-9, 9, 3), rng.integers(1, 9, 3)
        line = (start + rng.permutation([0, 2, 5])[:, None] * step).astype(float)
        assert_no_plane(student.plane_through(*line.copy()), line)


def in_front(points, plane):
    """Return the points in front of both the plane and its parallel through the sensor."""
    height = points[:, :3].astype(float) @ plane[:3]
    return points[(height > 0.01) & (height + plane[3] > 0.01)]


@hidden(
    "point_plane_distance",
    weight=3,
    title="Right for the course's own scan, from planes through the sensor",
    hint="a x + b y + c z, each coordinate times its own part of the normal.",
)
def test_distances_in_the_course_cloud(student, seed):
    rng = np.random.default_rng(seed)
    cloud = samples.patch_of_course_cloud(seed, 2000)
    for _ in range(2):
        plane = random_plane(rng) * [1, 1, 1, 0]
        points = in_front(cloud, plane)[:, :3]
        assert_distances(student.point_plane_distance(points.copy(), plane.copy()), points, plane)


@hidden(
    "point_plane_distance",
    weight=2,
    title="Right for planes anywhere",
    hint="d is added to a x + b y + c z.",
)
def test_offset_planes(student, seed):
    rng = np.random.default_rng(seed)
    require_plain_distances(student.point_plane_distance)
    for sign in (1, -1, 1):
        plane = random_plane(rng)
        plane[3] = sign * abs(plane[3])
        points = in_front(rng.uniform(-20, 20, (80, 3)), plane)
        assert_distances(student.point_plane_distance(points.copy(), plane.copy()), points, plane)


@hidden(
    "point_plane_distance",
    weight=2,
    title="No distance has a sign",
    hint="np.abs of the whole sum. A plane and its negative are the same plane.",
)
def test_both_sides(student, seed):
    rng = np.random.default_rng(seed)
    require_plain_distances(student.point_plane_distance)
    xyz, plane = rng.uniform(-8, 8, (60, 3)), random_plane(rng) * [1, 1, 1, 0]
    for sign in (1, -1):
        assert_distances(student.point_plane_distance(xyz.copy(), sign * plane), xyz, plane)


@hidden(
    "point_plane_distance",
    weight=15,
    title="Right on both sides of planes anywhere, in the course's own scan",
    hint="First the whole sum, d included; then its absolute value.",
)
def test_both_sides_anywhere(student, seed):
    rng = np.random.default_rng(seed)
    with needs("d counts, and no distance has a sign"):
        test_offset_planes(student, seed)
        test_both_sides(student, seed)
    cloud = samples.patch_of_course_cloud(seed, 500)[:, :3]
    for _ in range(2):
        plane = random_plane(rng)
        plane[3] = -np.median(cloud @ plane[:3])  # half of the points on either side
        assert_distances(student.point_plane_distance(cloud.copy(), plane.copy()), cloud, plane)


@hidden(
    "point_plane_distance",
    weight=5,
    title="Clouds of four columns have the distances of their first three",
    hint="points[:, :3] for the product with the normal.",
)
def test_four_columns(student, seed):
    require_plain_distances(student.point_plane_distance)
    cloud = samples.patch_of_course_cloud(seed, 50)
    plane = random_plane(np.random.default_rng(seed)) + [0, 0, 0, 6]
    for intensity in (1, 255):
        bright = cloud * [1, 1, 1, intensity]
        assert_ignores_intensity(student.point_plane_distance, bright, plane)


@hidden(
    "point_plane_distance",
    weight=1,
    title="Right for single precision, another memory order and one point",
    hint="One number per row, whatever the array is made of.",
)
def test_forms_of_points(student, seed):
    require_plain_distances(student.point_plane_distance)
    plane = np.array([0.0, 0.6, 0.8, 0.0])
    points = in_front(samples.patch_of_course_cloud(seed, 50), plane)[:, :3]
    for form in (points.astype(np.float32), np.asfortranarray(points), points[:1], points[:3]):
        assert_distances(student.point_plane_distance(form.copy(), plane.copy()), form, plane)


def tilted(cloud, rng):
    """Return the cloud as seen by a scanner that is mounted at an angle and at any height."""
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
    """Return points of a street, the inlier count of its best plane, and sufficient iterations.

    The oracle tries 1 500 samples at once. The chance of a single sample is the share of samples
    with at least 85 % of the best one's inliers, reduced by a tenth as a margin.
    """
    cloud = samples.course_cloud() if name == "course" else samples.fresh_street(street)
    near, low = (np.abs(cloud[:, :2]) < (12, 8)).all(axis=1), cloud[:, 2] < -0.9
    rng = np.random.default_rng((street, run))
    # A quarter of the points are obstacles, so fixed rows of the cloud are rarely all on the road.
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
    return points, int(counts.max()), min(900, math.ceil(23 / chance))


def assert_marks(answer, points, tolerance):
    """Check that the mask contains most of the points near the model, and few others."""
    near, mask = gaps_from(points, as_model(answer)) <= tolerance, as_mask(answer, len(points))
    if np.sum(near & mask) < 0.8 * max(np.sum(near), np.sum(mask)):
        raise CheckFailed(
            "The plane is found, and the mask marks other points than those near it.",
            hint="The mask of a plane is point_plane_distance(points, plane) <= "
            "distance_tolerance: keep it together with its plane.",
        )


@hidden(
    "ransac_plane",
    weight=4,
    title="Finds the road in {}",
    hint="Draw your plane from the side, as in the notebook: does it lie in the road?",
)
@pytest.mark.parametrize(
    "name", ["course", "fresh"], ids=["the course's own scan", "a street you have not seen"]
)
def test_streets(student, seed, name):
    for run in range(3):
        points, most, iterations = street_and_its_best(name, seed, run, 0.2)
        answer = student.ransac_plane(points.copy(), iterations, 0.2, np.random.default_rng(run))
        found = np.count_nonzero(gaps_from(points, as_model(answer)) <= 0.2)
        if found < 0.82 * most:
            raise CheckFailed(
                "A plane with many more points near it exists.",
                yours=f"{found} points",
                expected=f"about {most} points",
            )
        assert_marks(answer, points, 0.2)


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
        # One sample in five consists of inliers and is well placed: 0.81^120 < 1e-10.
        answer = student.ransac_plane(points.copy(), 120, 0.2, np.random.default_rng(run))
        assert_finds(answer, points, 0.2, belongs)
        assert_marks(answer, points, 0.2)


@hidden(
    "ransac_plane",
    weight=3,
    title="Finds the plane among twice as many outliers",
    hint="Every round needs three new rows, and the best of all rounds counts, not the last.",
)
def test_many_outliers(student, seed):
    for run in range(2):
        points, belongs = scattered_plane(seed + 10 + run, 25, 50)
        # One sample in 36 consists of inliers and is well placed: 0.972^850 < 1e-10.
        answer = student.ransac_plane(points.copy(), 850, 0.2, np.random.default_rng(run))
        assert_finds(answer, points, 0.2, belongs, share=0.85)
        assert_marks(answer, points, 0.2)


@hidden(
    "ransac_plane",
    weight=8,
    title="The mask belongs to the model, run after run",
    hint="Keep the plane and its mask together. Whoever fits a new plane in the end needs a new "
    "mask, too.",
)
def test_masks(student, seed):
    require_plane_among_outliers(student.ransac_plane)
    for run in range(6):
        points, _ = scattered_plane(seed + 20 + run, 50, 20, noise=0.1)
        answer = student.ransac_plane(points.copy(), 12 + run, 0.2, np.random.default_rng(run))
        assert_nearest_are_inliers(answer, points)


@hidden(
    "ransac_plane",
    weight=4,
    title="Follows tolerances you have not seen",
    hint="Compare the distances with distance_tolerance.",
)
def test_tolerances(student, seed):
    rng = np.random.default_rng(seed)
    require_plane_among_outliers(student.ransac_plane)
    for run in range(3):
        points, _ = scattered_plane(seed + 30 + run, 90, 0, noise=0.3)
        tolerance = rng.uniform(0.05, 0.12) + 0.2 * run
        answer = student.ransac_plane(points.copy(), 40, tolerance, np.random.default_rng(run))
        with needs("the mask belongs to the model"):
            assert_nearest_are_inliers(answer, points)
        assert_inliers_within_tolerance(answer, points, tolerance)


@hidden(
    "ransac_plane",
    weight=2,
    title="Takes three different rows of four",
    hint="rng.choice(n, 3, replace=False): with replacement a row comes up twice.",
)
def test_three_points(student, seed):
    rng = np.random.default_rng(seed)
    require_plane_among_outliers(student.ransac_plane)
    # Four corners, alternately raised and lowered; none of their planes is steep enough to reject.
    corners = np.array([[9.0, 0, 0.4], [0, 9, -0.4], [-9, 0, 0.4], [0, -9, -0.4]])
    corners[:, :2] += rng.uniform(-2, 2, (4, 2))
    assert_rows_differ(student.ransac_plane, corners + [*rng.uniform(-20, 20, 2), -1.7])


@hidden(
    "ransac_plane",
    weight=1,
    title="No round is missing: one iteration is one sample",
    hint="max_iterations is the number of samples: for _ in range(max_iterations).",
)
def test_rounds(student, seed):
    require_plane_among_outliers(student.ransac_plane)
    assert_no_round_is_missing(student.ransac_plane)


@hidden(
    "ransac_plane",
    weight=2,
    title="Right for single precision, other memory orders, duplicates and four columns",
    hint="Use points[:, :3] and the rows as they come.",
)
def test_forms(student, seed):
    rng = generator_for_students(seed, "test_forms")
    forms = (lambda points: points.astype(np.float32), np.asfortranarray, lambda p: p[:, :3])
    for run, form in enumerate(forms):
        points, belongs = scattered_plane(seed + 40 + run, 40, 20, columns=4)
        variant = form(points)
        # More than one sample in five consists of inliers: 0.77^90 < 1e-10.
        assert_finds(student.ransac_plane(variant.copy(), 90, 0.2, rng), variant, 0.2, belongs)
    twice, belongs = np.repeat(points, 2, axis=0), np.repeat(belongs, 2)
    assert_finds(student.ransac_plane(twice.copy(), 90, 0.2, rng), twice, 0.2, belongs)


@hidden(
    "ransac_plane",
    weight=2,
    title="Goes on when most samples lie on one line",
    hint="A sample without a plane is skipped, and it counts as a round.",
)
def test_degenerate(student, seed):
    for run in range(6):
        points, belongs = ramp_with_collinear_points(np.random.default_rng(seed + run))
        # Four samples in ten give a plane, which is always the right one: 0.6^60 < 1e-13.
        answer = student.ransac_plane(points.copy(), 60, 0.1, np.random.default_rng(run))
        assert_finds(answer, points, 0.1, belongs)


@hidden(
    "ransac_plane",
    weight=1,
    title="Fewer than three points have no plane, and three have one",
    hint="Ask for len(points) < 3 before the loop.",
)
def test_few_points(student, seed):
    require_plane_without_outliers(student.ransac_plane)
    cloud = samples.patch_of_course_cloud(seed, 2)
    for n in (0, 1, 2):
        assert_nothing_found(student.ransac_plane(cloud[:n].copy(), 50, 0.2, 20 + n), n)
    assert_three_are_enough(student.ransac_plane, random_triangle(np.random.default_rng(seed)))


@hidden(
    "fit_plane",
    weight=5,
    title="Right for planes in any direction, with noise",
    hint="Centre the points, take the SVD, and the direction with the smallest spread.",
)
def test_fit_any_direction(student, seed):
    rng = np.random.default_rng(seed)
    for run in range(4):
        points, _ = scattered_plane(seed + run, 50, 0, random_plane(rng), noise=0.1)
        assert_direction(student.fit_plane(points.copy()), points)
    angle = rng.uniform(0, 2 * np.pi)
    wall, _ = scattered_plane(seed + 4, 50, 0, (np.cos(angle), np.sin(angle), 0, 3), noise=0.1)
    assert_direction(student.fit_plane(wall.copy()), wall)
    # Small pieces of a few centimetres also have small sums of squares.
    for run in range(8):
        points, _ = scattered_plane(seed + 5 + run, 12, 0, random_plane(rng), noise=0.1)
        piece = [6.0, 2.0, -1.4] + 0.02 * (points - points.mean(axis=0))
        assert_direction(student.fit_plane(piece.copy()), piece)


@hidden(
    "fit_plane",
    weight=13,
    title="The mean lies on the plane, wherever the points are",
    hint="d is minus the product of the normal and the mean.",
)
def test_fit_offset(student, seed):
    rng = np.random.default_rng(seed)
    require_direction(student.fit_plane)
    for run in range(3):
        points, _ = scattered_plane(seed + 10 + run, 50, 0, noise=0.05)
        points += rng.uniform(-8, 8, 3)
        for some in (points, points - 2 * points.mean(axis=0)):  # the origin is on either side
            assert_through_the_mean(student.fit_plane(some.copy()), some)


@hidden(
    "fit_plane",
    weight=5,
    title="Right for pieces of the course's own scan",
    hint="Any cloud has a best plane, flat or not.",
)
def test_fit_course_cloud(student, seed):
    cloud = samples.course_cloud()
    near = (np.abs(cloud[:, 0] - 6) < 6) & (np.abs(cloud[:, 1]) < 5) & (cloud[:, 2] < -1.3)
    rows = np.random.default_rng(seed).choice(np.flatnonzero(near), 800, replace=False)
    assert_direction(student.fit_plane(cloud[rows].copy()), cloud[rows])


@hidden(
    "fit_plane",
    weight=1,
    title="Right for three points, single precision and duplicates",
    hint="Three points have a best plane, too: the one through them.",
)
def test_fit_small(student, seed):
    rng = np.random.default_rng(seed)
    require_direction(student.fit_plane)
    for size in (0.8, 2.0, 5.0):
        triangle = random_triangle(rng, size)
        assert_direction(student.fit_plane(triangle.copy()), triangle)
    points, _ = scattered_plane(seed + 30, 40, 0, noise=0.05)
    for variant in (
        points.astype(np.float32),
        np.asfortranarray(points),
        np.repeat(points, 3, axis=0),
    ):
        assert_direction(student.fit_plane(variant.copy()), variant)


def questions(seed, *sizes, count=12):
    """Yield arguments of `iterations_needed` with the right answers, from exact arithmetic."""
    rng = np.random.default_rng(seed)
    while count:
        ratio, confidence = rng.choice(np.arange(30, 96)) / 100, rng.choice([0.9, 0.99, 0.995])
        case = float(ratio), int(rng.choice(sizes)), float(confidence)
        expected = iterations_by_counting(*case)
        if expected is not None:
            yield case, expected
            count -= 1


@hidden(
    "iterations_needed",
    weight=3,
    title="Right for planes, give or take one, with numbers you have not seen",
    hint="log(1 - confidence) / log(1 - w^s).",
)
def test_iterations(student, seed):
    for case, expected in questions(seed, 3):
        assert_nearly(student.iterations_needed(*case), expected, *case)


@hidden(
    "iterations_needed",
    weight=2,
    title="Right for samples of other sizes",
    hint="w is taken to the power of sample_size.",
)
def test_sizes(student, seed):
    require_plain_cases(student.iterations_needed)
    for case, expected in questions(seed + 1, 1, 2, 4, 5):
        assert_nearly(student.iterations_needed(*case), expected, *case)


@hidden(
    "iterations_needed",
    weight=2,
    title="Rounded up to the smallest whole number",
    hint="math.ceil, and no number of samples more or less.",
)
def test_rounding(student, seed):
    require_plain_cases(student.iterations_needed)
    for case, expected in questions(seed + 2, 3):
        assert_iterations(student.iterations_needed(*case), expected, *case)
