"""Hidden tests of lesson 07. Students see the titles and hints but not the code.

Each test covers one property. No point is on a border. Heights and intensities are large enough to
matter only in the tests about them. In the course's scan and on new streets, heights are as the
scanner measured them.
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
    assert_empty_table,
    assert_order,
    assert_untouched,
    frozen,
)
from utils.checks.lesson_07 import (
    assert_points_left,
    assert_points_left_by_box,
    require_crop,
    require_ego_removed,
    require_near_points_kept,
)

MARGIN = 1e-3  # metres from a border, so that single precision gives the same answer


@cached_by_content
def distances_in_plain_python(cloud):
    return np.array([math.sqrt(x * x + y * y) for x, y in cloud[:, :2].tolist()])


def rows_clear_of_circle(cloud, distance):
    """Return the rows that are not on a circle's rim, and whether each is inside."""
    true_distance = distances_in_plain_python(cloud)
    clear = np.abs(true_distance - distance) > MARGIN
    return cloud[clear], true_distance[clear] < distance


def assert_distance_filtered(student, cloud, distance=10.0):
    """Compare the answer for a cloud with distances computed in plain Python."""
    cloud, near = rows_clear_of_circle(cloud, distance)
    answer = student.filter_by_distance(cloud.copy(order="A"), distance)
    assert_points_left(answer, cloud, distance, near)


def drop_corners(cloud, distance):
    """Return the rows for which |x| + |y| and max(|x|, |y|) agree with the distance."""
    x, y = np.abs(cloud[:, :2]).T
    return cloud[(x + y < distance - MARGIN) | (np.maximum(x, y) > distance + MARGIN)]


def flatten(cloud):
    """Scale heights and intensities down until they hardly affect a distance."""
    return cloud * [1, 1, 0.01, 0.01]


@hidden(
    "filter_by_distance",
    weight=4,
    title="Keeps the near points of the course's scan",
    hint="Draw your result as in the notebook: it must be a disc with a radius of 10 m.",
)
def test_filters_the_course_scan(student):
    assert_distance_filtered(student, samples.course_cloud()[::5])


@hidden(
    "filter_by_distance",
    weight=4,
    title="Keeps the near points of a street you have not seen",
    hint="Keep exactly the rows with sqrt(x² + y²) <= distance.",
)
def test_filters_a_new_street(student, seed):
    assert_distance_filtered(student, samples.fresh_street(seed)[::5] * [1, 1, 1, 0.01])


@hidden(
    "filter_by_distance",
    weight=5,
    title="Works with distances you have not seen",
    hint="Compare with `distance`, whatever its value.",
)
def test_works_with_other_distances(student, seed):
    cloud = flatten(samples.patch_of_course_cloud(seed, 1000))
    for distance in np.random.default_rng(seed).uniform(6.0, 20.0, 4).tolist():
        assert_distance_filtered(student, drop_corners(cloud, distance), distance)


@hidden(
    "filter_by_distance",
    weight=3,
    title="Keeps the same points, whatever their heights",
    hint="Compute the distance from columns 0 and 1 only, and keep the height in its row.",
)
def test_ignores_heights(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 600) * [1, 1, 0, 0.01]
    cloud[:, 2] = np.random.default_rng(seed).uniform(-30, 30, len(cloud))
    cloud[7] = 0.0, 0.0, 5.5, 0.01  # directly above the sensor, as under a bridge
    assert_distance_filtered(student, drop_corners(cloud, 10.0))


@hidden(
    "filter_by_distance",
    weight=3,
    title="Keeps the same points, whatever their intensities",
    hint="Compute the distance from columns 0 and 1 only, and keep the intensity in its row.",
)
def test_ignores_intensities(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 600) * [1, 1, 0.01, 0]
    cloud[:, 3] = np.random.default_rng(seed).integers(0, 256, len(cloud))
    assert_distance_filtered(student, drop_corners(cloud, 10.0))


@hidden(
    "filter_by_distance",
    weight=2,
    title="Keeps the same points when the cloud is turned about the sensor",
    hint="Compute the distance with np.hypot(x, y), which is the same in every direction.",
)
def test_keeps_the_same_points_when_turned(student, seed):
    cloud = flatten(samples.patch_of_course_cloud(seed, 500))
    for angle in np.random.default_rng(seed).uniform(0, 2 * math.pi, 3):
        turned = cloud.copy()
        turned[:, 0] = math.cos(angle) * cloud[:, 0] - math.sin(angle) * cloud[:, 1]
        turned[:, 1] = math.sin(angle) * cloud[:, 0] + math.cos(angle) * cloud[:, 1]
        assert_distance_filtered(student, turned)


@hidden(
    "filter_by_distance",
    weight=2,
    title="Keeps the intensity of every row",
    hint="Index the cloud itself, cloud[mask], which keeps all columns.",
)
def test_keeps_all_columns(student, seed):
    cloud = drop_corners(flatten(samples.patch_of_course_cloud(seed, 500)), 10.0)
    cloud, near = rows_clear_of_circle(cloud, 10.0)
    assert_all_columns(student.filter_by_distance(cloud.copy(), 10.0), cloud, near)


@hidden(
    "filter_by_distance",
    weight=2,
    title="Keeps the order of the rows, whatever it was",
    hint="Index with a mask, which never changes the order.",
)
def test_keeps_the_order(student, seed):
    cloud = drop_corners(flatten(samples.patch_of_course_cloud(seed, 500)), 10.0)
    cloud, near = rows_clear_of_circle(cloud, 10.0)
    for order in (np.arange(len(cloud)), np.argsort(-cloud[:, 1])):
        answer = student.filter_by_distance(cloud[order], 10.0)
        assert_order(answer, cloud[order], near[order])


@hidden(
    "filter_by_distance",
    weight=1,
    title="Works with three columns, float32 and duplicate rows",
    hint="Use the same mask for every cloud, without a special case.",
)
def test_works_on_all_kinds_of_clouds(student, seed):
    require_near_points_kept(student.filter_by_distance)
    cloud = drop_corners(flatten(samples.patch_of_course_cloud(seed, 300)), 10.0)
    assert_distance_filtered(student, cloud[:, :3])
    assert_distance_filtered(student, cloud.astype(np.float32))
    assert_distance_filtered(student, np.repeat(cloud[:40], 3, axis=0))


@hidden(
    "filter_by_distance",
    weight=1,
    title="Works on a single point, and when no point is left",
    hint="Use the same mask for every cloud, without a special case.",
)
def test_works_on_small_clouds(student, seed):
    require_near_points_kept(student.filter_by_distance)
    cloud = flatten(samples.patch_of_course_cloud(seed, 300))
    columns = as_array(student.filter_by_distance(cloud.copy(), 10.0)).shape[-1]
    far = cloud + [100, 0, 0, 0]
    assert_empty_table(student.filter_by_distance(far.copy(), 10.0), far, columns)
    assert_distance_filtered(student, np.array([[3.0, 4.0, 0.1, 0.5]]))


@hidden(
    "filter_by_distance",
    weight=2,
    title="Does not change a cloud from the course's scan",
    hint="Index with a mask, which creates a new array and leaves the cloud unchanged.",
)
def test_leaves_its_input_unchanged(student, seed):
    require_near_points_kept(student.filter_by_distance)
    assert_untouched(student.filter_by_distance, samples.patch_of_course_cloud(seed, 200), 10.0)


REGION = (-10.0, -5.0, -2.0), (30.0, 6.0, 1.0)
EGO_BOX = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)
# From below the road to above the trees, so that heights do not matter.
TALL_REGION = (-10.0, -5.0, -60.0), (30.0, 6.0, 60.0)


def random_boxes(seed, tall):
    """Yield random boxes: ahead on the right, behind, and around the sensor."""
    rng = np.random.default_rng(seed)
    for x, y in ((7, -7), (-7, 4), (1, 0)):
        middle = np.array([x, y, -1.0]) + rng.uniform(-0.5, 0.5, 3)
        half = rng.uniform((2, 2, 0.4), (6, 5, 1.2))
        if tall:
            half[2] = 60.0
        yield tuple((middle - half).tolist()), tuple((middle + half).tolist())


@cached_by_content
def distances_and_depths(cloud, minimum, maximum):
    """Return each row's distance from the nearest face of a box, and its depth inside, (n, 2)."""
    found = []
    for row in cloud[:, :3].tolist():
        gaps = [
            side
            for value, low, high in zip(row, minimum, maximum, strict=True)
            for side in (value - low, high - value)
        ]
        found.append((min(map(abs, gaps)), min(gaps)))
    return np.array(found).reshape(-1, 2)


def rows_clear_of_box(cloud, minimum, maximum):
    """Return the rows that are not on a face of a box, and whether each is inside."""
    distance, depth = distances_and_depths(cloud, tuple(minimum), tuple(maximum)).T
    return cloud[distance > MARGIN], depth[distance > MARGIN] > 0


def answer_of(student, exercise, cloud, minimum, maximum):
    corners = copy.copy(minimum), copy.copy(maximum)
    return getattr(student, exercise)(cloud.copy(order="A"), *corners)


def assert_box_filtered(student, exercise, cloud, minimum, maximum):
    cloud, inside = rows_clear_of_box(cloud, minimum, maximum)
    keep = inside if exercise == "crop_region" else ~inside
    assert_points_left_by_box(
        answer_of(student, exercise, cloud, minimum, maximum), cloud, minimum, maximum, keep
    )


def outside_on_all_axes(cloud, minimum, maximum):
    """Return a mask of rows outside a box on all axes, below it on some and above on others."""
    before, beyond = cloud[:, :3] < np.array(minimum), cloud[:, :3] > np.array(maximum)
    return (before | beyond).all(axis=1) & before.any(axis=1) & beyond.any(axis=1)


def inside_on_all_axes_or_none(cloud, minimum, maximum):
    """Return the rows that are inside a box on all axes or on none, and whether each is inside."""
    cloud, inside = rows_clear_of_box(cloud, minimum, maximum)
    clear = inside | outside_on_all_axes(cloud, minimum, maximum)
    return cloud[clear], inside[clear]


def cloud_variants(cloud):
    """Yield the cloud with three columns, in single precision, and with duplicates."""
    yield cloud[:, :3]
    yield cloud.astype(np.float32)
    yield np.repeat(cloud[:100], 3, axis=0)


@functools.lru_cache(maxsize=64)
def scan_around_the_car(seed):
    """Return part of a new street, with all invalid returns and all returns from the ego car."""
    cloud = samples.fresh_street(seed)
    near = np.flatnonzero(np.hypot(cloud[:, 0], cloud[:, 1]) < 2.5)
    rest = np.random.default_rng(seed).choice(len(cloud), 700, replace=False)
    return frozen(cloud[np.union1d(near, rest)])


@functools.cache
def course_cloud_around_the_car():
    cloud = samples.course_cloud()
    return frozen(cloud[np.hypot(cloud[:, 0], cloud[:, 1]) < 3.6])


@hidden(
    "crop_region",
    weight=6,
    title="Crops the course's scan and a street you have not seen",
    hint="Draw your result as in the notebook: no point may be outside the dashed box.",
)
def test_crops_streets(student, seed):
    for cloud in (
        samples.patch_of_course_cloud(seed, 3000),
        samples.obstacles_of_street(seed, 3000),
    ):
        assert_box_filtered(student, "crop_region", cloud, *TALL_REGION)


@hidden(
    "crop_region",
    weight=3,
    title="Crops to boxes you have not seen",
    hint="Compare with minimum and maximum, whatever their values.",
)
def test_crops_to_other_boxes(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 1500)
    for minimum, maximum in random_boxes(seed, tall=True):
        assert_box_filtered(student, "crop_region", cloud, minimum, maximum)


@hidden(
    "crop_region",
    weight=4,
    title="Removes points that are outside in height only",
    hint="Compare all three coordinates: z must be inside as well.",
)
def test_crops_by_height(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 1500)
    for low, high in np.sort(np.random.default_rng(seed).uniform(-2, 1, (3, 2)), axis=1).tolist():
        assert_box_filtered(student, "crop_region", cloud, (-60, -60, low), (60, 60, high + 0.1))


@hidden(
    "crop_region",
    weight=2,
    title="Keeps the coordinates and the intensity of every row",
    hint="Compare only the first three columns, and keep the fourth, the intensity.",
)
def test_crop_keeps_all_columns(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 500) * [1, 1, 1, 255]
    cloud, inside = inside_on_all_axes_or_none(cloud, *REGION)
    assert_all_columns(answer_of(student, "crop_region", cloud, *REGION), cloud, inside)


@hidden(
    "crop_region",
    weight=1,
    title="Keeps the order of the rows, whatever it was",
    hint="Index with a mask, which never changes the order.",
)
def test_crop_keeps_the_order(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 500)
    cloud, inside = inside_on_all_axes_or_none(cloud[np.argsort(-cloud[:, 1])], *REGION)
    assert_order(answer_of(student, "crop_region", cloud, *REGION), cloud, inside)


@hidden(
    "crop_region",
    weight=1,
    title="Works with three columns, float32 and duplicate rows",
    hint="Compare only cloud[:, :3], and index the whole cloud with the mask.",
)
def test_crops_all_kinds_of_clouds(student, seed):
    require_crop(student.crop_region)
    cloud, _ = inside_on_all_axes_or_none(samples.patch_of_course_cloud(seed, 300), *REGION)
    for variant in cloud_variants(cloud):
        assert_box_filtered(student, "crop_region", variant, *REGION)


@hidden(
    "crop_region",
    weight=1,
    title="Works on a single point, and when no point is left",
    hint="Use the same mask for every cloud: one point and none need no special case.",
)
def test_crops_small_clouds(student, seed):
    require_crop(student.crop_region)
    cloud = samples.patch_of_course_cloud(seed, 300)
    columns = as_array(answer_of(student, "crop_region", cloud, *REGION)).shape[-1]
    far = cloud + [200, 200, 200, 0]
    assert_empty_table(answer_of(student, "crop_region", far, *REGION), far, columns)
    assert_box_filtered(student, "crop_region", np.array([[1.0, 2.0, 0.5, 0.1]]), *REGION)


@hidden(
    "crop_region",
    weight=1,
    title="Does not change the cloud or the corners",
    hint="Index with a mask, which creates a new array and leaves the cloud unchanged.",
)
def test_crop_leaves_its_input_unchanged(student, seed):
    require_crop(student.crop_region)
    cloud = samples.patch_of_course_cloud(seed, 200)
    assert_untouched(student.crop_region, cloud, *map(np.array, REGION))


@hidden(
    "remove_ego_returns",
    weight=3,
    title="Removes the ego car from {}",
    hint="Draw your result as in the notebook: the box should be empty, and nothing else should "
    "be missing.",
)
@pytest.mark.parametrize(
    "street", ["course", "fresh"], ids=["the course's scan", "a street you have not seen"]
)
def test_removes_the_ego_car_from_streets(student, seed, street):
    cloud = course_cloud_around_the_car() if street == "course" else scan_around_the_car(seed)
    assert_box_filtered(student, "remove_ego_returns", cloud, *EGO_BOX)


@hidden(
    "remove_ego_returns",
    weight=3,
    title="Works with boxes you have not seen",
    hint="Compare with minimum and maximum, whatever their values.",
)
def test_works_with_other_boxes(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 1500)
    for minimum, maximum in random_boxes(seed + 1, tall=True):
        assert_box_filtered(student, "remove_ego_returns", cloud, minimum, maximum)


@hidden(
    "remove_ego_returns",
    weight=3,
    title="Keeps points that are outside in height only",
    hint="Keep points above and below the box: they are not inside it.",
)
def test_keeps_points_above_and_below(student, seed):
    require_ego_removed(student.remove_ego_returns)
    cloud = samples.patch_of_course_cloud(seed, 1500)
    for minimum, maximum in random_boxes(seed + 2, tall=False):
        assert_box_filtered(student, "remove_ego_returns", cloud, minimum, maximum)


@hidden(
    "remove_ego_returns",
    weight=2,
    title="Keeps the intensity of every row, even up to 255",
    hint="Compare only the first three columns, and keep the fourth, the intensity.",
)
def test_removal_keeps_all_columns(student, seed):
    cloud, inside = inside_on_all_axes_or_none(scan_around_the_car(seed) * [1, 1, 1, 255], *EGO_BOX)
    assert_all_columns(answer_of(student, "remove_ego_returns", cloud, *EGO_BOX), cloud, ~inside)


@hidden(
    "remove_ego_returns",
    weight=1,
    title="Keeps the order of the rows, whatever it was",
    hint="Index with a mask, which never changes the order.",
)
def test_removal_keeps_the_order(student, seed):
    cloud = scan_around_the_car(seed)
    cloud, inside = inside_on_all_axes_or_none(cloud[np.argsort(-cloud[:, 1])], *EGO_BOX)
    assert_order(answer_of(student, "remove_ego_returns", cloud, *EGO_BOX), cloud, ~inside)


@hidden(
    "remove_ego_returns",
    weight=1,
    title="Works with three columns, float32 and duplicate rows",
    hint="Compare only cloud[:, :3], and index the whole cloud with the inverted mask.",
)
def test_removes_from_all_kinds_of_clouds(student, seed):
    require_ego_removed(student.remove_ego_returns)
    cloud, _ = inside_on_all_axes_or_none(scan_around_the_car(seed), *EGO_BOX)
    for variant in cloud_variants(cloud):
        assert_box_filtered(student, "remove_ego_returns", variant, *EGO_BOX)


@hidden(
    "remove_ego_returns",
    weight=1,
    title="Works on a single point, and when no point is left",
    hint="Use the same mask for every cloud: one point and none need no special case.",
)
def test_removes_from_small_clouds(student, seed):
    require_ego_removed(student.remove_ego_returns)
    cloud = scan_around_the_car(seed)
    columns = as_array(answer_of(student, "remove_ego_returns", cloud, *EGO_BOX)).shape[-1]
    low, high = map(np.array, EGO_BOX)
    ours = np.random.default_rng(seed).uniform([*low + 0.05, 0], [*high - 0.05, 1], (50, 4))
    assert_empty_table(answer_of(student, "remove_ego_returns", ours, *EGO_BOX), ours, columns)
    assert_box_filtered(student, "remove_ego_returns", np.array([[9.0, 8.0, 2.2, 0.1]]), *EGO_BOX)


@hidden(
    "remove_ego_returns",
    weight=1,
    title="Does not change the cloud or the corners",
    hint="Index with a mask, which creates a new array and leaves the cloud unchanged.",
)
def test_removal_leaves_its_input_unchanged(student, seed):
    require_ego_removed(student.remove_ego_returns)
    # A patch may contain no returns of the ego car, so an answer could not overwrite any.
    for cloud in (course_cloud_around_the_car(), samples.patch_of_course_cloud(seed, 200)):
        assert_untouched(student.remove_ego_returns, cloud, *map(np.array, EGO_BOX))
