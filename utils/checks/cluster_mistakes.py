"""Common mistakes of clustering, predicted for points on a straight line.

On a line, a cluster ends at each gap that is too wide. The effect of a mistake is therefore a
formula about neighbours.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from utils.checks.assertions import CheckFailed, as_array, frozen, overlaps
from utils.checks.clusters import in_order
from utils.checks.diagnosis import Mistake

# On such a line, a distance in the plane or along one axis differs from the distance in space, and
# from line to line the axes change places.
_WAYS = frozen(np.array([[2.0, 3.0, 6.0], [6.0, 2.0, 3.0], [3.0, 6.0, 2.0]]) / 7)


# Gaps in thresholds. Along a line of _WAYS, each measure by one axis or two closes other ones.
_TOO_WIDE = frozen(np.array([1.02, 1.075, 1.13, 1.5, 2.1, 2.9]))


def same_clusters(answer: object, predicted: np.ndarray) -> bool:
    """Return whether an answer groups points as predicted, with the same set of labels."""
    try:
        yours = as_array(answer)
    except CheckFailed:
        return False
    if yours.shape != predicted.shape or yours.ndim != 1:
        return False
    shared, number, _ = overlaps(yours, predicted)
    return shared == number and np.array_equal(np.unique(yours), np.unique(predicted))


def on_a_line(
    places: Sequence[float], brightness: float = 0.0, way: ArrayLike = _WAYS[0]
) -> np.ndarray:
    """Return points on a straight line through the sensor.

    Parameters
    ----------
    places : sequence of float, length n
        Positions along the line in metres; negative behind the sensor.
    brightness : float
        Intensity per metre; 0 for a cloud without intensities.
    way : array_like, shape (3,)
        Direction of the line: a unit vector without negative components.

    Returns
    -------
    numpy.ndarray, shape (n, 3) or (n, 4)
    """
    cloud = np.outer(places, way)
    return np.column_stack([cloud, brightness * np.array(places)]) if brightness else cloud


def parted(cloud: np.ndarray, holds: Callable) -> np.ndarray:
    """Label points on a line, with a new cluster wherever two neighbours are not joined.

    Parameters
    ----------
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    holds : callable
        Takes the points in their order along the line, and their rows in the cloud. Returns
        whether each point joins the next, shape (n - 1,).

    Returns
    -------
    numpy.ndarray of int, shape (n,)
    """
    order = np.argsort(cloud[:, :3].sum(axis=1))
    labels = np.empty(len(cloud), dtype=int)
    labels[order] = np.concatenate([[0], np.cumsum(~holds(cloud[order], order))])
    return in_order(labels)


def by_steps(measure: Callable) -> Callable:
    """Return the prediction of a mistake that measures gaps wrongly.

    Parameters
    ----------
    measure : callable
        Takes the vectors from each point to the next, shape (n - 1, columns), and the threshold.
        Returns the apparent length of each vector in thresholds, shape (n - 1,).

    Returns
    -------
    callable
        As `Mistake.predicts`.
    """

    def predicts(right: np.ndarray, cloud: np.ndarray, threshold: float) -> np.ndarray:
        return parted(cloud, lambda line, _: measure(np.diff(line, axis=0), threshold) < 1)

    return predicts


def length(steps: np.ndarray) -> np.ndarray:
    """Return the length of each step over all its columns; shape (n,)."""
    return np.linalg.norm(steps, axis=1)


def right_on_a_line(cloud: np.ndarray, threshold: float) -> np.ndarray:
    """Return right labels for points on a line, (n,): gaps below the threshold join points."""
    gaps = by_steps(lambda steps, limit: length(steps[:, :3]) / limit)
    return gaps(None, cloud, threshold)


def measured_wrongly() -> tuple[Mistake, ...]:
    """Return the mistakes about distances that both clustering lessons share."""
    return (
        Mistake(
            "The distance is compared with threshold ** 2: 0.5 acts as 0.25.",
            by_steps(lambda steps, limit: length(steps[:, :3]) / limit**2),
            "np.linalg.norm gives distances; these go with threshold itself.",
        ),
        Mistake(
            "The squared distance is compared with threshold itself: 0.5 acts as 0.71.",
            by_steps(lambda steps, limit: length(steps[:, :3]) ** 2 / limit),
            "Take the root first, as np.linalg.norm does.",
        ),
        Mistake(
            "A fixed threshold of 0.5 decides, whatever is given.",
            by_steps(lambda steps, limit: length(steps[:, :3]) / 0.5),
            "Compare with the parameter threshold.",
        ),
        Mistake(
            "Intensity counts as a fourth coordinate.",
            by_steps(lambda steps, limit: length(steps) / limit),
            "cloud[:, :3] are the coordinates.",
        ),
        Mistake(
            "The height is left out: distances are measured in x and y alone.",
            by_steps(lambda steps, limit: length(steps[:, :2]) / limit),
            "cloud[:, :3] are the coordinates, z among them.",
        ),
        *(_measured_along(kept) for kept in ([1, 2], [0, 2], [0], [1], [2])),
    )


def _measured_along(kept: list[int]) -> Mistake:
    """Return the mistake of measuring distances along some of the axes alone.

    Parameters
    ----------
    kept : list of int
        Numbers of the axes.
    """
    names = " and ".join("xyz"[axis] for axis in kept)
    return Mistake(
        f"Distances are measured along {names} alone.",
        by_steps(lambda steps, limit: length(steps[:, kept]) / limit),
        "cloud[:, :3] are the coordinates: x, y and z.",
    )


def mixed_up() -> tuple[Mistake, ...]:
    """Return the mistakes about labels that both clustering lessons share."""
    return (
        Mistake(
            "The clusters are right, and their labels start from 0.",
            lambda right, *case: right - 1,
            "Labels start from 1: add 1 to all, or count up before the first cluster.",
        ),
        Mistake(
            "Every point has a label of its own: nobody joins anybody.",
            lambda right, *case: np.arange(len(right)) + 1,
            "Look at the distances: is there one for each point (axis=1), and do those below the "
            "threshold get the label?",
            is_cheap=True,
        ),
        Mistake(
            "All points have the same label, however far apart.",
            lambda right, *case: np.ones(len(right), dtype=int),
            is_cheap=True,
        ),
        Mistake(
            "What is returned has one number for each cluster.",
            lambda right, *case: np.unique(right),
            "There must be one label for each point, in the order of the points.",
        ),
    )


def lines_of_points() -> tuple[tuple[np.ndarray, float], ...]:
    """Return cases (cloud, threshold) in which each wrong measure splits at different gaps."""
    rng = np.random.default_rng(9)
    found = []
    cases = (
        ([0.3, 0.42, 0.55, 0.7, 0.85, 1.2, 0.31, 0.41, 0.2, 3.0, 0.54], 0.6, 0.0),
        ([1.0, 1.3, 1.5, 1.8, 2.4, 2.8, 0.3, 3.5, 7.0, 0.9, 1.7], 2.0, 0.75),
        ([0.33, 0.44, 0.53, 0.58, 1.1, 0.1, 0.4, 0.7, 0.2, 0.84, 0.55], 0.6, 2.5),
    )
    for (gaps, threshold, brightness), way in zip(cases, _WAYS, strict=True):
        places = rng.permutation(1 + np.cumsum([0, *gaps, *(threshold * _TOO_WIDE)]))
        found.append((on_a_line(places, brightness, way), threshold))
    return frozen_cases(found)


def frozen_cases(cases: list[tuple[np.ndarray, float]]) -> tuple[tuple[np.ndarray, float], ...]:
    """Return the cases with read-only clouds."""
    return tuple((frozen(cloud), threshold) for cloud, threshold in cases)
