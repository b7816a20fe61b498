"""Hidden tests of lesson 09. Students see the titles and hints but not the code.

Each test covers one property. Only in `test_keeps_clusters_of_the_minimum_size` does a cluster have
exactly the minimum number of points. Only `test_keeps_the_labels` compares the labels of the
remaining clusters.
"""

from collections import Counter

import numpy as np

from extension import samples
from grader.judging.hidden_tests import hidden
from utils.checks.assertions import CheckFailed, as_labels, assert_untouched
from utils.checks.lesson_09 import (
    NOISE_MESSAGE,
    assert_labels_kept,
    assert_right_clusters_left,
    require_most_clusters_right,
    require_small_clusters_removed,
)


def expected_labels(labels, minimum):
    """Compute the right answer in plain Python."""
    numbers = labels.tolist()
    count = Counter(numbers)
    return np.array(
        [number if number > 0 and count[number] >= minimum else 0 for number in numbers], dtype=int
    )


def assert_filtered(student, labels, minimum):
    """Check the remaining clusters. Raise the minimum until it is not the size of a cluster."""
    counts = set(Counter(labels.tolist()).values())
    minimum = next(number for number in range(minimum, len(labels) + 2) if number not in counts)
    expected = expected_labels(labels, minimum)
    assert_right_clusters_left(student.filter_clusters(labels.copy(), minimum), labels, expected)


def random_labels(rng, clusters, largest):
    """Return shuffled labels of clusters of various sizes, numbered from 1, with some noise."""
    sizes = np.ceil(np.exp(rng.uniform(0, np.log(largest), clusters))).astype(int)
    labels = np.repeat(np.arange(1, clusters + 1), sizes)
    return rng.permutation(np.concatenate([labels, np.zeros(clusters, dtype=int)]))


def objects_of_course_cloud(seed):
    """Return cluster labels of objects above the road in the course's scan."""
    patch = samples.patch_of_course_cloud(seed, 4000)
    patch = patch[patch[:, 2] > -1.1]
    return samples.cluster_labels(samples.remove_ties(patch, 0.5), 0.5)


@hidden(
    "filter_clusters",
    weight=7,
    title="Filters the clusters of the course's scan",
    hint="Compare np.unique(labels, return_counts=True) before and after filtering.",
)
def test_filters_the_course_scan(student, seed):
    labels = objects_of_course_cloud(seed)
    for minimum in (2, 5, 12):
        assert_filtered(student, labels, minimum)


@hidden(
    "filter_clusters",
    weight=7,
    title="Removes small clusters from clouds you have not seen",
    hint="Compare only the number of points of each cluster with min_num_points, even if small "
    "clusters have consecutive labels.",
)
def test_filters_swarms(student, seed):
    rng = np.random.default_rng(seed)
    for minimum in (2, 5, 20):
        assert_filtered(student, random_labels(rng, 60, 40), minimum)
    assert_filtered(student, random_labels(rng, 40, 400), 100)


@hidden(
    "filter_clusters",
    weight=7,
    title="Keeps cars, walls and lorries with hundreds or thousands of points",
    hint="Compare the size of a cluster only with min_num_points: there is no maximum.",
)
def test_keeps_large_clusters(student, seed):
    rng = np.random.default_rng(seed)
    sizes = (np.array([150, 400, 900, 2500, 7000, 20_000]) * rng.uniform(1, 2, 6)).astype(int)
    labels = np.repeat(rng.permutation(np.arange(1, 13)), [*sizes, *rng.integers(1, 9, 6)])
    assert_filtered(student, rng.permutation(labels), 10)


@hidden(
    "filter_clusters",
    weight=3,
    title="Keeps clusters of exactly the minimum size in clouds you have not seen",
    hint='Write < min_num_points, not <=, because the exercise says "fewer than".',
)
def test_keeps_clusters_of_the_minimum_size(student, seed):
    require_most_clusters_right(student.filter_clusters)
    labels = np.concatenate(
        [np.repeat([1, 2, 3], 6), random_labels(np.random.default_rng(seed), 30, 30)]
    )
    count = Counter(labels.tolist())
    # The cluster with the highest label also has exactly the minimum size.
    labels = np.append(labels, np.repeat(31, count[2]))
    count = Counter(labels.tolist())
    at_the_border = [label for label in count if label > 0 and count[label] == count[2]]
    yours = as_labels(student.filter_clusters(labels.copy(), count[2]), len(labels))
    if (yours[np.isin(labels, at_the_border)] <= 0).any():
        raise CheckFailed("A cluster with exactly as many points as the minimum was removed.")


@hidden(
    "filter_clusters",
    weight=3,
    title="Keeps labels that are large and have gaps",
    hint="Loop over np.unique(cluster_labels), not from 1 to N: labels that were filtered before "
    "have gaps and many zeros.",
)
def test_keeps_the_labels(student, seed):
    require_most_clusters_right(student.filter_clusters)
    rng = np.random.default_rng(seed)
    numbers = np.concatenate([[0], rng.choice(np.arange(300, 5000), 40, replace=False)])
    labels = numbers[random_labels(rng, 40, 60)]
    for minimum in (4, 9):
        expected = expected_labels(labels, minimum)
        assert_labels_kept(student.filter_clusters(labels.copy(), minimum), labels, expected)


@hidden(
    "filter_clusters",
    weight=3,
    title="Never turns noise into a cluster, however many noise points there are",
    hint="Leave label 0 unchanged, however often it occurs: it is not a cluster.",
)
def test_never_clusters_noise(student, seed):
    require_most_clusters_right(student.filter_clusters)
    rng = np.random.default_rng(seed)
    labels = random_labels(rng, 40, 60)
    labels[rng.random(len(labels)) < 0.3] = 0
    yours = as_labels(student.filter_clusters(labels.copy(), 4), len(labels))
    if (yours[labels == 0] > 0).any():
        raise CheckFailed(NOISE_MESSAGE)


@hidden(
    "filter_clusters",
    weight=3,
    title="Works for any order of the points and the labels",
    hint="Count all points with a label, wherever they are in the array: a high label does not "
    "mean a large cluster.",
)
def test_works_in_any_order(student, seed):
    rng = np.random.default_rng(seed)
    labels = random_labels(rng, 30, 50)
    renamed = np.concatenate([[0], rng.permutation(30) + 1])[labels]
    assert_filtered(student, np.sort(labels), 8)
    assert_filtered(student, renamed[rng.permutation(len(labels))], 8)


@hidden(
    "filter_clusters",
    weight=2,
    title="Keeps all clusters if the minimum is 0, and none if it is huge",
    hint="Use the same lines for every minimum: 0 and a huge minimum need no special case.",
)
def test_works_with_extreme_minima(student, seed):
    require_small_clusters_removed(student.filter_clusters)
    labels = random_labels(np.random.default_rng(seed), 20, 30)
    for minimum in (0, 10_000):
        expected = expected_labels(labels, minimum)
        assert_right_clusters_left(
            student.filter_clusters(labels.copy(), minimum), labels, expected
        )
    assert_filtered(student, np.zeros(12, dtype=int), 5)


@hidden(
    "filter_clusters",
    weight=2,
    title="Works with 32-bit labels and with many clusters",
    hint="Keep the integer type of cluster_labels: 8 bits are too few for more than 255 labels.",
)
def test_works_with_other_number_types(student, seed):
    require_small_clusters_removed(student.filter_clusters)
    labels = random_labels(np.random.default_rng(seed), 20, 30)
    assert_filtered(student, labels.astype(np.int32), 6)
    assert_filtered(student, np.repeat(labels, 2)[::2], 6)
    assert_filtered(student, random_labels(np.random.default_rng(seed + 1), 700, 20), 4)


@hidden(
    "filter_clusters",
    weight=2,
    title="Does not change labels you have not seen",
    hint="Write into a copy: cluster_labels.copy().",
)
def test_leaves_its_input_unchanged(student, seed):
    labels = random_labels(np.random.default_rng(seed), 20, 30)
    require_most_clusters_right(student.filter_clusters)
    assert_untouched(student.filter_clusters, labels, 6)
