"""Tasks for the replays of lessons 02 and 03: small clouds and the arguments of the search."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ROUNDS = 10
ROUNDING = 1e-3  # metres; single precision is finer


@dataclass(frozen=True)
class Task:
    """Points and arguments of a search.

    Attributes
    ----------
    search, through : str
        Names of the student's functions: the search, and the model through a sample.
    model : str
        Kind of model, "line" or "plane".
    size : int
        Number of points in a sample, and of coordinates per point.
    points : numpy.ndarray
        Cloud with one row per point.
    tolerance : float
        Threshold for inliers, in metres.
    seed : int
        Random seed for the search.
    """

    search: str
    through: str
    model: str
    size: int
    points: np.ndarray
    tolerance: float
    seed: int

    @property
    def xyz(self) -> np.ndarray:
        """Coordinates of the points, shape (n, size), without further columns."""
        return self.points[:, : self.size]


def _twenty_points() -> np.ndarray:
    """Return the twenty points of lesson 02, rounded to the centimetre."""
    rng, steps = np.random.default_rng(18), np.arange(-5, 5)
    wall = np.column_stack([steps, steps]) + rng.uniform(-0.6, 0.6, (10, 2))
    return np.round(np.vstack([wall, rng.uniform(-5, 5, (10, 2))]), 2)


def _street() -> np.ndarray:
    """Return points of a climbing road, a car on it and a house front."""
    rng = np.random.default_rng(7)
    x, y = rng.uniform((-8, -4), (22, 4), (36, 2)).T
    road = np.column_stack([x, y, -1.7 + 0.015 * x + rng.normal(0, 0.03, 36)])
    car = rng.uniform((8, -1, -1.4), (12, 1, -0.2), (16, 3))
    front = rng.uniform((0, 4.95, -1.5), (16, 5.05, 0.9), (12, 3))
    xyz = np.vstack([road, car, front])
    return np.round(np.column_stack([xyz, rng.uniform(0.05, 0.95, len(xyz))]), 2)


LINE = Task("ransac_line", "line_through", "line", 2, _twenty_points(), 0.5, 3)
PLANE = Task("ransac_plane", "plane_through", "plane", 3, _street(), 0.2, 2)
