"""Reference kd-trees: build them from points, list their nodes, and find the nodes' regions."""

import operator
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

SIDES = {"l": "left", "r": "right"}


class TreeNode:
    """A node of a correct tree; `input_row` is the row of its point in the input."""

    def __init__(self, point: list[float], index: int, input_row: int = 0) -> None:
        self.point, self.index, self.input_row = point, index, input_row
        self.left = self.right = None


def alternating_axis(depth: int, dimensions: int) -> int:
    """Return the axis to compare at a depth: x at the root, then each axis in turn."""
    return depth % dimensions


def grow_tree(
    points: ArrayLike,
    indices: Sequence[int] | None = None,
    axis_at: Callable[[int, int], int] = alternating_axis,
    goes_left: Callable[[float, float], bool] = operator.lt,
) -> TreeNode | None:
    """Build the tree that results from inserting points one by one; return None without points.

    The first point is the root. It divides the others into those on its left and on its right,
    which keep their order.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3)
    indices : sequence of int, optional
        By default 0, 1, 2, ...
    axis_at : callable, optional
        Takes the depth and the number of dimensions; returns the axis to compare.
    goes_left : callable, optional
        Takes a coordinate of the new point and of the node; returns whether the point goes left.

    Returns
    -------
    node or None
        The root, with `point`, `index`, `left` and `right`.
    """
    points, rows = np.asarray(points).tolist(), range(len(points))
    nodes = [TreeNode(*values) for values in zip(points, indices or rows, rows, strict=True)]
    waiting = [(nodes, 0)] if nodes else []
    for (top, *others), depth in waiting:  # the list grows during the loop
        axis = axis_at(depth, len(top.point))
        sides = {"left": [], "right": []}
        for node in others:
            smaller = goes_left(node.point[axis], top.point[axis])
            sides["left" if smaller else "right"].append(node)
        for name, part in sides.items():
            if part:
                setattr(top, name, part[0])
                waiting.append((part, depth + 1))
    return nodes[0] if nodes else None


def nodes_by_path(root: TreeNode | None) -> dict[str, TreeNode]:
    """Return the nodes of a tree by their paths: "" is the root, "lr" is left and then right.

    Returns
    -------
    dict of str to node
        In level order.
    """
    waiting = [("", root)] if root is not None else []
    for path, node in waiting:  # the list grows during the loop
        for letter, name in SIDES.items():
            if getattr(node, name) is not None:
                waiting.append((path + letter, getattr(node, name)))
    return dict(waiting)


def tree_as_lists(root: TreeNode | None) -> tuple[list, list, list, list]:
    """Return a tree as lists with one entry per node, for `KdTree.plant`.

    Returns
    -------
    points : list of list of float
    left, right : list of int
        Rows of the children; -1 for a missing child.
    indices : list of int
    """
    nodes = list(nodes_by_path(root).values())
    rows = {id(node): row for row, node in enumerate(nodes)}
    rows[id(None)] = -1
    return (
        [node.point for node in nodes],
        [rows[id(node.left)] for node in nodes],
        [rows[id(node.right)] for node in nodes],
        [node.index for node in nodes],
    )


def regions_by_index(root: TreeNode) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """Return the region of space that each node of a correct tree covers.

    Returns
    -------
    dict of int to tuple of numpy.ndarray
        For each node's index: the lowest and the highest corner, both (k,) and possibly infinite.
    """
    places = nodes_by_path(root)
    regions = {}
    for path, node in places.items():
        low, high = np.full((2, len(node.point)), [[-np.inf], [np.inf]])
        for depth, letter in enumerate(path):
            axis, split = depth % len(low), places[path[:depth]].point[depth % len(low)]
            if letter == "l":
                high[axis] = min(high[axis], split)
            else:
                low[axis] = max(low[axis], split)
        regions[node.index] = (low, high)
    return regions
