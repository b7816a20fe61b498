"""The world of a scanner: ground, obstacles on it, and the car that carries the scanner."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from utils.simulator.ground import Ground
from utils.simulator.pose import Pose
from utils.simulator.shapes import Solid


@dataclass(frozen=True, eq=False)
class Obstacle:
    """An object in the world with a true box and an identity.

    Parameters
    ----------
    kind : str
        One of `utils.simulator.CLASSES`.
    size : tuple of float
        Length, width, height of its true box in metres.
    solids : tuple of Solid
        Parts in the obstacle's own frame: x forward, the origin in the middle of its floor.
    pose : Pose
        Position and heading; z is the height above the ground there, usually 0.
    identity : int
        Positive and unique in its world; 0 until the obstacle is placed in a world.
    speed, turn_rate : float
        In metres and radians per second.
    """

    kind: str
    size: tuple[float, float, float]
    solids: tuple[Solid, ...]
    pose: Pose = Pose()
    identity: int = 0
    speed: float = 0.0
    turn_rate: float = 0.0

    def at(self, time: float) -> Obstacle:
        """Return the obstacle `time` seconds later on its straight line or arc."""
        turned = self.pose.yaw + self.turn_rate * time
        # The chord of the arc points halfway between the two headings.
        half = self.turn_rate * time / 2
        chord = self.speed * time * (math.sin(half) / half if half else 1.0)
        heading = self.pose.yaw + half
        pose = replace(
            self.pose,
            x=self.pose.x + chord * math.cos(heading),
            y=self.pose.y + chord * math.sin(heading),
            yaw=turned,
        )
        return replace(self, pose=pose)


@dataclass(frozen=True, eq=False)
class World:
    """Everything that rays can hit.

    Parameters
    ----------
    ground : Ground
    obstacles : tuple of Obstacle
    ego : tuple of Solid
        Parts of the vehicle that carries the sensor, in the vehicle frame.
    """

    ground: Ground = Ground()
    obstacles: tuple[Obstacle, ...] = ()
    ego: tuple[Solid, ...] = ()

    def seen_from(self, vehicle: Pose, time: float = 0.0) -> World:
        """Return the world `time` seconds later in the frame of a vehicle at pose `vehicle`."""
        outer = replace(vehicle, z=0.0).inverse()
        moved = (obstacle.at(time) for obstacle in self.obstacles)
        return replace(
            self,
            ground=self.ground.seen_from(vehicle),
            obstacles=tuple(replace(thing, pose=outer.then(thing.pose)) for thing in moved),
        )

    def base(self, obstacle: Obstacle) -> Pose:
        """Return the pose of an obstacle's own frame: its pose, lifted onto the ground."""
        pose = obstacle.pose
        return replace(pose, z=pose.z + float(self.ground.height(pose.x, pose.y)))
