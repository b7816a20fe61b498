"""Visible checks of lesson 10: `euclidean_clustering_accelerated`."""

from collections.abc import Callable, Sequence
from time import perf_counter

import numpy as np

from utils.checks.core import visible
from utils.checks.vocabulary import (
    CheckFailed,
    as_labels,
    assert_partition,
    assert_untouched,
    frozen,
)

# Comparing 20 000 points with each other takes longer than this; every short cut is far below.
SECONDS = 4.0


def _row(
    start: Sequence[float], step: float, n: int, along: Sequence[float] = (1.0, 0.0, 0.0)
) -> np.ndarray:
    """A row of points (n, 3) on a straight line, `step` metres apart."""
    return np.array(start) + np.outer(np.arange(n) * step, along)


_THREE = frozen(
    np.vstack(
        [
            _row([2.0, 1.0, 0.0], 0.3, 5),
            _row([8.0, -2.0, 0.5], 0.3, 3),
            _row([-6.0, 4.0, -1.0], 0.4, 2),
        ]
    )
)
_THREE_LABELS = frozen(np.repeat([1, 2, 3], [5, 3, 2]))


@visible(
    "euclidean_clustering_accelerated",
    weight=3,
    title="Three groups far apart are three clusters, labelled 1 to 3",
    why='A cluster is an obstacle. Later lessons use 0 for "no obstacle" and count by the '
    "largest label.",
    hint="From pieces of cells to points: label_of_cell[cell_of_point]. Pieces count from 0, "
    "labels from 1.",
)
def separates_groups(euclidean_clustering_accelerated: Callable) -> None:
    labels = as_labels(euclidean_clustering_accelerated(_THREE.copy(), 0.5), len(_THREE))
    assert_partition(labels, _THREE_LABELS, _THREE)
    found = np.unique(labels).tolist()
    if found != list(range(1, len(found) + 1)):
        raise CheckFailed(
            "The labels in use are not 1 to N.",
            yours=str(found),
            expected=str(list(range(1, len(found) + 1))),
        )


@visible(
    "euclidean_clustering_accelerated",
    weight=3,
    title="A chain of neighbours is one cluster, however long",
    why="A wall crosses dozens of cells and is one obstacle.",
    hint="Joining must go on: cell to cell to cell. connected_components does that for all "
    "joined pairs at once.",
)
def follows_chains(euclidean_clustering_accelerated: Callable) -> None:
    wall = _row([-6.0, 0.0, 0.0], 0.4, 40, (0.6, 0.8, 0.0))
    cloud = np.vstack([wall, wall + [0.0, 3.0, 0.0]])
    order = np.random.default_rng(5).permutation(len(cloud))
    assert_partition(
        euclidean_clustering_accelerated(cloud[order], 0.5),
        np.repeat([1, 2], 40)[order],
        cloud[order],
    )


@visible(
    "euclidean_clustering_accelerated",
    weight=4,
    title="Pairs just below the threshold join, in every direction and across borders",
    why="A short cut that looks only at the nearest cells tears thin things: poles, signs, people.",
    hint="With cells of side threshold / sqrt(3), close points lie up to two cells apart "
    "along each axis: 5 x 5 x 5 cells, corners included.",
)
def joins_across_borders(euclidean_clustering_accelerated: Callable) -> None:
    cloud, labels = _pairs_of_points(0.99, 120)
    assert_partition(euclidean_clustering_accelerated(cloud.copy(), 0.5), labels, cloud)


@visible(
    "euclidean_clustering_accelerated",
    weight=4,
    title="Pairs just above the threshold stay apart",
    why="Sharing a cell, or lying in the next one, is no proof of being close: half a metre "
    "parts a pedestrian from a car.",
    hint="Is the side of a cell threshold / sqrt(3), so that nobody in it is too far from "
    "anybody else? Is the distance of points in neighbouring cells really measured? And "
    "below zero np.floor and .astype(int) differ.",
)
def parts_what_is_apart(euclidean_clustering_accelerated: Callable) -> None:
    cloud, _ = _pairs_of_points(1.01, 120)
    assert_partition(
        euclidean_clustering_accelerated(cloud.copy(), 0.5), np.arange(1, len(cloud) + 1), cloud
    )


@visible(
    "euclidean_clustering_accelerated",
    weight=4,
    title="Finds the one close pair of two crowded cells",
    why="Two bumpers touch at a single point. If only one point of each cell is asked, one "
    "obstacle becomes two, and which one depends on the order of the scan.",
    hint="Representatives far apart prove nothing. Where the pieces of two neighbouring cells "
    "still differ, compare their points: is any pair closer than the threshold?",
)
def compares_the_points(euclidean_clustering_accelerated: Callable) -> None:
    rng = np.random.default_rng(8)
    clouds, labels = [], []
    for number in range(40):
        # Two rods of 0.28 m, 0.49 m apart at their ends, or 0.51 m; other points are farther.
        rod = np.column_stack([np.linspace(0, 0.28, 15), np.zeros((15, 2))])
        joined = number % 2 == 0
        both = np.vstack([rod, rod + [0.28 + (0.49 if joined else 0.51), 0.0, 0.0]])
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        place = np.array([number % 7, number // 7, 0.0]) * 4 - 12
        clouds.append(both @ turn.T + place + rng.uniform(0, 0.3, 3))
        labels.append(np.repeat([2 * number + 1, 2 * number + 1 + (not joined)], 15))
    order = rng.permutation(40 * 30)
    cloud, labels = np.vstack(clouds)[order], np.concatenate(labels)[order]
    assert_partition(euclidean_clustering_accelerated(cloud.copy(), 0.5), labels, cloud)


@visible(
    "euclidean_clustering_accelerated",
    weight=3,
    title="Follows threshold, given by position, by name or left out",
    why="The threshold decides what counts as one object, and it decides the size of a cell.",
    hint="Everything scales with the parameter threshold: sides, neighbours and distances. "
    "Keep its default of 0.5.",
)
def follows_the_threshold(euclidean_clustering_accelerated: Callable) -> None:
    x = np.cumsum([0.0, 0.2, 0.45, 0.6, 0.9])
    cloud = np.column_stack([x, 0 * x, 0 * x])
    for threshold, labels in (
        (0.3, [1, 1, 2, 3, 4]),
        (0.5, [1, 1, 1, 2, 3]),
        (0.7, [1, 1, 1, 1, 2]),
        (1.0, [1, 1, 1, 1, 1]),
    ):
        for answer in (
            euclidean_clustering_accelerated(cloud.copy(), threshold),
            euclidean_clustering_accelerated(cloud=cloud.copy(), threshold=threshold),
        ):
            assert_partition(answer, np.array(labels), cloud)
    assert_partition(
        euclidean_clustering_accelerated(cloud.copy()), np.array([1, 1, 1, 2, 3]), cloud
    )


@visible(
    "euclidean_clustering_accelerated",
    weight=2,
    title="Measures in x, y and z, and not in intensity",
    why="A number plate is bright, not far away.",
    hint="cloud[:, :3] are the coordinates; a fourth column, if there is one, is not.",
)
def ignores_intensity(euclidean_clustering_accelerated: Callable) -> None:
    bright = np.column_stack([_THREE, np.linspace(0, 9, len(_THREE))])
    assert_partition(euclidean_clustering_accelerated(bright.copy(), 0.5), _THREE_LABELS, bright)
    above = np.vstack([_THREE[:5], _THREE[:5] + [0.0, 0.0, 2.0]])
    assert_partition(
        euclidean_clustering_accelerated(above.copy(), 0.5), np.repeat([1, 2], 5), above
    )


@visible(
    "euclidean_clustering_accelerated",
    weight=2,
    title="Takes an empty cloud, one point and equal points, and leaves its input untouched",
    why="Filters leave nothing now and then, and the next step still needs the cloud.",
    hint="Return an array of length 0 early when len(cloud) == 0. A list of pairs may be "
    "empty, too.",
)
def takes_the_smallest(euclidean_clustering_accelerated: Callable) -> None:
    for columns in (3, 4):
        empty = np.empty((0, columns))
        assert_partition(
            euclidean_clustering_accelerated(empty, 0.5), np.empty(0, dtype=int), empty
        )
    one = np.array([[1.0, 2.0, 3.0]])
    assert_partition(euclidean_clustering_accelerated(one.copy(), 0.5), np.array([1]), one)
    equal = np.array([[1.0, 2.0, 3.0], [5.0, 0.0, 0.0], [1.0, 2.0, 3.0]])
    labels = euclidean_clustering_accelerated(equal.copy(), 0.5)
    assert_partition(labels, np.array([1, 2, 1]), equal)
    assert_untouched(euclidean_clustering_accelerated, equal, 0.5)


@visible(
    "euclidean_clustering_accelerated",
    weight=3,
    title=f"Clusters 20 000 points in less than {SECONDS:.0f} seconds",
    why="The scanner delivers five times as many, ten times a second.",
    hint="Where is the time spent? Comparing each point with all others takes n * n steps, "
    "however short each is. Work with cells: their number is what counts.",
)
def is_quick(euclidean_clustering_accelerated: Callable) -> None:
    # Forty walls of 500 points, 0.1 m apart from point to point, 3 m from wall to wall.
    wall = np.stack(np.meshgrid(np.arange(25) * 0.1, [0.0], np.arange(20) * 0.1), axis=-1)
    places = np.array([[6.0 * (i % 5), 3.0 * (i // 5), 0.0] for i in range(40)]) - [10, 12, 1]
    cloud = (wall.reshape(1, -1, 3) + places[:, None]).reshape(-1, 3)
    order = np.random.default_rng(6).permutation(len(cloud))
    begin = perf_counter()
    answer = euclidean_clustering_accelerated(cloud[order], 0.5)
    seconds = perf_counter() - begin
    assert_partition(answer, np.repeat(1 + np.arange(40), 500)[order], cloud[order])
    if seconds > SECONDS:
        raise CheckFailed(
            f"The clusters are right, but they took {seconds:.1f} s.",
            yours=f"{seconds:.1f} s",
            expected=f"less than {SECONDS:.0f} s",
        )


def _pairs_of_points(share: float, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (2 n, 3) in pairs, `share` of 0.5 m apart, and their labels; pairs are far apart."""
    rng = np.random.default_rng(7)
    way = rng.normal(size=(n, 3))
    way *= 0.5 * share / np.linalg.norm(way, axis=1, keepdims=True)
    numbers = np.arange(n)
    places = np.column_stack([numbers % 11, numbers // 11, 0 * numbers]) * 2.0 - 10
    places += rng.uniform(-0.4, 0.4, (n, 3))
    # The first few lie around the sensor, where coordinates change their sign.
    places[:8] = -way[:8] / 2 + np.outer(np.arange(8), [0.0, 0.0, 6.0])
    return np.stack([places, places + way], axis=1).reshape(-1, 3), np.repeat(1 + np.arange(n), 2)
