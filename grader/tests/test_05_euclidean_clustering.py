"""Hidden tests of lesson 05. Titles and hints are shown to students; the code is not."""

import numpy as np

from grader.judging import samples
from grader.judging.marks import hidden, visible_checks
from utils.checks.vocabulary import assert_partition


@visible_checks("euclidean_clustering")
def test_visible(student, check):
    check.run(student.euclidean_clustering)


def assert_clusters(student, cloud, *threshold):
    radius = (threshold or (0.5,))[0]
    cloud = samples.without_ties(cloud, radius)
    assert_partition(
        student.euclidean_clustering(cloud.copy(), *threshold),
        samples.cluster_labels(cloud, radius),
        cloud,
    )


@hidden(
    "euclidean_clustering",
    weight=5,
    title="Right on obstacles of the course's own scan",
    hint="Draw your labels with plots.clusters: does one object carry two colours, or do two "
    "objects share one?",
)
def test_course_cloud(student, seed):
    cloud = samples.patch_of_course_cloud(seed, 4000)
    assert_clusters(student, cloud[cloud[:, 2] > -1.1][:900])


@hidden(
    "euclidean_clustering",
    weight=6,
    title="Right on streets you have not seen",
    hint="Nothing about one particular cloud may stand in the function.",
)
def test_fresh_streets(student, seed):
    for street in range(2):
        assert_clusters(student, samples.obstacles_of_street(seed + street, 500))


@hidden(
    "euclidean_clustering",
    weight=4,
    title="Right at thresholds you have not seen",
    hint="Is it the distance that is compared with the threshold, or its square?",
)
def test_other_thresholds(student, seed):
    cloud = samples.obstacles_of_street(seed, 350)
    for threshold in np.random.default_rng(seed).uniform(0.2, 2.0, 3):
        assert_clusters(student, cloud, float(threshold))


@hidden(
    "euclidean_clustering",
    weight=4,
    title="Long winding chains stay whole",
    hint="Every point that gets a label must be asked for its own neighbours.",
)
def test_long_chain(student, seed):
    # A spiral of 1500 points, 0.4 m apart, its turns 1.3 m apart. It begins at its inner end,
    # so whoever recurses must go 1500 calls deep.
    angle, points = 0.0, []
    for _ in range(1500):
        radius = 2.0 + 1.3 * angle / (2 * np.pi)
        points.append([radius * np.cos(angle), radius * np.sin(angle), 0.0])
        angle += 0.4 / radius
    spiral = np.array(points)
    others = np.random.default_rng(seed).permutation(np.vstack([spiral[1:], spiral[:40] + 5.0]))
    assert_clusters(student, np.vstack([spiral[:1], others]))


@hidden(
    "euclidean_clustering",
    weight=3,
    title="The order, place and turn of the cloud do not matter",
    hint="Labels may not depend on where the cloud lies or on which point comes first.",
)
def test_invariance(student, seed):
    rng = np.random.default_rng(seed)
    cloud = samples.obstacles_of_street(seed, 250)[:, :3]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    assert_clusters(student, cloud[rng.permutation(len(cloud))])
    assert_clusters(student, cloud @ turn.T + rng.uniform(-50, 50, 3))


@hidden(
    "euclidean_clustering",
    weight=3,
    title="Right for single precision, all in one and all alone",
    hint="Print the labels of three points by hand, then of one.",
)
def test_extremes(student, seed):
    rng = np.random.default_rng(seed)
    cloud = samples.obstacles_of_street(seed, 200)
    assert_clusters(student, cloud.astype(np.float32))
    assert_clusters(student, np.asfortranarray(cloud))
    assert_clusters(student, rng.uniform(0, 1, (60, 3)), 3.0)
    assert_clusters(student, rng.uniform(-100, 100, (600, 4)), 0.05)  # more than 255
    assert_clusters(student, np.repeat(rng.uniform(-9, 9, (5, 3)), 4, axis=0), 0.5)
