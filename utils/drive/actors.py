"""Who does something unforeseen: steps off the kerb, crosses, brakes.

An actor waits for the car: it begins when the car has come so far. So every drive meets it, the
slow one later than the fast one.
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
    """Something that moves straight on, at a speed that changes.

    Parameters
    ----------
    obstacle : Obstacle
        Where it is at the beginning of the drive, in road coordinates, and with its speed until
        it begins.
    begins : float
        Metres along the road of our scanner at which it begins.
    speeds : tuple of (float, float)
        Seconds since it began, and the speed then in m/s; in between it changes evenly, and after
        the last one it stays.
    """

    obstacle: Obstacle
    begins: float
    speeds: tuple[tuple[float, float], ...]

    def at(self, time: float, began: float | None) -> Obstacle:
        """The obstacle at a time of the drive, having begun at another; None: not yet."""
        waited = time if began is None else began
        travelled, speed = self.obstacle.speed * waited, self.obstacle.speed
        if began is not None:
            moments, speeds = np.transpose(self.speeds)
            moment = time - began
            steps = np.append(moments[moments < moment], moment)
            paces = np.interp(steps, moments, speeds)
            travelled += float(np.trapezoid(paces, steps))
            speed = float(paces[-1])
        pose = self.obstacle.pose
        forward, left = np.cos(pose.yaw) * travelled, np.sin(pose.yaw) * travelled
        there = replace(pose, x=float(pose.x + forward), y=float(pose.y + left))
        return replace(self.obstacle, pose=there, speed=speed)


def crossing(thing: Obstacle, x: float, y: float, pace: float, speed: float) -> Actor:
    """Somebody who crosses at `x`, from the side at `y`, in our way if we drive on as before.

    Parameters
    ----------
    thing : Obstacle
        A person or a cyclist.
    x, y : float
        Where they wait, in road coordinates.
    pace, speed : float
        Theirs and ours, in m/s.
    """
    needs = abs(y - EGO_LANE) / pace
    waiting = placed(thing, x, y, np.copysign(np.pi / 2, EGO_LANE - y))
    return Actor(waiting, x - BUMPER - speed * needs, ((0.0, pace),))


def child(x: float, speed: float) -> Actor:
    """A child that runs out from the right kerb at 5 km/h."""
    return crossing(pedestrian(1.2, 0.25), x, -5.0, 1.39, speed)


def adult(x: float, speed: float, side: int = -1, pace: float = 1.39) -> Actor:
    """An adult who crosses from the kerb, at 5 km/h or faster; `side` is 1 for the left."""
    return crossing(pedestrian(1.75, 0.3), x, side * 5.2, pace, speed)


def crossing_cyclist(x: float, speed: float, pace: float = 4.17) -> Actor:
    """A cyclist who comes out of a side street on the left, at 15 km/h or slower."""
    return crossing(cyclist(), x, 13.0, pace, speed)


def peeping(x: float, speed: float) -> Actor:
    """A person who steps out from behind what is parked, looks for a second, and crosses."""
    thing = placed(pedestrian(1.75, 0.2), x, -4.6, np.pi / 2)
    pauses = ((0.0, 1.2), (1.6, 1.2), (1.7, 0.0), (2.7, 0.0), (2.9, 1.4))
    return Actor(thing, x - BUMPER - 3.0 * speed, pauses)


def car_ahead(x: float, speed: float, begins: float, *speeds: tuple[float, float]) -> Actor:
    """A car in our lane, at first as fast as we are, and then at other speeds."""
    return Actor(placed(car(4.4, 1.78, 1.45), x, EGO_LANE, 0.0, speed), begins, speeds)


def slow_cyclist(x: float) -> Actor:
    """A cyclist in our lane at 4 m/s, who turns off after a while."""
    rider = placed(cyclist(), x, EGO_LANE - 0.3, 0.0, 4.0)
    return Actor(rider, np.inf, ((0.0, 4.0),))


def standing(thing: Obstacle, x: float, y: float, yaw: float = 0.0) -> Actor:
    """Something that never moves."""
    return Actor(replace(thing, pose=Pose(x, y, 0.0, yaw)), np.inf, ((0.0, 0.0),))
