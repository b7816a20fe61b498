"""Broken versions of a student's functions; this file contains no solutions.

A version calls the student's own right function with other arguments, or changes its answer.
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
        Takes the right function and a cloud; returns the broken answer.
    says : str
        A description of the fault, shown once a student has found it.
    smallest : int
        Number of rows of the smallest cloud that shows the fault.
    """

    answer: Callable
    says: str
    smallest: int


@dataclass(frozen=True)
class Puzzle:
    """Broken versions of one function, and a cloud that shows all their faults.

    Attributes
    ----------
    answer_of : callable
        Takes the right function and a cloud; returns the right answer.
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

ROUNDS, TOLERANCE = 200, 0.5


def _line(ransac_line: Callable, points: np.ndarray, tolerance: float = TOLERANCE) -> tuple:
    return ransac_line(points.copy(), ROUNDS, tolerance, 0)


def _no_upright_line(ransac_line: Callable, points: np.ndarray) -> tuple:
    line, inliers = _line(ransac_line, points)
    if line is not None and abs(line[1]) < 1e-9:
        return None, np.zeros(len(points), dtype=bool)
    return line, inliers


def _without_the_last(ransac_line: Callable, points: np.ndarray) -> tuple:
    line, inliers = _line(ransac_line, points[:-1])
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
_OTHERS = [[6, 1.5], [7.5, -2], [0.5, 2], [5.5, -3.5], [8, 3.2], [0.2, -1.5], [3.4, 3.2]]

# ---- 05 and 10: clustering ---------------------------------------------------------------------

THRESHOLD = 0.8


def _labels(cluster: Callable, cloud: np.ndarray, threshold: float = THRESHOLD) -> np.ndarray:
    return np.asarray(cluster(np.array(cloud, dtype=float), threshold))


def _flat(cloud: np.ndarray) -> np.ndarray:
    return cloud * [1, 1, 0]


def _balls(_: Callable, cloud: np.ndarray) -> np.ndarray:
    """Group each unlabelled point with all other unlabelled points within the threshold."""
    labels = np.zeros(len(cloud), dtype=int)
    while 0 in labels:
        near = np.linalg.norm(cloud - cloud[np.argmin(labels)], axis=1) < THRESHOLD
        labels[near & (labels == 0)] = labels.max() + 1
    return labels


def _cells(cloud: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the occupied cells, the first point of each, and the cell of each point."""
    cells = np.floor(cloud / (THRESHOLD / np.sqrt(3)))
    return np.unique(cells, axis=0, return_index=True, return_inverse=True)


def _touching_cells(cluster: Callable, cloud: np.ndarray) -> np.ndarray:
    cells, _, where = _cells(cloud)
    return _labels(cluster, cells, 1.8)[where.ravel()]  # diagonal neighbours are 1.73 apart


def _first_of_cell(cluster: Callable, cloud: np.ndarray) -> np.ndarray:
    _, first, where = _cells(cloud)
    return _labels(cluster, cloud[first])[where.ravel()]


def _groups(labels: np.ndarray) -> np.ndarray:
    """Return which pairs of points share a label, so that the labels' values do not matter."""
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


def _boxes(get_bounding_boxes: Callable, rows: np.ndarray) -> np.ndarray:
    return np.asarray(get_bounding_boxes(rows[:, :3].copy(), rows[:, 3].astype(int)))


def _of_noise_too(get_bounding_boxes: Callable, rows: np.ndarray) -> np.ndarray:
    return _boxes(get_bounding_boxes, rows + [0, 0, 0, 1])


def _without_gaps(get_bounding_boxes: Callable, rows: np.ndarray) -> np.ndarray:
    count = len(np.unique(rows[rows[:, 3] > 0, 3]))
    return _boxes(get_bounding_boxes, rows[rows[:, 3] <= count])


def _from_zero(get_bounding_boxes: Callable, rows: np.ndarray) -> np.ndarray:
    labels = np.unique(rows[rows[:, 3] > 0, 3])
    origins = np.column_stack([np.zeros((len(labels), 3)), labels])
    return _boxes(get_bounding_boxes, np.vstack([rows, origins]))


def _corners(boxes: np.ndarray) -> np.ndarray:
    """Return the corners of each box, sorted so that their order does not matter."""
    ordered = [box[np.lexsort(box.T)] for box in np.asarray(boxes, dtype=float).reshape(-1, 8, 3)]
    return np.array(ordered).reshape(-1, 8, 3)


def _draw_boxes(rows: np.ndarray, boxes: np.ndarray, _: np.ndarray, axes: Axes) -> None:
    from utils import plots

    limits = ((-0.8, 8), (-3.5, 3.5))
    plots.clusters(rows[:, :2], rows[:, 3].astype(int), axes=axes, limits=limits)
    plots.boxes(boxes, axes=axes)
    axes.get_legend().remove()


_LABELLED = [[2, 1, 0, 1], [3.5, 1.5, 0, 1], [3, 2.2, 1, 1], [5, -1, 0, 3], [6.5, -2, 1, 3],
             [5.4, -2.4, 0, 3], [1, -2.5, 0, 0], [7, 2.5, 0, 0], [4, 0.1, 0, 0]]  # fmt: skip


PUZZLES = {
    "ransac_line": Puzzle(
        _line,
        _inlier_count,
        _draw_line,
        "x, y",
        np.array(_WALL + _OTHERS, dtype=float),
        {
            "A": Version(_no_upright_line, "It describes lines by y = m x + q.", 2),
            "B": Version(_without_the_last, "It never looks at the last point.", 2),
            "C": Version(
                lambda ransac, points: _line(ransac, points, TOLERANCE**2),
                "It compares the distance with the square of the threshold.",
                3,
            ),
        },
    ),
    "euclidean_clustering": Puzzle(
        _labels,
        _groups,
        _draw_clusters,
        "x, y, z",
        np.array(_STREET, dtype=float),
        {
            "A": Version(
                lambda cluster, cloud: _labels(cluster, _flat(cloud)), "It ignores the height.", 2
            ),
            "B": Version(_balls, "It compares points only with the first point of a cluster.", 3),
            "C": Version(
                lambda cluster, cloud: _labels(cluster, cloud, THRESHOLD**0.5),
                "It compares the squared distance with the threshold.",
                2,
            ),
        },
    ),
    "get_bounding_boxes": Puzzle(
        _boxes,
        _corners,
        _draw_boxes,
        "x, y, z, label",
        np.array(_LABELLED, dtype=float),
        {
            "A": Version(_from_zero, "It starts with low = high = 0.", 1),
            "B": Version(_without_gaps, "It assumes that the labels have no gaps: 1, 2, 3, ...", 1),
            "C": Version(_of_noise_too, "It also draws a box around label 0.", 1),
        },
    ),
    "euclidean_clustering_accelerated": Puzzle(
        _labels,
        _groups,
        _draw_clusters,
        "x, y, z",
        np.array(_CROWDED, dtype=float),
        {
            "A": Version(_first_of_cell, "It looks only at the first point of each cell.", 3),
            "B": Version(_touching_cells, "It joins points exactly when their cells touch.", 2),
            "C": Version(
                lambda cluster, cloud: _labels(cluster, _flat(cloud)), "It ignores the height.", 2
            ),
        },
    ),
}
