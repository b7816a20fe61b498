"""Compare results with the expected results: masks, labels and their confusion matrix."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from numpy.typing import ArrayLike

from utils.plots.arguments import as_cloud, as_labels, as_mask, drawn_rows, marker_size, project
from utils.plots.clouds import Group, draw_groups, mark_sensor
from utils.plots.clusters import count_overlaps, draw_labels, renumber_like
from utils.plots.style import (
    INK,
    PALE,
    SKY,
    VERMILION,
    WIDTH,
    canvas,
    counted,
    finish,
    frame,
    key,
    note,
    panels,
    styled,
)

RINGS_ACROSS = 24
MAX_CELLS = 12

# All colours are light enough for dark text.
CELL_COLOURS = ListedColormap(matplotlib.colormaps["Blues"](np.linspace(0, 0.55, 64)))


@styled
def difference(
    cloud: ArrayLike,
    yours_mask: ArrayLike,
    expected_mask: ArrayLike,
    *,
    view: str = "above",
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw the points that a filter wrongly keeps or removes, with counts.

    Parameters
    ----------
    cloud : (n, 3) or (n, 4) array_like of float
        In metres.
    yours_mask, expected_mask : (n,) array_like of bool
        True for the points that are kept.
    view : {"above", "side", "side to scale"}
    title, limits, axes
        As in :func:`utils.plots.from_above`.
    """
    cloud = as_cloud(cloud)
    yours = as_mask(yours_mask, len(cloud), "yours_mask")
    expected = as_mask(expected_mask, len(cloud), "expected_mask")
    groups = (
        Group("correctly removed", ~yours & ~expected, "x", PALE),
        Group("correctly kept", yours & expected, "o", SKY),
        Group("wrongly kept", yours & ~expected, "^", VERMILION, strong=True),
        Group("wrongly removed", ~yours & expected, "s", INK, strong=True),
    )
    return draw_groups(cloud, groups, view=view, title=title, limits=limits, axes=axes)


@styled
def worst(
    cloud: ArrayLike,
    labels_yours: ArrayLike,
    labels_expected: ArrayLike,
    *,
    view: str = "above",
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Sequence[Axes] | np.ndarray | None = None,
) -> np.ndarray:
    """Draw two labellings side by side, with rings around the points on which they differ.

    Clusters may be numbered differently. Each of your clusters is matched with the expected
    cluster that shares the most points with it, and takes that cluster's colour. Points outside
    these matches count as differences.

    Parameters
    ----------
    cloud : (n, 2), (n, 3) or (n, 4) array_like of float
        In metres.
    labels_yours, labels_expected : (n,) array_like of int
        1 and above for clusters; 0 or less for noise.
    view : {"above", "side", "side to scale"}
    title : str, optional
        Title above both panels; only used for a new figure.
    limits : optional
        As in :func:`utils.plots.from_above`; by default a region around the differing points.
    axes : two matplotlib.axes.Axes, optional

    Returns
    -------
    (2,) array of matplotlib.axes.Axes
        First your labels, then the expected ones.
    """
    cloud = as_cloud(cloud, planar=True)
    yours = as_labels(labels_yours, len(cloud), "labels_yours")
    expected = as_labels(labels_expected, len(cloud), "labels_expected")
    own_figure = axes is None
    axes = panels(2, axes, columns=2, size=(WIDTH, 4.2))
    across, up, across_label, up_label = project(cloud, view)
    relabelled = renumber_like(yours, expected)
    differs = np.flatnonzero(relabelled != np.maximum(expected, 0))
    focus = _region_around(across[differs], up[differs]) if len(differs) else (across, up)
    for panel, name, labels in ((axes[0], "yours", relabelled), (axes[1], "expected", expected)):
        frame(panel, *focus, limits, equal=view != "side")
        rows, remark = drawn_rows(panel, across, up)
        ringed = differs[_one_row_per_cell(panel, across[differs], up[differs])]
        draw_labels(panel, across[rows], up[rows], labels[rows])
        size = marker_size(len(rows)) + 5
        style = {"markerfacecolor": "none", "markeredgewidth": 1.2}
        panel.plot(across[ringed], up[ringed], "o", color=INK, markersize=size, zorder=5, **style)
        if cloud.shape[1] > 2:
            mark_sensor(panel)
        key(panel, f"differ: {len(differs):,}", "o", size=9, **style)
        key(panel, f"noise: {np.count_nonzero(labels <= 0):,}", "x", colour=PALE)
        note(panel, remark)
        count = counted(len(np.unique(labels[labels > 0])), "cluster")
        finish(panel, f"{name}: {count}", across_label, up_label)
    if own_figure and title:
        axes[0].figure.suptitle(title, x=0.01, ha="left", color=INK, fontsize=12, fontweight="bold")
    return axes


def _region_around(
    across: np.ndarray, up: np.ndarray
) -> np.ndarray | tuple[np.ndarray, np.ndarray]:
    """Return a region (2, 2) around points, with a margin of a quarter of its size or 2 metres.

    Without finite points, return the coordinates unchanged.
    """
    finite = np.isfinite(across) & np.isfinite(up)
    if not finite.any():
        return across, up
    spans = np.array([[part[finite].min(), part[finite].max()] for part in (across, up)])
    margin = np.maximum(0.25 * (spans[:, 1] - spans[:, 0]), 2.0)
    return np.stack([spans[:, 0] - margin, spans[:, 1] + margin], axis=1)


def _one_row_per_cell(axes: Axes, across: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Choose at most one point per cell of a grid over the view, so that rings do not overlap."""
    corner, far_corner = np.transpose([axes.get_xlim(), axes.get_ylim()])
    finite = np.flatnonzero(np.isfinite(across) & np.isfinite(up))
    places = (np.stack([across[finite], up[finite]], axis=1) - corner) / (far_corner - corner)
    _, first = np.unique(np.floor(places * RINGS_ACROSS), axis=0, return_index=True)
    return finite[first]


@styled
def label_confusion(
    true: ArrayLike, predicted: ArrayLike, *, title: str | None = None, axes: Axes | None = None
) -> Axes:
    """Draw the number of points with each pair of true and predicted labels.

    One filled cell in each row and column is a perfect match, even if the labels differ. Several
    filled cells in a row mean that a true cluster is split; several in a column, that clusters are
    merged.

    Parameters
    ----------
    true, predicted : (n,) array_like of int
        1 and above for clusters; 0 or less for noise. At most the twelve biggest of each are shown.
    title : str, optional
    axes : matplotlib.axes.Axes, optional
    """
    true = as_labels(true, len(np.atleast_1d(true)), "true")
    predicted = as_labels(predicted, len(true), "predicted")
    rows, columns, counts = count_overlaps(true, predicted)
    shown_rows = np.sort(np.argsort(-counts.sum(axis=1), kind="stable")[:MAX_CELLS])
    shown_columns = np.sort(np.argsort(-counts.sum(axis=0), kind="stable")[:MAX_CELLS])
    shown = counts[np.ix_(shown_rows, shown_columns)]
    axes = canvas(axes, size=(6.2, 5.0))
    axes.grid(False)
    if shown.size:
        axes.imshow(np.log1p(shown), cmap=CELL_COLOURS, vmin=0, aspect="auto")
    cell = axes.get_window_extent().width / axes.figure.dpi * 72 / max(1, shown.shape[1])
    for (row, column), count in np.ndenumerate(shown):
        if count:
            text = f"{count:,}" if count < 10_000 else f"{count / 1000:.0f}k"
            axes.text(
                column,
                row,
                text,
                ha="center",
                va="center",
                color=INK,
                fontsize=min(9.5, 1.5 * cell / len(text)),
            )
    for set_ticks, labels in (
        (axes.set_xticks, columns[shown_columns]),
        (axes.set_yticks, rows[shown_rows]),
    ):
        set_ticks(range(len(labels)), ["noise" if label == 0 else str(label) for label in labels])
    axes.tick_params(length=0)
    if shown.size < counts.size:
        title = (title or "") + f" (biggest {len(shown_rows)} × {len(shown_columns)})"
    return finish(axes, title, "predicted label", "true label")
