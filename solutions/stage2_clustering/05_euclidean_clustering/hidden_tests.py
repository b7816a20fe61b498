"""Hidden tests of lesson 05. Titles and hints are shown to students; the code is not.

Each tests one property. A squared distance, or 0.5 instead of the threshold, fails only on scans;
in the other tests any threshold between 0.25 m and 2 m is right.
"""

import numpy as np

from extension import samples
from grader.judging.hidden_tests import hidden
from utils.checks.assertions import assert_partition, assert_untouched
from utils.checks.clusters import assert_from_one, assert_works


def assert_clusters(student, cloud, threshold=1.0):
    cloud = samples.without_ties(cloud, threshold)
    assert_partition(
        student.euclidean_clustering(cloud.copy(), threshold),
        samples.cluster_labels(cloud, threshold),
        cloud,
    )


def objects(seed):
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
    title="Right on obstacles of the course's own scan",
    hint="Draw your labels with plots.clusters: does one object carry two colours, or do two "
    "objects share one?",
)
def test_course_cloud(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 4000)
    assert_clusters(student, cloud[cloud[:, 2] > -1.1][:600, :3], 0.5)


@hidden(
    "euclidean_clustering",
    weight=8,
    title="Right on streets you have not seen",
    hint="In every street the same holds: all that a chain of neighbours joins is one cluster.",
)
def test_fresh_streets(student, seed):
    for street in range(2):
        assert_clusters(student, samples.obstacles_of_street(seed + street, 500)[:, :3])


@hidden(
    "euclidean_clustering",
    weight=4,
    title="Right at thresholds you have not seen",
    hint="Neighbours are two points whose distance in metres is below threshold.",
)
def test_other_thresholds(student, seed):
    cloud = samples.obstacles_of_street(seed, 350)[:, :3]
    for threshold in np.random.default_rng(seed).uniform(0.2, 2.0, 3):
        assert_clusters(student, cloud, float(threshold))


@hidden(
    "euclidean_clustering",
    weight=7,
    title="Long winding chains stay whole",
    hint="A cluster is all that can be reached from neighbour to neighbour, however far.",
)
def test_long_chain(student, seed):
    # A spiral of 400 points, 0.45 m apart, with turns 1.5 m apart, and a shorter one above it.
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
    title="A chain of thousands of points, beginning at its end",
    hint="A queue follows a chain to its end, however long it is.",
)
def test_deep_chain(student, seed):
    # A recursive answer needs 1100 nested calls, and Python allows 1000.
    steps = np.random.default_rng(seed).uniform(-0.1, 0.1, (1100, 3)) * [0, 1, 1] + [0.45, 0, 0]
    assert_clusters(student, np.cumsum(steps, axis=0), 0.8)


@hidden(
    "euclidean_clustering",
    weight=2,
    title="The order of the points does not matter",
    hint="Which points belong together is the same whichever comes first.",
)
def test_order(student, seed):
    cloud, labels = objects(seed)
    for order in (np.random.default_rng(seed).permutation(300), np.argsort(cloud[:, 1])):
        answer = student.euclidean_clustering(cloud[order], 1.0)
        assert_partition(answer, labels[order], cloud[order])


@hidden(
    "euclidean_clustering",
    weight=2,
    title="Place and turn of the cloud do not matter",
    hint="A distance, the root of dx² + dy² + dz², is the same in every direction.",
)
def test_place_and_turn(student, seed):
    rng = np.random.default_rng(seed)
    cloud, labels = objects(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    moved = cloud @ turn.T + rng.uniform(-50, 50, 3)
    assert_partition(student.euclidean_clustering(moved.copy(), 1.0), labels, moved)


@hidden(
    "euclidean_clustering",
    weight=7,
    title="Right with intensities, small ones and large ones",
    hint="The coordinates are cloud[:, :3]; whatever the intensity is, the clusters are the same.",
)
def test_intensity(student, seed):
    cloud, labels = objects(seed)
    for largest in (1, 255):
        bright = np.random.default_rng(seed).uniform(0, largest, (300, 1))
        bright = np.hstack([cloud, bright])
        assert_partition(student.euclidean_clustering(bright.copy(), 1.0), labels, bright)


@hidden(
    "euclidean_clustering",
    weight=1,
    title="Takes single precision, and columns first in memory",
    hint="The same lines serve every kind of array.",
)
def test_kinds_of_arrays(student, seed):
    cloud, labels = objects(seed)
    for form in (cloud.astype(np.float32), np.asfortranarray(cloud)):
        assert_partition(student.euclidean_clustering(form, 1.0), labels, cloud)


@hidden(
    "euclidean_clustering",
    weight=3,
    title="Right for hundreds of clusters",
    hint="Labels go as high as there are clusters, and each cluster has its own.",
)
def test_many_clusters(student, seed):
    assert_works(student.euclidean_clustering)
    assert_clusters(student, np.random.default_rng(seed).uniform(-100, 100, (400, 3)), 0.8)


@hidden(
    "euclidean_clustering",
    weight=1,
    title="Right where all points are one cluster, and where many are equal",
    hint="Equal points are at distance 0 and belong together.",
)
def test_extremes(student, seed):
    assert_works(student.euclidean_clustering)
    rng = np.random.default_rng(seed)
    assert_clusters(student, rng.uniform(0, 0.2, (60, 3)))
    assert_clusters(student, np.repeat(rng.uniform(-9, 9, (5, 3)), 4, axis=0))


@hidden(
    "euclidean_clustering",
    weight=2,
    title="Every point has a label above 0, wherever it stands in the cloud",
    hint="A point without neighbours is a cluster of its own: the first of the cloud, any, the "
    "last.",
)
def test_every_point(student, seed):
    assert_works(student.euclidean_clustering)
    cloud, _ = objects(seed)
    alone = np.random.default_rng(seed).uniform(30, 40, (2, 3)) * [[-1, -1, 1], [1, 1, 1]]
    for whole in (np.vstack([alone[:1], cloud, alone[1:]]), alone[:1]):
        assert_from_one(student.euclidean_clustering(whole.copy(), 1.0), len(whole))


@hidden(
    "euclidean_clustering",
    weight=1,
    title="Never writes into the cloud that it is given",
    hint="Labels stand in an array of their own.",
)
def test_input(student, seed):
    assert_works(student.euclidean_clustering)
    cloud = samples.patch_of_course_cloud(seed, 300) * [1, 1, 1, 255]
    assert_untouched(student.euclidean_clustering, cloud, 0.5)
