"""Names and rings in figures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import matplotlib.patheffects
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse
from matplotlib.text import Annotation
from numpy.typing import ArrayLike

from utils.plots.style import INK, PAPER, styled

NAME_SIZE = 10.5  # typographic points
# The sides of a region at which its name may be, the preferred one first.
SIDES = np.array([(0, 1), (1, 0), (-1, 0), (0, -1)])


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


def write(
    axes: Axes,
    across: float,
    up: float,
    text: str,
    *,
    offset: ArrayLike = (0, 0),
    size: float = NAME_SIZE,
    weight: str = "normal",
    ha: str = "center",
) -> Annotation:
    """Write `text` at a position in data coordinates, with a white edge that keeps it readable.

    `offset` is the distance from this position in typographic points.
    """
    annotation = axes.annotate(
        text,
        (across, up),
        xytext=offset,
        textcoords="offset points",
        ha=ha,
        va="center",
        fontsize=size,
        fontweight=weight,
        color=INK,
        zorder=8,
        annotation_clip=True,
    )
    annotation.set_path_effects([matplotlib.patheffects.withStroke(linewidth=3, foreground=PAPER)])
    return annotation


def write_point_names(axes: Axes, points: np.ndarray, names: Sequence[str]) -> None:
    """Write a name next to each point, on the side away from its neighbours."""
    for row in np.flatnonzero(np.isfinite(points).all(axis=1)):
        away = points[row] - points
        distances = np.linalg.norm(away, axis=1)
        distinct = distances > 0
        push = np.sum(away[distinct] / distances[distinct, None] ** 3, axis=0)
        strength = np.linalg.norm(push)
        offset = 11 * push / strength if strength > 0 else (8, 8)
        write(axes, *points[row], names[row], offset=offset, size=10)


def write_names(axes: Axes, regions: ArrayLike, names: Sequence[str], points: np.ndarray) -> None:
    """Write each name next to its region, where it covers no other text and the fewest points.

    Names of regions outside the view are left out.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Axes with their final limits.
    regions : (n, 2, 2) array_like of float
        Lower left and upper right corner of each region, in data coordinates.
    names : sequence of str
    points : (m, 2) ndarray of float
        Everything that should stay visible, in data coordinates.
    """
    axes.apply_aspect()
    view = np.sort(np.transpose([axes.get_xlim(), axes.get_ylim()]), axis=0)
    window, points = axes.transData.transform(view), axes.transData.transform(points)
    taken = [text.get_window_extent().get_points() for text in axes.texts]

    def cost(place: _Place) -> tuple[bool, int]:
        covers_text = any(_overlap(place.outline, other) for other in taken)
        leaves_view = not _is_inside(place.outline, window).all()
        return covers_text or leaves_view, np.count_nonzero(_is_inside(points, place.outline))

    for region, name in zip(np.reshape(regions, (-1, 2, 2)), names, strict=True):
        if (region[1] < view[0]).any() or (region[0] > view[1]).any():
            continue
        place = min(_places_around(axes, np.clip(region, *view), name), key=cost)
        taken.append(place.outline)
        text = write(axes, *place.anchor, name, offset=place.offset, weight="bold")
        text.set_bbox({"facecolor": PAPER, "edgecolor": "none", "alpha": 0.85, "pad": 0.5})


class _Place(NamedTuple):
    """A place for a name.

    Attributes
    ----------
    anchor : ndarray, shape (2,)
        Middle of a side of the region, in data coordinates.
    offset : ndarray, shape (2,)
        From the anchor to the middle of the name, in typographic points.
    outline : ndarray, shape (2, 2)
        Lower left and upper right corner of the name, in pixels.
    """

    anchor: np.ndarray
    offset: np.ndarray
    outline: np.ndarray


def _places_around(axes: Axes, region: np.ndarray, name: str) -> list[_Place]:
    half_size = NAME_SIZE * np.array([0.35 * len(name), 0.6])  # in typographic points
    pixels = axes.figure.dpi / 72  # per typographic point
    places = []
    for side in SIDES:
        anchor = (region.sum(axis=0) + side * np.ptp(region, axis=0)) / 2
        offset = side * (half_size + 2)
        middle = axes.transData.transform(anchor) + pixels * offset
        places.append(_Place(anchor, offset, middle + np.outer([-1, 1], pixels * half_size)))
    return places


def _is_inside(points: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """Return whether each point (n, 2) is inside a rectangle, given by its two corners."""
    return ((points >= outline[0]) & (points <= outline[1])).all(axis=1)


def _overlap(first: np.ndarray, second: np.ndarray) -> bool:
    """Return whether two rectangles overlap, each given by its two corners."""
    return bool(((first[0] < second[1]) & (first[1] > second[0])).all())
