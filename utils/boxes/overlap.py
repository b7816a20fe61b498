"""How much boxes overlap, in the plane and in space.

Boxes are arrays (N, 8, 3), turned about z only: four corners of the floor in any order, then
the four of the roof.
"""

from __future__ import annotations

import numpy as np


def plane_iou(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Intersection over union of the boxes' footprints.

    Parameters
    ----------
    boxes : ndarray, shape (N, 8, 3)
    others : ndarray, shape (M, 8, 3)

    Returns
    -------
    ndarray, shape (N, M)
        From 0 (apart, touching, or flat) to 1 (the same).

    Raises
    ------
    ValueError
        If an array is not (N, 8, 3).
    """
    boxes, others = _checked(boxes), _checked(others)
    shared = _shared_area(boxes, others)
    return _over_union(shared, _area(_footprints(boxes)), _area(_footprints(others)))


def space_iou(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Intersection over union of the boxes' volumes; see `plane_iou`."""
    boxes, others = _checked(boxes), _checked(others)
    floor, roof = boxes[:, :, 2].min(axis=1), boxes[:, :, 2].max(axis=1)
    other_floor, other_roof = others[:, :, 2].min(axis=1), others[:, :, 2].max(axis=1)
    rise = np.minimum(roof[:, None], other_roof) - np.maximum(floor[:, None], other_floor)
    shared = _shared_area(boxes, others) * np.maximum(rise, 0.0)
    volumes = _area(_footprints(boxes)) * (roof - floor)
    other_volumes = _area(_footprints(others)) * (other_roof - other_floor)
    return _over_union(shared, volumes, other_volumes)


def _checked(boxes: np.ndarray) -> np.ndarray:
    boxes = np.asarray(boxes, dtype=float)
    if boxes.size == 0:
        return boxes.reshape(0, 8, 3)
    if boxes.ndim != 3 or boxes.shape[1:] != (8, 3):
        raise ValueError(f"Boxes are arrays of shape (N, 8, 3); this one has {boxes.shape}.")
    return boxes


def _footprints(boxes: np.ndarray) -> np.ndarray:
    """Floor corners (N, 4, 2), anticlockwise."""
    floors = boxes[:, :4, :2]
    return _anticlockwise(floors)


def _anticlockwise(points: np.ndarray) -> np.ndarray:
    """Points (N, k, 2) sorted by their angle around their mean."""
    offsets = points - points.mean(axis=1, keepdims=True)
    order = np.argsort(np.arctan2(offsets[..., 1], offsets[..., 0]), axis=1, kind="stable")
    return np.take_along_axis(points, order[..., None], axis=1)


def _area(polygons: np.ndarray) -> np.ndarray:
    """Areas (N,) of anticlockwise polygons (N, k, 2): the shoelace formula."""
    if not len(polygons):
        return np.zeros(0)
    # Near the origin the products lose fewer digits.
    x, y = np.moveaxis(polygons - polygons[:, :1], -1, 0)
    return np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1) / 2


def _over_union(shared: np.ndarray, sizes: np.ndarray, other_sizes: np.ndarray) -> np.ndarray:
    union = sizes[:, None] + other_sizes[None, :] - shared
    return np.divide(shared, union, out=np.zeros_like(shared), where=union > 0)


def _shared_area(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Area (N, M) common to two sets of footprints.

    The common part of two rectangles is the convex hull of the corners of each that lie in the
    other and of the points where their edges cross.
    """
    shared = np.zeros((len(boxes), len(others)))
    first, second = _footprints(boxes), _footprints(others)
    if not shared.size:
        return shared
    rows, columns = np.nonzero(_close_enough(first, second))
    if not len(rows):
        return shared
    centre = first[rows].mean(axis=1, keepdims=True)
    first, second = first[rows] - centre, second[columns] - centre
    crossings, crossed = _edge_crossings(first, second)
    points = np.concatenate([first, second, crossings], axis=1)
    valid = np.concatenate([_inside(first, second), _inside(second, first), crossed], axis=1)
    # Repeating a valid point in place of an invalid one leaves the hull as it is.
    stand_in = points[np.arange(len(points)), np.argmax(valid, axis=1)]
    points = np.where(valid[..., None], points, stand_in[:, None])
    area = _area(_anticlockwise(points))
    # A point or a line holds everything for `_inside`; no more is shared than there is.
    most = np.minimum(_area(first), _area(second))
    shared[rows, columns] = np.where(valid.any(axis=1), np.clip(area, 0.0, most), 0.0)
    return shared


def _close_enough(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Pairs (N, M) of polygons whose bounding rectangles meet."""
    low, high = first.min(axis=1)[:, None], first.max(axis=1)[:, None]
    return np.all((low <= second.max(axis=1)) & (high >= second.min(axis=1)), axis=2)


def _inside(points: np.ndarray, polygons: np.ndarray) -> np.ndarray:
    """Which points (K, p, 2) lie in or on the anticlockwise polygons (K, q, 2): (K, p)."""
    edges = np.roll(polygons, -1, axis=1) - polygons
    offsets = points[:, :, None] - polygons[:, None]
    left = edges[:, None, :, 0] * offsets[..., 1] - edges[:, None, :, 1] * offsets[..., 0]
    slack = 1e-9 * np.abs(edges).sum(axis=2)[:, None]
    return np.all(left >= -slack, axis=2)


def _edge_crossings(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where edges cross: points (K, 16, 2), and which of them exist (K, 16)."""
    start, along = first[:, :, None], (np.roll(first, -1, axis=1) - first)[:, :, None]
    other, across = second[:, None], (np.roll(second, -1, axis=1) - second)[:, None]
    offset = other - start
    twist = along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (offset[..., 0] * across[..., 1] - offset[..., 1] * across[..., 0]) / twist
        t = (offset[..., 0] * along[..., 1] - offset[..., 1] * along[..., 0]) / twist
    crossed = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    points = start + np.where(crossed, s, 0.0)[..., None] * along
    return points.reshape(len(first), -1, 2), crossed.reshape(len(first), -1)
