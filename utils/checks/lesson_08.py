"""Visible checks of lesson 08: `get_bounding_boxes`."""

from collections.abc import Callable

import numpy as np

from utils.checks import common_box_checks, common_checks
from utils.checks.assertions import (
    CheckFailed,
    as_array,
    brief_text,
    frozen,
    parse_table,
    precondition,
)
from utils.checks.boxes import (
    assert_box_corners,
    corners_between,
    same_corners,
)
from utils.checks.common_checks import Case
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.run_cache import once_per_run

# A cluster around the origin whose first point is not extreme on any axis. The initial values of a
# search for its box and the order of the points do not matter here: separate checks cover these.
_POINTS = parse_table(
    "0.5 0.2 -0.1; -2 0.4 0.3; 3 -0.3 0.2; 0.1 -1.5 -0.4; -0.6 2.5 0.1; 1 0.7 -1.2; -0.2 -0.5 0.8"
)
_LOW, _HIGH = frozen((np.array([-2.0, -1.5, -1.2]), np.array([3.0, 2.5, 0.8])))
_BOX = frozen(corners_between(_LOW, _HIGH))
# The same cluster three times: unchanged, half as large, and enlarged and shifted.
_SIZES, _SHIFT = (1.0, 0.5, 1.5), 0.4
_CLOUD = frozen(np.vstack([_SIZES[0] * _POINTS, _SIZES[1] * _POINTS, _SIZES[2] * _POINTS + _SHIFT]))
_BOXES = frozen(np.stack([_SIZES[0] * _BOX, _SIZES[1] * _BOX, _SIZES[2] * _BOX + _SHIFT]))
_LABELS = frozen(np.repeat([1, 2, 3], 7))


@once_per_run
def require_single_box(get_bounding_boxes: Callable) -> None:
    """Assert that a single cluster gets the right box; raise `NotYet` if not."""
    with precondition("a single cluster gets the right box"):
        labels = np.ones(7, dtype=int)
        answer = get_bounding_boxes(_POINTS.copy(), labels.copy())
        assert_box_corners(answer, _BOX[None], _POINTS, labels)


@once_per_run
def require_three_boxes(get_bounding_boxes: Callable) -> None:
    """Assert that three clusters get the right boxes; raise `NotYet` if not."""
    with precondition("each of three clusters gets the right box"):
        answer = get_bounding_boxes(_CLOUD.copy(), _LABELS.copy())
        assert_box_corners(answer, _BOXES, _CLOUD, _LABELS)


@visible_check(
    "get_bounding_boxes",
    weight=4,
    title="Returns boxes that extend from the smallest to the largest x, y and z of their points",
    why="The car avoids only the boxes. It may hit anything that sticks out of a box, and it "
    "cannot use free space inside one.",
    hint="Take points.min(axis=0) and points.max(axis=0) of the rows with one label. Each "
    "coordinate of a corner is one of the two values.",
)
def extends_from_min_to_max(get_bounding_boxes: Callable) -> None:
    labels = np.ones(7, dtype=int)
    answer = get_bounding_boxes(_POINTS.copy(), labels.copy())
    assert_box_corners(answer, _BOX[None], _POINTS, labels)


@visible_check(
    "get_bounding_boxes",
    weight=3,
    title="Returns one box for each label above 0",
    why="One box around two cars also blocks the gap between them, and a car without a box is "
    "invisible.",
    hint="For each label, start again with only the rows of that label: cloud[cluster_labels == "
    "label].",
)
def returns_one_box_per_label(get_bounding_boxes: Callable) -> None:
    require_single_box(get_bounding_boxes)
    answer = get_bounding_boxes(_CLOUD.copy(), _LABELS.copy())
    assert_box_corners(answer, _BOXES, _CLOUD, _LABELS)


@visible_check(
    "get_bounding_boxes",
    weight=2,
    title="Does not round the coordinates",
    why="Rounding errors add up when later steps use these coordinates.",
    hint="Return the coordinates unrounded. Round numbers only when you print them.",
)
def does_not_round(get_bounding_boxes: Callable) -> None:
    require_three_boxes(get_bounding_boxes)
    points, labels = _POINTS + [0.0043, -0.0036, 0.0047], np.ones(7, dtype=int)
    answer = get_bounding_boxes(points.copy(), labels.copy())
    assert_box_corners(answer, _BOX[None] + [0.0043, -0.0036, 0.0047], points, labels)


@visible_check(
    "get_bounding_boxes",
    weight=3,
    title="Works on clusters in all directions, for example behind the car on the right",
    why="Behind the car on the right, x and y are negative. If their maximum starts at 0, the box "
    "reaches to the sensor.",
    hint="Start the minimum at np.inf and the maximum at -np.inf, or both at the first point.",
)
def works_in_all_directions(get_bounding_boxes: Callable) -> None:
    require_three_boxes(get_bounding_boxes)
    shifts = parse_table("9 6 3; -9 -6 -3")
    cloud = np.vstack([_POINTS + shift for shift in shifts])
    labels = np.repeat([1, 2], 7)
    boxes = np.stack([_BOX + shift for shift in shifts])
    assert_box_corners(get_bounding_boxes(cloud.copy(), labels.copy()), boxes, cloud, labels)


@visible_check(
    "get_bounding_boxes",
    weight=3,
    title="Returns the same boxes for points in any order",
    why="A scan lists its rows from the top beam down, so the first point of a cluster is often "
    "its highest. Without that point, the box is too low.",
    hint="Compare every point with both the minimum and the maximum: use `if` twice, not `elif`.",
)
def works_for_points_in_any_order(get_bounding_boxes: Callable) -> None:
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
common_box_checks.promise_label_gaps(
    _THREE_CASE,
    "allows_gaps",
    [2, 5, 9],
    hint="Use np.unique(cluster_labels), which lists the labels that occur. range(1, ...) also "
    "includes labels that do not occur.",
    weight=2,
)
common_box_checks.promise_label_order(_THREE_CASE, "orders_boxes_by_label", [2, 3, 1], weight=2)
common_box_checks.promise_no_box_for_noise(_THREE_CASE, "ignores_noise", weight=2)


@visible_check(
    "get_bounding_boxes",
    weight=2,
    title="Works on clusters of one point, two points or equal points",
    why="A thin post far away may give only a single return, and the car must still see it.",
    hint="Use the same code for every cluster: the minimum and the maximum of a single point are "
    "that point.",
)
def works_on_few_points(get_bounding_boxes: Callable) -> None:
    require_three_boxes(get_bounding_boxes)
    first, second, third = parse_table("6 2 -1.1; 5 2.6 -0.5; -3 -4.6 -1")
    cloud = np.vstack([first, second, third, first, second, third, third, third])
    labels = np.array([1, 1, 2, 3, 3, 4, 4, 4])
    pair = corners_between(np.minimum(first, second), np.maximum(first, second))
    post = corners_between(third, third)
    answer = get_bounding_boxes(cloud.copy(), labels.copy())
    assert_box_corners(answer, np.stack([pair, post, pair, post]), cloud, labels)


common_box_checks.promise_intensity_ignored(_THREE_CASE, "ignores_intensity", weight=2)
common_box_checks.promise_empty_result(
    _THREE_CASE,
    "returns_the_empty_shape",
    hint="End with .reshape(-1, 8, 3), because np.array([]) has shape (0,), or start from "
    "np.zeros((number_of_boxes, 8, 3)).",
    weight=2,
)
common_checks.promise_names(
    _THREE_CASE,
    "keeps_the_names",
    why="Other code may call get_bounding_boxes(cloud=..., cluster_labels=...).",
)
common_box_checks.promise_untouched(
    _THREE_CASE, "leaves_its_input", hint="Write the corners into a new array."
)


@note_check(
    "get_bounding_boxes",
    title="Gives corner k the larger x if k & 1, the larger y if k & 2 and the larger z if k & 4",
    why="The lesson's pictures use these numbers to draw the edges, so the edges cross if the "
    "corners are in another order. The picture of the box of seven points shows your numbers.",
)
def numbers_the_corners(get_bounding_boxes: Callable) -> None:
    box = as_array(get_bounding_boxes(_POINTS.copy(), np.ones(7, dtype=int)))[0]
    for corner in range(8):
        larger = [bool(corner & 1), bool(corner & 2), bool(corner & 4)]
        place = np.where(larger, _HIGH, _LOW)
        if np.abs(box[corner] - place).max() > 1e-3:
            raise CheckFailed(
                f"Corner {corner} is not in the same place as in the lesson.",
                yours=brief_text(box[corner]),
                expected=brief_text(place),
            )


@note_check(
    "get_bounding_boxes",
    title="Returns the boxes as an array",
    why="The next cells call boxes.min(axis=1), which fails for a list. End with np.array(...).",
)
def returns_an_array(get_bounding_boxes: Callable) -> None:
    answer = get_bounding_boxes(_CLOUD.copy(), _LABELS.copy())
    if isinstance(answer, (list, tuple)):
        raise CheckFailed(
            f"The function returns the boxes as a {type(answer).__name__}, not as an array."
        )


# Small streets with the corners of their boxes. The clusters do not overlap, their labels have no
# gaps, and some streets have a stray point. The first point of a cluster is its largest or its
# smallest on every axis. Each street has a different number of points.
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
    """Return axis-aligned boxes after `change` has replaced their lowest and highest corners."""
    corners = [change(box.min(axis=0), box.max(axis=0)) for box in right]
    return np.stack([corners_between(low, high) for low, high in corners])


def _without_first(low: np.ndarray, high: np.ndarray, cloud: np.ndarray) -> np.ndarray:
    """Return the points between two corners, except the first one in the cloud."""
    return cloud[((cloud >= low) & (cloud <= high)).all(axis=1)][1:]


def _boxes_of(cloud: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """Return the box of each label above 0."""
    clusters = [cloud[labels == label] for label in np.unique(labels[labels > 0])]
    corners = [(points.min(axis=0), points.max(axis=0)) for points in clusters]
    return np.stack([corners_between(low, high) for low, high in corners])


def _order_of_appearance(labels: np.ndarray) -> np.ndarray:
    """Return the order of the boxes if labels are processed in the order of first occurrence."""
    in_use = np.unique(labels[labels > 0])
    return np.argsort([labels.tolist().index(label) for label in in_use])


def _same_boxes(answer: object, predicted: np.ndarray) -> bool:
    """Return whether boxes have the same corners, in any order."""
    try:
        yours = as_array(answer)
    except CheckFailed:
        return False
    return yours.shape == predicted.shape and all(map(same_corners, yours, predicted))


declare_mistakes(
    "get_bounding_boxes",
    Mistake(
        "The first point of a cluster is never compared with the maximum, perhaps because of "
        "`elif`.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (low, _without_first(low, high, cloud).max(axis=0))
        ),
        "Compare every point with both values: use `if` twice.",
    ),
    Mistake(
        "The first point of a cluster is never compared with the minimum, perhaps because of "
        "`elif`.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (_without_first(low, high, cloud).min(axis=0), high)
        ),
        "Compare every point with both values: use `if` twice.",
    ),
    Mistake(
        "Minimum and maximum start at 0, so every box extends to the sensor.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (np.minimum(low, 0), np.maximum(high, 0))
        ),
        "Start from the first point of the cluster, or from np.inf and -np.inf.",
    ),
    Mistake(
        "The maximum starts at 0, so it is never below 0.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (low, np.maximum(high, 0))
        ),
        "Start from the first point of the cluster, or from -np.inf.",
    ),
    Mistake(
        "Label 0 also gets a box, but it is not an obstacle.",
        lambda right, cloud, labels: np.concatenate(
            [np.repeat(cloud[labels == 0], 8, axis=0).reshape(-1, 8, 3), right]
        ),
        "Keep only labels > 0.",
    ),
    Mistake(
        "The last label gets no box.",
        lambda right, cloud, labels: right[:-1],
        "Loop over the labels above 0 in np.unique(cluster_labels). range(1, n) ends before n.",
    ),
    Mistake(
        "Only the first label gets a box.",
        lambda right, cloud, labels: right[:1],
        "The loop over the labels ends too early: put `return` after the loop, not inside it.",
    ),
    Mistake(
        "Your code always skips the smallest label. If no point has label 0, the smallest label "
        "is an obstacle.",
        lambda right, cloud, labels: right[int(0 not in labels) :],
        "Keep labels > 0 instead of dropping the first label: label 0 may be absent.",
    ),
    Mistake(
        "The function sorts the labels but not the points, so points get the labels of other "
        "points.",
        lambda right, cloud, labels: _boxes_of(cloud, np.sort(labels)),
        "Leave cluster_labels unchanged: np.unique(cluster_labels) returns a new, sorted array.",
    ),
    Mistake(
        "Every box is built from all points, whatever their labels.",
        lambda right, cloud, labels: np.stack(
            [corners_between(cloud.min(axis=0), cloud.max(axis=0))] * len(right)
        ),
        "For each label, take only the rows with that label: cloud[cluster_labels == label].",
        is_cheap=True,
    ),
    Mistake(
        "One maximum is used for x, y and z: axis=0 is missing.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (low, np.full(3, high.max()))
        ),
        "Write points.max(axis=0), which gives one number for each column.",
    ),
    Mistake(
        "One minimum is used for x, y and z: axis=0 is missing.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (np.full(3, low.min()), high)
        ),
        "Write points.min(axis=0), which gives one number for each column.",
    ),
    Mistake(
        "One minimum and one maximum are used for x, y and z: axis=0 is missing.",
        lambda right, cloud, labels: _change_corners(
            right, lambda low, high: (np.full(3, low.min()), np.full(3, high.max()))
        ),
        "Write points.min(axis=0) and points.max(axis=0), which give one number for each column.",
    ),
    Mistake(
        "Minimum and maximum are not reset for each label, so each box also contains the boxes "
        "before it.",
        lambda right, cloud, labels: _change_corners(
            [np.vstack(right[: row + 1]) for row in range(len(right))],
            lambda low, high: (low, high),
        ),
        "Initialise them inside the loop over the labels.",
    ),
    Mistake(
        "The boxes are in the order in which the labels first occur.",
        lambda right, cloud, labels: right[_order_of_appearance(labels)],
        "Sort the boxes by label, in ascending order.",
    ),
    cases=tuple((cloud, labels) for cloud, labels, _ in _STREETS),
    right=_right_boxes,
    is_same=_same_boxes,
)
