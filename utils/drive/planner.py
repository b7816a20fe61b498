"""The given planner: how hard to brake, and for what. It steers nothing; the lane is straight.

It sees what the detector boxed and how these boxes move, and nothing else. So a box where nothing
is stops the car, and what has no box is driven into.
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
"""At so many moments until we would stand the planner asks where a thing will be."""


@dataclass(frozen=True, eq=False)
class Thing:
    """A box as the planner sees it.

    Parameters
    ----------
    corners : ndarray, shape (8, 3)
        In metres, the scanner at the origin, now.
    velocity : tuple of float
        Metres per second over the ground, forward and to the left.
    seen : bool
        Whether the last scan had a box for it; else it is where it should be by now.
    name : int
        The same from scan to scan.
    """

    corners: np.ndarray
    velocity: tuple[float, float] = (0.0, 0.0)
    seen: bool = True
    name: int = 0


@dataclass(frozen=True, eq=False)
class Decision:
    """What to do in the next tenth of a second.

    Parameters
    ----------
    acceleration : float
        In m/s²; negative brakes.
    cause : Thing or None
        For what the car brakes or waits.
    gap : float
        Metres from the bumper to where the cause is, or will be.
    """

    acceleration: float
    cause: Thing | None = None
    gap: float = np.inf


@dataclass(frozen=True, eq=False)
class Streak:
    """Something over our own car, scan after scan in one place.

    Parameters
    ----------
    middle : ndarray, shape (2,)
        Of its box, in metres, the scanner at the origin.
    scans : int
        That had a box for it, all in a row but for a few without.
    """

    middle: np.ndarray
    scans: int


class Planner:
    """Brakes for one thing that is in the way three times in a row: a box that flickers is none.

    Nobody gets onto our car from one scan to the next; drops do, and are gone again, and dirt
    does, and stays. So what is over it counts once it has been in one place for a second.
    """

    def __init__(self) -> None:
        self._ahead, self._over = {}, []

    def decide(self, speed: float, limit: float, things: Iterable[Thing]) -> Decision:
        """What to do now; see `plan`."""
        things = self._believed(speed, list(things))
        in_the_way = [thing.name for thing in things if plan(speed, limit, [thing]).cause]
        self._ahead = {name: self._ahead.get(name, 0) + 1 for name in in_the_way}
        sure = [thing for thing in things if self._ahead.get(thing.name, SURE) >= SURE]
        decision = plan(speed, limit, sure)
        if len(sure) == len(things):
            return decision
        return replace(decision, acceleration=min(decision.acceleration, 0.0))

    def _believed(self, speed: float, things: list[Thing]) -> list[Thing]:
        """All things; without those over our car, unless they stay."""
        over = {thing: self._again(thing) for thing in things if reach(thing, speed) > OVER}
        self._over = list(over.values())
        return [thing for thing in things if thing not in over or over[thing].scans >= STAYS]

    def _again(self, thing: Thing) -> Streak:
        middle = thing.corners[:, :2].mean(axis=0)
        there = [one for one in self._over if np.abs(one.middle - middle).max() <= STILL]
        return Streak(middle, thing.seen + max((one.scans for one in there), default=0))


def plan(speed: float, limit: float, things: Iterable[Thing]) -> Decision:
    """Drive on as fast as is allowed; brake for what stands, or will stand, in the corridor.

    Parameters
    ----------
    speed, limit : float
        Ours, and that of the street, in m/s.
    things : iterable of Thing
    """
    free = min(ACCELERATION, (limit - speed) / 0.5)
    decisions = [Decision(free)]
    for thing in things:
        gap = room(thing, speed)
        ahead = max(thing.velocity[0], 0.0) if gap > 0 else 0.0  # what is over us leads nobody
        needed = needed_room(thing, speed)
        if gap <= needed + (speed == 0):  # who stands waits for a metre more
            ours_to_lose = max(speed**2 - ahead**2, 0.0)
            brake = ours_to_lose / (2 * max(gap - STANDSTILL, 0.1))
            gentle = COMFORTABLE if speed > ahead else 0.0
            decisions.append(Decision(-min(max(brake, gentle), DECELERATION), thing, gap))
        elif ahead > 1 and gap <= needed + speed:  # behind somebody: grow as slow as they are
            follow = min(free, max(ahead - speed, -2.0) / 2)
            decisions.append(Decision(follow, thing if follow < free else None, gap))
    return min(decisions, key=lambda decision: decision.acceleration)


def needed_room(thing: Thing, speed: float) -> float:
    """Metres from our bumper within which a thing in the corridor has us brake."""
    rolls = max(thing.velocity[0], 0.0) ** 2 / (2 * DECELERATION)
    return STANDSTILL + max(stopping_distance(speed) - rolls, 0.0)


def room(thing: Thing, speed: float, wider: float = 0.0) -> float:
    """Metres from our bumper to a thing in the corridor; infinite where it stays outside.

    Parameters
    ----------
    thing : Thing
    speed : float
        Ours. The faster we are, the longer we look ahead: until we would stand.
    wider : float
        Metres by which the corridor is wider than usual, to either side.
    """
    (x, y), (forward, left) = thing.corners[:, :2].T, thing.velocity
    if x.max() < 0.0:
        return np.inf  # behind us
    for later in np.linspace(0.0, REACTION + speed / DECELERATION, LOOKS):
        nearest = _nearest_within(CORRIDOR + wider, x, y + left * later)
        if np.isfinite(nearest):
            # What drives away has its own room; what comes towards us takes some of ours.
            return float(nearest + min(forward, 0.0) * later) - BUMPER
    return np.inf


def reach(thing: Thing, speed: float) -> float:
    """Metres that a thing in the corridor reaches over our car; 0 for what is ahead, or also is."""
    x, y = thing.corners[:, :2].T
    farthest = -_nearest_within(CORRIDOR, -x, y)
    if x.min() > BUMPER or farthest > BUMPER + STANDSTILL:
        return 0.0
    return max(-room(thing, speed), 0.0)


def _nearest_within(half: float, x: np.ndarray, y: np.ndarray) -> float:
    """The least x of what lies between some points and within a corridor; infinite for nothing.

    It is at a point, or where a line between two of them enters the corridor.
    """
    a, b = np.triu_indices(len(x), 1)
    rise = y[b] - y[a]
    steep = rise != 0  # the others run along the corridor
    a, b, rise = a[steep], b[steep], rise[steep]
    share = (np.array([[-half], [half]]) - y[a]) / rise
    crossings = (x[a] + share * (x[b] - x[a]))[(share > 0) & (share < 1)]
    return min(x[np.abs(y) < half].min(initial=np.inf), crossings.min(initial=np.inf))
