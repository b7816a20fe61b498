"""Visible checks of lesson 09: `filter_clusters`."""

from collections import Counter
from collections.abc import Callable

import numpy as np

import utils
from utils.checks import common_checks
from utils.checks.assertions import (
    CheckFailed,
    as_array,
    as_labels,
    assert_new_array,
    brief_text,
    frozen,
    precondition,
)
from utils.checks.common_checks import Case
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.failures import NotYet, fixed
from utils.checks.run_cache import once_per_run

# Clusters of 5, 1, 2, 4, 4 and 2 points, in mixed order. No cluster has exactly 3 points, the
# minimum in these checks: a separate check covers that case.
_LABELS = frozen(np.array([1, 1, 2, 3, 1, 4, 4, 3, 1, 5, 4, 1, 5, 6, 4, 5, 6, 5]))
_KEPT = frozen(np.array([1, 1, 0, 0, 1, 4, 4, 0, 1, 5, 4, 1, 5, 0, 4, 5, 0, 5]))
NOISE_MESSAGE = fixed("Points with label 0 belong to no cluster and must keep the label 0.")


def assert_right_clusters_left(
    answer: object, labels: np.ndarray, expected: np.ndarray, minimum: int | None = None
) -> None:
    """Assert that the right clusters are left and have different labels, which may be new.

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
        _assert_different_labels(yours, labels, minimum)
        return
    removed = np.unique(labels[(yours <= 0) & (expected > 0)])
    not_removed = np.unique(labels[(yours > 0) & (expected == 0) & (labels > 0)])
    parts = [
        f"{_cluster_text(labels, label)} should be {'removed' if label in not_removed else 'kept'}"
        for label in [*not_removed[:1], *removed[:1]]
    ]
    text = "; ".join(parts)
    show = _summary_text if _summary_text(yours) != _summary_text(expected) else brief_text
    raise CheckFailed(
        f"{text[0].upper()}{text[1:]}." if text else NOISE_MESSAGE,
        input_text=_call_text(labels, minimum)
        if len(labels) <= 20 or minimum is not None
        else None,
        yours=show(yours),
        expected=show(expected),
        draw=lambda: _draw_clusters(labels, yours, expected),
    )


def _assert_different_labels(yours: np.ndarray, labels: np.ndarray, minimum: int | None) -> None:
    """Assert that no two clusters of `labels` have the same label in the answer."""
    is_left = yours > 0
    old_labels = [
        np.unique(labels[is_left & (yours == label)]) for label in np.unique(yours[is_left])
    ]
    if merged := next((group.tolist() for group in old_labels if len(group) > 1), None):
        raise CheckFailed(
            f"Clusters {merged[0]} and {merged[1]} now have the same label, so two obstacles "
            "became one.",
            input_text=_call_text(labels, minimum)
            if len(labels) <= 20 or minimum is not None
            else None,
            yours=brief_text(yours),
            hint="Keep the old label of each remaining point.",
        )


def assert_labels_kept(answer: object, labels: np.ndarray, expected: np.ndarray) -> None:
    """Assert that points of remaining clusters keep their labels; removed points are ignored.

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
            f"The label of point {index} has changed. Remaining clusters must keep their labels, "
            "even if this leaves gaps.",
            yours=f"label {yours[index]}",
            expected=f"label {expected[index]}",
            draw=lambda: _draw_clusters(labels, yours, expected),
        )


_BASIC_PROPERTY = "clusters with too few points are removed and the others stay"


@once_per_run
def require_small_clusters_removed(filter_clusters: Callable) -> None:
    """Assert that small clusters are removed and large ones stay; raise `NotYet` if not."""
    with precondition(_BASIC_PROPERTY):
        assert_right_clusters_left(filter_clusters(_LABELS.copy(), 3), _LABELS, _KEPT)


@once_per_run
def require_most_clusters_right(filter_clusters: Callable) -> None:
    """Assert that at least five of six clusters are treated correctly; raise `NotYet` if not.

    This is enough for checks that do not depend on sizes, such as the checks of names, input and
    label 0. A function that keeps or removes all clusters treats three of them correctly; a
    function that uses only the first label treats four correctly.
    """
    yours = as_labels(filter_clusters(_LABELS.copy(), 3), len(_LABELS))
    is_right = (yours > 0) == (_KEPT > 0)
    if sum(is_right[label == _LABELS].all() for label in range(1, 7)) < 5:
        raise NotYet(_BASIC_PROPERTY)


def _call_text(labels: np.ndarray, minimum: int | None) -> str:
    if len(labels) <= 20:
        text = f"labels {brief_text(labels)}"
    else:
        sizes = [np.count_nonzero(labels == label) for label in np.unique(labels)]
        text = f"clusters of {', '.join(map(str, sizes[:-1]))} and {sizes[-1]} points"
    return text + (f"; minimum {minimum}" if minimum is not None else "")


def _draw_clusters(labels: np.ndarray, yours: np.ndarray, expected: np.ndarray) -> None:
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
        panel.set_xlabel("points of the cluster")
        panel.set_ylabel("old label")
        if len(names) <= 12:
            panel.set_yticks(range(len(names)), names)


def _cluster_text(labels: np.ndarray, label: int) -> str:
    count = np.count_nonzero(labels == label)
    return f"cluster {label}, with {count} point{'s' if count != 1 else ''},"


def _summary_text(labels: np.ndarray) -> str:
    """Return the labels above 0 and the number of noise points as a short text."""
    in_use = np.unique(labels[labels > 0]).tolist()
    names = ", ".join(map(str, in_use[:8])) + (", ..." if len(in_use) > 8 else "")
    noise = np.count_nonzero(labels <= 0)
    return f"clusters: {names or 'none'}; noise points: {noise}"


@visible_check(
    "filter_clusters",
    weight=6,
    title="Removes clusters with too few points and keeps the others",
    why="Later steps draw a box around every cluster with a label above 0, so the car would brake "
    "for every puff of spray that you keep.",
    hint="Count the points of each label with np.unique(cluster_labels, return_counts=True). Set "
    "labels with fewer than min_num_points points to 0.",
)
def removes_small_clusters(filter_clusters: Callable) -> None:
    assert_right_clusters_left(filter_clusters(_LABELS.copy(), 3), _LABELS, _KEPT, 3)


@visible_check(
    "filter_clusters",
    weight=3,
    title="Keeps the labels of the remaining clusters",
    why="The label identifies an obstacle: the next steps use it to find its points and its box.",
    hint="Start from cluster_labels.copy(), and never change a label to anything but 0.",
)
def keeps_the_labels(filter_clusters: Callable) -> None:
    require_most_clusters_right(filter_clusters)
    assert_labels_kept(filter_clusters(_LABELS.copy(), 3), _LABELS, _KEPT)


@visible_check(
    "filter_clusters",
    weight=3,
    title="Gives the points of removed clusters the label 0",
    why="All later steps treat label 0 as noise, but a negative label has no meaning to them.",
    hint="Write 0 for every point of a cluster that is too small.",
)
def writes_zeros(filter_clusters: Callable) -> None:
    require_most_clusters_right(filter_clusters)
    yours = as_labels(filter_clusters(_LABELS.copy(), 3), len(_LABELS))
    if (yours < 0).any():
        raise CheckFailed(
            fixed("Points of removed clusters must get the label 0, not a negative label."),
            yours=brief_text(yours),
            expected=brief_text(_KEPT),
        )


@visible_check(
    "filter_clusters",
    weight=3,
    title="Removes all small clusters, even if their labels are consecutive",
    why="Spray forms many small clusters. A loop that renumbers the labels skips the cluster "
    "after each removed cluster.",
    hint="Never change a label to anything but 0. If you loop, read from cluster_labels and write "
    "into a copy.",
)
def removes_consecutive_clusters(filter_clusters: Callable) -> None:
    labels = np.repeat([1, 2, 3, 4, 5, 6, 7], [1, 2, 1, 6, 2, 1, 5])
    assert_right_clusters_left(
        filter_clusters(labels.copy(), 4),
        labels,
        np.repeat([0, 0, 0, 4, 0, 0, 7], [1, 2, 1, 6, 2, 1, 5]),
        4,
    )


@visible_check(
    "filter_clusters",
    weight=3,
    title="Keeps clusters of exactly min_num_points points",
    why="A cluster of exactly the minimum size counts as an obstacle, and the car must see it.",
    hint='Write < min_num_points, not <=, because the exercise says "fewer than".',
)
def keeps_clusters_of_the_minimum_size(filter_clusters: Callable) -> None:
    for sizes, kept in (([4, 5, 9], [0, 2, 3]), ([9, 4, 5], [1, 0, 3])):
        labels = np.repeat([1, 2, 3], sizes)
        assert_right_clusters_left(
            filter_clusters(labels.copy(), 5), labels, np.repeat(kept, sizes), 5
        )


@visible_check(
    "filter_clusters",
    weight=3,
    title="Uses min_num_points as the minimum",
    why="The number of points on an obstacle depends on the scanner, so each car sets its own "
    "minimum.",
    hint="Compare with min_num_points, not with a fixed number.",
)
def uses_the_minimum(filter_clusters: Callable) -> None:
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


@common_checks.promise_default(
    _FILTERED_CASE,
    "min_num_points=100",
    title="Uses a minimum of 100 by default",
    why="The lesson calls filter_clusters(cluster_labels) and relies on this default.",
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
            fixed(
                "filter_clusters(labels) and filter_clusters(labels, 100) keep different clusters."
            ),
            input_text=_call_text(labels, None),
            yours=f"{np.count_nonzero(without_minimum)} points kept",
            expected=f"{np.count_nonzero(with_minimum)} points kept, as with a minimum of 100",
        )


common_checks.promise_names(
    _FILTERED_CASE,
    "keeps_the_names",
    why="Other code may call filter_clusters(labels, min_num_points=10).",
)


@visible_check(
    "filter_clusters",
    weight=5,
    title="Keeps large clusters, however large they are",
    why="A wall, a lorry or the car ahead has hundreds or thousands of points in a scan.",
    hint="Compare the size only with min_num_points: there is a minimum but no maximum.",
)
def keeps_large_clusters(filter_clusters: Callable) -> None:
    require_most_clusters_right(filter_clusters)
    sizes = np.array([300, 4, 1100, 9, 6500, 2, 30_000])
    labels = np.repeat(np.arange(1, 8), sizes)
    kept = np.where(sizes < 10, 0, np.arange(1, 8))
    assert_right_clusters_left(
        filter_clusters(labels.copy(), 10), labels, np.repeat(kept, sizes), 10
    )


@visible_check(
    "filter_clusters",
    weight=3,
    title="Keeps label 0, however many points have it",
    why="Earlier steps also use label 0 for noise, and noise must not become one huge obstacle.",
    hint="Leave label 0 unchanged, however often it occurs: it is not a cluster.",
)
def keeps_label_zero(filter_clusters: Callable) -> None:
    require_most_clusters_right(filter_clusters)
    labels = np.array([0, 2, 0, 2, 0, 1, 2, 0, 0, 1, 0, 2])
    yours = as_labels(filter_clusters(labels.copy(), 3), len(labels))
    if (yours[labels == 0] > 0).any():
        raise CheckFailed(
            NOISE_MESSAGE,
            input_text=f"labels {brief_text(labels)}, minimum 3",
            yours=brief_text(yours),
            expected=brief_text(np.where(labels == 2, 2, 0)),
        )


@visible_check(
    "filter_clusters",
    weight=2,
    title="Works when labels have gaps",
    why="If you filter labels twice, the first call leaves gaps for the second.",
    hint="Loop over np.unique(cluster_labels), not over range(1, N): label 7 may occur without "
    "label 6.",
)
def allows_gaps(filter_clusters: Callable) -> None:
    labels = np.array([7, 40, 7, 7, 40, 3, 7])
    assert_right_clusters_left(
        filter_clusters(labels.copy(), 3), labels, np.array([7, 0, 7, 7, 0, 0, 7]), 3
    )


@visible_check(
    "filter_clusters",
    weight=3,
    title="Works on no points, on one point, and on a single cluster",
    why="Other filters may remove everything, or leave a single wall.",
    hint="Use the same code for every array: np.unique of an empty array is empty.",
)
def works_on_few_points(filter_clusters: Callable) -> None:
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


common_checks.promise_untouched(
    _FILTERED_CASE,
    "leaves_its_input",
    why="The next step may try another minimum on the same labels.",
    hint="Start from cluster_labels.copy(), or let np.where build a new array.",
    weight=2,
)


@visible_check(
    "filter_clusters",
    weight=1,
    title="Returns a new array, even if nothing is removed",
    why="Otherwise, changing the result would also change the labels of the previous step.",
    hint="Start from cluster_labels.copy(), or let np.where build a new array.",
)
def returns_a_new_array(filter_clusters: Callable) -> None:
    require_most_clusters_right(filter_clusters)
    assert_new_array(filter_clusters, _LABELS, 0)


@note_check(
    "filter_clusters",
    title="Returns the labels as an array",
    why="The next cells compute filtered > 0, which fails for a list. End with np.array(...).",
)
def returns_an_array(filter_clusters: Callable) -> None:
    answer = filter_clusters(_LABELS.copy(), 3)
    if isinstance(answer, (list, tuple)):
        raise CheckFailed(
            f"The function returns the labels as a {type(answer).__name__}, not as an array."
        )


@note_check(
    "filter_clusters",
    title="Returns whole numbers",
    why="The docstring says ndarray of int. Neither np.bincount nor an index accepts "
    "floating-point numbers.",
)
def returns_whole_numbers(filter_clusters: Callable) -> None:
    dtype = as_array(filter_clusters(_LABELS.copy(), 3)).dtype
    if dtype.kind not in "iu":
        raise CheckFailed(f"The labels are of type {dtype}.")


def _right_labels(labels: np.ndarray, minimum: int) -> np.ndarray:
    numbers = labels.tolist()
    return np.array(
        [number if number > 0 and numbers.count(number) >= minimum else 0 for number in numbers]
    )


def _cluster_sizes(labels: np.ndarray) -> np.ndarray:
    sizes = Counter(labels.tolist())
    return np.array([sizes[label] for label in labels.tolist()], dtype=int)


def _renumbered(right: np.ndarray, *case: object) -> np.ndarray:
    """Renumber the remaining clusters from 1."""
    return np.searchsorted(np.unique(right[right > 0]), right) + (right > 0)


def _renumbered_inside_the_loop(right: np.ndarray, labels: np.ndarray, minimum: int) -> np.ndarray:
    """Predict a loop that decreases all later labels by one whenever it removes a cluster."""
    labels = labels.copy()
    for label in range(1, labels.max() + 1):
        if np.count_nonzero(labels == label) < minimum:
            labels[labels == label] = 0
            labels[labels > label] -= 1
    return labels


def _next_cluster_sizes(right: np.ndarray, labels: np.ndarray, minimum: int) -> np.ndarray:
    """Predict an answer that keeps each cluster if the next one is large enough, and the last."""
    sizes = np.append(np.bincount(labels)[1:], minimum)
    return np.where(sizes[labels] < minimum, 0, labels)


declare_mistakes(
    "filter_clusters",
    Mistake(
        "Clusters of exactly min_num_points points are removed. They should be kept.",
        lambda right, labels, minimum: np.where(_cluster_sizes(labels) > minimum, labels, 0),
        'Remove clusters with <, or keep clusters with >=, because "fewer than" means <.',
    ),
    Mistake(
        "The labels themselves are compared with min_num_points. The number of points with each "
        "label should be compared.",
        lambda right, labels, minimum: np.where(labels < minimum, 0, labels),
        "Count the points of each label with np.unique(cluster_labels, return_counts=True).",
        is_cheap=True,
    ),
    Mistake(
        "The large clusters are removed and the small ones stay. It should be the other way round.",
        lambda right, labels, minimum: np.where(_cluster_sizes(labels) < minimum, labels, 0),
    ),
    Mistake(
        "The minimum is fixed at 100; min_num_points is ignored.",
        lambda right, labels, minimum: np.where(_cluster_sizes(labels) < 100, 0, labels),
        "Compare with min_num_points.",
    ),
    Mistake(
        "The points of small clusters are deleted. They should keep their place and get the "
        "label 0.",
        lambda right, labels, minimum: labels[_cluster_sizes(labels) >= minimum],
        "Return one label for each point: np.where(too_small, 0, cluster_labels).",
    ),
    Mistake(
        "The remaining clusters are renumbered from 1. They should keep their labels.",
        _renumbered,
        "Never change a label to anything but 0.",
    ),
    Mistake(
        "Your code returns each remaining label once. It should return one label for each point.",
        lambda right, labels, minimum: np.unique(right[right > 0]),
        "Return one label for each point: np.where(too_small, 0, cluster_labels).",
    ),
    Mistake(
        "Points of small clusters get the label -1. They should get 0.",
        lambda right, labels, minimum: np.where(right > 0, right, -1),
    ),
    Mistake(
        "Nothing is removed: the function returns the labels unchanged. It should set the labels "
        "of small clusters to 0.",
        lambda right, labels, minimum: labels,
        is_cheap=True,
    ),
    Mistake(
        "Your loop renumbers the later labels, so it skips the cluster after each removed cluster.",
        _renumbered_inside_the_loop,
        "Never change a label to anything but 0. Read from cluster_labels and write into a copy.",
    ),
    Mistake(
        "The last label is skipped, so its cluster stays, however small it is.",
        lambda right, labels, minimum: np.where(labels == labels.max(), labels, right),
        "Loop over np.unique(cluster_labels), which contains every label. range(1, n) ends before "
        "n.",
    ),
    Mistake(
        "The first label is skipped, so its cluster stays, however small it is.",
        lambda right, labels, minimum: np.where(labels == labels.min(), labels, right),
        "Loop over np.unique(cluster_labels[cluster_labels > 0]). np.unique(cluster_labels)[1:] "
        "skips a cluster if label 0 is absent.",
    ),
    Mistake(
        "Your code uses the position in the array of counts as the label, so the size of the next "
        "cluster decides whether a cluster stays.",
        _next_cluster_sizes,
        "Write labels, counts = np.unique(cluster_labels, return_counts=True), then loop over "
        "zip(labels, counts).",
    ),
    # The labels have no gaps, so that a loop over range() is right. The first case is the call that
    # a failed check shows.
    cases=(
        (_LABELS, 3),
        (np.array([5, 2, 1, 4, 2, 6, 4, 3, 5, 4, 1, 2, 5, 4, 3]), 3),
        (np.repeat([1, 2, 3, 4, 5], [6, 3, 130, 7, 2]), 7),
    ),
    right=_right_labels,
)
