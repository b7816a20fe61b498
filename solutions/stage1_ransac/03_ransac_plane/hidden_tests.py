"""Hidden tests of lesson 03. Students see the titles and hints but not the code.

The tests of RANSAC judge its result, after so many iterations that a right answer fails less than
once in a billion runs. If one sample succeeds with probability p, N iterations fail with
probability (1 - p)^N.
"""

import functools
import math

import numpy as np
import pytest

from extension import samples
from grader.judging.hidden_tests import generator_for_students, hidden
from utils.checks.assertions import CheckFailed, precondition
from utils.checks.lesson_03.fit_plane import (
    assert_direction,
    assert_through_the_mean,
    require_direction,
)
from utils.checks.lesson_03.iterations_needed import (
    assert_iterations,
    assert_nearly_right,
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
    assert_three_points_are_enough,
    ramp_with_collinear_points,
    require_plane_among_outliers,
    require_plane_without_outliers,
)
from utils.checks.lesson_03.results import (
    as_mask,
    as_model,
    assert_finds_plane,
    assert_inliers_within_tolerance,
    assert_nearest_are_inliers,
    assert_nothing_found,
)
from utils.geometry import distances_from_plane


def random_plane(rng):
    """Return a plane with a random unit normal and a random offset, shape (4,)."""
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
    title="Returns a normal that is perpendicular to triangles you have not seen",
    hint="Compute np.cross(q - p, r - p), which is perpendicular to the triangle.",
)
def test_normal_is_perpendicular_to_random_triangles(student, seed):
    rng = np.random.default_rng(seed)
    for _ in range(8):
        triangle = random_triangle(rng)
        assert_perpendicular(student.plane_through(*triangle.copy()), triangle)


@hidden(
    "plane_through",
    weight=14,
    title="Returns a plane through all three points, near and far",
    hint="Choose d so that the plane passes through p. Compute it from the a, b and c that you "
    "return.",
)
def test_plane_contains_its_points(student, seed):
    rng = np.random.default_rng(seed + 1)
    require_perpendicular_normals(student.plane_through)
    for reach in (1, 10, 60):
        triangle = random_triangle(rng) + rng.uniform(-reach, reach, 3)
        for points in (triangle, triangle[::-1]):  # the second order reverses the normal
            assert_contains_points(student.plane_through(*points.copy()), triangle)


@hidden(
    "plane_through",
    weight=5,
    title="Returns a normal of length 1, however large the triangle is",
    hint="Divide the cross product by its length.",
)
def test_normal_has_length_1(student, seed):
    rng = np.random.default_rng(seed + 2)
    require_perpendicular_normals(student.plane_through)
    for size in (0.5, 3, 30):
        triangle = random_triangle(rng, size)
        assert_unit_normal(as_plane_of_triangle(student.plane_through(*triangle.copy()), triangle))


@hidden(
    "plane_through",
    weight=1,
    title="Works for points in any order and on float32 arrays",
    hint="Treat p, q and r alike: only the sign of the four numbers may depend on their order.",
)
def test_order_of_points_does_not_matter(student, seed):
    triangle = random_triangle(np.random.default_rng(seed + 3))
    require_perpendicular_normals(student.plane_through)
    for order in ((0, 1, 2), (1, 0, 2), (2, 0, 1), (2, 1, 0)):
        turned = triangle[list(order)]
        for points in (turned, turned.astype(np.float32)):
            assert_perpendicular(student.plane_through(*points.copy()), turned)


@hidden(
    "plane_through",
    weight=4,
    title="Returns None for points on one line, in any order",
    hint="Return None if the length of the cross product is below 1e-9.",
)
def test_points_on_a_line_give_none(student, seed):
    rng = np.random.default_rng(seed + 4)
    require_planes(student.plane_through)
    for _ in range(4):
        start, step = rng.integers(-9, 9, 3), rng.integers(1, 9, 3)
        line = (start + rng.permutation([0, 2, 5])[:, None] * step).astype(float)
        assert_no_plane(student.plane_through(*line.copy()), line)


def points_in_front(points, plane):
    """Return the points in front of a plane and of the parallel plane through the sensor."""
    height = points[:, :3].astype(float) @ plane[:3]
    return points[(height > 0.01) & (height + plane[3] > 0.01)]


@hidden(
    "point_plane_distance",
    weight=3,
    title="Measures distances in the course's scan from planes through the sensor",
    hint="Compute a x + b y + c z: multiply x by a, y by b and z by c.",
)
def test_measures_the_course_cloud(student, seed):
    rng = np.random.default_rng(seed)
    cloud = samples.patch_of_course_cloud(seed, 2000)
    for _ in range(2):
        plane = random_plane(rng) * [1, 1, 1, 0]
        points = points_in_front(cloud, plane)[:, :3]
        assert_distances(student.point_plane_distance(points.copy(), plane.copy()), points, plane)


@hidden(
    "point_plane_distance",
    weight=2,
    title="Measures distances from planes that do not pass through the sensor",
    hint="Add d, the last number of the plane, to a x + b y + c z.",
)
def test_adds_d(student, seed):
    rng = np.random.default_rng(seed)
    require_plain_distances(student.point_plane_distance)
    for sign in (1, -1, 1):
        plane = random_plane(rng)
        plane[3] = sign * abs(plane[3])
        points = points_in_front(rng.uniform(-20, 20, (80, 3)), plane)
        assert_distances(student.point_plane_distance(points.copy(), plane.copy()), points, plane)


@hidden(
    "point_plane_distance",
    weight=2,
    title="Returns no negative distances",
    hint="Take np.abs of the whole sum: (a, b, c, d) and its negative are the same plane.",
)
def test_measures_on_both_sides(student, seed):
    rng = np.random.default_rng(seed)
    require_plain_distances(student.point_plane_distance)
    xyz, plane = rng.uniform(-8, 8, (60, 3)), random_plane(rng) * [1, 1, 1, 0]
    for sign in (1, -1):
        assert_distances(student.point_plane_distance(xyz.copy(), sign * plane), xyz, plane)


@hidden(
    "point_plane_distance",
    weight=15,
    title="Measures distances in the course's scan on both sides of any plane",
    hint="Compute the whole sum including d, then take np.abs of it.",
)
def test_measures_on_both_sides_of_any_plane(student, seed):
    rng = np.random.default_rng(seed)
    with precondition("d is added and no distance is negative"):
        test_adds_d(student, seed)
        test_measures_on_both_sides(student, seed)
    cloud = samples.patch_of_course_cloud(seed, 500)[:, :3]
    for _ in range(2):
        plane = random_plane(rng)
        plane[3] = -np.median(cloud @ plane[:3])  # half of the points are on each side of the plane
        assert_distances(student.point_plane_distance(cloud.copy(), plane.copy()), cloud, plane)


@hidden(
    "point_plane_distance",
    weight=5,
    title="Returns the same distances with and without intensity",
    hint="Use points[:, :3] for the product with the normal.",
)
def test_ignores_intensity(student, seed):
    require_plain_distances(student.point_plane_distance)
    cloud = samples.patch_of_course_cloud(seed, 50)
    plane = random_plane(np.random.default_rng(seed)) + [0, 0, 0, 6]
    for intensity in (1, 255):
        bright = cloud * [1, 1, 1, intensity]
        assert_ignores_intensity(student.point_plane_distance, bright, plane)


@hidden(
    "point_plane_distance",
    weight=1,
    title="Works on float32 arrays and on a single point",
    hint="Compute points[:, :3] @ normal, which works for any type of number.",
)
def test_measures_any_array(student, seed):
    require_plain_distances(student.point_plane_distance)
    plane = np.array([0.0, 0.6, 0.8, 0.0])
    points = points_in_front(samples.patch_of_course_cloud(seed, 50), plane)[:, :3]
    for form in (points.astype(np.float32), points[:1], points[:3]):
        assert_distances(student.point_plane_distance(form.copy(), plane.copy()), form, plane)


def tilt(cloud, rng):
    """Return the cloud as seen by a scanner mounted at a random angle and height."""
    lean, heading = rng.uniform(0.2, 0.7), rng.uniform(0, 2 * np.pi)
    axis = np.array([np.cos(heading), np.sin(heading), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    basis = np.column_stack([axis, np.cross(axis, up), up])
    cosine, sine = np.cos(lean), np.sin(lean)
    turn = basis @ np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]]) @ basis.T
    return np.column_stack([cloud[:, :3] @ turn.T + [0.0, 0.0, rng.uniform(-3, 3)], cloud[:, 3:]])


@functools.lru_cache(maxsize=256)
def street_with_best_plane(name, seed, run, tolerance):
    """Return points of a street, the inlier count of the best plane, and enough iterations.

    The best plane is the best of 1500 samples. A sample succeeds if it has at least 85 % of that
    plane's inliers. The share of such samples, less a tenth as a margin, gives the iterations.
    """
    cloud = samples.course_cloud() if name == "course" else samples.fresh_street(seed)
    near, low = (np.abs(cloud[:, :2]) < (12, 8)).all(axis=1), cloud[:, 2] < -0.9
    rng = np.random.default_rng((seed, run))
    # A quarter of the points are obstacles, so an answer that always draws the same three rows
    # rarely finds the road.
    rows = [rng.choice(np.flatnonzero(near & low), 370, replace=False)]
    rows += [rng.choice(np.flatnonzero(near & ~low), 130, replace=False)]
    # In the last run, the obstacles come first, in case an answer draws only from the first rows.
    order = np.concatenate(rows[::-1]) if run == 2 else rng.permutation(np.concatenate(rows))
    points = tilt(cloud[order], rng)
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
    """Check that the mask marks most of the points near the plane, and few others."""
    near, mask = (
        distances_from_plane(points, as_model(answer)) <= tolerance,
        as_mask(answer, len(points)),
    )
    if np.sum(near & mask) < 0.8 * max(np.sum(near), np.sum(mask)):
        raise CheckFailed(
            "The plane is found, but the mask does not mark the points near it.",
            hint="The mask of a plane is point_plane_distance(points, plane) <= "
            "distance_tolerance: keep the plane and its mask together.",
        )


@hidden(
    "ransac_plane",
    weight=4,
    title="Finds the road in {}",
    hint="Draw your plane from the side, as in the notebook: it must follow the road.",
)
@pytest.mark.parametrize(
    "name", ["course", "fresh"], ids=["the course's scan", "a street you have not seen"]
)
def test_finds_the_road(student, seed, name):
    for run in range(3):
        points, most, iterations = street_with_best_plane(name, seed, run, 0.2)
        answer = student.ransac_plane(points.copy(), iterations, 0.2, np.random.default_rng(run))
        found = np.count_nonzero(distances_from_plane(points, as_model(answer)) <= 0.2)
        if found < 0.82 * most:
            raise CheckFailed(
                "There is a plane with many more points near it.",
                yours=f"{found} points",
                expected=f"about {most} points",
            )
        assert_marks(answer, points, 0.2)


@hidden(
    "ransac_plane",
    weight=4,
    title="Finds planes in any direction",
    hint="Treat walls, ramps and roads alike, and keep the plane with the most inliers of all "
    "rounds.",
)
def test_finds_planes_in_any_direction(student, seed):
    rng = np.random.default_rng(seed)
    for run in range(6):
        points, on_plane = scattered_plane(seed + run, 40, 25, random_plane(rng))
        # At least 19 samples in 100 have three well-placed inliers: 0.81^120 < 1e-10.
        answer = student.ransac_plane(points.copy(), 120, 0.2, np.random.default_rng(run))
        assert_finds_plane(answer, points, 0.2, on_plane)
        assert_marks(answer, points, 0.2)


@hidden(
    "ransac_plane",
    weight=3,
    title="Finds the plane when outliers outnumber inliers two to one",
    hint="Draw three new rows in every round, and return the best of all rounds, not the last.",
)
def test_finds_planes_among_many_outliers(student, seed):
    for run in range(2):
        points, on_plane = scattered_plane(seed + 10 + run, 25, 50)
        # At least one sample in 36 has three well-placed inliers: 0.972^850 < 1e-10.
        answer = student.ransac_plane(points.copy(), 850, 0.2, np.random.default_rng(run))
        assert_finds_plane(answer, points, 0.2, on_plane, share=0.85)
        assert_marks(answer, points, 0.2)


@hidden(
    "ransac_plane",
    weight=8,
    title="Returns the mask that belongs to the model in every run",
    hint="Keep the plane and its mask together. If you refit the plane at the end, compute a "
    "new mask.",
)
def test_mask_belongs_to_model(student, seed):
    require_plane_among_outliers(student.ransac_plane)
    for run in range(6):
        points, _ = scattered_plane(seed + 20 + run, 50, 20, noise=0.1)
        answer = student.ransac_plane(points.copy(), 12 + run, 0.2, np.random.default_rng(run))
        assert_nearest_are_inliers(answer, points)


@hidden(
    "ransac_plane",
    weight=4,
    title="Works for tolerances you have not seen",
    hint="Compare the distances with distance_tolerance.",
)
def test_uses_the_tolerance(student, seed):
    rng = np.random.default_rng(seed)
    require_plane_among_outliers(student.ransac_plane)
    for run in range(3):
        points, _ = scattered_plane(seed + 30 + run, 90, 0, noise=0.3)
        tolerance = rng.uniform(0.05, 0.12) + 0.2 * run
        answer = student.ransac_plane(points.copy(), 40, tolerance, np.random.default_rng(run))
        with precondition("the mask belongs to the model"):
            assert_nearest_are_inliers(answer, points)
        assert_inliers_within_tolerance(answer, points, tolerance)


@hidden(
    "ransac_plane",
    weight=2,
    title="Draws three different rows out of four",
    hint="Use rng.choice(n, 3, replace=False): with replacement, a row may be drawn twice.",
)
def test_draws_three_different_rows(student, seed):
    rng = np.random.default_rng(seed)
    require_plane_among_outliers(student.ransac_plane)
    # Four corners, alternately high and low. An answer may reject steep planes, so the heights
    # differ so little that every plane through three corners is nearly level.
    corners = np.array([[9.0, 0, 0.4], [0, 9, -0.4], [-9, 0, 0.4], [0, -9, -0.4]])
    corners[:, :2] += rng.uniform(-2, 2, (4, 2))
    assert_rows_differ(student.ransac_plane, corners + [*rng.uniform(-20, 20, 2), -1.7])


@hidden(
    "ransac_plane",
    weight=1,
    title="Finds a plane even if max_iterations is 1",
    hint="Draw one sample in each round of `for _ in range(max_iterations)`.",
)
def test_no_round_is_missing(student, seed):
    require_plane_among_outliers(student.ransac_plane)
    assert_no_round_is_missing(student.ransac_plane)


@hidden(
    "ransac_plane",
    weight=2,
    title="Works on float32 arrays, on duplicate rows, and on three and four columns",
    hint="Use points[:, :3], and keep all rows as they are.",
)
def test_finds_planes_in_any_array(student, seed):
    rng = generator_for_students(seed, "test_finds_planes_in_any_array")
    forms = (lambda points: points.astype(np.float32), lambda p: p[:, :3])
    for run, form in enumerate(forms):
        points, on_plane = scattered_plane(seed + 40 + run, 40, 20, columns=4)
        variant = form(points)
        # At least 23 samples in 100 have three well-placed inliers: 0.77^90 < 1e-10.
        assert_finds_plane(
            student.ransac_plane(variant.copy(), 90, 0.2, rng), variant, 0.2, on_plane
        )
    duplicates, on_plane = np.repeat(points, 2, axis=0), np.repeat(on_plane, 2)
    assert_finds_plane(
        student.ransac_plane(duplicates.copy(), 90, 0.2, rng), duplicates, 0.2, on_plane
    )


@hidden(
    "ransac_plane",
    weight=2,
    title="Continues if most samples lie on one line",
    hint="Skip a sample that does not define a plane, but count it as a round.",
)
def test_continues_after_degenerate_samples(student, seed):
    for run in range(6):
        points, on_plane = ramp_with_collinear_points(np.random.default_rng(seed + run))
        # At least four samples in ten define a plane, always the right one: 0.6^60 < 1e-13.
        answer = student.ransac_plane(points.copy(), 60, 0.1, np.random.default_rng(run))
        assert_finds_plane(answer, points, 0.1, on_plane)


@hidden(
    "ransac_plane",
    weight=1,
    title="Finds a plane through three points, but none through fewer",
    hint="Test len(points) < 3 before the loop.",
)
def test_three_points_are_enough(student, seed):
    require_plane_without_outliers(student.ransac_plane)
    cloud = samples.patch_of_course_cloud(seed, 2)
    for n in (0, 1, 2):
        assert_nothing_found(student.ransac_plane(cloud[:n].copy(), 50, 0.2, 20 + n), n)
    assert_three_points_are_enough(
        student.ransac_plane, random_triangle(np.random.default_rng(seed))
    )


@hidden(
    "fit_plane",
    weight=5,
    title="Fits planes in any direction, with noise",
    hint="Centre the points, take the SVD and use the direction of least spread.",
)
def test_fits_planes_in_any_direction(student, seed):
    rng = np.random.default_rng(seed)
    for run in range(4):
        points, _ = scattered_plane(seed + run, 50, 0, random_plane(rng), noise=0.1)
        assert_direction(student.fit_plane(points.copy()), points)
    angle = rng.uniform(0, 2 * np.pi)
    wall, _ = scattered_plane(seed + 4, 50, 0, (np.cos(angle), np.sin(angle), 0, 3), noise=0.1)
    assert_direction(student.fit_plane(wall.copy()), wall)
    # In pieces of about 20 cm, the sums of squares are small too.
    for run in range(8):
        points, _ = scattered_plane(seed + 5 + run, 12, 0, random_plane(rng), noise=0.1)
        piece = [6.0, 2.0, -1.4] + 0.02 * (points - points.mean(axis=0))
        assert_direction(student.fit_plane(piece.copy()), piece)


@hidden(
    "fit_plane",
    weight=13,
    title="Returns a plane through the mean, wherever the points are",
    hint="Compute d = -(normal @ centre), where centre is the mean of the points.",
)
def test_plane_contains_the_mean(student, seed):
    rng = np.random.default_rng(seed)
    require_direction(student.fit_plane)
    for run in range(3):
        points, _ = scattered_plane(seed + 10 + run, 50, 0, noise=0.05)
        points += rng.uniform(-8, 8, 3)
        for cloud in (points, points - 2 * points.mean(axis=0)):  # on both sides of the origin
            assert_through_the_mean(student.fit_plane(cloud.copy()), cloud)


@hidden(
    "fit_plane",
    weight=5,
    title="Fits planes to pieces of the course's scan",
    hint="Return the plane of least spread for every cloud, even if the cloud is not flat.",
)
def test_fits_the_course_cloud(student, seed):
    cloud = samples.course_cloud()
    near = (np.abs(cloud[:, 0] - 6) < 6) & (np.abs(cloud[:, 1]) < 5) & (cloud[:, 2] < -1.3)
    rows = np.random.default_rng(seed).choice(np.flatnonzero(near), 800, replace=False)
    assert_direction(student.fit_plane(cloud[rows].copy()), cloud[rows])


@hidden(
    "fit_plane",
    weight=1,
    title="Works on three points, on float32 arrays and on duplicate rows",
    hint="Use the same code for three points: their best plane passes through them.",
)
def test_fits_three_points_and_any_array(student, seed):
    rng = np.random.default_rng(seed)
    require_direction(student.fit_plane)
    for size in (0.8, 2.0, 5.0):
        triangle = random_triangle(rng, size)
        assert_direction(student.fit_plane(triangle.copy()), triangle)
    points, _ = scattered_plane(seed + 30, 40, 0, noise=0.05)
    for variant in (
        points.astype(np.float32),
        np.repeat(points, 3, axis=0),
    ):
        assert_direction(student.fit_plane(variant.copy()), variant)


def iteration_cases(seed, *sizes, count=12):
    """Yield arguments of `iterations_needed`, each with the exact answer."""
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
    title="Finds the number of samples to within one, for values you have not seen",
    hint="Divide math.log(1 - confidence) by math.log(1 - inlier_ratio ** sample_size).",
)
def test_finds_the_number_for_planes(student, seed):
    for case, expected in iteration_cases(seed, 3):
        assert_nearly_right(student.iterations_needed(*case), expected, *case)


@hidden(
    "iterations_needed",
    weight=2,
    title="Works for samples of other sizes",
    hint="Write inlier_ratio ** sample_size.",
)
def test_uses_the_sample_size(student, seed):
    require_plain_cases(student.iterations_needed)
    for case, expected in iteration_cases(seed + 1, 1, 2, 4, 5):
        assert_nearly_right(student.iterations_needed(*case), expected, *case)


@hidden(
    "iterations_needed",
    weight=2,
    title="Rounds up to the next whole number",
    hint="Use math.ceil, and do not add or subtract a sample.",
)
def test_rounds_up(student, seed):
    require_plain_cases(student.iterations_needed)
    for case, expected in iteration_cases(seed + 2, 3):
        assert_iterations(student.iterations_needed(*case), expected, *case)
