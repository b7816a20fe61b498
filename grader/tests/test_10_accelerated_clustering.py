"""Hidden tests of lesson 10. Titles and hints are shown to students; the code is not.

Small clouds come first and big ones last: an answer that hangs or bursts on the big ones is
stopped there, and keeps what it has earned.
"""

import functools

import numpy as np

from grader.judging import samples
from grader.judging.marks import hidden, visible_checks
from grader.sandbox.student import StudentStopped
from utils.checks.vocabulary import CheckFailed, assert_partition

NAME = "euclidean_clustering_accelerated"


@visible_checks(NAME)
def test_visible(student, check):
    check.run(student.euclidean_clustering_accelerated)


def assert_clusters(student, cloud, *threshold):
    radius = (threshold or (0.5,))[0]
    cloud = samples.without_ties(cloud, radius)
    assert_partition(
        student.euclidean_clustering_accelerated(cloud.copy(), *threshold),
        samples.cluster_labels(cloud, radius),
        cloud,
    )


@hidden(
    NAME,
    weight=5,
    title="Right on obstacles of the course's own scan",
    hint="Compare with your euclidean_clustering of lesson 05: same partition?",
)
def test_course_cloud(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 6000)
    assert_clusters(student, cloud[cloud[:, 2] > -1.1][:1500])


@hidden(
    NAME,
    weight=5,
    title="Right on streets you have not seen",
    hint="Nothing about one particular cloud may stand in the function.",
)
def test_fresh_streets(student, seed):
    for street in range(2):
        assert_clusters(student, samples.obstacles_of_street(seed + street, 1200))


@hidden(
    NAME,
    weight=4,
    title="Right at thresholds you have not seen, small and large",
    hint="Side, neighbours and distances all follow the parameter threshold.",
)
def test_other_thresholds(student, seed):
    cloud = samples.obstacles_of_street(seed, 600)
    for threshold in np.random.default_rng(seed).uniform(0.1, 2.5, 4):
        assert_clusters(student, cloud, float(threshold))
    assert_clusters(student, cloud, 25.0)


@hidden(
    NAME,
    weight=4,
    title="Exact where many points crowd into few cells",
    hint="Two cells belong together if ANY point of one is close to ANY point of the other.",
)
def test_crowded_cells(student, seed):
    # Lumps of 25 points whose gaps lie around the threshold: representatives decide nothing.
    rng = np.random.default_rng(seed)
    for _ in range(4):
        middles = np.cumsum(rng.uniform(0.4, 0.95, (16, 1)) * _directions(rng, 16), axis=0)
        cloud = np.vstack([middle + 0.18 * _directions(rng, 25) for middle in middles])
        assert_clusters(student, cloud[rng.permutation(len(cloud))])


@hidden(
    NAME,
    weight=3,
    title="Long winding chains stay whole",
    hint="Joining goes on from cell to cell, as far as it reaches.",
)
def test_long_chain(student, seed):
    rng = np.random.default_rng(seed)
    angle = np.cumsum(np.full(1500, 0.3) / (2.0 + 0.02 * np.arange(1500)))
    radius = 2.0 + 1.2 * angle / np.pi
    spiral = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle])
    cloud = np.vstack([spiral, spiral[:40] + [0, 0, 5]])
    assert_clusters(student, cloud[rng.permutation(len(cloud))])


@hidden(
    NAME,
    weight=3,
    title="The order, place and turn of the cloud do not matter",
    hint="Moving the cloud by 10 cm moves every border of a cell; the clusters must stay.",
)
def test_invariance(student, seed):
    rng = np.random.default_rng(seed)
    cloud = samples.obstacles_of_street(seed, 500)[:, :3]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    assert_clusters(student, cloud[rng.permutation(len(cloud))])
    assert_clusters(student, cloud @ turn.T + rng.uniform(-50, 50, 3))
    assert_clusters(student, cloud + rng.uniform(-0.3, 0.3, 3))


@hidden(
    NAME,
    weight=3,
    title="Right for single precision, all in one and all alone",
    hint="Clouds may be flat, tiny or all in one cell: then lists of pairs are empty.",
)
def test_extremes(student, seed):
    rng = np.random.default_rng(seed)
    cloud = samples.obstacles_of_street(seed, 300)
    assert_clusters(student, cloud.astype(np.float32))
    assert_clusters(student, np.asfortranarray(cloud))
    assert_clusters(student, rng.uniform(0, 1, (60, 3)), 3.0)
    assert_clusters(student, rng.uniform(-100, 100, (600, 4)), 0.05)  # more than 255
    assert_clusters(student, np.repeat(rng.uniform(-9, 9, (5, 3)), 4, axis=0), 0.5)
    assert_clusters(student, rng.uniform(-3, 3, (200, 3)) * [1, 1, 0], 0.5)


# ------------------------------------------------------------------------------ big clouds


def answer_in_time(student, cloud, threshold, advice):
    """The answer, or a failure that says what to do when the process had to be stopped."""
    try:
        return student.euclidean_clustering_accelerated(cloud, threshold)
    except StudentStopped as stopped:
        raise CheckFailed(f"{len(cloud):,} points. {stopped} {advice}") from None


@functools.lru_cache(maxsize=16)
def whole_scan(seed):
    """All obstacles of a fresh street, one return per 3 cm: about 50 000 points. Read-only."""
    cloud = samples.fresh_street(seed)
    cloud = cloud[cloud[:, 2] > -1.2]
    places = np.unique(np.floor(cloud[:, :3] / 0.03), axis=0, return_index=True)[1]
    return cloud[np.sort(places)]


@hidden(
    NAME,
    weight=5,
    title="A whole scan, exactly and in time",
    hint="Time your function on all points of cloud.txt above the road. Which line takes most "
    "of it? Loops over points, and lists of neighbours of every point, are too long.",
)
def test_whole_scan(student, seed):
    cloud = whole_scan(seed)
    for threshold in 0.5 + 0.004 * np.arange(20):
        answer = answer_in_time(
            student,
            cloud.copy(),
            float(threshold),
            "A scan must be answered in time: work with cells instead of points.",
        )
        # The answer comes first: an oracle for many points is slow, and not all need it. Where
        # a cluster hangs by a hair at this threshold, single precision may differ: take another.
        labels = samples.cluster_labels(cloud, threshold - 1e-4)
        if np.array_equal(labels, samples.cluster_labels(cloud, threshold + 1e-4)):
            assert_partition(answer, labels, cloud)
            return
    raise RuntimeError(f"No clear threshold for the street of seed {seed}")


@hidden(
    NAME,
    weight=5,
    title="Four heaps of ten thousand points, exactly and in little memory",
    hint="In a heap everybody is near everybody: a list of all pairs is as long as the square "
    "of its points. Points that share a cell need no pair, and two crowded cells need "
    "only their closest pair: a KD-tree of the one, asked by the other.",
)
def test_heaps(student, seed):
    # Cubes of 0.2 m: all pairs inside are near. The first two are 0.45 m apart, the others 0.55.
    rng = np.random.default_rng(seed)
    heaps = rng.uniform(0, 0.2, (4, 10_000, 3))
    heaps[[0, 2], 0] = [0.2, 0.1, 0.1]
    heaps[[1, 3], 0] = [0.0, 0.1, 0.1]
    heaps += np.array([[0, 0, 0], [0.65, 0, 0], [0, 5, 0], [0.75, 5, 0]])[:, None]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    order = rng.permutation(40_000)
    cloud = (heaps.reshape(-1, 3) @ turn.T + rng.uniform(-5, 5, 3))[order]
    answer = answer_in_time(
        student,
        cloud.copy(),
        0.5,
        "Points in heaps must not be compared pair by pair: whoever shares a "
        "small cell belongs together anyway.",
    )
    assert_partition(answer, np.repeat([1, 1, 2, 3], 10_000)[order], cloud)


def _directions(rng, n):
    way = rng.normal(size=(n, 3))
    return way / np.linalg.norm(way, axis=1, keepdims=True)
