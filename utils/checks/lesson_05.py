"""Visible checks of lesson 05: `euclidean_clustering`."""

from collections.abc import Callable, Sequence

import numpy as np

from utils.checks.core import visible
from utils.checks.vocabulary import (
    CheckFailed,
    as_labels,
    assert_partition,
    assert_untouched,
    frozen,
)


def _line(start: Sequence[float], step: float, n: int) -> np.ndarray:
    """A row of points (n, 3) along x, `step` metres apart."""
    return np.array(start) + np.outer(np.arange(n) * step, [1.0, 0.0, 0.0])


def _mixed(step: float) -> tuple[np.ndarray, np.ndarray]:
    """Three groups far apart whose points come in any order, and their labels."""
    groups = [
        _line([2.0, 1.0, 0.0], step, 4),
        _line([8.0, -2.0, 0.5], step, 3),
        _line([3.0, -6.0, 0.2], step, 3),
    ]
    order = np.array([7, 0, 4, 1, 8, 5, 2, 9, 3, 6])
    return np.vstack(groups)[order], np.repeat([1, 2, 3], [4, 3, 3])[order]


_GROUPS, _LABELS = frozen(_mixed(0.3))
# The same, so tight that even balls around a first point get them right: for checks of something
# else, which should not fail, with a hint that misleads, because chains break.
_TIGHT, _ = frozen(_mixed(0.1))


@visible(
    "euclidean_clustering",
    weight=4,
    title="Groups far apart are clusters of their own",
    why="A cluster is an obstacle: two cars must not become one, nor one car two.",
    hint="Take a point without a label, give it a new label, then give the same label to "
    "everything that can be reached from it.",
)
def separates_groups(euclidean_clustering: Callable) -> None:
    assert_partition(euclidean_clustering(_GROUPS.copy(), 0.5), _LABELS, _GROUPS)


@visible(
    "euclidean_clustering",
    weight=6,
    title="A chain of neighbours is one cluster, however long",
    why="A wall is metres long and its ends are far apart, but it is one obstacle.",
    hint="Each point that you label must itself be asked for its neighbours: put it into "
    "the queue. Comparing with the first point only finds a ball.",
)
def follows_chains(euclidean_clustering: Callable) -> None:
    wall = _line([0.0, 0.0, 0.0], 0.4, 30)
    order = np.random.default_rng(5).permutation(60)
    cloud = np.vstack([wall, wall + [0.0, 3.0, 0.0]])[order]
    labels = np.repeat([1, 2], 30)[order]
    assert_partition(euclidean_clustering(cloud.copy(), 0.5), labels, cloud)


@visible(
    "euclidean_clustering",
    weight=3,
    title="Labels are the whole numbers 1 to N",
    why='Later lessons use 0 for "belongs to no obstacle" and count obstacles by the '
    "largest label.",
    hint="The first cluster gets 1. The counter goes up when a new cluster begins, not at "
    "each point.",
)
def counts_from_one(euclidean_clustering: Callable) -> None:
    labels = as_labels(euclidean_clustering(_GROUPS.copy(), 0.5), len(_GROUPS))
    found = np.unique(labels)
    assert_partition(labels, _LABELS, _GROUPS)
    if not np.array_equal(found, np.arange(1, len(found) + 1)):
        raise CheckFailed(
            "The labels in use are not 1 to N.",
            yours=str(found.tolist()),
            expected=str(list(range(1, len(found) + 1))),
        )


@visible(
    "euclidean_clustering",
    weight=4,
    title="Follows threshold, given by position, by name or left out",
    why="The threshold decides what counts as one object: at half a metre parked cars stay "
    "apart, at two metres a cyclist melts into the car beside.",
    hint="Compare distances with the parameter threshold itself: not its square, not 0.5 "
    "written into the function. Keep its default of 0.5.",
)
def follows_the_threshold(euclidean_clustering: Callable) -> None:
    # Gaps of 0.2, 0.45, 0.6 and 0.9 m: each threshold below joins a different number.
    x = np.cumsum([0.0, 0.2, 0.45, 0.6, 0.9])
    cloud = np.column_stack([x, 0 * x, 0 * x])
    for threshold, labels in (
        (0.3, [1, 1, 2, 3, 4]),
        (0.5, [1, 1, 1, 2, 3]),
        (0.7, [1, 1, 1, 1, 2]),
        (1.0, [1, 1, 1, 1, 1]),
    ):
        assert_partition(euclidean_clustering(cloud.copy(), threshold), np.array(labels), cloud)
        assert_partition(
            euclidean_clustering(cloud=cloud.copy(), threshold=threshold), np.array(labels), cloud
        )
    assert_partition(euclidean_clustering(cloud.copy()), np.array([1, 1, 1, 2, 3]), cloud)


@visible(
    "euclidean_clustering",
    weight=3,
    title="Measures distance in x, y and z, and not in intensity",
    why="A white stripe on a black bumper is bright, not far away; and a bridge is above "
    "the road, not on it.",
    hint="cloud[:, :3] are the coordinates; a fourth column, if there is one, is not.",
)
def ignores_intensity(euclidean_clustering: Callable) -> None:
    bright = np.column_stack([_TIGHT, np.tile([0.0, 0.9], 5)])
    assert_partition(euclidean_clustering(bright.copy(), 0.5), _LABELS, bright)
    above = np.vstack([_line([2.0, 1.0, 0.0], 0.1, 3), _line([2.0, 1.0, 2.0], 0.1, 3)])
    above, labels = above[[0, 3, 1, 4, 5, 2]], np.array([1, 2, 1, 2, 2, 1])
    assert_partition(euclidean_clustering(above.copy(), 0.5), labels, above)


@visible(
    "euclidean_clustering",
    weight=2,
    title="Takes an empty cloud, one point and equal points",
    why="After filtering nothing may be left, and recordings do hold the same point twice.",
    hint="A loop over the points does nothing when there are none: an array of length 0 is "
    "the answer. Equal points are at distance 0 and belong together.",
)
def takes_the_smallest(euclidean_clustering: Callable) -> None:
    for columns in (3, 4):
        assert_partition(
            euclidean_clustering(np.empty((0, columns)), 0.5),
            np.empty(0, dtype=int),
            np.empty((0, columns)),
        )
    one = np.array([[1.0, 2.0, 3.0]])
    assert_partition(euclidean_clustering(one.copy(), 0.5), np.array([1]), one)
    equal = np.array([[1.0, 2.0, 3.0], [5.0, 0.0, 0.0], [1.0, 2.0, 3.0], [5.0, 9.0, 0.0]])
    assert_partition(euclidean_clustering(equal.copy(), 0.5), np.array([1, 2, 1, 3]), equal)


@visible(
    "euclidean_clustering",
    weight=1,
    title="Leaves its input untouched",
    why="The next step of the pipeline still needs the cloud.",
    hint="Keep labels in an array of their own; do not write into cloud.",
)
def leaves_its_input(euclidean_clustering: Callable) -> None:
    assert_untouched(euclidean_clustering, _TIGHT, 0.5)
    labels = euclidean_clustering(_TIGHT.copy(), 0.5)
    assert_partition(labels, _LABELS, _TIGHT)
