"""Which nodes of a kd-tree somebody looks at: ``with watched(tree) as visited: ...``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class Node(Protocol):
    """A node of a kd-tree, whoever wrote its class."""

    point: ArrayLike
    index: int
    left: Node | None
    right: Node | None


class Tree(Protocol):
    """A kd-tree, whoever wrote its class."""

    root: Node | None


@contextmanager
def watched(tree: Tree) -> Iterator[list[int]]:
    """Note the index of each node whose point is read, once per node and in order.

    Parameters
    ----------
    tree : object
        With `root`: a node or None. Nodes have `point`, `index`, `left` and `right`, and are
        objects of a class written in Python.

    Yields
    ------
    list of int
        Fills up as nodes are looked at.
    """
    visited, seen, kinds = [], set(), {}

    def read(node: Node) -> ArrayLike:
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
    """All nodes of a tree, parents first, without recursion: bad trees are deep."""
    nodes = [root] if root is not None else []
    for node in nodes:  # grows while it is walked
        nodes += [child for child in (node.left, node.right) if child is not None]
    return nodes


def depth_of(root: Node | None) -> int:
    """Number of levels of a tree; 0 without a root."""
    level, depth = [root] if root is not None else [], 0
    while level:
        level = [child for node in level for child in (node.left, node.right) if child is not None]
        depth += 1
    return depth
