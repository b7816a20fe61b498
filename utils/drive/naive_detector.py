"""The naive detector of lesson 12: an obstacle is a square metre with something in it."""

from __future__ import annotations

import numpy as np


def occupied_squares(cloud: np.ndarray, ground_level: float = -1.2) -> np.ndarray:
    """Boxes (N, 8, 3) over all square metres with at least five returns above a level.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
    ground_level : float
        Metres, the scanner at 0.
    """
    above = cloud[cloud[:, 2] > ground_level]
    squares, count = np.unique(np.floor(above[:, :2]), axis=0, return_counts=True)
    unit = np.array([[0, 0, -1.7], [1, 0, -1.7], [1, 1, -1.7], [0, 1, -1.7]])
    unit = np.vstack([unit, unit + [0, 0, 1.5]])
    return np.insert(squares[count >= 5], 2, 0.0, axis=1)[:, None] + unit
