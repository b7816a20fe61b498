"""Hidden tests of lesson 02. Students see the titles and hints but not the code.

RANSAC is random, so its tests count successes over many seeds. The margins are so wide that a right
answer fails less than once in a billion runs.
"""

import functools
import itertools
import math

import numpy as np

from extension import samples
from grader.judging.hidden_tests import hidden
from utils.checks.assertions import CheckFailed, call_each
from utils.checks.failures import fixed
from utils.checks.lesson_02.line_through import (
    assert_no_line,
    assert_on_line,
    assert_unit_normal,
    require_slanted_lines,
)
from utils.checks.lesson_02.lines import distances_from
from utils.checks.lesson_02.point_line_distance import assert_line_distances
from utils.checks.lesson_02.point_line_distance import require_plain_distances as assert_plain_case
from utils.checks.lesson_02.ransac_line import (
    assert_no_round_is_missing,
    assert_two_points_are_enough,
    lines_from_two_rounds,
    require_line_among_outliers,
)
from utils.checks.lesson_02.results import (
    as_line_and_mask,
    assert_mask_matches_line,
    assert_nothing_found,
)
from utils.checks.lesson_02.runs import follows_wall, wall_and_clutter


def random_pairs(seed, n, reach=20.0):
    """Return `n` pairs of points that are at least a metre apart."""
    rng = np.random.default_rng(seed)
    p = rng.uniform(-reach, reach, (n, 2))
    angle, apart = rng.uniform(0, 2 * math.pi, n), rng.uniform(1, reach, n)
    return p, p + np.column_stack([apart * np.cos(angle), apart * np.sin(angle)])


@hidden(
    "line_through",
    weight=3,
    title="Returns a line through both points, in either order",
    hint="Insert the x and y of both points into a x + b y + c: each point must give 0.",
)
def test_line_passes_through_both_points(student, seed):
    for p, q in zip(*random_pairs(seed, 12), strict=True):
        assert_on_line(student.line_through(p.copy(), q.copy()), p, q)
        assert_on_line(student.line_through(q.copy(), p.copy()), p, q)


@hidden(
    "line_through",
    weight=2,
    title="Returns a normal of length 1, however far apart the points are",
    hint="Divide a and b by the length of the direction, then compute c.",
)
def test_normal_has_length_1(student, seed):
    require_slanted_lines(student.line_through)
    for p, q in zip(*random_pairs(seed + 6, 8), strict=True):
        assert_unit_normal(student.line_through(p.copy(), q.copy()))


@hidden(
    "line_through",
    weight=2,
    title="Returns the right line if it is parallel to an axis",
    hint="Do not use a slope. Divide only by the length, never by dx or dy.",
)
def test_finds_axis_parallel_lines(student, seed):
    require_slanted_lines(student.line_through)
    for p, q in zip(*random_pairs(seed + 1, 4), strict=True):
        for end in ([p[0], q[1] + 30], [q[0] + 30, p[1]]):
            assert_on_line(student.line_through(p.copy(), np.array(end)), p, end)


@hidden(
    "line_through",
    weight=1,
    title="Works on float32 arrays",
    hint="Use np.hypot and plain arithmetic, which work with any floating-point type.",
)
def test_finds_lines_in_single_precision(student, seed):
    require_slanted_lines(student.line_through)
    for pair in zip(*random_pairs(seed + 1, 4), strict=True):
        p, q = (point.astype(np.float32) for point in pair)
        assert_on_line(student.line_through(p.copy(), q.copy()), p, q)


@hidden(
    "line_through",
    weight=2,
    title="Returns None for equal points, wherever they are",
    hint="Return None if the length is 0.",
)
def test_equal_points_have_no_line(student, seed):
    require_slanted_lines(student.line_through)
    for point in random_pairs(seed + 2, 3)[0]:
        assert_no_line(student.line_through, point)


@hidden(
    "line_through",
    weight=1,
    title="Finds a line through points five centimetres apart",
    hint="Return None only if the length is exactly 0.",
)
def test_close_points_have_a_line(student, seed):
    require_slanted_lines(student.line_through)
    for p in random_pairs(seed + 2, 3)[0]:
        if student.line_through(p.copy(), p + [0.04, 0.03]) is None:
            raise CheckFailed("The answer is None although the points differ.")


def distances_by_hand(points, p, q):
    """Compute signed distances from the line through p and q, using areas of parallelograms."""
    base = math.dist(p, q)
    return np.array(
        [
            ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])) / base
            for x, y in points.tolist()
        ]
    )


def line_by_hand(p, q):
    """Return the line (a, b, c) through two points."""
    base = math.dist(p, q)
    a, b = (p[1] - q[1]) / base, (q[0] - p[0]) / base
    return np.array([a, b, -(a * p[0] + b * p[1])])


def assert_distances(student, points, p, q):
    """Check the answer's distances from the line through two points."""
    signed, line = distances_by_hand(points, p, q), line_by_hand(p, q)
    answer = student.point_line_distance(points.copy(), line.copy())
    assert_line_distances(answer, points, line, np.abs(signed))


def assert_distances_on_one_side(student, points, p, q):
    """Check the answer's distances on the side of the line where a x + b y + c > 0.

    If most points are on the other side, swap p and q first.
    """
    is_positive = distances_by_hand(points, p, q) > 0
    if 2 * is_positive.sum() < len(points):
        p, q, is_positive = q, p, ~is_positive
    assert_distances(student, points[is_positive], p, q)


def pairs_through_origin(seed, n):
    """Return `n` pairs of points whose lines pass through (0, 0)."""
    return [(-2 * q, q) for q in random_pairs(seed, n)[1]]


@hidden(
    "point_line_distance",
    weight=2,
    title="Measures distances from lines through (0, 0) that you have not seen",
    hint="Draw circles around your points as in the notebook: each one must touch the line.",
)
def test_measures_from_lines_through_the_origin(student, seed):
    points = np.random.default_rng(seed).uniform(-20, 20, (60, 2))
    for p, q in pairs_through_origin(seed + 3, 6):
        assert_distances_on_one_side(student, points, p, q)


@hidden(
    "point_line_distance",
    weight=3,
    title="Measures distances from lines that do not pass through (0, 0)",
    hint="Add c, with its sign, to the sum.",
)
def test_measures_from_any_line(student, seed):
    assert_plain_case(student.point_line_distance)
    points = np.random.default_rng(seed + 1).uniform(-20, 20, (60, 2))
    for p, q in zip(*random_pairs(seed + 3, 6), strict=True):
        assert_distances_on_one_side(student, points, p, q)


@hidden(
    "point_line_distance",
    weight=3,
    title="Measures distances on both sides of a line",
    hint="Take np.abs of the whole sum: a distance is never negative.",
)
def test_measures_on_both_sides(student, seed):
    assert_plain_case(student.point_line_distance)
    points = np.random.default_rng(seed + 2).uniform(-20, 20, (60, 2))
    for p, q in pairs_through_origin(seed + 4, 6):
        assert_distances(student, points, p, q)


@hidden(
    "point_line_distance",
    weight=7,
    title="Measures distances in a slice of the course's scan",
    hint="Compute with whole columns: the same code works for twenty points and for twenty "
    "thousand.",
)
def test_measures_the_course_cloud(student, seed):
    points = wall_of_course_cloud(seed, 500)
    assert_distances(student, points, (0.0, -8.0), (10.0, -8.1))
    assert_distances(student, points, (7.0, -2.0), (7.0, -9.0))


@hidden(
    "point_line_distance",
    weight=1,
    title="Works on float32 arrays, on few points and on duplicate rows",
    hint="Compute with whole columns, such as points[:, 0], for any number of points.",
)
def test_measures_few_points_in_single_precision(student, seed):
    assert_plain_case(student.point_line_distance)
    points = np.random.default_rng(seed).uniform(-20, 20, (30, 2))
    [(p, q)] = pairs_through_origin(seed + 4, 1)
    points = points[distances_by_hand(points, p, q) > 0]
    for few in (
        points.astype(np.float32),
        points[::-1],
        points[:1],
        np.repeat(points[:2], 3, axis=0),
    ):
        assert_distances(student, few, p, q)


def wall_of_course_cloud(seed, n):
    """Return `n` points of the course's scan at sensor height: a house front and clutter."""
    cloud = samples.course_cloud()
    x, y, z = cloud[:, 0], cloud[:, 1], cloud[:, 2]
    rows = np.flatnonzero((np.abs(z) < 0.3) & (x > -1) & (x < 14) & (y < -1) & (y > -12))
    return cloud[np.random.default_rng(seed).choice(rows, n, replace=False), :2]


@functools.lru_cache(maxsize=512)
def _most_inliers(data, tolerance):
    points = np.frombuffer(data).reshape(-1, 2)
    first, second = np.triu_indices(len(points), 1)
    along = points[second] - points[first]
    apart = np.hypot(along[:, 0], along[:, 1])
    along, first = along[apart > 0] / apart[apart > 0, None], first[apart > 0]
    offset = points[None] - points[first][:, None]
    across = along[:, :1] * offset[..., 1] - along[:, 1:] * offset[..., 0]
    return int((np.abs(across) <= tolerance).sum(axis=1).max())


def most_inliers(points, tolerance):
    """Try all pairs of points, and return the largest number of points near a line."""
    return _most_inliers(np.ascontiguousarray(points, dtype=float).tobytes(), tolerance)


def iterate_successes(student, clouds, max_iterations, tolerance, must_mark=False):
    """Yield, for each cloud, whether the answer finds a line with 80 % of the possible inliers.

    If `must_mark` is true, the mask must also mark at least 80 % of the points near the line, and
    few others.
    """
    for number, points in enumerate(clouds):
        rng = np.random.default_rng(1000 + number)
        answer = student.ransac_line(points.copy(), max_iterations, tolerance, rng)
        line, mask = as_line_and_mask(answer, len(points))
        near = line is not None and distances_from(line, points) <= tolerance
        is_found = np.sum(near) >= 0.8 * most_inliers(points, tolerance)
        is_marked = np.sum(mask & near) >= 0.8 * max(np.sum(near), np.sum(mask))
        yield line is not None and bool(is_found and (is_marked or not must_mark))


def has_at_least(needed, flags):
    """Return whether at least `needed` flags are true. Stop as soon as enough are."""
    return sum(itertools.islice(filter(None, flags), needed)) == needed


def assert_mostly_found(student, clouds, max_iterations, tolerance, needed):
    arguments = student, clouds, max_iterations, tolerance
    if has_at_least(needed, iterate_successes(*arguments, must_mark=True)):
        return
    if has_at_least(needed, iterate_successes(*arguments)):
        raise CheckFailed(
            "The line is found, but the mask does not mark the points near it.",
            hint="The mask of a line is point_line_distance(points, line) <= "
            "distance_tolerance: keep the line and its mask together.",
        )
    raise CheckFailed("The line is found too rarely.")


# P(miss) is the probability that one run without early stopping misses the line. It was computed
# from all pairs of points in 2000 scenes. An answer that stops early, at a confidence of 99 %,
# misses the line in at most one run in 100.


@hidden(
    "ransac_line",
    weight=5,
    title="Finds a line among as many outliers as inliers",
    hint="Keep the line with the most inliers of all rounds.",
)
def test_finds_fresh_lines(student, seed):
    clouds = [wall_and_clutter((seed, run), 25, 25)[0] for run in range(12)]
    assert_mostly_found(student, clouds, 120, 0.4, 8)  # P(miss) = 1e-8
    # The outliers come first, in case an answer draws only from the first rows.
    points, on_line = wall_and_clutter((seed, 12), 120, 120)
    points = points[np.argsort(on_line)]
    for run in range(3):
        answer = student.ransac_line(points.copy(), 120, 0.4, np.random.default_rng(run))
        if follows_wall(as_line_and_mask(answer, len(points))[0], points[120:], 0.4):
            return
    raise CheckFailed("The line is found too rarely.")


@hidden(
    "ransac_line",
    weight=10,
    title="Returns the mask that belongs to the line, even for a rough wall",
    hint="Replace line and mask together. Compare distances in metres with distance_tolerance, and "
    "do not square them.",
)
def test_mask_belongs_to_line(student, seed):
    require_line_among_outliers(student.ransac_line)
    for run, tolerance in enumerate((0.3, 0.3, 0.6, 1.8)):
        # The wall is so rough that every other line has different inliers.
        rough, _ = wall_and_clutter((seed, run, 2), 25, 10, noise=0.8)
        rng = np.random.default_rng(run)
        answer = student.ransac_line(rough.copy(), 40, tolerance, rng)
        assert_mask_matches_line(answer, rough, tolerance)
    # After only two or three samples, the best line is poor, so a wrong mask is easy to detect.
    clouds = [wall_and_clutter((seed, run, 4), 14, 26)[0] for run in range(40)]
    calls = [
        (points, 2 + run % 2, 0.4, np.random.default_rng(run)) for run, points in enumerate(clouds)
    ]
    for points, answer in zip(clouds, call_each(student.ransac_line, calls), strict=True):
        assert_mask_matches_line(answer, points, 0.4)


@hidden(
    "ransac_line",
    weight=3,
    title="Finds a line among three times as many outliers as inliers",
    hint="Loop with `for _ in range(max_iterations)`, and draw a new sample in each round.",
)
def test_finds_lines_among_many_outliers(student, seed):
    clouds = [wall_and_clutter((seed, run, 1), 12, 38)[0] for run in range(16)]
    assert_mostly_found(student, clouds, 400, 0.3, 11)  # P(miss) = 3e-8


@hidden(
    "ransac_line",
    weight=3,
    title="Finds the house front in the course's scan",
    hint="Draw the slice as at the end of the notebook: your line must follow the wall.",
)
def test_finds_the_wall_in_the_course_cloud(student, seed):
    clouds = [wall_of_course_cloud((seed, run), 90) for run in range(12)]
    assert_mostly_found(student, clouds, 60, 0.15, 9)


@hidden(
    "ransac_line",
    weight=2,
    title="Finds the line if the street is moved, rotated and scaled",
    hint="Use only distances. Do not rely on a fixed position or size.",
)
def test_finds_moved_and_scaled_lines(student, seed):
    points, _ = wall_and_clutter((seed, 2), 25, 15)
    cosine, sine = math.cos(seed % 7), math.sin(seed % 7)
    turned = points @ np.array([[cosine, sine], [-sine, cosine]]) + [300.0, -200.0]
    assert_mostly_found(student, [turned] * 6, 80, 0.4, 3)
    assert_mostly_found(student, [points * 40] * 6, 80, 16.0, 3)
    small = points[::-1] / 50  # all points are within half a metre of each other
    assert_mostly_found(student, [small] * 6, 80, 0.008, 3)


@hidden(
    "ransac_line",
    weight=1,
    title="Finds a wall straight ahead or straight to the side",
    hint="Use only distances, not a slope.",
)
def test_finds_axis_parallel_walls(student, seed):
    require_line_among_outliers(student.ransac_line)
    rng = np.random.default_rng(seed)
    for column in (0, 1):
        wall = rng.uniform(-9, 9, (30, 2))
        wall[:20, column] = 4.0
        outliers = wall[20:, column]
        outliers += np.where(outliers < 4, -1, 1)  # keeps outliers away from the wall
        assert_mostly_found(student, [wall] * 6, 80, 0.2, 3)


@hidden(
    "ransac_line",
    weight=1,
    title="Draws two different points in every round",
    hint="Draw without replacement: a point that is drawn twice does not define a line.",
)
def test_draws_two_of_three_points(student, seed):
    require_line_among_outliers(student.ransac_line)
    p, q = (points[0] for points in random_pairs(seed + 5, 1))
    third = p + 2 * np.array([p[1] - q[1], q[0] - p[0]])  # is far from the line through p and q
    three = np.array([p, q, third])
    for line in lines_from_two_rounds(student.ransac_line, three):
        if line is None:
            raise CheckFailed(
                "Any two of the three points define a line, but in some runs no line is found."
            )
        if np.sum(distances_from(line, three) <= 0.1) != 2:
            raise CheckFailed(
                "A sample consists of two points, and the line must pass through both."
            )


@hidden(
    "ransac_line",
    weight=1,
    title="Draws exactly max_iterations samples",
    hint="Draw one sample in each round of `for _ in range(max_iterations)`.",
)
def test_one_iteration_is_one_sample(student, seed):
    require_line_among_outliers(student.ransac_line)
    assert_no_round_is_missing(student.ransac_line)
    # The points differ from run to run, so an answer with a fixed seed is not lucky or unlucky.
    clouds = [wall_and_clutter((seed, 3, run), 14, 46)[0] for run in range(48)]
    misses = (not found for found in iterate_successes(student, clouds, 1, 0.3))
    if not has_at_least(25, misses):  # one sample in 25 finds the line
        raise CheckFailed(
            fixed(
                "With max_iterations=1, the line is found in most runs, but a single sample hardly "
                "ever finds it. The function draws more samples than max_iterations allows."
            )
        )


@hidden(
    "ransac_line",
    weight=2,
    title="Continues after samples of two equal points",
    hint="If line_through returns None, continue with the next sample: equal points do not define "
    "a line.",
)
def test_continues_after_equal_points(student, seed):
    require_line_among_outliers(student.ransac_line)
    rng = np.random.default_rng(seed)
    wall = wall_and_clutter((seed, 4), 12, 0)[0]
    for run in range(24):
        # Half of all samples consist of equal points. All forty practically never do.
        equal_points = np.repeat(rng.uniform(12, 20, (1, 2)), 28, axis=0)
        points = rng.permutation(np.vstack([equal_points, wall]))
        answer = student.ransac_line(points, 40, 0.3, np.random.default_rng(run))
        if as_line_and_mask(answer, len(points))[0] is None:
            raise CheckFailed("The line is None although not all points are equal.")


@hidden(
    "ransac_line",
    weight=1,
    title="Works on float32 arrays",
    hint="Compute with whole columns, such as points[:, 0], for any number of points.",
)
def test_works_in_single_precision(student, seed):
    require_line_among_outliers(student.ransac_line)
    points, _ = wall_and_clutter((seed, 5), 25, 10)
    clouds = [points.astype(np.float32), points[::2]]
    assert_mostly_found(student, clouds * 2, 80, 0.4, 3)


@hidden(
    "ransac_line",
    weight=1,
    title="Finds a line through two points, but none through fewer",
    hint="Return (None, all False) for fewer than two points.",
)
def test_two_points_are_enough(student, seed):
    require_line_among_outliers(student.ransac_line)
    point = np.random.default_rng(seed).uniform(-9, 9, (1, 2))
    for few in (point[:0], point.astype(np.float32)):
        answer = student.ransac_line(few.copy(), 5, 0.4, np.random.default_rng(3))
        assert_nothing_found(answer, len(few))
    p, q = (points[0] for points in random_pairs(seed + 6, 1))
    assert_two_points_are_enough(student.ransac_line, np.array([p, q]))
