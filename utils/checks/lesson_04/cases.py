"""Points and right trees that the checks of this lesson ask about."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from utils.checks.assertions import frozen
from utils.geometry import Node, grown

# The eleven points of the lesson.
QUIZ = frozen(
    np.array(
        [
            [-6.2, 7.0],
            [-6.3, 8.4],
            [-5.2, 7.1],
            [-5.7, 6.3],
            [7.2, 6.1],
            [8.0, 5.3],
            [7.2, 7.1],
            [0.2, -7.1],
            [1.7, -6.9],
            [-1.2, -7.2],
            [2.2, -8.9],
        ]
    )
)
# Inserted in this order they make a balanced tree.
BALANCED = (7, 0, 3, 9, 1, 2, 5, 8, 10, 4, 6)


def balanced() -> Node:
    """The right tree of the eleven points, four levels deep."""
    return grown(QUIZ[list(BALANCED)], BALANCED)


def chain(count: int) -> Node:
    """A tree of points that arrived in sorted order; no node has a left child."""
    root = last = Node([0.0, 0.0], 0)
    for row in range(1, count):
        last.right = last = Node([float(row), float(row)], row)
    return root


def distinct(rng: np.random.Generator, n: int, k: int) -> np.ndarray:
    """Points of which no two share a coordinate, in random order.

    Returns
    -------
    numpy.ndarray, shape (n, k)
    """
    return (np.stack([rng.permutation(4 * n)[:n] for _ in range(k)], axis=1) - 2 * n) / 16 + 0.01


def along_the_diagonal(values: ArrayLike, k: int = 2) -> np.ndarray:
    """Points with equal coordinates: whichever is compared, the tree is the same.

    Parameters
    ----------
    values : array_like, shape (n,)
    k : {2, 3}

    Returns
    -------
    numpy.ndarray, shape (n, k)
    """
    return np.repeat(np.array(values, dtype=float)[:, None], k, axis=1)


def nested(
    rng: np.random.Generator,
    sizes: Sequence[float],
    k: int,
    allowed: Callable[[np.ndarray], bool],
    lowest: float = -1.5,
) -> np.ndarray:
    """Points about the origin, in an order in which each cuts off what lies beyond it.

    Inserted so they make a tree without branches: the origin, and all who follow, lie to the left
    of each. Whoever searches around the origin on one side alone finds all.

    Parameters
    ----------
    rng : numpy.random.Generator
    sizes : sequence of float
        How far from the origin each cuts, descending.
    k : {2, 3}
    allowed : callable
        Takes a point, shape (k,): whether it may be one.
    lowest : float
        The smallest coordinate of a point, in sizes of its own.

    Returns
    -------
    numpy.ndarray, shape (len(sizes), k)
    """
    points = []
    while len(points) < len(sizes):
        size = sizes[len(points)]
        point = rng.uniform(lowest * size, size, k).round(3)
        point[len(points) % k] = round(size, 3)
        if allowed(point):
            points.append(point)
    return np.array(points)


def off_the_corners(points: np.ndarray) -> np.ndarray:
    """Clear of the unit circle's rim, and not in a corner of the square around it."""
    far = np.linalg.norm(points, axis=-1)
    return (far < 0.99) | (np.abs(points).max(axis=-1) > 1.01)


def off_the_rim(point: np.ndarray) -> bool:
    """Clear of the unit circle's rim."""
    return abs(np.linalg.norm(point) - 1) > 0.02 and abs(np.abs(point).max() - 1) > 0.01
