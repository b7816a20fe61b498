"""Planes a x + b y + c z + d = 0, whose normal (a, b, c) may have any length."""

import math

import numpy as np


def gaps_from(points: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """Distance of each point from a plane whose normal may have any length; shape (n,)."""
    gaps = np.asarray(points, dtype=float)[:, :3] @ plane[:3] + plane[3]
    return np.abs(gaps) / np.linalg.norm(plane[:3])


def best_plane(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Least-squares plane by the covariance matrix, and its root mean square distance.

    Parameters
    ----------
    points : numpy.ndarray, shape (n, 3) or (n, 4)

    Returns
    -------
    plane : numpy.ndarray, shape (4,)
    distance : float
    """
    centre, variances, directions = spread_of(points)
    return plane_at(centre, directions[:, 0]), math.sqrt(max(variances[0], 0.0))


def spread_of(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean of some points, and variances and directions (as columns) of their spread, rising."""
    xyz = np.asarray(points, dtype=float)[:, :3]
    centre = xyz.mean(axis=0)
    return centre, *np.linalg.eigh((xyz - centre).T @ (xyz - centre) / len(xyz))


def plane_at(place: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """The plane through a place, shape (3,), with a normal, shape (3,); shape (4,)."""
    return np.append(normal, -normal @ place)


def with_unit_normal(plane: np.ndarray) -> np.ndarray:
    """The same plane, all four numbers divided by the length of its normal; shape (4,)."""
    return plane / np.linalg.norm(plane[:3])
