"""The samples and oracles of hidden tests agree with other libraries and plain loops."""

import hashlib
import itertools
from collections import Counter

import numpy as np
import pytest
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import pdist, squareform

from extension import samples
from grader.course.paths import PROJECT
from grader.judging import hidden_tests
from grader.judging.hidden_tests import cached_by_content, generator_for_students


@pytest.fixture
def counted_oracle():
    """Return a cached oracle, and a list of its calls."""
    calls = []

    @cached_by_content
    def doubled(cloud, *settings):
        """Return twice the cloud."""
        calls.append((cloud.shape, settings))
        return 2 * cloud

    return doubled, calls


def test_an_oracle_runs_once_for_each_content(counted_oracle):
    doubled, calls = counted_oracle
    cloud = np.arange(12.0).reshape(4, 3)
    first = doubled(cloud, 0.5)
    assert np.array_equal(first, 2 * cloud) and doubled.__doc__ == "Return twice the cloud."
    assert doubled(cloud.copy(), 0.5) is first is doubled(np.asfortranarray(cloud), 0.5)
    assert len(calls) == 1
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 7
    # Other clouds need a new result, and so do the same bytes in another shape or type.
    others = [cloud.reshape(3, 4), cloud.view(np.int64), cloud + 1, cloud[:0], cloud[:0, :2]]
    for other in others:
        assert np.array_equal(doubled(other, 0.5), 2 * other)
    assert doubled(cloud, 0.25) is not first
    assert len(calls) == 1 + len(others) + 1
    assert doubled(cloud, 0.5) is first


def test_the_cache_of_an_oracle_is_bounded(counted_oracle, monkeypatch):
    assert 100 <= hidden_tests.MAX_CACHED_ANSWERS <= 1000
    monkeypatch.setattr(hidden_tests, "MAX_CACHED_ANSWERS", 3)
    doubled, calls = counted_oracle
    clouds = [np.full((2, 3), float(number)) for number in range(4)]
    for cloud in clouds[:3] * 2:
        doubled(cloud)
    assert len(calls) == 3
    doubled(clouds[3])  # only the oldest entry is dropped
    for cloud in clouds[1:]:
        doubled(cloud)
    assert len(calls) == 4
    doubled(clouds[0])
    assert len(calls) == 5


def test_every_slow_oracle_is_cached():
    cloud = np.random.default_rng(7).uniform(0, 2, (30, 4))
    for oracle in (samples.cluster_labels, samples.remove_ties, samples.voxel_centroids):
        answer = oracle(cloud, 0.5)
        assert oracle(cloud.copy(), 0.5) is answer and not answer.flags.writeable
    assert samples.course_cloud() is samples.course_cloud()


def test_a_generator_for_students_is_drawn_from_a_digest():
    state = generator_for_students(20_170_405, "steps").bit_generator.state
    digest = hashlib.sha256(b"for students: 20170405 steps").hexdigest()
    assert state == np.random.default_rng(int(digest, 16)).bit_generator.state
    for seed, label in ((20_170_406, "steps"), (20_170_405, "step")):
        other = generator_for_students(seed, label)
        assert other.bit_generator.state != state


def assert_rows_of(part, cloud):
    """Assert that a cloud contains each row of a part at least as often as the part does."""
    assert Counter(map(bytes, part)) <= Counter(map(bytes, cloud))


@pytest.mark.parametrize("columns", [3, 4])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_labels_of_clusters_are_single_linkage(columns, dtype):
    rng = np.random.default_rng(3)
    cloud = rng.uniform(-3, 3, (180, columns)).astype(dtype)
    cloud[:, 3:] *= 100  # intensity is not a coordinate
    labels = samples.cluster_labels(samples.remove_ties(cloud, 0.7), 0.7)
    near = samples.remove_ties(cloud, 0.7)[:, :3].astype(float)
    expected = fcluster(linkage(near, "single"), 0.7, "distance")
    assert len(near) > 170 and 10 < labels.max() < 120 and labels.min() == 1
    pairs = set(zip(labels.tolist(), expected.tolist(), strict=True))
    assert len(pairs) == labels.max() == expected.max()


def test_one_point_is_one_cluster_and_an_empty_cloud_has_none():
    lonely = np.array([[0.0, 0, 0], [9, 9, 9], [0, 0.2, 0.1]])
    assert samples.cluster_labels(lonely, 0.5).tolist() == [1, 2, 1]
    for columns in (3, 4):
        labels = samples.cluster_labels(np.empty((0, columns)), 0.5)
        assert labels.shape == (0,) and labels.dtype.kind == "i"


@pytest.mark.parametrize("columns", [3, 4])
def test_no_two_points_remain_at_the_threshold(columns):
    cloud = np.random.default_rng(9).uniform(0, 4, (400, columns))
    cloud[:, 3:] *= 100
    kept = samples.remove_ties(cloud, 0.8, 5e-3)
    assert (np.abs(pdist(kept[:, :3]) - 0.8) > 5e-3).all()
    assert_rows_of(kept, cloud)
    # In each pair with a distance near the threshold, only the later point is removed.
    doubtful = np.abs(squareform(pdist(cloud[:, :3])) - 0.8) < 5e-3
    removed = np.triu(doubtful).any(axis=0)
    assert 20 < removed.sum() < 200 and np.array_equal(kept, cloud[~removed])


def test_the_default_margin_is_a_millimetre():
    line = np.array([[0.0, 0, 0], [0.7009, 0, 0], [0, 0.7011, 0], [0, 0, 0.6991], [-0.6989, 0, 0]])
    assert samples.remove_ties(line, 0.7).tolist() == line[[0, 2, 4]].tolist()
    assert samples.remove_ties(line[:0], 0.7).shape == (0, 3)


@pytest.mark.parametrize("columns", [3, 4])
def test_centroids_of_voxels_agree_with_a_loop(columns):
    cloud = np.random.default_rng(4).uniform(-1, 1, (150, columns))
    voxels = samples.voxel_centroids(cloud, 0.5)
    cells = np.floor(cloud[:, :3] / 0.5)
    expected = [
        cloud[(cells == cell).all(axis=1)].mean(axis=0)
        for cell in itertools.product(range(-2, 2), repeat=3)
        if (cells == cell).all(axis=1).any()
    ]
    assert len(voxels) == len(expected) > 50
    order = np.lexsort(voxels.T), np.lexsort(np.array(expected).T)
    assert np.allclose(voxels[order[0]], np.array(expected)[order[1]], atol=1e-12)
    assert samples.voxel_centroids(cloud[:0], 0.5).shape == (0, columns)
    # Another dtype shows that the function does not confuse bytes with columns.
    assert np.allclose(samples.voxel_centroids(cloud.astype(np.float32), 0.5), voxels, atol=1e-6)


def test_a_patch_contains_rows_of_the_course_cloud():
    cloud = samples.course_cloud()
    assert np.array_equal(cloud, np.loadtxt(PROJECT / "data" / "cloud.txt"))
    patch = samples.patch_of_course_cloud(5, 700)
    assert patch.shape == (700, cloud.shape[1])
    assert_rows_of(patch, cloud)
    distance = np.sqrt(patch[:, 0] ** 2 + patch[:, 1] ** 2)
    assert 24 < distance.max() < 25
    assert np.array_equal(samples.patch_of_course_cloud.__wrapped__(5, 700), patch)
    assert not np.array_equal(samples.patch_of_course_cloud(6, 700), patch)
    everywhere = np.sqrt(cloud[:, 0] ** 2 + cloud[:, 1] ** 2) < 25
    assert len(samples.patch_of_course_cloud(5, everywhere.sum())) == everywhere.sum()
    for kept in (cloud, patch):
        assert not kept.flags.writeable


def test_obstacles_are_near_rows_of_the_street_above_the_road():
    street = samples.fresh_street(8)
    assert samples.fresh_street(8) is street
    assert street.ndim == 2 and street.shape[1] == 4 and not street.flags.writeable
    wanted = (np.sqrt(street[:, 0] ** 2 + street[:, 1] ** 2) < 20) & (street[:, 2] > -1)
    assert (street[:, 2] < -1).any() and wanted.sum() > 500
    some = samples.obstacles_of_street(8, 400)
    assert len(some) == 400 and not some.flags.writeable
    assert_rows_of(some, street[wanted])
    assert np.array_equal(samples.obstacles_of_street.__wrapped__(8, 400), some)
    everything = samples.obstacles_of_street(8, 10**7)
    assert len(everything) == wanted.sum()
    assert_rows_of(everything, street[wanted])
    assert not np.array_equal(everything, street[wanted])  # a patch's rows are in random order
