"""Visible checks of lesson 09: `filter_clusters`."""

from collections.abc import Callable

import numpy as np

import utils
from utils.checks import common_checks
from utils.checks.assertions import (
    CheckFailed,
    as_array,
    as_labels,
    assert_new_array,
    brief,
    frozen,
    needs,
)
from utils.checks.common_checks import Case
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.failures import NotYet, fixed
from utils.checks.run_cache import once

# Clusters of 5, 1, 2, 4, 4 and 2 points, mixed. None has exactly 3 points, the minimum in these
# checks, because a separate check covers that case.
_LABELS = frozen(np.array([1, 1, 2, 3, 1, 4, 4, 3, 1, 5, 4, 1, 5, 6, 4, 5, 6, 5]))
_KEPT = frozen(np.array([1, 1, 0, 0, 1, 4, 4, 0, 1, 5, 4, 1, 5, 0, 4, 5, 0, 5]))
NOISE_MESSAGE = fixed("Points with label 0 belong to no cluster and keep the 0.")


def assert_right_clusters_left(
    answer: object, labels: np.ndarray, expected: np.ndarray, minimum: int | None = None
) -> None:
    """Assert that the right clusters are left, each with a label of its own, whatever the labels.

    Parameters
    ----------
    answer : object
    labels : numpy.ndarray of int, shape (n,)
        The labels that the function was given.
    expected : numpy.ndarray of int, shape (n,)
        The right answer.
    minimum : int, optional
        The minimum that the function was given, for the message.
    """
    yours = as_labels(answer, len(labels))
    if np.array_equal(yours > 0, expected > 0):
        _assert_apart(yours, labels, minimum)
        return
    removed = np.unique(labels[(yours <= 0) & (expected > 0)])
    not_removed = np.unique(labels[(yours > 0) & (expected == 0) & (labels > 0)])
    parts = [
        f"{_cluster_text(labels, cluster)} should be {'gone' if cluster in not_removed else 'left'}"
        for cluster in [*not_removed[:1], *removed[:1]]
    ]
    text = "; ".join(parts)
    show = _summary if _summary(yours) != _summary(expected) else brief
    raise CheckFailed(
        f"{text[0].upper()}{text[1:]}." if text else NOISE_MESSAGE,
        given=_call_text(labels, minimum) if len(labels) <= 20 or minimum is not None else None,
        yours=show(yours),
        expected=show(expected),
        draw=lambda: _draw(labels, yours, expected),
    )


def _assert_apart(yours: np.ndarray, labels: np.ndarray, minimum: int | None) -> None:
    """Assert that no two clusters of `labels` have the same label in the answer."""
    is_left = yours > 0
    old_labels = [
        np.unique(labels[is_left & (yours == label)]) for label in np.unique(yours[is_left])
    ]
    if merged := next((group.tolist() for group in old_labels if len(group) > 1), None):
        raise CheckFailed(
            f"Clusters {merged[0]} and {merged[1]} have the same label now: two obstacles "
            "became one.",
            given=_call_text(labels, minimum) if len(labels) <= 20 or minimum is not None else None,
            yours=brief(yours),
        )


def assert_labels_kept(answer: object, labels: np.ndarray, expected: np.ndarray) -> None:
    """Assert that points which rightly stay keep their labels; missing points are ignored.

    Parameters
    ----------
    answer : object
    labels, expected : numpy.ndarray of int, shape (n,)
        The labels that the function was given, and the right answer.
    """
    yours = as_labels(answer, len(labels))
    stays = (yours > 0) & (expected > 0)
    wrong = np.flatnonzero(stays & (yours != expected))
    if len(wrong):
        index = wrong[0]
        raise CheckFailed(
            f"Point {index} has another label than before. What stays keeps its label, gaps and "
            "all.",
            yours=f"label {yours[index]}",
            expected=f"label {expected[index]}",
            draw=lambda: _draw(labels, yours, expected),
        )


_BASIC_PROPERTY = "clusters with too few points go, the others stay"


@once
def require_small_clusters_removed(filter_clusters: Callable) -> None:
    """Assert that small clusters go and large ones stay; raise `NotYet` if not."""
    with needs(_BASIC_PROPERTY):
        assert_right_clusters_left(filter_clusters(_LABELS.copy(), 3), _LABELS, _KEPT)


@once
def require_most_clusters_right(filter_clusters: Callable) -> None:
    """Assert that at least five of six clusters go or stay as they should; raise `NotYet` if not.

    This is enough for checks that do not depend on sizes: names, input, label 0. A function that
    keeps or removes all clusters gets three right; one that uses only the first label gets four.
    """
    yours = as_labels(filter_clusters(_LABELS.copy(), 3), len(_LABELS))
    is_right = (yours > 0) == (_KEPT > 0)
    if sum(is_right[cluster == _LABELS].all() for cluster in range(1, 7)) < 5:
        raise NotYet(_BASIC_PROPERTY)


def _call_text(labels: np.ndarray, minimum: int | None) -> str:
    if len(labels) <= 20:
        text = f"labels {brief(labels)}"
    else:
        sizes = [np.count_nonzero(labels == label) for label in np.unique(labels)]
        text = f"clusters of {', '.join(map(str, sizes[:-1]))} and {sizes[-1]} points"
    return text + (f"; minimum {minimum}" if minimum is not None else "")


def _draw(labels: np.ndarray, yours: np.ndarray, expected: np.ndarray) -> None:
    """Draw each cluster as a row of points, one row per label."""
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


def _cluster_text(labels: np.ndarray, cluster: int) -> str:
    count = np.count_nonzero(labels == cluster)
    return f"cluster {cluster}, of {count} point{'s' if count != 1 else ''},"


def _summary(labels: np.ndarray) -> str:
    """Return the labels above 0 and the number of points without one as a short text."""
    in_use = np.unique(labels[labels > 0]).tolist()
    names = ", ".join(map(str, in_use[:8])) + (", ..." if len(in_use) > 8 else "")
    noise = np.count_nonzero(labels <= 0)
    return f"clusters {names or 'none'}; {noise} point{'s' if noise != 1 else ''} of noise"


@visible(
    "filter_clusters",
    weight=6,
    title="Clusters with too few points go, the others stay",
    why="Later steps draw a box around every label above 0: each drop of spray that stays "
    "is an obstacle to brake for.",
    hint="First count how often each label occurs. Then decide point by point, from the "
    "count of its label.",
)
def removes_small_clusters(filter_clusters: Callable) -> None:
    assert_right_clusters_left(filter_clusters(_LABELS.copy(), 3), _LABELS, _KEPT, 3)


@visible(
    "filter_clusters",
    weight=3,
    title="What stays keeps its label",
    why="The label is the obstacle's name: the next steps find its points and its box by it.",
    hint="Change no label but to 0: start from a copy of the labels.",
)
def keeps_the_labels(filter_clusters: Callable) -> None:
    require_most_clusters_right(filter_clusters)
    assert_labels_kept(filter_clusters(_LABELS.copy(), 3), _LABELS, _KEPT)


@visible(
    "filter_clusters",
    weight=3,
    title="Points of removed clusters get the label 0",
    why="0 is noise for every step that follows; a negative label is the name of nothing.",
    hint="Write 0 where a cluster is too small.",
)
def writes_zeros(filter_clusters: Callable) -> None:
    require_most_clusters_right(filter_clusters)
    yours = as_labels(filter_clusters(_LABELS.copy(), 3), len(_LABELS))
    if (yours < 0).any():
        raise CheckFailed(
            fixed("Points of removed clusters get the label 0, not a negative one."),
            yours=brief(yours),
            expected=brief(_KEPT),
        )


@visible(
    "filter_clusters",
    weight=3,
    title="Removes every small cluster, also one that follows another",
    why="Clutter comes in swarms. Moving the labels up while walking along them skips "
    "the neighbour of each cluster that went.",
    hint="Change no label but to 0. If you loop, read the labels from the original and write "
    "into a copy.",
)
def removes_neighbours(filter_clusters: Callable) -> None:
    labels = np.repeat([1, 2, 3, 4, 5, 6, 7], [1, 2, 1, 6, 2, 1, 5])
    assert_right_clusters_left(
        filter_clusters(labels.copy(), 4),
        labels,
        np.repeat([0, 0, 0, 4, 0, 0, 7], [1, 2, 1, 6, 2, 1, 5]),
        4,
    )


@visible(
    "filter_clusters",
    weight=3,
    title="A cluster of exactly min_num_points stays",
    why="The minimum is the smallest number of points that is still believed.",
    hint='"Fewer than" is <, not <=.',
)
def keeps_the_tie(filter_clusters: Callable) -> None:
    for sizes, kept in (([4, 5, 9], [0, 2, 3]), ([9, 4, 5], [1, 0, 3])):
        labels = np.repeat([1, 2, 3], sizes)
        assert_right_clusters_left(
            filter_clusters(labels.copy(), 5), labels, np.repeat(kept, sizes), 5
        )


@visible(
    "filter_clusters",
    weight=3,
    title="The parameter decides how many points are enough",
    why="How many points an obstacle has depends on the scanner, so each car sets its own minimum.",
    hint="Compare with min_num_points, by its name, and with no number of your own.",
)
def follows_the_minimum(filter_clusters: Callable) -> None:
    labels = np.repeat([1, 2, 3], [12, 30, 60])
    for minimum, kept in ((7, [1, 2, 3]), (20, [0, 2, 3]), (45, [0, 0, 3]), (80, [0, 0, 0])):
        expected = np.repeat(kept, [12, 30, 60])
        assert_right_clusters_left(
            filter_clusters(labels.copy(), minimum), labels, expected, minimum
        )


_FILTERED_CASE = Case(
    __name__,
    "filter_clusters",
    {"cluster_labels": _LABELS, "min_num_points": 3},
    expected=_KEPT,
    compare=lambda answer, labels, minimum, kept: as_labels(answer, len(labels)),
    precondition=require_most_clusters_right,
)


@common_checks.default(
    _FILTERED_CASE,
    "min_num_points=100",
    title="The minimum is 100 unless another one is given",
    why="Later lessons call filter_clusters(labels) and rely on it.",
)
def keeps_the_default(filter_clusters: Callable) -> None:
    sizes = [60, 99, 100, 101]
    labels = np.repeat([1, 2, 3, 4], sizes)
    with_minimum, without_minimum = (
        as_labels(answer, len(labels)) > 0
        for answer in (filter_clusters(labels.copy(), 100), filter_clusters(labels.copy()))
    )
    if not np.array_equal(with_minimum, without_minimum):
        raise CheckFailed(
            fixed("Without a minimum other clusters stay than with a minimum of 100."),
            given=_call_text(labels, None),
            yours=f"{np.count_nonzero(without_minimum)} points stay",
            expected=f"{np.count_nonzero(with_minimum)}, as in your function with 100",
        )


common_checks.names(
    _FILTERED_CASE,
    "keeps_the_names",
    why="Later lessons call filter_clusters(labels, min_num_points=10).",
)


@visible(
    "filter_clusters",
    weight=5,
    title="A large cluster stays, however large it is",
    why="A wall, a lorry or the car in front has hundreds or thousands of points in a scan.",
    hint="There is a minimum and no maximum: compare the size with min_num_points alone.",
)
def keeps_large_clusters(filter_clusters: Callable) -> None:
    require_most_clusters_right(filter_clusters)
    sizes = np.array([300, 4, 1100, 9, 6500, 2, 30_000])
    labels = np.repeat(np.arange(1, 8), sizes)
    kept = np.where(sizes < 10, 0, np.arange(1, 8))
    assert_right_clusters_left(
        filter_clusters(labels.copy(), 10), labels, np.repeat(kept, sizes), 10
    )


@visible(
    "filter_clusters",
    weight=3,
    title="Label 0 stays 0, however many points have it",
    why="Other steps set noise to 0, too. It must not come back as one huge obstacle.",
    hint="Leave out the label 0 when you look for clusters, or let it stay what it is.",
)
def leaves_noise_alone(filter_clusters: Callable) -> None:
    require_most_clusters_right(filter_clusters)
    labels = np.array([0, 2, 0, 2, 0, 1, 2, 0, 0, 1, 0, 2])
    yours = as_labels(filter_clusters(labels.copy(), 3), len(labels))
    if (yours[labels == 0] > 0).any():
        raise CheckFailed(
            NOISE_MESSAGE,
            given=f"labels {brief(labels)}, minimum 3",
            yours=brief(yours),
            expected=brief(np.where(labels == 2, 2, 0)),
        )


@visible(
    "filter_clusters",
    weight=2,
    title="Labels may have gaps",
    why="A second filter gets the gaps that the first one left.",
    hint="Go by the labels that occur, from np.unique, not by range(1, N): 7 may be there "
    "without 6.",
)
def allows_gaps(filter_clusters: Callable) -> None:
    labels = np.array([7, 40, 7, 7, 40, 3, 7])
    assert_right_clusters_left(
        filter_clusters(labels.copy(), 3), labels, np.array([7, 0, 7, 7, 0, 0, 7]), 3
    )


@visible(
    "filter_clusters",
    weight=3,
    title="Takes no points, one point, and all points in one cluster",
    why="The other filters can remove everything, or leave a single wall.",
    hint="The same lines serve every case: np.unique of no points is no labels.",
)
def takes_the_smallest(filter_clusters: Callable) -> None:
    empty = np.empty(0, dtype=int)
    assert_right_clusters_left(filter_clusters(empty, 2), empty, empty)
    for labels, minimum, expected in (
        ([1], 0, [1]),
        ([1], 2, [0]),
        ([5, 5, 5], 2, [5, 5, 5]),
        ([5, 5, 5], 4, [0, 0, 0]),
    ):
        labels = np.array(labels)
        assert_right_clusters_left(
            filter_clusters(labels.copy(), minimum), labels, np.array(expected), minimum
        )


common_checks.untouched(
    _FILTERED_CASE,
    "leaves_its_input",
    why="The next step may want to try another minimum on the same labels.",
    hint="Start from cluster_labels.copy(), or let np.where build a new array.",
    weight=2,
)


@visible(
    "filter_clusters",
    weight=1,
    title="Returns a new array, also where nothing is removed",
    why="Otherwise a change of the result would change the labels of the step before.",
    hint="Start from cluster_labels.copy(), or let np.where build a new array.",
)
def returns_a_new_array(filter_clusters: Callable) -> None:
    require_most_clusters_right(filter_clusters)
    assert_new_array(filter_clusters, _LABELS, 0)


@noted(
    "filter_clusters",
    title="The labels are an array, not a list",
    why="The next cells ask for filtered > 0, which a list cannot answer. End with np.array(...).",
)
def returns_an_array(filter_clusters: Callable) -> None:
    answer = filter_clusters(_LABELS.copy(), 3)
    if isinstance(answer, (list, tuple)):
        raise CheckFailed(f"The labels are a {type(answer).__name__}.")


@noted(
    "filter_clusters",
    title="Labels are whole numbers",
    why="np.bincount and labels as an index, in the next cells, take no floating point numbers.",
)
def has_whole_labels(filter_clusters: Callable) -> None:
    dtype = as_array(filter_clusters(_LABELS.copy(), 3)).dtype
    if dtype.kind not in "iu":
        raise CheckFailed(f"The labels are of type {dtype}.")


def _right_labels(labels: np.ndarray, minimum: int) -> np.ndarray:
    numbers = labels.tolist()
    return np.array(
        [number if number > 0 and numbers.count(number) >= minimum else 0 for number in numbers]
    )


def _cluster_sizes(labels: np.ndarray) -> np.ndarray:
    return np.array([labels.tolist().count(label) for label in labels])


def _renumbered(right: np.ndarray, *case: object) -> np.ndarray:
    """Number the clusters that stay from 1."""
    return np.searchsorted(np.unique(right[right > 0]), right) + (right > 0)


def _labels_move_up(right: np.ndarray, labels: np.ndarray, minimum: int) -> np.ndarray:
    """Decrease all later labels by one inside the loop whenever a cluster goes."""
    labels = labels.copy()
    for label in range(1, labels.max() + 1):
        if np.count_nonzero(labels == label) < minimum:
            labels[labels == label] = 0
            labels[labels > label] -= 1
    return labels


def _next_cluster_sizes(right: np.ndarray, labels: np.ndarray, minimum: int) -> np.ndarray:
    """Use the size of the next cluster for each cluster; the last one always stays."""
    sizes = np.append(np.bincount(labels)[1:], minimum)
    return np.where(sizes[labels] < minimum, 0, labels)


mistakes(
    "filter_clusters",
    Mistake(
        "`<=` stands where `<` is asked for: a cluster of exactly min_num_points goes.",
        lambda right, labels, minimum: np.where(_cluster_sizes(labels) > minimum, labels, 0),
        'Only clusters with fewer points go; "fewer than" is <.',
    ),
    Mistake(
        "The labels are compared with min_num_points; the number of points that have a label "
        "should be.",
        lambda right, labels, minimum: np.where(labels < minimum, 0, labels),
        "np.unique(cluster_labels, return_counts=True) counts the points of each label.",
    ),
    Mistake(
        "It is the large clusters that go, and the small ones that stay.",
        lambda right, labels, minimum: np.where(_cluster_sizes(labels) < minimum, labels, 0),
    ),
    Mistake(
        "A fixed minimum of 100 decides, whatever min_num_points is.",
        lambda right, labels, minimum: np.where(_cluster_sizes(labels) < 100, 0, labels),
        "Compare with min_num_points.",
    ),
    Mistake(
        "The points of small clusters are deleted. They keep their place, with the label 0.",
        lambda right, labels, minimum: right[right > 0],
        "There must be one label for each point: np.where(too_small, 0, cluster_labels).",
    ),
    Mistake(
        "The clusters that stay are numbered anew, from 1.",
        _renumbered,
        "Change no label but to 0.",
    ),
    Mistake(
        "What is returned are the names of the labels that stay, each once.",
        lambda right, labels, minimum: np.unique(right[right > 0]),
        "There must be one label for each point, in the order of the points.",
    ),
    Mistake(
        "-1 is written where a cluster is too small; it should be 0.",
        lambda right, labels, minimum: np.where(right > 0, right, -1),
    ),
    Mistake(
        "Nothing is removed: the labels come back as they went in.",
        lambda right, labels, minimum: labels,
        is_cheap=True,
    ),
    Mistake(
        "The later labels move up while the loop walks along them, so that it never looks at the "
        "cluster that follows one that goes.",
        _labels_move_up,
        "Change no label but to 0. Read the labels from cluster_labels, and write into a copy.",
    ),
    Mistake(
        "The last label is left out: its cluster stays, however small it is.",
        lambda right, labels, minimum: np.where(labels == labels.max(), labels, right),
        "range(1, n) ends before n. np.unique(cluster_labels) holds every label, the last as well.",
    ),
    Mistake(
        "You go by the place in the table of counts, not by the label: each cluster stays or goes "
        "by the size of the next one.",
        _next_cluster_sizes,
        "np.unique gives labels and counts side by side: take both, "
        "for label, count in zip(names, how_many).",
    ),
    # The labels have no gaps, so that a loop over range() is right. The first case is the call that
    # a failed check shows.
    cases=(
        (_LABELS, 3),
        (np.array([5, 2, 1, 4, 2, 6, 4, 3, 5, 4, 1, 2, 5, 4, 3]), 3),
        (np.repeat([1, 2, 3, 4, 5], [7, 3, 130, 6, 2]), 7),
    ),
    right=_right_labels,
)
