"""One look for every figure: palette, sizes, empty axes, legends and notes.

Every setting is made on the axes being drawn into, or only while a function draws: importing or
calling :mod:`utils.plots` leaves the reader's own ``rcParams`` as they were. The background is
opaque and light, so that a figure reads the same in a light and in a dark notebook.
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

# Okabe and Ito's colour-blind-safe palette (https://jfly.uni-koeln.de/color/), without its yellow,
# which small points on white do not show, and with the strongest colours first.
BLUE, VERMILION, GREEN = "#0072B2", "#D55E00", "#009E73"
PURPLE, ORANGE, SKY, BLACK = "#CC79A7", "#E69F00", "#56B4E9", "#000000"
PALETTE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)

# Six markers and seven colours have no common divisor: 42 pairs before one comes again.
MARKERS = ("o", "^", "s", "D", "v", "P")

PAPER, INK, MUTED, PALE, GRID = "#FFFFFF", "#1B1F24", "#57606A", "#A8B0B8", "#E7E9EC"

# The bright end of plasma is left out: it would vanish on paper. Few steps keep the files small.
COLOURS = ListedColormap(matplotlib.colormaps["plasma"](np.linspace(0, 0.8, 32)))
COLOURS = COLOURS.with_extremes(bad=PALE)

WIDTH, HEIGHT = 8.5, 4.8  # inches: the width of a notebook's output
MANY = 5_000  # points, from which on a single one no longer counts

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
    """Decorate a function: it draws with the course's settings and gives the reader's back.

    When it fails, the figure that it may have opened is closed: a notebook would show it empty.
    """

    @functools.wraps(draw)
    def drawn(*arguments: Arguments.args, **options: Arguments.kwargs) -> Result:
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
            # Not rc_context: a notebook makes settings of its own when it opens its first figure,
            # and rc_context would take those back, so that no later figure were shown.
            matplotlib.rcParams.update(settings)

    return drawn


def canvas(axes: Axes | None = None, *, size: tuple[float, float] = (WIDTH, HEIGHT)) -> Axes:
    """Return `axes` in the course's look, or the axes of a new figure of notebook width."""
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
    """Return `count` axes in the course's look, in rows of `columns`, as a flat array."""
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
        raise ValueError(f"axes must hold one Axes per panel: {count}, not {len(axes)}.")
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

    Given `limits` win; axes that already show something keep their view, so that figures can be
    laid over each other; otherwise the region holds the points and fills the axes. Of a big cloud
    it leaves the outermost hundredth in each direction outside, as a few far returns would make
    everything else tiny.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    across, up : (n,) array_like of float
        Coordinates along the two axes.
    limits : ((low, high), (low, high)) or (low, high, low, high), optional
        Across, then up.
    equal : bool
        One metre is equally long in both directions.
    """
    if equal:
        axes.set_aspect("equal", adjustable="box")
    if limits is not None:
        spans = _spans_of(limits)
    elif axes.has_data():
        return
    else:
        spans = np.array([_span(across), _span(up, all_of_it=not equal)])
        if equal:
            window = axes.get_window_extent()
            shape = np.array([window.width, window.height]) / max(window.height, 1)
            half = np.max((spans[:, 1] - spans[:, 0]) / shape) * shape / 2
            middle = spans.mean(axis=1)
            spans = np.stack([middle - half, middle + half], axis=1)
    axes.set_xlim(*spans[0])
    axes.set_ylim(*spans[1])


def _spans_of(limits: ArrayLike) -> np.ndarray:
    """Return limits in either notation as a (2, 2) array; a sentence for anything else."""
    try:
        spans = np.asarray(limits, dtype=float).reshape(2, 2)
    except (TypeError, ValueError):
        spans = np.full((2, 2), np.nan)
    if not np.isfinite(spans).all() or (spans[:, 0] == spans[:, 1]).any():
        raise ValueError(
            "limits must be ((low, high), (low, high)), across and then up, in metres, "
            f"for example ((-20, 40), (-10, 10)); yours is {limits!r}."
        )
    return spans


def _span(values: ArrayLike, *, all_of_it: bool = False) -> tuple[float, float]:
    """Return (low, high) around the finite values, with a margin and never of zero width."""
    values = np.asarray(values, dtype=float)
    values = values[np.isfinite(values)]
    if not len(values):
        return -10.0, 10.0
    low, high = values.min(), values.max()
    if len(values) > MANY and not all_of_it:
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
    """Add an entry to the legend that :func:`finish` draws: a line without points."""
    axes.plot(
        [], [], marker=marker, color=colour, linestyle=line, markersize=size, label=label, **options
    )


def finish(
    axes: Axes, title: str | None = None, across: str | None = None, up: str | None = None
) -> Axes:
    """Write title and axis labels; put the legend between title and axes, where no data are."""
    if across is not None:
        axes.set_xlabel(across, color=INK, fontsize=10.5)
    if up is not None:
        axes.set_ylabel(up, color=INK, fontsize=10.5)
    handles, labels = axes.get_legend_handles_labels()
    rows = 0
    if labels:
        width = axes.get_window_extent().width / axes.figure.dpi
        # A legend entry is about 0.5 in of marker and gap, and 0.085 in for each letter.
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
    axes.set_title(title, loc="left", color=INK, fontsize=12, fontweight="bold", pad=7 + 17 * rows)
    return axes


def number(value: float) -> str:
    """Return a number as text, short and with a real minus sign."""
    return f"{value:.4g}".replace("-", "−")


def counted(count: int, noun: str) -> str:
    """Return "1 cluster", "2 clusters"."""
    return f"{count:,} {noun}" + ("" if count == 1 else "s")


def note(axes: Axes, text: str) -> None:
    """Write what the picture leaves out into the lower right corner."""
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
