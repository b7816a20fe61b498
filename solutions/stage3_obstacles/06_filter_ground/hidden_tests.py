"""Hidden tests of lesson 06. Students see the titles and hints but not the code.

Each test covers one property. No point is at the ground level or on the border of a cell, and
most tests compare only positions. Only `test_counts_cells_on_all_sides` has cells on both sides of
zero, and only `test_starts_cells_at_multiples` has points in the upper halves of cells.
"""

import numpy as np
import pytest

from extension import samples
from grader.judging.hidden_tests import cached_by_content, hidden
from utils.checks.assertions import (
    as_array,
    assert_all_columns,
    assert_empty_table,
    assert_order,
    assert_same_set_of_rows,
    assert_untouched,
    precondition,
)
from utils.checks.lesson_06 import (
    assert_centroids,
    assert_no_ground_left,
    assert_row_per_cell,
    require_ground_removed,
    require_row_per_cell,
)


@cached_by_content
def expected_mask(cloud, level):
    """Compute the right mask in plain Python. No point may be exactly at the level."""
    return np.array([z > level for z in cloud[:, 2].tolist()], dtype=bool)


def drop_ties(cloud, level):
    return cloud[np.abs(cloud[:, 2] - level) > 1e-4]


def assert_ground_removed(student, cloud, level=-1.2):
    cloud = drop_ties(cloud, level)
    answer = student.filter_ground(cloud.copy(order="A"), level)
    assert_no_ground_left(answer, cloud, expected_mask(cloud, level), level)


@hidden(
    "filter_ground",
    weight=4,
    title="Removes the ground from the course's scan",
    hint="Draw your result as the notebook does: the road must be gone, and everything else must "
    "still be there.",
)
def test_filters_the_course_scan(student):
    assert_ground_removed(student, samples.course_cloud()[::5])


@hidden(
    "filter_ground",
    weight=4,
    title="Removes the ground from a street you have not seen",
    hint="Keep the rows with z >= ground_level, on any street.",
)
def test_filters_a_new_street(student, seed):
    assert_ground_removed(student, samples.fresh_street(seed)[::5])


@hidden(
    "filter_ground",
    weight=3,
    title="Works for ground levels you have not seen",
    hint="Keep the rows with z >= ground_level, whatever the level is.",
)
def test_works_at_other_levels(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 2000)
    for level in np.random.default_rng(seed).uniform(-2.0, 1.0, 4):
        assert_ground_removed(student, cloud, float(level))


@hidden(
    "filter_ground",
    weight=2,
    title="Keeps the intensity of every row, even up to 255",
    hint="Compare only column 2, and keep all columns.",
)
def test_keeps_all_columns(student, seed):
    cloud = drop_ties(samples.patch_of_course_cloud(seed, 500) * [1, 1, 1, 255], -1.2)
    assert_all_columns(student.filter_ground(cloud.copy(), -1.2), cloud, expected_mask(cloud, -1.2))


@hidden(
    "filter_ground",
    weight=2,
    title="Keeps the order of the rows, whatever it was",
    hint="Index with a mask: it never changes the order.",
)
def test_keeps_the_order(student, seed):
    patch = drop_ties(samples.patch_of_course_cloud(seed, 500), -1.2)
    for cloud in (patch, patch[np.argsort(-patch[:, 1])]):
        answer = student.filter_ground(cloud.copy(), -1.2)
        assert_order(answer, cloud, expected_mask(cloud, -1.2))


@hidden(
    "filter_ground",
    weight=1,
    title="Works with three columns, float32 and duplicate rows",
    hint="Use the same mask for every cloud, without a special case.",
)
def test_works_on_all_kinds_of_clouds(student, seed):
    require_ground_removed(student.filter_ground)
    cloud = samples.patch_of_course_cloud(seed, 300)
    assert_ground_removed(student, cloud[:, :3])
    assert_ground_removed(student, cloud.astype(np.float32))
    assert_ground_removed(student, np.repeat(cloud[:60], 3, axis=0))


@hidden(
    "filter_ground",
    weight=1,
    title="Works on a single point, and when no point is left",
    hint="Use the same mask for every cloud, without a special case.",
)
def test_works_on_small_clouds(student, seed):
    require_ground_removed(student.filter_ground)
    cloud = samples.patch_of_course_cloud(seed, 300)
    columns = as_array(student.filter_ground(cloud.copy(), -1.2)).shape[-1]
    low = cloud - [0, 0, 60, 0]
    assert_empty_table(student.filter_ground(low.copy(), -1.2), low, columns)
    assert_ground_removed(student, cloud[:1] + [0, 0, 60, 0])


@hidden(
    "filter_ground",
    weight=2,
    title="Does not change a cloud from the course's scan",
    hint="Index with a mask, which makes a new array and leaves the cloud unchanged.",
)
def test_leaves_its_input_unchanged(student, seed):
    require_ground_removed(student.filter_ground)
    assert_untouched(student.filter_ground, samples.patch_of_course_cloud(seed, 200), -1.2)


def rows_clear_of_borders(cloud, size, highest=1 - 1e-3):
    """Return the rows whose offset in their cell is between 0.001 and `highest` on all axes."""
    offset = cloud[:, :3] / size % 1.0
    return cloud[((offset > 1e-3) & (offset < highest)).all(axis=1)]


def rows_in_lower_halves(cloud, size):
    """Return rows that get the same cells even if an answer rounds, or counts from the minimum."""
    cloud = rows_clear_of_borders(cloud, size, 0.45)
    lowest = cloud[:1].copy()
    lowest[0, :3] = (np.floor(cloud[:, :3].min(axis=0) / size) + 1e-3) * size
    return np.vstack([cloud, lowest])


def rows_of_one_quadrant(cloud, seed):
    """Return the rows of a random quadrant below the sensor, where each axis has one sign."""
    sign_x, sign_y = np.random.default_rng(seed).choice([-1, 1], 2)
    x, y, z = cloud[:, :3].T
    return cloud[(sign_x * x > 0) & (sign_y * y > 0) & (z < 0)]


def add_mirror_images(cloud, size):
    """Add mirror images of points, so that there are cells on both sides of zero on all axes."""
    images = [cloud]
    for axis in range(3):
        image = cloud[axis::3].copy()
        image[:, axis] = size - image[:, axis]
        images.append(image)
    return np.vstack(images)


def with_equal_intensities(cloud):
    """Return the cloud with the intensity 0.5 in all rows."""
    return np.column_stack([cloud[:, :3], np.full(len(cloud), 0.5)])


def assert_thinned(student, cloud, size):
    """Compare the answer for a cloud with centroids computed in plain Python."""
    cloud = rows_in_lower_halves(cloud, size)
    answer = student.voxel_grid(cloud.copy(order="A"), size)
    assert_centroids(answer, cloud, samples.voxel_centroids(cloud, size), size)


def assert_row_count(student, cloud, size):
    """Check only the number of rows, one per occupied cell."""
    cloud = rows_in_lower_halves(cloud, size)
    answer = student.voxel_grid(cloud.copy(order="A"), size)
    assert_row_per_cell(answer, cloud, len(samples.voxel_centroids(cloud, size)), size)


@hidden(
    "voxel_grid",
    weight=11,
    title="Thins out one quadrant of the course's scan",
    hint="Return one row per occupied cell: the mean of its points.",
)
def test_thins_the_course_scan(student, seed):
    cloud = rows_of_one_quadrant(samples.patch_of_course_cloud(seed, 9000), seed)
    assert_thinned(student, with_equal_intensities(cloud), 0.2)


@hidden(
    "voxel_grid",
    weight=11,
    title="Thins out one quadrant of a street you have not seen",
    hint="On every street, return one row per occupied cell: the mean of its points.",
)
def test_thins_a_new_street(student, seed):
    cloud = rows_of_one_quadrant(samples.obstacles_of_street(seed, 9000), seed)
    assert_thinned(student, with_equal_intensities(cloud), 0.2)


@hidden(
    "voxel_grid",
    weight=5,
    title="Returns one point per cell for a {} cell size you have not seen",
    hint="Make the cells voxel_size wide, whatever its value.",
)
@pytest.mark.parametrize("size", [0.35, 1.1], ids=["small", "large"])
def test_works_with_other_voxel_sizes(student, seed, size):
    cloud = rows_of_one_quadrant(samples.obstacles_of_street(seed, 9000), seed)
    assert_row_count(student, with_equal_intensities(cloud), size)


@hidden(
    "voxel_grid",
    weight=4,
    title="Returns one point per cell on all sides of the sensor",
    hint="Compute the cell as floor(xyz / voxel_size) on both sides of zero.",
)
def test_counts_cells_on_all_sides(student, seed):
    street = samples.obstacles_of_street(seed, 6000)
    assert_row_count(student, with_equal_intensities(street), 0.2)
    assert_row_count(student, with_equal_intensities(add_mirror_images(street[::10], 0.2)), 0.2)


@hidden(
    "voxel_grid",
    weight=3,
    title="Starts cells at multiples of voxel_size, wherever the points are",
    hint="Compute the cell as floor(xyz / voxel_size).",
)
def test_starts_cells_at_multiples(student, seed):
    require_row_per_cell(student.voxel_grid)
    cloud = with_equal_intensities(
        rows_of_one_quadrant(samples.patch_of_course_cloud(seed, 9000), seed)
    )
    cloud = rows_clear_of_borders(cloud, 0.2)
    answer = student.voxel_grid(cloud.copy(), 0.2)
    assert_row_per_cell(answer, cloud, len(samples.voxel_centroids(cloud, 0.2)), 0.2)


@hidden(
    "voxel_grid",
    weight=3,
    title="Averages the intensity in the same way as the coordinates",
    hint="Take the mean of whole rows, with all their columns.",
)
def test_averages_the_intensity(student, seed):
    # Intensities below the cell size do not change the cell of an answer that includes them.
    cloud = rows_of_one_quadrant(samples.patch_of_course_cloud(seed, 9000), seed) * [1, 1, 1, 0.19]
    cloud = rows_in_lower_halves(cloud, 0.2)
    expected, answer = samples.voxel_centroids(cloud, 0.2), student.voxel_grid(cloud.copy(), 0.2)
    with precondition("there is one point per occupied cell, the mean of its points"):
        assert_centroids(answer, cloud, expected, 0.2)
    assert_same_set_of_rows(answer, expected)


@hidden(
    "voxel_grid",
    weight=4,
    title="Finds the same cells, whatever the intensities",
    hint="Compute the cell from x, y and z only.",
)
def test_ignores_bright_intensities(student, seed):
    require_row_per_cell(student.voxel_grid)
    cloud = rows_of_one_quadrant(samples.patch_of_course_cloud(seed, 9000), seed)
    assert_row_count(student, cloud, 0.2)
    assert_row_count(student, cloud * [1, 1, 1, 255], 0.2)


@hidden(
    "voxel_grid",
    weight=2,
    title="Works with three columns, float32, a single point, and many points in one cell",
    hint="Use the same lines for every cloud: only an empty cloud may need a special case.",
)
def test_thins_all_kinds_of_clouds(student, seed):
    require_row_per_cell(student.voxel_grid)
    cloud = with_equal_intensities(
        rows_of_one_quadrant(samples.patch_of_course_cloud(seed, 9000), seed)
    )
    cloud = rows_in_lower_halves(cloud, 0.2)
    for form in (
        cloud[:, :3],
        cloud.astype(np.float32),
        cloud[-1:],
        np.repeat(cloud[-40:], 50, axis=0),
    ):
        answer = student.voxel_grid(form.copy(order="A"), 0.2)
        assert_row_per_cell(answer, form, len(samples.voxel_centroids(form, 0.2)), 0.2)


@hidden(
    "voxel_grid",
    weight=2,
    title="Does not change a cloud from the course's scan",
    hint="Leave the caller's cloud unchanged: write into a new array.",
)
def test_voxel_grid_leaves_its_input_unchanged(student, seed):
    require_row_per_cell(student.voxel_grid)
    assert_untouched(student.voxel_grid, samples.patch_of_course_cloud(seed, 200), 0.2)
