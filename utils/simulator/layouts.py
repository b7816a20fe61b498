"""Hand-made layouts: the street in the lessons, and the town square in the cyclist scene."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from utils.simulator.ground import Ground
from utils.simulator.streets import EGO_LANE, placed, world_of
from utils.simulator.traffic import (
    car,
    cyclist,
    garden_wall,
    hedge,
    house,
    pedestrian,
    pole,
    tree,
    truck,
)
from utils.simulator.world import Obstacle, World


def lesson_obstacles() -> list[Obstacle]:
    """Return the obstacles of the lessons' street, in road coordinates."""
    back = math.pi
    return [
        # Parked on the right and on the left.
        placed(car(4.2, 1.72, 1.45), 7.2, -4.05, 0.03),
        placed(car(3.8, 1.66, 1.50), -5.8, -4.0, -0.04),
        placed(car(4.6, 1.82, 1.48), -11.8, -3.95, 0.02),
        placed(car(4.4, 1.80, 1.68), 19.5, -4.0, 0.0),
        placed(car(4.5, 1.78, 1.46), -1.5, 4.05, back + 0.03),
        placed(car(4.0, 1.70, 1.52), -8.0, 3.95, back - 0.05),
        placed(truck(width=2.1), 16.0, 3.9, back),
        placed(car(4.3, 1.75, 1.50), 24.0, 4.0, back + 0.02),
        # Moving: a car that has just passed, one that turns out of a driveway, one ahead.
        placed(car(4.4, 1.78, 1.45), -9.5, 1.6, back + 0.02, speed=8.0),
        placed(car(4.1, 1.72, 1.55), 7.2, 2.6, -2.45, speed=3.0, turn_rate=-0.4),
        placed(car(4.7, 1.84, 1.44), 22.5, EGO_LANE, 0.0, speed=7.0),
        placed(cyclist(), 3.4, 0.75, back + 0.10, speed=4.5),
        placed(cyclist(), 13.0, -1.9, 0.05, speed=4.0),
        # On foot: one crosses the road, two walk so close that clustering may join them.
        placed(pedestrian(1.80, 0.30), 8.9, -1.5, math.pi / 2, speed=1.4),
        placed(pedestrian(1.68, 0.20), 2.6, -6.7, 0.0, speed=1.3),
        placed(pedestrian(1.82, 0.28), 2.5, -7.4, 0.0, speed=1.3),
        placed(pedestrian(1.62, 0.15), 5.2, 6.6, back, speed=1.2),
        placed(pedestrian(1.75, 0.25), -4.6, -6.8, back, speed=1.3),
        placed(pedestrian(1.20, 0.15), -3.2, 6.8, 0.4, speed=0.8),
        # Next to the kerb.
        placed(pole(6.0, 0.08), 1.0, -5.6),
        placed(pole(2.9, 0.04, sign=True), 4.3, -5.5),
        placed(tree(5.5, 1.3, 0.15), -2.4, -5.7),
        placed(tree(6.0, 1.4, 0.16), 12.0, -5.7),
        placed(pole(6.0, 0.08), 21.0, -5.6),
        placed(pole(6.0, 0.08), 2.4, 5.6),
        placed(tree(6.5, 1.5, 0.18), -5.4, 5.7),
        placed(tree(5.8, 1.3, 0.14), 11.5, 5.7),
        placed(pole(2.9, 0.04, sign=True), -11.0, 5.5),
        # House fronts, with the driveway of the turning car.
        placed(house(12.0, 8.0, 7.5), -9.0, -12.8, back),
        placed(house(14.0, 8.0, 6.5), 6.0, -13.3, back),
        placed(house(10.0, 8.0, 8.0), 20.0, -12.9, back),
        placed(house(15.0, 8.0, 7.0), -7.0, 12.7),
        placed(house(12.0, 8.0, 7.5), 18.0, 13.0),
        placed(hedge(8.0, 0.8, 1.4), 5.0, 15.7),
        placed(house(26.0, 8.0, 8.0), 6.0, 27.7),
        placed(garden_wall(1.6, 1.3), -2.0, -9.7, back),
        placed(house(9.0, 8.0, 8.0), -21.0, 12.7),
        placed(house(10.0, 8.0, 8.0), -21.0, -12.9, back),
    ]


def winding_pose(
    distance: float, speed: float, aside: float, weave: float
) -> tuple[float, float, float, float]:
    """Return x, y, heading and speed of a weaving ride, `aside` metres left of a winding path."""
    bend, ripple = 2 * math.pi / 45, 2 * math.pi / 13
    y = 3.0 * math.sin(bend * distance) + aside + weave * 0.4 * math.sin(ripple * distance)
    rise = 3.0 * bend * math.cos(bend * distance)
    rise += weave * 0.4 * ripple * math.cos(ripple * distance)
    return distance, y, math.atan(rise), speed * math.hypot(1.0, rise)


@lru_cache(maxsize=4)
def square(seed: int) -> World:
    """Return an open square with turning cars, and parked cars, trees and houses around it."""
    rng = np.random.default_rng((seed, 4))
    obstacles = [
        # Four vehicles that drive in circles, and one oncoming car.
        placed(car(4.4), 14.0, 10.0, 0.0, 4.0, 0.80),
        placed(car(4.1), 20.0, -9.0, math.pi, 4.0, 0.80),
        placed(car(4.6), 38.0, -7.0, 0.0, 4.0, -0.60),
        placed(truck(), -12.0, 8.0, 0.0, 3.0, 0.50),
        placed(car(4.2), 56.0, 6.2, math.pi, 6.0, -0.01),
    ]
    for x in np.arange(-30.0, 76.0, 7.0).tolist():
        for side in (1.0, -1.0):
            if rng.random() < 0.7:
                yaw = side * math.pi / 2 + 0.1 * rng.random()
                obstacles.append(placed(car(3.8 + rng.random()), x, 25.0 * side, yaw))
            if rng.random() < 0.5:
                obstacles.append(placed(tree(5.0 + 2.0 * rng.random(), 1.4), x + 3.5, 28.0 * side))
            if rng.random() < 0.3:
                obstacles.append(placed(pole(6.0), x + 3.5, 26.5 * side))
            if rng.random() < 0.4:
                walker = pedestrian(1.6 + 0.3 * rng.random())
                obstacles.append(placed(walker, x, 31.0 * side, 0.0, 1.3))
    for x in np.arange(-34.0, 80.0, 15.0).tolist():
        obstacles.append(placed(house(13.0 + rng.random()), x, 37.0))
        obstacles.append(placed(house(13.0 + rng.random()), x, -37.0, math.pi))
    for x, yaw in ((-48.0, math.pi / 2), (90.0, -math.pi / 2)):
        obstacles.append(placed(house(60.0), x, 0.0, yaw))
    return world_of(Ground(slope=0.008), obstacles)
