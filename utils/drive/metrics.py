"""Metrics of a drive: distance, comfort, closest pass and braking events."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from utils.drive.explanations import KINDS_IN_WORDS, Braking, braking_events, describe_collision
from utils.drive.loop import Drive
from utils.drive.rules import COMFORTABLE_DECELERATION, TICK

NEAR_MISS_GAP, NEAR_MISS_SPEED = 0.5, 2.0
"""Near miss: nearer than NEAR_MISS_GAP m to a road user at more than NEAR_MISS_SPEED m/s."""


@dataclass(frozen=True)
class Report:
    """Metrics of one drive.

    Attributes
    ----------
    street : int
        The street's number.
    metres, seconds : float
        Distance and duration of the drive.
    brakings : tuple of Braking
        All braking events, in order.
    collision : str
        A sentence about the collision; empty without one.
    closest_distance : float
        Smallest distance in metres to a road user while the car was moving; infinite if none
        came near.
    closest_kind : str
        That road user in words, such as "a cyclist".
    near_misses : int
        Number of road users that came nearer than 0.5 m while the car was faster than 2 m/s; one
        that the car hit does not count.
    hardest_braking : float
        Largest deceleration in m/s².
    harsh_seconds : float
        Seconds of uncomfortably hard braking.
    scan_age : float
        Median age in seconds of the scan that the planner used.
    mean_speed : float
        Mean speed in m/s.
    """

    street: int
    metres: float
    seconds: float
    brakings: tuple[Braking, ...] = ()
    collision: str = ""
    closest_distance: float = np.inf
    closest_kind: str = ""
    near_misses: int = 0
    hardest_braking: float = 0.0
    harsh_seconds: float = 0.0
    scan_age: float = TICK
    mean_speed: float = 0.0

    @property
    def needless(self) -> int:
        """Number of needless braking events."""
        return sum(braking.needless for braking in self.brakings)


def measure(drive: Drive) -> Report:
    """Compute the metrics of a drive."""
    closest: dict[int, float] = {}
    missed = set()
    for moment in drive.moments:
        for identity, gap in moment.gaps.items():
            if identity not in drive.street.road_users or moment.speed <= 0:
                continue
            closest[identity] = min(gap, closest.get(identity, np.inf))
            if 0 < gap < NEAR_MISS_GAP and moment.speed > NEAR_MISS_SPEED:
                missed.add(identity)
    nearest = min(closest, key=closest.get, default=None)
    slowing = [max(-moment.acceleration, 0.0) for moment in drive.moments]
    ages = [
        moment.number - moment.latest_scan
        for moment in drive.moments
        if moment.latest_scan is not None
    ]
    return Report(
        drive.street.number,
        drive.metres,
        len(drive.moments) * TICK,
        tuple(braking_events(drive)),
        describe_collision(drive),
        closest.get(nearest, np.inf),
        "" if nearest is None else KINDS_IN_WORDS[drive.street.kind_of(nearest)],
        len(missed - {drive.hit_identity}),
        max(slowing),
        TICK * sum(deceleration > COMFORTABLE_DECELERATION + 0.01 for deceleration in slowing),
        TICK * float(np.median(ages)) if ages else np.inf,
        float(np.mean([moment.speed for moment in drive.moments])),
    )
