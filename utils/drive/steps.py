"""Ready-made steps of a detector, for driving when you have written only one step yourself.

The ready-made steps use libraries, and none of them solves an exercise. Replace any of them with
your own function:

>>> detect = chain(ground=lambda points: filter_ground(points, -1.2))
>>> drive_street(6, detect)
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

EGO = np.array([(-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)])
REGION = np.array([(-5.0, -6.0, -2.5), (35.0, 9.2, 1.0)])
"""Opposite corners of the box of the ego car's returns, and of the region to search, in metres."""


def chain(
    *,
    region: Callable | None = None,
    ground: Callable | None = None,
    cluster: Callable | None = None,
    keep: Callable | None = None,
    boxes: Callable | None = None,
    voxel: float = 0.2,
) -> Callable[[np.ndarray], np.ndarray]:
    """Build a detector from your own steps and ready-made ones.

    Parameters
    ----------
    region, ground : callable, optional
        Takes points (n, 3) and returns the points to keep.
    cluster : callable, optional
        Takes points and returns labels (n,), from 1 up.
    keep : callable, optional
        Takes labels and returns labels, with 0 for each point of a cluster to drop.
    boxes : callable, optional
        Takes points and labels, and returns corners (N, 8, 3).
    voxel : float
        Side of the voxels in metres; one point per voxel is kept.

    Returns
    -------
    callable
        Detector for `drive_street`: takes a cloud (n, 4) and returns boxes (N, 8, 3).
    """
    region, ground, cluster = (
        region or _crop_region_ahead,
        ground or _remove_road,
        cluster or _label_touching_points,
    )
    keep, boxes = keep or _keep_large_clusters, boxes or fit_upright_boxes

    def detect(cloud: np.ndarray) -> np.ndarray:
        xyz = cloud[:, :3]
        own = ((xyz >= EGO[0]) & (xyz <= EGO[1])).all(axis=1)
        lost = ~np.isfinite(xyz).all(axis=1) | (np.abs(xyz).max(axis=1) == 0)
        points = ground(region(xyz[~own & ~lost]))
        cells = np.unique(np.floor(points / voxel), axis=0, return_index=True)[1]
        points = points[np.sort(cells)]
        return boxes(points, keep(cluster(points))) if len(points) else np.empty((0, 8, 3))

    return detect


def askew(detect: Callable, degrees: float) -> Callable[[np.ndarray], np.ndarray]:
    """Adapt a detector to a scanner that is mounted at an angle on the roof.

    Parameters
    ----------
    detect : callable
        Takes a cloud and returns boxes, both in the axes of the rotated scanner.
    degrees : float
        Rotation of the scanner to the left.

    Returns
    -------
    callable
        Takes a cloud and returns boxes in the axes of the car.
    """
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])

    def turned(cloud: np.ndarray) -> np.ndarray:
        found = detect(np.column_stack([cloud[:, :3] @ turn, cloud[:, 3]]))
        return np.reshape(found, (-1, 8, 3)) @ turn.T

    return turned


def _crop_region_ahead(points: np.ndarray) -> np.ndarray:
    return points[((points > REGION[0]) & (points < REGION[1])).all(axis=1)]


def _remove_road(points: np.ndarray) -> np.ndarray:
    return points[~is_road(points)]


def is_road(points: np.ndarray) -> np.ndarray:
    """Return whether each point (n, 3) is at most 0.3 m from the road.

    The road is a plane, which is refitted to the low points near it. If there are hardly any low
    points, no point is on the road.
    """
    near = points[:, 2] < -1.0
    for tolerance in (0.6, 0.3, 0.2):
        if near.sum() < 3:
            return np.zeros(len(points), bool)
        flat = np.column_stack([points[:, :2], np.ones(len(points))])
        plane = np.linalg.lstsq(flat[near], points[near, 2], rcond=None)[0]
        off = points[:, 2] - flat @ plane
        near = np.abs(off) < tolerance
    return np.abs(off) <= 0.3


def _label_touching_points(points: np.ndarray) -> np.ndarray:
    """Label the groups of points that are connected by steps of at most 0.5 m."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(0.5, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), (len(points), len(points)))
    return connected_components(graph, directed=False)[1] + 1


def _keep_large_clusters(labels: np.ndarray) -> np.ndarray:
    return labels * (np.bincount(labels) >= 10)[labels]


def fit_upright_boxes(points: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """Return axis-aligned boxes around the clusters, computed by a library."""
    from scipy.spatial import cKDTree

    found = []
    for label in np.unique(labels[labels > 0]):
        tree = cKDTree(points[labels == label])
        (west, south, low), (east, north, high) = tree.mins, tree.maxes
        floor = ((west, south), (east, south), (east, north), (west, north))
        found.append([(*corner, z) for z in (low, high) for corner in floor])
    return np.reshape(found, (-1, 8, 3)).astype(float)
