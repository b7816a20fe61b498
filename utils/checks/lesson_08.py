"""Visible checks of lesson 08: `get_bounding_boxes`."""

from collections.abc import Callable

import numpy as np

from utils.checks import common_box_checks, common_checks
from utils.checks.assertions import CheckFailed, as_array, brief, frozen, needs, table
from utils.checks.boxes import (
    assert_box_corners,
    corners_between,
    same_corners,
)
from utils.checks.common_checks import Case
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.run_cache import once

# A cluster that surrounds the origin and whose first point is not extreme on any axis. Neither the
# starting values of a search nor the order of the points change its box, because separate checks
# cover these.
_POINTS = table(
    "0.5 0.2 -0.1; -2 0.4 0.3; 3 -0.3 0.2; 0.1 -1.5 -0.4; -0.6 2.5 0.1; 1 0.7 -1.2; -0.2 -0.5 0.8"
)
_LOW, _HIGH = frozen((np.array([-2.0, -1.5, -1.2]), np.array([3.0, 2.5, 0.8])))
_BOX = frozen(corners_between(_LOW, _HIGH))
# The same cluster unchanged, half as large, and larger and shifted.
_SIZES, _SHIFT = (1.0, 0.5, 1.5), 0.4
_CLOUD = frozen(np.vstack([_SIZES[0] * _POINTS, _SIZES[1] * _POINTS, _SIZES[2] * _POINTS + _SHIFT]))
_BOXES = frozen(np.stack([_SIZES[0] * _BOX, _SIZES[1] * _BOX, _SIZES[2] * _BOX + _SHIFT]))
_LABELS = frozen(np.repeat([1, 2, 3], 7))


@once
def require_single_box(get_bounding_boxes: Callable) -> None:
    """Assert that a single cluster gets its box; raise `NotYet` if not."""
    with needs("a single cluster gets its box"):
        labels = np.ones(7, dtype=int)
        answer = get_bounding_boxes(_POINTS.copy(), labels.copy())
        assert_box_corners(answer, _BOX[None], _POINTS, labels)


@once
def require_three_boxes(get_bounding_boxes: Callable) -> None:
    """Assert that three clusters get their boxes; raise `NotYet` if not."""
    with needs("each of three clusters gets its box"):
        answer = get_bounding_boxes(_CLOUD.copy(), _LABELS.copy())
        assert_box_corners(answer, _BOXES, _CLOUD, _LABELS)


@visible(
    "get_bounding_boxes",
    weight=4,
    title="A box reaches from the smallest to the largest x, y and z of its points",
    why="The planner sees only boxes. The car may hit anything that sticks out of a box, and it "
    "cannot use free space inside one. An obstacle without a box is invisible.",
    hint="points.min(axis=0) and points.max(axis=0) of the rows of one label give all six "
    "numbers; a corner takes, for each axis, one or the other.",
)
def reaches_from_min_to_max(get_bounding_boxes: Callable) -> None:
    labels = np.ones(7, dtype=int)
    answer = get_bounding_boxes(_POINTS.copy(), labels.copy())
    assert_box_corners(answer, _BOX[None], _POINTS, labels)


@visible(
    "get_bounding_boxes",
    weight=3,
    title="Each label gets a box of its own",
    why="One box over two cars closes the gap between them, too; and a car without a box is not "
    "there.",
    hint="For each label take the rows with that label alone, cloud[cluster_labels == label], "
    "and start afresh.",
)
def one_box_for_each_label(get_bounding_boxes: Callable) -> None:
    require_single_box(get_bounding_boxes)
    answer = get_bounding_boxes(_CLOUD.copy(), _LABELS.copy())
    assert_box_corners(answer, _BOXES, _CLOUD, _LABELS)


@visible(
    "get_bounding_boxes",
    weight=2,
    title="A box is as exact as its points",
    why="Each step of a pipeline adds its own errors. Rounding is for texts that people read.",
    hint="Return the numbers as they are, without round.",
)
def is_exact(get_bounding_boxes: Callable) -> None:
    require_three_boxes(get_bounding_boxes)
    points, labels = _POINTS + [0.0043, -0.0036, 0.0047], np.ones(7, dtype=int)
    answer = get_bounding_boxes(points.copy(), labels.copy())
    assert_box_corners(answer, _BOX[None] + [0.0043, -0.0036, 0.0047], points, labels)


@visible(
    "get_bounding_boxes",
    weight=3,
    title="A cluster may lie anywhere: ahead on the left, behind on the right",
    why="Behind us on the right all coordinates are negative, and their largest is below 0.",
    hint="Start from the first point or from infinity: 0 is a place like any other.",
)
def starts_anywhere(get_bounding_boxes: Callable) -> None:
    require_three_boxes(get_bounding_boxes)
    shifts = table("9 6 3; -9 -6 -3")
    cloud = np.vstack([_POINTS + shift for shift in shifts])
    labels = np.repeat([1, 2], 7)
    boxes = np.stack([_BOX + shift for shift in shifts])
    assert_box_corners(get_bounding_boxes(cloud.copy(), labels.copy()), boxes, cloud, labels)


@visible(
    "get_bounding_boxes",
    weight=3,
    title="The order of the points does not matter",
    why="A scan lists its rows from the top beam down: often the first point of a cluster is its "
    "highest.",
    hint="The first point is the smallest so far and the largest so far at once: both questions "
    "must be asked of each point, if and if, not if and elif.",
)
def takes_points_in_any_order(get_bounding_boxes: Callable) -> None:
    require_three_boxes(get_bounding_boxes)
    labels = np.repeat([1, 2], 7)
    for first in range(1, 7):
        points = np.roll(_POINTS, -first, axis=0)
        cloud = np.vstack([points, 0.5 * points])
        answer = get_bounding_boxes(cloud.copy(), labels.copy())
        assert_box_corners(answer, np.stack([_BOX, 0.5 * _BOX]), cloud, labels)


_THREE_CASE = Case(
    __name__,
    "get_bounding_boxes",
    {"cloud": _CLOUD, "cluster_labels": _LABELS},
    expected=_BOXES,
    compare=lambda answer, cloud, labels, boxes: assert_box_corners(answer, boxes, cloud, labels),
    precondition=require_three_boxes,
)
common_box_checks.gaps(
    _THREE_CASE,
    "allows_gaps",
    [2, 5, 9],
    hint="np.unique(cluster_labels) lists the labels that occur. range(1, ...) also counts those "
    "that do not.",
    weight=2,
)
common_box_checks.ascending(_THREE_CASE, "follows_the_labels", [2, 3, 1], weight=2)
common_box_checks.noise(_THREE_CASE, "leaves_noise_alone", weight=2)


@visible(
    "get_bounding_boxes",
    weight=2,
    title="Takes clusters of one, two and equal points",
    why="A thin post far away returns a single point.",
    hint="Minimum and maximum of a single point are both that point; no special case is needed.",
)
def takes_few_points(get_bounding_boxes: Callable) -> None:
    require_three_boxes(get_bounding_boxes)
    first, second, third = table("6 2 -1.1; 5 2.6 -0.5; -3 -4.6 -1")
    cloud = np.vstack([first, second, third, first, second, third, third, third])
    labels = np.array([1, 1, 2, 3, 3, 4, 4, 4])
    pair = corners_between(np.minimum(first, second), np.maximum(first, second))
    post = corners_between(third, third)
    answer = get_bounding_boxes(cloud.copy(), labels.copy())
    assert_box_corners(answer, np.stack([pair, post, pair, post]), cloud, labels)


common_box_checks.fourth_column(_THREE_CASE, "ignores_intensity", weight=2)
common_box_checks.no_boxes(
    _THREE_CASE,
    "takes_nothing",
    hint="np.array([]) has shape (0,). End with .reshape(-1, 8, 3), or start from "
    "np.zeros((number_of_boxes, 8, 3)).",
    weight=2,
)
common_checks.names(
    _THREE_CASE,
    "keeps_the_names",
    why="Whoever reads the docstring may call get_bounding_boxes(cloud=..., cluster_labels=...).",
)
common_box_checks.untouched(
    _THREE_CASE, "leaves_its_input", hint="Write the corners into an array of their own."
)


@noted(
    "get_bounding_boxes",
    title="Corner k has the larger x if k & 1, the larger y if k & 2, the larger z if k & 4",
    why="The lesson's pictures join corners by these numbers, as most programs do by theirs: in "
    "another order the edges cross. The picture of the box of seven points shows your numbers.",
)
def numbers_the_corners(get_bounding_boxes: Callable) -> None:
    box = as_array(get_bounding_boxes(_POINTS.copy(), np.ones(7, dtype=int)))[0]
    for corner in range(8):
        larger = [bool(corner & 1), bool(corner & 2), bool(corner & 4)]
        place = np.where(larger, _HIGH, _LOW)
        if np.abs(box[corner] - place).max() > 1e-3:
            raise CheckFailed(
                f"Corner {corner} stands elsewhere.",
                yours=brief(box[corner]),
                expected=brief(place),
            )


@noted(
    "get_bounding_boxes",
    title="The boxes are an array, not a list",
    why="The next cells ask for boxes.min(axis=1), which a list has not.",
)
def returns_an_array(get_bounding_boxes: Callable) -> None:
    answer = get_bounding_boxes(_CLOUD.copy(), _LABELS.copy())
    if isinstance(answer, (list, tuple)):
        raise CheckFailed(f"The boxes are a {type(answer).__name__}.")


# Small streets with the corners of their boxes. The clusters are apart from each other, and the
# labels have no gaps; some streets have a stray point. The first point of a cluster is its largest
# or its smallest on every axis. Each street has a different number of points.
_STREETS = tuple(
    frozen((np.array(cloud), np.array(labels), np.stack([corners_between(*box) for box in boxes])))
    for cloud, labels, boxes in (
        (
            [
                [-4.0, -2.0, -1.0],
                [9.0, 6.0, 3.0],
                [5.0, 3.0, 1.0],
                [7.0, 4.0, 2.0],
                [-9.0, -7.0, -5.0],
                [-6.0, -4.0, -3.0],
                [-7.0, -5.0, -4.0],
            ],
            [0, 1, 1, 1, 2, 2, 2],
            (((5, 3, 1), (9, 6, 3)), ((-9, -7, -5), (-6, -4, -3))),
        ),
        (
            [
                [8.0, -6.0, 2.0],
                [5.0, -9.0, 1.0],
                [-1.0, 9.0, -2.0],
                [-5.0, 5.0, 4.0],
                [7.0, -7.0, 1.5],
                [-9.0, 2.0, 2.0],
                [-6.0, 4.0, 3.0],
                [-7.0, 3.0, 2.5],
            ],
            [2, 2, 0, 1, 2, 1, 1, 1],
            (((-9, 2, 2), (-5, 5, 4)), ((5, -9, 1), (8, -6, 2))),
        ),
        (
            [
                [4.0, 3.0, 2.0],
                [1.0, 1.0, -1.0],
                [3.0, 2.0, 1.0],
                [2.0, 1.5, 0.0],
                [-4.0, -6.0, -2.0],
                [-1.0, -3.0, -0.5],
                [-2.0, -5.0, -1.0],
                [-3.0, -4.0, -1.5],
                [6.0, -6.0, 0.0],
            ],
            [2, 2, 2, 2, 1, 1, 1, 1, 0],
            (((-4, -6, -2), (-1, -3, -0.5)), ((1, 1, -1), (4, 3, 2))),
        ),
        (
            [
                [-5.0, 4.0, 1.0],
                [-7.0, 2.0, -1.0],
                [-6.0, 3.0, 0.0],
                [4.0, 5.0, 2.0],
                [6.0, 8.0, 3.0],
                [5.0, 6.0, 2.5],
                [4.5, 7.0, 2.2],
                [3.0, -4.0, 0.5],
                [2.0, -6.0, -1.5],
                [2.5, -5.0, -1.0],
            ],
            [2, 2, 2, 3, 3, 3, 3, 1, 1, 1],
            (((2, -6, -1.5), (3, -4, 0.5)), ((-7, 2, -1), (-5, 4, 1)), ((4, 5, 2), (6, 8, 3))),
        ),
        (
            [
                [9.0, -3.0, 0.0],
                [7.0, -5.0, -1.0],
                [8.0, -4.0, -0.5],
                [-2.0, 8.0, 1.0],
                [-4.0, 5.0, -0.6],
                [-3.0, 6.0, 0.2],
            ],
            [1, 1, 1, 2, 2, 2],
            (((7, -5, -1), (9, -3, 0)), ((-4, 5, -0.6), (-2, 8, 1))),
        ),
    )
)


def _right_boxes(cloud: np.ndarray, labels: np.ndarray) -> np.ndarray:
    return next(boxes for street, _, boxes in _STREETS if len(street) == len(cloud))


def _change_corners(right: np.ndarray, change: Callable) -> np.ndarray:
    """Return straight boxes whose lowest and highest corner are replaced by `change`."""
    corners = [change(box.min(axis=0), box.max(axis=0)) for box in right]
    return np.stack([corners_between(low, high) for low, high in corners])


def _without_first(low: np.ndarray, high: np.ndarray, cloud: np.ndarray) -> np.ndarray:
    """Return the points between two corners, except the first one in the cloud."""
    return cloud[((cloud >= low) & (cloud <= high)).all(axis=1)][1:]


def _boxes_of(cloud: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """Return the box of each label above 0."""
    clusters = [cloud[labels == name] for name in np.unique(labels[labels > 0])]
    corners = [(points.min(axis=0), points.max(axis=0)) for points in clusters]
    return np.stack([corners_between(low, high) for low, high in corners])


def _order_of_appearance(labels: np.ndarray) -> np.ndarray:
    """Return the order of the boxes if the labels come in the order of their first points."""
    names = np.unique(labels[labels > 0])
    return np.argsort([labels.tolist().index(name) for name in names])


def _same_boxes(answer: object, predicted: np.ndarray) -> bool:
    """Return whether boxes have the same corners, in any order."""
    try:
        yours = as_array(answer)
    except CheckFailed:
        return False
    return yours.shape == predicted.shape and all(map(same_corners, yours, predicted))


mistakes(
    "get_bounding_boxes",
    Mistake(
        "`elif` asks about the maximum only where a point is no new minimum, so the first point of "
        "a cluster never counts as its largest.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (low, _without_first(low, high, cloud).max(axis=0))
        ),
        "Both questions must be asked of every point: `if` and `if`.",
    ),
    Mistake(
        "`elif` asks about the minimum only where a point is no new maximum, so the first point of "
        "a cluster never counts as its smallest.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (_without_first(low, high, cloud).min(axis=0), high)
        ),
        "Both questions must be asked of every point: `if` and `if`.",
    ),
    Mistake(
        "Minimum and maximum start at 0, so every box reaches to the sensor.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (np.minimum(low, 0), np.maximum(high, 0))
        ),
        "Start from the first point of the cluster, or from infinity.",
    ),
    Mistake(
        "The maximum starts at 0, so no box ends below it.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (low, np.maximum(high, 0))
        ),
        "Start from the first point of the cluster, or from minus infinity.",
    ),
    Mistake(
        "Label 0 gets a box, too. It is no obstacle.",
        lambda right, cloud, labels: np.concatenate(
            [np.repeat(cloud[labels == 0], 8, axis=0).reshape(-1, 8, 3), right]
        ),
        "Keep only labels > 0.",
    ),
    Mistake(
        "The last label gets no box: range stops before its end.",
        lambda right, cloud, labels: right[:-1],
        "Loop over np.unique(cluster_labels) instead, which knows about gaps, too.",
    ),
    Mistake(
        "Only the first label gets a box.",
        lambda right, cloud, labels: right[:1],
        "The loop over the labels ends too early: `return` belongs behind it, not into it.",
    ),
    Mistake(
        "The first label is left out, as if it were 0; where no point has label 0, it is an "
        "obstacle.",
        lambda right, cloud, labels: right[int(0 not in labels) :],
        "Keep labels > 0 instead of dropping the first: noise need not occur.",
    ),
    Mistake(
        "The labels are sorted and the points are not: each point gets the label of another.",
        lambda right, cloud, labels: _boxes_of(cloud, np.sort(labels)),
        "Leave cluster_labels as they are; np.unique(cluster_labels) is a sorted list beside them.",
    ),
    Mistake(
        "All points count for every box, whatever their label.",
        lambda right, cloud, labels: np.stack(
            [corners_between(cloud.min(axis=0), cloud.max(axis=0))] * len(right)
        ),
        "For each label take the rows with that label alone, cloud[cluster_labels == label].",
        is_cheap=True,
    ),
    Mistake(
        "One maximum serves x, y and z alike: axis=0 is missing.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (low, np.full(3, high.max()))
        ),
        "points.max(axis=0) gives three numbers, one for each column.",
    ),
    Mistake(
        "One minimum serves x, y and z alike: axis=0 is missing.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (np.full(3, low.min()), high)
        ),
        "points.min(axis=0) gives three numbers, one for each column.",
    ),
    Mistake(
        "One minimum and one maximum serve x, y and z alike: axis=0 is missing.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (np.full(3, low.min()), np.full(3, high.max()))
        ),
        "points.min(axis=0) gives three numbers, one for each column.",
    ),
    Mistake(
        "Minimum and maximum are not started afresh for each label: a box holds the ones before "
        "it, too.",
        lambda right, cloud, labels: _change_corners(
            [np.vstack(right[: row + 1]) for row in range(len(right))],
            lambda low, high: (low, high),
        ),
        "Set them inside the loop over the labels.",
    ),
    Mistake(
        "The boxes come in the order in which the labels first occur.",
        lambda right, cloud, labels: right[_order_of_appearance(labels)],
        "They belong in ascending order of the labels.",
    ),
    cases=tuple((cloud, labels) for cloud, labels, _ in _STREETS),
    right=_right_boxes,
    same=_same_boxes,
)
