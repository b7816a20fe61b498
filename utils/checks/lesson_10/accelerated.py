"""Visible checks of `euclidean_clustering_accelerated`.

Separate checks cover correctness and speed. On the timed clouds, any rule that joins cells gives
the right clusters. The clouds that need an exact rule are small.
"""

import functools
import time
from collections.abc import Callable, Iterator
from math import ceil

import numpy as np

from utils.checks import common_checks, common_cluster_checks
from utils.checks.assertions import (
    CheckFailed,
    as_labels,
    assert_partition,
    brief_text,
    frozen,
    precondition,
    time_call,
)
from utils.checks.cluster_mistakes import (
    distance_mistakes,
    frozen_cases,
    label_line,
    label_mistakes,
    lengths,
    line_cases,
    points_on_line,
    right_labels_of_line,
    same_clusters,
)
from utils.checks.clusters import (
    GROUPS,
    LABELS,
    assert_clusters,
    assert_integer_labels,
    assert_labels_from_one,
    assert_numbered_by_appearance,
    assert_separates_at_the_threshold,
    renumber_by_appearance,
    require_simplest_clusters,
    row_of_points,
)
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.failures import fixed
from utils.checks.lesson_10.steps import SEVEN_POINTS, WIDE_THRESHOLD

_NAME = "euclidean_clustering_accelerated"
# Side of a cell whose diagonal is the threshold, as a multiple of the threshold.
_CELL_SIDE = 1 / np.sqrt(3)


@visible_check(
    _NAME,
    weight=3,
    title="Puts groups that are far apart into separate clusters",
    why="Each cluster becomes one obstacle. Two cars must not merge, and one car must not split.",
    hint="Use the coordinates cloud[:, :3], and give each point the label of its cell, "
    "label[cell_of_point].",
)
def separates_groups(euclidean_clustering_accelerated: Callable) -> None:
    assert_clusters(euclidean_clustering_accelerated(GROUPS.copy(), 1.0), LABELS, GROUPS, 1.0)


@visible_check(
    _NAME,
    weight=4,
    title="Puts six of the lesson's seven points into one cluster",
    why="Each of the three steps joins some of these points, so the cluster splits if a step is "
    "missing.",
    hint="If you use the three steps, rerun the notebook cells that try them on the seven points. "
    "Fix the first step whose result is not the expected one.",
)
def joins_six_of_seven_points(euclidean_clustering_accelerated: Callable) -> None:
    labels = np.array([1, 1, 1, 1, 1, 1, 2])
    assert_clusters(
        euclidean_clustering_accelerated(SEVEN_POINTS.copy(), WIDE_THRESHOLD),
        labels,
        SEVEN_POINTS,
        WIDE_THRESHOLD,
    )


@visible_check(
    _NAME,
    weight=8,
    title="Gives N clusters the labels 1 to N",
    why='Later lessons use 0 for "no obstacle", and a later cell prints the largest label as the '
    "number of clusters.",
    hint="Add 1 to the ranks, or to the result of components. Both start at 0.",
)
def counts_from_one(euclidean_clustering_accelerated: Callable) -> None:
    require_simplest_clusters(euclidean_clustering_accelerated)
    assert_labels_from_one(euclidean_clustering_accelerated(GROUPS.copy(), 1.0), len(GROUPS))


@visible_check(
    _NAME,
    weight=3,
    title="Joins a chain of neighbours into one cluster, however long it is",
    why="A wall crosses dozens of cells but is one obstacle.",
    hint="Join from cell to cell until the chain ends. connected_components does that for all "
    "joined pairs at once.",
)
def joins_chains(euclidean_clustering_accelerated: Callable) -> None:
    wall = row_of_points([2.0, 1.0, 0.5], 0.3, 40, (0.6, 0.8, 0.0))
    cloud = np.vstack([wall, wall + [0.0, 0.0, 8.0]])
    order = np.random.default_rng(5).permutation(len(cloud))
    answer = euclidean_clustering_accelerated(cloud[order], 1.0)
    assert_clusters(answer, np.repeat([1, 2], 40)[order], cloud[order], 1.0)


@visible_check(
    _NAME,
    weight=4,
    title="Joins two points that are slightly closer than the threshold, even across cell borders",
    why="A shortcut that looks only at adjacent cells splits objects with few points, such as "
    "poles, signs and distant people.",
    hint="Search 5 x 5 x 5 cells, corners included, with query_pairs(2, p=np.inf). Close points "
    "may be two cells apart along each axis.",
)
def joins_across_borders(euclidean_clustering_accelerated: Callable) -> None:
    require_simplest_clusters(euclidean_clustering_accelerated)
    cloud = _pairs_of_points(0.99)
    labels = np.repeat(np.arange(len(cloud) // 2), 2)
    assert_clusters(euclidean_clustering_accelerated(cloud.copy(), 1.0), labels, cloud, 1.0)


@visible_check(
    _NAME,
    weight=4,
    title="Does not join two points that are slightly farther apart than the threshold",
    why="Points in neighbouring cells need not be close. A gap of half a metre may separate a "
    "pedestrian from a car.",
    hint="Make the side of a cell threshold / np.sqrt(3), so that no two points in it are too far "
    "apart. Measure distances between points in neighbouring cells.",
)
def separates_pairs_above_the_threshold(euclidean_clustering_accelerated: Callable) -> None:
    require_simplest_clusters(euclidean_clustering_accelerated)
    for cloud in (_pairs_of_points(1.01), _diagonal_pairs()):
        answer = euclidean_clustering_accelerated(cloud.copy(), 1.0)
        assert_clusters(answer, np.arange(len(cloud)), cloud, 1.0)


@visible_check(
    _NAME,
    weight=5,
    title="Does not join points that are too far apart, even if the cloud begins with a dense heap",
    why="A scan may begin with thousands of returns from one wall. They must not change which of "
    "the other points are joined.",
    hint="Compute the distance between points[first[i]] and points[first[j]]. Here i and j are "
    "rows of cells, and first turns them into rows of points.",
)
def separates_pairs_behind_a_heap(euclidean_clustering_accelerated: Callable) -> None:
    require_simplest_clusters(euclidean_clustering_accelerated)
    pairs = _pairs_of_points(1.01)
    with precondition(
        "points slightly farther apart than the threshold stay separate in a cloud without a heap"
    ):
        answer = euclidean_clustering_accelerated(pairs.copy(), 1.0)
        assert_partition(answer, np.arange(len(pairs)), pairs)
    # The heap has more points in a cube of 0.2 m than the cloud has cells.
    heap = np.random.default_rng(2).uniform(-8.2, -8.0, (2 * len(pairs), 3))
    cloud = np.vstack([heap, pairs])
    labels = np.concatenate([np.zeros(len(heap), dtype=int), 1 + np.arange(len(pairs))])
    answer = euclidean_clustering_accelerated(cloud.copy(), 1.0)
    assert_clusters(answer, labels, cloud, 1.0)


@visible_check(
    _NAME,
    weight=4,
    title="Uses cells of the same size everywhere, even around the sensor",
    why="Coordinates change sign at the sensor. If the cells there are larger, objects near the "
    "ego car merge.",
    hint="Call np.floor before .astype(int), because .astype(int) alone rounds towards 0.",
)
def separates_pairs_around_the_sensor(euclidean_clustering_accelerated: Callable) -> None:
    require_simplest_clusters(euclidean_clustering_accelerated)
    with precondition(
        "far from the sensor, points slightly farther apart than the threshold stay separate"
    ):
        pairs = _pairs_of_points(1.01)
        answer = euclidean_clustering_accelerated(pairs.copy(), 1.0)
        assert_partition(answer, np.arange(len(pairs)), pairs)
    for centre, direction in _pair_positions_across_zero():
        pair = centre + np.outer([-0.505, 0.505], direction)
        answer = euclidean_clustering_accelerated(pair.copy(), 1.0)
        assert_clusters(answer, np.array([1, 2]), pair, 1.0)


@visible_check(
    _NAME,
    weight=6,
    title="Finds the only close pair of points in two crowded cells",
    why="A single pair of close points may connect two parts of a car. If you compare only one "
    "point of each cell, the car may become two obstacles.",
    hint="If two neighbouring cells are still in different pieces, compare all their points. If "
    "any two are closer than the threshold, relabel the whole piece: label[label == label[j]] = "
    "label[i].",
)
def finds_the_close_pair(euclidean_clustering_accelerated: Callable) -> None:
    require_simplest_clusters(euclidean_clustering_accelerated)
    cloud, labels = _touching_rods()
    assert_clusters(euclidean_clustering_accelerated(cloud.copy(), 0.3), labels, cloud, 0.3)


@visible_check(
    _NAME,
    weight=19,
    title="Finds the right clusters at the far end of the lesson's street",
    why="A street combines most of the cases that the checks above test one by one. The picture "
    "above shows this scan.",
    hint="Draw your labels next to those of join_all_pairs, and look for clusters that are split "
    "or merged. The picture of the pieces after two steps shows the same end of the street.",
)
def clusters_the_street(euclidean_clustering_accelerated: Callable) -> None:
    require_simplest_clusters(euclidean_clustering_accelerated)
    cloud, labels = _end_of_the_street()
    assert_clusters(euclidean_clustering_accelerated(cloud.copy(), 0.5), labels, cloud, 0.5)


@visible_check(
    _NAME,
    weight=6,
    title="Uses the parameter threshold to decide which points are close",
    why="The threshold decides what counts as one object. With a wrong one, cars merge or split.",
    hint="Use the parameter threshold for the side of a cell and in every comparison of distances.",
)
def uses_the_threshold(euclidean_clustering_accelerated: Callable) -> None:
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
    # The exact step must decide about these two points, because they are in neighbouring cells.
    # They are closer than 0.5 m, but not closer than 0.3 m.
    pair = np.array([2.0, 1.0, 1.0]) + np.outer([0.0, 0.4], np.ones(3) / np.sqrt(3))
    with precondition("points in neighbouring cells stay separate if they are not close"):
        answer = euclidean_clustering_accelerated(pair / 0.6, 0.5)
        assert_partition(answer, np.array([1, 2]), pair)
    answer = euclidean_clustering_accelerated(pair.copy(), 0.3)
    assert_clusters(answer, np.array([1, 2]), pair, 0.3)
    # Pairs in neighbouring cells that are slightly more than 2 m apart.
    cloud = 2.0 * _pairs_of_points(1.01)[:40]
    with precondition("points slightly farther apart than the threshold stay separate"):
        answer = euclidean_clustering_accelerated(cloud / 2, 1.0)
        assert_partition(answer, np.arange(len(cloud)), cloud)
    answer = euclidean_clustering_accelerated(cloud.copy(), 2.0)
    assert_clusters(answer, np.arange(len(cloud)), cloud, 2.0)


_CASE = common_cluster_checks.case_of(__name__, _NAME)
common_cluster_checks.promise_default(
    _CASE,
    "keeps_the_default",
    why="Later cells call euclidean_clustering_accelerated(obstacles) without a threshold.",
)
common_checks.promise_names(
    _CASE,
    "keeps_the_names",
    why="Other code may call euclidean_clustering_accelerated(cloud, threshold=0.3).",
)


@visible_check(
    _NAME,
    weight=2,
    title="Measures distances along x, y and z",
    why="Without the height, a bridge and the road below it would become one cluster.",
    hint="Use all three coordinates, cloud[:, :3].",
)
def measures_in_space(euclidean_clustering_accelerated: Callable) -> None:
    require_simplest_clusters(euclidean_clustering_accelerated)
    for direction in np.eye(3):
        cloud = np.vstack([GROUPS, GROUPS + 20.0 * direction])
        labels = np.concatenate([LABELS, LABELS + 3])
        assert_clusters(euclidean_clustering_accelerated(cloud.copy(), 1.0), labels, cloud, 1.0)


common_cluster_checks.promise_intensity_ignored(
    _CASE,
    "ignores_intensity",
    why="A bright number plate is no farther away than the dark bumper next to it. In many "
    "recordings, intensity goes from 0 to 255.",
    weight=8,
)
common_cluster_checks.promise_few_points(
    _CASE,
    "works_on_smallest_clouds",
    why="A filter sometimes removes every point, and that must not crash the program.",
    hint="If len(cloud) == 0, return an empty array at once. The list of pairs may also be empty.",
    weight=2,
)
common_cluster_checks.promise_equal_points(
    _CASE,
    "joins_equal_points",
    hint="Give all points of a cell the same label, because equal points share a cell.",
)
common_cluster_checks.promise_untouched(_CASE, "leaves_its_input")


# ---- speed -------------------------------------------------------------------------------------


@visible_check(
    _NAME,
    weight=4,
    title="Clusters 7,000 points on fourteen walls quickly",
    why="A scan has about ten times as many points as this cloud, and ten scans arrive every "
    "second.",
    hint="Work with cells instead of points, because there are far fewer cells. Comparing each "
    "point with all others takes n * n steps.",
)
def is_quick(euclidean_clustering_accelerated: Callable) -> None:
    # Fourteen walls at least 3 m apart, with points every 0.1 m.
    wall = np.stack(np.meshgrid(np.arange(25) * 0.1, [0.0], np.arange(20) * 0.1), axis=-1)
    places = np.array([[6.0 * (index % 5), 3.0 * (index // 5), 0.0] for index in range(14)])
    cloud = (wall.reshape(1, -1, 3) + places[:, None]).reshape(-1, 3)
    order = np.random.default_rng(6).permutation(len(cloud))
    labels = np.repeat(np.arange(14), 500)[order]
    assert_in_time(euclidean_clustering_accelerated, cloud[order], labels, 90)


@visible_check(
    _NAME,
    weight=16,
    title="Clusters a dense heap of points quickly",
    why="A wet wall just in front of the sensor, or two merged scans, can put thousands of points "
    "close together. A list of all close pairs then fills the memory.",
    hint="Do not list or measure pairs of points in one cell, because points that share a cell "
    "of side threshold / np.sqrt(3) share a cluster.",
)
def is_quick_on_a_heap(euclidean_clustering_accelerated: Callable) -> None:
    cloud, labels = _two_heaps(2500, 5.0)
    assert_in_time(euclidean_clustering_accelerated, cloud, labels, 25)


@visible_check(
    _NAME,
    weight=12,
    title="Compares two neighbouring heaps quickly",
    why="Two cells with thousands of points each form millions of pairs. This happens in merged "
    "scans, but not in an ordinary street.",
    hint="Call cKDTree(p).query(q), which finds the nearest point of p for each point of q "
    "without a table of all distances.",
)
def is_quick_on_two_heaps(euclidean_clustering_accelerated: Callable) -> None:
    # The gap is slightly larger than the threshold, so the exact test cannot stop early.
    cloud, labels = _two_heaps(3000, 0.51)
    assert_in_time(euclidean_clustering_accelerated, cloud, labels, 20)


def assert_in_time(
    euclidean_clustering: Callable, cloud: np.ndarray, labels: np.ndarray, times: float
) -> None:
    """Assert that the clusters at 0.5 m are right and do not take too long to compute.

    The limit is a multiple of a reference time: one search for the nearest neighbour of each
    point. The search takes n log n steps, and more time on a slow machine. A right answer, even in
    plain Python, needs at most a fifth of the allowed time. Processor time is measured, so that
    other programs have no influence.

    Parameters
    ----------
    euclidean_clustering : callable
    cloud : numpy.ndarray, shape (n, 3)
    labels : numpy.ndarray of int, shape (n,)
        The right clusters.
    times : float
        Allowed time, as a multiple of the reference time.
    """
    require_simplest_clusters(euclidean_clustering)
    allowed = times * min(_seconds_to_find_neighbours(cloud) for _ in range(3))
    best = np.inf
    # Repeat, because other programs may slow down a run, but rarely by these factors. A run that is
    # far too slow would only use up the time for the calls that follow.
    for hopeless in (8, 3, 1):
        answer, seconds = time_call(euclidean_clustering, cloud, 0.5)
        best = min(best, seconds)
        assert_timed_clusters(answer, labels, cloud)
        if best <= allowed or best > hopeless * allowed:
            break
    if best > allowed:
        raise CheckFailed(
            f"The clusters are right, but computing them took {ceil(best / allowed * times)} "
            "times as long as finding the nearest neighbour of every point.",
            input_text=f"{len(cloud)} points; threshold 0.5 m",
            yours=f"{best:.2f} s of processor time",
            expected=f"less than {times:.0f} times as long, {allowed:.2f} s",
        )


def assert_timed_clusters(answer: object, labels: np.ndarray, cloud: np.ndarray) -> None:
    """Assert that the clusters of a timed call are right; if not, say that time is not the problem.

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
            "The time is not the problem: the clusters are wrong. Look at the checks of small "
            "clouds first."
        )
        raise


def _seconds_to_find_neighbours(cloud: np.ndarray) -> float:
    from scipy.spatial import cKDTree

    # Use thread time. While a timer such as the judge's watches process time, Linux updates
    # process time only once per tick, and a fast machine needs less than a tick. WebAssembly has
    # no thread time.
    clock = getattr(time, "thread_time", time.perf_counter)
    start = clock()
    cKDTree(cloud).query(cloud, k=2)
    return clock() - start


def _two_heaps(n: int, gap: float) -> tuple[np.ndarray, np.ndarray]:
    """Return two heaps `gap` metres apart, each of n points in a cube of 0.1 m, and the labels."""
    rng = np.random.default_rng(3)
    heaps = rng.uniform(0, 0.1, (2, n, 3))
    heaps[1, :, 0] += 0.1 + gap
    order = rng.permutation(2 * n)
    return heaps.reshape(-1, 3)[order] + 3.05, np.repeat([1, 2], n)[order]


# ---- notes, which cost no points ---------------------------------------------------------------


@note_check(
    _NAME,
    title="Returns labels of an integer type",
    why="Later cells use labels as row numbers, which must be integers. End with .astype(int).",
)
def has_integer_labels(euclidean_clustering_accelerated: Callable) -> None:
    assert_integer_labels(euclidean_clustering_accelerated)


@note_check(
    _NAME,
    title="Numbers the clusters without gaps",
    why="The docstring asks for the labels 1 to N. When the exact step joins two pieces, one "
    "number is no longer used. Number the clusters again at the end.",
)
def leaves_no_gaps(euclidean_clustering_accelerated: Callable) -> None:
    cloud, _ = _touching_rods()
    assert_labels_from_one(euclidean_clustering_accelerated(cloud, 0.3), len(cloud))


@note_check(
    _NAME,
    title="Numbers the clusters in the order of their first points",
    why="The docstring asks for this order. It lets you compare the labels with those of lesson "
    "05 one by one. np.argsort(np.argsort(start)) returns the ranks.",
)
def numbers_by_appearance(euclidean_clustering_accelerated: Callable) -> None:
    assert_numbered_by_appearance(euclidean_clustering_accelerated)
    # Sorted by distance, the points are in rows 1, 2 and 0. Their ranks are different: 2, 0 and 1.
    cloud = np.outer([9.0, 1.0, 5.0], [1.0, 0.0, 0.0])
    labels = as_labels(euclidean_clustering_accelerated(cloud.copy(), 1.0), 3)
    if not np.array_equal(labels, renumber_by_appearance(labels)):
        raise CheckFailed(
            f"Three points far apart have the labels {brief_text(labels)}, "
            f"{fixed('not [1, 2, 3]')}."
        )


@note_check(
    _NAME,
    title="Does not join two points exactly at the threshold",
    why='The docstring says "closer than", which is <. The difference hardly ever matters for '
    "measured points, but it does on a regular grid.",
)
def separates_at_the_threshold(euclidean_clustering_accelerated: Callable) -> None:
    assert_separates_at_the_threshold(euclidean_clustering_accelerated)


# ---- clouds ------------------------------------------------------------------------------------


@functools.cache
def _end_of_the_street() -> tuple[np.ndarray, np.ndarray]:
    """Return the obstacle points 20 to 40 m ahead in the course's scan, and their clusters.

    If the distance between two points is within 1 mm of the threshold, 0.5 m, one of them is left
    out.
    """
    from scipy.spatial import cKDTree

    from utils.datasets import course_street

    xyz = course_street()[0][:, :3]
    x, y, z = xyz.T
    xyz = xyz[(x > 20) & (x < 40) & (np.abs(y) < 7) & (z > -1.2)]
    pairs = cKDTree(xyz).query_pairs(0.501, output_type="ndarray")
    doubtful = pairs[lengths(xyz[pairs[:, 0]] - xyz[pairs[:, 1]]) > 0.499, 1]
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

    Each pair fits into a cell with sides of 1 / sqrt(2) m.
    """
    grid = np.stack(np.meshgrid(np.arange(10), np.arange(10), [0]), axis=-1).reshape(-1, 3)
    corners = (7 * grid + 1) / np.sqrt(2)
    low = corners + np.random.default_rng(5).uniform(0.005, 0.115, corners.shape)
    return np.stack([low, low + 1.01 * _CELL_SIDE], axis=1).reshape(-1, 3)


def _touching_rods() -> tuple[np.ndarray, np.ndarray]:
    """Return pairs of rods, shape (n, 3), and the labels of their points, shape (n,).

    Only the facing ends of two rods are closer than 0.3 m.
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


def _pair_positions_across_zero() -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield centres and directions, both of shape (3,), of pairs of points on both sides of zero.

    Between the two points, either all coordinates change their sign or only one does.
    """
    for direction in _directions(8):
        yield np.zeros(3), direction
    for axis in np.eye(3):
        direction = 0.26 + 0.68 * axis
        yield 0.25 * (1 - axis), direction / np.linalg.norm(direction)


# ---- common mistakes ---------------------------------------------------------------------------


def _prediction_from_cells(side: float, joins: Callable, rounding: Callable = np.floor) -> Callable:
    """Return the prediction for a function that joins neighbours on a line by their cells.

    Parameters
    ----------
    side : float
        Side of a cell, as a multiple of the threshold.
    joins : callable
        Takes three arrays with an entry for each pair of neighbours: their distance, the steps
        between their cells, and the distance between the first points of these cells. Distances
        are multiples of the threshold. Returns which pairs are joined.
    rounding : callable
        Rounds coordinates, measured in sides of a cell, to whole cells.
    """

    def predict(right: np.ndarray, cloud: np.ndarray, threshold: float) -> np.ndarray:
        def are_joined(line: np.ndarray, order: np.ndarray) -> np.ndarray:
            places = line[:, :3] / threshold
            steps = np.abs(np.diff(rounding(places / side), axis=0)).max(axis=1)
            cells = np.concatenate([[0], np.cumsum(steps > 0)])
            by_cell = np.lexsort((order, cells))  # within a cell, sorted by row in the cloud
            first = by_cell[np.searchsorted(cells, cells)]
            gaps, firsts = (lengths(np.diff(points, axis=0)) for points in (places, places[first]))
            return joins(gaps, steps, firsts)

        return label_line(cloud, are_joined)

    return predict


def _prediction_from_rows(uses_points: bool) -> Callable:
    """Return the prediction for a function that confuses cells and points in the cheap step.

    If `uses_points` is true, rows of cells are mistaken for rows of points. Otherwise the distance
    between two cells is counted in cells and compared with metres. In both cases the exact step
    still joins all points that are close.
    """

    def predict(right: np.ndarray, cloud: np.ndarray, threshold: float) -> np.ndarray:
        from scipy.spatial import cKDTree

        xyz = cloud[:, :3]
        cells, cell_of_point = np.unique(
            np.floor(xyz / (threshold * _CELL_SIDE)), axis=0, return_inverse=True
        )
        measured, cell_of_point = (xyz if uses_points else cells), cell_of_point.ravel()
        pairs = cKDTree(cells).query_pairs(2.5, p=np.inf, output_type="ndarray")
        joined = pairs[lengths(measured[pairs[:, 0]] - measured[pairs[:, 1]]) < threshold]
        representatives = np.unique(cell_of_point, return_index=True)[1]
        _, start, piece = np.unique(right, return_index=True, return_inverse=True)
        same = np.column_stack([start[piece], np.arange(len(right))])
        return renumber_by_appearance(
            _connected_labels(len(cloud), np.vstack([same, representatives[joined]]))
        )

    return predict


def _is_same_answer(answer: object, predicted: np.ndarray) -> bool:
    """Return whether an answer groups the points as predicted and has the same smallest label."""
    try:
        yours = as_labels(answer, len(predicted))
    except CheckFailed:
        return False
    return same_clusters(
        renumber_by_appearance(yours) + yours.min(),
        renumber_by_appearance(predicted) + predicted.min(),
    )


# Directions, and positions along them as multiples of the threshold. A cell is 0.577 long along an
# axis, so close points may be two cells apart. It is 1 long along the diagonal, so points that
# share a larger cell may be too far apart.
_AXIS = ([1.0, 0.0, 0.0], [0.52, 14.46, -0.53, 5.21, 15.5, 4.6, 10.9, 9.25, 14.98, 20.3])
_DIAGONAL = (
    [_CELL_SIDE, _CELL_SIDE, _CELL_SIDE],
    [0.6, 16.05, 12.2, 5.25, -0.7, 11.05, 17.75, 6.75, 16.95, 22.4],
)


def _lines_across_cells() -> tuple[tuple[np.ndarray, float], ...]:
    """Return cases (cloud, threshold) for which each wrong rule about cells changes clusters."""
    cases = []
    for threshold, (direction, places) in ((0.8, _AXIS), (1.2, _DIAGONAL)):
        for scale in (threshold, -1.5 * threshold):
            cases.append(
                (points_on_line(scale * np.array(places), direction=direction), abs(scale))
            )
    # Two points on opposite sides of the sensor are not close, however cells are rounded. A
    # function that adds coordinates instead of subtracting them joins these points.
    cases.append((points_on_line([0.6, -0.5, 9.0, 9.4], direction=_AXIS[0]), 1.0))
    return frozen_cases(cases)


def _lines_behind_a_heap() -> tuple[tuple[np.ndarray, float], ...]:
    """Return cases that begin with a heap; no two points behind it are close."""
    cases = []
    for threshold in (0.7, 1.4, 2.1):
        behind = 3.05 + 1.15 * np.arange(8)
        places = np.concatenate([np.linspace(0.45, 0.55, 9), behind])
        cases.append((points_on_line(threshold * places, direction=_DIAGONAL[0]), threshold))
    return frozen_cases(cases)


declare_mistakes(
    _NAME,
    *distance_mistakes(),
    Mistake(
        "The side of a cell is the threshold, so two points in one cell may be 1.7 times the "
        "threshold apart.",
        _prediction_from_cells(1.0, lambda gaps, steps, firsts: (gaps < 1) | (steps == 0)),
        "Make the side threshold / np.sqrt(3), so that the diagonal equals the threshold.",
    ),
    Mistake(
        "The side of a cell is threshold / sqrt(2), which is right only in the plane.",
        _prediction_from_cells(
            1 / np.sqrt(2), lambda gaps, steps, firsts: (gaps < 1) | (steps == 0)
        ),
        "Make the side threshold / np.sqrt(3), because the diagonal of a cube is side * "
        "np.sqrt(3).",
    ),
    Mistake(
        "The code joins neighbouring cells without measuring, or at too large a distance.",
        _prediction_from_cells(_CELL_SIDE, lambda gaps, steps, firsts: steps <= 2),
        "Join two cells only if a point of one is closer than the threshold to a point of the "
        "other.",
    ),
    Mistake(
        "The code searches only the next cell on each side, but close points may be two cells "
        "apart.",
        _prediction_from_cells(_CELL_SIDE, lambda gaps, steps, firsts: (steps <= 1) & (gaps < 1)),
        "Search 5 x 5 x 5 cells, corners included, with query_pairs(2, p=np.inf).",
    ),
    Mistake(
        "The code does not join two cells whose representatives are far apart, even if other "
        "points in them are close.",
        _prediction_from_cells(_CELL_SIDE, lambda gaps, steps, firsts: (steps == 0) | (firsts < 1)),
        "If two neighbouring cells are still in different pieces, compare all their points. Join "
        "the pieces if two of these points are close.",
    ),
    Mistake(
        "Each cell is a separate cluster, because the code does not join cells.",
        _prediction_from_cells(_CELL_SIDE, lambda gaps, steps, firsts: steps == 0),
        "Join neighbouring cells that contain close points, and number the pieces.",
    ),
    Mistake(
        "The code rounds coordinates towards 0, so the cells around the sensor are twice as wide.",
        _prediction_from_cells(
            _CELL_SIDE, lambda gaps, steps, firsts: (gaps < 1) | (steps == 0), np.trunc
        ),
        "Call np.floor before .astype(int), because .astype(int) alone rounds towards 0.",
    ),
    *label_mistakes(),
    Mistake(
        "The code mistakes rows of cells for rows of points, so it measures between the wrong "
        "points.",
        _prediction_from_rows(uses_points=True),
        "Measure between points[first[pairs[:, 0]]] and points[first[pairs[:, 1]]]. pairs "
        "contains rows of cells, and first turns them into rows of points.",
    ),
    Mistake(
        "The code counts the distance between two cells in cells, but compares it with metres.",
        _prediction_from_rows(uses_points=False),
        "Measure between representatives, such as points[first[pairs[:, 0]]], and not between "
        "cells, cells[pairs[:, 0]].",
    ),
    cases=(*line_cases(), *_lines_across_cells(), *_lines_behind_a_heap()),
    right=right_labels_of_line,
    is_same=_is_same_answer,
)
