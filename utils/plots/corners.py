"""Figures of boxes with eight corners in any order: outlines, and one box with corner numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import ArrayLike

from utils.plots.annotations import write, write_names
from utils.plots.arguments import as_cloud, as_names, drawn_rows, marker_size, project
from utils.plots.clouds import dots, mark_sensor
from utils.plots.style import (
    BLUE,
    INK,
    MUTED,
    PALE,
    PALETTE,
    VERMILION,
    canvas,
    finish,
    frame,
    key,
    note,
    styled,
)


@styled
def boxes(
    corners: ArrayLike,
    *,
    cloud: ArrayLike | None = None,
    view: str = "above",
    names: bool | Sequence[str | int] | None = None,
    label: str | None = None,
    reference: bool = False,
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw the outlines of boxes, on top of `cloud` or of an existing figure.

    Parameters
    ----------
    corners : (N, 8, 3) array_like of float
        The eight corners of each box in metres, in any order. Boxes with a non-finite corner are
        left out.
    cloud : (n, 3) or (n, 4) array_like of float, optional
        In metres; drawn in a pale colour below the boxes.
    view : {"above", "side", "side to scale"}
    names : bool or sequence of str or int, optional
        Names to write next to the boxes; True for the row numbers.
    label : str, optional
        Entry in the legend; the number of boxes is added.
    reference : bool
        Draw dashed grey lines, for true boxes or the previous frame's boxes.
    title, axes
        As in :func:`utils.plots.from_above`.
    limits : ((low, high), (low, high)) or four numbers, optional
        Visible region in metres. By default the current view of `axes`, or else all boxes.
    """
    corners = _as_corners(corners)
    names = as_names(names, len(corners))
    across, up, across_label, up_label = project(corners, view)
    axes = canvas(axes)
    remark, cloud_2d = "", np.empty((2, 0))
    focus = (across, up)
    if cloud is not None:
        cloud_2d = np.stack(project(as_cloud(cloud), view)[:2])
        focus = focus if len(corners) else cloud_2d
    frame(axes, *focus, limits, equal=view != "side")
    if cloud is not None:
        rows, remark = drawn_rows(axes, *cloud_2d)
        dots(axes, cloud_2d[0][rows], cloud_2d[1][rows], "o", PALE, marker_size(len(rows)))
    colour, line = (MUTED, "--") if reference else (VERMILION, "-")
    finite = np.flatnonzero(np.isfinite(corners).all(axis=(1, 2)))
    outlines = [_outline(across[box], up[box]) for box in finite]
    axes.add_collection(
        LineCollection(outlines, colors=colour, linestyles=line, linewidths=1.8, zorder=4),
        autolim=False,
    )
    key(axes, f"{label or 'boxes'}: {len(corners):,}", colour=colour, line=line, linewidth=1.8)
    mark_sensor(axes)
    note(axes, remark)
    if names:
        _write_names(axes, outlines, [names[box] for box in finite], cloud_2d.T)
    return finish(axes, title, across_label, up_label)


@styled
def corner_numbers(box: ArrayLike, *, title: str | None = None, axes: Axes | None = None) -> Axes:
    """Draw one box at an angle, with the row number of each corner.

    The order of the corners does not affect the edges: the four lowest corners form the floor. A
    wrong order therefore appears as wrong numbers on a correct box.

    Parameters
    ----------
    box : (8, 3) array_like of float
        In metres.
    title : str, optional
    axes : matplotlib.axes.Axes, optional
    """
    box = _as_corners(np.asarray(box, dtype=float)[None])[0]
    axes = canvas(axes, size=(5.5, 4.2))
    axes.set_axis_off()
    if not np.isfinite(box).all():
        note(axes, "a corner of the box is not finite")
        return finish(axes, title)
    drawn = _project_obliquely(box - box.mean(axis=0))
    extent = max(np.ptp(drawn, axis=0).max(), 1e-3)
    start = drawn.min(axis=0) - 0.12 * extent
    frame(axes, *np.concatenate([start[None] - 0.05 * extent, drawn + 0.08 * extent]).T)
    edges = _edges(box)
    hidden = _project_obliquely(box, depth=True).argmax()
    for edge in edges:
        behind = hidden in edge
        axes.plot(
            *drawn[list(edge)].T,
            color=MUTED if behind else INK,
            linestyle=":" if behind else "-",
            linewidth=1.2 if behind else 1.8,
            zorder=2,
        )
    for number, place in enumerate(drawn):
        dots(axes, *place[:, None], "o", PALETTE[0], 17, zorder=4)
        axes.annotate(
            str(number), place, ha="center", va="center", color="white", fontweight="bold", zorder=5
        )
    _draw_directions(axes, start, 0.18 * extent)
    return finish(axes, title)


def _write_names(
    axes: Axes, outlines: list[np.ndarray], names: list[str], points: np.ndarray
) -> None:
    """Write names next to outlines, off `points` (m, 2) and off the outlines."""
    regions = [(outline.min(axis=0), outline.max(axis=0)) for outline in outlines]
    lines = [np.linspace(line[:-1], line[1:], 50).reshape(-1, 2) for line in outlines]
    write_names(axes, regions, names, np.concatenate([points, *lines]))


def _as_corners(corners: ArrayLike) -> np.ndarray:
    try:
        corners = np.asarray(corners, dtype=float)
    except (TypeError, ValueError):
        corners = np.empty((0, 1))
    if corners.size == 0 and corners.shape[0] == 0 and corners.ndim in (1, 3):
        return np.empty((0, 8, 3))
    if corners.ndim != 3 or corners.shape[1:] != (8, 3):
        raise ValueError(
            "corners must have shape (N, 8, 3), with eight corners (x, y, z) per box; "
            f"yours has {corners.shape}."
        )
    return corners


def _outline(across: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return the convex hull of points as a closed line (m, 2).

    This is Andrew's monotone chain (1979). It also works for points on a line, or a single point,
    for which SciPy's hull raises an error.
    """
    points = np.unique(np.stack([across, up], axis=1), axis=0)

    def half_hull(points: np.ndarray) -> list[np.ndarray]:
        chain = []
        for point in points:
            while len(chain) > 1:
                first, second = chain[-1] - chain[-2], point - chain[-2]
                if first[0] * second[1] - first[1] * second[0] > 0:
                    break
                chain.pop()
            chain.append(point)
        return chain

    lower, upper = half_hull(points), half_hull(points[::-1])
    return np.array([*lower, *upper[1:]])


def _edges(box: np.ndarray) -> list[tuple[int, int]]:
    """Return the twelve edges of a box as pairs of rows: floor, roof and vertical edges."""
    order = np.argsort(box[:, 2], kind="stable")
    floor, roof = (_sorted_around_centre(box, rows) for rows in (order[:4], order[4:]))
    edges = [(ring[k], ring[(k + 1) % 4]) for ring in (floor, roof) for k in range(4)]
    for row in floor:
        nearest = np.linalg.norm(box[roof, :2] - box[row, :2], axis=1).argmin()
        edges.append((row, roof[nearest]))
    return edges


def _sorted_around_centre(box: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return `rows`, sorted by the direction of their corners from the centre."""
    spokes = box[rows, :2] - box[rows, :2].mean(axis=0)
    return rows[np.argsort(np.arctan2(spokes[:, 1], spokes[:, 0]))]


def _project_obliquely(points: np.ndarray, *, depth: bool = False) -> np.ndarray:
    """Project points onto the drawing plane (n, 2), as seen from the front right and above.

    With `depth`, return the depth of each point along the line of sight (n,) instead.
    """
    turn, tilt = np.radians([-54.0, 42.0])
    right = np.array([-np.sin(turn), np.cos(turn), 0])
    away = -np.array([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)])
    if depth:
        return points @ away
    return points @ np.stack([right, np.cross(right, away)], axis=1)


def _draw_directions(axes: Axes, start: np.ndarray, length: float) -> None:
    """Draw an arrow for each of the directions x, y and z."""
    for name, direction in zip("xyz", _project_obliquely(np.eye(3)), strict=True):
        end = start + length * direction
        axes.annotate(
            "", end, start, arrowprops={"arrowstyle": "-|>", "color": BLUE, "linewidth": 1.4}
        )
        write(axes, *(end + 0.15 * length * direction), name, weight="bold")
