"""Arguments of plotting functions: checks of their shapes, and the choice of points to draw."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from utils.plots.style import counted

MAX_POINTS = 30_000
"""Clouds with more points are thinned for drawing, because further dots only hide each other."""

VIEWS = {
    "above": (0, 1, "x, forward (m)", "y, left (m)"),
    "side": (0, 2, "x, forward (m)", "z, up (m), stretched"),
    "side to scale": (0, 2, "x, forward (m)", "z, up (m)"),
}


def as_cloud(cloud: ArrayLike, *, planar: bool = False) -> np.ndarray:
    """Return `cloud` as a float array (n, 3) or (n, 4); `planar` also allows (n, 2)."""
    widths = (2, 3, 4) if planar else (3, 4)
    try:
        cloud = np.asarray(cloud, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(
            "A cloud must be a rectangular array of numbers with one row per point."
        ) from None
    if cloud.ndim == 2 and cloud.shape[1] in widths:
        return cloud
    allowed = " or ".join(f"(n, {width})" for width in widths)
    tip = ""
    if cloud.ndim == 2 and cloud.shape[0] in widths:
        tip = " It looks transposed: try cloud.T."
    elif cloud.ndim == 1 and len(cloud) in widths:
        tip = " For a single point use cloud[None, :]."
    raise ValueError(
        f"A cloud must have shape {allowed}, one row per point; yours has {cloud.shape}.{tip}"
    )


def as_points(points: ArrayLike, name: str = "points") -> np.ndarray:
    """Return two-dimensional `points` as a float array (n, 2)."""
    try:
        points = np.asarray(points, dtype=float)
    except (TypeError, ValueError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(
            f"{name} must have shape (n, 2), one row (x, y) per point; yours has {points.shape}."
        )
    return points


def as_mask(mask: ArrayLike, count: int, name: str = "keep") -> np.ndarray:
    """Return `mask` as a bool array (count,)."""
    mask = np.asarray(mask)
    if mask.size == 0:
        mask = mask.astype(bool)
    if mask.dtype != bool:
        raise ValueError(
            f"{name} must be a mask of True and False (dtype bool); yours has dtype {mask.dtype}."
        )
    return _check_length(mask, count, name)


def as_labels(labels: ArrayLike, count: int, name: str = "labels") -> np.ndarray:
    """Return `labels` as an int array (count,); any dtype is accepted if all numbers are whole."""
    labels = np.asarray(labels)
    try:
        with np.errstate(invalid="ignore"):
            whole = labels.astype(np.int64)
        is_whole = bool((whole == labels).all())
    except (TypeError, ValueError):
        is_whole = False
    if not is_whole:
        raise ValueError(f"{name} must be whole numbers; yours has dtype {labels.dtype}.")
    return _check_length(whole, count, name)


def as_values(values: ArrayLike, count: int, name: str = "values") -> np.ndarray:
    """Return `values` as a float array (count,)."""
    try:
        values = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be numbers, one per point.") from None
    return _check_length(values, count, name)


def as_names(names: bool | Sequence[str | int] | None, count: int, noun: str = "box") -> list[str]:
    """Return a name for each of `count` objects, or an empty list; True means the row numbers."""
    if names is None or names is False:
        return []
    texts = [str(name) for name in (range(count) if names is True else names)]
    if len(texts) != count:
        raise ValueError(
            f"names must contain one name per {noun}: {count} names, not {len(texts)}."
        )
    return texts


def _check_length(array: np.ndarray, count: int, name: str) -> np.ndarray:
    if array.shape != (count,):
        raise ValueError(
            f"{name} must have one entry per point: shape ({count},); yours has {array.shape}."
        )
    return array


def project(cloud: np.ndarray, view: str) -> tuple[np.ndarray, np.ndarray, str, str]:
    """Return the two columns of a cloud (..., k) that a view shows, and the labels of both axes."""
    if view not in VIEWS:
        raise ValueError(f'view must be "above", "side" or "side to scale"; yours is {view!r}.')
    if cloud.shape[-1] == 2:
        if view != "above":
            raise ValueError('Points of shape (n, 2) have no height: use view="above".')
        return cloud[..., 0], cloud[..., 1], "x (m)", "y (m)"
    first, second, across, up = VIEWS[view]
    return cloud[..., first], cloud[..., second], across, up


def drawn_rows(axes: Axes, across: np.ndarray, up: np.ndarray) -> tuple[np.ndarray, str]:
    """Choose the points to draw into the view of `axes`, and describe which points are left out.

    Points with a non-finite coordinate are left out. The others are divided into runs of k points,
    and one random point of each run is drawn. Taking exactly every k-th point could coincide with
    the order of the beams and drop most of them. Points inside and outside the view have
    different values of k, so a closer view shows more. Points outside are kept in case the view
    moves later.

    Returns
    -------
    rows : (m,) int array
        Rows to draw, ascending.
    remark : str
        Text for the corner of the figure; empty if all points are drawn.
    """
    finite = np.isfinite(across) & np.isfinite(up)
    inside = is_in_view(axes, across, up)
    rows, step = _thin(np.flatnonzero(inside))
    others, _ = _thin(np.flatnonzero(finite & ~inside))
    remarks = []
    if step > 1:
        remarks.append(f"1 of {step} points shown")
    missing = np.count_nonzero(~finite)
    if missing:
        remarks.append(f"{counted(missing, 'invalid row')} not shown")
    return np.sort(np.concatenate([rows, others])), " · ".join(remarks)


def is_in_view(axes: Axes, across: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return whether each point is in the visible region of `axes`; NaN is not."""
    return _is_between(across, axes.get_xlim()) & _is_between(up, axes.get_ylim())


def _is_between(values: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    low, high = sorted(limits)
    return (values >= low) & (values <= high)


def _thin(rows: np.ndarray) -> tuple[np.ndarray, int]:
    step = max(1, -(-len(rows) // MAX_POINTS))
    starts = np.arange(0, len(rows), step)
    offsets = np.random.default_rng(0).integers(step, size=len(starts))
    return rows[np.minimum(starts + offsets, len(rows) - 1)], step


def marker_size(count: int) -> float:
    """Return a marker size in typographic points, smaller for a cloud with more points."""
    return float(np.clip(22 / max(count, 1) ** 0.27, 1.4, 7.0))
