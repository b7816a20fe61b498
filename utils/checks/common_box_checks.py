"""Common checks for functions that return one box per cluster; see `common_checks`.

The arguments of the case are `cloud`, with three columns, and `cluster_labels`, which start at 1.
`expected` has one box per label; it is None if `compare` can judge a box by the points alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from utils.checks import common_checks
from utils.checks.boxes import as_cluster_boxes
from utils.checks.common_checks import Case, promise

# Two returns far from all clusters.
_STRAYS = ((30.0, 20.0, 4.0), (-20.0, -9.0, -1.0))


def promise_label_gaps(
    case: Case, name: str, labels: Sequence[int], *, hint: str, weight: float = 1
) -> None:
    """Check the boxes of labels with gaps; `labels` replace the labels 1, 2, ... of the case."""

    @promise(
        "gaps",
        case,
        name,
        title="Works when labels have gaps",
        why="A filter that removes a cluster leaves a gap in the labels, and the other clusters "
        "still need their boxes.",
        hint=hint,
        weight=weight,
    )
    def check(function: Callable) -> None:
        case.precondition(function)
        _with_labels(case, labels).assert_right(function)


def promise_label_order(case: Case, name: str, labels: Sequence[int], *, weight: float = 1) -> None:
    """Check that boxes are in label order; `labels` replace the labels 1, 2, ... of the case."""

    @promise(
        "ascending",
        case,
        name,
        title="Returns the boxes in ascending order of their labels",
        why="The next step uses the row of a box to find its label.",
        hint="Loop over the labels from the smallest to the largest: np.unique sorts them.",
        weight=weight,
    )
    def check(function: Callable) -> None:
        case.precondition(function)
        _with_labels(case, labels).assert_right(function)


def _with_labels(case: Case, labels: Sequence[int]) -> Case:
    """Return the case with other labels instead of 1, 2, ..."""
    arguments = {
        **case.arguments,
        "cluster_labels": np.array([0, *labels])[case.arguments["cluster_labels"]],
    }
    boxes = case.expected
    return replace(
        case, arguments=arguments, expected=None if boxes is None else boxes[np.argsort(labels)]
    )


def promise_no_box_for_noise(case: Case, name: str, *, weight: float = 1) -> None:
    """Check that points with label 0 get no box."""
    arguments = {
        "cloud": np.vstack([_STRAYS, case.first, _STRAYS]),
        "cluster_labels": np.pad(case.arguments["cluster_labels"], len(_STRAYS)),
    }

    @promise(
        "noise",
        case,
        name,
        title="Ignores points with label 0",
        why="Stray points are all over the street, so a box around them would cover the whole "
        "street and the ego car.",
        hint="Keep only labels > 0 before you loop.",
        weight=weight,
    )
    def check(function: Callable) -> None:
        try:
            replace(case, arguments=arguments).assert_right(function)
        except Exception:
            case.precondition(function)  # if this also fails, stray points are not the cause
            raise


def promise_empty_result(case: Case, name: str, *, hint: str, weight: float = 1) -> None:
    """Check that the shape is (0, 8, 3) without clusters and without points."""

    @promise(
        "no_boxes",
        case,
        name,
        title="Returns an array of shape (0, 8, 3) when there are no clusters",
        why="On an empty road, the next step may call boxes.min(axis=1), which fails for the "
        "shape (0,).",
        hint=hint,
        weight=weight,
    )
    def check(function: Callable) -> None:
        case.precondition(function)
        for cloud in (case.first, case.first[:0]):
            labels = np.zeros(len(cloud), dtype=int)
            as_cluster_boxes(function(cloud.copy(), labels.copy()), labels)


def promise_intensity_ignored(case: Case, name: str, *, weight: float = 1) -> None:
    """Check that intensity does not affect the boxes."""
    common_checks.promise_fourth_column(
        case,
        name,
        np.linspace(9, -9, len(case.first)),
        title="Ignores intensity in a fourth column",
        why="A corner is a point in space, so intensity must not be one of its coordinates.",
        hint="Take the coordinates with cloud[mask, :3].",
        weight=weight,
    )


def promise_untouched(case: Case, name: str, *, hint: str, weight: float = 1) -> None:
    """Check that the function changes neither the cloud nor the labels."""
    common_checks.promise_untouched(
        case,
        name,
        title="Does not change the cloud or the labels",
        why="The next step still needs the original cloud and labels.",
        hint=hint,
        weight=weight,
    )
