"""Position and heading of an object."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Pose:
    """A position in metres and a heading in radians, anticlockwise from the x axis."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    yaw: float = 0.0

    def apply(self, points: np.ndarray) -> np.ndarray:
        """Transform points (..., 3) from this pose's own frame to the outer frame."""
        return self.rotate(points) + (self.x, self.y, self.z)

    def rotate(self, vectors: np.ndarray) -> np.ndarray:
        """Rotate vectors (..., 3) by the heading, without a shift."""
        cosine, sine = math.cos(self.yaw), math.sin(self.yaw)
        turned = np.array(vectors, dtype=float)
        x, y = turned[..., 0], turned[..., 1]
        turned[..., 0], turned[..., 1] = cosine * x - sine * y, sine * x + cosine * y
        return turned

    def inverse(self) -> Pose:
        """Return the pose of the outer frame in this pose's own frame."""
        cosine, sine = math.cos(self.yaw), math.sin(self.yaw)
        return Pose(
            -cosine * self.x - sine * self.y, sine * self.x - cosine * self.y, -self.z, -self.yaw
        )

    def then(self, inner: Pose) -> Pose:
        """Return the outer-frame pose of an object that has pose `inner` in this pose's frame."""
        x, y, z = self.apply(np.array([inner.x, inner.y, inner.z])).tolist()
        return Pose(x, y, z, self.yaw + inner.yaw)
