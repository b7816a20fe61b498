"""Rings that draw attention to a place in a figure."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.patches import Ellipse

from utils.plots.style import INK, PAPER, styled


@styled
def ring(axes: Axes, x: float, y: float, *, radius: float, text: str = "") -> Axes:
    """Draw a ring around a place in a figure.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Axes that already show something.
    x, y : float
        The centre, in data coordinates.
    radius : float
        In units of the x axis. The ring is round on the page even if the y axis is stretched.
    text : str
        Text above the ring.
    """
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    window = axes.get_window_extent()
    scale = abs((right - left) / window.width), abs((high - low) / window.height)
    radius_up = radius if axes.get_aspect() == 1 else radius * scale[1] / scale[0]
    style = {"facecolor": "none", "edgecolor": INK, "linewidth": 2.2, "zorder": 8}
    axes.add_patch(Ellipse((x, y), 2 * radius, 2 * radius_up, **style))
    if text:
        axes.annotate(
            text,
            (x, y + radius_up),
            xytext=(0, 4),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize=10,
            color=INK,
            zorder=8,
            annotation_clip=True,
            bbox={"facecolor": PAPER, "edgecolor": "none", "alpha": 0.85, "pad": 1.0},
        )
    return axes
