"""Figures of clusters: labelled points, neighbour graphs, and the growth of a cluster."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from utils.plots.annotations import write_names, write_point_names
from utils.plots.arguments import (
    as_cloud,
    as_labels,
    as_names,
    drawn_rows,
    is_in_view,
    marker_size,
    project,
)
from utils.plots.clouds import dots, mark_sensor
from utils.plots.style import (
    BLUE,
    INK,
    MARKERS,
    MUTED,
    PALE,
    PALETTE,
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

MAX_NAMES = 12

UNTOUCHED, WAITING, DONE = 0, 1, 2
"""States of a point in :func:`growth`: not reached yet, in the queue, finished."""


@styled
def clusters(
    cloud: ArrayLike,
    labels: ArrayLike,
    *,
    view: str = "above",
    names: bool = False,
    like: ArrayLike | None = None,
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw each cluster with its own pair of colour and marker, and noise as pale crosses.

    Seven colours and six markers give 42 different pairs; a label always has the same pair.

    Parameters
    ----------
    cloud : (n, 2), (n, 3) or (n, 4) array_like of float
        In metres; two columns for points in the plane.
    labels : (n,) array_like of int
        1 and above for clusters; 0 (or less) for noise.
    view : {"above", "side", "side to scale"}
    names : bool
        Write the label next to each of the twelve biggest clusters in view.
    like : (n,) array_like of int, optional
        Labels of the same points in another figure. Clusters that share most of their points get
        the same colour in both figures.
    title, limits, axes
        As in :func:`utils.plots.from_above`.
    """
    cloud = as_cloud(cloud, planar=True)
    labels = as_labels(labels, len(cloud))
    across, up, across_label, up_label = project(cloud, view)
    axes = canvas(axes)
    frame(axes, across, up, limits, equal=view != "side")
    rows, remark = drawn_rows(axes, across, up)
    shown = labels if like is None else renumber_like(labels, as_labels(like, len(cloud), "like"))
    draw_labels(axes, across[rows], up[rows], shown[rows])
    if cloud.shape[1] > 2:
        mark_sensor(axes)
    count, noise = len(np.unique(labels[labels > 0])), np.count_nonzero(labels <= 0)
    key(axes, counted(count, "cluster"))  # without a marker, because clusters differ in colour
    if noise:
        key(axes, counted(noise, "noise point"), "x", colour=PALE)
    note(axes, remark)
    if names:
        _write_names(axes, across, up, labels)
    return finish(axes, title, across_label, up_label)


def draw_labels(axes: Axes, across: np.ndarray, up: np.ndarray, labels: np.ndarray) -> None:
    """Draw valid points with the colour and marker of their label."""
    size = marker_size(len(labels))
    noise = labels <= 0
    dots(axes, across[noise], up[noise], "x", PALE, size * 0.8, zorder=1.5)
    # Drawing one artist per pair, rather than per cluster, is fast for hundreds of clusters.
    pair = np.where(noise, -1, (labels - 1) % (len(PALETTE) * len(MARKERS)))
    for number in np.unique(pair[~noise]):
        chosen = pair == number
        marker, colour = MARKERS[number % len(MARKERS)], PALETTE[number % len(PALETTE)]
        dots(axes, across[chosen], up[chosen], marker, colour, size * 1.15)


def count_overlaps(
    first: np.ndarray, second: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the labels of both arrays (n,), and the number of points with each pair of labels.

    Labels of noise count as 0. The counts have one row per label in `first` and one column per
    label in `second`.
    """
    rows, row_of = np.unique(np.maximum(first, 0), return_inverse=True)
    columns, column_of = np.unique(np.maximum(second, 0), return_inverse=True)
    counts = np.zeros((len(rows), len(columns)), dtype=int)
    np.add.at(counts, (row_of, column_of), 1)
    return rows, columns, counts


def renumber_like(yours: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """Renumber `yours` like `expected`, matching the biggest overlaps first.

    Noise stays 0. Clusters without a partner get labels that `expected` does not use.
    """
    rows, columns, counts = count_overlaps(yours, expected)
    pairs = np.argwhere(counts > 0)
    pairs = pairs[np.argsort(-counts[tuple(pairs.T)], kind="stable")]
    new_labels, taken = {0: 0}, {0}
    for row, column in pairs:
        yours_label, expected_label = int(rows[row]), int(columns[column])
        if yours_label not in new_labels and expected_label not in taken:
            new_labels[yours_label] = expected_label
            taken.add(expected_label)
    unused = max(columns, default=0) + 1
    for yours_label in rows.tolist():
        if yours_label not in new_labels:
            new_labels[yours_label] = unused
            unused += 1
    return np.array([new_labels[label] for label in np.maximum(yours, 0).tolist()], dtype=int)


def _write_names(axes: Axes, across: np.ndarray, up: np.ndarray, labels: np.ndarray) -> None:
    visible = is_in_view(axes, across, up)
    places, labels = np.stack([across, up], axis=1)[visible], labels[visible]
    found, counts = np.unique(labels[labels > 0], return_counts=True)
    largest = found[np.argsort(-counts, kind="stable")[:MAX_NAMES]]
    regions = [
        (own.min(axis=0), own.max(axis=0)) for own in (places[labels == label] for label in largest)
    ]
    write_names(axes, regions, [str(label) for label in largest], places)


@styled
def graph(
    cloud: ArrayLike,
    edges: ArrayLike = (),
    *,
    view: str = "above",
    labels: ArrayLike | None = None,
    names: bool | Sequence[str] = False,
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw points and the edges between neighbours, which join close points into one cluster.

    The figure is readable for up to a few hundred points.

    Parameters
    ----------
    cloud : (n, 2), (n, 3) or (n, 4) array_like of float
        In metres.
    edges : (m, 2) array_like of int
        The two rows of `cloud` that each edge joins.
    view : {"above", "side", "side to scale"}
    labels : (n,) array_like of int, optional
        Colour and marker as in :func:`clusters`.
    names : bool or sequence of str
        Names to write at the points; True for the row numbers.
    title, limits, axes
        As in :func:`utils.plots.from_above`.
    """
    cloud = as_cloud(cloud, planar=True)
    labels = np.ones(len(cloud), int) if labels is None else as_labels(labels, len(cloud))
    names = as_names(names, len(cloud), "point")
    edges = _as_edges(edges, len(cloud))
    across, up, across_label, up_label = project(cloud, view)
    axes = canvas(axes)
    frame(axes, across, up, limits, equal=view != "side")
    ends = np.stack([across[edges], up[edges]], axis=-1)
    ends = ends[np.isfinite(ends).all(axis=(1, 2))]
    axes.add_collection(LineCollection(ends, colors=MUTED, linewidths=1.0, zorder=1), autolim=False)
    draw_labels(axes, across, up, labels)
    if names:
        write_point_names(axes, np.stack([across, up], axis=1), names)
    key(axes, counted(len(edges), "pair") + " of neighbours", colour=MUTED, line="-")
    return finish(axes, title, across_label, up_label)


def _as_edges(edges: ArrayLike, count: int) -> np.ndarray:
    edges = np.asarray(edges)
    if edges.size == 0:
        return np.empty((0, 2), dtype=int)
    if edges.ndim != 2 or edges.shape[1] != 2 or not np.issubdtype(edges.dtype, np.integer):
        raise ValueError(
            "edges must be an array of whole numbers of shape (m, 2), with the two rows that each "
            f"edge joins; yours has shape {edges.shape} and dtype {edges.dtype}."
        )
    if edges.min() < 0 or edges.max() >= count:
        raise ValueError(f"edges must contain row numbers from 0 to {count - 1}.")
    return edges


@styled
def growth(
    cloud: ArrayLike,
    frames_of_labels: Iterable[ArrayLike],
    *,
    titles: Sequence[str] | None = None,
    names: Sequence[str] = ("untouched", "waiting in the queue", "done"),
    columns: int = 4,
    view: str = "above",
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Sequence[Axes] | np.ndarray | None = None,
) -> np.ndarray:
    """Draw the growth of a cluster, with one small panel per step.

    Parameters
    ----------
    cloud : (n, 2), (n, 3) or (n, 4) array_like of float
        In metres.
    frames_of_labels : sequence of (n,) array_like of int
        For each step, the state of each point: 0 untouched, 1 waiting in the queue, 2 done.
    titles : sequence of str, optional
        One per step; by default "step 0", "step 1" and so on.
    names : (str, str, str)
        Names of the three states in the legend; only used for a new figure.
    columns : int
        Number of panels side by side; only used for a new figure.
    view : {"above", "side", "side to scale"}
    title : str, optional
        Title of the whole figure; only used for a new figure.
    limits : optional
        As in :func:`utils.plots.from_above`; the same for all panels.
    axes : sequence of matplotlib.axes.Axes, optional
        One per step.

    Returns
    -------
    (steps,) array of matplotlib.axes.Axes
        One per panel.
    """
    cloud = as_cloud(cloud, planar=True)
    frames = [
        as_labels(frame_labels, len(cloud), f"frames_of_labels[{step}]")
        for step, frame_labels in enumerate(frames_of_labels)
    ]
    titles = [f"step {step}" for step in range(len(frames))] if titles is None else list(titles)
    if len(titles) != len(frames):
        raise ValueError(
            f"titles must contain one title per step: {len(frames)} titles, not {len(titles)}."
        )
    own_figure = axes is None
    columns = min(columns, max(1, len(frames)))
    rows = -(-len(frames) // columns)
    size = (WIDTH, max(1, rows) * (0.9 + WIDTH / max(columns, 2)))
    axes = panels(len(frames), axes, columns=columns, size=size)
    across, up, across_label, up_label = project(cloud, view)
    size = 1.2 * marker_size(len(cloud))
    state_styles = (
        (UNTOUCHED, "o", PALE, 0.7),
        (WAITING, "^", VERMILION, 1.3),
        (DONE, "s", BLUE, 1.0),
    )
    for panel, states, panel_title in zip(axes, frames, titles, strict=True):
        frame(panel, across, up, limits, equal=view != "side")
        for state, marker, colour, scale in state_styles:
            chosen = states == state
            dots(panel, across[chosen], up[chosen], marker, colour, size * scale)
        finish(panel, panel_title, across_label, up_label)
    if own_figure and len(axes):
        for panel in axes:
            panel.label_outer()
        figure = axes[0].figure
        if title:
            figure.suptitle(title, x=0.01, ha="left", color=INK, fontsize=12, fontweight="bold")
        entries = zip(names, state_styles, strict=True)
        shared_legend(figure, axes[0], [(name, style[1], style[2]) for name, style in entries])
    return axes


def shared_legend(figure: Figure, axes: Axes, entries: Sequence[tuple[str, str, str]]) -> None:
    """Draw one legend below all panels of `figure`, with entries `(name, marker, colour)`."""
    lines = [
        axes.plot([], [], linestyle="none", marker=marker, color=colour, markersize=6)[0]
        for _, marker, colour in entries
    ]
    figure.legend(
        lines, [name for name, _, _ in entries], loc="outside lower center", ncols=len(entries)
    )
