"""A person who stands in the road: a street to drive through, and one scan of it.

>>> look_at_person(12, 0.5, lambda labels: filter_clusters(labels, 30))
>>> drive_street(street_with_person(12, 0.5), detect)

Positions are those from the scanner after `POSITION` metres of the drive: x forward, y left.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from utils.drive.actors import standing_actor
from utils.drive.loop import scan_from
from utils.drive.planner import TrackedBox, plan
from utils.drive.rules import (
    BUMPER,
    CORRIDOR,
    HALF_WIDTH,
    STANDSTILL_GAP,
    TAIL,
    stopping_distance,
)
from utils.drive.steps import chain, fit_upright_boxes
from utils.drive.streets import SCANNER, Street
from utils.simulator.streets import EGO_LANE, StreetPlan
from utils.simulator.traffic import car, pedestrian

POSITION = 40.0
"""Metres that the car has driven when it makes the scan, so that a drive has time to react."""

PARKED_CARS = ((8.0, -2.75), (15.0, -2.75))
"""Centres of the parked cars, in metres."""

BRAKING_RANGE = BUMPER + STANDSTILL_GAP + stopping_distance(30 / 3.6)
"""Distance in metres from the scanner, below which the car brakes for a standing obstacle."""

_LENGTH, _WIDTH, _ = car().size

SCENERY = {
    "lines": {
        "middle of our lane": (0, 1, 0),
        "the car brakes up to here": (1, 0, -BRAKING_RANGE),
    },
    "tolerance": CORRIDOR,
    "rectangles": {
        "our car": [(TAIL, -HALF_WIDTH, BUMPER, HALF_WIDTH)],
        "parked cars": [
            (x - _LENGTH / 2, y - _WIDTH / 2, x + _LENGTH / 2, y + _WIDTH / 2)
            for x, y in PARKED_CARS
        ],
    },
}
"""Parts of a `utils.by_hand.Drawing` of the street that stay where they are."""


@dataclass(frozen=True)
class Sight:
    """What one scan shows of the person.

    Attributes
    ----------
    returns : int
        Number of returns that hit the person.
    points : int
        Size of the largest cluster with a point on the person, after thinning. It may contain more
        than the person.
    has_box : bool
        Whether any point on the person is in a cluster that is kept.
    brakes : bool
        Whether the car would brake for the boxes of this scan, at the speed limit.
    """

    returns: int
    points: int
    has_box: bool
    brakes: bool


def street_with_person(x: float, y: float) -> Street:
    """Return a street with two parked cars and a person who stands at (x, y), facing left."""
    cars = (standing_actor(car(), POSITION + a, EGO_LANE + b) for a, b in PARKED_CARS)
    person = standing_actor(pedestrian(1.75, 0.3), POSITION + x, EGO_LANE + y, math.pi / 2)
    houses_only = StreetPlan(parked=math.inf, furniture=math.inf, walkers=math.inf)
    return Street(21, "A person in the road", actors=(*cars, person), plan=houses_only)


def look_at_person(x: float, y: float, keep: Callable[[np.ndarray], np.ndarray]) -> Sight:
    """Scan the street once with a person at (x, y), and filter the clusters.

    Parameters
    ----------
    x, y : float
        Place of the person, in metres from the scanner.
    keep : callable
        Takes labels and returns labels, as in `utils.drive.chain`.
    """
    street = street_with_person(x, y)
    world = street.world(0.0, POSITION, {})
    frame = scan_from(world, street, SCANNER, 0)
    hits = frame.cloud[frame.scan.objects == world.obstacles[-1].identity, :3]
    find_clusters = chain(keep=lambda labels: labels, boxes=lambda *both: both)
    points, labels = find_clusters(frame.cloud)
    kept = np.asarray(keep(labels))
    on_person = (points[:, None] == hits).all(axis=2).any(axis=1)
    boxes = [TrackedBox(corners) for corners in fit_upright_boxes(points, kept)]
    return Sight(
        returns=len(hits),
        points=int(np.bincount(labels)[labels[on_person]].max(initial=0)),
        has_box=bool((kept[on_person] > 0).any()),
        brakes=plan(street.limit, street.limit, boxes).cause is not None,
    )
