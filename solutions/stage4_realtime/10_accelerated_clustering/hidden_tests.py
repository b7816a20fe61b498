"""Hidden tests of lesson 10. Students see the titles and hints but not the code.

The tests of small clouds come first. If an answer takes too much time or memory on a large cloud,
the judge stops it there, and it keeps the points that it has earned. Two tests of large clouds also
check that the clusters are exact.
"""

import functools

import numpy as np

from extension import samples
from grader.judging.hidden_tests import hidden
from grader.sandbox.failures import StudentStopped
from utils.checks.assertions import CheckFailed, assert_partition, frozen
from utils.checks.clusters import require_simplest_clusters
from utils.checks.lesson_10.accelerated import assert_timed_clusters

NAME = "euclidean_clustering_accelerated"


def assert_clusters(student, cloud, threshold=0.5):
    cloud = samples.remove_ties(cloud, threshold)
    assert_partition(
        student.euclidean_clustering_accelerated(cloud.copy(), threshold),
        samples.cluster_labels(cloud, threshold),
        cloud,
    )


@hidden(
    NAME,
    weight=12,
    title="Finds the exact clusters in the course's scan",
    hint="Compare your clusters with those of join_all_pairs on the same points. If they differ, "
    "draw both.",
)
def test_course_cloud(student, seed):
    cloud = samples.course_cloud()
    far = cloud[(np.hypot(cloud[:, 0], cloud[:, 1]) > 15) & (cloud[:, 2] > -1.1)]
    angle = np.arctan2(far[:, 1], far[:, 0])
    start = np.random.default_rng(seed).uniform(0, 2 * np.pi)
    # The rows are not thinned or shuffled, but stay in the order of the scanner.
    order = np.argsort((angle - start) % (2 * np.pi), kind="stable")
    assert_clusters(student, far[np.sort(order[:2500])])


@hidden(
    NAME,
    weight=12,
    title="Finds the exact clusters on new streets",
    hint="Take every tenth point of cloud.txt in random order, compare your clusters with those "
    "of join_all_pairs, and look for clusters that are split or merged.",
)
def test_fresh_streets(student, seed):
    for street in range(2):
        assert_clusters(student, samples.obstacles_of_street(seed + street, 1200)[:, :3])


@hidden(
    NAME,
    weight=32,
    title="Finds the exact clusters at small and large thresholds",
    hint="Use the parameter threshold for the side of a cell and in every comparison of distances.",
)
def test_other_thresholds(student, seed):
    cloud = samples.obstacles_of_street(seed, 600)[:, :3]
    for threshold in np.random.default_rng(seed).uniform(
        [0.1, 0.1, 1.2, 1.2], [1.0, 1.0, 2.5, 2.5]
    ):
        assert_clusters(student, cloud, float(threshold))
    assert_clusters(student, cloud, 25.0)


@hidden(
    NAME,
    weight=6,
    title="Finds the exact clusters when many points are in a few cells",
    hint="Join two cells if any point of one is closer than the threshold to any point of the "
    "other.",
)
def test_crowded_cells(student, seed):
    # The gaps between lumps of 25 points are close to the threshold, so it is not enough to compare
    # one point per cell. Some answers take the square root of the threshold by mistake, which makes
    # 0.5 m larger and 4 m smaller.
    rng = np.random.default_rng(seed)
    for threshold in (0.5, 0.5, 4.0, 4.0):
        middles = np.cumsum(rng.uniform(0.4, 0.95, (40, 1)) * _directions(rng, 40), axis=0)
        cloud = np.vstack([middle + 0.18 * _directions(rng, 25) for middle in middles])
        cloud = cloud[rng.permutation(len(cloud))] * (threshold / 0.5)
        assert_clusters(student, cloud, threshold)


@hidden(
    NAME,
    weight=3,
    title="Does not join two points that are slightly farther apart than the threshold, wherever "
    "they are",
    hint="Make the side of a cell threshold / np.sqrt(3), so that no two points in it are too far "
    "apart.",
)
def test_pairs_just_above_the_threshold(student, seed):
    require_simplest_clusters(student.euclidean_clustering_accelerated)
    cloud = _pairs_at_all_offsets(np.random.default_rng(seed))
    answer = student.euclidean_clustering_accelerated(cloud.copy(), 1.0)
    assert_partition(answer, np.arange(len(cloud)), cloud)


@hidden(
    NAME,
    weight=2,
    title="Joins a long winding chain into one cluster",
    hint="Join from cell to cell until the chain ends.",
)
def test_long_chain(student, seed):
    rng = np.random.default_rng(seed)
    angle = np.cumsum(np.full(1500, 0.2) / (2.0 + 0.02 * np.arange(1500)))
    radius = 2.0 + 2.4 * angle / np.pi
    spiral = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle])
    cloud = np.vstack([spiral, spiral[:40] + [0, 0, 5]])
    assert_clusters(student, cloud[rng.permutation(len(cloud))])


@hidden(
    NAME,
    weight=2,
    title="Does not depend on the order, position or rotation of the cloud",
    hint="Measure distances between points, not between cells. If the cloud moves by 10 cm, other "
    "points share a cell.",
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
    weight=6,
    title="Ignores intensities, whether they are small or large",
    hint="Use only the coordinates, cloud[:, :3].",
)
def test_intensity(student, seed):
    cloud, labels = _boxes_of_points(seed)
    for largest in (1, 255):
        bright = np.random.default_rng(seed).uniform(0, largest, (len(cloud), 1))
        bright = np.hstack([cloud, bright])
        answer = student.euclidean_clustering_accelerated(bright.copy(), 1.0)
        assert_partition(answer, labels, bright)


@hidden(
    NAME,
    weight=1,
    title="Works on float32 arrays",
    hint="Start from cloud[:, :3], and do not rely on the type of the numbers in the array.",
)
def test_kinds_of_arrays(student, seed):
    cloud, labels = _boxes_of_points(seed)
    answer = student.euclidean_clustering_accelerated(cloud.astype(np.float32), 1.0)
    assert_partition(answer, labels, cloud)


@hidden(
    NAME,
    weight=1,
    title="Works on clouds that are flat, tiny or in a single cell",
    hint="Make sure that your code works if the list of pairs of cells is empty, as for a cloud "
    "in a single cell.",
)
def test_extremes(student, seed):
    require_simplest_clusters(student.euclidean_clustering_accelerated)
    rng = np.random.default_rng(seed)
    cloud, labels = _boxes_of_points(seed)
    answer = student.euclidean_clustering_accelerated(cloud * [1, 1, 0], 1.0)
    assert_partition(answer, labels, cloud)
    assert_clusters(student, rng.uniform(5, 5.2, (60, 3)), 1.0)
    assert_clusters(student, np.repeat(rng.uniform(-9, 9, (5, 3)), 4, axis=0), 1.0)


@hidden(
    NAME,
    weight=2,
    title="Finds hundreds of clusters",
    hint="Store labels as int, because 8-bit integers end at 255.",
)
def test_many_clusters(student, seed):
    require_simplest_clusters(student.euclidean_clustering_accelerated)
    assert_clusters(student, np.random.default_rng(seed).uniform(-100, 100, (600, 3)), 0.05)


# ------------------------------------------------------------------------------ big clouds


def answer_in_time(student, cloud, threshold, advice):
    """Return the answer. If the sandbox stops the process, raise a failure with advice."""
    require_simplest_clusters(student.euclidean_clustering_accelerated)
    try:
        return student.euclidean_clustering_accelerated(cloud, threshold)
    except StudentStopped as stopped:
        raise CheckFailed(f"The cloud has {len(cloud):,} points. {stopped} {advice}") from None


@functools.lru_cache(maxsize=16)
def whole_scan(seed):
    """Return all obstacles of a new street, thinned to one return per cube of 3 cm."""
    cloud = samples.fresh_street(seed)[:, :3]
    cloud = cloud[cloud[:, 2] > -1.2]
    places = np.unique(np.floor(cloud / 0.03), axis=0, return_index=True)[1]
    return cloud[np.sort(places)]


@hidden(
    NAME,
    weight=30,
    title="Clusters a whole scan exactly and in time",
    hint="Compare your clusters with those of your euclidean_clustering from lesson 05, on the "
    "points of cloud.txt within 10 m.",
)
def test_whole_scan(student, seed):
    cloud = whole_scan(seed)
    for threshold in 0.5 + 0.004 * np.arange(20):
        answer = answer_in_time(
            student,
            cloud.copy(),
            float(threshold),
            "Loops over points take too long, and so do lists of the neighbours of every point. "
            "Work with cells instead of points.",
        )
        # The oracle is slow, so it runs only if the answer came in time. If a tiny change of the
        # threshold changes the clusters, an answer in single precision may differ, so the test
        # tries the next threshold.
        labels = samples.cluster_labels(cloud, threshold - 1e-4)
        if np.array_equal(labels, samples.cluster_labels(cloud, threshold + 1e-4)):
            assert_partition(answer, labels, cloud)
            return
    raise RuntimeError(f"No clear threshold for the street of seed {seed}")


@hidden(
    NAME,
    weight=12,
    title="Clusters sixty thousand points on a few walls, quickly and with little memory",
    hint="Work with cells instead of pairs of points. Twice as many points on the same wall give "
    "four times as many close pairs, but the same number of cells.",
)
def test_dense_walls(student, seed):
    cloud, labels = _walls(seed)
    answer = answer_in_time(
        student, cloud.copy(), 0.5, "Do not compare the points of dense walls pair by pair."
    )
    assert_timed_clusters(answer, labels, cloud)


@hidden(
    NAME,
    weight=16,
    title="Clusters heaps of twenty thousand points, quickly and with little memory",
    hint="Join the points of a cell without a list of all pairs, which grows with the square of "
    "the number of points in a heap.",
)
def test_heaps(student, seed):
    cloud, labels = _heaps(seed)
    answer = answer_in_time(
        student,
        cloud.copy(),
        0.5,
        "Do not compare the points of a heap pair by pair, because points that share a cell share "
        "a cluster.",
    )
    assert_timed_clusters(answer, labels, cloud)


@hidden(
    NAME,
    weight=30,
    title="Joins two heaps only if two of their points are close, and needs little memory",
    hint="Call cKDTree(p).query(q) for the points p and q of two crowded cells. You need only "
    "their closest pair.",
)
def test_touching_heaps(student, seed):
    cloud, labels = _heaps_end_to_end(seed)
    answer = answer_in_time(
        student,
        cloud.copy(),
        0.5,
        "Do not compare two heaps pair by pair, because their closest pair of points is enough.",
    )
    assert_partition(answer, labels, cloud)


def _pairs_at_all_offsets(rng):
    """Return 1000 pairs of points, shape (2000, 3); each pair is 1.002 m apart along a diagonal.

    If cells are too large, a cell contains both points of a pair, but only if the pair is in the
    right place. For cells with the side 1 / sqrt(2), that place extends over a fifth of the side
    along each axis. The pairs therefore begin at each tenth of the side along each axis. Wherever
    such cells begin, at least one of them contains a pair. Larger cells contain more pairs.
    """
    side = 1 / np.sqrt(2)
    tenths = np.stack(np.meshgrid(*[np.arange(10)] * 3), axis=-1).reshape(-1, 3) / 10
    places = 7 * np.stack(np.meshgrid(np.arange(40), np.arange(25), [0]), axis=-1).reshape(-1, 3)
    low = side * (places + rng.permutation(tenths)) + rng.uniform(-80, -60, 3)
    return np.stack([low, low + 1.002 / np.sqrt(3)], axis=1).reshape(-1, 3)


@functools.lru_cache(maxsize=16)
def _walls(seed):
    """Return twelve walls of 5000 points and their labels, read-only."""
    rng = np.random.default_rng(seed)
    walls = rng.uniform(0, 1, (12, 5000, 3)) * [1.2, 0.0, 1.0]
    walls += np.array([[5.0 * (i % 4), 5.0 * (i // 4), 0.0] for i in range(12)])[:, None]
    return _mix(rng, walls, range(12))


@functools.lru_cache(maxsize=16)
def _heaps(seed):
    """Return two heaps of 20,000 points, each 0.08 m wide, and their labels, read-only."""
    rng = np.random.default_rng(seed)
    heaps = rng.uniform(0, 0.08, (2, 20_000, 3))
    heaps[1] += [6.0, 0.0, 0.0]
    return _mix(rng, heaps, range(2))


@functools.lru_cache(maxsize=16)
def _heaps_end_to_end(seed):
    """Return two small heaps that a pair of points joins, two large separate heaps, and labels.

    The ends of two heaps are 0.502 m apart, so an answer has to search the large heaps completely.
    In each small heap, one point protrudes towards the other. The heaps are so thin that the
    nearest points are at the ends, where a kd-tree finds them ten times as fast as in a cube. They
    are so short that cell borders rarely split a heap, and never into pieces that are small enough
    for a table of distances. The arrays are read-only.
    """
    rng = np.random.default_rng(seed)
    heaps = [rng.uniform(0, [0.04, 0.002, 0.002], (n, 3)) for n in (2000, 2000, 28_000, 28_000)]
    heaps[0][0], heaps[1][0] = [0.0415, 0.001, 0.001], [-0.0015, 0.001, 0.001]
    for heap, x in zip(heaps, (0.0, 0.542, 6.0, 6.542), strict=True):
        heap[:, 0] += x
    return _mix(rng, heaps, (0, 0, 1, 2))


def _mix(rng, parts, labels):
    """Combine parts into one rotated, shifted and shuffled cloud, and return it with its labels."""
    cloud, labels = np.vstack(parts), np.repeat(labels, [len(part) for part in parts])
    turn, order = np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.permutation(len(cloud))
    return frozen((cloud @ turn.T + rng.uniform(-5, 5, 3))[order]), frozen(labels[order])


def _boxes_of_points(seed):
    """Return twelve dense boxes of points, far apart horizontally, and their labels."""
    rng = np.random.default_rng(seed)
    places = np.stack(np.meshgrid([-18, -6, 6, 18], [-12, 0, 12], [0.5]), axis=-1).reshape(12, 1, 3)
    order = rng.permutation(720)
    cloud = (rng.uniform(0, 0.9, (12, 60, 3)) + places).reshape(-1, 3)
    return cloud[order], np.repeat(np.arange(12), 60)[order]


def _directions(rng, n):
    directions = rng.normal(size=(n, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)
