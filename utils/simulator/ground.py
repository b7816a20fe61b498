r"""Ground: a straight road with slope, crown and kerbs, or an open plane.

In a cross-section of the road, the two lanes fall slightly from the middle to a kerb on either
side. Behind the kerb a pavement rises outwards:

    \__                          __/
       |____------^^^------____|
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from utils.simulator.pose import Pose
from utils.simulator.shapes import Material


@dataclass(frozen=True)
class Ground:
    """An endless straight road with a pavement on either side.

    Parameters
    ----------
    pose : Pose
        A point on the crown of the road, and the road's heading.
    slope : float
        Rise per metre along the road.
    width : float
        Distance from kerb to kerb in metres; infinite for an open plane.
    crown : float
        Fall per metre from the middle of the road to the kerb.
    kerb : float
        Height of the kerb in metres.
    pavement_slope : float
        Outward rise of the pavement per metre.
    material : Material
    """

    pose: Pose = Pose()
    slope: float = 0.0
    width: float = math.inf
    crown: float = 0.0
    kerb: float = 0.0
    pavement_slope: float = 0.0
    material: Material = Material(reflectivity=0.36)

    def height(self, x: float | np.ndarray, y: float | np.ndarray) -> np.ndarray:
        """Return the height of the ground at (x, y), in metres; arrays are broadcast."""
        along, across = self._road_coordinates(np.asarray(x, float), np.asarray(y, float))
        aside, half = np.abs(across), self.width / 2
        road = -self.crown * aside
        if math.isfinite(half):
            pavement = self.kerb - self.crown * half + self.pavement_slope * (aside - half)
            road = np.where(aside <= half, road, pavement)
        return self.pose.z + self.slope * along + road

    def seen_from(self, vehicle: Pose) -> Ground:
        """Return the ground in the frame of a vehicle on it, with height 0 at the origin."""
        outer = replace(vehicle, z=float(self.height(vehicle.x, vehicle.y))).inverse()
        return replace(self, pose=outer.then(self.pose))

    def crossings(
        self, rays: np.ndarray, origin: tuple[float, float, float]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Find the first intersection of each ray with the ground.

        Parameters
        ----------
        rays : ndarray, shape (3, ...)
            Unit directions.
        origin : tuple of float
            Starting point of all rays, in metres.

        Returns
        -------
        distance, cosine : ndarray, shape rays.shape[1:]
            Distance in metres, infinite for a ray that misses the ground, and cosine of the angle
            of incidence.
        """
        cosine_yaw, sine_yaw = math.cos(self.pose.yaw), math.sin(self.pose.yaw)
        along = cosine_yaw * rays[0] + sine_yaw * rays[1]
        across = cosine_yaw * rays[1] - sine_yaw * rays[0]
        start_along, start_across = self._road_coordinates(*origin[:2])
        start_height = origin[2] - self.pose.z - self.slope * start_along
        climb = rays[2] - self.slope * along  # relative to the road, per metre of ray

        distance = np.full(rays.shape[1:], np.inf)
        cosine = np.zeros(rays.shape[1:])
        half = self.width / 2

        def meet(height: float, tilt: float, side: int, inner: float, outer: float) -> None:
            """Add hits on the strip z = height + tilt * aside, with `aside` from inner to outer.

            Here, z is relative to the slope of the road, and `aside` is the distance from the
            middle to this side.
            """
            drop = climb - tilt * side * across
            reach = -(start_height - height - tilt * side * start_across) / drop
            aside = side * (start_across + reach * across)
            met = (reach > 0) & (reach < distance) & (aside >= inner) & (aside <= outer)
            np.copyto(distance, reach, where=met)
            steepness = math.sqrt(1 + self.slope**2 + tilt**2)
            np.copyto(cosine, np.abs(drop) / steepness, where=met)

        with np.errstate(divide="ignore", invalid="ignore"):
            for side in (1, -1):
                meet(0.0, -self.crown, side, 0.0, half)
                if not math.isfinite(half):
                    continue
                edge = self.kerb - self.crown * half
                meet(edge - self.pavement_slope * half, self.pavement_slope, side, half, math.inf)
                reach = (side * half - start_across) / across
                level = start_height + reach * climb
                met = (reach > 0) & (reach < distance)
                met &= (level >= -self.crown * half) & (level <= edge)
                np.copyto(distance, reach, where=met)
                np.copyto(cosine, np.abs(across), where=met)
        return distance, cosine

    def _road_coordinates(
        self, x: float | np.ndarray, y: float | np.ndarray
    ) -> tuple[float | np.ndarray, float | np.ndarray]:
        """Return the distances along the road and to the left of its crown, in metres."""
        cosine, sine = math.cos(self.pose.yaw), math.sin(self.pose.yaw)
        x, y = x - self.pose.x, y - self.pose.y
        return cosine * x + sine * y, cosine * y - sine * x
