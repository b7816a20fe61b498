"""Points and correct trees for the checks of lesson 04."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from utils.checks.assertions import frozen
from utils.geometry import TreeNode, grow_tree

ELEVEN_POINTS = frozen(
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
# Inserted in this order, the eleven points make a balanced tree.
BALANCED_ORDER = (7, 0, 3, 9, 1, 2, 5, 8, 10, 4, 6)


def balanced_tree() -> TreeNode:
    """Return a balanced tree of the eleven points, four levels deep."""
    return grow_tree(ELEVEN_POINTS[list(BALANCED_ORDER)], BALANCED_ORDER)


def chain_tree(count: int) -> TreeNode:
    """Return the tree of points inserted in sorted order, in which no node has a left child."""
    root = last = TreeNode([0.0, 0.0], 0)
    for row in range(1, count):
        last.right = last = TreeNode([float(row), float(row)], row)
    return root


def distinct_points(rng: np.random.Generator, n: int, k: int) -> np.ndarray:
    """Return points in random order, no two of which share a coordinate.

    Returns
    -------
    numpy.ndarray, shape (n, k)
    """
    return (np.stack([rng.permutation(4 * n)[:n] for _ in range(k)], axis=1) - 2 * n) / 16 + 0.01


def diagonal_points(values: ArrayLike, k: int = 2) -> np.ndarray:
    """Return points on the diagonal, whose tree is the same for any order of the axes.

    Parameters
    ----------
    values : array_like, shape (n,)
    k : {2, 3}

    Returns
    -------
    numpy.ndarray, shape (n, k)
    """
    return np.repeat(np.array(values, dtype=float)[:, None], k, axis=1)


def nested_points(
    rng: np.random.Generator,
    sizes: Sequence[float],
    k: int,
    allowed: Callable[[np.ndarray], bool],
    lowest: float = -1.5,
) -> np.ndarray:
    """Return points whose splits come closer to the origin with every point.

    Inserted in this order, they make a tree without branches, because the origin and all later
    points are to the left of each point. Even a search around the origin that follows only one
    side finds them all.

    Parameters
    ----------
    rng : numpy.random.Generator
    sizes : sequence of float
        Distances of the splits from the origin, in descending order.
    k : {2, 3}
        Number of coordinates.
    allowed : callable
        Takes a point, shape (k,); returns whether it may be used.
    lowest : float
        Smallest coordinate of a point, as a multiple of its entry in `sizes`.

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


def is_off_corners(points: np.ndarray) -> np.ndarray:
    """Return a mask of points clearly inside the unit circle or outside the square around it."""
    distances = np.linalg.norm(points, axis=-1)
    return (distances < 0.99) | (np.abs(points).max(axis=-1) > 1.01)


def is_off_circle(point: np.ndarray) -> bool:
    """Return whether a point is clearly off the unit circle and the sides of its square."""
    return abs(np.linalg.norm(point) - 1) > 0.02 and abs(np.abs(point).max() - 1) > 0.01
