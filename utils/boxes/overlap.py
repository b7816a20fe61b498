"""Overlap of boxes, in the plane and in space.

Boxes are arrays (N, 8, 3), turned about z only. The four corners of the floor come first, in any
order, and then the four corners of the roof.
"""

from __future__ import annotations

import numpy as np


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


def _areas(boxes: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the shared areas of footprints (N, M), and the areas of each list, (N,) and (M,)."""
    import shapely  # a slow import that only comparisons need

    first, second = _footprints(boxes), _footprints(others)
    shared = np.zeros((len(first), len(second)))
    rows, columns = shapely.STRtree(second).query(first)
    shared[rows, columns] = shapely.area(shapely.intersection(first[rows], second[columns]))
    return shared, shapely.area(first), shapely.area(second)


def _footprints(boxes: np.ndarray) -> np.ndarray:
    """Return footprints as Shapely geometries (N,), or None for a box with a non-finite corner."""
    import shapely

    floors = boxes[:, :4, :2]
    finite = np.isfinite(floors).all(axis=(1, 2))
    footprints = np.full(len(boxes), None)
    # A convex hull accepts corners in any order. If a box has no width, the hull has no area.
    footprints[finite] = shapely.convex_hull(shapely.multipoints(floors[finite]))
    return footprints


def _iou_of_sizes(shared: np.ndarray, sizes: np.ndarray, other_sizes: np.ndarray) -> np.ndarray:
    union = sizes[:, None] + other_sizes[None, :] - shared
    return np.divide(shared, union, out=np.zeros_like(shared), where=union > 0)
