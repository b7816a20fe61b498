"""What a drive is worth: how far, how smooth, how close, and what was braked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from utils.drive.explanations import WORDS, Braking, brakings, collision
from utils.drive.loop import Drive
from utils.drive.rules import COMFORTABLE, TICK

CLOSE, FAST = 0.5, 2.0
"""A near miss: nearer than so many metres to somebody who moves, faster than so many m/s."""


@dataclass(frozen=True)
class Report:
    """A drive in numbers.

    Attributes
    ----------
    street : int
        Its number.
    metres, seconds : float
        Driven.
    brakings : tuple of Braking
    collision : str
        A sentence; empty where nothing was hit.
    closest : float
        Metres to the nearest road user that moves or may move, while we did; infinite where
        nobody came near.
    closest_kind : str
        Who that was.
    near_misses : int
        How many of them came nearer than 0.5 m while we were faster than 2 m/s.
    hardest : float
        Of all decelerations, in m/s².
    harsh : float
        Seconds of braking harder than is comfortable.
    age : float
        Seconds, in the middle, since the scan that the car went by.
    """

    street: int
    metres: float
    seconds: float
    brakings: tuple[Braking, ...] = ()
    collision: str = ""
    closest: float = np.inf
    closest_kind: str = ""
    near_misses: int = 0
    hardest: float = 0.0
    harsh: float = 0.0
    age: float = TICK

    @property
    def needless(self) -> int:
        """How often the car braked for nothing."""
        return sum(braking.needless for braking in self.brakings)


def measure(drive: Drive) -> Report:
    """Measure a drive."""
    closest: dict[int, float] = {}
    missed = set()
    for moment in drive.moments:
        for identity, gap in moment.gaps.items():
            if identity not in drive.street.road_users or moment.speed <= 0:
                continue
            closest[identity] = min(gap, closest.get(identity, np.inf))
            if 0 < gap < CLOSE and moment.speed > FAST:
                missed.add(identity)
    nearest = min(closest, key=closest.get, default=None)
    slowing = [max(-moment.acceleration, 0.0) for moment in drive.moments]
    ages = [moment.number - moment.seen for moment in drive.moments if moment.seen is not None]
    return Report(
        drive.street.number,
        drive.metres,
        len(drive.moments) * TICK,
        tuple(brakings(drive)),
        collision(drive),
        closest.get(nearest, np.inf),
        "" if nearest is None else WORDS[drive.street.kind_of(nearest)],
        len(missed - {drive.hit}),
        max(slowing),
        TICK * sum(one > COMFORTABLE + 0.01 for one in slowing),
        TICK * float(np.median(ages)) if ages else np.inf,
    )
