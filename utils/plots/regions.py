"""Kd-trees of the plane: the regions they cut, and what a search looks at and leaves out.

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

from utils.plots.arguments import as_points, marker_size
from utils.plots.clouds import dots
from utils.plots.clusters import write_rows
from utils.plots.style import (
    BLUE,
    GREEN,
    GRID,
    INK,
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
from utils.visits import NOT_YET, PRUNED, VISITED, fates

if TYPE_CHECKING:
    from utils.visits import Node

MOST_NAMES = 40
AXIS_LOOKS = (("x", BLUE, "-"), ("y", VERMILION, "--"))
# Lines across what is left out for good, dots on what is only not reached yet.
LEFT_OUT = {
    PRUNED: {"facecolor": GRID, "edgecolor": PALE, "hatch": "//"},
    NOT_YET: {"facecolor": "none", "edgecolor": PALE, "hatch": ".."},
}
TITLE = {"color": INK, "fontsize": 12, "fontweight": "bold"}


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
    """
    points = as_points(points)
    axes = canvas(axes)
    frame(axes, *points.T, limits)
    axes.locator_params(nbins=6)
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
    steps: int | None = None,
    names: bool | None = None,
    legend: bool = True,
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw a search in a kd-tree: circle and box, nodes looked at, regions left out.

    Parameters
    ----------
    points : (n, 2) array_like of float
    root : node or None
        With `point`, `index`, `left` and `right`.
    target : (2,) array_like of float
    tolerance : float
        Radius of the search in metres.
    visited : sequence of int, optional
        Indices of the nodes the search looked at, in order. Regions without one are hatched.
    found : sequence of int, optional
        Indices the search returned.
    steps : int, optional
        How many nodes it has looked at so far; by default all. Regions that it enters later are
        dotted, and what it finds later is not shown.
    legend : bool
        Explain the marks above the picture.
    names, title, limits, axes
        As in :func:`kd_splits`.
    """
    points = as_points(points)
    target = np.asarray(target, dtype=float)
    if target.shape != (2,):
        raise ValueError(f"target must be one point (x, y); yours has shape {target.shape}.")
    rows = None if visited is None else _as_rows(visited, len(points), "visited")
    found = None if found is None else np.unique(_as_rows(found, len(points), "found"))
    axes = canvas(axes)
    frame(axes, *points.T, limits)
    axes.locator_params(nbins=6)
    _draw_splits(axes, root, strength=0.45)
    if rows is not None:
        _draw_left_out(axes, root, rows.tolist(), steps)
        if found is not None and steps is not None:
            found = np.intersect1d(found, rows[:steps])
    _draw_points(axes, points, names)
    _draw_window(axes, target, float(tolerance))
    size = marker_size(len(points))
    if rows is not None:
        so_far = np.unique(rows[:steps])
        label = f"{len(so_far)} looked at"
        _ring(axes, points[so_far], "s", INK, size * 2.0, label)
        if steps is not None and 0 < steps <= len(rows):
            now = rows[steps - 1]
            look = {"markerfacecolor": "none", "markeredgewidth": 2.4}
            axes.plot(*points[now], "o", color=INK, markersize=size * 3.6, zorder=3.6, **look)
    if found is not None:
        _disc(axes, points[found], size * 1.25, f"{len(found)} found")
    finish(axes, title, "x (m)", "y (m)")
    if not legend:
        axes.get_legend().remove()
        axes.set_title(axes.get_title(loc="left"), loc="left", pad=7, **TITLE)
    return axes


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
    key(axes, "target", "+", colour=INK, size=9, markeredgewidth=1.8)


def _draw_left_out(axes: Axes, root: Node | None, visited: list[int], steps: int | None) -> None:
    """Hatch the largest regions that the search prunes, and dot those that it enters later."""
    places, made = _places(axes, root), fates(root, visited, steps)
    for fate, look in LEFT_OUT.items():
        branches = 0
        for place in places:
            above = VISITED if place.parent is None else made[id(place.parent)]
            if made[id(place.node)] == fate and above == VISITED:
                size = place.upper - place.lower
                axes.add_patch(Rectangle(place.lower, *size, linewidth=0, zorder=0.9, **look))
                branches += 1
        if branches:
            count = sum(its_fate == fate for its_fate in made.values())
            label = f"{fate}: {branches} branch{'es' * (branches > 1)}, {counted(count, 'point')}"
            axes.add_patch(Rectangle((0, 0), 0, 0, label=label, linewidth=0.6, **look))


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


def _disc(axes: Axes, points: np.ndarray, size: float, label: str) -> None:
    look = {"markeredgecolor": INK, "markeredgewidth": 0.8, "linestyle": "none"}
    axes.plot(*points.T, "o", color=GREEN, markersize=size, zorder=3.7, label=label, **look)


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
