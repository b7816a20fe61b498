"""Visible checks of lesson 09: `filter_clusters`."""

from collections.abc import Callable

import numpy as np

import utils
from utils.checks.core import visible
from utils.checks.vocabulary import (
    CheckFailed,
    as_labels,
    assert_new_array,
    assert_untouched,
    frozen,
)

# Clusters of 5, 1, 2, 4, 3 and 2 points, neither sorted nor in one piece.
_LABELS = frozen(np.array([1, 1, 2, 3, 1, 4, 4, 3, 1, 5, 4, 1, 5, 6, 4, 5, 6]))


def assert_filtered(answer: object, labels: np.ndarray, expected: np.ndarray) -> None:
    """The answer is `expected`; where not, say which of the usual mistakes it looks like.

    Parameters
    ----------
    answer : object
    labels : numpy.ndarray of int, shape (n,)
        What the function was given.
    expected : numpy.ndarray of int, shape (n,)
    """
    yours = as_labels(answer, len(labels))
    if np.array_equal(yours, expected):
        return
    sides = {"yours": _counted(yours), "expected": _counted(expected)}
    noise = labels == 0
    if yours[noise].any():
        raise CheckFailed("Points with label 0 belong to no cluster and keep the 0.", **sides)
    if (yours < 0).any():
        raise CheckFailed(
            "Points of removed clusters get the label 0, not a negative one.", **sides
        )
    if np.array_equal(yours > 0, expected > 0):
        raise CheckFailed(
            "The right points are left, but clusters changed their labels. What "
            "stays keeps its label, gaps and all.",
            **sides,
        )
    gone, left = (
        np.unique(labels[(yours == 0) & (expected > 0)]),
        np.unique(labels[(yours > 0) & (expected == 0)]),
    )
    parts = [
        f"{_of(labels, cluster)} should be {'gone' if cluster in left else 'left'}"
        for cluster in [*left[:1], *gone[:1]]
    ]
    text = "; ".join(parts)
    raise CheckFailed(
        f"{text[0].upper()}{text[1:]}.", **sides, draw=lambda: _draw(labels, yours, expected)
    )


def _draw(labels: np.ndarray, yours: np.ndarray, expected: np.ndarray) -> None:
    """Draw each cluster as a row of points, the label as its height."""
    place = np.array([np.count_nonzero(labels[:i] == label) for i, label in enumerate(labels)])
    names, row = np.unique(labels, return_inverse=True)
    limits = ((-1, place.max() + 1), (-1, len(names)))
    panels = utils.plots.worst(
        np.column_stack([place, row.ravel()]),
        yours,
        expected,
        limits=limits,
        title="One row for each cluster",
    )
    for panel in panels:
        panel.set_aspect("auto")
        panel.set_xlabel("its points")
        panel.set_ylabel("old label")
        if len(names) <= 12:
            panel.set_yticks(range(len(names)), names)


def _of(labels: np.ndarray, cluster: int) -> str:
    count = np.count_nonzero(labels == cluster)
    return f"cluster {cluster}, of {count} point{'s' if count != 1 else ''},"


def _counted(labels: np.ndarray) -> str:
    """Labels above 0 that are in use, and the number of points without one, in few words."""
    found = np.unique(labels[labels > 0]).tolist()
    names = ", ".join(map(str, found[:8])) + (", ..." if len(found) > 8 else "")
    return f"clusters {names or 'none'}; {np.count_nonzero(labels <= 0)} points of noise"


@visible(
    "filter_clusters",
    weight=4,
    title="Clusters with too few points become 0, the others keep their label",
    why="Later steps draw a box around every label above 0: each drop of spray that stays "
    "is an obstacle to brake for.",
    hint="First count how often each label occurs. Then decide point by point, from the "
    "count of its label.",
)
def removes_small_clusters(filter_clusters: Callable) -> None:
    assert_filtered(
        filter_clusters(_LABELS.copy(), 3),
        _LABELS,
        np.array([1, 1, 0, 0, 1, 4, 4, 0, 1, 5, 4, 1, 5, 0, 4, 5, 0]),
    )


@visible(
    "filter_clusters",
    weight=4,
    title="Removes every small cluster, also one that follows another",
    why="Clutter comes in swarms. Whoever moves the labels up while walking along them skips "
    "the neighbour of each cluster that went.",
    hint="Change no label but to 0. If you loop, read the labels from the original and write "
    "into a copy.",
)
def removes_neighbours(filter_clusters: Callable) -> None:
    labels = np.repeat([1, 2, 3, 4, 5, 6, 7], [1, 2, 1, 6, 2, 1, 5])
    assert_filtered(
        filter_clusters(labels.copy(), 4),
        labels,
        np.repeat([0, 0, 0, 4, 0, 0, 7], [1, 2, 1, 6, 2, 1, 5]),
    )


@visible(
    "filter_clusters",
    weight=3,
    title="A cluster of exactly min_num_points stays; the parameter decides, the default is 100",
    why="How many points an obstacle has depends on the scanner, so each car sets its own minimum.",
    hint='"Fewer than" is <, not <=. Compare with the parameter, by its name, and keep its '
    "default of 100.",
)
def follows_the_minimum(filter_clusters: Callable) -> None:
    labels = np.repeat([1, 2, 3], [99, 100, 101])
    for minimum, kept in ((99, [1, 2, 3]), (100, [0, 2, 3]), (101, [0, 0, 3]), (102, [0, 0, 0])):
        expected = np.repeat(kept, [99, 100, 101])
        assert_filtered(filter_clusters(labels.copy(), minimum), labels, expected)
        assert_filtered(
            filter_clusters(cluster_labels=labels.copy(), min_num_points=minimum), labels, expected
        )
    assert_filtered(filter_clusters(labels.copy()), labels, np.repeat([0, 2, 3], [99, 100, 101]))


@visible(
    "filter_clusters",
    weight=3,
    title="Label 0 stays 0, however many points have it; labels may have gaps",
    why="Other steps set noise to 0, too. It must not come back as one huge obstacle.",
    hint="Go by the labels that occur, from np.unique, not by range(1, N): 7 may be there "
    "without 6.",
)
def leaves_noise_alone(filter_clusters: Callable) -> None:
    labels = np.array([0, 7, 0, 7, 0, 40, 7, 0, 0, 3, 0, 40])
    assert_filtered(
        filter_clusters(labels.copy(), 3), labels, np.array([0, 7, 0, 7, 0, 0, 7, 0, 0, 0, 0, 0])
    )


@visible(
    "filter_clusters",
    weight=2,
    title="Takes no points, one point, and all points in one cluster",
    why="After the other filters nothing may be left, or a single wall.",
    hint="max() of an empty array is an error; np.unique of one is not.",
)
def takes_the_smallest(filter_clusters: Callable) -> None:
    nothing = np.empty(0, dtype=int)
    assert_filtered(filter_clusters(nothing, 2), nothing, nothing)
    for labels, minimum, expected in (
        ([1], 1, [1]),
        ([1], 2, [0]),
        ([5, 5, 5], 3, [5, 5, 5]),
        ([5, 5, 5], 4, [0, 0, 0]),
    ):
        assert_filtered(
            filter_clusters(np.array(labels), minimum), np.array(labels), np.array(expected)
        )


@visible(
    "filter_clusters",
    weight=2,
    title="Returns a new array and leaves its input untouched",
    why="Somebody may want to try another minimum on the same labels.",
    hint="Start from cluster_labels.copy(), or let np.where build a new array.",
)
def leaves_its_input(filter_clusters: Callable) -> None:
    assert_untouched(filter_clusters, _LABELS, 3)
    assert_new_array(filter_clusters, _LABELS, 1)
    answer = filter_clusters(_LABELS.copy(), 3)
    assert_filtered(answer, _LABELS, np.array([1, 1, 0, 0, 1, 4, 4, 0, 1, 5, 4, 1, 5, 0, 4, 5, 0]))
