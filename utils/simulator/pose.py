"""Where something stands and which way it faces."""

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
        """Points (..., 3) given in this pose's own frame, in the outer frame."""
        return self.rotate(points) + (self.x, self.y, self.z)

    def rotate(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors (..., 3) turned by the heading, not shifted."""
        cosine, sine = math.cos(self.yaw), math.sin(self.yaw)
        turned = np.array(vectors, dtype=float)
        x, y = turned[..., 0], turned[..., 1]
        turned[..., 0], turned[..., 1] = cosine * x - sine * y, sine * x + cosine * y
        return turned

    def inverse(self) -> Pose:
        """The pose of the outer frame seen from this one."""
        cosine, sine = math.cos(self.yaw), math.sin(self.yaw)
        return Pose(
            -cosine * self.x - sine * self.y, sine * self.x - cosine * self.y, -self.z, -self.yaw
        )

    def then(self, inner: Pose) -> Pose:
        """The pose, in the outer frame, of something whose pose in this frame is `inner`."""
        x, y, z = self.apply(np.array([inner.x, inner.y, inner.z])).tolist()
        return Pose(x, y, z, self.yaw + inner.yaw)
