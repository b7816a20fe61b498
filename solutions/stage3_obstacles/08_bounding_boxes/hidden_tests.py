"""Hidden tests of lesson 08. Students see the titles and hints but not the code.

The two tests on scans use data as in the lesson: noise, intensities, and labels with gaps and in
any order. Each other test covers one property. Unless a test is about these things, labels rise
from 1 without gaps, clouds have neither noise nor intensities, and the first point of a cluster is
not its smallest or largest on any axis.
"""

import functools

import numpy as np
import pytest

from extension import samples
from grader.judging.hidden_tests import hidden
from utils.checks.assertions import assert_untouched, frozen
from utils.checks.boxes import as_cluster_boxes, assert_box_corners
from utils.checks.lesson_08 import require_three_boxes


def expected_boxes(cloud, labels):
    """Compute the right boxes in plain Python, shape (N, 8, 3)."""
    rows = {}
    for label, row in zip(labels.tolist(), cloud[:, :3].tolist(), strict=True):
        if label > 0:
            rows.setdefault(label, []).append(row)
    boxes = []
    for label in sorted(rows):
        columns = [sorted(column) for column in zip(*rows[label], strict=True)]
        boxes.append(
            [
                [
                    column[-1] if corner // 2**axis % 2 else column[0]
                    for axis, column in enumerate(columns)
                ]
                for corner in range(8)
            ]
        )
    return np.array(boxes, dtype=float).reshape(-1, 8, 3)


def assert_boxed(student, cloud, labels):
    """Round a cloud to centimetres, so that answers may round too, and check its boxes."""
    cloud = cloud.round(2)
    assert_box_corners(
        student.get_bounding_boxes(cloud.copy(), labels.copy()),
        expected_boxes(cloud, labels),
        cloud,
        labels,
    )


def put_means_first(cloud, labels):
    """Begin a cloud with the mean of each cluster, drop noise, and renumber labels from 1."""
    cloud = cloud[labels > 0]
    names, place = np.unique(labels[labels > 0], return_inverse=True)
    middles = [cloud[place == row].mean(axis=0) for row in range(len(names))]
    return np.vstack([middles, cloud]), np.concatenate([np.arange(len(names)), place]) + 1


@functools.lru_cache(maxsize=64)
def course_clusters(seed):
    """Return part of the course's scan, with cluster labels; the road has the label 0."""
    cloud = samples.patch_of_course_cloud(seed, 2500)
    stands = cloud[:, 2] > -1.1
    found = drop_small_clusters(samples.cluster_labels(cloud[stands, :3], 0.7), 4)
    return imitate_filter(*put_means_first(cloud[stands], found), cloud[~stands], seed)


@functools.lru_cache(maxsize=64)
def street_clusters(seed):
    """Return part of a new street, with cluster labels."""
    cloud = samples.obstacles_of_street(seed, 1500)
    found = drop_small_clusters(samples.cluster_labels(cloud[:, :3], 0.8), 4)
    return imitate_filter(*put_means_first(cloud, found), cloud[found == 0] - [0, 0, 3, 0], seed)


def imitate_filter(cloud, labels, noise, seed):
    """Add noise to a cloud, and renumber its labels with gaps and in any order, as a filter may."""
    rng = np.random.default_rng(seed)
    names = rng.choice(np.arange(1, 3 * labels.max()), labels.max(), replace=False)
    cloud, labels = np.vstack([cloud, noise]), np.append(names[labels - 1], 0 * noise[:, 0])
    return frozen((cloud, labels.astype(int)))


def drop_noise_and_intensity(cloud, labels):
    """Drop a scan's noise and intensities, and renumber its labels from 1 without gaps."""
    kept = labels > 0
    return cloud[kept, :3], np.unique(labels[kept], return_inverse=True)[1].ravel() + 1


def clusters_around_the_origin(rng, count=12, each=20):
    """Return clusters that each have points on all sides of the origin."""
    labels = np.repeat(np.arange(1, count + 1), each)
    sizes = rng.uniform(1, 9, (count, 3))[labels - 1]
    points = rng.uniform(-1, 1, (len(labels), 3)) * sizes
    points[1::each] = -points[::each]  # on both sides along every axis
    return put_means_first(points, labels)


def drop_small_clusters(labels, least):
    """Set the labels of clusters with fewer than `least` points to 0."""
    return np.where(np.bincount(labels)[labels] < least, 0, labels)


@hidden(
    "get_bounding_boxes",
    weight=4,
    title="Puts a box around every obstacle in the course's scan",
    hint="Draw your boxes and compare them with the picture in the notebook: every obstacle must "
    "be inside a box.",
)
def test_boxes_the_course_scan(student, seed):
    assert_boxed(student, *course_clusters(seed))


@hidden(
    "get_bounding_boxes",
    weight=4,
    title="Puts a box around every obstacle on a street you have not seen",
    hint="On any street, return one box for each label above 0 that occurs, in ascending order.",
)
def test_boxes_a_new_street(student, seed):
    assert_boxed(student, *street_clusters(seed))


@hidden(
    "get_bounding_boxes",
    weight=2,
    title="Works when labels have large gaps",
    hint="Loop over np.unique(labels[labels > 0]), which lists the labels that occur.",
)
def test_works_with_gaps(student, seed):
    rng = np.random.default_rng(seed)
    cloud, labels = clusters_around_the_origin(rng)
    names = np.sort(rng.choice(np.arange(1, 900), labels.max(), replace=False))
    assert_boxed(student, cloud, np.concatenate([[0], names])[labels])


@hidden(
    "get_bounding_boxes",
    weight=2,
    title="Orders boxes by label, whichever label comes first in the cloud",
    hint="Return the boxes in ascending order of their labels, not in the order of first "
    "occurrence.",
)
def test_orders_boxes_by_label(student, seed):
    rng = np.random.default_rng(seed)
    cloud, labels = clusters_around_the_origin(rng)
    assert_boxed(student, cloud, np.concatenate([[0], rng.permutation(labels.max()) + 1])[labels])


@hidden(
    "get_bounding_boxes",
    weight=2,
    title="Ignores points with label 0, whatever their number and their values",
    hint="Use only rows with a label above 0, whatever the other rows contain.",
)
def test_ignores_noise(student, seed):
    rng = np.random.default_rng(seed)
    cloud, labels = clusters_around_the_origin(rng)
    stray = rng.uniform(-40, 40, (60, 3))
    stray[::9] = np.nan
    cloud = np.vstack([stray[:30], cloud, stray[30:]])
    assert_boxed(student, cloud, np.pad(labels, 30))


@hidden(
    "get_bounding_boxes",
    weight=2,
    title="Works for points in {} order of x + y + z",
    hint="Compare every point with both the minimum and the maximum: use `if` twice, not `elif`.",
)
@pytest.mark.parametrize("step", [1, -1], ids=["ascending", "descending"])
def test_works_for_any_order_of_points(student, seed, step):
    cloud, labels = drop_noise_and_intensity(*street_clusters(seed))
    order = np.lexsort([step * cloud.sum(axis=1), labels])
    assert_boxed(student, cloud[order], labels[order])


@hidden(
    "get_bounding_boxes",
    weight=2,
    title="Works when all coordinates are {}",
    hint="Start the minimum at np.inf and the maximum at -np.inf, or both at the first point.",
)
@pytest.mark.parametrize("corner", [-1, 1], ids=["below zero", "above zero"])
def test_works_in_all_directions(student, seed, corner):
    rng = np.random.default_rng(seed)
    cloud = rng.uniform(5, 9, (60, 3)) * corner
    assert_boxed(student, *put_means_first(cloud, rng.integers(1, 4, 60)))


@hidden(
    "get_bounding_boxes",
    weight=2,
    title="Works on one point, two points, equal points and points on a line",
    hint="Use the same code for every cluster: a box may be flat, or consist of eight equal "
    "corners.",
)
def test_works_on_few_points(student, seed):
    rng = np.random.default_rng(seed)
    place = rng.uniform(-9, 9, (1, 3))
    pair = rng.uniform(-9, 9, (2, 3))
    line = place + np.outer(np.linspace(0, 3, 7), [1.0, -0.5, 0.2])
    cloud = np.vstack([place, pair, np.repeat(place, 5, axis=0), line])
    assert_boxed(student, cloud, np.repeat([1, 2, 3, 4], [1, 2, 5, 7]))
    assert_boxed(student, place, np.array([1]))
    assert_boxed(student, line, np.ones(7, dtype=int))


@hidden(
    "get_bounding_boxes",
    weight=2,
    title="Works on clouds with intensity",
    hint="Use only the first three columns, cloud[:, :3], because they are the coordinates.",
)
def test_works_with_intensity(student, seed):
    rng = np.random.default_rng(seed)
    cloud, labels = clusters_around_the_origin(rng)
    assert_boxed(student, np.column_stack([cloud, rng.uniform(-50, 50, len(cloud))]), labels)


@hidden(
    "get_bounding_boxes",
    weight=1,
    title="Works with float32 points and with 32-bit labels",
    hint="Select rows with cluster_labels == label, which works for every type of number.",
)
def test_works_with_other_number_types(student, seed):
    cloud, labels = clusters_around_the_origin(np.random.default_rng(seed))
    assert_boxed(student, cloud.astype(np.float32), labels)
    assert_boxed(student, cloud, labels.astype(np.int32))


@hidden(
    "get_bounding_boxes",
    weight=1,
    title="Works with hundreds of clusters",
    hint="Return one box for each label above 0, however many there are.",
)
def test_works_with_many_clusters(student, seed):
    assert_boxed(student, *clusters_around_the_origin(np.random.default_rng(seed), 300, 12))


@hidden(
    "get_bounding_boxes",
    weight=1,
    title="Works on a cloud without clusters",
    hint="Without clusters, return an array of shape (0, 8, 3).",
)
def test_works_without_clusters(student, seed):
    require_three_boxes(student.get_bounding_boxes)
    cloud, none = np.random.default_rng(seed).uniform(-30, 30, (600, 3)), np.zeros(600, dtype=int)
    as_cluster_boxes(student.get_bounding_boxes(cloud.copy(), none.copy()), none)


@hidden(
    "get_bounding_boxes",
    weight=1,
    title="Does not change the cloud or the labels if some points are noise",
    hint="Write the boxes into a new array, and leave the cloud and the labels unchanged.",
)
def test_leaves_its_input_unchanged(student, seed):
    require_three_boxes(student.get_bounding_boxes)
    cloud, labels = clusters_around_the_origin(np.random.default_rng(seed))
    strays = np.random.default_rng(seed).uniform(-40, 40, (20, 3))
    assert_untouched(
        student.get_bounding_boxes, np.vstack([cloud, strays]), np.pad(labels, (0, 20))
    )
