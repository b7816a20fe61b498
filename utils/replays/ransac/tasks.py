"""What RANSAC is asked for in lessons 02 and 03: small clouds, and what is drawn of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ROUNDS = 10
HAIR = 1e-3  # metres; single precision is finer


@dataclass(frozen=True)
class Task:
    """What is asked of a search, and how it is drawn.

    Attributes
    ----------
    search, through : str
        Names of the functions.
    model : str
        What is looked for.
    size : int
        Points in a sample, and coordinates of a point.
    points : numpy.ndarray
    tolerance : float
    seed : int
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
        """The points without what is no coordinate."""
        return self.points[:, : self.size]


def _twenty() -> np.ndarray:
    """The twenty points of lesson 02, to the centimetre."""
    rng, steps = np.random.default_rng(18), np.arange(-5, 5)
    wall = np.column_stack([steps, steps]) + rng.uniform(-0.6, 0.6, (10, 2))
    return np.round(np.vstack([wall, rng.uniform(-5, 5, (10, 2))]), 2)


def _street() -> np.ndarray:
    """A road that climbs, a car that stands on it, and a house front."""
    rng = np.random.default_rng(7)
    x, y = rng.uniform((-8, -4), (22, 4), (36, 2)).T
    road = np.column_stack([x, y, -1.7 + 0.015 * x + rng.normal(0, 0.03, 36)])
    car = rng.uniform((8, -1, -1.4), (12, 1, -0.2), (16, 3))
    front = rng.uniform((0, 4.95, -1.5), (16, 5.05, 0.9), (12, 3))
    xyz = np.vstack([road, car, front])
    return np.round(np.column_stack([xyz, rng.uniform(0.05, 0.95, len(xyz))]), 2)


LINE = Task("ransac_line", "line_through", "line", 2, _twenty(), 0.5, 3)
PLANE = Task("ransac_plane", "plane_through", "plane", 3, _street(), 0.2, 2)
