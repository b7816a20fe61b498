"""Visible checks of `euclidean_clustering_accelerated`.

Separate checks cover correctness and speed. Any rule that joins cells is right on the timed clouds,
and the clouds that need an exact rule are small.
"""

import functools
from collections.abc import Callable, Iterator
from math import ceil
from time import thread_time

import numpy as np

from utils.checks import common_checks, common_cluster_checks
from utils.checks.assertions import (
    CheckFailed,
    as_labels,
    assert_partition,
    brief,
    frozen,
    needs,
    timed,
)
from utils.checks.cluster_mistakes import (
    cut_line,
    distance_mistakes,
    frozen_cases,
    label_mistakes,
    labels_on_a_line,
    length,
    lines_of_points,
    on_a_line,
    same_clusters,
)
from utils.checks.clusters import (
    GROUPS,
    LABELS,
    assert_clusters,
    assert_from_one,
    assert_integer_labels,
    assert_numbered_by_appearance,
    assert_separates_at_the_threshold,
    assert_works,
    in_order,
    row_of_points,
)
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.failures import fixed
from utils.checks.lesson_10.steps import SEVEN_POINTS, WIDE_THRESHOLD

_NAME = "euclidean_clustering_accelerated"
# Side of a cell whose diagonal is the threshold, in thresholds.
_CELL_SIDE = 1 / np.sqrt(3)


@visible(
    _NAME,
    weight=3,
    title="Groups far apart are clusters of their own",
    why="A cluster is an obstacle: two cars must not become one, nor one car two.",
    hint="From pieces of cells to points: label_of_cell[cell_of_point].",
)
def separates_groups(euclidean_clustering_accelerated: Callable) -> None:
    assert_clusters(euclidean_clustering_accelerated(GROUPS.copy(), 1.0), LABELS, GROUPS, 1.0)


@visible(
    _NAME,
    weight=4,
    title="The seven points of the lesson: six of them hang together",
    why="Each of the three steps has its part in them.",
    hint="If you go by the three steps: run each on the seven points, in the cells where they are "
    "written. Which is the first to differ from what is expected?",
)
def clusters_the_seven(euclidean_clustering_accelerated: Callable) -> None:
    labels = np.array([1, 1, 1, 1, 1, 1, 2])
    assert_clusters(
        euclidean_clustering_accelerated(SEVEN_POINTS.copy(), WIDE_THRESHOLD),
        labels,
        SEVEN_POINTS,
        WIDE_THRESHOLD,
    )


@visible(
    _NAME,
    weight=8,
    title="Labels are the whole numbers 1 to N",
    why='Later lessons use 0 for "no obstacle" and count by the largest label.',
    hint="Pieces count from 0, labels from 1.",
)
def counts_from_one(euclidean_clustering_accelerated: Callable) -> None:
    assert_works(euclidean_clustering_accelerated)
    assert_from_one(euclidean_clustering_accelerated(GROUPS.copy(), 1.0), len(GROUPS))


@visible(
    _NAME,
    weight=3,
    title="A chain of neighbours is one cluster, however long",
    why="A wall crosses dozens of cells and is one obstacle.",
    hint="Joining must go on: cell to cell to cell. connected_components does that for all "
    "joined pairs at once.",
)
def follows_chains(euclidean_clustering_accelerated: Callable) -> None:
    wall = row_of_points([2.0, 1.0, 0.5], 0.3, 40, (0.6, 0.8, 0.0))
    cloud = np.vstack([wall, wall + [0.0, 0.0, 8.0]])
    order = np.random.default_rng(5).permutation(len(cloud))
    answer = euclidean_clustering_accelerated(cloud[order], 1.0)
    assert_clusters(answer, np.repeat([1, 2], 40)[order], cloud[order], 1.0)


@visible(
    _NAME,
    weight=4,
    title="Pairs just below the threshold join, in every direction and across borders",
    why="A short cut that looks only at the nearest cells tears whatever has few points: poles, "
    "signs, people far away.",
    hint="With cells of side threshold / sqrt(3), close points lie up to two cells apart "
    "along each axis: 5 x 5 x 5 cells, corners included.",
)
def joins_across_borders(euclidean_clustering_accelerated: Callable) -> None:
    assert_works(euclidean_clustering_accelerated)
    cloud = _pairs_of_points(0.99)
    labels = np.repeat(np.arange(len(cloud) // 2), 2)
    assert_clusters(euclidean_clustering_accelerated(cloud.copy(), 1.0), labels, cloud, 1.0)


@visible(
    _NAME,
    weight=4,
    title="Pairs just above the threshold stay apart",
    why="Sharing a cell, or lying in the next one, is no proof of being close: half a metre "
    "parts a pedestrian from a car.",
    hint="Is the side of a cell threshold / sqrt(3), so that no two points in it are too "
    "far apart? Is the distance of points in neighbouring cells really measured?",
)
def parts_what_is_apart(euclidean_clustering_accelerated: Callable) -> None:
    assert_works(euclidean_clustering_accelerated)
    for cloud in (_pairs_of_points(1.01), _diagonal_pairs()):
        answer = euclidean_clustering_accelerated(cloud.copy(), 1.0)
        assert_clusters(answer, np.arange(len(cloud)), cloud, 1.0)


@visible(
    _NAME,
    weight=5,
    title="Pairs just above the threshold stay apart, also where the cloud begins with a heap",
    why="A scan begins with thousands of returns of the same wall. What lies far behind it must "
    "not run together for that.",
    hint="Are the two points that you measure really points of the two cells? The row of a cell in "
    "the list of cells is not the row of a point in the cloud.",
)
def parts_behind_a_heap(euclidean_clustering_accelerated: Callable) -> None:
    assert_works(euclidean_clustering_accelerated)
    pairs = _pairs_of_points(1.01)
    with needs("pairs just above the threshold stay apart, where nothing else is"):
        answer = euclidean_clustering_accelerated(pairs.copy(), 1.0)
        assert_partition(answer, np.arange(len(pairs)), pairs)
    # The heap has more points within 0.2 m than the cloud has cells.
    heap = np.random.default_rng(2).uniform(-8.2, -8.0, (2 * len(pairs), 3))
    cloud = np.vstack([heap, pairs])
    labels = np.concatenate([np.zeros(len(heap), dtype=int), 1 + np.arange(len(pairs))])
    answer = euclidean_clustering_accelerated(cloud.copy(), 1.0)
    assert_clusters(answer, labels, cloud, 1.0)


@visible(
    _NAME,
    weight=4,
    title="Cells around the sensor are as large as all others",
    why="The sensor is where coordinates change their sign, and right there stands our own car.",
    hint="Below zero, np.floor and .astype(int) differ: .astype(int) alone rounds towards 0.",
)
def parts_around_the_sensor(euclidean_clustering_accelerated: Callable) -> None:
    assert_works(euclidean_clustering_accelerated)
    with needs("pairs just above the threshold stay apart, away from the sensor"):
        pairs = _pairs_of_points(1.01)
        answer = euclidean_clustering_accelerated(pairs.copy(), 1.0)
        assert_partition(answer, np.arange(len(pairs)), pairs)
    for centre, direction in _across_zero():
        pair = centre + np.outer([-0.505, 0.505], direction)
        answer = euclidean_clustering_accelerated(pair.copy(), 1.0)
        assert_clusters(answer, np.array([1, 2]), pair, 1.0)


@visible(
    _NAME,
    weight=6,
    title="Finds the one close pair of two crowded cells",
    why="Two bumpers touch at a single point. If only one point of each cell is asked, one "
    "obstacle becomes two, and which one depends on the order of the scan.",
    hint="Representatives far apart prove nothing. Where the pieces of two neighbouring cells "
    "still differ, compare their points: is any pair closer than the threshold? Then all cells of "
    "the one piece get the label of the other.",
)
def compares_the_points(euclidean_clustering_accelerated: Callable) -> None:
    assert_works(euclidean_clustering_accelerated)
    cloud, labels = _touching_rods()
    assert_clusters(euclidean_clustering_accelerated(cloud.copy(), 0.3), labels, cloud, 0.3)


@visible(
    _NAME,
    weight=19,
    title="Right on the far end of the lesson's own street",
    why="This is the scan that the picture above shows.",
    hint="The picture of the pieces after two steps shows the same end of the street. Draw your "
    "labels there, and beside them those of join_all_pairs: what is torn, what runs together?",
)
def clusters_the_street(euclidean_clustering_accelerated: Callable) -> None:
    assert_works(euclidean_clustering_accelerated)
    cloud, labels = _end_of_the_street()
    assert_clusters(euclidean_clustering_accelerated(cloud.copy(), 0.5), labels, cloud, 0.5)


@visible(
    _NAME,
    weight=6,
    title="The parameter threshold decides which points are close",
    why="The threshold decides what counts as one object, and it decides the size of a cell.",
    hint="Everything scales with the parameter threshold: sides, neighbours and distances, also "
    "in the exact step.",
)
def follows_the_threshold(euclidean_clustering_accelerated: Callable) -> None:
    # Gaps of 0.1, 1 and 10 m, so that each threshold joins a different number of points.
    cloud = row_of_points([2.0, 1.0, 1.0], 0.1, 2)
    cloud = np.vstack([cloud, cloud + [1.1, 0.0, 0.0], cloud[:1] + [11.2, 0.0, 0.0]])
    for threshold, labels in (
        (0.3, [1, 1, 2, 2, 3]),
        (3.0, [1, 1, 1, 1, 2]),
        (30.0, [1, 1, 1, 1, 1]),
    ):
        answer = euclidean_clustering_accelerated(cloud.copy(), threshold)
        assert_clusters(answer, np.array(labels), cloud, threshold)
    # Two points in neighbouring cells, so that the exact step decides. They are closer than 0.5 m,
    # but not closer than 0.3 m.
    pair = np.array([2.0, 1.0, 1.0]) + np.outer([0.0, 0.4], np.ones(3) / np.sqrt(3))
    with needs("points in neighbouring cells that are not close stay apart"):
        answer = euclidean_clustering_accelerated(pair / 0.6, 0.5)
        assert_partition(answer, np.array([1, 2]), pair)
    answer = euclidean_clustering_accelerated(pair.copy(), 0.3)
    assert_clusters(answer, np.array([1, 2]), pair, 0.3)
    # Pairs in neighbouring cells that are slightly more than 2 m apart.
    cloud = 2.0 * _pairs_of_points(1.01)[:40]
    with needs("pairs just above the threshold stay apart"):
        answer = euclidean_clustering_accelerated(cloud / 2, 1.0)
        assert_partition(answer, np.arange(len(cloud)), cloud)
    answer = euclidean_clustering_accelerated(cloud.copy(), 2.0)
    assert_clusters(answer, np.arange(len(cloud)), cloud, 2.0)


_CASE = common_cluster_checks.case_of(__name__, _NAME)
common_cluster_checks.default(
    _CASE,
    "keeps_the_default",
    why="Later cells call euclidean_clustering_accelerated(obstacles) and rely on it.",
)
common_checks.names(
    _CASE,
    "keeps_the_names",
    why="Other programs may call euclidean_clustering_accelerated(cloud, threshold=0.3).",
)


@visible(
    _NAME,
    weight=2,
    title="Measures in x, y and z",
    why="A bridge is above the road, not on it.",
    hint="cloud[:, :3] are the coordinates, all three of them.",
)
def measures_in_space(euclidean_clustering_accelerated: Callable) -> None:
    assert_works(euclidean_clustering_accelerated)
    for direction in np.eye(3):
        cloud = np.vstack([GROUPS, GROUPS + 20.0 * direction])
        labels = np.concatenate([LABELS, LABELS + 3])
        assert_clusters(euclidean_clustering_accelerated(cloud.copy(), 1.0), labels, cloud, 1.0)


common_cluster_checks.intensity(
    _CASE,
    "ignores_intensity",
    why="A number plate is bright, not far away. Many recordings count intensity from 0 to 255.",
    weight=8,
)
common_cluster_checks.few_points(
    _CASE,
    "takes_the_smallest",
    why="Filters leave nothing now and then.",
    hint="Return an array of length 0 early when len(cloud) == 0. A list of pairs may be "
    "empty, too.",
    weight=2,
)
common_cluster_checks.equal_points(
    _CASE,
    "joins_equal_points",
    hint="Equal points share a cell, so that there is nothing to measure.",
)
common_cluster_checks.untouched(_CASE, "leaves_its_input")


# ---- in time -----------------------------------------------------------------------------------


@visible(
    _NAME,
    weight=4,
    title="Many points on many objects are clustered quickly",
    why="The scanner delivers ten times as many points, ten times a second.",
    hint="Where is the time spent? Comparing each point with all others takes n * n steps, "
    "however short each is. Work with cells: their number is what counts.",
)
def is_quick(euclidean_clustering_accelerated: Callable) -> None:
    # Fourteen walls at least 3 m apart, with points every 0.1 m.
    wall = np.stack(np.meshgrid(np.arange(25) * 0.1, [0.0], np.arange(20) * 0.1), axis=-1)
    places = np.array([[6.0 * (index % 5), 3.0 * (index // 5), 0.0] for index in range(14)])
    cloud = (wall.reshape(1, -1, 3) + places[:, None]).reshape(-1, 3)
    order = np.random.default_rng(6).permutation(len(cloud))
    labels = np.repeat(np.arange(14), 500)[order]
    assert_in_time(euclidean_clustering_accelerated, cloud[order], labels, 90)


@visible(
    _NAME,
    weight=16,
    title="A heap of points costs no list of all its pairs",
    why="A wet wall just in front of the sensor, or two merged scans, put thousands of points "
    "close together: the pairs of near points are then the square of the points, and fill the "
    "memory.",
    hint="Points that share a cell of side threshold / sqrt(3) share a cluster: no pair of points "
    "inside has to be listed or measured.",
)
def takes_a_heap(euclidean_clustering_accelerated: Callable) -> None:
    cloud, labels = _two_heaps(2500, 5.0)
    assert_in_time(euclidean_clustering_accelerated, cloud, labels, 25)


@visible(
    _NAME,
    weight=12,
    title="Two heaps side by side cost no table of their distances",
    why="The exact test of two cells is the old trouble in a corner that no street shows: "
    "thousands of points against thousands.",
    hint="The closest pair of two cells needs no table of all distances between them: "
    "cKDTree(p).query(q) finds the nearest in p for each in q.",
)
def takes_two_heaps(euclidean_clustering_accelerated: Callable) -> None:
    # The gap is slightly larger than the threshold, so the exact test cannot stop early.
    cloud, labels = _two_heaps(3000, 0.51)
    assert_in_time(euclidean_clustering_accelerated, cloud, labels, 20)


def assert_in_time(
    euclidean_clustering: Callable, cloud: np.ndarray, labels: np.ndarray, times: float
) -> None:
    """Assert that clusters at 0.5 m are right and take at most a multiple of a reference time.

    The reference is one search for the nearest neighbour of each point. It takes n log n steps,
    and more time on a slow machine. A right answer, even in plain Python, needs at most a fifth of
    the allowed time. Processor time is measured, so that other programs have no influence.

    Parameters
    ----------
    euclidean_clustering : callable
    cloud : numpy.ndarray, shape (n, 3)
    labels : numpy.ndarray of int, shape (n,)
        The right clusters.
    times : float
        Allowed time, as a multiple of the reference.
    """
    assert_works(euclidean_clustering)
    allowed = times * min(_seconds_to_find_neighbours(cloud) for _ in range(3))
    best = np.inf
    for attempt in range(3):  # repeat, because other load may disturb a single run
        answer, seconds = timed(euclidean_clustering, cloud, 0.5)
        best = min(best, seconds)
        assert_timed_clusters(answer, labels, cloud)
        if best <= allowed or (attempt and best > 3 * allowed):
            break
    if best > allowed:
        raise CheckFailed(
            f"The clusters are right, but took {ceil(best / allowed * times)} times as long as "
            "finding the nearest neighbour of every point.",
            given=f"{len(cloud)} points; threshold 0.5 m",
            yours=f"{best:.2f} s of processor time",
            expected=f"less than {times:.0f} times as long, {allowed:.2f} s",
        )


def assert_timed_clusters(answer: object, labels: np.ndarray, cloud: np.ndarray) -> None:
    """Assert that the clusters of a timed call are right, and hint at correctness if not.

    Parameters
    ----------
    answer : object
    labels : numpy.ndarray of int, shape (n,)
        The right clusters.
    cloud : numpy.ndarray, shape (n, 3)
    """
    try:
        assert_partition(answer, labels, cloud)
    except CheckFailed as failure:
        failure.hint = (
            "This is not about time: the clusters are wrong. First the checks of small clouds."
        )
        raise


def _seconds_to_find_neighbours(cloud: np.ndarray) -> float:
    from scipy.spatial import cKDTree

    # Use thread time: while a timer like the judge's watches process time, Linux updates the latter
    # only once per tick. A quick machine needs less than a tick.
    begin = thread_time()
    cKDTree(cloud).query(cloud, k=2)
    return thread_time() - begin


def _two_heaps(n: int, gap: float) -> tuple[np.ndarray, np.ndarray]:
    """Return two heaps of n points within 0.1 m, `gap` metres apart, and their labels."""
    rng = np.random.default_rng(3)
    heaps = rng.uniform(0, 0.1, (2, n, 3))
    heaps[1, :, 0] += 0.1 + gap
    order = rng.permutation(2 * n)
    return heaps.reshape(-1, 3)[order] + 3.05, np.repeat([1, 2], n)[order]


# ---- notes, which cost no points ---------------------------------------------------------------


@noted(
    _NAME,
    title="Labels are whole numbers by type",
    why="Labels serve as row numbers further down, and floating point numbers cannot: let the "
    "answer end with .astype(int).",
)
def has_whole_labels(euclidean_clustering_accelerated: Callable) -> None:
    assert_integer_labels(euclidean_clustering_accelerated)


@noted(
    _NAME,
    title="The numbers of the clusters have no gaps",
    why="Later lessons count obstacles by the largest label. Where pieces are joined in the exact "
    "step a number falls out: count anew at the end.",
)
def leaves_no_gaps(euclidean_clustering_accelerated: Callable) -> None:
    cloud, _ = _touching_rods()
    assert_from_one(euclidean_clustering_accelerated(cloud, 0.3), len(cloud))


@noted(
    _NAME,
    title="Clusters are numbered as they first appear in the cloud",
    why="The docstring says so. With other numbers two answers cannot be compared label by "
    "label: with lesson 05, or from one scan to the next. np.argsort once gives an order; the "
    "argsort of that gives the ranks.",
)
def numbers_by_appearance(euclidean_clustering_accelerated: Callable) -> None:
    assert_numbered_by_appearance(euclidean_clustering_accelerated)
    # From near to far the points are in rows 1, 2 and 0; this order differs from its ranks.
    cloud = np.outer([9.0, 1.0, 5.0], [1.0, 0.0, 0.0])
    labels = as_labels(euclidean_clustering_accelerated(cloud.copy(), 1.0), 3)
    if not np.array_equal(labels, in_order(labels)):
        raise CheckFailed(
            f"Three points far apart have the labels {brief(labels)}, {fixed('not [1, 2, 3]')}."
        )


@noted(
    _NAME,
    title="Two points exactly at the threshold are not close",
    why='The docstring says "closer than", which is <; on measured points it hardly ever matters, '
    "on a regular grid it does.",
)
def parts_at_the_threshold(euclidean_clustering_accelerated: Callable) -> None:
    assert_separates_at_the_threshold(euclidean_clustering_accelerated)


# ---- clouds ------------------------------------------------------------------------------------


@functools.cache
def _end_of_the_street() -> tuple[np.ndarray, np.ndarray]:
    """Return the obstacle points 20 to 40 m ahead in the course's scan, and their clusters.

    If the distance of two points is within 1 mm of the threshold, 0.5 m, one of them is left out.
    """
    from scipy.spatial import cKDTree

    from utils.datasets import load_cloud

    xyz = load_cloud("cloud.txt")[:, :3]
    x, y, z = xyz.T
    xyz = xyz[(x > 20) & (x < 40) & (np.abs(y) < 7) & (z > -1.2)]
    pairs = cKDTree(xyz).query_pairs(0.501, output_type="ndarray")
    doubtful = pairs[length(xyz[pairs[:, 0]] - xyz[pairs[:, 1]]) > 0.499, 1]
    xyz = np.delete(xyz, np.unique(doubtful), axis=0)
    return frozen(xyz), frozen(
        _connected_labels(len(xyz), cKDTree(xyz).query_pairs(0.5, output_type="ndarray"))
    )


def _connected_labels(n: int, pairs: np.ndarray) -> np.ndarray:
    """Return the labels of n points that are joined by pairs, shape (k, 2)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(pairs), dtype=bool), pairs.T), shape=(n, n))
    return connected_components(graph, directed=False)[1]


def _pairs_of_points(gap: float) -> np.ndarray:
    """Return 120 pairs of points `gap` metres apart in various directions; shape (240, 3).

    Different pairs are far from each other.
    """
    indices, directions = np.arange(120), _directions(120)
    places = np.column_stack([indices % 11, indices // 11, 0 * indices]) * 6.0 + 4
    places += np.random.default_rng(7).uniform(0, 1, (120, 3))
    return np.stack([places, places + gap * directions], axis=1).reshape(-1, 3)


def _diagonal_pairs() -> np.ndarray:
    """Return 100 pairs of points 1.01 m apart; shape (200, 3).

    Each pair fits into a cell with the side 1 / sqrt(2) m.
    """
    grid = np.stack(np.meshgrid(np.arange(10), np.arange(10), [0]), axis=-1).reshape(-1, 3)
    corners = (7 * grid + 1) / np.sqrt(2)
    low = corners + np.random.default_rng(5).uniform(0.005, 0.115, corners.shape)
    return np.stack([low, low + 1.01 * _CELL_SIDE], axis=1).reshape(-1, 3)


def _touching_rods() -> tuple[np.ndarray, np.ndarray]:
    """Return pairs of rods, shape (n, 3), of which only the facing ends are close at 0.3 m.

    The second result has the labels of the points.
    """
    rng = np.random.default_rng(8)
    rod = np.column_stack([np.linspace(0, 0.57, 15), np.zeros((15, 2))])
    clouds = []
    for index in range(30):
        rods = np.vstack([rod, rod + [0.57 + 0.56, 0.0, 0.0]])
        rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        place = np.array([3.0 + 8 * (index % 6), 3.0 + 8 * (index // 6), 3.0])
        clouds.append(rods @ rotation.T + place + rng.uniform(0, 0.6, 3))
    order = rng.permutation(30 * 30)
    return 0.3 * np.vstack(clouds)[order], np.repeat(np.arange(30), 30)[order]


def _directions(n: int) -> np.ndarray:
    vectors = np.random.default_rng(4).normal(size=(n, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _across_zero() -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield centres and directions, both of shape (3,), of pairs that reach across zero.

    All coordinates change their sign between the two points, or one coordinate alone.
    """
    for direction in _directions(8):
        yield np.zeros(3), direction
    for axis in np.eye(3):
        direction = 0.26 + 0.68 * axis
        yield 0.25 * (1 - axis), direction / np.linalg.norm(direction)


# ---- common mistakes ---------------------------------------------------------------------------


def _joined_by_cells(side: float, joins: Callable, rounding: Callable = np.floor) -> Callable:
    """Return the prediction of a mistake that joins neighbours on a line by their cells.

    Parameters
    ----------
    side : float
        Side of a cell in thresholds.
    joins : callable
        Takes three arrays with an entry for each pair of neighbours and returns which are joined:
        their distance in thresholds, the steps between their cells, and the distance in thresholds
        between the first points of these cells.
    rounding : callable
        Takes coordinates in cells; returns the cells.
    """

    def predicts(right: np.ndarray, cloud: np.ndarray, threshold: float) -> np.ndarray:
        def are_joined(line: np.ndarray, order: np.ndarray) -> np.ndarray:
            places = line[:, :3] / threshold
            steps = np.abs(np.diff(rounding(places / side), axis=0)).max(axis=1)
            cells = np.concatenate([[0], np.cumsum(steps > 0)])
            by_cell = np.lexsort((order, cells))  # within a cell, sorted by row in the cloud
            first = by_cell[np.searchsorted(cells, cells)]
            gaps, firsts = (length(np.diff(points, axis=0)) for points in (places, places[first]))
            return joins(gaps, steps, firsts)

        return cut_line(cloud, are_joined)

    return predicts


def _joined_by_rows(takes_points: bool) -> Callable:
    """Return the prediction of a mistake that confuses cells and points in the cheap step.

    With `takes_points` it takes the rows of two cells for rows of points. Otherwise it measures the
    distance between cells, in cells, and compares it with metres. The exact step still joins all
    points that are close.
    """

    def predicts(right: np.ndarray, cloud: np.ndarray, threshold: float) -> np.ndarray:
        from scipy.spatial import cKDTree

        xyz = cloud[:, :3]
        cells, cell_of_point = np.unique(
            np.floor(xyz / (threshold * _CELL_SIDE)), axis=0, return_inverse=True
        )
        measured, cell_of_point = (xyz if takes_points else cells), cell_of_point.ravel()
        pairs = cKDTree(cells).query_pairs(2.5, p=np.inf, output_type="ndarray")
        joined = pairs[length(measured[pairs[:, 0]] - measured[pairs[:, 1]]) < threshold]
        representatives = np.unique(cell_of_point, return_index=True)[1]
        _, start, piece = np.unique(right, return_index=True, return_inverse=True)
        same = np.column_stack([start[piece], np.arange(len(right))])
        return in_order(_connected_labels(len(cloud), np.vstack([same, representatives[joined]])))

    return predicts


def _same(answer: object, predicted: np.ndarray) -> bool:
    """Return whether an answer groups the points as predicted and has the same smallest label."""
    try:
        yours = as_labels(answer, len(predicted))
    except CheckFailed:
        return False
    return same_clusters(in_order(yours) + yours.min(), in_order(predicted) + predicted.min())


# Directions, and places along them in thresholds. A cell is 0.577 long along an axis, so close
# points may be two cells apart. It is 1 long along the diagonal, so points that share a larger cell
# may be too far apart.
_AXIS = ([1.0, 0.0, 0.0], [0.52, 14.46, -0.53, 5.21, 15.5, 4.6, 10.9, 9.25, 14.98, 20.3])
_DIAGONAL = (
    [_CELL_SIDE, _CELL_SIDE, _CELL_SIDE],
    [0.6, 16.05, 12.2, 5.25, -0.7, 11.05, 17.75, 6.75, 16.95, 22.4],
)


def _lines_across_cells() -> tuple[tuple[np.ndarray, float], ...]:
    """Return cases, (cloud, threshold), in which every rule about cells gives other clusters."""
    cases = []
    for threshold, (direction, places) in ((0.8, _AXIS), (1.2, _DIAGONAL)):
        for scale in (threshold, -1.5 * threshold):
            cases.append((on_a_line(scale * np.array(places), direction=direction), abs(scale)))
    # Two points on both sides of the sensor are not close, however cells are rounded. A function
    # that adds coordinates instead of subtracting them joins these points.
    cases.append((on_a_line([0.6, -0.5, 9.0, 9.4], direction=_AXIS[0]), 1.0))
    return frozen_cases(cases)


def _lines_behind_a_heap() -> tuple[tuple[np.ndarray, float], ...]:
    """Return cases that begin with a heap; the cells behind it have no close points."""
    cases = []
    for threshold in (0.7, 1.4, 2.1):
        behind = 3.05 + 1.15 * np.arange(8)
        places = np.concatenate([np.linspace(0.45, 0.55, 9), behind])
        cases.append((on_a_line(threshold * places, direction=_DIAGONAL[0]), threshold))
    return frozen_cases(cases)


mistakes(
    _NAME,
    *distance_mistakes(),
    Mistake(
        "Cells have the side threshold: two points in one may be 1.7 thresholds apart.",
        _joined_by_cells(1.0, lambda gaps, steps, firsts: (gaps < 1) | (steps == 0)),
        "The side is threshold / sqrt(3): then the diagonal is the threshold.",
    ),
    Mistake(
        "Cells have the side threshold / sqrt(2), which is right in the plane only.",
        _joined_by_cells(1 / np.sqrt(2), lambda gaps, steps, firsts: (gaps < 1) | (steps == 0)),
        "In space the diagonal is side * sqrt(3): the side is threshold / sqrt(3).",
    ),
    Mistake(
        "Neighbouring cells are joined without measuring, or at too large a distance.",
        _joined_by_cells(_CELL_SIDE, lambda gaps, steps, firsts: steps <= 2),
        "Neighbours may be close: join them if a point of the one is closer than the threshold to "
        "a point of the other.",
    ),
    Mistake(
        "Only the next cell on each side is looked at; close points may be two cells apart.",
        _joined_by_cells(_CELL_SIDE, lambda gaps, steps, firsts: (steps <= 1) & (gaps < 1)),
        "5 x 5 x 5 cells, corners included: query_pairs(2, p=np.inf).",
    ),
    Mistake(
        "Two cells whose representatives are far apart stay apart, also where other points of "
        "theirs are close.",
        _joined_by_cells(_CELL_SIDE, lambda gaps, steps, firsts: (steps == 0) | (firsts < 1)),
        "Where the pieces of two neighbouring cells still differ, compare all their points, and "
        "go on with what comes of it.",
    ),
    Mistake(
        "Each cell is a cluster: none are joined.",
        _joined_by_cells(_CELL_SIDE, lambda gaps, steps, firsts: steps == 0),
        "Join neighbouring cells that hold close points, and number the pieces.",
    ),
    Mistake(
        "Cells are rounded towards 0: those around the sensor are twice as wide.",
        _joined_by_cells(
            _CELL_SIDE, lambda gaps, steps, firsts: (gaps < 1) | (steps == 0), np.trunc
        ),
        "np.floor rounds down on both sides of 0; .astype(int) alone does not.",
    ),
    *label_mistakes(),
    Mistake(
        "The rows of two cells are taken for rows of points: what is measured are points that have "
        "nothing to do with these cells.",
        _joined_by_rows(takes_points=True),
        "pairs[:, 0] are rows of cells, first[pairs[:, 0]] are rows of points: "
        "points[first[pairs[:, 0]]].",
    ),
    Mistake(
        "The distance is measured from cell to cell, in cells, and compared with metres.",
        _joined_by_rows(takes_points=False),
        "Measure between representatives: points[first[pairs[:, 0]]], and not cells[pairs[:, 0]].",
    ),
    cases=(*lines_of_points(), *_lines_across_cells(), *_lines_behind_a_heap()),
    right=labels_on_a_line,
    same=_same,
)
