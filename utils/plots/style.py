"""The common style of all figures: palette, sizes, empty axes, legends and notes.

Settings apply to the axes of a figure, or only while a function draws. Importing or calling
:mod:`utils.plots` does not change the user's own ``rcParams``. The background is opaque and
light, so that figures look the same in light and dark notebooks.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any, ParamSpec, TypeVar

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from numpy.typing import ArrayLike

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

# Okabe and Ito's palette (https://jfly.uni-koeln.de/color/) is safe for colour-blind readers. Its
# yellow is left out, because small yellow points are invisible on white. Strong colours come first.
BLUE, VERMILION, GREEN = "#0072B2", "#D55E00", "#009E73"
PURPLE, ORANGE, SKY, BLACK = "#CC79A7", "#E69F00", "#56B4E9", "#000000"
PALETTE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)

# Six and seven have no common divisor, so markers and colours form 42 pairs before one repeats.
MARKERS = ("o", "^", "s", "D", "v", "P")

PAPER, INK, MUTED, PALE, GRID = "#FFFFFF", "#1B1F24", "#57606A", "#A8B0B8", "#E7E9EC"

# The bright end of plasma is invisible on white. Few colours keep the files small.
COLOURS = ListedColormap(matplotlib.colormaps["plasma"](np.linspace(0, 0.8, 32)))
COLOURS = COLOURS.with_extremes(bad=PALE)

TITLE = {"color": INK, "fontsize": 12, "fontweight": "bold"}
WIDTH, HEIGHT = 8.5, 4.8  # inches; WIDTH fits the output of a notebook
MAX_POINTS_WITH_OUTLIERS = 5_000  # points; in larger clouds, `frame` may cut off outliers

STYLE = {
    "figure.facecolor": PAPER,
    "savefig.facecolor": "auto",
    "savefig.transparent": False,
    "axes.facecolor": PAPER,
    "axes.unicode_minus": True,
    "font.size": 10.5,
    "text.color": INK,
    "text.usetex": False,
    "legend.frameon": True,
    "legend.facecolor": PAPER,
    "legend.edgecolor": "none",
    "legend.framealpha": 0.9,
    "legend.fontsize": 10,
    "legend.labelcolor": INK,
    "lines.markeredgewidth": 0.8,
    "path.effects": [],
    "hatch.linewidth": 0.6,
}


def styled(draw: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Decorate a function to draw in the course's style and then restore the user's settings.

    If the function fails, the figures that it opened are closed; a notebook would show them empty.
    """

    @functools.wraps(draw)
    def wrapper(*arguments: Arguments.args, **options: Arguments.kwargs) -> Result:
        figures = plt.get_fignums()
        settings = {name: matplotlib.rcParams[name] for name in STYLE}
        try:
            matplotlib.rcParams.update(STYLE)
            return draw(*arguments, **options)
        except Exception:
            for opened in set(plt.get_fignums()).difference(figures):
                plt.close(opened)
            raise
        finally:
            # A notebook changes settings when it opens its first figure. `rc_context` would undo
            # these changes, and later figures would not be shown.
            matplotlib.rcParams.update(settings)

    return wrapper


def canvas(axes: Axes | None = None, *, size: tuple[float, float] = (WIDTH, HEIGHT)) -> Axes:
    """Return `axes` in the course's style, or the axes of a new figure of notebook width."""
    if axes is None:
        _, axes = plt.subplots(figsize=size, layout="compressed")
    if not isinstance(axes, Axes):
        raise TypeError(
            f"axes must be one matplotlib Axes, not {type(axes).__name__}. "
            "With figure, panels = plt.subplots(1, 2), pass panels[0]."
        )
    axes.figure.set_facecolor(PAPER)
    axes.set_facecolor(PAPER)
    axes.set_axisbelow(True)
    axes.grid(True, color=GRID, linewidth=0.7, linestyle="-")
    axes.tick_params(
        which="both", direction="out", width=0.6, colors=MUTED, labelcolor=INK, labelsize=9.5
    )
    axes.tick_params(which="major", length=3)
    for side, spine in axes.spines.items():
        spine.set(visible=side in ("left", "bottom"), color=MUTED, linewidth=0.6)
    return axes


def panels(
    count: int,
    axes: Sequence[Axes] | np.ndarray | None = None,
    *,
    columns: int,
    size: tuple[float, float] | None = None,
) -> np.ndarray:
    """Return `count` axes in the course's style as a flat array; new axes form a grid."""
    if axes is None:
        rows = -(-max(count, 1) // columns)
        figure, grid = plt.subplots(
            rows, columns, figsize=size or (WIDTH, 3.0 * rows), layout="compressed", squeeze=False
        )
        figure.set_facecolor(PAPER)
        for unused in grid.flat[count:]:
            unused.set_axis_off()
        axes = grid.flat[:count]
    axes = np.atleast_1d(np.asarray(axes, dtype=object)).ravel()
    if len(axes) != count:
        raise ValueError(f"axes must contain one Axes per panel: {count} axes, not {len(axes)}.")
    for panel in axes:
        canvas(panel)
    return axes


def frame(
    axes: Axes,
    across: ArrayLike,
    up: ArrayLike,
    limits: ArrayLike | None = None,
    *,
    equal: bool = True,
) -> None:
    """Fix the visible region before anything is drawn.

    `limits` set the region if they are given. Otherwise axes that already show something keep their
    view, so that figures can be drawn on top of each other. Empty axes get a region that contains
    the points and fills the axes. In a large cloud the outermost 1 % along each axis may be cut
    off, because a few distant returns would make everything else tiny.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    across, up : (n,) array_like of float
        Coordinates along the horizontal and the vertical axis.
    limits : ((low, high), (low, high)) or (low, high, low, high), optional
        Horizontal limits, then vertical ones.
    equal : bool
        Use the same scale in both directions. If false, no heights are cut off.
    """
    if equal:
        # The top edges of panels in a row are then at the same height, like their titles.
        axes.set_aspect("equal", adjustable="box", anchor="N")
    if limits is not None:
        spans = spans_from_limits(limits)
    elif axes.has_data():
        return
    else:
        spans = np.array([_padded_span(across), _padded_span(up, keep_all=not equal)])
        if equal:
            window = axes.get_window_extent()
            shape = np.array([window.width, window.height]) / max(window.height, 1)
            half = np.max((spans[:, 1] - spans[:, 0]) / shape) * shape / 2
            middle = spans.mean(axis=1)
            spans = np.stack([middle - half, middle + half], axis=1)
    axes.set_xlim(*spans[0])
    axes.set_ylim(*spans[1])


def spans_from_limits(limits: ArrayLike) -> np.ndarray:
    """Return limits in either notation as a (2, 2) array, or raise ValueError with the format."""
    try:
        spans = np.asarray(limits, dtype=float).reshape(2, 2)
    except (TypeError, ValueError):
        spans = np.full((2, 2), np.nan)
    if not np.isfinite(spans).all() or (spans[:, 0] == spans[:, 1]).any():
        raise ValueError(
            "limits must be ((low, high), (low, high)) in metres, first horizontally and then "
            f"vertically, for example ((-20, 40), (-10, 10)); yours is {limits!r}."
        )
    return spans


def _padded_span(values: ArrayLike, *, keep_all: bool = False) -> tuple[float, float]:
    """Return (low, high) around the finite values, with a margin; the width is never zero."""
    values = np.asarray(values, dtype=float)
    values = values[np.isfinite(values)]
    if not len(values):
        return -10.0, 10.0
    low, high = values.min(), values.max()
    if len(values) > MAX_POINTS_WITH_OUTLIERS and not keep_all:
        low, high = np.percentile(values, [0.5, 99.5])
    margin = max(0.07 * (high - low), 0.5 if low == high else 0.0)
    return low - margin, high + margin


def key(
    axes: Axes,
    label: str,
    marker: str = "",
    *,
    colour: str = INK,
    line: str = "none",
    size: float = 6.0,
    **options: Any,
) -> None:
    """Add an entry to the legend that :func:`finish` draws, by plotting a line without points."""
    axes.plot(
        [], [], marker=marker, color=colour, linestyle=line, markersize=size, label=label, **options
    )


def finish(
    axes: Axes, title: str | None = None, across: str | None = None, up: str | None = None
) -> Axes:
    """Add title, axis labels and legend; the legend is between title and axes, clear of the data.

    Arguments that are None leave the existing title or label unchanged.
    """
    if across is not None:
        axes.set_xlabel(across, color=INK, fontsize=10.5)
    if up is not None:
        axes.set_ylabel(up, color=INK, fontsize=10.5)
    handles, labels = axes.get_legend_handles_labels()
    rows = 0
    if labels:
        width = axes.get_window_extent().width / axes.figure.dpi
        # The width of a legend entry is about 0.5 inches plus 0.085 inches per letter.
        widths = [0.5 + 0.085 * len(label) for label in labels]
        columns = len(labels) if sum(widths) < width else max(1, int(width / max(widths)))
        columns = min(columns, len(labels))
        rows = -(-len(labels) // columns)
        axes.legend(
            handles,
            labels,
            loc="lower left",
            bbox_to_anchor=(0, 1),
            ncols=columns,
            borderaxespad=0.2,
            borderpad=0.2,
            handletextpad=0.3,
            columnspacing=1.2,
        )
    title = axes.get_title(loc="left") if title is None else title
    axes.set_title(title, loc="left", pad=7 + 17 * rows, **TITLE)
    _level_titles(axes)
    return axes


def _level_titles(axes: Axes) -> None:
    """Raise the titles of all panels in the row of `axes` to the highest one.

    A legend with several rows raises the title of its panel, but not those of the other panels. A
    panel whose legend was removed stays as it is, because its title may already have been lowered.
    """
    place = axes.get_subplotspec()
    if place is None:
        return
    pads = {}  # points between each panel and its title
    for panel in axes.figure.axes:
        spec = panel.get_subplotspec()
        in_row = spec and spec.get_gridspec() is place.get_gridspec()
        in_row = in_row and spec.rowspan == place.rowspan and panel.get_title(loc="left")
        if in_row and (panel.get_legend() or not panel.get_legend_handles_labels()[1]):
            pads[panel] = panel.titleOffsetTrans.transform((0, 0))[1] * 72 / panel.figure.dpi
    for panel, pad in pads.items():
        if pad < max(pads.values()) - 0.5:
            panel.set_title(
                panel.get_title(loc="left"), loc="left", pad=max(pads.values()), **TITLE
            )


def number(value: float) -> str:
    """Return a number as text with four significant digits and a real minus sign.

    A number of thousands, millions or billions is rounded to a whole number, as in "58,658".
    """
    text = f"{value:,.0f}" if 1e3 <= abs(value) < 1e12 else f"{value:.4g}"
    return text.replace("-", "−")


def counted(count: int, noun: str) -> str:
    """Return a count with its noun, as in "1 cluster" or "2 clusters"."""
    return f"{count:,} {noun}" + ("" if count == 1 else "s")


def note(axes: Axes, text: str) -> None:
    """Write a note into the lower right corner, such as the number of points left out."""
    if text:
        axes.text(
            0.995,
            0.01,
            text,
            transform=axes.transAxes,
            ha="right",
            va="bottom",
            fontsize=9,
            color=MUTED,
            zorder=9,
            bbox={"facecolor": PAPER, "edgecolor": "none", "alpha": 0.85, "pad": 1.5},
        )
