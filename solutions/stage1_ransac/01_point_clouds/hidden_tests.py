"""Hidden tests of lesson 01. Students see the titles and hints but not the code."""

import math

import numpy as np

from extension import samples
from grader.judging.hidden_tests import cached_by_content, hidden
from utils.checks.assertions import assert_positions, assert_rows
from utils.checks.lesson_01 import (
    assert_distances,
    require_distances_at_all_heights,
    require_lost_returns_dropped,
)


@cached_by_content
def distances_by_hand(cloud):
    return np.array([math.hypot(x, y) for x, y in cloud[:, :2].tolist()])


def assert_right_distances(student, cloud):
    """Compare the answer for a cloud with distances computed in plain Python."""
    answer = student.horizontal_distance(cloud.copy())
    assert_distances(answer, cloud, distances_by_hand(cloud))


def random_rows(cloud, seed, n):
    """Return `n` random rows of a cloud."""
    return cloud[np.random.default_rng(seed).choice(len(cloud), n, replace=False)]


@hidden(
    "horizontal_distance",
    weight=3,
    title="Measures the distances in the course's scan",
    hint="Draw your distances as the notebook does: each colour must form a circle.",
)
def test_measures_the_course_cloud(student, seed):
    assert_right_distances(student, random_rows(samples.course_cloud(), seed, 4000))


@hidden(
    "horizontal_distance",
    weight=3,
    title="Measures the distances in a street you have not seen",
    hint="Compute the square root of x² + y² from columns 0 and 1 of any cloud.",
)
def test_measures_a_fresh_street(student, seed):
    assert_right_distances(student, random_rows(samples.fresh_street(seed), seed, 4000))


@hidden(
    "horizontal_distance",
    weight=2,
    title="Returns the same distances if the street is rotated, mirrored or lifted",
    hint="Use only x² + y², which stays the same if the street is rotated, mirrored or lifted.",
)
def test_distances_do_not_depend_on_direction_or_height(student, seed):
    rng = np.random.default_rng(seed)
    cloud = random_rows(samples.course_cloud(), seed, 300).copy()
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
    title="Works on three columns and on few points",
    hint="Compute with whole columns, such as cloud[:, 0], for any number of points.",
)
def test_measures_three_columns_and_few_points(student, seed):
    require_distances_at_all_heights(student.horizontal_distance)
    cloud = samples.patch_of_course_cloud(seed, 200)[:, :3]
    assert_right_distances(student, cloud)
    assert_right_distances(student, cloud[:2])
    assert_right_distances(student, cloud[:1])


@hidden(
    "horizontal_distance",
    weight=1,
    title="Works on float32 arrays and on duplicate rows",
    hint="Compute with whole columns, such as cloud[:, 0], for any number of points.",
)
def test_measures_in_single_precision(student, seed):
    require_distances_at_all_heights(student.horizontal_distance)
    cloud = samples.patch_of_course_cloud(seed, 200)
    assert_right_distances(student, cloud.astype(np.float32))
    assert_right_distances(student, np.repeat(cloud[:3], 3, axis=0))


def is_valid_row(row):
    """Return whether a row is a valid point."""
    return all(math.isfinite(value) for value in row[:3]) and any(value != 0 for value in row[:3])


@cached_by_content
def valid_rows_by_hand(cloud):
    return np.array([is_valid_row(row) for row in cloud.tolist()], dtype=bool)


def assert_lost_returns_dropped(student, cloud):
    answer = student.drop_invalid(cloud.copy())
    assert_positions(answer, cloud, valid_rows_by_hand(cloud), view="above")


def valid_rows(cloud):
    """Return the valid rows that have no coordinate of 0, and whose coordinates do not sum to 0.

    Points with such coordinates have tests of their own.
    """
    xyz = cloud[:, :3]
    return cloud[(xyz != 0).all(axis=1) & (np.abs(xyz.sum(axis=1)) > 1e-6)]


def insert_lost_returns(cloud, seed, share=0.2):
    """Return valid rows and a share of lost returns: three zeros, or one or three NaNs."""
    rng = np.random.default_rng(seed)
    cloud = valid_rows(cloud)
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
    title="Cleans the course's scan, with and without lost returns",
    hint="Damage the scan as the notebook does: drop_invalid must remove the bar at 0 m.",
)
def test_cleans_the_course_cloud(student, seed):
    require_lost_returns_dropped(student.drop_invalid)
    patch = samples.patch_of_course_cloud(seed, 3000)
    assert_lost_returns_dropped(student, valid_rows(patch))
    assert_lost_returns_dropped(student, insert_lost_returns(patch, seed))


@hidden(
    "drop_invalid",
    weight=2,
    title="Cleans the scan of a street you have not seen",
    hint="Keep the rows in which all three coordinates are finite and at least one is not 0.",
)
def test_cleans_a_fresh_street(student, seed):
    assert_lost_returns_dropped(
        student, insert_lost_returns(random_rows(samples.fresh_street(seed), seed, 3000), seed)
    )


@hidden(
    "drop_invalid",
    weight=3,
    title="Drops returns at (0, 0, 0) whose intensity is above 0",
    hint="Compare the three coordinates with 0, not the whole row.",
)
def test_drops_bright_returns(student, seed):
    require_lost_returns_dropped(student.drop_invalid)
    cloud = valid_rows(samples.patch_of_course_cloud(seed, 400))
    cloud[::7, :3] = 0.0
    cloud[::7, 3] = np.random.default_rng(seed).uniform(0.1, 1, len(cloud[::7]))
    assert_lost_returns_dropped(student, cloud)


@hidden(
    "drop_invalid",
    weight=2,
    title="Drops rows with positive or negative infinity",
    hint="Use np.isfinite, which is False for NaN and for both infinities.",
)
def test_drops_infinite_returns(student, seed):
    require_lost_returns_dropped(student.drop_invalid)
    rng = np.random.default_rng(seed)
    cloud = valid_rows(samples.patch_of_course_cloud(seed, 400))
    for row in range(0, len(cloud), 6):
        cloud[row, rng.integers(0, 3)] = rng.choice([np.inf, -np.inf])
    assert_lost_returns_dropped(student, cloud)


@hidden(
    "drop_invalid",
    weight=2,
    title="Keeps good points with one or two zeros",
    hint="Keep rows in which one or two coordinates are 0. Only a row with three zeros is lost.",
)
def test_keeps_points_with_a_zero(student, seed):
    require_lost_returns_dropped(student.drop_invalid)
    rng = np.random.default_rng(seed)
    cloud = samples.patch_of_course_cloud(seed, 1000)
    # Large coordinates only: even with two zeros, the points are not close to the sensor.
    cloud = cloud[(np.abs(cloud[:, :3]) > 0.6).all(axis=1)]
    for row in range(0, len(cloud), 3):
        cloud[row, rng.choice(3, rng.integers(1, 3), replace=False)] = 0.0
    assert_lost_returns_dropped(student, cloud)


@hidden(
    "drop_invalid",
    weight=1,
    title="Keeps points a few centimetres from the sensor",
    hint="Compare with exactly 0: a point very close to the sensor may be real.",
)
def test_keeps_near_points(student, seed):
    require_lost_returns_dropped(student.drop_invalid)
    near = np.random.default_rng(seed).normal(scale=0.05, size=(40, 4))
    assert_lost_returns_dropped(student, near)
    assert_lost_returns_dropped(student, near * [1, 1, 1, 0])


@hidden(
    "drop_invalid",
    weight=1,
    title="Cleans clouds of three columns",
    hint="Select the coordinates with cloud[:, :3], which works with or without a fourth column.",
)
def test_cleans_three_columns(student, seed):
    assert_lost_returns_dropped(
        student, insert_lost_returns(samples.patch_of_course_cloud(seed, 300), seed)[:, :3]
    )


@hidden(
    "drop_invalid",
    weight=2,
    title="Keeps whole rows and their order, even in float32 arrays",
    hint="Index the whole cloud with the mask, cloud[mask], which keeps all columns and the order.",
)
def test_keeps_order_and_columns(student, seed):
    cloud = insert_lost_returns(samples.patch_of_course_cloud(seed, 300), seed)
    # Answers must keep duplicate points.
    duplicates = np.repeat(cloud[:20], 2, axis=0)
    for scan in (cloud.astype(np.float32), cloud[::-1], duplicates):
        answer = student.drop_invalid(scan.copy())
        assert_rows(answer, scan, valid_rows_by_hand(scan), view="above")
