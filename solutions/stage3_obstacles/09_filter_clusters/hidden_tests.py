"""Hidden tests of lesson 09. Titles and hints are shown to students; the code is not.

Each tests one property. Only in `test_ties` a cluster has exactly the minimum number of points, and
only `test_labels` compares the labels of the remaining clusters.
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


def filtered_by_hand(labels, minimum):
    """Return the right answer, computed in plain Python."""
    numbers = labels.tolist()
    count = Counter(numbers)
    return np.array(
        [number if number > 0 and count[number] >= minimum else 0 for number in numbers], dtype=int
    )


def assert_right(student, labels, minimum):
    """Check the remaining clusters, for the next larger minimum that no cluster has exactly."""
    counts = set(Counter(labels.tolist()).values())
    minimum = next(number for number in range(minimum, len(labels) + 2) if number not in counts)
    expected = filtered_by_hand(labels, minimum)
    assert_right_clusters_left(student.filter_clusters(labels.copy(), minimum), labels, expected)


def clutter(rng, clusters, largest):
    """Return labels 1 to N of clusters of mixed sizes, in random order and with some noise."""
    sizes = np.ceil(np.exp(rng.uniform(0, np.log(largest), clusters))).astype(int)
    labels = np.repeat(np.arange(1, clusters + 1), sizes)
    return rng.permutation(np.concatenate([labels, np.zeros(clusters, dtype=int)]))


def objects_of_course_cloud(seed):
    """Return cluster labels of the objects above the road in the course's cloud."""
    patch = samples.patch_of_course_cloud(seed, 4000)
    patch = patch[patch[:, 2] > -1.1]
    return samples.cluster_labels(samples.without_ties(patch, 0.5), 0.5)


@hidden(
    "filter_clusters",
    weight=7,
    title="Right on clusters of the course's own scan",
    hint="Compare np.unique(labels, return_counts=True) before and after.",
)
def test_course_cloud(student, seed):
    labels = objects_of_course_cloud(seed)
    for minimum in (2, 5, 12):
        assert_right(student, labels, minimum)


@hidden(
    "filter_clusters",
    weight=7,
    title="Right on swarms of small clusters that you have not seen",
    hint="Clusters of all sizes, small ones one after the other: each is judged by its own number "
    "of points, and by nothing that came before.",
)
def test_swarms(student, seed):
    rng = np.random.default_rng(seed)
    for minimum in (2, 5, 20):
        assert_right(student, clutter(rng, 60, 40), minimum)
    assert_right(student, clutter(rng, 40, 400), 100)


@hidden(
    "filter_clusters",
    weight=7,
    title="Right where cars, walls and lorries have hundreds and thousands of points",
    hint="There is a minimum and no maximum.",
)
def test_large_clusters(student, seed):
    rng = np.random.default_rng(seed)
    sizes = (np.array([150, 400, 900, 2500, 7000, 20_000]) * rng.uniform(1, 2, 6)).astype(int)
    labels = np.repeat(rng.permutation(np.arange(1, 13)), [*sizes, *rng.integers(1, 9, 6)])
    assert_right(student, rng.permutation(labels), 10)


@hidden(
    "filter_clusters",
    weight=3,
    title="Of a swarm, clusters of exactly the minimum stay",
    hint="A cluster with as many points as the minimum stays.",
)
def test_ties(student, seed):
    require_most_clusters_right(student.filter_clusters)
    labels = np.concatenate([np.repeat([1, 2, 3], 6), clutter(np.random.default_rng(seed), 30, 30)])
    count = Counter(labels.tolist())
    labels = np.append(labels, np.repeat(31, count[2]))  # the highest label also has the minimum
    count = Counter(labels.tolist())
    at_the_border = [label for label in count if label > 0 and count[label] == count[2]]
    yours = as_labels(student.filter_clusters(labels.copy(), count[2]), len(labels))
    if (yours[np.isin(labels, at_the_border)] <= 0).any():
        raise CheckFailed("A cluster with exactly as many points as the minimum is gone.")


@hidden(
    "filter_clusters",
    weight=3,
    title="What stays keeps its label, gaps and large numbers and all",
    hint="Filtering twice must be possible: the second time there are gaps and many zeros.",
)
def test_labels(student, seed):
    require_most_clusters_right(student.filter_clusters)
    rng = np.random.default_rng(seed)
    numbers = np.concatenate([[0], rng.choice(np.arange(300, 5000), 40, replace=False)])
    labels = numbers[clutter(rng, 40, 60)]
    for minimum in (4, 9):
        expected = filtered_by_hand(labels, minimum)
        assert_labels_kept(student.filter_clusters(labels.copy(), minimum), labels, expected)


@hidden(
    "filter_clusters",
    weight=3,
    title="Noise stays noise, however plenty it is",
    hint="Label 0 is no cluster, however often it occurs.",
)
def test_noise(student, seed):
    require_most_clusters_right(student.filter_clusters)
    rng = np.random.default_rng(seed)
    labels = clutter(rng, 40, 60)
    labels[rng.random(len(labels)) < 0.3] = 0
    yours = as_labels(student.filter_clusters(labels.copy(), 4), len(labels))
    if (yours[labels == 0] > 0).any():
        raise CheckFailed(NOISE_MESSAGE)


@hidden(
    "filter_clusters",
    weight=3,
    title="The order of the points and the numbers of the clusters do not matter",
    hint="The points of a cluster need not stand next to each other, and a high label is not "
    "a large cluster.",
)
def test_order(student, seed):
    rng = np.random.default_rng(seed)
    labels = clutter(rng, 30, 50)
    renamed = np.concatenate([[0], rng.permutation(30) + 1])[labels]
    assert_right(student, np.sort(labels), 8)
    assert_right(student, renamed[rng.permutation(len(labels))], 8)


@hidden(
    "filter_clusters",
    weight=2,
    title="A minimum of 0 keeps everything, a huge one nothing",
    hint="The same lines serve every case: no special case is needed.",
)
def test_extremes(student, seed):
    require_small_clusters_removed(student.filter_clusters)
    labels = clutter(np.random.default_rng(seed), 20, 30)
    for minimum in (0, 10_000):
        expected = filtered_by_hand(labels, minimum)
        assert_right_clusters_left(
            student.filter_clusters(labels.copy(), minimum), labels, expected
        )
    assert_right(student, np.zeros(12, dtype=int), 5)


@hidden(
    "filter_clusters",
    weight=2,
    title="Takes other kinds of whole numbers, and many clusters",
    hint="Labels may be 32 bits wide, and there may be more than 255.",
)
def test_kinds_of_numbers(student, seed):
    require_small_clusters_removed(student.filter_clusters)
    labels = clutter(np.random.default_rng(seed), 20, 30)
    assert_right(student, labels.astype(np.int32), 6)
    assert_right(student, np.repeat(labels, 2)[::2], 6)
    assert_right(student, clutter(np.random.default_rng(seed + 1), 700, 20), 4)


@hidden(
    "filter_clusters",
    weight=2,
    title="Never writes into the array that it is given",
    hint="Work on a copy.",
)
def test_input(student, seed):
    labels = clutter(np.random.default_rng(seed), 20, 30)
    require_most_clusters_right(student.filter_clusters)
    assert_untouched(student.filter_clusters, labels, 6)
