"""Figures of numbers: histograms, curves with measurements, and bars."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from utils.plots.arguments import as_values
from utils.plots.style import (
    BLUE,
    INK,
    MARKERS,
    PALETTE,
    PAPER,
    VERMILION,
    canvas,
    finish,
    note,
    number,
    styled,
)

MAX_ROWS_OF_NAMES = 6  # above a histogram
ROW_OF_NAMES = 0.09  # share of the height of the axes


@styled
def histogram(
    values: ArrayLike,
    *,
    bins: int | ArrayLike = 60,
    label: str | None = None,
    marks: Mapping[str, float] | None = None,
    title: str | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw a histogram.

    Parameters
    ----------
    values : (n,) array_like of float
        Non-finite values are left out; a note in the corner gives their number.
    bins : int or array_like of float
        Number of bins, or their edges.
    label : str, optional
        Name and unit of the values.
    marks : dict of str to float, optional
        Values to mark with vertical lines, by the name to write next to each line.
    title : str, optional
    axes : matplotlib.axes.Axes, optional
    """
    values = np.asarray(values, dtype=float).ravel()
    finite = values[np.isfinite(values)]
    axes = canvas(axes)
    if len(finite):
        axes.hist(finite, bins=bins, color=BLUE, edgecolor=PAPER, linewidth=0.3)
    axes.yaxis.set_major_formatter("{x:,.0f}")
    _draw_marks(axes, marks or {})
    missing = len(values) - len(finite)
    note(axes, f"{missing:,} not a number" if missing else "")
    axes.grid(False, axis="x")
    return finish(axes, title, label or "value", "number of points")


def _draw_marks(axes: Axes, marks: Mapping[str, float]) -> None:
    """Draw named vertical lines, with each name above the bars, on the side with more room."""
    marks = {name: float(value) for name, value in marks.items() if np.isfinite(value)}
    axes.set_ylim(top=axes.get_ylim()[1] / (1 - ROW_OF_NAMES * min(len(marks), MAX_ROWS_OF_NAMES)))
    for index, value in enumerate(marks.values()):
        dashes = ("--", "-.", ":")[index % 3]
        axes.axvline(value, color=VERMILION, linewidth=1.6, linestyle=dashes)
    borders = np.array([*axes.get_xlim(), *marks.values()])
    for index, (name, value) in enumerate(marks.items()):
        room_left = value - borders[borders < value].max(initial=-np.inf)
        room_right = borders[borders > value].min(initial=np.inf) - value
        left = room_left > room_right
        axes.annotate(
            f"{name}: {number(value)}",
            (value, 0.98 - ROW_OF_NAMES * (index % MAX_ROWS_OF_NAMES)),
            xycoords=axes.get_xaxis_transform(),
            xytext=(-5 if left else 5, 0),
            textcoords="offset points",
            ha="right" if left else "left",
            va="top",
            fontsize=10,
            color=INK,
            bbox={"facecolor": PAPER, "edgecolor": "none", "alpha": 0.85, "pad": 1.0},
        )


@styled
def curves(
    theory: Mapping[str, tuple[ArrayLike, ArrayLike]],
    measured: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    *,
    across: str | None = None,
    up: str | None = None,
    title: str | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw theoretical curves as lines, and measurements as markers.

    Parameters
    ----------
    theory : dict of str to (x, y)
        One line per name.
    measured : dict of str to (x, y), optional
        One set of markers per name. A name that is also in `theory` has the same colour in both.
    across, up : str, optional
        Names and units of the x axis and the y axis.
    title : str, optional
    axes : matplotlib.axes.Axes, optional
    """
    axes = canvas(axes)
    measured = measured or {}
    names = list(dict.fromkeys([*theory, *measured]))
    for index, name in enumerate(names):
        colour, marker = PALETTE[index % len(PALETTE)], MARKERS[index % len(MARKERS)]
        if name in theory:
            dashes = ("-", "--", "-.", ":")[index % 4]
            axes.plot(*theory[name], color=colour, linewidth=1.8, linestyle=dashes, label=name)
        if name in measured:
            label = f"{name}, measured" if name in theory else name
            axes.plot(
                *measured[name],
                color=colour,
                marker=marker,
                markersize=7,
                linestyle="none",
                label=label,
            )
    return finish(axes, title, across or "", up or "")


@styled
def compare(
    values: Mapping[str, float],
    *,
    label: str | None = None,
    title: str | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw named numbers as horizontal bars, with the number at the end of each bar.

    Parameters
    ----------
    values : dict of str to float
        One bar per entry, from top to bottom.
    label : str, optional
        Name and unit of the numbers.
    title : str, optional
    axes : matplotlib.axes.Axes, optional
    """
    lengths = as_values(list(values.values()), len(values))
    axes = canvas(axes, size=(8.5, 1.4 + 0.42 * max(1, len(values))))
    bars = axes.barh(list(values), np.nan_to_num(lengths), color=BLUE, height=0.62)
    axes.bar_label(bars, [number(length) for length in lengths], padding=4, color=INK)
    axes.margins(x=0.1)
    if len(values):
        axes.set_ylim(len(values) - 0.5, -0.5)
    axes.grid(False, axis="y")
    axes.tick_params(axis="y", length=0)
    return finish(axes, title, label or "", None)
