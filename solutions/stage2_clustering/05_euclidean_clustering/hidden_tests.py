"""Hidden tests of lesson 05. Students see the titles and hints but not the code.

Each test covers one property. An answer that squares a distance, or always uses a threshold of 0.5,
fails only on scans. In the other tests, any threshold between 0.25 m and 2 m gives the right
clusters.
"""

import numpy as np

from extension import samples
from grader.judging.hidden_tests import hidden
from utils.checks.assertions import assert_partition, assert_untouched
from utils.checks.clusters import assert_labels_from_one, require_simplest_clusters


def assert_clusters(student, cloud, threshold=1.0):
    cloud = samples.remove_ties(cloud, threshold)
    assert_partition(
        student.euclidean_clustering(cloud.copy(), threshold),
        samples.cluster_labels(cloud, threshold),
        cloud,
    )


def random_walks(seed):
    """Return twelve random walks, far apart, with steps below 0.2 m, and their labels."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(size=(12, 25, 3))
    steps *= rng.uniform(0.1, 0.2, (12, 25, 1)) / np.linalg.norm(steps, axis=2, keepdims=True)
    places = np.stack(np.meshgrid([-18, -6, 6, 18], [-12, 0, 12], [0]), axis=-1).reshape(12, 1, 3)
    order = rng.permutation(300)
    cloud = (np.cumsum(steps, axis=1) + places).reshape(-1, 3)
    return cloud[order], np.repeat(np.arange(12), 25)[order]


@hidden(
    "euclidean_clustering",
    weight=5,
    title="Finds the clusters in the course's scan",
    hint="Draw your labels with plots.clusters, and look for an object with two colours or for "
    "two objects that share one.",
)
def test_course_cloud(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 4000)
    assert_clusters(student, cloud[cloud[:, 2] > -1.1][:600, :3], 0.5)


@hidden(
    "euclidean_clustering",
    weight=8,
    title="Finds the clusters on unseen streets",
    hint="Apply the same rule on every street: a chain of neighbours is one cluster.",
)
def test_fresh_streets(student, seed):
    for street in range(2):
        assert_clusters(student, samples.obstacles_of_street(seed + street, 500)[:, :3])


@hidden(
    "euclidean_clustering",
    weight=4,
    title="Finds the clusters for unseen thresholds",
    hint="Compare the distance in metres with threshold: closer points are neighbours.",
)
def test_other_thresholds(student, seed):
    cloud = samples.obstacles_of_street(seed, 350)[:, :3]
    for threshold in np.random.default_rng(seed).uniform(0.2, 2.0, 3):
        assert_clusters(student, cloud, float(threshold))


@hidden(
    "euclidean_clustering",
    weight=7,
    title="Keeps long winding chains in one piece",
    hint="Search for the neighbours of every point that joins a cluster, however far it is from "
    "the first point.",
)
def test_long_chain(student, seed):
    # Two spirals, one above the other. The points are 0.45 m apart, and the turns 1.5 m.
    angle, points = 0.0, []
    for _ in range(400):
        radius = 2.0 + 1.5 * angle / (2 * np.pi)
        points.append([radius * np.cos(angle), radius * np.sin(angle), 0.0])
        angle += 0.45 / radius
    spiral = np.array(points)
    cloud = np.vstack([spiral, spiral[:40] + [0.0, 0.0, 3.0]])
    assert_clusters(student, np.random.default_rng(seed).permutation(cloud), 0.8)


@hidden(
    "euclidean_clustering",
    weight=3,
    title="Follows a chain of more than a thousand points from its end",
    hint="Use a queue, which follows a chain to its end, however long the chain is.",
)
def test_deep_chain(student, seed):
    # A recursive answer needs 1100 nested calls, and Python allows 1000.
    steps = np.random.default_rng(seed).uniform(-0.1, 0.1, (1100, 3)) * [0, 1, 1] + [0.45, 0, 0]
    assert_clusters(student, np.cumsum(steps, axis=0), 0.8)


@hidden(
    "euclidean_clustering",
    weight=2,
    title="Finds the same clusters, whatever the order of the points",
    hint="Give close points the same label, whichever of them comes first.",
)
def test_order(student, seed):
    cloud, labels = random_walks(seed)
    for order in (np.random.default_rng(seed).permutation(300), np.argsort(cloud[:, 1])):
        answer = student.euclidean_clustering(cloud[order], 1.0)
        assert_partition(answer, labels[order], cloud[order])


@hidden(
    "euclidean_clustering",
    weight=2,
    title="Finds the same clusters after the cloud is moved and rotated",
    hint="Use the square root of dx² + dy² + dz², which is the same in every direction.",
)
def test_pose(student, seed):
    rng = np.random.default_rng(seed)
    cloud, labels = random_walks(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    moved = cloud @ turn.T + rng.uniform(-50, 50, 3)
    assert_partition(student.euclidean_clustering(moved.copy(), 1.0), labels, moved)


@hidden(
    "euclidean_clustering",
    weight=7,
    title="Ignores small and large intensities",
    hint="Use only the coordinates, cloud[:, :3]. Intensity does not change the clusters.",
)
def test_intensity(student, seed):
    cloud, labels = random_walks(seed)
    for largest in (1, 255):
        bright = np.random.default_rng(seed).uniform(0, largest, (300, 1))
        bright = np.hstack([cloud, bright])
        assert_partition(student.euclidean_clustering(bright.copy(), 1.0), labels, bright)


@hidden(
    "euclidean_clustering",
    weight=1,
    title="Works on float32 arrays",
    hint="Do not rely on the type of the numbers in the array.",
)
def test_kinds_of_arrays(student, seed):
    cloud, labels = random_walks(seed)
    answer = student.euclidean_clustering(cloud.astype(np.float32), 1.0)
    assert_partition(answer, labels, cloud)


@hidden(
    "euclidean_clustering",
    weight=3,
    title="Gives hundreds of clusters different labels",
    hint="Store labels as int: a type such as np.uint8 ends at 255.",
)
def test_many_clusters(student, seed):
    require_simplest_clusters(student.euclidean_clustering)
    assert_clusters(student, np.random.default_rng(seed).uniform(-100, 100, (400, 3)), 0.8)


@hidden(
    "euclidean_clustering",
    weight=1,
    title="Works if all points are one cluster, and if many points are equal",
    hint="Give equal points the same label: their distance is 0.",
)
def test_extremes(student, seed):
    require_simplest_clusters(student.euclidean_clustering)
    rng = np.random.default_rng(seed)
    assert_clusters(student, rng.uniform(0, 0.2, (60, 3)))
    assert_clusters(student, np.repeat(rng.uniform(-9, 9, (5, 3)), 4, axis=0))


@hidden(
    "euclidean_clustering",
    weight=2,
    title="Gives every point, even an isolated one, a label from 1 upwards",
    hint="Begin a new cluster at every point without a label, even if it has no neighbours or is "
    "the first or last of the cloud.",
)
def test_every_point(student, seed):
    require_simplest_clusters(student.euclidean_clustering)
    cloud, _ = random_walks(seed)
    alone = np.random.default_rng(seed).uniform(30, 40, (2, 3)) * [[-1, -1, 1], [1, 1, 1]]
    for whole in (np.vstack([alone[:1], cloud, alone[1:]]), alone[:1]):
        assert_labels_from_one(student.euclidean_clustering(whole.copy(), 1.0), len(whole))


@hidden(
    "euclidean_clustering",
    weight=1,
    title="Does not change a cloud from the course's scan",
    hint="Store the labels in a new array.",
)
def test_input(student, seed):
    require_simplest_clusters(student.euclidean_clustering)
    cloud = samples.patch_of_course_cloud(seed, 300) * [1, 1, 1, 255]
    assert_untouched(student.euclidean_clustering, cloud, 0.5)
