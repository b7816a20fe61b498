"""A kd-tree drawn as a tree.

A node is any object with `point`, `index`, `left` and `right`; the root may be None. A wrong tree
is drawn as it is, and a loop in it is walked only once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from utils.plots.grouping import write
from utils.plots.style import (
    BLUE,
    GREEN,
    INK,
    MUTED,
    PAPER,
    VERMILION,
    canvas,
    finish,
    key,
    note,
    number,
    styled,
)

if TYPE_CHECKING:
    from utils.visits import Node

MOST_NAMES, MOST_POINTS = 40, 15
"""Larger trees are drawn without indices, and without coordinates."""

AXIS_LOOKS = (("x", "o", BLUE), ("y", "s", VERMILION), ("z", "D", GREEN))


@styled
def kd_tree(root: Node | None, *, title: str | None = None, axes: Axes | None = None) -> Axes:
    """Draw a kd-tree as a tree: depth downwards, smaller to the left, equal or greater right.

    Parameters
    ----------
    root : node or None
        With `point`, `index`, `left` and `right`.
    title : str, optional
    axes : matplotlib.axes.Axes, optional

    Returns
    -------
    matplotlib.axes.Axes
    """
    axes = canvas(axes)
    order = _in_order(root)
    places = {id(node): (rank, depth) for rank, (node, depth) in enumerate(order)}
    deepest = max((depth for _, depth in order), default=0)
    axes.set_xlim(-1, max(len(order), 1))
    axes.set_ylim(deepest + 0.6, -0.6)
    links = [
        (places[id(node)], places[id(child)])
        for node, _ in order
        for child in (node.left, node.right)
        if child is not None
    ]
    axes.add_collection(LineCollection(links, colors=MUTED, linewidths=1, zorder=1), autolim=False)
    _draw_nodes(axes, order)
    if not order:
        note(axes, "the tree is empty")
    axes.set_xticks([])
    axes.spines["bottom"].set_visible(False)
    axes.yaxis.get_major_locator().set_params(integer=True)
    return finish(axes, title, None, "depth")


def _draw_nodes(axes: Axes, order: list[tuple[Node, int]]) -> None:
    """Draw (node, depth) by rank and depth, in the colour and shape of the axis it splits."""
    dimensions = len(np.ravel(order[0][0].point)) if order else 2
    few = len(order) <= MOST_NAMES
    size = _node_size(axes, len(order)) if few else 3
    depths = np.array([depth for _, depth in order], dtype=int)
    for axis, (name, marker, colour) in enumerate(AXIS_LOOKS[:dimensions]):
        ranks = np.flatnonzero(depths % dimensions == axis)
        # Room for a number inside: a dark one on paper reads best.
        look = {"markerfacecolor": PAPER if few else colour, "markeredgewidth": 2 if few else 0}
        axes.plot(ranks, depths[ranks], marker, color=colour, markersize=size, zorder=2, **look)
        key(axes, f"splits {name}", marker, colour=colour, size=8, **look)
    if few:
        for rank, (node, depth) in enumerate(order):
            _name_node(
                axes,
                node,
                (rank, depth),
                font_size=0.56 * size,
                with_point=len(order) <= MOST_POINTS,
            )


def _node_size(axes: Axes, count: int) -> float:
    """Return a marker size at which neighbouring leaves, two ranks apart, do not touch."""
    width = 72 * axes.get_window_extent().width / axes.figure.dpi
    return float(np.clip(1.9 * width / max(1, count), 13, 17))


def _name_node(
    axes: Axes, node: Node, place: tuple[float, float], *, font_size: float, with_point: bool
) -> None:
    axes.annotate(
        str(node.index),
        place,
        ha="center",
        va="center",
        color=INK,
        fontsize=font_size,
        fontweight="bold",
        zorder=5,
    )
    if with_point:
        point = ", ".join(number(value) for value in np.ravel(node.point))
        # On paper of its own: the links to the children start below it.
        written = write(axes, *place, f"({point})", offset=(0, -16), size=9)
        written.set_bbox({"facecolor": PAPER, "edgecolor": "none", "pad": 0.8})


def _in_order(root: Node | None) -> list[tuple[Node, int]]:
    """Return (node, depth) from left to right, without recursion: bad trees are deep."""
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
