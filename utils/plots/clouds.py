"""Figures of whole clouds: from above, from the side, and with kept and removed points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from numpy.typing import ArrayLike

from utils.plots.arguments import (
    as_cloud,
    as_mask,
    as_values,
    drawn_rows,
    is_in_view,
    marker_size,
    project,
)
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
    """Draw a cloud from above, to scale: x (forward) to the right, y (left) upwards.

    Parameters
    ----------
    cloud : (n, 3) or (n, 4) array_like of float
        x forward, y left and z up, in metres; a fourth column is ignored. Rows with a non-finite
        coordinate are left out, and clouds of more than 30 000 points are thinned. A note in the
        corner mentions both.
    values : (n,) array_like of float, optional
        Values that the colours show; by default the height.
    span : (float, float), optional
        Values at both ends of the colour scale; by default percentiles 1 and 99 of the visible
        points. Figures with the same span have the same colours.
    label : str, optional
        Name and unit of `values`, written next to the colour bar.
    title : str, optional
    limits : ((x_low, x_high), (y_low, y_high)) or four numbers, optional
        Visible region in metres. By default the current view of `axes`, or else the whole cloud.
        In a cloud of more than 5 000 points the outermost 1 % along each axis may be cut off.
    axes : matplotlib.axes.Axes, optional
        Axes to draw into; by default a new figure.

    Raises
    ------
    ValueError
        A shape is wrong; the message gives the expected one.
    """
    return _draw_coloured(cloud, "above", values, span, label, None, title, limits, axes)


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
    """Draw a cloud from its right-hand side: x (forward) to the right, z upwards.

    Heights are stretched to fill the figure, because a scan is about a hundred times longer than
    it is high. The label of the axis mentions this.

    Parameters
    ----------
    cloud, values, span, label, title, axes
        As in :func:`from_above`.
    level : float, optional
        Height in metres of a horizontal line, such as the ground level.
    to_scale : bool
        Use the same scale for both axes, without stretching.
    limits : ((x_low, x_high), (z_low, z_high)) or four numbers, optional
        Visible region in metres.
    """
    view = "side to scale" if to_scale else "side"
    return _draw_coloured(cloud, view, values, span, label, level, title, limits, axes)


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
    """Draw the points that a filter keeps (blue dots) and removes (pale crosses), with counts.

    Parameters
    ----------
    cloud : (n, 3) or (n, 4) array_like of float
        In metres; see :func:`from_above`.
    keep : (n,) array_like of bool
        True for the points that the filter keeps.
    view : {"above", "side", "side to scale"}
    title, limits, axes
        As in :func:`from_above`.
    """
    cloud = as_cloud(cloud)
    keep = as_mask(keep, len(cloud))
    groups = (Group("removed", ~keep, "x", PALE), Group("kept", keep, "o", BLUE))
    return draw_groups(cloud, groups, view=view, title=title, limits=limits, axes=axes)


class Group(NamedTuple):
    """Points of a cloud that share a marker and a colour.

    Attributes
    ----------
    name : str
        Entry in the legend.
    mask : ndarray of bool, shape (n,)
        True for the points of the cloud that belong to the group.
    marker, colour : str
        In matplotlib's notation.
    strong : bool
        Whether to draw the points larger and never thin them.
    """

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
    """Draw groups of points of a valid cloud; the last group is on top and first in the legend."""
    across, up, across_label, up_label = project(cloud, view)
    axes = canvas(axes)
    frame(axes, across, up, limits, equal=view != "side")
    rows, remark = drawn_rows(axes, across, up)
    size = marker_size(len(rows))
    for group in groups:
        chosen = np.flatnonzero(group.mask) if group.strong else rows[group.mask[rows]]
        # Strong points are drawn above the symbol of the sensor.
        scale, layer = (max(1.6, 4.0 / size), 7) if group.strong else (1.0, 2)
        style = group.marker, group.colour, size * scale
        dots(axes, across[chosen], up[chosen], *style, zorder=layer)
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
    """Draw markers of one colour as one rasterised artist, which is fast even for many points."""
    # A cross has no area to fill, so it needs a wider stroke and a little more room than a dot.
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
    """Mark the sensor at the origin with a triangle that points forward, to the right."""
    style = {"color": PAPER, "markeredgecolor": INK, "markeredgewidth": 1.2, "zorder": 6}
    axes.plot(0, 0, marker=">", markersize=8, **style)
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


def _draw_coloured(
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
        values, label = cloud[:, 2], label or "height z (m)"
    values = as_values(values, len(cloud))
    across, up, across_label, up_label = project(cloud, view)
    axes = canvas(axes)
    # A level below or above all points must also be visible.
    levels = [] if level is None else [float(level)]
    frame(axes, across, np.append(up, levels), limits, equal=view != "side")
    rows, remark = drawn_rows(axes, across, up)
    low, high, extend = _colour_range(values[is_in_view(axes, across, up)], span)
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
        # A smooth edge is invisible on a small dot but triples the file size.
        antialiased=size >= 2.5,
        plotnonfinite=True,
        rasterized=True,
    )
    _colour_bar(axes, points, label, extend)
    for height in levels:
        mark_level(axes, height)
    mark_sensor(axes)
    note(axes, remark)
    return finish(axes, title, across_label, up_label)


def _colour_range(values: np.ndarray, span: tuple[float, float] | None) -> tuple[float, float, str]:
    """Return both ends of the colour scale, and which of the ends some values exceed.

    By default, the scale covers percentiles 1 to 99, so that a few stray values do not use up the
    colours.
    """
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
    # As an inset, the colour bar is as high as the axes even if their aspect is fixed.
    place = axes.inset_axes((1.02, 0, 0.022, 1))
    bar = axes.figure.colorbar(points, cax=place, extend=extend)
    bar.outline.set_visible(False)
    bar.ax.tick_params(colors=MUTED, labelcolor=INK, labelsize=9.5, length=3, width=0.6)
    bar.set_label(label or "", color=INK, fontsize=10.5)


def mark_level(axes: Axes, level: float) -> None:
    """Draw a labelled horizontal line at a height, if the height is in view."""
    low, high = sorted(axes.get_ylim())
    if not low <= level <= high:
        return
    axes.axhline(level, color=VERMILION, linewidth=1.6, linestyle="--", zorder=5)
    axes.annotate(
        f"z = {number(level)} m",
        (0.995, level),
        xycoords=axes.get_yaxis_transform(),
        xytext=(-4, -3),
        textcoords="offset points",
        ha="right",
        va="top",
        fontsize=10,
        color=INK,
        zorder=7,
        bbox={"facecolor": PAPER, "edgecolor": "none", "alpha": 0.85, "pad": 1.0},
    )
