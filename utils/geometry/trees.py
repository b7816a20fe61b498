"""Kd-trees as they should be: grown from points, walked, and the regions they cut."""

import operator
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

SIDES = {"l": "left", "r": "right"}


class TreeNode:
    """A node of a right tree; `arrival` is its place in the order in which points came."""

    def __init__(self, point: list[float], index: int, arrival: int = 0) -> None:
        self.point, self.index, self.arrival = point, index, arrival
        self.left = self.right = None


def in_turn(depth: int, dimensions: int) -> int:
    """The axis that is compared at a depth: each in its turn, x at the root."""
    return depth % dimensions


def grown(
    points: ArrayLike,
    indices: Sequence[int] | None = None,
    axis_at: Callable[[int, int], int] = in_turn,
    goes_left: Callable[[float, float], bool] = operator.lt,
) -> TreeNode | None:
    """The tree of points that arrive one after another; None without points.

    The first of them is the root and parts the others in two, which arrive on either side.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3)
    indices : sequence of int, optional
        By default 0, 1, 2, ...
    axis_at : callable, optional
        Takes the depth and the number of dimensions; returns the axis that is compared.
    goes_left : callable, optional
        Takes a coordinate of a point and that of the node where it is.

    Returns
    -------
    node or None
        With `point`, `index`, `left` and `right`.
    """
    points, rows = np.asarray(points).tolist(), range(len(points))
    nodes = [TreeNode(*one) for one in zip(points, indices or rows, rows, strict=True)]
    waiting = [(nodes, 0)] if nodes else []
    for (top, *others), depth in waiting:  # grows while it is walked
        axis = axis_at(depth, len(top.point))
        sides = {"left": [], "right": []}
        for one in others:
            smaller = goes_left(one.point[axis], top.point[axis])
            sides["left" if smaller else "right"].append(one)
        for name, part in sides.items():
            if part:
                setattr(top, name, part[0])
                waiting.append((part, depth + 1))
    return nodes[0] if nodes else None


def places_of(root: TreeNode | None) -> dict[str, TreeNode]:
    """The nodes of a tree by the way to them: "" is the root, "lr" to its left and then right.

    Returns
    -------
    dict of str to node
        Level by level.
    """
    waiting = [("", root)] if root is not None else []
    for way, node in waiting:  # grows while it is walked
        for letter, name in SIDES.items():
            if getattr(node, name) is not None:
                waiting.append((way + letter, getattr(node, name)))
    return dict(waiting)


def table_of(root: TreeNode | None) -> tuple[list, list, list, list]:
    """The rows of a tree as `KdTree.plant` takes them.

    Returns
    -------
    points : list of list of float
    left, right : list of int
        Rows of the children; -1 where there is none.
    indices : list of int
    """
    nodes = list(places_of(root).values())
    rows = {id(node): row for row, node in enumerate(nodes)}
    rows[id(None)] = -1
    return (
        [node.point for node in nodes],
        [rows[id(node.left)] for node in nodes],
        [rows[id(node.right)] for node in nodes],
        [node.index for node in nodes],
    )


def regions_of(root: TreeNode) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """The region that each node of a right tree falls into.

    Returns
    -------
    dict of int to tuple of numpy.ndarray
        By index: its lowest and its highest corner, both (k,), in part infinite.
    """
    places = places_of(root)
    regions = {}
    for way, node in places.items():
        low, high = np.full((2, len(node.point)), [[-np.inf], [np.inf]])
        for depth, letter in enumerate(way):
            axis, split = depth % len(low), places[way[:depth]].point[depth % len(low)]
            if letter == "l":
                high[axis] = min(high[axis], split)
            else:
                low[axis] = max(low[axis], split)
        regions[node.index] = (low, high)
    return regions
