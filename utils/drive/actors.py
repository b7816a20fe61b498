"""Road users that do something unexpected: step off the kerb, cross the road or brake.

An actor begins to act when the ego car reaches a given place, so slow and fast cars both meet it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from utils.drive.rules import BUMPER
from utils.simulator.pose import Pose
from utils.simulator.streets import EGO_LANE, placed
from utils.simulator.traffic import car, cyclist, pedestrian
from utils.simulator.world import Obstacle


@dataclass(frozen=True, eq=False)
class Actor:
    """A road user that moves in a straight line, at a speed that changes over time.

    Parameters
    ----------
    obstacle : Obstacle
        The road user at the beginning of the drive, in road coordinates. Until the actor begins,
        its speed is constant.
    start_position : float
        Position of the ego car's scanner along the road, in metres, at which the actor begins.
    speeds : tuple of (float, float)
        Pairs of the seconds since the actor began and its speed at that time in m/s. The speed is
        interpolated linearly in between, and constant after the last pair.
    """

    obstacle: Obstacle
    start_position: float
    speeds: tuple[tuple[float, float], ...]

    def at(self, time: float, start_time: float | None) -> Obstacle:
        """Return the obstacle at `time`; without a `start_time`, it is still waiting."""
        waited = time if start_time is None else start_time
        travelled, speed = self.obstacle.speed * waited, self.obstacle.speed
        if start_time is not None:
            moments, speeds = np.transpose(self.speeds)
            moment = time - start_time
            steps = np.append(moments[moments < moment], moment)
            paces = np.interp(steps, moments, speeds)
            travelled += float(np.trapezoid(paces, steps))
            speed = float(paces[-1])
        pose = self.obstacle.pose
        forward, left = np.cos(pose.yaw) * travelled, np.sin(pose.yaw) * travelled
        there = replace(pose, x=float(pose.x + forward), y=float(pose.y + left))
        return replace(self.obstacle, pose=there, speed=speed)


def crossing_actor(road_user: Obstacle, x: float, y: float, pace: float, speed: float) -> Actor:
    """Return an actor that crosses at `x` and collides with an ego car of constant `speed`.

    Parameters
    ----------
    road_user : Obstacle
        A pedestrian or a cyclist.
    x, y : float
        Its waiting position in road coordinates, in metres.
    pace, speed : float
        Speeds of the road user and of the ego car, in m/s.
    """
    duration = abs(y - EGO_LANE) / pace
    waiting = placed(road_user, x, y, np.copysign(np.pi / 2, EGO_LANE - y))
    return Actor(waiting, x - BUMPER - speed * duration, ((0.0, pace),))


def child(x: float, speed: float) -> Actor:
    """Return a child who runs out from the right kerb at 5 km/h."""
    return crossing_actor(pedestrian(1.2, 0.25), x, -5.0, 1.39, speed)


def adult(x: float, speed: float, side: int = -1, pace: float = 1.39) -> Actor:
    """Return an adult who crosses, by default at 5 km/h, from the left (1) or right kerb (-1)."""
    return crossing_actor(pedestrian(1.75, 0.3), x, side * 5.2, pace, speed)


def crossing_cyclist(x: float, speed: float, pace: float = 4.17) -> Actor:
    """Return a cyclist who comes out of a side street on the left, by default at 15 km/h."""
    return crossing_actor(cyclist(), x, 13.0, pace, speed)


def hesitating_pedestrian(x: float, speed: float) -> Actor:
    """Return a person who steps out from behind a parked vehicle, waits a second, and crosses."""
    person = placed(pedestrian(1.75, 0.2), x, -4.6, np.pi / 2)
    pauses = ((0.0, 1.2), (1.6, 1.2), (1.7, 0.0), (2.7, 0.0), (2.9, 1.4))
    return Actor(person, x - BUMPER - 3.0 * speed, pauses)


def car_ahead(x: float, speed: float, start_position: float, *speeds: tuple[float, float]) -> Actor:
    """Return a car ahead in our lane, which drives at `speed` m/s and then follows `speeds`."""
    return Actor(placed(car(4.4, 1.78, 1.45), x, EGO_LANE, 0.0, speed), start_position, speeds)


def slow_cyclist(x: float) -> Actor:
    """Return a cyclist who rides in our lane at a constant 4 m/s."""
    rider = placed(cyclist(), x, EGO_LANE - 0.3, 0.0, 4.0)
    return Actor(rider, np.inf, ((0.0, 4.0),))


def standing_actor(obstacle: Obstacle, x: float, y: float, yaw: float = 0.0) -> Actor:
    """Return an actor that never moves."""
    return Actor(replace(obstacle, pose=Pose(x, y, 0.0, yaw)), np.inf, ((0.0, 0.0),))
