"""Assertions about a search: the points that it finds and the regions that it skips."""

import copy
import math
from collections.abc import Callable, Sequence

import numpy as np

import utils
from utils.checks.assertions import CheckFailed, WrongForm, as_array, brief_text
from utils.checks.lesson_04.trees import assert_indices, assert_tree, build_tree_with, exact_text
from utils.geometry import TreeNode, tree_as_lists


def as_indices(answer: object) -> list[int]:
    """Convert the answer of a search to a sorted list of whole numbers."""
    array = as_array(
        list(answer) if isinstance(answer, set) else answer, description="a list of indices"
    )
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise WrongForm(
            "search must return the indices of the points it finds, in one flat list.",
            yours=brief_text(answer),
            expected="whole numbers, such as [0, 3]",
        )
    return sorted(array.tolist())


def assert_found(
    tree: object, root: TreeNode | None, target: Sequence[float], tolerance: float
) -> None:
    """Assert that a search finds exactly the points of a correct tree within the tolerance.

    Parameters
    ----------
    tree : object
        Instance of the student's class, with the nodes of the correct tree.
    root : node or None
        The correct tree.
    target : sequence of float
    tolerance : float
    """
    points, _, _, indices = tree_as_lists(root)
    points_by_index = dict(zip(indices, points, strict=True))
    expected = {
        index for index in points_by_index if math.dist(points_by_index[index], target) <= tolerance
    }
    yours = set(as_indices(tree.search(copy.copy(target), tolerance)))
    if yours == expected:
        return
    missing, extra = sorted(expected - yours), sorted(yours - expected)
    unknown = [index for index in extra if index not in points_by_index]
    parts = []
    if missing:
        parts.append(f"Not found: {_describe_first_point(missing, points_by_index, target)}")
    if unknown:
        parts.append(f"Found: index {unknown[0]}, which is not in the tree")
    elif extra:
        parts.append(
            f"Found, but farther away than {tolerance:g} m: "
            f"{_describe_first_point(extra, points_by_index, target)}"
        )
    raise CheckFailed(
        f"{'. '.join(parts)}.",
        input_text=f"target {exact_text(target)}, tolerance {tolerance:g} m",
        yours=_indices_text(yours),
        expected=_indices_text(expected),
        draw=_make_search_drawing(
            root, target, tolerance, yours & set(points_by_index), "Points that your search found"
        ),
    )


def _describe_first_point(
    indices: list[int], points: dict[int, list[float]], target: Sequence[float]
) -> str:
    index = indices[0]
    text = f"{len(indices)} points, for example point " if len(indices) > 1 else "point "
    return (
        f"{text}{index} at {exact_text(points[index])}, "
        f"{math.dist(points[index], target):.3g} m from the target"
    )


def _indices_text(found: set[int]) -> str:
    return f"{sorted(found)}" if len(found) <= 8 else f"{len(found)} indices"


def _make_search_drawing(
    root: TreeNode | None, target: Sequence[float], tolerance: float, found: set[int], title: str
) -> Callable | None:
    """Return a function that draws a search; None for an empty tree or points in space."""
    if root is None or len(target) != 2:
        return None
    points, _, _, indices = tree_as_lists(root)
    rows = {index: row for row, index in enumerate(sorted(indices))}
    box = [np.subtract(target, tolerance), np.add(target, tolerance)]
    corners = np.vstack([*points, *box])
    margin = 0.08 * np.ptp(corners, axis=0).max()
    limits = np.column_stack([corners.min(axis=0) - margin, corners.max(axis=0) + margin])
    return lambda: utils.plots.kd_search(
        np.array(points)[np.argsort(indices)],
        root,
        target,
        tolerance,
        found=[rows[index] for index in found],
        title=title,
        limits=limits,
    )


def assert_pruned(
    KdTree: Callable,
    root: TreeNode,
    target: Sequence[float],
    tolerance: float,
    trap: int,
    decoy: int,
    place: Sequence[float],
) -> None:
    """Assert that a search follows the splits and skips a region that cannot contain a neighbour.

    Two leaves are moved to places where they would not be in a correct tree. Other points that the
    search finds are ignored.

    Parameters
    ----------
    KdTree : callable
    root : node
        A correct tree.
    target : sequence of float
    tolerance : float
    trap : int
        Index of a leaf in a region farther away than the tolerance. It is moved to the target, so
        that only a search that enters the region finds it.
    decoy : int
        Index of the leaf in whose region the target is. Every search that follows the splits finds
        it. A search that visits every node but ignores misplaced ones does not find it.
    place : sequence of float
        New place of the decoy, within the tolerance and beyond a split.
    """
    _, left, right, indices = tree_as_lists(root)
    rows = indices.index(trap), indices.index(decoy)
    assert all(left[row] == right[row] == -1 for row in rows)
    assert math.dist(place, target) < tolerance
    tree = build_tree_with(KdTree, root, {trap: target, decoy: place})
    answer = as_indices(tree.search(copy.copy(target), tolerance))
    if trap in answer:
        raise CheckFailed(
            "search visited a region in which every point is farther away than the tolerance.",
            input_text=f"target {exact_text(target)}, tolerance {tolerance:g} m",
            yours=f"visits node {trap}",
            expected="skips the whole region of this node",
            draw=_make_search_drawing(
                root, target, tolerance, {trap}, f"Node {trap} is beyond the box"
            ),
        )
    if decoy not in answer:
        raise CheckFailed(
            "search skipped a node that is on the target's own side of every split.",
            hint="Use only the splits to choose nodes, and only the distance to choose points.",
        )


def assert_same_tree(tree: object, points: np.ndarray, indices: list[int]) -> None:
    """Assert that a search did not change a tree.

    Parameters
    ----------
    tree : object
        Instance of the student's class.
    points, indices
        As for `grow_tree`.
    """
    try:
        assert_tree(tree, points, indices)
        assert_indices(tree, points, indices)
    except CheckFailed as error:
        raise CheckFailed(f"The search changed the tree. {error.marked}", draw=error.draw) from None
