"""Figures of run time against the number of points, with a fitted power."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import EngFormatter, LogLocator, NullFormatter
from numpy.typing import ArrayLike

from utils.plots.style import INK, MARKERS, MUTED, PALETTE, canvas, finish, styled


@styled
def timing(
    series: Mapping[str, tuple[ArrayLike, ArrayLike]],
    *,
    fit: bool = True,
    title: str | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw run time against the number of points on logarithmic axes.

    On such axes, a power n^k is a straight line whose slope is the exponent k.

    Parameters
    ----------
    series : dict of str to (n, seconds)
        For each name, the numbers of points and the run times, in arrays of equal length.
    fit : bool
        Draw the fitted power as a dashed line, and add its exponent to the legend, as in
        "naive: n^2.0".
    title : str, optional
    axes : matplotlib.axes.Axes, optional
    """
    axes = canvas(axes)
    axes.set_xscale("log")
    axes.set_yscale("log")
    ends = []
    for index, (name, measured) in enumerate(series.items()):
        n, seconds = _measurements(name, measured)
        colour, marker = PALETTE[index % len(PALETTE)], MARKERS[index % len(MARKERS)]
        label = name
        fitted = fit and len(np.unique(n)) > 1
        if fitted:
            exponent, offset = np.polyfit(np.log(n), np.log(seconds), 1)
            span = np.array([n.min(), n.max()])
            label = f"{name}: n^{exponent:.1f}"
            axes.plot(
                span, np.exp(offset) * span**exponent, color=colour, linewidth=1.2, linestyle="--"
            )
        axes.plot(
            n,
            seconds,
            color=colour,
            marker=marker,
            markersize=7,
            linestyle="none" if fitted else "-",
            linewidth=1.2,
            label=label,
        )
        if len(n):
            last = np.argmax(n)
            ends.append((n[last], seconds[last], name))
    _write_series_names(axes, ends)
    _format_ticks(axes)
    return finish(axes, title, "number of points n", "time")  # the tick labels include the unit


def _measurements(
    name: str, measured: tuple[ArrayLike, ArrayLike]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the measurements for which n and seconds are finite and positive."""
    try:
        n, seconds = (np.asarray(part, dtype=float).ravel() for part in measured)
        valid = len(n) == len(seconds)
    except (TypeError, ValueError):
        valid = False
    if not valid:
        raise ValueError(
            f'series["{name}"] must be a pair (n, seconds) of two lists of numbers of equal length.'
        )
    usable = np.isfinite(n) & np.isfinite(seconds) & (n > 0) & (seconds > 0)
    return n[usable], seconds[usable]


def _write_series_names(axes: Axes, ends: list[tuple[float, float, str]]) -> None:
    """Write each name next to the end of its series, and move names apart that would overlap."""
    if not ends:
        return
    axes.margins(x=0.06, y=0.1)
    axes.autoscale_view()
    heights = axes.transAxes.inverted().transform(
        axes.transData.transform([(n, seconds) for n, seconds, _ in ends])
    )[:, 1]
    previous = -np.inf
    for position in np.argsort(heights):
        n, seconds, name = ends[position]
        previous = max(heights[position], previous + 0.06)
        axes.annotate(
            name,
            (n, seconds),
            xytext=(1.01, previous),
            textcoords="axes fraction",
            ha="left",
            va="center",
            fontsize=10,
            color=INK,
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": MUTED, "linewidth": 0.5, "shrinkB": 5},
        )


def _format_ticks(axes: Axes) -> None:
    """Format tick labels as 200, 1 k or 10 ms; on short axes add ticks at steps of 2 and 5."""
    for axis, (low, high), unit in (
        (axes.xaxis, axes.get_xlim(), ""),
        (axes.yaxis, axes.get_ylim(), "s"),
    ):
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 100 * low else (1,)))
        axis.set_major_formatter(EngFormatter(unit=unit))
        axis.set_minor_formatter(NullFormatter())
