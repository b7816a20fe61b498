"""Visible checks of lesson 05: `euclidean_clustering`.

The clouds are chosen so that one mistake fails only a few checks. A fixed threshold of 0.5, or a
missing or superfluous square, fails a single check. A function that labels balls instead of chains
passes all checks that use pairs of points.
"""

import sys
from collections.abc import Callable

import numpy as np

from utils.checks import common_checks, common_cluster_checks
from utils.checks.assertions import (
    CheckFailed,
    as_labels,
    brief_text,
    frozen,
)
from utils.checks.cluster_mistakes import (
    distance_mistakes,
    frozen_cases,
    label_mistakes,
    lengths,
    line_cases,
    points_on_line,
    prediction_with_measure,
    right_labels_of_line,
    same_clusters,
)
from utils.checks.clusters import (
    GROUPS,
    LABELS,
    assert_clusters,
    assert_integer_labels,
    assert_is_array,
    assert_labels_from_one,
    assert_numbered_by_appearance,
    assert_separates_at_the_threshold,
    keeps_clusters_whole,
    require_simplest_clusters,
    row_of_points,
)
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes

# With this step and threshold, each point of a row has one neighbour on either side, even if a
# function squares the distance or the threshold.
_STEP, _THRESHOLD = 0.45, 0.8

# The seven points of the lesson, with z = 0. Squaring does not change their clusters either.
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
_LABELS_WITH_SINGLES = brief_text(np.array([1, *(LABELS + 1), LABELS.max() + 2]))


@visible_check(
    "euclidean_clustering",
    weight=2,
    title="Puts groups that are far apart into separate clusters",
    why="A cluster stands for an obstacle. Two cars must not become one, and one car must not "
    "become two.",
    hint="Take a point without a label and give it a new label. Then give the same label to every "
    "point that can be reached from it.",
    slow="does each point get a label above 0 when it enters the queue? A point that gets label 0 "
    "still counts as unlabelled and enters again.",
)
def separates_groups(euclidean_clustering: Callable) -> None:
    assert_clusters(euclidean_clustering(GROUPS.copy(), 1.0), LABELS, GROUPS, 1.0)


_JOINED_HINT = (
    "Let a point join only if its distance to a point of the cluster is below the threshold."
)


@visible_check(
    "euclidean_clustering",
    weight=13,
    title="Joins a chain of neighbours into one cluster, however long it is",
    why="The ends of a wall are metres apart, but it is one obstacle.",
    hint="Also search for the neighbours of each point that joins the cluster.",
)
def follows_chains(euclidean_clustering: Callable) -> None:
    answer = euclidean_clustering(_SEVEN_POINTS.copy(), _THRESHOLD)
    try:
        assert_clusters(answer, _SEVEN_LABELS, _SEVEN_POINTS, _THRESHOLD)
    except CheckFailed as failure:
        joined = failure.is_about_the_check and keeps_clusters_whole(answer, _SEVEN_LABELS)
        failure.hint = failure.hint or (_JOINED_HINT if joined else "")
        raise
    wall = row_of_points([0.0, 0.0, 0.0], _STEP, 30)
    order = np.random.default_rng(5).permutation(60)
    cloud = np.vstack([wall, wall + [0.0, 3.0, 0.0]])[order]
    labels = np.repeat([1, 2], 30)[order]
    assert_clusters(euclidean_clustering(cloud.copy(), _THRESHOLD), labels, cloud, _THRESHOLD)


@visible_check(
    "euclidean_clustering",
    weight=5,
    title="Labels every point with a whole number from 1 to the number of clusters",
    why='Later lessons use 0 for "belongs to no obstacle", and a later cell prints the largest '
    "label as the number of clusters.",
    hint="Give the first cluster the label 1, and increase the counter only when a new cluster "
    "begins. An isolated point is a cluster too, even if it is the first or last of the cloud.",
)
def counts_from_one(euclidean_clustering: Callable) -> None:
    require_simplest_clusters(euclidean_clustering)
    assert_labels_from_one(euclidean_clustering(GROUPS.copy(), 1.0), len(GROUPS))
    # The first and the last point are isolated.
    cloud = np.vstack([[-6.0, -8.0, 0.5], GROUPS, [-9.0, 4.0, 0.5]])
    answer = euclidean_clustering(cloud.copy(), 1.0)
    try:
        assert_labels_from_one(answer, len(cloud))
    except CheckFailed as failure:
        if failure.is_about_the_check:
            failure.input_text = "an isolated point, then three groups, then another isolated point"
            failure.yours, failure.expected = (
                brief_text(as_labels(answer, len(cloud))),
                _LABELS_WITH_SINGLES,
            )
        raise


@visible_check(
    "euclidean_clustering",
    weight=5,
    title="Uses the parameter threshold to decide which points are close",
    why="The threshold decides what counts as one object. At 0.5 m, parked cars stay separate; at "
    "2 m, a cyclist and the car next to them become one cluster.",
    hint="Compare the distance in metres with the parameter threshold: closer points are "
    "neighbours.",
)
def uses_the_threshold(euclidean_clustering: Callable) -> None:
    # Rows with gaps of 0.2, 0.45, 0.6 and 0.9 m; each threshold joins the points of more rows.
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
common_cluster_checks.promise_default(
    _CASE,
    "keeps_the_default",
    why="Later cells call euclidean_clustering(obstacles) and rely on this default.",
)
common_checks.promise_names(
    _CASE, "keeps_the_names", why="Other code may call euclidean_clustering(cloud, threshold=0.3)."
)


@visible_check(
    "euclidean_clustering",
    weight=3,
    title="Measures the distance in the same way in every direction of space",
    why="If the height counted less, a bridge and the road below it would become one cluster.",
    hint="Use np.linalg.norm(..., axis=1) over three columns: the distance is the square root of "
    "dx² + dy² + dz².",
)
def measures_all_directions_alike(euclidean_clustering: Callable) -> None:
    require_simplest_clusters(euclidean_clustering)
    # Pairs of points in five directions. Even a wrong threshold must treat all directions alike.
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
                f"Points {gap:.2f} m apart share a label along {parts[0]} but not along "
                f"{parts[1]}.",
                input_text=f"pairs of points, {gap:.2f} m apart, in different directions; "
                "threshold 1 m",
            )


def _direction_text(direction: np.ndarray) -> str:
    """Return a direction as text: the name of an axis, or the signs of a diagonal."""
    signs = np.sign(direction).astype(int)
    return f"{'xyz'[np.argmax(direction)]}" if abs(signs).sum() == 1 else f"{tuple(signs.tolist())}"


common_cluster_checks.promise_intensity_ignored(
    _CASE,
    "ignores_intensity",
    why="A white stripe on a black bumper is brighter, not farther away. In many recordings, "
    "intensity goes from 0 to 255.",
    weight=7,
)
common_cluster_checks.promise_few_points(
    _CASE,
    "takes_the_smallest",
    why="A filter sometimes removes every point, and that must not crash the program.",
    hint="Start with labels = np.zeros(len(cloud), dtype=int), which is empty for an empty cloud.",
    weight=2,
)
common_cluster_checks.promise_equal_points(
    _CASE,
    "joins_equal_points",
    hint="Give equal points the same label: their distance is 0, which is below any threshold.",
)
common_cluster_checks.promise_untouched(_CASE, "leaves_its_input")


@visible_check(
    "euclidean_clustering",
    weight=3,
    title="Labels a wall of more than a thousand points",
    why="A function that calls itself for each neighbour reaches Python's recursion limit at the "
    "first wall of a full scan.",
    hint="Put points into a queue, and work in a loop until the queue is empty.",
)
def labels_a_long_wall(euclidean_clustering: Callable) -> None:
    require_simplest_clusters(euclidean_clustering)
    # Python allows 1000 nested calls by default, and 3000 in a notebook.
    n = min(sys.getrecursionlimit(), 3000) + 100
    wall = row_of_points([-n * _STEP / 2, 5.0, 0.0], _STEP, n)
    assert_clusters(
        euclidean_clustering(wall.copy(), _THRESHOLD), np.ones(n, int), wall, _THRESHOLD
    )


@visible_check(
    "euclidean_clustering",
    weight=3,
    title="Labels a dense wall without putting points into the queue again and again",
    why="On a nearby wall, a point has dozens of neighbours. If it gets its label when it leaves "
    "the queue, it enters the queue dozens of times and adds its own neighbours each time.",
    hint="Label new neighbours when they enter the queue, not when they leave it.",
    slow="does each point enter the queue only once? Label new neighbours when they enter it, not "
    "when they leave it.",
)
def labels_a_dense_wall(euclidean_clustering: Callable) -> None:
    require_simplest_clusters(euclidean_clustering)
    wall = np.stack(np.meshgrid(np.arange(20) * 0.1, [3.0], np.arange(20) * 0.1), axis=-1)
    cloud = wall.reshape(-1, 3)
    assert_clusters(euclidean_clustering(cloud.copy(), 0.8), np.ones(400, int), cloud, 0.8)


# ---- notes, which do not affect the score ------------------------------------------------------


@note_check(
    "euclidean_clustering",
    title="Returns an array, not a list",
    why="The next cells use labels.max() and labels == 3, which only work with an array. Return "
    "np.array(labels).",
)
def returns_an_array(euclidean_clustering: Callable) -> None:
    assert_is_array(euclidean_clustering)


@note_check(
    "euclidean_clustering",
    title="Returns labels of an integer type",
    why="A later cell calls np.bincount(labels), which does not accept floating-point numbers. "
    "Create the array of labels with np.zeros(n, dtype=int).",
)
def returns_integer_labels(euclidean_clustering: Callable) -> None:
    assert_integer_labels(euclidean_clustering)


@note_check(
    "euclidean_clustering",
    title="Numbers the clusters in the order in which they first appear in the cloud",
    why="The text of the lesson refers to clusters by these numbers, and your numbers are "
    "different.",
)
def numbers_by_appearance(euclidean_clustering: Callable) -> None:
    assert_numbered_by_appearance(euclidean_clustering)


@note_check(
    "euclidean_clustering",
    title="Keeps two points separate if they are exactly the threshold apart",
    why='The docstring says "closer than", which means <. The difference hardly ever matters for '
    "measured points, but it does for a regular grid.",
)
def separates_at_the_threshold(euclidean_clustering: Callable) -> None:
    assert_separates_at_the_threshold(euclidean_clustering)


# ---- common mistakes ---------------------------------------------------------------------------


def _predict_balls(right: np.ndarray, cloud: np.ndarray, threshold: float) -> np.ndarray:
    """Label balls as in the lesson: all unlabelled points near the first unlabelled point."""
    places, labels = cloud[:, :3], np.zeros(len(cloud), dtype=int)
    while 0 in labels:
        near = lengths(places - places[np.argmin(labels)]) < threshold
        labels[near & (labels == 0)] = labels.max() + 1
    return labels


def _predict_one_pass(right: np.ndarray, cloud: np.ndarray, threshold: float) -> np.ndarray:
    """Give each point the label of the first earlier point that is near."""
    labels = []
    for place in cloud[:, :3]:
        near = np.flatnonzero(lengths(cloud[: len(labels), :3] - place) < threshold)
        labels.append(labels[near[0]] if len(near) else max(labels, default=0) + 1)
    return np.array(labels)


def _prediction_without_cluster_at(row: int) -> Callable:
    """Return a prediction in which an isolated point in this row keeps the label 0."""

    def predict(right: np.ndarray, *case: object) -> np.ndarray:
        if np.count_nonzero(right == right[row]) > 1:
            return right
        labels = np.where(np.arange(len(right)) == np.arange(len(right))[row], 0, right)
        return np.unique(labels, return_inverse=True)[1].ravel()

    return predict


def _predict_first_rows(right: np.ndarray, *case: object) -> np.ndarray:
    """Label each point with the row, counted from 1, of the first point of its cluster."""
    return np.array([right.tolist().index(label) + 1 for label in right])


# Points on a line. The first point of the cloud, the last, or both are isolated.
_SINGLES_AT_THE_ENDS = frozen_cases(
    [
        (points_on_line(places), 0.6)
        for places in (
            [9.0, 1.0, 3.4, 1.4, 3.0, 1.8],
            [5.0, 2.0, 2.3, 5.3, 2.6, 8.0],
            [7.0, 4.0, 4.4, 1.0, 1.5, 10.0],
        )
    ]
)

declare_mistakes(
    "euclidean_clustering",
    *distance_mistakes(),
    Mistake(
        "The distances along x, y and z are added up, and their sum is longer than the straight "
        "line.",
        prediction_with_measure(lambda steps, limit: np.abs(steps[:, :3]).sum(axis=1) / limit),
        "Take the square root of dx² + dy² + dz², as np.linalg.norm does.",
    ),
    Mistake(
        "Only the longest of the distances along x, y and z counts; all three should count.",
        prediction_with_measure(lambda steps, limit: np.abs(steps[:, :3]).max(axis=1) / limit),
        "Take the square root of dx² + dy² + dz², as np.linalg.norm does.",
    ),
    Mistake(
        "Only points close to the first point of a cluster join it, so chains are cut off.",
        _predict_balls,
        "Put each point that joins into the queue, and search for its own neighbours.",
        is_cheap=True,
    ),
    Mistake(
        "Each point takes the label of an earlier neighbour, and clusters that meet later keep two "
        "labels.",
        _predict_one_pass,
        "Complete one cluster, with a queue, before you begin the next.",
        is_cheap=True,
    ),
    Mistake(
        "Only the cluster of the first point is labelled; all other points keep the label 0.",
        lambda right, *case: (right == 1).astype(int),
        "The loop over the points ends too early: `return` belongs after it, not inside it.",
    ),
    Mistake(
        "The counter goes up at every point; it should go up only when a new cluster begins.",
        _predict_first_rows,
        "First make sure that the point has no label, then increase the counter.",
    ),
    Mistake(
        "No cluster begins at the first point; if it is isolated, it keeps the label 0.",
        _prediction_without_cluster_at(0),
        "Start the loop over the points at 0: range(len(cloud)).",
    ),
    Mistake(
        "No cluster begins at the last point; if it is isolated, it keeps the label 0.",
        _prediction_without_cluster_at(-1),
        "Let the loop run to the last point: range(len(cloud)).",
    ),
    *label_mistakes(),
    cases=(*line_cases(), *_SINGLES_AT_THE_ENDS),
    right=right_labels_of_line,
    is_same=same_clusters,
)
