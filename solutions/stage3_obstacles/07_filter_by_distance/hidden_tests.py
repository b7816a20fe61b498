"""Hidden tests of lesson 07. Titles and hints are shown to students; the code is not.

Each tests one property. Points are on a border only in the tests of faces. Heights and intensities
are large enough to matter only in the tests about them.
"""

import copy
import functools
import math

import numpy as np
import pytest

from extension import samples
from grader.judging.hidden_tests import cached_by_content, hidden
from utils.checks.assertions import (
    as_array,
    assert_all_columns,
    assert_nothing_left,
    assert_order,
    assert_untouched,
    frozen,
)
from utils.checks.lesson_07 import (
    assert_points_left,
    assert_points_left_by_box,
    require_crop,
    require_ego_removed,
    require_near_points,
)

MARGIN = 1e-3  # Smallest distance from a border, so that single precision gives the same answer.


@cached_by_content
def distances_by_hand(cloud):
    return np.array([math.sqrt(x * x + y * y) for x, y in cloud[:, :2].tolist()])


def clear_of_circle(cloud, distance):
    """Return the rows that are clear of a circle's rim, and whether each is inside."""
    true_distance = distances_by_hand(cloud)
    clear = np.abs(true_distance - distance) > MARGIN
    return cloud[clear], true_distance[clear] < distance


def assert_distance_filtered(student, cloud, distance=10.0):
    """Compare the answer with distances computed in plain Python."""
    cloud, near = clear_of_circle(cloud, distance)
    answer = student.filter_by_distance(cloud.copy(order="A"), distance)
    assert_points_left(answer, cloud, distance, near)


def without_corners(cloud, distance):
    """Return rows whose side of the circle is the same for every usual norm in the plane."""
    x, y = np.abs(cloud[:, :2]).T
    return cloud[(x + y < distance - MARGIN) | (np.maximum(x, y) > distance + MARGIN)]


def pressed_flat(cloud):
    """Return the cloud with heights and intensities too small to affect a distance."""
    return cloud * [1, 1, 0.01, 0.01]


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
    title="Right on a street you have not seen, pressed flat",
    hint="On every street the rows with sqrt(x² + y²) <= distance are what is left.",
)
def test_fresh_street(student, seed):
    assert_distance_filtered(student, pressed_flat(samples.fresh_street(seed)[::5]))


@hidden(
    "filter_by_distance",
    weight=5,
    title="Right at distances you have not seen",
    hint="Near is what is at most `distance` away, whatever number that is.",
)
def test_other_distances(student, seed):
    cloud = pressed_flat(samples.patch_of_course_cloud(seed, 1000))
    for distance in np.random.default_rng(seed).uniform(6.0, 20.0, 4).tolist():
        assert_distance_filtered(student, without_corners(cloud, distance), distance)


@hidden(
    "filter_by_distance",
    weight=3,
    title="The same whatever the heights",
    hint="x and y alone decide, columns 0 and 1; the height stays with its row.",
)
def test_heights(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 600) * [1, 1, 0, 0.01]
    cloud[:, 2] = np.random.default_rng(seed).uniform(-30, 30, len(cloud))
    cloud[7] = 0.0, 0.0, 5.5, 0.01  # straight above the sensor, as under a bridge
    assert_distance_filtered(student, without_corners(cloud, 10.0))


@hidden(
    "filter_by_distance",
    weight=3,
    title="The same whatever the intensities",
    hint="x and y alone decide, columns 0 and 1; the intensity stays with its row.",
)
def test_intensities(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 600) * [1, 1, 0.01, 0]
    cloud[:, 3] = np.random.default_rng(seed).integers(0, 256, len(cloud))
    assert_distance_filtered(student, without_corners(cloud, 10.0))


@hidden(
    "filter_by_distance",
    weight=2,
    title="Turning the cloud about the sensor changes nothing",
    hint="A circle is the same from all sides.",
)
def test_turned(student, seed):
    cloud = pressed_flat(samples.patch_of_course_cloud(seed, 500))
    for angle in np.random.default_rng(seed).uniform(0, 2 * math.pi, 3):
        turned = cloud.copy()
        turned[:, 0] = math.cos(angle) * cloud[:, 0] - math.sin(angle) * cloud[:, 1]
        turned[:, 1] = math.sin(angle) * cloud[:, 0] + math.cos(angle) * cloud[:, 1]
        assert_distance_filtered(student, turned)


@hidden(
    "filter_by_distance",
    weight=2,
    title="Every row keeps its intensity, bright or not",
    hint="Index the cloud itself: all columns stay.",
)
def test_columns(student, seed):
    cloud = without_corners(pressed_flat(samples.patch_of_course_cloud(seed, 500)), 10.0)
    cloud, near = clear_of_circle(cloud, 10.0)
    assert_all_columns(student.filter_by_distance(cloud.copy(), 10.0), cloud, near)


@hidden(
    "filter_by_distance",
    weight=2,
    title="The order of the rows stays, whatever it was",
    hint="A mask keeps the order by itself.",
)
def test_order(student, seed):
    cloud = without_corners(pressed_flat(samples.patch_of_course_cloud(seed, 500)), 10.0)
    cloud, near = clear_of_circle(cloud, 10.0)
    for order in (np.arange(len(cloud)), np.argsort(-cloud[:, 1])):
        answer = student.filter_by_distance(cloud[order], 10.0)
        assert_order(answer, cloud[order], near[order])


@hidden(
    "filter_by_distance",
    weight=1,
    title="Right for three columns, single precision and rows that occur twice",
    hint="The same two lines serve every case: no special case is needed.",
)
def test_kinds_of_clouds(student, seed):
    require_near_points(student.filter_by_distance)
    cloud = without_corners(pressed_flat(samples.patch_of_course_cloud(seed, 300)), 10.0)
    assert_distance_filtered(student, cloud[:, :3])
    assert_distance_filtered(student, cloud.astype(np.float32))
    assert_distance_filtered(student, np.asfortranarray(cloud))
    assert_distance_filtered(student, np.repeat(cloud[:40], 3, axis=0))


@hidden(
    "filter_by_distance",
    weight=1,
    title="Right for one point and where nothing is left",
    hint="The same two lines serve every case: no special case is needed.",
)
def test_small(student, seed):
    require_near_points(student.filter_by_distance)
    cloud = pressed_flat(samples.patch_of_course_cloud(seed, 300))
    columns = as_array(student.filter_by_distance(cloud.copy(), 10.0)).shape[-1]
    far = cloud + [100, 0, 0, 0]
    assert_nothing_left(student.filter_by_distance(far.copy(), 10.0), far, columns)
    assert_distance_filtered(student, np.array([[3.0, 4.0, 0.1, 0.5]]))


@hidden(
    "filter_by_distance",
    weight=2,
    title="Never writes into the array that it is given",
    hint="Indexing with a mask makes a new array, and leaves the cloud as it is.",
)
def test_input(student, seed):
    require_near_points(student.filter_by_distance)
    assert_untouched(student.filter_by_distance, samples.patch_of_course_cloud(seed, 200), 10.0)


REGION = (-10.0, -5.0, -2.0), (30.0, 6.0, 1.0)
EGO_BOX = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)
# A region from below the road to above the trees, in which heights do not matter.
TALL_REGION = (-10.0, -5.0, -60.0), (30.0, 6.0, 60.0)


def boxes_of(seed, tall):
    """Yield new boxes: ahead on the right, behind, and around the sensor."""
    rng = np.random.default_rng(seed)
    for x, y in ((7, -7), (-7, 4), (1, 0)):
        middle = np.array([x, y, -1.0]) + rng.uniform(-0.5, 0.5, 3)
        half = rng.uniform((2, 2, 0.4), (6, 5, 1.2))
        if tall:
            half[2] = 60.0
        yield tuple((middle - half).tolist()), tuple((middle + half).tolist())


@cached_by_content
def gaps_by_hand(cloud, minimum, maximum):
    """Return the smallest distance of each row from a box's faces, and its depth inside, (n, 2)."""
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
    """Return the rows that are clear of the faces of a box, and whether each is inside."""
    distance, depth = gaps_by_hand(cloud, tuple(minimum), tuple(maximum)).T
    return cloud[distance > MARGIN], depth[distance > MARGIN] > 0


def ask(student, exercise, cloud, minimum, maximum):
    corners = copy.copy(minimum), copy.copy(maximum)
    return getattr(student, exercise)(cloud.copy(order="A"), *corners)


def assert_box_filtered(student, exercise, cloud, minimum, maximum):
    cloud, inside = clear_of(cloud, minimum, maximum)
    keep = inside if exercise == "crop_region" else ~inside
    assert_points_left_by_box(
        ask(student, exercise, cloud, minimum, maximum), cloud, minimum, maximum, keep
    )


def apart(cloud, minimum, maximum):
    """Return which rows are outside on all axes, below a box on some and above it on others."""
    before, beyond = cloud[:, :3] < np.array(minimum), cloud[:, :3] > np.array(maximum)
    return (before | beyond).all(axis=1) & before.any(axis=1) & beyond.any(axis=1)


def clear_cut(cloud, minimum, maximum):
    """Return the rows that are inside a box on all axes or on none, and whether each is inside."""
    cloud, inside = clear_of(cloud, minimum, maximum)
    clear = inside | apart(cloud, minimum, maximum)
    return cloud[clear], inside[clear]


def on_a_lattice(seed):
    """Return points in, on or away from a box, the box, and a mask of the points in or on it.

    All coordinates are multiples of half a metre, which have no rounding errors.
    """
    rng = np.random.default_rng(seed)
    cloud = np.column_stack([rng.integers(-10, 11, (1500, 3)) / 2, np.ones(1500)])
    cloud = rng.permutation(np.unique(cloud, axis=0))
    minimum = tuple((rng.integers(-7, -2, 3) / 2).tolist())
    maximum = tuple((rng.integers(2, 8, 3) / 2).tolist())
    inside = gaps_by_hand(cloud, minimum, maximum)[:, 1] >= 0
    clear = inside | apart(cloud, minimum, maximum)
    return cloud[clear], (minimum, maximum), inside[clear]


def other_clouds(cloud):
    """Yield the cloud with three columns, in other types and layouts, and with duplicate rows."""
    yield cloud[:, :3]
    yield cloud.astype(np.float32)
    yield np.asfortranarray(cloud)
    yield np.repeat(cloud[:100], 3, axis=0)


@functools.lru_cache(maxsize=64)
def scan_around_the_car(seed):
    """Return part of a new street, with all returns of the ego car and all invalid ones."""
    cloud = samples.fresh_street(seed)
    near = np.flatnonzero(np.hypot(cloud[:, 0], cloud[:, 1]) < 2.5)
    rest = np.random.default_rng(seed).choice(len(cloud), 700, replace=False)
    return frozen(cloud[np.union1d(near, rest)])


@functools.cache
def course_around_the_car():
    cloud = samples.course_cloud()
    return frozen(cloud[np.hypot(cloud[:, 0], cloud[:, 1]) < 3.6])


@hidden(
    "crop_region",
    weight=6,
    title="Right on the course's own scan and on a fresh street",
    hint="Compare with the picture in the notebook: nothing may stick out of the rectangle.",
)
def test_crop_streets(student, seed):
    for cloud in (
        samples.patch_of_course_cloud(seed, 3000),
        samples.obstacles_of_street(seed, 3000),
    ):
        assert_box_filtered(student, "crop_region", cloud, *TALL_REGION)


@hidden(
    "crop_region",
    weight=3,
    title="Right for boxes you have not seen",
    hint="Inside is what lies between minimum and maximum, whatever these are.",
)
def test_crop_other_boxes(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 1500)
    for minimum, maximum in boxes_of(seed, tall=True):
        assert_box_filtered(student, "crop_region", cloud, minimum, maximum)


@hidden(
    "crop_region",
    weight=4,
    title="Right where height decides",
    hint="All three coordinates have to be inside, z too.",
)
def test_crop_heights(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 1500)
    for low, high in np.sort(np.random.default_rng(seed).uniform(-2, 1, (3, 2)), axis=1).tolist():
        assert_box_filtered(student, "crop_region", cloud, (-60, -60, low), (60, 60, high + 0.1))


@hidden(
    "crop_region",
    weight=2,
    title="Every row keeps its place and its intensity, bright or not",
    hint="Compare the first three columns; the fourth is no coordinate, and stays.",
)
def test_crop_columns(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 500) * [1, 1, 1, 255]
    cloud, inside = clear_cut(cloud, *REGION)
    assert_all_columns(ask(student, "crop_region", cloud, *REGION), cloud, inside)


@hidden(
    "crop_region",
    weight=1,
    title="The order of the rows stays, whatever it was",
    hint="A mask keeps the order by itself.",
)
def test_crop_order(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 500)
    cloud, inside = clear_cut(cloud[np.argsort(-cloud[:, 1])], *REGION)
    assert_order(ask(student, "crop_region", cloud, *REGION), cloud, inside)


@hidden(
    "crop_region",
    weight=1,
    title="Right for three columns, single precision and rows that occur twice",
    hint="The same lines serve every case: no special case is needed.",
)
def test_crop_kinds_of_clouds(student, seed):
    require_crop(student.crop_region)
    cloud, _ = clear_cut(samples.patch_of_course_cloud(seed, 300), *REGION)
    for variant in other_clouds(cloud):
        assert_box_filtered(student, "crop_region", variant, *REGION)


@hidden(
    "crop_region",
    weight=1,
    title="Right for one point and where nothing is left",
    hint="The same lines serve every case: no special case is needed.",
)
def test_crop_small(student, seed):
    require_crop(student.crop_region)
    cloud = samples.patch_of_course_cloud(seed, 300)
    columns = as_array(ask(student, "crop_region", cloud, *REGION)).shape[-1]
    far = cloud + [200, 200, 200, 0]
    assert_nothing_left(ask(student, "crop_region", far, *REGION), far, columns)
    assert_box_filtered(student, "crop_region", np.array([[1.0, 2.0, 0.5, 0.1]]), *REGION)


@hidden(
    "crop_region",
    weight=1,
    title="Never writes into the arrays that it is given",
    hint="Indexing with a mask makes a new array, and leaves the cloud as it is.",
)
def test_crop_input(student, seed):
    require_crop(student.crop_region)
    cloud = samples.patch_of_course_cloud(seed, 200)
    assert_untouched(student.crop_region, cloud, *map(np.array, REGION))


@hidden(
    "remove_ego_returns",
    weight=3,
    title="Frees {} of our own car",
    hint="In the picture the box must be empty, and everything beside it still there.",
)
@pytest.mark.parametrize(
    "street", ["course", "fresh"], ids=["the course's own scan", "a fresh street"]
)
def test_remove_from_streets(student, seed, street):
    cloud = course_around_the_car() if street == "course" else scan_around_the_car(seed)
    assert_box_filtered(student, "remove_ego_returns", cloud, *EGO_BOX)


@hidden(
    "remove_ego_returns",
    weight=3,
    title="Right for boxes you have not seen",
    hint="Inside is what lies between minimum and maximum, whatever these are.",
)
def test_remove_other_boxes(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 1500)
    for minimum, maximum in boxes_of(seed + 1, tall=True):
        assert_box_filtered(student, "remove_ego_returns", cloud, minimum, maximum)


@hidden(
    "remove_ego_returns",
    weight=3,
    title="Right where height decides",
    hint="What is above or below the box is no part of it.",
)
def test_remove_heights(student, seed):
    require_ego_removed(student.remove_ego_returns)
    cloud = samples.patch_of_course_cloud(seed, 1500)
    for minimum, maximum in boxes_of(seed + 2, tall=False):
        assert_box_filtered(student, "remove_ego_returns", cloud, minimum, maximum)


@hidden(
    "remove_ego_returns",
    weight=2,
    title="Every row keeps its intensity, bright or not",
    hint="Compare the first three columns; the fourth is no coordinate, and stays.",
)
def test_remove_columns(student, seed):
    cloud, inside = clear_cut(scan_around_the_car(seed) * [1, 1, 1, 255], *EGO_BOX)
    assert_all_columns(ask(student, "remove_ego_returns", cloud, *EGO_BOX), cloud, ~inside)


@hidden(
    "remove_ego_returns",
    weight=1,
    title="The order of the rows stays, whatever it was",
    hint="A mask keeps the order by itself.",
)
def test_remove_order(student, seed):
    cloud = scan_around_the_car(seed)
    cloud, inside = clear_cut(cloud[np.argsort(-cloud[:, 1])], *EGO_BOX)
    assert_order(ask(student, "remove_ego_returns", cloud, *EGO_BOX), cloud, ~inside)


@hidden(
    "remove_ego_returns",
    weight=1,
    title="Right for three columns, single precision and rows that occur twice",
    hint="The same lines serve every case; what occurs twice stays twice.",
)
def test_remove_kinds_of_clouds(student, seed):
    require_ego_removed(student.remove_ego_returns)
    cloud, _ = clear_cut(scan_around_the_car(seed), *EGO_BOX)
    for variant in other_clouds(cloud):
        assert_box_filtered(student, "remove_ego_returns", variant, *EGO_BOX)


@hidden(
    "remove_ego_returns",
    weight=1,
    title="Right for one point and where nothing is left",
    hint="The same lines serve every case: no special case is needed.",
)
def test_remove_small(student, seed):
    require_ego_removed(student.remove_ego_returns)
    cloud = scan_around_the_car(seed)
    columns = as_array(ask(student, "remove_ego_returns", cloud, *EGO_BOX)).shape[-1]
    low, high = map(np.array, EGO_BOX)
    ours = np.random.default_rng(seed).uniform([*low + 0.05, 0], [*high - 0.05, 1], (50, 4))
    assert_nothing_left(ask(student, "remove_ego_returns", ours, *EGO_BOX), ours, columns)
    assert_box_filtered(student, "remove_ego_returns", np.array([[9.0, 8.0, 2.2, 0.1]]), *EGO_BOX)


@hidden(
    "remove_ego_returns",
    weight=1,
    title="Never writes into the arrays that it is given",
    hint="Indexing with a mask makes a new array, and leaves the cloud as it is.",
)
def test_remove_input(student, seed):
    require_ego_removed(student.remove_ego_returns)
    # A small part of a scan may contain no returns of the ego car, and so nothing to overwrite.
    for cloud in (course_around_the_car(), samples.patch_of_course_cloud(seed, 200)):
        assert_untouched(student.remove_ego_returns, cloud, *map(np.array, EGO_BOX))
