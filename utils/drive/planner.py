"""The course's planner, which decides how hard to brake and for which thing.

The planner does not steer, because the lane is straight. It knows only the detector's boxes and
their motion, so the car stops for a box around nothing and hits an object without a box.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from utils.drive.rules import (
    ACCELERATION,
    BUMPER,
    COMFORTABLE,
    CORRIDOR,
    DECELERATION,
    OVER,
    REACTION,
    STANDSTILL,
    STAYS,
    STILL,
    SURE,
    stopping_distance,
)

LOOKS = 5
"""Number of moments before standstill for which the planner predicts the place of a thing."""


@dataclass(frozen=True, eq=False)
class Thing:
    """A box as the planner sees it.

    Parameters
    ----------
    corners : ndarray, shape (8, 3)
        Current corners in metres, with the scanner at the origin.
    velocity : tuple of float
        Velocity over the ground, forward and to the left, in m/s.
    seen : bool
        Whether the latest scan had a box for it; otherwise its place is a prediction.
    name : int
        Track ID, the same from scan to scan.
    """

    corners: np.ndarray
    velocity: tuple[float, float] = (0.0, 0.0)
    seen: bool = True
    name: int = 0


@dataclass(frozen=True, eq=False)
class Decision:
    """Acceleration for the next tenth of a second, with its cause.

    Parameters
    ----------
    acceleration : float
        In m/s²; negative values brake.
    cause : Thing or None
        Thing for which the car brakes, waits or slows down.
    gap : float
        Distance in metres from the bumper to the current or predicted place of the cause.
    """

    acceleration: float
    cause: Thing | None = None
    gap: float = np.inf


@dataclass(frozen=True, eq=False)
class StayingObstacle:
    """A thing that overlaps the ego car and stays in one place.

    Parameters
    ----------
    middle : ndarray, shape (2,)
        Centre of its box in metres, with the scanner at the origin.
    scans : int
        Number of scans with a box for it; scans without one neither count nor reset the count.
    """

    middle: np.ndarray
    scans: int


class Planner:
    """Brakes for a thing that is in the way in three scans in a row, to ignore flickering boxes.

    A road user cannot get onto the ego car from one scan to the next. A raindrop can appear there
    but vanishes at once. A thing that overlaps the car therefore counts only after it has stayed
    in one place for a second.
    """

    def __init__(self) -> None:
        self._ahead, self._over = {}, []

    def decide(self, speed: float, limit: float, things: Iterable[Thing]) -> Decision:
        """Return the decision for this moment; see `plan` for the parameters.

        The car does not accelerate while a thing has been in the way for fewer than three scans.
        """
        things = self._without_phantoms(speed, list(things))
        in_the_way = [thing.name for thing in things if plan(speed, limit, [thing]).cause]
        self._ahead = {name: self._ahead.get(name, 0) + 1 for name in in_the_way}
        sure = [thing for thing in things if self._ahead.get(thing.name, SURE) >= SURE]
        decision = plan(speed, limit, sure)
        if len(sure) == len(things):
            return decision
        return replace(decision, acceleration=min(decision.acceleration, 0.0))

    def _without_phantoms(self, speed: float, things: list[Thing]) -> list[Thing]:
        """Return all things except those over the ego car that have not stayed for a second."""
        over = {
            thing: self._staying_obstacle(thing) for thing in things if reach(thing, speed) > OVER
        }
        self._over = list(over.values())
        return [thing for thing in things if thing not in over or over[thing].scans >= STAYS]

    def _staying_obstacle(self, thing: Thing) -> StayingObstacle:
        middle = thing.corners[:, :2].mean(axis=0)
        near = [
            obstacle for obstacle in self._over if np.abs(obstacle.middle - middle).max() <= STILL
        ]
        return StayingObstacle(
            middle, thing.seen + max((obstacle.scans for obstacle in near), default=0)
        )


def plan(speed: float, limit: float, things: Iterable[Thing]) -> Decision:
    """Decide to drive as fast as allowed, but brake for things that are or will be in the corridor.

    Parameters
    ----------
    speed, limit : float
        Speed of the ego car and limit of the street, in m/s.
    things : iterable of Thing
        Things around the car.
    """
    free = min(ACCELERATION, (limit - speed) / 0.5)
    decisions = [Decision(free)]
    for thing in things:
        gap = room(thing, speed)
        ahead = (
            max(thing.velocity[0], 0.0) if gap > 0 else 0.0
        )  # a thing that overlaps us is not a leading vehicle
        needed = needed_room(thing, speed)
        if gap <= needed + (speed == 0):  # before it starts, a standing car waits for 1 m more
            ours_to_lose = max(speed**2 - ahead**2, 0.0)
            brake = ours_to_lose / (2 * max(gap - STANDSTILL, 0.1))
            gentle = COMFORTABLE if speed > ahead else 0.0
            decisions.append(Decision(-min(max(brake, gentle), DECELERATION), thing, gap))
        elif ahead > 1 and gap <= needed + speed:  # adapt to the speed of the vehicle ahead
            follow = min(free, max(ahead - speed, -2.0) / 2)
            decisions.append(Decision(follow, thing if follow < free else None, gap))
    return min(decisions, key=lambda decision: decision.acceleration)


def needed_room(thing: Thing, speed: float) -> float:
    """Return the gap in metres below which the car brakes for a thing in the corridor."""
    rolls = max(thing.velocity[0], 0.0) ** 2 / (2 * DECELERATION)
    return STANDSTILL + max(stopping_distance(speed) - rolls, 0.0)


def room(thing: Thing, speed: float, wider: float = 0.0) -> float:
    """Return the gap in metres from the bumper to a thing; infinite if outside the corridor.

    Parameters
    ----------
    thing : Thing
        The thing, with the scanner at the origin.
    speed : float
        Speed of the ego car in m/s. The prediction covers the time until the car would stop.
    wider : float
        Metres added to the corridor on either side.
    """
    (x, y), (forward, left) = thing.corners[:, :2].T, thing.velocity
    if x.max() < 0.0:
        return np.inf  # behind us
    for later in np.linspace(0.0, REACTION + speed / DECELERATION, LOOKS):
        nearest = _nearest_within(CORRIDOR + wider, x, y + left * later)
        if np.isfinite(nearest):
            # Only oncoming traffic changes the gap; `needed_room` accounts for a leading vehicle.
            return float(nearest + min(forward, 0.0) * later) - BUMPER
    return np.inf


def reach(thing: Thing, speed: float) -> float:
    """Return by how many metres a thing in the corridor overlaps the ego car from the front.

    Return 0 if the thing begins ahead of the bumper, or extends more than STANDSTILL metres ahead
    of the bumper.
    """
    x, y = thing.corners[:, :2].T
    farthest = -_nearest_within(CORRIDOR, -x, y)
    if x.min() > BUMPER or farthest > BUMPER + STANDSTILL:
        return 0.0
    return max(-room(thing, speed), 0.0)


def _nearest_within(half: float, x: np.ndarray, y: np.ndarray) -> float:
    """Return the smallest x of the points' convex hull within a corridor; infinite if none.

    This x is at a point, or where a line between two points crosses the edge of the corridor.
    """
    a, b = np.triu_indices(len(x), 1)
    rise = y[b] - y[a]
    steep = rise != 0  # other lines are parallel to the edges
    a, b, rise = a[steep], b[steep], rise[steep]
    share = (np.array([[-half], [half]]) - y[a]) / rise
    crossings = (x[a] + share * (x[b] - x[a]))[(share > 0) & (share < 1)]
    return min(x[np.abs(y) < half].min(initial=np.inf), crossings.min(initial=np.inf))
