"""Hidden tests of lesson 09. Titles and hints are shown to students; the code is not."""

from collections import Counter

import numpy as np

from grader.judging import samples
from grader.judging.marks import hidden, visible_checks
from utils.checks.lesson_09 import assert_filtered
from utils.checks.vocabulary import assert_left_alone, observe


@visible_checks("filter_clusters")
def test_visible(student, check):
    check.run(student.filter_clusters)


def filtered_by_hand(labels, minimum):
    """The right answer, in plain Python."""
    numbers = labels.tolist()
    count = Counter(numbers)
    return np.array(
        [number if number > 0 and count[number] >= minimum else 0 for number in numbers], dtype=int
    )


def assert_right(student, labels, *minimum):
    expected = filtered_by_hand(labels, *(minimum or (100,)))
    seen = observe(student.filter_clusters, labels, *minimum)
    assert_filtered(seen.result, labels, expected)
    assert_left_alone(seen, labels)


def clutter(rng, clusters, largest):
    """Labels 1 to N of clusters of mixed sizes, in random order, with some noise among them."""
    sizes = np.ceil(np.exp(rng.uniform(0, np.log(largest), clusters))).astype(int)
    labels = np.repeat(np.arange(1, clusters + 1), sizes)
    return rng.permutation(np.concatenate([labels, np.zeros(clusters, dtype=int)]))


def objects_of_course_cloud(seed):
    """Labels of what stands above the road in the course's cloud: an object is a cluster."""
    patch = samples.patch_of_course_cloud(seed, 4000)
    patch = patch[patch[:, 2] > -1.1]
    return samples.cluster_labels(samples.without_ties(patch, 0.5), 0.5)


@hidden(
    "filter_clusters",
    weight=5,
    title="Right on clusters of the course's own scan",
    hint="Compare np.unique(labels, return_counts=True) before and after.",
)
def test_course_cloud(student, seed):
    labels = objects_of_course_cloud(seed)
    for minimum in (2, 5, 12):
        assert_right(student, labels, minimum)


@hidden(
    "filter_clusters",
    weight=5,
    title="Right on swarms of small clusters that you have not seen",
    hint="Nothing may move while you walk along the labels: of two small neighbours both "
    "have to go.",
)
def test_swarms(student, seed):
    rng = np.random.default_rng(seed)
    for minimum in (2, 5, 20):
        assert_right(student, clutter(rng, 60, 40), minimum)
    assert_right(student, clutter(rng, 40, 400))


@hidden(
    "filter_clusters",
    weight=3,
    title="Right when the labels have gaps and noise is plenty",
    hint="Filtering twice must be possible: the second time there are gaps and many zeros.",
)
def test_gaps_and_noise(student, seed):
    rng = np.random.default_rng(seed)
    numbers = np.concatenate([[0], rng.choice(np.arange(1, 5000), 40, replace=False)])
    labels = numbers[clutter(rng, 40, 60)]
    labels[rng.random(len(labels)) < 0.3] = 0
    once = filtered_by_hand(labels, 4)
    assert_right(student, labels, 4)
    assert_right(student, once, 9)


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
    title="A minimum of 0 or 1 keeps everything, a huge one nothing",
    hint="The same lines serve every case: no special case is needed.",
)
def test_extremes(student, seed):
    labels = clutter(np.random.default_rng(seed), 20, 30)
    for minimum in (0, 1, 3, 10_000):
        assert_right(student, labels, minimum)
    assert_right(student, np.zeros(12, dtype=int), 5)
    assert_right(student, np.repeat([2, 1], [5, 4]), 5)


@hidden(
    "filter_clusters",
    weight=2,
    title="Takes other kinds of whole numbers, and read-only arrays",
    hint="Labels may be 32 bits wide. Never write into the array you are given.",
)
def test_kinds_of_numbers(student, seed):
    labels = clutter(np.random.default_rng(seed), 20, 30)
    assert_right(student, labels.astype(np.int32), 6)
    assert_right(student, np.repeat(labels, 2)[::2], 6)
    assert_right(student, clutter(np.random.default_rng(seed + 1), 700, 20), 4)
    frozen = labels.copy()
    frozen.flags.writeable = False
    assert_filtered(student.filter_clusters(frozen, 6), labels, filtered_by_hand(labels, 6))
