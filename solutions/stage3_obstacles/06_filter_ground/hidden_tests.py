"""Hidden tests of lesson 06. Titles and hints are shown to students; the code is not.

Each tests one property. No point is at the ground level or on the border of a cell, and most tests
compare only positions. Only `test_voxels_all_around` has cells on both sides of zero, and only
`test_voxel_borders` has points in the upper halves of cells.
"""

import numpy as np
import pytest

from extension import samples
from grader.judging.hidden_tests import cached_by_content, hidden
from utils.checks.assertions import (
    as_array,
    assert_all_columns,
    assert_nothing_left,
    assert_order,
    assert_same_set_of_rows,
    assert_untouched,
    needs,
)
from utils.checks.lesson_06 import (
    assert_centroids,
    assert_no_ground_left,
    assert_row_per_cell,
    require_ground_removed,
    require_row_per_cell,
)


@cached_by_content
def kept_by_hand(cloud, level):
    """Return the right mask, in plain Python; test clouds have no point at the level itself."""
    return np.array([z > level for z in cloud[:, 2].tolist()], dtype=bool)


def without_ties(cloud, level):
    return cloud[np.abs(cloud[:, 2] - level) > 1e-4]


def assert_ground_removed(student, cloud, level=-1.2):
    cloud = without_ties(cloud, level)
    answer = student.filter_ground(cloud.copy(order="A"), level)
    assert_no_ground_left(answer, cloud, kept_by_hand(cloud, level), level)


@hidden(
    "filter_ground",
    weight=4,
    title="Right on the course's own scan",
    hint="Compare with the picture in the notebook: is the road gone and all else there?",
)
def test_course_cloud(student):
    assert_ground_removed(student, samples.course_cloud()[::5])


@hidden(
    "filter_ground",
    weight=4,
    title="Right on a street you have not seen",
    hint="On every street the rows with z >= ground_level are what is left.",
)
def test_fresh_street(student, seed):
    assert_ground_removed(student, samples.fresh_street(seed)[::5])


@hidden(
    "filter_ground",
    weight=3,
    title="Right at levels you have not seen",
    hint="The rows with z >= ground_level are what is left, whatever the level is.",
)
def test_other_levels(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 2000)
    for level in np.random.default_rng(seed).uniform(-2.0, 1.0, 4):
        assert_ground_removed(student, cloud, float(level))


@hidden(
    "filter_ground",
    weight=2,
    title="Every row keeps its intensity, bright or not",
    hint="Only column 2 decides; all columns stay.",
)
def test_columns(student, seed):
    cloud = without_ties(samples.patch_of_course_cloud(seed, 500) * [1, 1, 1, 255], -1.2)
    assert_all_columns(student.filter_ground(cloud.copy(), -1.2), cloud, kept_by_hand(cloud, -1.2))


@hidden(
    "filter_ground",
    weight=2,
    title="The order of the rows stays, whatever it was",
    hint="A mask keeps the order by itself.",
)
def test_order(student, seed):
    patch = without_ties(samples.patch_of_course_cloud(seed, 500), -1.2)
    for cloud in (patch, patch[np.argsort(-patch[:, 1])]):
        answer = student.filter_ground(cloud.copy(), -1.2)
        assert_order(answer, cloud, kept_by_hand(cloud, -1.2))


@hidden(
    "filter_ground",
    weight=1,
    title="Right for three columns, single precision and rows that occur twice",
    hint="The same two lines serve every case: no special case is needed.",
)
def test_kinds_of_clouds(student, seed):
    require_ground_removed(student.filter_ground)
    cloud = samples.patch_of_course_cloud(seed, 300)
    assert_ground_removed(student, cloud[:, :3])
    assert_ground_removed(student, cloud.astype(np.float32))
    assert_ground_removed(student, np.asfortranarray(cloud))
    assert_ground_removed(student, np.repeat(cloud[:60], 3, axis=0))


@hidden(
    "filter_ground",
    weight=1,
    title="Right for one point and where nothing is left",
    hint="The same two lines serve every case: no special case is needed.",
)
def test_small(student, seed):
    require_ground_removed(student.filter_ground)
    cloud = samples.patch_of_course_cloud(seed, 300)
    columns = as_array(student.filter_ground(cloud.copy(), -1.2)).shape[-1]
    low = cloud - [0, 0, 60, 0]
    assert_nothing_left(student.filter_ground(low.copy(), -1.2), low, columns)
    assert_ground_removed(student, cloud[:1] + [0, 0, 60, 0])


@hidden(
    "filter_ground",
    weight=2,
    title="Never writes into the array that it is given",
    hint="Indexing with a mask makes a new array, and leaves the cloud as it is.",
)
def test_input(student, seed):
    require_ground_removed(student.filter_ground)
    assert_untouched(student.filter_ground, samples.patch_of_course_cloud(seed, 200), -1.2)


def clear_of_borders(cloud, size, highest=1 - 1e-3):
    """Return the rows that are away from cell borders and in the lower part of their cell."""
    offset = cloud[:, :3] / size % 1.0
    return cloud[((offset > 1e-3) & (offset < highest)).all(axis=1)]


def in_lower_halves(cloud, size):
    """Return rows whose cells are the same if an answer rounds or starts at the lowest cell."""
    cloud = clear_of_borders(cloud, size, 0.45)
    lowest = cloud[:1].copy()
    lowest[0, :3] = (np.floor(cloud[:, :3].min(axis=0) / size) + 1e-3) * size
    return np.vstack([cloud, lowest])


def one_corner(cloud, seed):
    """Return the rows of one quadrant below the sensor, so that no coordinate changes its sign."""
    along, across = np.random.default_rng(seed).choice([-1, 1], 2)
    x, y, z = cloud[:, :3].T
    return cloud[(along * x > 0) & (across * y > 0) & (z < 0)]


def mirrored(cloud, size):
    """Return a cloud with additional points in cells whose index is negated along one axis."""
    images = [cloud]
    for axis in range(3):
        image = cloud[axis::3].copy()
        image[:, axis] = size - image[:, axis]
        images.append(image)
    return np.vstack(images)


def evenly_lit(cloud):
    """Return the cloud with the same intensity everywhere."""
    return np.column_stack([cloud[:, :3], np.full(len(cloud), 0.5)])


def assert_thinned(student, cloud, size):
    """Compare the centroids with those from plain Python."""
    cloud = in_lower_halves(cloud, size)
    answer = student.voxel_grid(cloud.copy(order="A"), size)
    assert_centroids(answer, cloud, samples.voxel_centroids(cloud, size), size)


def assert_counted(student, cloud, size):
    """Compare only the number of cells."""
    cloud = in_lower_halves(cloud, size)
    answer = student.voxel_grid(cloud.copy(order="A"), size)
    assert_row_per_cell(answer, cloud, len(samples.voxel_centroids(cloud, size)), size)


@hidden(
    "voxel_grid",
    weight=11,
    title="Right on a quarter of the course's own scan",
    hint="There is one row for each occupied cell: the mean of its points.",
)
def test_voxels_of_course_cloud(student, seed):
    cloud = one_corner(samples.patch_of_course_cloud(seed, 9000), seed)
    assert_thinned(student, evenly_lit(cloud), 0.2)


@hidden(
    "voxel_grid",
    weight=11,
    title="Right on a quarter of a street that you have not seen",
    hint="On every street there is one row for each occupied cell: the mean of its points.",
)
def test_voxels_of_fresh_street(student, seed):
    cloud = one_corner(samples.obstacles_of_street(seed, 9000), seed)
    assert_thinned(student, evenly_lit(cloud), 0.2)


@hidden(
    "voxel_grid",
    weight=5,
    title="As many points as cells, for a {} size that you have not seen",
    hint="Cells are voxel_size wide, whatever the size is.",
)
@pytest.mark.parametrize("size", [0.35, 1.1], ids=["small", "large"])
def test_voxel_sizes(student, seed, size):
    cloud = one_corner(samples.obstacles_of_street(seed, 9000), seed)
    assert_counted(student, evenly_lit(cloud), size)


@hidden(
    "voxel_grid",
    weight=4,
    title="As many points as cells all around the sensor, above and below it",
    hint="On both sides of zero the cell is floor(xyz / voxel_size).",
)
def test_voxels_all_around(student, seed):
    street = samples.obstacles_of_street(seed, 6000)
    assert_counted(student, evenly_lit(street), 0.2)
    assert_counted(student, evenly_lit(mirrored(street[::10], 0.2)), 0.2)


@hidden(
    "voxel_grid",
    weight=3,
    title="Cells begin at multiples of voxel_size, wherever the points lie",
    hint="The cell is floor(xyz / voxel_size).",
)
def test_voxel_borders(student, seed):
    require_row_per_cell(student.voxel_grid)
    cloud = evenly_lit(one_corner(samples.patch_of_course_cloud(seed, 9000), seed))
    cloud = clear_of_borders(cloud, 0.2)
    answer = student.voxel_grid(cloud.copy(), 0.2)
    assert_row_per_cell(answer, cloud, len(samples.voxel_centroids(cloud, 0.2)), 0.2)


@hidden(
    "voxel_grid",
    weight=3,
    title="Averages the intensity as it averages the coordinates",
    hint="The mean of a cell is one of whole rows: all columns.",
)
def test_voxels_average_the_intensity(student, seed):
    # If an answer uses the intensities as coordinates, all are in one cell, as they are so low.
    cloud = one_corner(samples.patch_of_course_cloud(seed, 9000), seed) * [1, 1, 1, 0.19]
    cloud = in_lower_halves(cloud, 0.2)
    expected, answer = samples.voxel_centroids(cloud, 0.2), student.voxel_grid(cloud.copy(), 0.2)
    with needs("there is one point per occupied cell, the mean of its points"):
        assert_centroids(answer, cloud, expected, 0.2)
    assert_same_set_of_rows(answer, expected)


@hidden(
    "voxel_grid",
    weight=4,
    title="The same cells whatever the intensities",
    hint="x, y and z alone decide about the cell.",
)
def test_voxels_of_bright_points(student, seed):
    require_row_per_cell(student.voxel_grid)
    cloud = one_corner(samples.patch_of_course_cloud(seed, 9000), seed)
    assert_counted(student, cloud, 0.2)
    assert_counted(student, cloud * [1, 1, 1, 255], 0.2)


@hidden(
    "voxel_grid",
    weight=2,
    title="Right for three columns, single precision, one point, and many points in one cell",
    hint="The same lines serve every case; only an empty cloud needs one of its own.",
)
def test_voxels_of_other_clouds(student, seed):
    require_row_per_cell(student.voxel_grid)
    cloud = evenly_lit(one_corner(samples.patch_of_course_cloud(seed, 9000), seed))
    cloud = in_lower_halves(cloud, 0.2)
    for form in (
        cloud[:, :3],
        np.asfortranarray(cloud),
        cloud.astype(np.float32),
        cloud[-1:],
        np.repeat(cloud[-40:], 50, axis=0),
    ):
        answer = student.voxel_grid(form.copy(order="A"), 0.2)
        assert_row_per_cell(answer, form, len(samples.voxel_centroids(form, 0.2)), 0.2)


@hidden(
    "voxel_grid",
    weight=2,
    title="Never writes into the array that it is given",
    hint="The caller's cloud is afterwards what it was before.",
)
def test_voxels_input(student, seed):
    require_row_per_cell(student.voxel_grid)
    assert_untouched(student.voxel_grid, samples.patch_of_course_cloud(seed, 200), 0.2)
