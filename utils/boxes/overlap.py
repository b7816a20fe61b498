"""Overlap of boxes, in the plane and in space.

Boxes are arrays (N, 8, 3), turned about z only. The four corners of the floor come first, in any
order, and then the four corners of the roof.
"""

from __future__ import annotations

import numpy as np

ROUNDING = 1e-9
"""Area in square metres that two boxes can share by rounding alone."""


def plane_iou(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the intersection over union of the boxes' footprints.

    Parameters
    ----------
    boxes : ndarray, shape (N, 8, 3)
        Corners in metres.
    others : ndarray, shape (M, 8, 3)

    Returns
    -------
    ndarray, shape (N, M)
        From 0 (apart, touching, or without area) to 1 (equal).

    Raises
    ------
    ValueError
        If an array does not have the shape (N, 8, 3).
    """
    return _iou_of_sizes(*_areas(_as_boxes(boxes), _as_boxes(others)))


def space_iou(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the intersection over union of the boxes' volumes.

    Parameters, result and errors are the same as for `plane_iou`.
    """
    boxes, others = _as_boxes(boxes), _as_boxes(others)
    floor, roof = boxes[:, :, 2].min(axis=1), boxes[:, :, 2].max(axis=1)
    other_floor, other_roof = others[:, :, 2].min(axis=1), others[:, :, 2].max(axis=1)
    rise = np.minimum(roof[:, None], other_roof) - np.maximum(floor[:, None], other_floor)
    shared, areas, other_areas = _areas(boxes, others)
    return _iou_of_sizes(
        shared * np.maximum(rise, 0.0),
        areas * (roof - floor),
        other_areas * (other_roof - other_floor),
    )


def _as_boxes(boxes: np.ndarray) -> np.ndarray:
    boxes = np.asarray(boxes, dtype=float)
    if boxes.size == 0:
        return boxes.reshape(0, 8, 3)
    if boxes.ndim != 3 or boxes.shape[1:] != (8, 3):
        raise ValueError(f"Boxes must have shape (N, 8, 3), not {boxes.shape}.")
    return boxes


def distances_between(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the distances in metres between the boxes' footprints; 0 if two overlap or touch.

    The boxes must have an area. Parameters, shape of the result and errors are the same as for
    `plane_iou`.
    """
    first, second = (footprints(_as_boxes(some)) for some in (boxes, others))
    gaps = np.minimum(
        _distances_to_sides(first[:, None], second[None, :]),
        _distances_to_sides(second[None, :], first[:, None]),
    )
    return np.where(_shared_areas(first, second) > ROUNDING, 0.0, gaps)


def footprints(boxes: np.ndarray) -> np.ndarray:
    """Return the convex hulls (N, 4, 2) of the floors of boxes (N, 8, 3), anticlockwise.

    If a hull is a triangle, one of its corners is repeated. The hull of a box with a non-finite
    corner is NaN.
    """
    floors = boxes[:, :4, :2]
    floors = np.where(np.isfinite(floors).all(axis=(1, 2), keepdims=True), floors, np.nan)
    offsets = floors - floors.mean(axis=1, keepdims=True)
    order = np.argsort(np.arctan2(offsets[..., 1], offsets[..., 0]), axis=1)
    corners = np.take_along_axis(floors, order[..., None], axis=1)
    before, after = np.roll(corners, 1, axis=1), np.roll(corners, -1, axis=1)
    is_inside_hull = _cross(corners - before, after - corners) < 0
    return np.where(is_inside_hull[..., None], before, corners)


def _areas(boxes: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the shared areas (N, M) of two lists of footprints, and their own areas."""
    first, second = footprints(boxes), footprints(others)
    return _shared_areas(first, second), _area(first), _area(second)


def _shared_areas(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the areas (N, M) that convex quadrilaterals (N, 4, 2) share with others (M, 4, 2)."""
    shared = np.zeros((len(first), len(second)))
    touch = (first.min(axis=1)[:, None] <= second.max(axis=1)) & (
        first.max(axis=1)[:, None] >= second.min(axis=1)
    )
    rows, columns = np.nonzero(touch.all(axis=2))
    if len(rows):
        area = _area(_clip(first[rows], second[columns]))
        # Clipping to a footprint without area removes nothing, so limit the shared area.
        shared[rows, columns] = np.minimum(
            area, np.minimum(_area(first)[rows], _area(second)[columns])
        )
    return shared


def _clip(polygons: np.ndarray, windows: np.ndarray) -> np.ndarray:
    """Return the parts of polygons (P, k, 2) inside convex, anticlockwise windows (P, 4, 2).

    Each corner beyond a side of the window moves to the line of the side, and corners are added
    where the outline crosses the line. On the line the outline may run back and forth, which does
    not change its area.
    """
    for start, end in zip(
        np.moveaxis(windows, 1, 0), np.moveaxis(np.roll(windows, -1, axis=1), 1, 0), strict=True
    ):
        along = (end - start)[:, None]
        length = np.hypot(along[..., 0], along[..., 1])
        left = np.stack([-along[..., 1], along[..., 0]], axis=-1)
        left = left / np.where(length > 0, length, 1.0)[..., None]
        depth = ((polygons - start[:, None]) * left).sum(axis=-1)
        moved = polygons - np.minimum(depth, 0.0)[..., None] * left
        following, following_depth = np.roll(polygons, -1, axis=1), np.roll(depth, -1, axis=1)
        crosses = depth * following_depth < 0
        fraction = depth / np.where(crosses, depth - following_depth, 1.0)
        crossings = polygons + fraction[..., None] * (following - polygons)
        added = np.where(crosses[..., None], crossings, moved)
        polygons = np.stack([moved, added], axis=2).reshape(len(polygons), -1, 2)
    return polygons


def _distances_to_sides(corners: np.ndarray, polygons: np.ndarray) -> np.ndarray:
    """Return the smallest distance from corners (..., 4, 2) to sides of polygons (..., 4, 2)."""
    start = polygons[..., None, :, :]
    along = np.roll(polygons, -1, axis=-2)[..., None, :, :] - start
    offsets = corners[..., :, None, :] - start
    squares = (along**2).sum(axis=-1)
    fraction = np.clip((offsets * along).sum(axis=-1) / np.where(squares > 0, squares, 1.0), 0, 1)
    return np.linalg.norm(offsets - fraction[..., None] * along, axis=-1).min(axis=(-2, -1))


def _area(polygons: np.ndarray) -> np.ndarray:
    """Return the areas of anticlockwise polygons (..., k, 2)."""
    around = polygons - polygons[..., :1, :]
    return _cross(around, np.roll(around, -1, axis=-2)).sum(axis=-1) / 2


def _cross(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]


def _iou_of_sizes(shared: np.ndarray, sizes: np.ndarray, other_sizes: np.ndarray) -> np.ndarray:
    union = sizes[:, None] + other_sizes[None, :] - shared
    return np.divide(shared, union, out=np.zeros_like(shared), where=union > 0)
