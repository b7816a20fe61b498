"""Clouds and assertions shared by the checks of the two clustering lessons."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks.assertions import (
    CheckFailed,
    as_array,
    as_labels,
    assert_partition,
    brief_text,
    count_overlaps,
    frozen,
    point_text,
    precondition,
)
from utils.checks.failures import fixed
from utils.checks.run_cache import once_per_run

# The search for a wrong pair of points computes n² distances, so larger clouds are not searched.
_MAX_COMPARED_POINTS = 1000


def row_of_points(
    start: Sequence[float], step: float, n: int, along: Sequence[float] = (1.0, 0.0, 0.0)
) -> np.ndarray:
    """Return evenly spaced points on a straight line.

    Parameters
    ----------
    start : sequence of float
        The first point, in metres.
    step : float
        Distance between neighbours, in metres.
    n : int
        Number of points.
    along : sequence of float
        Direction: a unit vector.

    Returns
    -------
    numpy.ndarray, shape (n, 3)
    """
    return np.array(start) + np.outer(np.arange(n) * step, along)


def renumber_by_appearance(labels: ArrayLike) -> np.ndarray:
    """Relabel clusters as 1, 2, ... in the order of their first points; shape (n,)."""
    _, first, which = np.unique(labels, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[which] + 1


def _three_groups() -> tuple[np.ndarray, np.ndarray]:
    groups = [
        row_of_points([2.0, 1.0, 0.5], 0.1, 4),
        row_of_points([8.0, 1.5, 0.5], 0.1, 3),
        row_of_points([3.0, 7.0, 0.5], 0.1, 3),
    ]
    order = np.array([7, 9, 0, 1, 4, 8, 5, 2, 3, 6])
    return np.vstack(groups)[order], renumber_by_appearance(np.repeat([1, 2, 3], [4, 3, 3])[order])


# These groups are so dense and so far apart that a function finds them even if it handles chains,
# cells or units wrongly.
GROUPS, LABELS = frozen(_three_groups())


@once_per_run
def require_simplest_clusters(euclidean_clustering: Callable) -> None:
    """Assert that the function finds the simplest clusters; raise `NotYet` if not.

    The function must separate groups that are far apart, and join a row of neighbours.
    """
    with precondition("groups of points that are far apart become separate clusters"):
        assert_partition(euclidean_clustering(GROUPS.copy(), 1.0), LABELS, GROUPS)
    with precondition("a chain of neighbours becomes one cluster"):
        row = row_of_points([2.0, 0.0, 0.0], 0.45, 7)
        assert_partition(euclidean_clustering(row.copy(), 0.8), np.ones(7, int), row)


def assert_clusters(
    answer: object, expected: np.ndarray, cloud: np.ndarray, threshold: float
) -> None:
    """Assert that the points are grouped as in `expected`; a failure names a pair of points.

    Parameters
    ----------
    answer : object
    expected : numpy.ndarray of int, shape (n,)
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    threshold : float
    """
    try:
        assert_partition(answer, expected, cloud)
    except CheckFailed as failure:
        if failure.is_about_the_check and len(cloud) <= _MAX_COMPARED_POINTS:
            yours = as_labels(answer, len(cloud))
            i, j = _nearest_wrong_pair(yours, expected, cloud)
            failure.input_text = _pair_text(i, j, yours, cloud, threshold)
            pair = cloud[[i, j], :2]
            gap, span = (np.ptp(points[:, :2], axis=0).max() for points in (pair, cloud))
            if 0 < gap < 0.03 * span:
                # Two markers so close together would cover each other in a picture of all points.
                margin = max(5 * gap, 0.5)
                limits = np.stack([pair.min(axis=0) - margin, pair.max(axis=0) + margin], axis=1)
                failure.draw = lambda: utils.plots.worst(cloud, yours, expected, limits=limits)
            failure.yours, failure.expected = _labels_text(yours), _labels_text(expected)
        raise


def keeps_clusters_whole(answer: object, expected: np.ndarray) -> bool:
    """Return whether an answer keeps every cluster of `expected` in one piece.

    Parameters
    ----------
    answer : object
    expected : numpy.ndarray of int, shape (n,)
    """
    shared, _, number_expected = count_overlaps(as_labels(answer, len(expected)), expected)
    return shared == number_expected


def _labels_text(labels: np.ndarray) -> str:
    count = cluster_count_text(labels[labels != 0])
    return f"{count}, labels {brief_text(labels)}" if len(labels) <= 12 else count


def cluster_count_text(labels: np.ndarray) -> str:
    """Return the number of clusters as text, such as "3 clusters"."""
    count = len(np.unique(labels))
    return "1 cluster" if count == 1 else f"{count} clusters"


def _nearest_wrong_pair(
    yours: np.ndarray, expected: np.ndarray, cloud: np.ndarray
) -> tuple[int, int]:
    """Return the rows of the nearest two points that are wrongly joined or wrongly separated."""
    wrong = (yours[:, None] == yours) != (expected[:, None] == expected)
    gaps = np.linalg.norm(cloud[:, None, :3] - cloud[None, :, :3], axis=2)
    return np.unravel_index(np.argmin(np.where(wrong, gaps, np.inf)), gaps.shape)


def _pair_text(i: int, j: int, yours: np.ndarray, cloud: np.ndarray, threshold: float) -> str:
    labels = "the same label" if yours[i] else "the label 0"
    if yours[i] != yours[j]:
        labels = "different labels"
    gap = np.linalg.norm(cloud[i, :3] - cloud[j, :3])
    return (
        f"points {i} and {j}, at {point_text(cloud[i])} and {point_text(cloud[j])}, "
        f"{gap:.2f} m apart; threshold {threshold:g} m. They have {labels}"
    )


def assert_labels_from_one(answer: object, n: int) -> None:
    """Assert that the labels are the numbers from 1 to the number of clusters.

    Parameters
    ----------
    answer : object
    n : int
        Number of points.
    """
    found = np.unique(as_labels(answer, n))
    wanted = np.arange(1, len(found) + 1)
    if not np.array_equal(found, wanted):
        raise CheckFailed(
            fixed("The labels are not 1 to N, where N is the number of clusters."),
            yours=brief_text(found),
            expected=brief_text(wanted),
        )


def assert_integer_labels(euclidean_clustering: Callable) -> None:
    """Assert that labels have an integer type."""
    kind = as_array(euclidean_clustering(GROUPS.copy(), 1.0)).dtype
    if kind.kind not in "iu":
        raise CheckFailed(f"The labels have the type {kind}.")


def assert_numbered_by_appearance(euclidean_clustering: Callable) -> None:
    """Assert that clusters are numbered by their first points, beginning with 1."""
    # The first point is isolated, so code that starts with another point numbers it differently.
    cloud = np.vstack([[-6.0, -8.0, 0.5], GROUPS])
    labels = as_labels(euclidean_clustering(cloud.copy(), 1.0), len(cloud))
    if not np.array_equal(labels, renumber_by_appearance(labels)):
        raise CheckFailed(
            f"The first labels are {brief_text(labels[:5])} instead of "
            f"{brief_text(renumber_by_appearance(labels)[:5])}."
        )


def assert_is_array(euclidean_clustering: Callable) -> None:
    """Assert that the labels are an array, not a list or tuple."""
    answer = euclidean_clustering(GROUPS.copy(), 1.0)
    if isinstance(answer, (list, tuple)):
        raise CheckFailed(f"The labels are a {type(answer).__name__}.")


def assert_separates_at_the_threshold(euclidean_clustering: Callable) -> None:
    """Assert that two points at exactly the threshold have different labels."""
    pair = np.array([[2.0, 0.0, 0.0], [2.5, 0.0, 0.0]])
    labels = as_labels(euclidean_clustering(pair, 0.5), 2)
    if labels[0] == labels[1]:
        raise CheckFailed(
            fixed("With a threshold of 0.5 m, two points 0.5 m apart are in one cluster.")
        )
