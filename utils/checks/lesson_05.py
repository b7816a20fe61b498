"""Visible checks of lesson 05: `euclidean_clustering`.

The clouds are chosen so that one mistake fails few checks. A fixed threshold of 0.5, or a square
too many or too few, fails only one. Balls instead of chains pass all checks that use pairs.
"""

import sys
from collections.abc import Callable

import numpy as np

from utils.checks import common_checks, common_cluster_checks
from utils.checks.assertions import (
    CheckFailed,
    as_labels,
    brief,
    frozen,
)
from utils.checks.cluster_mistakes import (
    by_steps,
    frozen_cases,
    length,
    lines_of_points,
    measured_wrongly,
    mixed_up,
    on_a_line,
    right_on_a_line,
    same_clusters,
)
from utils.checks.clusters import (
    GROUPS,
    LABELS,
    assert_an_array,
    assert_clusters,
    assert_from_one,
    assert_numbered_by_appearance,
    assert_parts_at_the_threshold,
    assert_whole,
    assert_works,
    is_whole,
    row_of_points,
)
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes

# With this step and threshold each point of a row has one neighbour on either side, even if a
# function squares one of the two.
_STEP, _THRESHOLD = 0.45, 0.8

# The seven points of the lesson, in space. Squaring has no effect on their clusters, either.
_SEVEN_POINTS = frozen(
    np.column_stack(
        [
            [0.0, 2.0, 0.45, 2.3, 0.45, 0.91, 1.5],
            [0.0, 0.1, 0.15, -0.2, -0.15, 0.0, -1.1],
            np.zeros(7),
        ]
    )
)
_SEVEN_LABELS = frozen(np.array([1, 2, 1, 2, 1, 1, 3]))
# Labels of the three groups with a single point before and after them, as text.
_LABELS_WITH_SINGLES = brief(np.array([1, *(LABELS + 1), LABELS.max() + 2]))


@visible(
    "euclidean_clustering",
    weight=2,
    title="Groups far apart are clusters of their own",
    why="A cluster is an obstacle: two cars must not become one, nor one car two.",
    hint="Take a point without a label, give it a new label, then give the same label to "
    "everything that can be reached from it.",
)
def separates_groups(euclidean_clustering: Callable) -> None:
    assert_clusters(euclidean_clustering(GROUPS.copy(), 1.0), LABELS, GROUPS, 1.0)


_JOINED_HINT = (
    "Let a point join only if its distance to a point of the cluster is below the threshold."
)


@visible(
    "euclidean_clustering",
    weight=13,
    title="A chain of neighbours is one cluster, however long",
    why="A wall is metres long and its ends are far apart, but it is one obstacle.",
    hint="Each point that you label must itself be asked for its neighbours: let it wait in the "
    "queue.",
)
def follows_chains(euclidean_clustering: Callable) -> None:
    answer = euclidean_clustering(_SEVEN_POINTS.copy(), _THRESHOLD)
    try:
        assert_clusters(answer, _SEVEN_LABELS, _SEVEN_POINTS, _THRESHOLD)
    except CheckFailed as failure:
        joined = failure.is_about_the_check and is_whole(answer, _SEVEN_LABELS)
        failure.hint = failure.hint or (_JOINED_HINT if joined else "")
        raise
    wall = row_of_points([0.0, 0.0, 0.0], _STEP, 30)
    order = np.random.default_rng(5).permutation(60)
    cloud = np.vstack([wall, wall + [0.0, 3.0, 0.0]])[order]
    labels = np.repeat([1, 2], 30)[order]
    assert_clusters(euclidean_clustering(cloud.copy(), _THRESHOLD), labels, cloud, _THRESHOLD)


@visible(
    "euclidean_clustering",
    weight=5,
    title="Labels are the whole numbers 1 to N, and every point has one",
    why='Later lessons use 0 for "belongs to no obstacle" and count obstacles by the '
    "largest label.",
    hint="The first cluster gets 1. The counter goes up where a new cluster begins, and only "
    "there; a point that stands alone begins one, too, be it the first of the cloud or the last.",
)
def counts_from_one(euclidean_clustering: Callable) -> None:
    assert_works(euclidean_clustering)
    assert_from_one(euclidean_clustering(GROUPS.copy(), 1.0), len(GROUPS))
    # The first point is a cluster of its own, and so is the last.
    cloud = np.vstack([[-6.0, -8.0, 0.5], GROUPS, [-9.0, 4.0, 0.5]])
    answer = euclidean_clustering(cloud.copy(), 1.0)
    try:
        assert_from_one(answer, len(cloud))
    except CheckFailed as failure:
        if failure.is_about_the_check:
            failure.given = "three groups of points, and one point alone before and behind them"
            failure.yours, failure.expected = (
                brief(as_labels(answer, len(cloud))),
                _LABELS_WITH_SINGLES,
            )
        raise


@visible(
    "euclidean_clustering",
    weight=5,
    title="The parameter threshold decides which points are close",
    why="The threshold decides what counts as one object: at half a metre parked cars stay "
    "apart, at two metres a cyclist melts into the car beside.",
    hint="Two points are close where their distance in metres is below the parameter threshold.",
)
def follows_the_threshold(euclidean_clustering: Callable) -> None:
    # Rows with gaps of 0.2, 0.45, 0.6 and 0.9 m; each threshold joins a different number of them.
    rows = np.arange(4)[:, None] * 9.0 + np.outer([0.2, 0.45, 0.6, 0.9], [0, 1, 2])
    cloud = np.outer(rows.ravel(), [1.0, 0.0, 0.0])
    for threshold, labels in (
        (0.3, [1, 1, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10]),
        (0.5, [1, 1, 1, 2, 2, 2, 3, 4, 5, 6, 7, 8]),
        (0.7, [1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 5, 6]),
        (1.0, [1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4]),
    ):
        answer = euclidean_clustering(cloud.copy(), threshold)
        assert_clusters(answer, np.array(labels), cloud, threshold)


_CASE = common_cluster_checks.case_of(__name__, "euclidean_clustering")
common_cluster_checks.default(
    _CASE,
    "keeps_the_default",
    why="Later cells call euclidean_clustering(obstacles) and rely on it.",
)
common_checks.names(
    _CASE, "keeps_the_names", why="Somebody may call euclidean_clustering(cloud, threshold=0.3)."
)


@visible(
    "euclidean_clustering",
    weight=3,
    title="Measures the straight distance in space, alike in every direction",
    why="A bridge is above the road, not on it; and a car that turns keeps its size.",
    hint="The distance is the root of dx² + dy² + dz²: np.linalg.norm(..., axis=1) over three "
    "columns.",
)
def measures_alike(euclidean_clustering: Callable) -> None:
    assert_works(euclidean_clustering)
    # Pairs in five directions. Right or wrong, a measure of distance must treat them alike.
    directions = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [1, -1, 0]], dtype=float)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    places = np.outer(np.arange(5), [20.0, 0.0, 0.0])
    for gap in (0.15, 0.35, 0.65, 0.75, 0.95, 1.25, 1.55):
        cloud = np.vstack([places, places + gap * directions])
        labels = as_labels(euclidean_clustering(cloud.copy(), 1.0), len(cloud))
        close = labels[:5] == labels[5:]
        if close.any() and not close.all():
            parts = [
                f"{_direction_text(directions[np.argmax(close == is_close)])}"
                for is_close in (True, False)
            ]
            raise CheckFailed(
                f"{gap:.2f} m are close along {parts[0]} and not close along {parts[1]}.",
                given=f"pairs of points, {gap:.2f} m apart, in different directions; threshold 1 m",
            )


def _direction_text(direction: np.ndarray) -> str:
    """Return a direction as text: the name of an axis, or the signs of a diagonal."""
    signs = np.sign(direction).astype(int)
    return f"{'xyz'[np.argmax(direction)]}" if abs(signs).sum() == 1 else f"{tuple(signs.tolist())}"


common_cluster_checks.intensity(
    _CASE,
    "ignores_intensity",
    why="A white stripe on a black bumper is bright, not far away. Many recordings count "
    "intensity from 0 to 255.",
    weight=7,
)
common_cluster_checks.few_points(
    _CASE,
    "takes_the_smallest",
    why="After filtering nothing may be left.",
    hint="A loop over the points does nothing when there are none: an array of length 0 is "
    "the answer.",
    weight=2,
)
common_cluster_checks.equal_points(
    _CASE,
    "joins_equal_points",
    hint="Equal points are at distance 0, which is below every threshold.",
)
common_cluster_checks.untouched(_CASE, "leaves_its_input")


@visible(
    "euclidean_clustering",
    weight=3,
    title="A wall of thousands of points needs no recursion",
    why="A function that calls itself for each neighbour ends at Python's limit of nested calls: "
    "at the first wall of a full scan.",
    hint="Let points wait in a queue, and work in a loop until it is empty.",
)
def takes_a_long_wall(euclidean_clustering: Callable) -> None:
    assert_works(euclidean_clustering)
    # Python allows 1000 nested calls, and 3000 if something in the notebook has raised the limit.
    n = min(sys.getrecursionlimit(), 3000) + 100
    wall = row_of_points([-n * _STEP / 2, 5.0, 0.0], _STEP, n)
    assert_clusters(
        euclidean_clustering(wall.copy(), _THRESHOLD), np.ones(n, int), wall, _THRESHOLD
    )


@visible(
    "euclidean_clustering",
    weight=3,
    title="No point waits in the queue twice: a dense wall is done at once",
    why="On a wall close by, a point has dozens of neighbours. If it gets its label on leaving the "
    "queue, and not on entering it, it enters dozens of times, and lets others in as often.",
    hint="Label new neighbours before, or when, they join the queue.",
    slow="points enter the queue over and over. Label new neighbours before, or when, they join "
    "it: a point that gets its label on leaving enters again and again.",
)
def takes_a_dense_wall(euclidean_clustering: Callable) -> None:
    assert_works(euclidean_clustering)
    wall = np.stack(np.meshgrid(np.arange(20) * 0.1, [3.0], np.arange(20) * 0.1), axis=-1)
    cloud = wall.reshape(-1, 3)
    assert_clusters(euclidean_clustering(cloud.copy(), 0.8), np.ones(400, int), cloud, 0.8)


# ---- notes, which cost no points ---------------------------------------------------------------


@noted(
    "euclidean_clustering",
    title="The labels are an array, not a list",
    why="The next cells ask for labels.max() and labels == 3, which a list does not answer: return "
    "np.array(labels).",
)
def returns_an_array(euclidean_clustering: Callable) -> None:
    assert_an_array(euclidean_clustering)


@noted(
    "euclidean_clustering",
    title="Labels are whole numbers by type",
    why="np.bincount(labels), in the next cell, takes no floating point numbers: let the array of "
    "labels begin as np.zeros(n, dtype=int).",
)
def has_whole_labels(euclidean_clustering: Callable) -> None:
    assert_whole(euclidean_clustering)


@noted(
    "euclidean_clustering",
    title="Clusters are numbered as they first appear in the cloud",
    why="The text speaks of clusters by these numbers; yours have others there.",
)
def numbers_by_appearance(euclidean_clustering: Callable) -> None:
    assert_numbered_by_appearance(euclidean_clustering)


@noted(
    "euclidean_clustering",
    title="Two points exactly at the threshold are not close",
    why='The docstring says "closer than", which is <; on measured points it hardly ever matters, '
    "on a regular grid it does.",
)
def parts_at_the_threshold(euclidean_clustering: Callable) -> None:
    assert_parts_at_the_threshold(euclidean_clustering)


# ---- common mistakes ---------------------------------------------------------------------------


def _around_first_points(right: np.ndarray, cloud: np.ndarray, threshold: float) -> np.ndarray:
    """Label balls as in the lesson: all unlabelled points near the first unlabelled point."""
    places, labels = cloud[:, :3], np.zeros(len(cloud), dtype=int)
    while 0 in labels:
        near = length(places - places[np.argmin(labels)]) < threshold
        labels[near & (labels == 0)] = labels.max() + 1
    return labels


def _in_one_pass(right: np.ndarray, cloud: np.ndarray, threshold: float) -> np.ndarray:
    """Give each point the label of the first point before it that is near."""
    labels = []
    for place in cloud[:, :3]:
        near = np.flatnonzero(length(cloud[: len(labels), :3] - place) < threshold)
        labels.append(labels[near[0]] if len(near) else max(labels, default=0) + 1)
    return np.array(labels)


def _no_cluster_begins_at(row: int) -> Callable:
    """Return a prediction in which no cluster begins in this row: a point alone keeps label 0."""

    def predicts(right: np.ndarray, *case: object) -> np.ndarray:
        if np.count_nonzero(right == right[row]) > 1:
            return right
        labels = np.where(np.arange(len(right)) == np.arange(len(right))[row], 0, right)
        return np.unique(labels, return_inverse=True)[1].ravel()

    return predicts


def _first_rows(right: np.ndarray, *case: object) -> np.ndarray:
    """Label each point by the row, counted from 1, of the first point of its cluster."""
    return np.array([right.tolist().index(label) + 1 for label in right])


# Points on a line. The first point of the cloud, the last, or both are clusters of their own.
_SINGLES_AT_THE_ENDS = frozen_cases(
    [
        (on_a_line(places), 0.6)
        for places in (
            [9.0, 1.0, 3.4, 1.4, 3.0, 1.8],
            [5.0, 2.0, 2.3, 5.3, 2.6, 8.0],
            [7.0, 4.0, 4.4, 1.0, 1.5, 10.0],
        )
    ]
)

mistakes(
    "euclidean_clustering",
    *measured_wrongly(),
    Mistake(
        "The ways along x, y and z are added up: that is longer than the straight distance.",
        by_steps(lambda steps, limit: np.abs(steps[:, :3]).sum(axis=1) / limit),
        "The distance is the root of dx² + dy² + dz².",
    ),
    Mistake(
        "Only the longest of the ways along x, y and z counts.",
        by_steps(lambda steps, limit: np.abs(steps[:, :3]).max(axis=1) / limit),
        "The distance is the root of dx² + dy² + dz².",
    ),
    Mistake(
        "Only points close to the first one of a cluster join: balls instead of chains.",
        _around_first_points,
        "Put each point that joins into the queue, and ask it for its own neighbours.",
        is_cheap=True,
    ),
    Mistake(
        "Each point takes the label of a neighbour before it, and clusters that meet later keep "
        "two labels.",
        _in_one_pass,
        "Make one cluster complete, with a queue, before the next begins.",
    ),
    Mistake(
        "Only the cluster of the first point is made; all other points keep the label 0.",
        lambda right, *case: (right == 1).astype(int),
        "The loop over the points ends too early: `return` belongs behind it, not into it.",
    ),
    Mistake(
        "The counter goes up at every point; it should only where a new cluster begins.",
        _first_rows,
        "Count after you know that the point has no label yet.",
    ),
    Mistake(
        "No cluster begins at the first point: where it stands alone, it keeps the label 0.",
        _no_cluster_begins_at(0),
        "Let the loop over the points begin at 0: range(len(cloud)).",
    ),
    Mistake(
        "No cluster begins at the last point: where it stands alone, it keeps the label 0.",
        _no_cluster_begins_at(-1),
        "Let the loop over the points go to the last: range(len(cloud)).",
    ),
    *mixed_up(),
    cases=(*lines_of_points(), *_SINGLES_AT_THE_ENDS),
    right=right_on_a_line,
    same=same_clusters,
)
