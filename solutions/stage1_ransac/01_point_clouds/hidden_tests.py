"""Hidden tests of lesson 01. Titles and hints are shown to students; the code is not."""

import math

import numpy as np

from extension import samples
from grader.judging.hidden_tests import cached_by_content, hidden
from utils.checks.assertions import assert_places, assert_rows
from utils.checks.lesson_01 import (
    assert_distances,
    require_lost_returns_dropped,
    require_street_distances,
)


@cached_by_content
def distances_by_hand(cloud):
    return np.array([math.hypot(x, y) for x, y in cloud[:, :2].tolist()])


def assert_measured(student, cloud):
    """Compare the answer with distances computed in plain Python."""
    answer = student.horizontal_distance(cloud.copy())
    assert_distances(answer, cloud, distances_by_hand(cloud))


def some_of(cloud, seed, n):
    """Return n random rows of a cloud."""
    return cloud[np.random.default_rng(seed).choice(len(cloud), n, replace=False)]


@hidden(
    "horizontal_distance",
    weight=3,
    title="Right on the course's own scan",
    hint="Compare with the picture in the notebook: is equal colour a circle?",
)
def test_distances_in_course_cloud(student, seed):
    assert_measured(student, some_of(samples.course_cloud(), seed, 4000))


@hidden(
    "horizontal_distance",
    weight=3,
    title="Right on a street you have not seen",
    hint="The root of x² + y², from the columns 0 and 1 of whatever cloud comes in.",
)
def test_distances_in_fresh_street(student, seed):
    assert_measured(student, some_of(samples.fresh_street(seed), seed, 4000))


@hidden(
    "horizontal_distance",
    weight=2,
    title="The same when the street turns about the sensor, is mirrored or lifted",
    hint="Only how far counts: not the direction, not the sign, not the height.",
)
def test_distances_when_turned(student, seed):
    rng = np.random.default_rng(seed)
    cloud = some_of(samples.course_cloud(), seed, 300).copy()
    before = np.array([math.hypot(x, y) for x, y in cloud[:, :2].tolist()])
    turn = rng.uniform(0, 2 * math.pi)
    cosine, sine = math.cos(turn), math.sin(turn)
    cloud[:, :2] = cloud[:, :2] @ np.array([[cosine, sine], [-sine, cosine]])
    cloud[:, 1] *= -1
    cloud[:, 2] += rng.uniform(2, 9)
    assert_distances(student.horizontal_distance(cloud.copy()), cloud, before)


@hidden(
    "horizontal_distance",
    weight=1,
    title="Right for three columns, and for few points",
    hint="Whole columns serve every case: no special case is needed.",
)
def test_distances_of_three_columns(student, seed):
    require_street_distances(student.horizontal_distance)
    cloud = samples.patch_of_course_cloud(seed, 200)[:, :3]
    assert_measured(student, cloud)
    assert_measured(student, cloud[:2])
    assert_measured(student, cloud[:1])


@hidden(
    "horizontal_distance",
    weight=1,
    title="Right for single precision and any layout in memory",
    hint="Whole columns serve every case: no special case is needed.",
)
def test_distances_in_single_precision(student, seed):
    require_street_distances(student.horizontal_distance)
    cloud = samples.patch_of_course_cloud(seed, 200)
    assert_measured(student, cloud.astype(np.float32))
    assert_measured(student, np.asfortranarray(cloud))
    assert_measured(student, np.repeat(cloud[:3], 3, axis=0))


def is_good(row):
    """Return whether a row is a valid point, computed in plain Python."""
    return all(math.isfinite(value) for value in row[:3]) and any(value != 0 for value in row[:3])


@cached_by_content
def kept_by_hand(cloud):
    return np.array([is_good(row) for row in cloud.tolist()], dtype=bool)


def assert_cleaned(student, cloud):
    answer = student.drop_invalid(cloud.copy())
    assert_places(answer, cloud, kept_by_hand(cloud), view="above")


def whole(cloud):
    """Return a copy without lost returns and without points that have a coordinate of 0.

    Other tests check these cases.
    """
    xyz = cloud[:, :3]
    return cloud[(xyz != 0).all(axis=1) & (np.abs(xyz.sum(axis=1)) > 1e-6)]


def broken(cloud, seed, share=0.2):
    """Return a copy in which some returns are lost, as (0, 0, 0, 0) or with one or three NaN."""
    rng = np.random.default_rng(seed)
    cloud = whole(cloud)
    kind = rng.integers(0, 3, len(cloud))
    bad = rng.random(len(cloud)) < share
    cloud[bad & (kind == 0)] = 0.0
    cloud[bad & (kind == 1), :3] = np.nan
    rows = np.flatnonzero(bad & (kind == 2))
    cloud[rows, rng.integers(0, 3, len(rows))] = np.nan
    return cloud


@hidden(
    "drop_invalid",
    weight=3,
    title="Right on the course's own scan, broken and whole",
    hint="Break the scan as the notebook does: is the tall bar at 0 m gone?",
)
def test_course_cloud_cleaned(student, seed):
    require_lost_returns_dropped(student.drop_invalid)
    patch = samples.patch_of_course_cloud(seed, 3000)
    assert_cleaned(student, whole(patch))
    assert_cleaned(student, broken(patch, seed))


@hidden(
    "drop_invalid",
    weight=2,
    title="Right on a street you have not seen",
    hint="A good row is finite in all three coordinates, and not 0 in all three.",
)
def test_fresh_street_cleaned(student, seed):
    assert_cleaned(student, broken(some_of(samples.fresh_street(seed), seed, 3000), seed))


@hidden(
    "drop_invalid",
    weight=3,
    title="Returns at (0, 0, 0) go with any intensity",
    hint="Compare the three coordinates with 0, not the whole row.",
)
def test_bright_returns_go(student, seed):
    require_lost_returns_dropped(student.drop_invalid)
    cloud = whole(samples.patch_of_course_cloud(seed, 400))
    cloud[::7, :3] = 0.0
    cloud[::7, 3] = np.random.default_rng(seed).uniform(0.1, 1, len(cloud[::7]))
    assert_cleaned(student, cloud)


@hidden(
    "drop_invalid",
    weight=2,
    title="Infinite coordinates go, of either sign",
    hint="np.isfinite is False for NaN and for both infinities.",
)
def test_infinite_returns_go(student, seed):
    require_lost_returns_dropped(student.drop_invalid)
    rng = np.random.default_rng(seed)
    cloud = whole(samples.patch_of_course_cloud(seed, 400))
    for row in range(0, len(cloud), 6):
        cloud[row, rng.integers(0, 3)] = rng.choice([np.inf, -np.inf])
    assert_cleaned(student, cloud)


@hidden(
    "drop_invalid",
    weight=2,
    title="Good points with a 0 among their coordinates stay",
    hint="One coordinate of 0 is fine, and so are two.",
)
def test_points_with_a_zero_stay(student, seed):
    require_lost_returns_dropped(student.drop_invalid)
    rng = np.random.default_rng(seed)
    cloud = samples.patch_of_course_cloud(seed, 1000)
    cloud = cloud[(np.abs(cloud[:, :3]) > 0.6).all(axis=1)]  # far away even with two zeros
    for row in range(0, len(cloud), 3):
        cloud[row, rng.choice(3, rng.integers(1, 3), replace=False)] = 0.0
    assert_cleaned(student, cloud)


@hidden(
    "drop_invalid",
    weight=1,
    title="Keeps any point near the sensor that is not exactly there",
    hint="Only exactly (0, 0, 0) is a lost return. The nearest real point may be nearest of "
    "all for a good reason.",
)
def test_near_points_stay(student, seed):
    require_lost_returns_dropped(student.drop_invalid)
    near = np.random.default_rng(seed).normal(scale=0.05, size=(40, 4))
    assert_cleaned(student, near)
    assert_cleaned(student, near * [1, 1, 1, 0])


@hidden(
    "drop_invalid",
    weight=1,
    title="Right for three columns",
    hint="cloud[:, :3] are the coordinates, whether or not a column follows.",
)
def test_three_columns_cleaned(student, seed):
    assert_cleaned(student, broken(samples.patch_of_course_cloud(seed, 300), seed)[:, :3])


@hidden(
    "drop_invalid",
    weight=2,
    title="Whole rows in their order, also in single precision",
    hint="All columns and the order of the rows stay.",
)
def test_order_and_precision_cleaned(student, seed):
    cloud = broken(samples.patch_of_course_cloud(seed, 300), seed)
    # Equal points stay separate rows.
    twice = np.repeat(cloud[:20], 2, axis=0)
    for scan in (cloud.astype(np.float32), np.asfortranarray(cloud[::-1]), twice):
        answer = student.drop_invalid(scan.copy())
        assert_rows(answer, scan, kept_by_hand(scan), view="above")
