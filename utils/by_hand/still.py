"""The same drawing as a figure of matplotlib, for places where nothing can be dragged."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle, Polygon, Rectangle

from utils.by_hand.drawing import Board, Drawing
from utils.plots.annotations import write
from utils.plots.arguments import marker_size
from utils.plots.clouds import dots
from utils.plots.style import (
    GREEN,
    GRID,
    INK,
    MUTED,
    ORANGE,
    PALE,
    WIDTH,
    canvas,
    finish,
    frame,
    key,
    styled,
)


@styled
def draw_still(board: Board, drawing: Drawing) -> Axes:
    """Draw a board and a function's answer in a new figure, and return its axes."""
    shapes = drawing.shapes(board)
    width, height = np.ptp(board.limits, axis=1)
    axes = canvas(size=(WIDTH, min(0.9 * WIDTH * height / width + 0.9, 6.8)))
    frame(axes, *board.points.T, board.limits)
    size = 1.3 * marker_size(len(board.points))
    for group in shapes["groups"]:
        rows, style = group["rows"], (group["marker"], group["colour"])
        dots(axes, *board.points[rows].T, *style, size, zorder=3)
        if group["legend"]:
            key(axes, group["legend"], group["marker"], colour=group["colour"])
        for row in rows if group["number"] else ():
            write(axes, *board.points[row], group["number"], offset=(9, 9))
    if not shapes["groups"]:
        dots(axes, *board.points.T, "o", INK, size, zorder=3)
    for line, dashes in zip(shapes["lines"], ("-", "--", ":"), strict=False):
        across, up = np.transpose(line["ends"])
        style = {"color": INK, "linestyle": dashes, "linewidth": 1.8, "zorder": 2.5}
        axes.plot(across, up, scalex=False, scaley=False, label=line["name"], **style)
    if band := shapes["band"]:
        style = {"facecolor": GREEN, "edgecolor": GREEN, "alpha": 0.18, "zorder": 1}
        axes.add_patch(Polygon(band["corners"], label=band["name"], **style))
    edges = board.points[np.array(shapes["edges"], dtype=int).reshape(-1, 2)]
    axes.add_collection(LineCollection(edges, colors=MUTED, linewidths=1.2), autolim=False)
    for group in shapes["rectangles"]:
        style = {"facecolor": GRID, "edgecolor": PALE, "hatch": "//", "linewidth": 0}
        for left, low, right, high in group["boxes"]:
            corner = (left, low)
            axes.add_patch(Rectangle(corner, right - left, high - low, zorder=0.9, **style))
        label = f"{group['name']}: {len(group['boxes'])}"
        axes.add_patch(Rectangle((0, 0), 0, 0, label=label, **style))
    if len(board.movable) < len(board.points):
        style = {"color": INK, "fillstyle": "none", "linestyle": "none", "zorder": 4}
        axes.plot(*board.points[list(board.movable)].T, "o", markersize=2.2 * size, **style)
    if board.circle:
        _draw_circle(axes, *board.circle)
    return finish(axes, drawing.title, "x (m)", "y (m)")


def _draw_circle(axes: Axes, x: float, y: float, radius: float) -> None:
    """Draw a circle, and its bounding square as a dotted line."""
    style = {"facecolor": "none", "edgecolor": INK, "zorder": 4}
    corner = (x - radius, y - radius)
    axes.add_patch(Rectangle(corner, 2 * radius, 2 * radius, linestyle=":", linewidth=1.2, **style))
    axes.add_patch(Circle((x, y), radius, facecolor=ORANGE, alpha=0.22, zorder=1.2))
    axes.add_patch(Circle((x, y), radius, linewidth=1.4, **style))
    axes.plot(x, y, marker="+", color=INK, markersize=11, markeredgewidth=1.8, zorder=6)
