"""Figures of kd-trees as tree diagrams.

A node is any object with `point`, `index`, `left` and `right`; the root may be None. A wrong tree
is drawn as it is, and a loop in it is followed only once.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from utils.plots.annotations import write
from utils.plots.style import (
    BLUE,
    GREEN,
    GRID,
    INK,
    MUTED,
    PALE,
    PAPER,
    TITLE,
    VERMILION,
    canvas,
    finish,
    key,
    note,
    number,
    styled,
)
from utils.visits import NOT_YET, PRUNED, VISITED, node_states

if TYPE_CHECKING:
    from utils.visits import Node

MAX_NAMES, MAX_POINTS = 40, 15
"""Largest number of nodes in a tree that is drawn with indices, and with coordinates."""

FOUND = "#A6DCC9"  # light enough for dark numbers

AXIS_STYLES = (("x", "o", BLUE), ("y", "s", VERMILION), ("z", "D", GREEN))


@styled
def kd_tree(
    root: Node | None,
    *,
    visited: Iterable[int] | None = None,
    found: Iterable[int] = (),
    steps: int | None = None,
    legend: bool = True,
    title: str | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw a kd-tree as a tree diagram: depth downwards, smaller coordinates to the left.

    Equal and greater coordinates are to the right.

    Parameters
    ----------
    root : node or None
        An object with `point`, `index`, `left` and `right`.
    visited, found, steps : optional
        A search, as in :func:`utils.plots.kd_search`. Visited nodes are filled, links to pruned
        branches are crossed out, and links to nodes that are not reached yet are dotted.
    legend : bool
        Show the legend above the figure.
    title : str, optional
    axes : matplotlib.axes.Axes, optional
    """
    axes = canvas(axes)
    order = _in_order(root)
    visited = None if visited is None else list(visited)
    state_of = {} if visited is None else node_states(root, visited, steps)
    positions = {id(node): (rank, depth) for rank, (node, depth) in enumerate(order)}
    deepest = max((depth for _, depth in order), default=0)
    axes.set_xlim(-1, max(len(order), 1))
    axes.set_ylim(deepest + 0.6, -0.6)
    links = {VISITED: [], PRUNED: [], NOT_YET: []}
    for node, _ in order:
        for child in (node.left, node.right):
            if child is not None:
                state = state_of.get(id(child), VISITED)
                links[state].append((positions[id(node)], positions[id(child)]))
    for state, dashes in ((VISITED, "-"), (PRUNED, "-"), (NOT_YET, ":")):
        style = {"colors": MUTED if state == VISITED else PALE, "linestyles": dashes}
        axes.add_collection(
            LineCollection(links[state], linewidths=1.2, zorder=1, **style), autolim=False
        )
    if state_of:
        branches = [(node, child) for node, _ in order for child in (node.left, node.right)]
        branches = [(node, child) for node, child in branches if state_of.get(id(child)) == PRUNED]
        middles = [
            np.mean([positions[id(node)], positions[id(child)]], axis=0)
            for node, child in branches
            if state_of[id(node)] == VISITED
        ]
        if middles:
            style = {"markersize": 9, "markeredgewidth": 2}
            axes.plot(*np.transpose(middles), "x", color=INK, zorder=3, **style)
            key(axes, "pruned", "x", size=8, markeredgewidth=2)
    visited_so_far = set() if visited is None else set(visited[:steps])
    _draw_nodes(axes, order, visited_so_far, visited_so_far & set(found))
    if not order:
        note(axes, "the tree is empty")
    axes.set_xticks([])
    axes.spines["bottom"].set_visible(False)
    axes.yaxis.get_major_locator().set_params(integer=True, min_n_ticks=1)
    finish(axes, title, None, "depth")
    if not legend and axes.get_legend():
        axes.get_legend().remove()
        axes.set_title(axes.get_title(loc="left"), loc="left", pad=7, **TITLE)
    return axes


def _draw_nodes(
    axes: Axes, order: list[tuple[Node, int]], visited: set[int], found: set[int]
) -> None:
    """Draw each node at its rank and depth, with the colour and shape of the axis that it cuts.

    `order` contains pairs (node, depth); the rank is the position in this list.
    """
    dimensions = len(np.ravel(order[0][0].point)) if order else 2
    few = len(order) <= MAX_NAMES
    size = _node_size(axes, len(order)) if few else 3
    depths = np.array([depth for _, depth in order], dtype=int)
    for axis, (name, marker, colour) in enumerate(AXIS_STYLES[:dimensions]):
        ranks = np.flatnonzero(depths % dimensions == axis)
        # The inside is white if a number is written there, because dark text is readable on white.
        style = {"markerfacecolor": PAPER if few else colour, "markeredgewidth": 2 if few else 0}
        axes.plot(ranks, depths[ranks], marker, color=colour, markersize=size, zorder=2, **style)
        key(axes, f"cuts {name}", marker, colour=colour, size=8, **style)
    for filled, colour, name in ((visited - found, GRID, "far"), (found, FOUND, "found")):
        ranks = [rank for rank, (node, _) in enumerate(order) if node.index in filled]
        if few and ranks:
            style = {"markerfacecolor": colour, "markeredgecolor": MUTED, "markeredgewidth": 0.8}
            axes.plot(ranks, depths[ranks], "s", markersize=1.55 * size, zorder=1.5, **style)
            key(axes, name, "s", size=9, **style)
    if few:
        rank_width = 72 * axes.get_window_extent().width / axes.figure.dpi / (len(order) + 1)
        longest = max((len(_coordinates(node)) for node, _ in order), default=0)
        for rank, (node, depth) in enumerate(order):
            _name_node(
                axes,
                node,
                (rank, depth),
                font_size=0.56 * size,
                # Two nodes of the same depth are at least two ranks apart.
                with_point=len(order) <= MAX_POINTS and 4.7 * longest < 2 * rank_width,
            )


def _node_size(axes: Axes, count: int) -> float:
    """Return a marker size, in typographic points, at which leaves two ranks apart do not touch."""
    width = 72 * axes.get_window_extent().width / axes.figure.dpi
    return float(np.clip(1.9 * width / max(1, count), 13, 17))


def _name_node(
    axes: Axes, node: Node, position: tuple[float, float], *, font_size: float, with_point: bool
) -> None:
    axes.annotate(
        str(node.index),
        position,
        ha="center",
        va="center",
        color=INK,
        fontsize=font_size,
        fontweight="bold",
        zorder=5,
    )
    if with_point:
        # The text has a white background, because links to the children pass behind it.
        text = write(axes, *position, _coordinates(node), offset=(0, -18), size=9)
        text.set_bbox({"facecolor": PAPER, "edgecolor": "none", "pad": 0.8})


def _coordinates(node: Node) -> str:
    return "(" + ", ".join(number(value) for value in np.ravel(node.point)) + ")"


def _in_order(root: Node | None) -> list[tuple[Node, int]]:
    """Return (node, depth) from left to right. Wrong trees may be too deep for recursion."""
    order, path, seen = [], [], set()
    node, depth = root, 0
    while node is not None or path:
        while node is not None and id(node) not in seen:
            seen.add(id(node))
            path.append((node, depth))
            node, depth = node.left, depth + 1
        if not path:
            break
        node, depth = path.pop()
        order.append((node, depth))
        node, depth = node.right, depth + 1
    return order
