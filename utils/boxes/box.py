"""The true box of an obstacle: kind, position, size and heading."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Box:
    """The true box of an obstacle that returned at least one echo, in sensor coordinates.

    Parameters
    ----------
    centre : tuple of float
        Centre (x, y, z) in metres.
    size : tuple of float
        Length, width, height in metres.
    yaw : float
        Direction of the length in radians, from the x axis towards y, in [-pi, pi).
    kind : str
        One of `utils.simulator.CLASSES`.
    identity : int
        ID of the obstacle, the same in every frame of a stream and in `Scan.objects`.
    velocity : tuple of float
        Velocity over the ground along the sensor's x and y axes, in m/s.
    returns : int
        Number of echoes in this frame.
    """

    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    yaw: float
    kind: str
    identity: int
    velocity: tuple[float, float] = (0.0, 0.0)
    returns: int = 0

    @property
    def corners(self) -> np.ndarray:
        """The corners, shape (8, 3): the floor anticlockwise from front left, then the roof."""
        signs = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) / 2
        half = self.size[2] / 2
        floor = np.column_stack([signs * self.size[:2], np.full(4, -half)])
        cosine, sine = math.cos(self.yaw), math.sin(self.yaw)
        x, y, z = np.vstack([floor, floor + (0, 0, 2 * half)]).T
        turned = np.column_stack([cosine * x - sine * y, sine * x + cosine * y, z])
        return turned + self.centre
