"""Common mistakes in clustering, predicted for points on a straight line.

On a line, a cluster ends at each gap that is too wide, so the effect of a mistake follows from the
distances between adjacent points.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from utils.checks.assertions import CheckFailed, as_array, count_overlaps, frozen
from utils.checks.clusters import renumber_by_appearance
from utils.checks.diagnosis import Mistake

# Directions of lines along which a distance in the plane, or along one axis, differs from the
# distance in space. The coordinates rotate from one direction to the next.
_DIRECTIONS = frozen(np.array([[2.0, 3.0, 6.0], [6.0, 2.0, 3.0], [3.0, 6.0, 2.0]]) / 7)


# Gaps as multiples of the threshold. Measured along one or two axes, they are shorter. Each such
# measure makes different gaps shorter than the threshold.
_TOO_WIDE = frozen(np.array([1.02, 1.075, 1.13, 1.5, 2.1, 2.9]))


def same_clusters(answer: object, predicted: np.ndarray) -> bool:
    """Return whether an answer groups points as predicted, with the same set of labels."""
    try:
        yours = as_array(answer)
    except CheckFailed:
        return False
    if yours.shape != predicted.shape or yours.ndim != 1:
        return False
    shared, number, _ = count_overlaps(yours, predicted)
    return shared == number and np.array_equal(np.unique(yours), np.unique(predicted))


def points_on_line(
    places: Sequence[float], brightness: float = 0.0, direction: ArrayLike = _DIRECTIONS[0]
) -> np.ndarray:
    """Return points on a straight line through the sensor.

    Parameters
    ----------
    places : sequence of float, length n
        Positions along the line in metres; negative behind the sensor.
    brightness : float
        Intensity per metre; 0 for a cloud without intensities.
    direction : array_like, shape (3,)
        A unit vector without negative components.

    Returns
    -------
    numpy.ndarray, shape (n, 3) or (n, 4)
    """
    cloud = np.outer(places, direction)
    return np.column_stack([cloud, brightness * np.array(places)]) if brightness else cloud


def label_line(cloud: np.ndarray, joins: Callable) -> np.ndarray:
    """Label points on a line; a new cluster begins wherever two adjacent points are not joined.

    Parameters
    ----------
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    joins : callable
        Takes the points in their order along the line, and their rows in the cloud. Returns
        whether each point is joined to the next, shape (n - 1,).

    Returns
    -------
    numpy.ndarray of int, shape (n,)
    """
    order = np.argsort(cloud[:, :3].sum(axis=1))
    labels = np.empty(len(cloud), dtype=int)
    labels[order] = np.concatenate([[0], np.cumsum(~joins(cloud[order], order))])
    return renumber_by_appearance(labels)


def prediction_with_measure(measure: Callable) -> Callable:
    """Return the prediction for a function that measures the gaps with `measure`.

    Parameters
    ----------
    measure : callable
        Takes the vectors from each point to the next, shape (n - 1, columns), and the threshold.
        Returns the measured length of each vector as a multiple of the threshold, shape (n - 1,).

    Returns
    -------
    callable
        As `Mistake.predict`.
    """

    def predict(right: np.ndarray, cloud: np.ndarray, threshold: float) -> np.ndarray:
        return label_line(cloud, lambda line, _: measure(np.diff(line, axis=0), threshold) < 1)

    return predict


def lengths(steps: np.ndarray) -> np.ndarray:
    """Return the length of each step, computed from all its columns; shape (n,)."""
    return np.linalg.norm(steps, axis=1)


def right_labels_of_line(cloud: np.ndarray, threshold: float) -> np.ndarray:
    """Return the right labels of points on a line, shape (n,)."""
    return prediction_with_measure(lambda steps, limit: lengths(steps[:, :3]) / limit)(
        None, cloud, threshold
    )


def distance_mistakes() -> tuple[Mistake, ...]:
    """Return the mistakes about distances that both clustering lessons share."""
    return (
        Mistake(
            "The distance is compared with threshold ** 2, so 0.5 acts like 0.25.",
            prediction_with_measure(lambda steps, limit: lengths(steps[:, :3]) / limit**2),
            "np.linalg.norm gives distances. Compare them with threshold itself.",
        ),
        Mistake(
            "The squared distance is compared with threshold itself, so 0.5 acts like 0.71.",
            prediction_with_measure(lambda steps, limit: lengths(steps[:, :3]) ** 2 / limit),
            "Take the square root first, as np.linalg.norm does.",
        ),
        Mistake(
            "The function always uses a threshold of 0.5 and ignores the parameter threshold.",
            prediction_with_measure(lambda steps, limit: lengths(steps[:, :3]) / 0.5),
            "Use the parameter threshold instead of the number 0.5.",
        ),
        Mistake(
            "The function uses intensity as a fourth coordinate.",
            prediction_with_measure(lambda steps, limit: lengths(steps) / limit),
            "Use only the coordinates: cloud[:, :3].",
        ),
        Mistake(
            "The height is left out: the function measures distances only along x and y.",
            prediction_with_measure(lambda steps, limit: lengths(steps[:, :2]) / limit),
            "Use all three coordinates: cloud[:, :3].",
        ),
        *(_mistake_along_axes(axes) for axes in ([1, 2], [0, 2], [0], [1], [2])),
    )


def _mistake_along_axes(axes: list[int]) -> Mistake:
    """Return the mistake of measuring distances along some of the axes only.

    Parameters
    ----------
    axes : list of int
        Indices of the axes.
    """
    names = " and ".join("xyz"[axis] for axis in axes)
    return Mistake(
        f"Distances are measured only along {names}.",
        prediction_with_measure(lambda steps, limit: lengths(steps[:, axes]) / limit),
        "Use all three coordinates, x, y and z: cloud[:, :3].",
    )


def label_mistakes() -> tuple[Mistake, ...]:
    """Return the mistakes about labels that both clustering lessons share."""
    return (
        Mistake(
            "The clusters are right, but their labels start from 0.",
            lambda right, *case: right - 1,
            "Add 1 to all labels, or increase the counter before the first cluster.",
        ),
        Mistake(
            "Every point has a different label: no points are joined.",
            lambda right, *case: np.arange(len(right)) + 1,
            "Compute one distance for each point (axis=1), and give the label to the points that "
            "are closer than the threshold.",
            is_cheap=True,
        ),
        Mistake(
            "All points have the same label, however far apart they are.",
            lambda right, *case: np.ones(len(right), dtype=int),
            is_cheap=True,
        ),
        Mistake(
            "The function returns one number for each cluster instead of one label for each point.",
            lambda right, *case: np.unique(right),
            "Return one label for each point, in the order of the points.",
        ),
    )


def line_cases() -> tuple[tuple[np.ndarray, float], ...]:
    """Return cases (cloud, threshold) in which each wrong measure splits at different gaps."""
    rng = np.random.default_rng(9)
    found = []
    cases = (
        ([0.3, 0.42, 0.55, 0.7, 0.85, 1.2, 0.31, 0.41, 0.2, 3.0, 0.54], 0.6, 0.0),
        ([1.0, 1.3, 1.5, 1.8, 2.4, 2.8, 0.3, 3.5, 7.0, 0.9, 1.7], 2.0, 0.75),
        ([0.33, 0.44, 0.53, 0.58, 1.1, 0.1, 0.4, 0.7, 0.2, 0.84, 0.55], 0.6, 2.5),
    )
    for (gaps, threshold, brightness), direction in zip(cases, _DIRECTIONS, strict=True):
        places = rng.permutation(1 + np.cumsum([0, *gaps, *(threshold * _TOO_WIDE)]))
        found.append((points_on_line(places, brightness, direction), threshold))
    return frozen_cases(found)


def frozen_cases(cases: list[tuple[np.ndarray, float]]) -> tuple[tuple[np.ndarray, float], ...]:
    """Return the cases with read-only clouds."""
    return tuple((frozen(cloud), threshold) for cloud, threshold in cases)
