"""Hidden tests of lesson 07. Titles and hints are shown to students; the code is not."""

import copy
import math

import numpy as np
import pytest

from grader.judging import samples
from grader.judging.marks import hidden, visible_checks
from utils.checks.lesson_07 import assert_boxed, assert_near

MARGIN = 1e-3  # No point is nearer than this to a border: single precision answers alike.


@visible_checks("filter_by_distance", "crop_region", "remove_ego_returns")
def test_visible(student, check):
    check.run(getattr(student, check.exercise))


@samples.remembered
def distances_by_hand(cloud):
    return np.array([math.sqrt(x * x + y * y) for x, y in cloud[:, :2].tolist()])


def assert_distance_filtered(student, cloud, *distance):
    """Compare with plain Python; both answers, some rows and not all, must be asked for."""
    radius = (distance or (10.0,))[0]
    true_distance = distances_by_hand(cloud)
    clear = np.abs(true_distance - radius) > MARGIN
    cloud, near = cloud[clear], true_distance[clear] < radius
    assert_near(student.filter_by_distance(cloud.copy(order="A"), *distance), cloud, radius, near)


@hidden(
    "filter_by_distance",
    weight=4,
    title="Right on the course's own scan",
    hint="Compare with the picture in the notebook: a disc, with nothing missing inside.",
)
def test_course_cloud(student):
    assert_distance_filtered(student, samples.course_cloud()[::5])


@hidden(
    "filter_by_distance",
    weight=4,
    title="Right on a street you have not seen",
    hint="Nothing about one particular cloud may stand in the function.",
)
def test_fresh_street(student, seed):
    assert_distance_filtered(student, samples.fresh_street(seed)[::5], 12.5)


@hidden(
    "filter_by_distance",
    weight=3,
    title="Right at distances you have not seen",
    hint="The distance comes from the parameter distance and from nowhere else.",
)
def test_other_distances(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 1000)
    for distance in np.random.default_rng(seed).uniform(4.0, 20.0, 4):
        assert_distance_filtered(student, cloud, float(distance))


@hidden(
    "filter_by_distance",
    weight=3,
    title="The same whatever the heights and the intensities",
    hint="Only columns 0 and 1 decide. Height and intensity stay, but are not counted.",
)
def test_height_and_intensity(student, seed):
    rng = np.random.default_rng(seed)
    cloud = samples.patch_of_course_cloud(seed, 600).copy()
    cloud[:, 2] = rng.uniform(-30, 30, len(cloud))
    assert_distance_filtered(student, cloud)
    cloud[:, 2] = rng.uniform(-1, 1, len(cloud))
    cloud[:, 3] = rng.integers(0, 256, len(cloud))
    assert_distance_filtered(student, cloud)


@hidden(
    "filter_by_distance",
    weight=2,
    title="Turning the cloud about the sensor or mixing its rows changes nothing",
    hint="A circle is the same from all sides; the order of rows stays as it came.",
)
def test_turned_and_mixed(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 500)
    for angle in np.random.default_rng(seed).uniform(0, 2 * math.pi, 3):
        turned = cloud.copy()
        turned[:, 0] = math.cos(angle) * cloud[:, 0] - math.sin(angle) * cloud[:, 1]
        turned[:, 1] = math.sin(angle) * cloud[:, 0] + math.cos(angle) * cloud[:, 1]
        assert_distance_filtered(student, turned)
    assert_distance_filtered(student, cloud[np.argsort(cloud[:, 2])])


@hidden(
    "filter_by_distance",
    weight=2,
    title="Right for three columns, single precision, one point and no result",
    hint="The same two lines serve every case: no special case is needed.",
)
def test_small_and_single(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 300)
    assert_distance_filtered(student, cloud[:, :3])
    assert_distance_filtered(student, cloud.astype(np.float32))
    assert_distance_filtered(student, np.asfortranarray(cloud))
    assert_distance_filtered(student, np.repeat(cloud[:40], 3, axis=0))
    assert_distance_filtered(student, np.array([[3.0, 4.0, 20.0, 0.5]]), 6.0)
    assert_distance_filtered(student, cloud, 0.5)


REGION = (-10.0, -5.0, -2.0), (30.0, 6.0, 1.0)
EGO_BOX = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)


def boxes_of(seed):
    """Boxes that nobody has seen, around places where there are points."""
    rng = np.random.default_rng(seed)
    for _ in range(3):
        middle = rng.uniform((-6, -6, -1.5), (8, 6, -0.5))
        half = rng.uniform((2, 2, 0.4), (6, 5, 1.2))
        yield (middle - half).tolist(), (middle + half).tolist()


@samples.remembered
def gaps_by_hand(cloud, minimum, maximum):
    """Smallest distance of each row from a face of a box, and smallest depth in it, (n, 2)."""
    found = []
    for row in cloud[:, :3].tolist():
        gaps = [
            side
            for value, low, high in zip(row, minimum, maximum, strict=True)
            for side in (value - low, high - value)
        ]
        found.append((min(map(abs, gaps)), min(gaps)))
    return np.array(found).reshape(-1, 2)


def clear_of(cloud, minimum, maximum):
    """(rows that lie clear of the faces of a box, whether each is inside)."""
    distance, depth = gaps_by_hand(cloud, tuple(minimum), tuple(maximum)).T
    return cloud[distance > MARGIN], depth[distance > MARGIN] > 0


def assert_box_filtered(student, exercise, cloud, minimum, maximum):
    cloud, keep = clear_of(cloud, minimum, maximum)
    corners = copy.copy(minimum), copy.copy(maximum)
    keep = keep if exercise == "crop_region" else ~keep
    answer = getattr(student, exercise)(cloud.copy(order="A"), *corners)
    assert_boxed(answer, cloud, minimum, maximum, keep)


def scan_around_the_car(seed):
    """A fresh street near the sensor, with the returns of our own car and invalid ones."""
    cloud = samples.fresh_street(seed)
    near = np.flatnonzero(np.hypot(cloud[:, 0], cloud[:, 1]) < 2.5)
    rest = np.random.default_rng(seed).choice(len(cloud), 700, replace=False)
    return cloud[np.union1d(near, rest)]


@hidden(
    "crop_region",
    weight=3,
    title="Right on the course's own scan and on a fresh street",
    hint="Compare with the picture in the notebook: nothing may stick out of the rectangle.",
)
def test_crop_streets(student, seed):
    assert_box_filtered(student, "crop_region", samples.patch_of_course_cloud(seed, 3000), *REGION)
    assert_box_filtered(student, "crop_region", samples.obstacles_of_street(seed, 3000), *REGION)


@hidden(
    "crop_region",
    weight=3,
    title="Right for boxes you have not seen",
    hint="All six numbers come from minimum and maximum.",
)
def test_crop_other_boxes(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 1500)
    for minimum, maximum in boxes_of(seed):
        assert_box_filtered(student, "crop_region", cloud, minimum, maximum)


@hidden(
    "crop_region",
    weight=2,
    title="Right for three columns, single precision, one point, high intensities",
    hint="Compare the first three columns; the fourth is no coordinate.",
)
def test_crop_small(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 300)
    bright = cloud * [1, 1, 1, 255]
    for variant in (cloud[:, :3], cloud.astype(np.float32), np.asfortranarray(cloud), bright):
        assert_box_filtered(student, "crop_region", variant, *REGION)
    assert_box_filtered(student, "crop_region", np.array([[1.0, 2.0, 0.5]]), *REGION)


@hidden(
    "remove_ego_returns",
    weight=3,
    title="Frees the course's own scan and a fresh street of our own car",
    hint="In the picture the box must be empty, and everything beside it still there.",
)
@pytest.mark.parametrize("street", ["course", "fresh"])
def test_remove_from_streets(student, seed, street):
    cloud = scan_around_the_car(seed)
    if street == "course":
        cloud = samples.course_cloud()
        cloud = cloud[np.hypot(cloud[:, 0], cloud[:, 1]) < 3.6]
    assert_box_filtered(student, "remove_ego_returns", cloud, *EGO_BOX)


@hidden(
    "remove_ego_returns",
    weight=3,
    title="Right for boxes you have not seen",
    hint="All six numbers come from minimum and maximum.",
)
def test_remove_other_boxes(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 1500)
    for minimum, maximum in boxes_of(seed + 1):
        assert_box_filtered(student, "remove_ego_returns", cloud, minimum, maximum)


@hidden(
    "remove_ego_returns",
    weight=2,
    title="Right for three columns, single precision, duplicates, high intensities",
    hint="Compare the first three columns; the fourth is no coordinate. Order and duplicates stay.",
)
def test_remove_small(student, seed):
    box = (-5.0, -4.0, -1.5), (8.0, 5.0, 0.5)
    cloud = samples.patch_of_course_cloud(seed, 300)
    bright = cloud * [1, 1, 1, 255]
    for variant in (
        cloud[:, :3],
        cloud.astype(np.float32),
        np.asfortranarray(cloud),
        bright,
        np.repeat(cloud[:40], 3, axis=0),
    ):
        assert_box_filtered(student, "remove_ego_returns", variant, *box)
    assert_box_filtered(
        student, "remove_ego_returns", np.array([[0.0, 0.0, 0.0], [9.0, 1.0, 0.2]]), *box
    )
