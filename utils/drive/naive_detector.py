"""The naive detector from lesson 12: a square metre with returns above ground is an obstacle."""

from __future__ import annotations

import numpy as np


def occupied_squares(cloud: np.ndarray, ground_level: float = -1.2) -> np.ndarray:
    """Return boxes (N, 8, 3) over all square metres with at least five returns above a level.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        Points in metres, with the scanner at the origin.
    ground_level : float
        Height in metres relative to the scanner.
    """
    above = cloud[cloud[:, 2] > ground_level]
    squares, count = np.unique(np.floor(above[:, :2]), axis=0, return_counts=True)
    unit = np.array([[0, 0, -1.7], [1, 0, -1.7], [1, 1, -1.7], [0, 1, -1.7]])
    unit = np.vstack([unit, unit + [0, 0, 1.5]])
    return np.insert(squares[count >= 5], 2, 0.0, axis=1)[:, None] + unit
