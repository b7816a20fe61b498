"""Figures of two-dimensional kd-trees: the cells of the tree, and the nodes that a search visits.

A node is any object with `point`, `index`, `left` and `right`; the root may be None. The axis of a
node is its depth modulo 2. A wrong tree is drawn as it is, and a loop in it is followed only once.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle, Rectangle
from numpy.typing import ArrayLike

from utils.plots.annotations import write_point_names
from utils.plots.arguments import as_names, as_points, marker_size
from utils.plots.clouds import dots
from utils.plots.style import (
    BLUE,
    GREEN,
    GRID,
    INK,
    ORANGE,
    PALE,
    TITLE,
    VERMILION,
    canvas,
    counted,
    finish,
    frame,
    key,
    spans_from_limits,
    styled,
)
from utils.visits import NOT_YET, PRUNED, VISITED, node_states

if TYPE_CHECKING:
    from utils.visits import Node

MAX_NAMES = 40
AXIS_STYLES = (("x", BLUE, "-"), ("y", VERMILION, "--"))
# Hatching for cells that the search prunes, and dots for cells that it has not reached yet.
REGION_STYLES = {
    PRUNED: {"facecolor": GRID, "edgecolor": PALE, "hatch": "//"},
    NOT_YET: {"facecolor": "none", "edgecolor": PALE, "hatch": ".."},
}


class _Cell(NamedTuple):
    """A node with its parent, its depth, and two corners (2,) of the cell that it divides."""

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
    """Draw the division of the plane by a kd-tree, in which each node cuts its cell in two.

    Parameters
    ----------
    points : (n, 2) array_like of float
        In metres.
    root : node or None
        An object with `point`, `index`, `left` and `right`.
    names : bool, optional
        Write the index at each point; by default only for up to 40 points.
    title : str, optional
    limits : ((x_low, x_high), (y_low, y_high)) or four numbers, optional
        Visible region in metres.
    axes : matplotlib.axes.Axes, optional
    """
    points = as_points(points)
    axes = canvas(axes)
    frame(axes, *points.T, limits)
    axes.locator_params(nbins=6)
    _draw_splits(axes, root, strength=1.0)
    _draw_points(axes, points, names)
    for axis, colour, dashes in AXIS_STYLES:
        key(axes, f"cuts {axis}", colour=colour, line=dashes)
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
    """Draw a search in a kd-tree: circle and bounding box, visited nodes and pruned regions.

    Parameters
    ----------
    points : (n, 2) array_like of float
        In metres.
    root : node or None
        An object with `point`, `index`, `left` and `right`.
    target : (2,) array_like of float
        Centre of the search, in metres.
    tolerance : float
        Radius of the search in metres.
    visited : sequence of int, optional
        Indices of the nodes that the search visits, in order. Regions without a visited node are
        hatched.
    found : sequence of int, optional
        Indices that the search returns.
    steps : int, optional
        Number of nodes visited so far; by default all. Regions that the search enters later are
        dotted, and points that it visits later are not shown as found.
    legend : bool
        Show the legend above the figure.
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
        _draw_unvisited_regions(axes, root, rows.tolist(), steps)
        if found is not None and steps is not None:
            found = np.intersect1d(found, rows[:steps])
    _draw_points(axes, points, names)
    _draw_window(axes, target, float(tolerance))
    size = marker_size(len(points))
    if rows is not None:
        so_far = np.unique(rows[:steps])
        label = f"{len(so_far)} looked at"
        _draw_ring(axes, points[so_far], "s", INK, size * 2.0, label)
        if steps is not None and 0 < steps <= len(rows):
            current = rows[steps - 1]
            style = {"markerfacecolor": "none", "markeredgewidth": 2.4}
            axes.plot(*points[current], "o", color=INK, markersize=size * 3.6, zorder=3.6, **style)
    if found is not None:
        _draw_disc(axes, points[found], size * 1.25, f"{len(found)} found")
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


def pruned_regions(root: Node | None, visited: Iterable[int], limits: ArrayLike) -> np.ndarray:
    """Return the largest cells that a search prunes.

    Parameters
    ----------
    root : node or None
        An object with `point`, `index`, `left` and `right`.
    visited : sequence of int
        Indices of the nodes that the search visits.
    limits : ((x_low, x_high), (y_low, y_high)) or four numbers
        Region in metres that the root divides.

    Returns
    -------
    ndarray, shape (m, 4)
        Corners (x_low, y_low, x_high, y_high) of each cell, in metres.
    """
    cells = _cells(spans_from_limits(limits), root)
    pruned = _largest_cells(cells, node_states(root, list(visited)), PRUNED)
    return np.array([[*cell.lower, *cell.upper] for cell in pruned]).reshape(-1, 4)


def _largest_cells(cells: list[_Cell], state_of: dict[int, str], state: str) -> list[_Cell]:
    """Return the cells of nodes in a state whose parents were visited."""
    return [
        cell
        for cell in cells
        if state_of[id(cell.node)] == state
        and (cell.parent is None or state_of[id(cell.parent)] == VISITED)
    ]


def _draw_unvisited_regions(
    axes: Axes, root: Node | None, visited: list[int], steps: int | None
) -> None:
    """Hatch the largest cells that the search prunes, and dot those that it enters later."""
    cells, state_of = _cells(_view_of(axes), root), node_states(root, visited, steps)
    for state, style in REGION_STYLES.items():
        largest = _largest_cells(cells, state_of, state)
        for cell in largest:
            size = cell.upper - cell.lower
            axes.add_patch(Rectangle(cell.lower, *size, linewidth=0, zorder=0.9, **style))
        if branches := len(largest):
            count = sum(other_state == state for other_state in state_of.values())
            label = f"{state}: {branches} branch{'es' * (branches > 1)}, {counted(count, 'point')}"
            axes.add_patch(Rectangle((0, 0), 0, 0, label=label, linewidth=0.6, **style))


def _draw_splits(axes: Axes, root: Node | None, *, strength: float) -> None:
    cuts, widths = ([], []), ([], [])
    for cell in _cells(_view_of(axes), root):
        axis = cell.depth % 2
        cut = np.stack([cell.lower, cell.upper])
        cut[:, axis] = np.ravel(cell.node.point)[axis]
        cuts[axis].append(cut)
        # The first cuts matter most, so they have the widest lines.
        widths[axis].append(max(0.6, 2.4 - 0.35 * cell.depth))
    for axis, (_, colour, dashes) in enumerate(AXIS_STYLES):
        style = {"colors": colour, "linestyles": dashes, "linewidths": widths[axis]}
        axes.add_collection(
            LineCollection(cuts[axis], alpha=strength, zorder=1.5, **style), autolim=False
        )


def _draw_points(axes: Axes, points: np.ndarray, names: bool | None) -> None:
    dots(axes, *points.T, "o", INK, marker_size(len(points)), zorder=3)
    if names or (names is None and len(points) <= MAX_NAMES):
        write_point_names(axes, points, as_names(True, len(points)))


def _draw_ring(
    axes: Axes, points: np.ndarray, marker: str, colour: str, size: float, label: str
) -> None:
    style = {"markerfacecolor": "none", "markeredgewidth": 1.4}
    axes.plot(*points.T, marker, color=colour, markersize=size, zorder=3.5, label=label, **style)


def _draw_disc(axes: Axes, points: np.ndarray, size: float, label: str) -> None:
    style = {"markeredgecolor": INK, "markeredgewidth": 0.8, "linestyle": "none"}
    axes.plot(*points.T, "o", color=GREEN, markersize=size, zorder=3.7, label=label, **style)


def _as_rows(rows: Iterable[int], count: int, name: str) -> np.ndarray:
    rows = np.asarray(list(rows))
    if rows.size == 0:
        return np.empty(0, dtype=int)
    if not np.issubdtype(rows.dtype, np.integer) or rows.min() < 0 or rows.max() >= count:
        raise ValueError(f"{name} must contain indices of points: whole numbers below {count}.")
    return rows


def _view_of(axes: Axes) -> np.ndarray:
    return np.array([axes.get_xlim(), axes.get_ylim()])


def _cells(view: np.ndarray, root: Node | None) -> list[_Cell]:
    """Return a :class:`_Cell` for each node, parents first; the root divides the whole view."""
    cells, seen = [], set()
    waiting = [_Cell(root, None, 0, *np.sort(view, axis=1).T)]
    while waiting:
        cell = waiting.pop()
        if cell.node is None or id(cell.node) in seen:
            continue
        seen.add(id(cell.node))
        cells.append(cell)
        point = np.ravel(cell.node.point)
        if len(point) != 2:
            raise ValueError(
                "Regions can be drawn only for points (x, y); a node of this tree has "
                f"{len(point)} numbers."
            )
        axis = cell.depth % 2
        upper, lower = cell.upper.copy(), cell.lower.copy()
        # In a wrong tree, a node may be outside its cell. One half of the cell is then empty.
        upper[axis] = lower[axis] = np.clip(point[axis], cell.lower[axis], cell.upper[axis])
        waiting.append(_Cell(cell.node.left, cell.node, cell.depth + 1, cell.lower, upper))
        waiting.append(_Cell(cell.node.right, cell.node, cell.depth + 1, lower, cell.upper))
    return cells
