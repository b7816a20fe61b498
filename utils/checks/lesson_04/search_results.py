"""What a search must find, and what it must leave alone."""

import copy
import math
from collections.abc import Callable, Sequence

import numpy as np

import utils
from utils.checks.assertions import CheckFailed, WrongForm, as_array, brief
from utils.checks.lesson_04.trees import assert_indices, assert_tree, exact_text, planted_with
from utils.geometry import Node, table_of


def as_indices(answer: object) -> list[int]:
    """What a search returned as a sorted list of whole numbers."""
    array = as_array(list(answer) if isinstance(answer, set) else answer, what="a list of indices")
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise WrongForm(
            "search returns the indices of the points it found, in one flat list.",
            yours=brief(answer),
            expected="whole numbers, such as [0, 3]",
        )
    return sorted(array.tolist())


def assert_found(
    tree: object, root: Node | None, target: Sequence[float], tolerance: float
) -> None:
    """A search finds exactly the points of a right tree that lie within the tolerance.

    Parameters
    ----------
    tree : object
        Of the student's class, with the nodes of the right tree.
    root : node or None
        The right tree.
    target : sequence of float
    tolerance : float
    """
    points, _, _, indices = table_of(root)
    where = dict(zip(indices, points, strict=True))
    expected = {index for index in where if math.dist(where[index], target) <= tolerance}
    yours = set(as_indices(tree.search(copy.copy(target), tolerance)))
    if yours == expected:
        return
    missing, extra = sorted(expected - yours), sorted(yours - expected)
    unknown = [index for index in extra if index not in where]
    parts = []
    if missing:
        parts.append(f"Not found: {_first(missing, where, target)}")
    if unknown:
        parts.append(f"Found: index {unknown[0]}, which the tree does not hold")
    elif extra:
        parts.append(f"Found, but farther than {tolerance:g}: {_first(extra, where, target)}")
    raise CheckFailed(
        f"{'. '.join(parts)}.",
        given=f"target {exact_text(target)}, tolerance {tolerance:g}",
        yours=_indices(yours),
        expected=_indices(expected),
        draw=_drawn(root, target, tolerance, yours & set(where), "What your search found"),
    )


def _first(indices: list[int], where: dict[int, list[float]], target: Sequence[float]) -> str:
    one = indices[0]
    text = f"{len(indices)} points, for example point " if len(indices) > 1 else "point "
    return f"{text}{one} at {exact_text(where[one])}, {math.dist(where[one], target):.3g} away"


def _indices(found: set[int]) -> str:
    return f"{sorted(found)}" if len(found) <= 8 else f"{len(found)} indices"


def _drawn(
    root: Node | None, target: Sequence[float], tolerance: float, found: set[int], title: str
) -> Callable | None:
    """Draw a search in the plane; in space and without points there is nothing to draw."""
    if root is None or len(target) != 2:
        return None
    points, _, _, indices = table_of(root)
    rows = {index: row for row, index in enumerate(sorted(indices))}
    reach = [np.subtract(target, tolerance), np.add(target, tolerance)]
    corners = np.vstack([*points, *reach])
    pad = 0.08 * np.ptp(corners, axis=0).max()
    limits = np.column_stack([corners.min(axis=0) - pad, corners.max(axis=0) + pad])
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
    root: Node,
    target: Sequence[float],
    tolerance: float,
    trap: int,
    decoy: int,
    place: Sequence[float],
) -> None:
    """A search leaves a region alone that cannot hold a neighbour, and follows the splits.

    Two leaves are moved to where no right tree has them. What else is found is not looked at.

    Parameters
    ----------
    KdTree : callable
    root : node
        A right tree.
    target : sequence of float
    tolerance : float
    trap : int
        Index of a leaf in a region beyond the tolerance. It is moved to the target: only a search
        that looks into the region finds it.
    decoy : int
        Index of the leaf in whose region the target lies. Every search that goes by the splits
        comes to it; whoever sorts out nodes in wrong places, to compare with the others, does not.
    place : sequence of float
        Where it is moved: within the tolerance, and beyond a split.
    """
    _, left, right, indices = table_of(root)
    rows = indices.index(trap), indices.index(decoy)
    assert all(left[row] == right[row] == -1 for row in rows)
    assert math.dist(place, target) < tolerance
    tree = planted_with(KdTree, root, {trap: target, decoy: place})
    answer = as_indices(tree.search(copy.copy(target), tolerance))
    if trap in answer:
        raise CheckFailed(
            "search looked into a region that lies entirely beyond the tolerance.",
            given=f"target {exact_text(target)}, tolerance {tolerance:g}",
            yours=f"asks node {trap}",
            expected="leaves its whole region out",
            draw=_drawn(root, target, tolerance, {trap}, f"Node {trap} is beyond the box"),
        )
    if decoy not in answer:
        raise CheckFailed(
            "A node was left out that a search meets when it goes by the splits, on the target's "
            "own side of each.",
            hint="The splits alone decide where to go: no other test may leave nodes out.",
        )


def assert_same_tree(tree: object, points: np.ndarray, indices: list[int]) -> None:
    """A search left a tree as it was.

    Parameters
    ----------
    tree : object
    points, indices
        As for `grown`.
    """
    try:
        assert_tree(tree, points, indices)
        assert_indices(tree, points, indices)
    except CheckFailed as error:
        raise CheckFailed(
            f"The tree is another one after the search. {error.marked}", draw=error.draw
        ) from None
