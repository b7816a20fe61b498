"""Points and circles that students drag in a notebook, with the answers of their own functions.

>>> def fit(points):
...     line, inliers = ransac_line(points, 200, 1.0, 0)
...     return Drawing(labels=np.where(inliers, 1, 2), lines={"line": line})
>>> drag_points(fit, points, movable=[10], limits=((-8, 8), (-6, 6)))

The function is called again whenever the student moves something. This needs the package anywidget.
Without it, in a script, and on the website, a figure shows the start, and a circle has sliders.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import util

import numpy as np
from numpy.typing import ArrayLike

from utils.by_hand.drawing import Board, Drawing
from utils.by_hand.still import draw_still
from utils.display import shell, show
from utils.plots.arguments import as_points
from utils.plots.style import spans_from_limits

__all__ = ["Drawing", "can_drag", "drag_circle", "drag_points"]

MOTIONLESS = (
    "The points of this figure do not move here. In JupyterLab and VS Code, you can drag them, if "
    "the package anywidget is installed."
)


def drag_points(
    draw: Callable[[np.ndarray], Drawing],
    points: ArrayLike,
    *,
    limits: ArrayLike,
    movable: Sequence[int] | None = None,
    can_add: bool = False,
) -> None:
    """Show points that the student drags, and what a function answers about them.

    Parameters
    ----------
    draw : callable
        Takes the points as an array of shape (n, 2), and returns a `Drawing`.
    points : (n, 2) array_like of float
        Points at the start, in metres.
    limits : ((x_low, x_high), (y_low, y_high)) or four numbers
        Visible region in metres.
    movable : sequence of int, optional
        Rows of the points that can be dragged; by default all.
    can_add : bool
        Whether the student may add and remove points. All points can then be dragged.
    """
    points = as_points(points)
    rows = range(len(points)) if movable is None else movable
    board = Board(spans_from_limits(limits), points, movable=tuple(rows), can_add=can_add)

    if can_drag():
        _drag(draw, board)
    else:
        _show_figure(draw, board)
        show(f"<p>{MOTIONLESS}</p>", MOTIONLESS)


def drag_circle(
    draw: Callable[[float, float, float], Drawing],
    circle: tuple[float, float, float],
    points: ArrayLike,
    *,
    limits: ArrayLike,
) -> None:
    """Show a circle that the student drags over points, and what a function answers about it.

    Parameters
    ----------
    draw : callable
        Takes the circle's x, y and radius in metres, and returns a `Drawing`.
    circle : (x, y, radius)
        Circle at the start, in metres.
    points : (n, 2) array_like of float
        Points in metres, which cannot be moved.
    limits : ((x_low, x_high), (y_low, y_high)) or four numbers
        Visible region in metres.
    """
    board = Board(spans_from_limits(limits), as_points(points), tuple(map(float, circle)))

    if can_drag():
        _drag(draw, board)
        return
    from ipywidgets import FloatSlider, interact

    def slider(value: float, low: float, high: float, title: str) -> FloatSlider:
        return FloatSlider(
            value=value, min=low, max=high, step=0.1, description=title, continuous_update=False
        )

    x, y, radius = board.circle
    interact(
        x=slider(x, *board.limits[0], "x (m)"),
        y=slider(y, *board.limits[1], "y (m)"),
        radius=slider(radius, 0.2, board.largest_radius, "radius (m)"),
    )(lambda x, y, radius: _show_figure(draw, board.moved(board.points, (x, y, radius))))


def can_drag() -> bool:
    """Return whether this is a notebook with the package that drawings need to move."""
    return bool(getattr(shell(), "kernel", None) and util.find_spec("anywidget"))


def _drag(draw: Callable[..., Drawing], board: Board) -> None:
    from utils.by_hand.widget import show_widget

    show_widget(draw, board)


def _show_figure(draw: Callable[..., Drawing], board: Board) -> None:
    import matplotlib.pyplot as plt

    draw_still(board, draw(*board.arguments))
    plt.show()
