"""Observe which nodes of a kd-tree a search visits, and which it prunes.

>>> with watched(tree) as visited:
...     tree.search(target, 0.5)
>>> node_states(tree.root, visited)
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class Node(Protocol):
    """A node of a kd-tree, of any class with these attributes."""

    point: ArrayLike
    index: int
    left: Node | None
    right: Node | None


class Tree(Protocol):
    """A kd-tree, of any class with a root."""

    root: Node | None


@contextmanager
def watched(tree: Tree) -> Iterator[list[int]]:
    """Record the index of each node whose point is read, once per node and in order.

    Parameters
    ----------
    tree : object
        An object with `root`: a node or None. Nodes have `point`, `index`, `left` and `right`, and
        their class is written in Python.

    Yields
    ------
    list of int
        A list that grows as nodes are visited. Clear it between two searches.
    """
    visited, seen, kinds = [], set(), {}

    def read(node: Node) -> ArrayLike:
        if not visited:
            seen.clear()
        if id(node) not in seen:
            seen.add(id(node))
            visited.append(node.index)
        return vars(node)["point"]

    nodes = nodes_of(tree.root)
    for node in nodes:
        kind = type(node)
        if kind not in kinds:
            kinds[kind] = type(kind.__name__, (kind,), {"point": property(read)})
        node.__class__ = kinds[kind]
    try:
        yield visited
    finally:
        for node in nodes:
            node.__class__ = type(node).__base__


def nodes_of(root: Node | None) -> list[Node]:
    """Return all nodes of a tree, parents first, each once even if a wrong tree has loops."""
    nodes = [root] if root is not None else []
    seen = set(map(id, nodes))
    for node in nodes:  # the list grows during the loop
        for child in (node.left, node.right):
            if child is not None and id(child) not in seen:
                seen.add(id(child))
                nodes.append(child)
    return nodes


def depth_of(root: Node | None) -> int:
    """Return the number of levels of a tree; 0 without a root."""
    depths = {id(root): 1} if root is not None else {}
    for node in nodes_of(root):
        for child in (node.left, node.right):
            if child is not None:
                depths.setdefault(id(child), depths[id(node)] + 1)
    return max(depths.values(), default=0)


def place_of(root: Node | None, index: int) -> str:
    """Describe the place of a node in a tree.

    Parameters
    ----------
    root : node or None
    index : int
        Index of the node to find.

    Returns
    -------
    str
        Such as "left of 5", "the root" or "not in the tree".
    """
    if root is not None and root.index == index:
        return "the root"
    for node in nodes_of(root):
        for side in ("left", "right"):
            child = getattr(node, side)
            if child is not None and child.index == index:
                return f"{side} of {node.index}"
    return "not in the tree"


VISITED, PRUNED, NOT_YET = "looked at", "pruned", "not yet"


def node_states(
    root: Node | None, visited: Sequence[int], steps: int | None = None
) -> dict[int, str]:
    """Return the state of each node after some steps of a search.

    A branch counts as pruned once its parent has been visited, if the search visits no node in it.

    Parameters
    ----------
    root : node or None
    visited : sequence of int
        Indices of all nodes that the whole search visited, in order, recorded by `watched`.
    steps : int, optional
        Number of nodes visited so far; by default all.

    Returns
    -------
    dict of int to str
        By the `id` of the node object: "looked at", "pruned" or "not yet".
    """
    visited = list(visited)
    now, ever = set(visited[:steps]), set(visited)
    nodes = nodes_of(root)
    in_branch = {}
    # Parents come before their children, so in reverse order each child comes before its parent.
    for node in reversed(nodes):
        branches = [in_branch.get(id(child), set()) for child in (node.left, node.right)]
        kinds = {kind for kind, which in (("now", now), ("ever", ever)) if node.index in which}
        in_branch[id(node)] = kinds.union(*branches)
    found = {}
    parents = {id(child): node for node in nodes for child in (node.left, node.right)}
    for node in nodes:
        above = found.get(id(parents.get(id(node))), VISITED)
        kinds = in_branch[id(node)]
        if "now" in kinds:
            found[id(node)] = VISITED
        elif above != VISITED:
            found[id(node)] = above
        else:
            found[id(node)] = NOT_YET if "ever" in kinds else PRUNED
    return found


def describe_step(
    root: Node | None, visited: Sequence[int], step: int, target: ArrayLike, tolerance: float
) -> str:
    """Describe one step of a search in a sentence: the node, its cut, branches and distance.

    Parameters
    ----------
    root : node or None
    visited : sequence of int
        As for `node_states`, for the whole search.
    step : int
        Counted from 1; 0 is before the search.
    target : (k,) array_like of float
    tolerance : float
    """
    if not 0 < step <= len(visited):
        return "Before the search, only the root is waiting."
    node = next(node for node in nodes_of(root) if node.index == visited[step - 1])
    states = node_states(root, visited)
    axis = _depth_in(root, node) % len(target)
    branches = [
        f"{side} {'no node' if child is None else states[id(child)].replace(VISITED, 'searched')}"
        for side, child in (("left", node.left), ("right", node.right))
    ]
    distance = math.dist(node.point, target)
    return (
        f"node {node.index} cuts {'xyz'[axis]} at {node.point[axis]:g}, and the box reaches from "
        f"{target[axis] - tolerance:g} to {target[axis] + tolerance:g}: {', '.join(branches)}; "
        f"{distance:.1f} m away: {'near' if distance <= tolerance else 'far'}"
    )


def _depth_in(root: Node | None, node: Node) -> int:
    level, depth, seen = [root], 0, set()
    while level and all(other is not node for other in level):
        seen.update(map(id, level))
        below = [child for other in level for child in (other.left, other.right)]
        level = [child for child in below if child is not None and id(child) not in seen]
        depth += 1
    return depth
