"""Visible checks of lesson 08: `get_bounding_boxes`."""

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np

from utils.checks.boxes import as_cluster_boxes, assert_box_corners
from utils.checks.core import visible
from utils.checks.vocabulary import assert_untouched, frozen

# A car ahead on the left and a pedestrian behind on the right; the first row of each is its
# largest corner, and stray points of label 0 lie around.
_CLOUD = frozen(
    np.array(
        [
            [9.0, 3.5, 0.1, 0.3],
            [-2.5, -4.0, 0.2, 0.5],
            [20.0, 9.0, 1.0, 0.9],
            [6.0, 2.0, -1.1, 0.2],
            [5.0, 2.6, -0.5, 0.9],
            [-3.0, -4.6, -1.0, 0.1],
            [7.7, 1.6, -0.9, 0.4],
            [-15.0, -9.0, -1.4, 0.0],
            [-2.9, -4.2, -0.3, 0.6],
        ]
    )
)
_LABELS = frozen(np.array([1, 2, 0, 1, 1, 2, 1, 0, 2]))


def _corners(low: Sequence[float], high: Sequence[float]) -> np.ndarray:
    """(8, 3): x changes fastest, as in corner k with bits 1, 2, 4 for x, y, z."""
    return np.array(list(product(*zip(low[::-1], high[::-1], strict=True))))[:, ::-1]


_CAR = frozen(_corners([5.0, 1.6, -1.1], [9.0, 3.5, 0.1]))
_PEDESTRIAN = frozen(_corners([-3.0, -4.6, -1.0], [-2.5, -4.0, 0.2]))


@visible(
    "get_bounding_boxes",
    weight=4,
    title="Each box reaches from the smallest to the largest x, y and z of its cluster",
    why="A corner too few centimetres out and the car scrapes along what it did not box.",
    hint="points.min(axis=0) and points.max(axis=0) of the rows of one label give all six "
    "numbers; a corner takes, for each axis, one or the other.",
)
def reaches_from_min_to_max(get_bounding_boxes: Callable) -> None:
    only_car = np.where(_LABELS == 1, 1, 0)
    assert_box_corners(
        get_bounding_boxes(_CLOUD.copy(), only_car.copy()), _CAR[None], _CLOUD, only_car
    )
    assert_box_corners(
        get_bounding_boxes(_CLOUD.copy(), _LABELS.copy()),
        np.stack([_CAR, _PEDESTRIAN]),
        _CLOUD,
        _LABELS,
    )


@visible(
    "get_bounding_boxes",
    weight=3,
    title="One box for each label above 0, in ascending order, gaps or not",
    why="Filters remove clusters and leave gaps in the numbers; the next step still wants "
    "to know which box is whose.",
    hint="np.unique(cluster_labels) lists the labels that occur, in ascending order. "
    "range(1, ...) would invent those that do not.",
)
def one_box_for_each_label(get_bounding_boxes: Callable) -> None:
    swapped = np.array([0, 7, 3])[_LABELS]  # the car is 7, the pedestrian 3
    assert_box_corners(
        get_bounding_boxes(_CLOUD.copy(), swapped.copy()),
        np.stack([_PEDESTRIAN, _CAR]),
        _CLOUD,
        swapped,
    )
    assert_box_corners(
        get_bounding_boxes(cloud=_CLOUD.copy(), cluster_labels=swapped.copy()),
        np.stack([_PEDESTRIAN, _CAR]),
        _CLOUD,
        swapped,
    )


@visible(
    "get_bounding_boxes",
    weight=2,
    title="Label 0 is no obstacle",
    why="Stray points lie all over the street: their box would be the street, with us in it.",
    hint="Keep only labels > 0 before you loop.",
)
def leaves_noise_alone(get_bounding_boxes: Callable) -> None:
    noise_first = np.vstack([_CLOUD[_LABELS == 0], _CLOUD[_LABELS > 0]])
    labels = np.concatenate([_LABELS[_LABELS == 0], _LABELS[_LABELS > 0]])
    assert_box_corners(
        get_bounding_boxes(noise_first.copy(), labels.copy()),
        np.stack([_CAR, _PEDESTRIAN]),
        noise_first,
        labels,
    )


@visible(
    "get_bounding_boxes",
    weight=2,
    title="Takes three columns as well as four, and clusters of one or two points",
    why="Some recordings hold no intensity, and a thin post far away returns a single point.",
    hint="Take the coordinates with cloud[mask, :3]; minimum and maximum of a single point "
    "are both that point.",
)
def takes_every_shape(get_bounding_boxes: Callable) -> None:
    xyz = _CLOUD[:, :3]
    assert_box_corners(
        get_bounding_boxes(xyz.copy(), _LABELS.copy()), np.stack([_CAR, _PEDESTRIAN]), xyz, _LABELS
    )
    few = np.array([4, 0, 0, 9, 9, 0, 0, 0, 0])
    assert_box_corners(
        get_bounding_boxes(_CLOUD.copy(), few.copy()),
        np.stack([_corners(_CLOUD[0, :3], _CLOUD[0, :3]), _corners([5, 2, -1.1], [6, 2.6, -0.5])]),
        _CLOUD,
        few,
    )


@visible(
    "get_bounding_boxes",
    weight=2,
    title="No cluster, no box: the shape is then (0, 8, 3)",
    why="On an empty road nothing is boxed, and the planner still asks for boxes[:, 0].",
    hint="np.array([]) has shape (0,). End with .reshape(-1, 8, 3), or start from "
    "np.zeros((number_of_boxes, 8, 3)).",
)
def takes_nothing(get_bounding_boxes: Callable) -> None:
    noise = np.zeros(len(_CLOUD), dtype=int)
    as_cluster_boxes(get_bounding_boxes(_CLOUD.copy(), noise.copy()), noise)
    for columns in (3, 4):
        none = np.zeros(0, dtype=int)
        as_cluster_boxes(get_bounding_boxes(np.empty((0, columns)), none.copy()), none)
    # Something must still come where there is something.
    assert_box_corners(
        get_bounding_boxes(_CLOUD.copy(), _LABELS.copy()),
        np.stack([_CAR, _PEDESTRIAN]),
        _CLOUD,
        _LABELS,
    )


@visible(
    "get_bounding_boxes",
    weight=1,
    title="Leaves cloud and labels untouched",
    why="The next step still needs them.",
    hint="Write the corners into an array of their own.",
)
def leaves_its_input(get_bounding_boxes: Callable) -> None:
    assert_untouched(get_bounding_boxes, _CLOUD, _LABELS)
    boxes = get_bounding_boxes(_CLOUD.copy(), _LABELS.copy())
    assert_box_corners(boxes, np.stack([_CAR, _PEDESTRIAN]), _CLOUD, _LABELS)
