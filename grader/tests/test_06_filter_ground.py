"""Hidden tests of lesson 06. Titles and hints are shown to students; the code is not."""

import numpy as np
import pytest

from grader.judging import samples
from grader.judging.marks import hidden, visible_checks
from utils.checks.vocabulary import assert_rows, assert_same_set_of_rows


@visible_checks("filter_ground", "voxel_grid")
def test_visible(student, check):
    check.run(getattr(student, check.exercise))


@samples.remembered
def kept_by_hand(cloud, level):
    """The right mask, in plain Python; clouds under test have no point at the level itself."""
    return np.array([z > level for z in cloud[:, 2].tolist()], dtype=bool)


def assert_ground_removed(student, cloud, *level):
    cloud = cloud[np.abs(cloud[:, 2] - (level or (-1.2,))[0]) > 1e-4]
    assert_rows(
        student.filter_ground(cloud.copy(), *level), cloud, kept_by_hand(cloud, *(level or (-1.2,)))
    )


@hidden(
    "filter_ground",
    weight=4,
    title="Right on the course's own scan",
    hint="Compare with the picture in the notebook: is the road gone and all else there?",
)
def test_course_cloud(student):
    assert_ground_removed(student, samples.course_cloud())


@hidden(
    "filter_ground",
    weight=4,
    title="Right on a street you have not seen",
    hint="Nothing about one particular cloud may stand in the function.",
)
def test_fresh_street(student, seed):
    assert_ground_removed(student, samples.fresh_street(seed))


@hidden(
    "filter_ground",
    weight=3,
    title="Right at levels you have not seen",
    hint="The level comes from the parameter ground_level and from nowhere else.",
)
def test_other_levels(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 2000)
    for level in np.random.default_rng(seed).uniform(-2.0, 1.0, 4):
        assert_ground_removed(student, cloud, float(level))


@hidden(
    "filter_ground",
    weight=2,
    title="Right with three columns and for any order of points",
    hint="Only column 2 decides; all columns and the order of rows stay.",
)
def test_columns_and_order(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 500)
    assert_ground_removed(student, cloud[:, :3])
    assert_ground_removed(student, cloud[np.argsort(cloud[:, 1])])


@hidden(
    "filter_ground",
    weight=2,
    title="Right for single precision, one point and no result",
    hint="The same two lines serve every case: no special case is needed.",
)
def test_small_and_single(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 300)
    assert_ground_removed(student, cloud.astype(np.float32))
    assert_ground_removed(student, np.asfortranarray(cloud))
    assert_ground_removed(student, cloud[:1])
    assert_ground_removed(student, cloud, 50.0)


@hidden(
    "voxel_grid",
    weight=4,
    title="Right on the course's own scan",
    hint="Print how many points are left for cells of 1 m: too many means that points of one "
    "cell were not merged.",
)
def test_voxels_of_course_cloud(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 3000)
    assert_centroids(student, cloud, 0.2)


@hidden(
    "voxel_grid",
    weight=3,
    title="Right for cells you have not seen, on a fresh street",
    hint="The size comes from the parameter voxel_size and from nowhere else.",
)
@pytest.mark.parametrize("size", [0.35, 1.1])
def test_voxels_of_fresh_street(student, seed, size):
    cloud = samples.obstacles_of_street(seed, 3000)
    assert_centroids(student, cloud, size)


@hidden(
    "voxel_grid",
    weight=2,
    title="Averages every column, intensity too",
    hint="Sum whole rows, not only the coordinates, and divide each by its own count.",
)
def test_voxels_average_every_column(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 400)
    assert_centroids(student, cloud, 5.0)
    assert_centroids(student, cloud[:, :3], 5.0)
    assert_centroids(student, cloud[:1], 0.2)


def assert_centroids(student, cloud, size):
    """Compare with plain Python, away from the borders of cells."""
    offset = cloud[:, :3] / size % 1.0
    cloud = cloud[((offset > 1e-3) & (offset < 1 - 1e-3)).all(axis=1)]
    assert_same_set_of_rows(
        student.voxel_grid(cloud.copy(), size), samples.voxel_centroids(cloud, size)
    )
