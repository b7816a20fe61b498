"""Streets that are filled row by row, so that no two objects overlap.

Road coordinates: x along the road, y to the left of its crown, z up. From the middle outwards each
side has a driving lane, parked cars and the kerb, then poles and trees, pedestrians and the house
fronts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from utils.simulator.ground import Ground
from utils.simulator.pose import Pose
from utils.simulator.traffic import (
    car,
    cyclist,
    ego_roof,
    garden_wall,
    hedge,
    house,
    pedestrian,
    pole,
    tree,
    truck,
)
from utils.simulator.world import Obstacle, World

LANE, PARKED, FURNITURE, WALKERS, FRONTS = 1.6, 3.95, 5.6, 7.0, 8.3
"""Distance of each row from the middle of the road in metres."""

ROAD_WIDTH = 10.0
EGO_LANE = -1.2
"""y of the ego car in metres, far enough from the parked cars."""


@dataclass(frozen=True)
class StreetPlan:
    """Densities of the objects in a street.

    Parameters
    ----------
    spans : tuple of (float, float)
        Stretches along the road that may be filled, in metres.
    parked, furniture, walkers, driving : float
        Mean free gap between two objects of a row, in metres, in addition to the clearance. An
        infinite gap leaves the row empty.
    clearance : float
        Smallest free gap between two objects of a row, in metres.
    untidiness : float
        Largest deviation of a parked car's heading from the road's, in radians.
    hedges : float
        Share of the gaps between houses that are closed by a hedge or a garden wall.
    """

    spans: tuple[tuple[float, float], ...] = ((-70.0, 80.0),)
    parked: float = 3.0
    furniture: float = 8.0
    walkers: float = 12.0
    driving: float = 25.0
    clearance: float = 1.0
    untidiness: float = 0.04
    hedges: float = 0.5


def placed(
    obstacle: Obstacle,
    x: float,
    y: float,
    yaw: float = 0.0,
    speed: float = 0.0,
    turn_rate: float = 0.0,
) -> Obstacle:
    """Return an obstacle moved to (x, y) in metres, with this heading and motion."""
    return replace(obstacle, pose=Pose(x, y, 0.0, yaw), speed=speed, turn_rate=turn_rate)


def numbered(obstacles: Iterable[Obstacle]) -> tuple[Obstacle, ...]:
    """Return the obstacles with the identities 1, 2, 3 and so on."""
    return tuple(replace(thing, identity=i) for i, thing in enumerate(obstacles, start=1))


def world_of(ground: Ground, obstacles: Iterable[Obstacle]) -> World:
    """Build a world whose sensor is on the roof of an ordinary car."""
    return World(ground, numbered(obstacles), ego_roof())


def street(rng: np.random.Generator, plan: StreetPlan) -> Iterator[Obstacle]:
    """Yield the objects on both sides of a street in road coordinates, with traffic on the right.

    All moving objects in a row have the same speed and direction, so they never collide.
    """
    for first, last in plan.spans:
        for side in (1, -1):
            for row in (
                _parked_cars,
                _street_furniture,
                _pedestrians,
                _moving_traffic,
                _house_fronts,
            ):
                yield from row(rng, plan, first, last, side)


def _gap(rng: np.random.Generator, plan: StreetPlan, mean: float) -> float:
    """Draw a free gap uniformly from the clearance to the clearance plus twice the mean."""
    return plan.clearance + mean * rng.random() * 2


def _parked_cars(
    rng: np.random.Generator, plan: StreetPlan, first: float, last: float, side: int
) -> Iterator[Obstacle]:
    """Yield parked cars along the kerb, heading with the traffic."""
    x = first + _gap(rng, plan, plan.parked)
    while x < last:
        thing = random_car(rng)
        length = thing.size[0]
        if x + length > last:
            return
        yaw = (0.0 if side < 0 else math.pi) + plan.untidiness * (2 * rng.random() - 1)
        yield placed(thing, x + length / 2, side * (PARKED + 0.1 * rng.random() - 0.05), yaw)
        x += length + _gap(rng, plan, plan.parked)


def _street_furniture(
    rng: np.random.Generator, plan: StreetPlan, first: float, last: float, side: int
) -> Iterator[Obstacle]:
    """Yield trees, lamp posts and signs next to the kerb."""
    x = first + _gap(rng, plan, plan.furniture)
    while x < last:
        choice = rng.random()
        if choice < 0.4:
            crown, trunk = 1.1 + 0.5 * rng.random(), 0.11 + 0.1 * rng.random()
            thing = tree(5.0 + 2.0 * rng.random(), crown, trunk)
        elif choice < 0.7:
            thing = pole(6.0, 0.08)
        else:
            thing = pole(2.9, 0.04, sign=True)
        yield placed(thing, x, side * FURNITURE)
        x += 0.6 + _gap(rng, plan, plan.furniture)


def _pedestrians(
    rng: np.random.Generator, plan: StreetPlan, first: float, last: float, side: int
) -> Iterator[Obstacle]:
    """Yield pedestrians on the pavement, sometimes two side by side."""
    x = first + _gap(rng, plan, plan.walkers)
    yaw = math.pi * (rng.random() < 0.5)
    while x < last:
        together = rng.random() < 0.25
        for y in (WALKERS - 0.35, WALKERS + 0.4) if together else (WALKERS,):
            yield placed(random_pedestrian(rng), x, side * y, yaw, speed=1.3)
        x += 0.6 + _gap(rng, plan, plan.walkers)


def _moving_traffic(
    rng: np.random.Generator, plan: StreetPlan, first: float, last: float, side: int
) -> Iterator[Obstacle]:
    """Yield cars, cyclists and lorries in the lane, except close to the ego car."""
    heading = 0.0 if side < 0 else math.pi
    speed = 4.5 + 2.0 * rng.random()
    x = first + _gap(rng, plan, plan.driving)
    while x < last:
        choice = rng.random()
        thing = cyclist() if choice < 0.2 else random_car(rng)
        if choice > 0.85:
            thing = truck(width=2.1)
        length = thing.size[0]
        if x + length > last:
            return
        if side > 0 or x > 7.0 or x + length < -7.0:
            y = side * (LANE + 0.1 * (thing.kind == "truck"))
            yield placed(thing, x + length / 2, y, heading, speed)
        x += length + 2.0 + _gap(rng, plan, plan.driving)


def _house_fronts(
    rng: np.random.Generator, plan: StreetPlan, first: float, last: float, side: int
) -> Iterator[Obstacle]:
    """Yield houses with gaps between them, some closed by a hedge or a garden wall."""
    x, yaw = first, 0.0 if side > 0 else math.pi
    while x + 7.0 < last:
        length = min(7.0 + 8.0 * rng.random(), last - x)
        setback = FRONTS + 1.5 * rng.random()
        front = house(length, 8.0, 6.0 + 3.0 * rng.random())
        yield placed(front, x + length / 2, side * (setback + 4.0), yaw)
        x += length
        gap = 1.5 + 4.0 * rng.random()
        if rng.random() < plan.hedges and x + gap < last:
            fence = hedge(gap - 0.6) if rng.random() < 0.5 else garden_wall(gap - 0.6)
            yield placed(fence, x + gap / 2, side * (setback + 0.6), yaw)
        x += gap


def random_car(rng: np.random.Generator) -> Obstacle:
    """Draw a car of a typical size."""
    return car(3.7 + 1.1 * rng.random(), 1.65 + 0.2 * rng.random(), 1.42 + 0.3 * rng.random())


def random_pedestrian(rng: np.random.Generator) -> Obstacle:
    """Draw a pedestrian of a typical size with a random stride."""
    return pedestrian(1.55 + 0.35 * rng.random(), 0.1 + 0.25 * rng.random())
