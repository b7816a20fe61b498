"""What the checks of the two lessons on clustering share."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from utils.checks.assertions import (
    CheckFailed,
    as_array,
    as_labels,
    assert_partition,
    brief,
    frozen,
    needs,
    point_text,
)
from utils.checks.failures import fixed
from utils.checks.run_cache import once

# In larger clouds nobody looks for the pair of points that shows what is wrong.
_MOST_COMPARED = 1000


def row_of_points(
    start: Sequence[float], step: float, n: int, along: Sequence[float] = (1.0, 0.0, 0.0)
) -> np.ndarray:
    """A row of points, `step` metres apart.

    Parameters
    ----------
    start : sequence of float
        The first point (m).
    step : float
    n : int
    along : sequence of float
        Direction, of length 1.

    Returns
    -------
    numpy.ndarray, shape (n, 3)
    """
    return np.array(start) + np.outer(np.arange(n) * step, along)


def in_order(labels: ArrayLike) -> np.ndarray:
    """The same clusters, numbered 1, 2, ... as they first appear; shape (n,)."""
    _, first, which = np.unique(labels, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[which] + 1


def _three_groups() -> tuple[np.ndarray, np.ndarray]:
    groups = [
        row_of_points([2.0, 1.0, 0.5], 0.1, 4),
        row_of_points([8.0, 1.5, 0.5], 0.1, 3),
        row_of_points([3.0, 7.0, 0.5], 0.1, 3),
    ]
    order = np.array([7, 9, 0, 1, 4, 8, 5, 2, 3, 6])
    return np.vstack(groups)[order], in_order(np.repeat([1, 2, 3], [4, 3, 3])[order])


# Groups so tight, and so far apart, that a slip about chains, cells or metres gets them right.
GROUPS, LABELS = frozen(_three_groups())


@once
def assert_works(euclidean_clustering: Callable) -> None:
    """Groups far apart are told apart; where not, no other property can be looked at."""
    with needs("groups of points far apart are clusters of their own"):
        assert_partition(euclidean_clustering(GROUPS.copy(), 1.0), LABELS, GROUPS)


def assert_clusters(
    answer: object, expected: np.ndarray, cloud: np.ndarray, threshold: float
) -> None:
    """The points are grouped as `expected`; where not, a pair of points shows it.

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
        if failure.is_about_the_check and len(cloud) <= _MOST_COMPARED:
            yours = as_labels(answer, len(cloud))
            failure.given = _telling_pair(yours, expected, cloud, threshold)
            failure.yours, failure.expected = _in_words(yours), _in_words(expected)
        raise


def _in_words(labels: np.ndarray) -> str:
    return f"{counted(labels)}, labels {brief(labels)}" if len(labels) <= 12 else counted(labels)


def counted(labels: np.ndarray) -> str:
    """The number of clusters, in words."""
    count = len(np.unique(labels))
    return "1 cluster" if count == 1 else f"{count} clusters"


def _telling_pair(
    yours: np.ndarray, expected: np.ndarray, cloud: np.ndarray, threshold: float
) -> str:
    """The nearest two points of which a labelling says what is not so."""
    wrong = (yours[:, None] == yours) != (expected[:, None] == expected)
    gaps = np.linalg.norm(cloud[:, None, :3] - cloud[None, :, :3], axis=2)
    one, other = np.unravel_index(np.argmin(np.where(wrong, gaps, np.inf)), gaps.shape)
    said = "one label" if yours[one] == yours[other] else "two labels"
    return (
        f"points {one} and {other}, at {point_text(cloud[one])} and {point_text(cloud[other])}, "
        f"{gaps[one, other]:.2f} m apart; threshold {threshold:g} m. They have {said}"
    )


def assert_from_one(answer: object, n: int) -> None:
    """The labels in use are 1 to N.

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
            fixed("The labels in use are not 1 to N, the number of clusters."),
            yours=brief(found),
            expected=brief(wanted),
        )


def assert_whole(euclidean_clustering: Callable) -> None:
    """Labels have a type of whole numbers."""
    kind = as_array(euclidean_clustering(GROUPS.copy(), 1.0)).dtype
    if kind.kind not in "iu":
        raise CheckFailed(f"The labels are of type {kind}.")


def assert_numbered_by_appearance(euclidean_clustering: Callable) -> None:
    """The first point is in cluster 1, and so on."""
    # The first point stands alone: whoever begins with another one numbers it otherwise.
    cloud = np.vstack([[-6.0, -8.0, 0.5], GROUPS])
    labels = as_labels(euclidean_clustering(cloud.copy(), 1.0), len(cloud))
    if not np.array_equal(labels, in_order(labels)):
        raise CheckFailed(f"Labels are {brief(labels[:5])}, not {brief(in_order(labels)[:5])}.")


def assert_an_array(euclidean_clustering: Callable) -> None:
    """Labels are an array."""
    answer = euclidean_clustering(GROUPS.copy(), 1.0)
    if isinstance(answer, (list, tuple)):
        raise CheckFailed(f"The labels are a {type(answer).__name__}.")


def assert_parts_at_the_threshold(euclidean_clustering: Callable) -> None:
    """A pair exactly a threshold apart has two labels."""
    pair = np.array([[2.0, 0.0, 0.0], [2.5, 0.0, 0.0]])
    labels = as_labels(euclidean_clustering(pair, 0.5), 2)
    if labels[0] == labels[1]:
        raise CheckFailed(
            fixed("Two points 0.5 m apart are in one cluster at the threshold 0.5 m.")
        )
