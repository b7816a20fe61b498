"""Kd-trees of the plane: the regions they cut, and what a search visits and skips.

A node is any object with `point`, `index`, `left` and `right`; the root may be None. The axis of a
node is its depth modulo 2. A wrong tree is drawn as it is, and a loop in it is walked only once.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle, Rectangle
from numpy.typing import ArrayLike

from utils.plots.clouds import dots
from utils.plots.data import as_points, marker_size
from utils.plots.grouping import write_rows
from utils.plots.style import (
    BLUE,
    GREEN,
    GRID,
    INK,
    MUTED,
    ORANGE,
    PALE,
    VERMILION,
    canvas,
    counted,
    finish,
    frame,
    key,
    styled,
)

if TYPE_CHECKING:
    from utils.visits import Node

MOST_NAMES = 40
AXIS_LOOKS = (("x", BLUE, "-"), ("y", VERMILION, "--"))


class _Place(NamedTuple):
    """A node, its parent, its depth, and the region that it divides: two corners (2,)."""

    node: Node | None
    parent: Node | None
    depth: int
    lower: np.ndarray
    upper: np.ndarray


@styled
def kd_splits(
    points: ArrayLike,
    root: Node | None,
    *,
    names: bool | None = None,
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw how a kd-tree divides the plane: each node cuts the region it falls into.

    Parameters
    ----------
    points : (n, 2) array_like of float
    root : node or None
        With `point`, `index`, `left` and `right`.
    names : bool, optional
        Write the index at each point; by default up to 40 points.
    title : str, optional
    limits : ((x_low, x_high), (y_low, y_high)) or four numbers, optional
    axes : matplotlib.axes.Axes, optional

    Returns
    -------
    matplotlib.axes.Axes
    """
    points = as_points(points)
    axes = canvas(axes)
    frame(axes, *points.T, limits)
    _draw_splits(axes, root, strength=1.0)
    _draw_points(axes, points, names)
    for axis, colour, dashes in AXIS_LOOKS:
        key(axes, f"splits {axis}", colour=colour, line=dashes)
    return finish(axes, title, "x (m)", "y (m)")


@styled
def kd_search(
    points: ArrayLike,
    root: Node | None,
    target: ArrayLike,
    tolerance: float,
    visited: Iterable[int] | None = None,
    *,
    found: Iterable[int] | None = None,
    names: bool | None = None,
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw a search in a kd-tree: circle and box, nodes looked at, regions never entered.

    Parameters
    ----------
    points : (n, 2) array_like of float
    root : node or None
        With `point`, `index`, `left` and `right`.
    target : (2,) array_like of float
    tolerance : float
        Radius of the search in metres.
    visited : sequence of int, optional
        Indices of the nodes the search looked at. Regions without one are hatched.
    found : sequence of int, optional
        Indices the search returned.
    names, title, limits, axes
        As in :func:`kd_splits`.

    Returns
    -------
    matplotlib.axes.Axes
    """
    points = as_points(points)
    target = np.asarray(target, dtype=float)
    if target.shape != (2,):
        raise ValueError(f"target must be one point (x, y); yours has shape {target.shape}.")
    visited_rows = None if visited is None else _as_rows(visited, len(points), "visited")
    axes = canvas(axes)
    frame(axes, *points.T, limits)
    _draw_splits(axes, root, strength=0.45)
    if visited_rows is not None:
        _draw_pruned(axes, root, set(visited_rows.tolist()))
    _draw_points(axes, points, names)
    _draw_window(axes, target, float(tolerance))
    size = marker_size(len(points))
    if visited_rows is not None:
        label = f"{len(np.unique(visited_rows))} of {len(points)} visited"
        _ring(axes, points[visited_rows], "s", INK, size * 2.0, label)
    if found is not None:
        rows = _as_rows(found, len(points), "found")
        _ring(axes, points[rows], "o", GREEN, size * 1.5, f"{len(np.unique(rows))} found")
    return finish(axes, title, "x (m)", "y (m)")


def _draw_window(axes: Axes, target: np.ndarray, tolerance: float) -> None:
    axes.add_patch(
        Rectangle(
            target - tolerance,
            2 * tolerance,
            2 * tolerance,
            facecolor="none",
            edgecolor=INK,
            linewidth=1.2,
            linestyle=":",
            zorder=4,
        )
    )
    axes.add_patch(
        Circle(target, tolerance, facecolor=ORANGE, edgecolor="none", alpha=0.22, zorder=1.2)
    )
    axes.add_patch(
        Circle(target, tolerance, facecolor="none", edgecolor=INK, linewidth=1.4, zorder=4)
    )
    axes.plot(*target, marker="+", color=INK, markersize=11, markeredgewidth=1.8, zorder=6)
    key(axes, "target and tolerance", "+", colour=INK, size=9, markeredgewidth=1.8)


def _draw_pruned(axes: Axes, root: Node | None, visited: set[int]) -> None:
    """Hatch the largest regions in which no node was visited."""
    places = _places(axes, root)
    entered = set()
    # Parents come before their children, so backwards each child is known before its parent.
    for place in reversed(places):
        if place.node.index in visited or id(place.node) in entered:
            entered.update((id(place.node), id(place.parent)))
    pruned = [
        place
        for place in places
        if id(place.node) not in entered and (place.parent is None or id(place.parent) in entered)
    ]
    for place in pruned:
        axes.add_patch(
            Rectangle(
                place.lower,
                *(place.upper - place.lower),
                facecolor=GRID,
                edgecolor=PALE,
                hatch="//",
                linewidth=0,
                zorder=0.9,
            )
        )
    if pruned:
        key(
            axes,
            counted(len(pruned), "pruned region"),
            "s",
            colour=GRID,
            size=10,
            markeredgecolor=MUTED,
        )


def _draw_splits(axes: Axes, root: Node | None, *, strength: float) -> None:
    cuts, widths = ([], []), ([], [])
    for place in _places(axes, root):
        axis = place.depth % 2
        cut = np.stack([place.lower, place.upper])
        cut[:, axis] = np.ravel(place.node.point)[axis]
        cuts[axis].append(cut)
        # The first cuts are the widest: they matter most.
        widths[axis].append(max(0.6, 2.4 - 0.35 * place.depth))
    for axis, (_, colour, dashes) in enumerate(AXIS_LOOKS):
        look = {"colors": colour, "linestyles": dashes, "linewidths": widths[axis]}
        axes.add_collection(
            LineCollection(cuts[axis], alpha=strength, zorder=1.5, **look), autolim=False
        )


def _draw_points(axes: Axes, points: np.ndarray, names: bool | None) -> None:
    dots(axes, *points.T, "o", INK, marker_size(len(points)), zorder=3)
    if names or (names is None and len(points) <= MOST_NAMES):
        write_rows(axes, points)


def _ring(
    axes: Axes, points: np.ndarray, marker: str, colour: str, size: float, label: str
) -> None:
    look = {"markerfacecolor": "none", "markeredgewidth": 1.4}
    axes.plot(*points.T, marker, color=colour, markersize=size, zorder=3.5, label=label, **look)


def _as_rows(rows: Iterable[int], count: int, name: str) -> np.ndarray:
    rows = np.asarray(list(rows))
    if rows.size == 0:
        return np.empty(0, dtype=int)
    if not np.issubdtype(rows.dtype, np.integer) or rows.min() < 0 or rows.max() >= count:
        raise ValueError(f"{name} must hold indices of points: whole numbers below {count}.")
    return rows


def _places(axes: Axes, root: Node | None) -> list[_Place]:
    """Return a :class:`_Place` for each node, parents first; the root divides the whole view."""
    view = np.sort([axes.get_xlim(), axes.get_ylim()], axis=1)
    places, seen = [], set()
    waiting = [_Place(root, None, 0, *view.T)]
    while waiting:
        place = waiting.pop()
        if place.node is None or id(place.node) in seen:
            continue
        seen.add(id(place.node))
        places.append(place)
        point = np.ravel(place.node.point)
        if len(point) != 2:
            raise ValueError(
                f"Only trees of points (x, y) divide the plane; a node holds {len(point)} numbers."
            )
        axis = place.depth % 2
        upper, lower = place.upper.copy(), place.lower.copy()
        # A node of a wrong tree may lie outside its region, which then has no far side.
        upper[axis] = lower[axis] = np.clip(point[axis], place.lower[axis], place.upper[axis])
        waiting.append(_Place(place.node.left, place.node, place.depth + 1, place.lower, upper))
        waiting.append(_Place(place.node.right, place.node, place.depth + 1, lower, place.upper))
    return places
