"""Planes a x + b y + c z + d = 0; the normal (a, b, c) may have any length."""

import math

import numpy as np


def distances_from_plane(points: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """Return the distance of each point from a plane; shape (n,)."""
    gaps = np.asarray(points, dtype=float)[:, :3] @ plane[:3] + plane[3]
    return np.abs(gaps) / np.linalg.norm(plane[:3])


def best_plane(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the least-squares plane of some points, and their root mean square distance from it.

    Parameters
    ----------
    points : numpy.ndarray, shape (n, 3) or (n, 4)

    Returns
    -------
    plane : numpy.ndarray, shape (4,)
        Computed from the covariance matrix; its normal has length 1.
    distance : float
        In the unit of the points.
    """
    centre, variances, directions = principal_components(points)
    return plane_through_point(centre, directions[:, 0]), math.sqrt(max(variances[0], 0.0))


def principal_components(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the mean of points, and their principal variances (ascending) and axes (columns)."""
    xyz = np.asarray(points, dtype=float)[:, :3]
    centre = xyz.mean(axis=0)
    return centre, *np.linalg.eigh((xyz - centre).T @ (xyz - centre) / len(xyz))


def plane_through_point(point: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return the plane, shape (4,), through a point, shape (3,), with a normal, shape (3,)."""
    return np.append(normal, -normal @ point)


def with_unit_normal(plane: np.ndarray) -> np.ndarray:
    """Return the same plane, shape (4,), scaled so that its normal has length 1."""
    return plane / np.linalg.norm(plane[:3])
