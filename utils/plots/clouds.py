"""Whole clouds: seen from above, from the side, and as kept and removed points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from numpy.typing import ArrayLike

from utils.plots.arguments import as_cloud, as_mask, as_values, drawn_rows, marker_size, project
from utils.plots.style import (
    BLUE,
    COLOURS,
    INK,
    MUTED,
    PALE,
    PAPER,
    VERMILION,
    canvas,
    finish,
    frame,
    key,
    note,
    number,
    styled,
)


@styled
def from_above(
    cloud: ArrayLike,
    *,
    values: ArrayLike | None = None,
    span: tuple[float, float] | None = None,
    label: str | None = None,
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw a cloud as a bird sees it: x forward to the right, y left up, to scale.

    Parameters
    ----------
    cloud : (n, 3) or (n, 4) array_like of float
        x forward, y left, z up in metres; more columns are ignored. Rows with a non-finite
        coordinate are left out, clouds above 30 000 points are thinned; both are said in a corner.
    values : (n,) array_like of float, optional
        What the colour shows; the height by default.
    span : (float, float), optional
        The values at both ends of the colours. Of heights -2 and 2 m, so that a car looks the
        same in all pictures; of other values by default their own range.
    label : str, optional
        Name and unit of `values`, written at the colour bar.
    title : str, optional
    limits : ((x_low, x_high), (y_low, y_high)) or four numbers, optional
        Visible region in metres. By default what `axes` show already, or the cloud; of more than
        5 000 points the outermost hundredth in each direction may lie outside.
    axes : matplotlib.axes.Axes, optional
        Where to draw; a new figure by default.

    Raises
    ------
    ValueError
        When a shape does not fit; the message says which one would.
    """
    return _coloured(cloud, "above", values, span, label, None, title, limits, axes)


@styled
def from_side(
    cloud: ArrayLike,
    *,
    values: ArrayLike | None = None,
    span: tuple[float, float] | None = None,
    label: str | None = None,
    level: float | None = None,
    to_scale: bool = False,
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw a cloud from its right-hand side: x forward to the right, z up.

    Heights are stretched to fill the figure, and the axis says so: a scan is a hundred times
    longer than it is high.

    Parameters
    ----------
    cloud, values, span, label, title, axes
        As in :func:`from_above`.
    level : float, optional
        Height in metres of a horizontal line, such as the ground level.
    to_scale : bool
        Do not stretch: a metre up is as long as a metre forward.
    limits : ((x_low, x_high), (z_low, z_high)) or four numbers, optional
        Visible region in metres.
    """
    view = "side to scale" if to_scale else "side"
    return _coloured(cloud, view, values, span, label, level, title, limits, axes)


@styled
def kept_and_removed(
    cloud: ArrayLike,
    keep: ArrayLike,
    *,
    view: str = "above",
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw what a filter keeps (strong dots) and what it removes (pale crosses), with counts.

    Parameters
    ----------
    cloud : (n, 3) or (n, 4) array_like of float
        In metres, see :func:`from_above`.
    keep : (n,) array_like of bool
        True for the points that stay.
    view : {"above", "side", "side to scale"}
    title, limits, axes
        As in :func:`from_above`.
    """
    cloud = as_cloud(cloud)
    keep = as_mask(keep, len(cloud))
    groups = (Group("removed", ~keep, "x", PALE), Group("kept", keep, "o", BLUE))
    return draw_groups(cloud, groups, view=view, title=title, limits=limits, axes=axes)


# Metres, from below the road to a lorry's roof: the same colours in every picture.
HEIGHTS = (-2.0, 2.0)


class Group(NamedTuple):
    """Points that are drawn alike. Strong ones are large and none of them is thinned out."""

    name: str
    mask: np.ndarray
    marker: str
    colour: str
    strong: bool = False


def draw_groups(
    cloud: np.ndarray,
    groups: Sequence[Group],
    *,
    view: str,
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw a checked cloud in groups, the last one on top and first in the legend."""
    across, up, across_label, up_label = project(cloud, view)
    axes = canvas(axes)
    frame(axes, across, up, limits, equal=view != "side")
    rows, remark = drawn_rows(axes, across, up)
    size = marker_size(len(rows))
    for group in groups:
        chosen = np.flatnonzero(group.mask) if group.strong else rows[group.mask[rows]]
        scale = max(1.6, 4.0 / size) if group.strong else 1.0
        dots(axes, across[chosen], up[chosen], group.marker, group.colour, size * scale)
    for group in reversed(groups):
        key(
            axes,
            f"{group.name}: {np.count_nonzero(group.mask):,}",
            group.marker,
            colour=group.colour,
        )
    if cloud.shape[1] > 2:
        mark_sensor(axes)
    note(axes, remark)
    return finish(axes, title, across_label, up_label)


def dots(
    axes: Axes,
    across: np.ndarray,
    up: np.ndarray,
    marker: str,
    colour: str,
    size: float,
    *,
    zorder: float = 2.0,
) -> None:
    """Draw markers of one colour: one rasterised artist, which stays quick for many points."""
    # A cross has no area to fill: it needs a wider stroke and a little more room than a dot.
    cross = marker in ("x", "+")
    size *= 1.3 if cross else 1.0
    axes.plot(
        across,
        up,
        linestyle="none",
        marker=marker,
        color=colour,
        markersize=size,
        markeredgewidth=min(0.9, size / 3.9) if cross else 0,
        rasterized=True,
        zorder=zorder,
    )


def mark_sensor(axes: Axes) -> None:
    """Mark the origin, where the sensor stands, looking to the right."""
    look = {"color": PAPER, "markeredgecolor": INK, "markeredgewidth": 1.2, "zorder": 6}
    axes.plot(0, 0, marker=">", markersize=8, **look)
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    if not (left < 0 < right and low < 0 < high):
        return
    axes.annotate(
        "sensor",
        (0, 0),
        xytext=(0, -8),
        textcoords="offset points",
        ha="center",
        va="top",
        fontsize=9,
        color=INK,
        zorder=6,
        annotation_clip=True,
        bbox={"facecolor": PAPER, "edgecolor": "none", "alpha": 0.75, "pad": 0.8},
    )


def _coloured(
    cloud: ArrayLike,
    view: str,
    values: ArrayLike | None,
    span: tuple[float, float] | None,
    label: str | None,
    level: float | None,
    title: str | None,
    limits: ArrayLike | None,
    axes: Axes | None,
) -> Axes:
    cloud = as_cloud(cloud)
    if values is None:
        values, label, span = cloud[:, 2], label or "height z (m)", span or HEIGHTS
    values = as_values(values, len(cloud))
    across, up, across_label, up_label = project(cloud, view)
    axes = canvas(axes)
    # A level below or above all points belongs into the picture, too.
    levels = [] if level is None else [float(level)]
    frame(axes, across, np.append(up, levels), limits, equal=view != "side")
    rows, remark = drawn_rows(axes, across, up)
    low, high, extend = _colour_range(values, span)
    size = marker_size(len(rows))
    points = axes.scatter(
        across[rows],
        up[rows],
        c=values[rows],
        s=size**2,
        cmap=COLOURS,
        vmin=low,
        vmax=high,
        linewidths=0,
        # The smooth edge of a small dot cannot be seen, but it triples the size of the file.
        antialiased=size >= 2.5,
        plotnonfinite=True,
        rasterized=True,
    )
    _colour_bar(axes, points, label, extend)
    for height in levels:
        _mark_level(axes, height)
    mark_sensor(axes)
    note(axes, remark)
    return finish(axes, title, across_label, up_label)


def _colour_range(values: np.ndarray, span: tuple[float, float] | None) -> tuple[float, float, str]:
    """Return low, high and the ends that stick out: a few stray values must not grey the rest."""
    values = values[np.isfinite(values)]
    if not len(values):
        return *(span or (0.0, 1.0)), "neither"
    low, high = span or np.percentile(values, [1, 99])
    if low == high:
        low, high = values.min(), values.max()
    if low == high:
        return low - 0.5, high + 0.5, "neither"
    below, above = values.min() < low, values.max() > high
    return low, high, ("neither", "min", "max", "both")[int(below) + 2 * int(above)]


def _colour_bar(axes: Axes, points: PathCollection, label: str | None, extend: str) -> None:
    # Placed relative to the axes, it stays as high as they are when their aspect is fixed.
    place = axes.inset_axes((1.02, 0, 0.022, 1))
    bar = axes.figure.colorbar(points, cax=place, extend=extend)
    bar.outline.set_visible(False)
    bar.ax.tick_params(colors=MUTED, labelcolor=INK, labelsize=9.5, length=3, width=0.6)
    bar.set_label(label or "", color=INK, fontsize=10.5)


def _mark_level(axes: Axes, level: float) -> None:
    low, high = sorted(axes.get_ylim())
    if not low <= level <= high:
        return
    axes.axhline(level, color=VERMILION, linewidth=1.6, linestyle="--", zorder=5)
    axes.annotate(
        f"z = {number(level)} m",
        (0.005, level),
        xycoords=axes.get_yaxis_transform(),
        xytext=(4, 3),
        textcoords="offset points",
        ha="left",
        va="bottom",
        fontsize=10,
        color=INK,
        zorder=7,
        bbox={"facecolor": PAPER, "edgecolor": "none", "alpha": 0.85, "pad": 1.0},
    )
