"""Replay of lesson 04: a search in a kd-tree, node by node."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from utils.replays.player import Fault, Replay, ReplayStep, earliest_fault
from utils.visits import describe_step, nodes_of

if TYPE_CHECKING:
    from utils.visits import Node

WINDOW = ((-10, 10), (-10, 10))


def walk(
    root: Node | None,
    target: ArrayLike,
    tolerance: float,
    visited: Sequence[int],
    found: Sequence[int],
) -> Replay:
    """Return the replay of a search.

    Parameters
    ----------
    root : node or None
        Root of a tree of points in the plane, with indices from 0 up.
    target : (2,) array_like of float
        Centre of the search.
    tolerance : float
        Radius of the search, in metres.
    visited : sequence of int
        Indices of the nodes that the search visited, in order; see `utils.visits.watched`.
    found : sequence of int
        Indices that the search returned.

    Returns
    -------
    Replay
        If the tree itself is wrong, only the remark says so, and no step is marked as wrong.
    """
    nodes = {node.index: node for node in nodes_of(root)}
    if not nodes or not set(visited) <= set(nodes):
        return Replay(
            remark="The tree is empty or was changed by a search, so there is no search to show."
        )
    points = np.array([nodes[index].point for index in sorted(nodes)], dtype=float)
    rows = [int(row) for row in found if isinstance(row, int | np.integer) and row in nodes]
    remark = (
        ""
        if len(rows) == len(found)
        else "Your search returns a value that is not an index in the tree."
    )

    def step(number: int) -> ReplayStep:
        says = describe_step(root, visited, number, target, tolerance)
        says = f"{says[0].upper()}{says[1:]}".removesuffix(".") + "."
        return ReplayStep(says, lambda title: draw(number, title))

    def draw(number: int, title: str) -> None:
        import matplotlib.pyplot as plt

        from utils import plots

        _, (plane, diagram) = plt.subplots(1, 2, figsize=(8.5, 5), layout="compressed")
        shown = {"found": rows, "steps": number}
        plots.kd_search(points, root, target, tolerance, visited, limits=WINDOW, axes=plane,
                        title=title, **shown)  # fmt: skip
        plots.kd_tree(root, visited=visited, axes=diagram, title="in the tree", **shown)

    wrong = None
    if misplaced := next(_misplaced(root), None):
        remark = f"The tree itself is wrong, so fix insert first: {misplaced}."
    elif not remark:
        wrong = _first_mistake(root, target, tolerance, list(visited), rows)
    return Replay([step(number) for number in range(len(visited) + 1)], wrong, remark)


def _nodes_with_parents(root: Node | None) -> Iterator[tuple[Node, Node | None, str, int]]:
    """Yield each node with its parent, its side of the parent, "left" or "right", and its depth."""
    waiting, seen = [(root, None, "", 0)] if root is not None else [], set()
    for node, parent, side, depth in waiting:  # the list grows during the loop
        if id(node) in seen:  # a wrong tree may have loops
            continue
        seen.add(id(node))
        yield node, parent, side, depth
        for name in ("left", "right"):
            if (child := getattr(node, name)) is not None:
                waiting.append((child, node, name, depth + 1))


def _misplaced(root: Node | None) -> Iterator[str]:
    """Yield a sentence for each node that is on the wrong side of a node above it."""
    for node, _, _, depth in _nodes_with_parents(root):
        axis = depth % len(node.point)
        for side in ("left", "right"):
            for below in nodes_of(getattr(node, side)):
                if (below.point[axis] < node.point[axis]) != (side == "left"):
                    yield f"point {below.index} is to the {side} of point {node.index}"


def _first_mistake(
    root: Node, target: ArrayLike, tolerance: float, visited: list[int], found: list[int]
) -> Fault | None:
    """Return the first step that is wrong.

    Step 0 is before the search, and each later step visits one node.
    """
    step_of = {index: step for step, index in enumerate(visited, start=1)}
    above = {id(node): (parent, side) for node, parent, side, _ in _nodes_with_parents(root)}
    faults = []
    for node, parent, side, depth in _nodes_with_parents(root):
        index, away = node.index, math.dist(node.point, target)
        is_near, times = away <= tolerance, found.count(index)
        far = f"node {index} is {away:.1f} m away, with a tolerance of {tolerance:g} m"
        if is_near and not times and index not in step_of:
            while parent is not None and parent.index not in step_of:
                parent, side = above[id(parent)]
            where = "any node" if parent is None else f"the {side} branch of node {parent.index}"
            step = 0 if parent is None else step_of[parent.index]
            faults.append(Fault(step, f"The search never visits {where}, although {far}."))
        elif is_near != bool(times) and index in step_of:
            does = "contains it" if times else "does not contain it"
            faults.append(Fault(step_of[index], f"{far.capitalize()}. Your answer {does}."))
        elif times > 1:
            faults.append(Fault(step_of[index], f"Node {index} is in your answer {times} times."))
        elif index in step_of and parent is not None and _visits_child(node, step_of):
            axis = (depth - 1) % len(target)
            low, high, cut = target[axis] - tolerance, target[axis] + tolerance, parent.point[axis]
            if cut <= low if side == "left" else high < cut:
                why = f"The box reaches from {low:g} to {high:g} along {'xyz'[axis]}, and node "
                why += (
                    f"{parent.index} cuts at {cut:g}. Nothing to its {side} can be near, but the "
                )
                faults.append(Fault(step_of[index], f"{why}search continues there."))
    return earliest_fault(faults)


def _visits_child(node: Node, step_of: dict[int, int]) -> bool:
    """Return whether a search visited a child of a node; visiting only the node is harmless."""
    return any(child is not None and child.index in step_of for child in (node.left, node.right))
