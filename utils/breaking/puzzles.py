"""Broken versions of a student's functions; this file contains no solutions.

A version calls the student's own correct function with other arguments, or changes its answer.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Version:
    """A broken version of a function.

    Attributes
    ----------
    answer : callable
        Takes the correct function and a cloud; returns the broken answer.
    description : str
        A description of the fault, shown once a student has found it.
    smallest_row_count : int
        Number of rows of the smallest cloud that shows the fault.
    """

    answer: Callable
    description: str
    smallest_row_count: int


@dataclass(frozen=True)
class Puzzle:
    """Broken versions of one function, and a cloud that shows all their faults.

    Attributes
    ----------
    answer_of : callable
        Takes the correct function and a cloud; returns the right answer.
    comparable : callable
        Converts an answer to an array that is equal for equivalent answers.
    draw : callable
        Draws an answer, given the cloud, the answer, the right answer and axes.
    columns : str
        Names of the columns of a cloud.
    example : numpy.ndarray
        The cloud that `show_broken` draws.
    versions : dict of str to Version
        Versions by letter.
    """

    answer_of: Callable
    comparable: Callable
    draw: Callable[[np.ndarray, object, object, Axes], object]
    columns: str
    example: np.ndarray
    versions: dict[str, Version]


# ---- 02: ransac_line ---------------------------------------------------------------------------

MAX_ITERATIONS, TOLERANCE = 200, 0.5


def _find_line(ransac_line: Callable, points: np.ndarray, tolerance: float = TOLERANCE) -> tuple:
    return ransac_line(points.copy(), MAX_ITERATIONS, tolerance, 0)


def _find_line_unless_upright(ransac_line: Callable, points: np.ndarray) -> tuple:
    line, inliers = _find_line(ransac_line, points)
    if line is not None and abs(line[1]) < 1e-9:
        return None, np.zeros(len(points), dtype=bool)
    return line, inliers


def _find_line_without_last_point(ransac_line: Callable, points: np.ndarray) -> tuple:
    line, inliers = _find_line(ransac_line, points[:-1])
    return line, np.append(inliers, False)[: len(points)]


def _draw_line(points: np.ndarray, answer: tuple, _: tuple, axes: Axes) -> None:
    from utils import plots

    line, inliers = answer
    plots.line_model(points, line, np.asarray(inliers, dtype=bool), TOLERANCE, axes=axes,
                     limits=((-1, 9), (-4.5, 4.5)))  # fmt: skip
    axes.get_legend().remove()


def _inlier_count(answer: tuple) -> np.ndarray:
    """Return the number of inliers: lines with equal numbers of inliers are equally good."""
    return np.array(np.sum(np.asarray(answer[1], dtype=bool)))


_WALL = [[3, -4], [3, -2.5], [3, -1], [3, 1], [3, 2.5], [3, 4], [3.4, -1.8], [2.6, 0.2]]
_OUTLIERS = [[6, 1.5], [7.5, -2], [0.5, 2], [5.5, -3.5], [8, 3.2], [0.2, -1.5], [3.4, 3.2]]

# ---- 05 and 10: clustering ---------------------------------------------------------------------

THRESHOLD = 0.8


def _labels(clustering: Callable, cloud: np.ndarray, threshold: float = THRESHOLD) -> np.ndarray:
    return np.asarray(clustering(np.array(cloud, dtype=float), threshold))


def _without_height(cloud: np.ndarray) -> np.ndarray:
    return cloud * [1, 1, 0]


def _cluster_into_balls(_: Callable, cloud: np.ndarray) -> np.ndarray:
    """Group each unlabelled point with all other unlabelled points within the threshold."""
    labels = np.zeros(len(cloud), dtype=int)
    while 0 in labels:
        near = np.linalg.norm(cloud - cloud[np.argmin(labels)], axis=1) < THRESHOLD
        labels[near & (labels == 0)] = labels.max() + 1
    return labels


def _occupied_cells(cloud: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the occupied cells, the first point of each, and the cell of each point."""
    cells = np.floor(cloud / (THRESHOLD / np.sqrt(3)))
    return np.unique(cells, axis=0, return_index=True, return_inverse=True)


def _cluster_touching_cells(clustering: Callable, cloud: np.ndarray) -> np.ndarray:
    cells, _, where = _occupied_cells(cloud)
    return _labels(clustering, cells, 1.8)[where.ravel()]  # diagonal neighbours are 1.73 apart


def _cluster_first_points_of_cells(clustering: Callable, cloud: np.ndarray) -> np.ndarray:
    _, first, where = _occupied_cells(cloud)
    return _labels(clustering, cloud[first])[where.ravel()]


def _same_label_mask(labels: np.ndarray) -> np.ndarray:
    """Return which pairs of points share a label, whatever the values of the labels."""
    labels = np.asarray(labels)
    return labels[:, None] == labels[None]


def _draw_clusters(cloud: np.ndarray, labels: np.ndarray, right: np.ndarray, axes: Axes) -> None:
    from utils import plots

    limits = ((-0.5, 6.5), (-2.4, 2.4))
    plots.clusters(cloud[:, :2], labels, like=right, axes=axes, limits=limits)
    for row, z in enumerate(cloud[:, 2]):
        if z:
            axes.annotate(f"{z:g} m up", cloud[row, :2], xytext=(6, 4), fontsize=8,
                          textcoords="offset points")  # fmt: skip
    axes.get_legend().remove()


_STREET = [[0, 0, 0], [0.7, 0.1, 0], [1.4, 0, 0], [2.1, 0.1, 0], [2.8, 0, 0], [3.64, 0.1, 0],
           [5, 1, 0], [5.3, 1.5, 0], [5.4, 1.2, 2.5], [5, -1, 0], [5.6, -1.5, 0], [0.3, 1.5, 0],
           [0.1, 1.9, 0], [1.5, -1.5, 0], [2.25, -1.6, 0], [2.8, -2, 0]]  # fmt: skip

_CROWDED = [[0.05, 0.1, 0], [0.42, 0.1, 0], [1.2, 0.1, 0], [1.6, 0.3, 0], [2.8, 1.5, 0],
            [3.68, 1.5, 0], [5, -1, 0], [5.3, -1.2, 0], [5.4, -1, 2.5], [2.4, -1.4, 0],
            [2.7, -1.4, 0], [3.45, -1.4, 0], [0.3, 1.6, 0], [0.5, 1.9, 0]]  # fmt: skip

# ---- 08: get_bounding_boxes --------------------------------------------------------------------


def _bounding_boxes(get_bounding_boxes: Callable, rows: np.ndarray) -> np.ndarray:
    return np.asarray(get_bounding_boxes(rows[:, :3].copy(), rows[:, 3].astype(int)))


def _labels_of(rows: np.ndarray) -> np.ndarray:
    return np.unique(rows[rows[:, 3] > 0, 3])


def _bounding_boxes_with_noise(get_bounding_boxes: Callable, rows: np.ndarray) -> np.ndarray:
    return _bounding_boxes(get_bounding_boxes, rows + [0, 0, 0, 1])


def _bounding_boxes_without_gaps(get_bounding_boxes: Callable, rows: np.ndarray) -> np.ndarray:
    count = len(_labels_of(rows))
    return _bounding_boxes(get_bounding_boxes, rows[rows[:, 3] <= count])


def _bounding_boxes_from_origin(get_bounding_boxes: Callable, rows: np.ndarray) -> np.ndarray:
    labels = _labels_of(rows)
    origins = np.column_stack([np.zeros((len(labels), 3)), labels])
    return _bounding_boxes(get_bounding_boxes, np.vstack([rows, origins]))


def _sorted_corners(boxes: np.ndarray) -> np.ndarray:
    """Return the corners of each box, sorted so that their order does not matter."""
    ordered = [
        box[np.lexsort(box.round(6).T)]  # rounding errors do not change the order
        for box in np.asarray(boxes, dtype=float).reshape(-1, 8, 3)
    ]
    return np.array(ordered).reshape(-1, 8, 3)


def _draw_boxes(rows: np.ndarray, boxes: np.ndarray, _: np.ndarray, axes: Axes) -> None:
    from utils import plots

    limits = ((-0.8, 8), (-3.5, 3.5))
    plots.clusters(rows[:, :2], rows[:, 3].astype(int), axes=axes, limits=limits)
    plots.boxes(boxes, axes=axes)
    axes.get_legend().remove()


_LABELLED_POINTS = [[2, 1, 0, 1], [3.5, 1.5, 0, 1], [3, 2.2, 1, 1], [5, -1, 0, 3], [6.5, -2, 1, 3],
             [5.4, -2.4, 0, 3], [1, -2.5, 0, 0], [7, 2.5, 0, 0], [4, 0.1, 0, 0]]  # fmt: skip

# ---- 11: get_oriented_boxes --------------------------------------------------------------------


def _boxes_around_means(get_oriented_boxes: Callable, rows: np.ndarray) -> np.ndarray:
    boxes = _bounding_boxes(get_oriented_boxes, rows)
    means = [rows[rows[:, 3] == label, :3].mean(axis=0) for label in _labels_of(rows)]
    return boxes + np.reshape(means, (-1, 1, 3)) - boxes.mean(axis=1, keepdims=True)


def _boxes_without_outliers(get_oriented_boxes: Callable, rows: np.ndarray) -> np.ndarray:
    near = np.ones(len(rows), dtype=bool)
    for label in _labels_of(rows):
        mine = rows[:, 3] == label
        off = np.abs(rows[mine, :3] - rows[mine, :3].mean(axis=0))
        near[mine] = (off <= 2 * rows[mine, :3].std(axis=0) + 1e-9).all(axis=1)
    return _bounding_boxes(get_oriented_boxes, rows[near])


def _boxes_turned_sideways(get_oriented_boxes: Callable, rows: np.ndarray) -> np.ndarray:
    boxes = _bounding_boxes(get_oriented_boxes, rows)
    middle = boxes.mean(axis=1, keepdims=True)
    x, y, z = np.moveaxis(boxes - middle, 2, 0)
    return middle + np.stack([-y, x, z], axis=2)


# Two sides of a car at an angle of 25°, and a person with an outstretched arm.
_CAR_AND_PERSON = [
    [1.9, -2.2, 0, 1], [2.35, -1.99, 0, 1], [2.81, -1.78, 0, 1], [3.26, -1.57, 0, 1],
    [3.71, -1.35, 0, 1], [4.17, -1.14, 0, 1], [4.62, -0.93, 0, 1], [5.07, -0.72, 0, 1],
    [5.53, -0.51, 0, 1], [1.65, -1.66, 0, 1], [1.39, -1.11, 0, 1], [1.14, -0.57, 0, 1],
    [4, 2.2, 0, 3], [4.3, 2.1, 0, 3], [4.1, 2.5, 0, 3], [4.4, 2.4, 0, 3], [4.2, 2.3, 0, 3],
    [4.3, 2.5, 0, 3], [5.4, 2.7, 0, 3], [6.5, -2.5, 0, 0], [0.5, 2, 0, 0],
]  # fmt: skip


PUZZLES = {
    "ransac_line": Puzzle(
        _find_line,
        _inlier_count,
        _draw_line,
        "x, y",
        np.array(_WALL + _OUTLIERS, dtype=float),
        {
            "A": Version(_find_line_unless_upright, "It describes lines by y = m x + h.", 2),
            "B": Version(_find_line_without_last_point, "It never looks at the last point.", 2),
            "C": Version(
                lambda ransac, points: _find_line(ransac, points, TOLERANCE**2),
                "It compares the distance with the square of the threshold.",
                3,
            ),
        },
    ),
    "euclidean_clustering": Puzzle(
        _labels,
        _same_label_mask,
        _draw_clusters,
        "x, y, z",
        np.array(_STREET, dtype=float),
        {
            "A": Version(
                lambda clustering, cloud: _labels(clustering, _without_height(cloud)),
                "It ignores the height.",
                2,
            ),
            "B": Version(
                _cluster_into_balls, "It compares points only with the first point of a cluster.", 3
            ),
            "C": Version(
                lambda clustering, cloud: _labels(clustering, cloud, THRESHOLD**0.5),
                "It compares the squared distance with the threshold.",
                2,
            ),
        },
    ),
    "get_bounding_boxes": Puzzle(
        _bounding_boxes,
        _sorted_corners,
        _draw_boxes,
        "x, y, z, label",
        np.array(_LABELLED_POINTS, dtype=float),
        {
            "A": Version(_bounding_boxes_from_origin, "It starts with low = high = 0.", 1),
            "B": Version(
                _bounding_boxes_without_gaps,
                "It assumes that the labels have no gaps: 1, 2, 3, ...",
                1,
            ),
            "C": Version(_bounding_boxes_with_noise, "It also draws a box around label 0.", 1),
        },
    ),
    "get_oriented_boxes": Puzzle(
        _bounding_boxes,
        _sorted_corners,
        _draw_boxes,
        "x, y, z, label",
        np.array(_CAR_AND_PERSON, dtype=float),
        {
            "A": Version(
                _boxes_without_outliers,
                "It ignores points more than two standard deviations from the mean.",
                6,
            ),
            "B": Version(_boxes_around_means, "It centres each box at the mean of the points.", 3),
            "C": Version(_boxes_turned_sideways, "It swaps the length and the width.", 2),
        },
    ),
    "euclidean_clustering_accelerated": Puzzle(
        _labels,
        _same_label_mask,
        _draw_clusters,
        "x, y, z",
        np.array(_CROWDED, dtype=float),
        {
            "A": Version(
                _cluster_first_points_of_cells, "It looks only at the first point of each cell.", 3
            ),
            "B": Version(
                _cluster_touching_cells, "It joins points exactly when their cells touch.", 2
            ),
            "C": Version(
                lambda clustering, cloud: _labels(clustering, _without_height(cloud)),
                "It ignores the height.",
                2,
            ),
        },
    ),
}
