"""Twenty streets to drive through; in most of them something unexpected happens."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from utils.drive.actors import (
    Actor,
    adult,
    car_ahead,
    child,
    crossing_cyclist,
    hesitating_pedestrian,
    slow_cyclist,
    standing_actor,
)
from utils.simulator.ground import Ground
from utils.simulator.pose import Pose
from utils.simulator.sensor import Sensor, layers
from utils.simulator.streets import (
    EGO_LANE,
    FRONTS,
    FURNITURE,
    PARKED,
    ROAD_WIDTH,
    WALKERS,
    StreetPlan,
    street,
    world_of,
)
from utils.simulator.traffic import truck
from utils.simulator.world import Obstacle, World

SCANNER = Sensor(
    layers(32, 2.0, -8.33) + layers(16, -9.3, -24.8),
    math.radians(0.36),
    maximum_range=45.0,
    dropout=0.01,
    weakest_signal=0.05,
    invalid_returns=3,
)
"""Like `hdl64` with a third of its returns, so that a drive can be simulated in real time."""

BEHIND, AHEAD = -12.0, 50.0
"""Range of simulated objects relative to the car, in metres; slightly more than it must see."""


@dataclass(frozen=True, eq=False)
class Street:
    """A street with its events and its weather.

    Parameters
    ----------
    number : int
        Number of the street, from 1.
    title : str
    speed : float
        Speed limit in km/h; the car starts at this speed.
    slope : float
        Rise per metre.
    actors : tuple of Actor
    rain : int
        Raindrops per scan.
    has_dirty_bonnet : bool
        Whether the bonnet is dirty.
    traffic : bool
        Whether there is oncoming traffic.
    plan : StreetPlan
        Density of the objects along the street.
    random_seed : int, optional
        Random seed for everything in the street; by default its number.
    """

    number: int
    title: str
    speed: float = 30.0
    slope: float = 0.0
    actors: tuple[Actor, ...] = ()
    rain: int = 0
    has_dirty_bonnet: bool = False
    traffic: bool = False
    plan: StreetPlan = StreetPlan(parked=5.0, furniture=10.0, walkers=14.0)  # noqa: RUF009
    random_seed: int | None = None

    @property
    def seed(self) -> int:
        """Random seed for everything in the street."""
        return self.number if self.random_seed is None else self.random_seed

    @property
    def limit(self) -> float:
        """Speed limit in m/s."""
        return self.speed / 3.6

    @cached_property
    def static_world(self) -> World:
        """World without the actors at the beginning of the drive, in road coordinates."""
        length = 20.0 * self.limit + AHEAD
        plan = replace(self.plan, spans=((BEHIND, length),), driving=20.0)
        obstacles = street(np.random.default_rng((self.seed, 30)), plan)
        ground = Ground(
            slope=self.slope, width=ROAD_WIDTH, crown=0.02, kerb=0.13, pavement_slope=0.02
        )
        return world_of(ground, [obstacle for obstacle in obstacles if self._may_contain(obstacle)])

    def _may_contain(self, obstacle: Obstacle) -> bool:
        """Return whether an obstacle may be in this street; only actors drive in our lane."""
        x, y = obstacle.pose.x, obstacle.pose.y
        if abs(y) < PARKED - 1.0:
            return y > 0 and self.traffic
        if self.traffic and 0 < y < FURNITURE - 1.0:
            return False  # no parking here, so that two cars can pass
        return not any(_obstructs(obstacle, x, y, actor) for actor in self.actors)

    def world(self, time: float, position: float, start_times: dict[int, float]) -> World:
        """Return the world around the ego car, in the car's frame.

        Parameters
        ----------
        time : float
            Seconds since the beginning of the drive.
        position : float
            Position of the car's scanner along the road, in metres.
        start_times : dict of int to float
            Start time of each actor that has begun, by its index in `actors`.
        """
        still = self.static_world
        moved = [obstacle.at(time) if obstacle.speed else obstacle for obstacle in still.obstacles]
        moved += [
            replace(actor.at(time, start_times.get(index)), identity=self._identity(index))
            for index, actor in enumerate(self.actors)
        ]
        near = (obstacle for obstacle in moved if BEHIND < obstacle.pose.x - position < AHEAD)
        world = replace(still, obstacles=tuple(near))
        return world.seen_from(Pose(position, EGO_LANE))

    def _identity(self, index: int) -> int:
        return len(self.static_world.obstacles) + 1 + index

    @cached_property
    def road_users(self) -> dict[int, str]:
        """Kinds of all objects that move or may move in this street, by identity."""
        moving = {
            obstacle.identity: obstacle.kind
            for obstacle in self.static_world.obstacles
            if obstacle.speed
        }
        return moving | {
            self._identity(index): actor.obstacle.kind for index, actor in enumerate(self.actors)
        }

    def kind_of(self, identity: int) -> str:
        """Return the kind of the object with this identity."""
        if identity in self.road_users:
            return self.road_users[identity]
        return self.static_world.obstacles[identity - 1].kind


def _obstructs(obstacle: Obstacle, x: float, y: float, actor: Actor) -> bool:
    """Return whether an obstacle is in the path of an actor, or may hide it."""
    pose, moves = actor.obstacle.pose, actor.speeds[-1][1] > 0
    across = moves and abs(math.sin(pose.yaw)) > 0.5
    if not across:
        return (
            abs(y - pose.y) < 3.0
            and abs(x - pose.x) < (obstacle.size[0] + actor.obstacle.size[0]) / 2 + 1.0
        )
    same_side = y * pose.y > 0
    half = obstacle.size[0] / 2
    from_afar = abs(pose.y) > WALKERS  # the side street must stay free
    if abs(y) > FRONTS or from_afar:
        return same_side and from_afar and abs(x - pose.x) < half + 3.5
    if obstacle.speed:  # no pedestrians near a crossing road user
        return same_side and abs(x - pose.x) < 12.0
    # Only another actor may hide a person who steps off the kerb.
    return -half - 1.5 < x - pose.x < half + 1.5 or (same_side and -9.0 < x - pose.x < half + 1.5)


def _streets() -> Iterable[Street]:
    """Yield the twenty streets in order."""
    v30, v50 = 30 / 3.6, 50 / 3.6
    empty = StreetPlan(parked=math.inf, furniture=16.0, walkers=30.0)
    crowded = StreetPlan(parked=1.5, furniture=6.0, walkers=7.0, clearance=1.2)
    lorry = standing_actor(truck(width=2.3), 70.0, -4.05)
    yield Street(1, "A quiet street", traffic=True)
    yield Street(2, "A child runs out from the kerb", actors=(child(70, v30),))
    yield Street(3, "A cyclist crosses", actors=(crossing_cyclist(75, v30, 2.78),))
    yield Street(
        4,
        "A pedestrian behind a parked lorry",
        20,
        actors=(lorry, hesitating_pedestrian(75.5, 20 / 3.6)),
    )
    yield Street(
        5,
        "The car ahead brakes",
        traffic=True,
        actors=(car_ahead(22, v30, 50, (0, v30), (1.4, 0), (4, 0), (8, v30)),),
    )
    yield Street(6, "A street that climbs", slope=0.06, traffic=True)
    yield Street(7, "A child on a climb", slope=0.05, actors=(child(85, v30),))
    yield Street(8, "Rain", rain=60, traffic=True)
    yield Street(9, "A cyclist in the rain", rain=60, actors=(crossing_cyclist(90, v30),))
    yield Street(10, "A dirty bonnet", has_dirty_bonnet=True, traffic=True)
    yield Street(11, "Two people cross", actors=(adult(80, v30), adult(80.9, v30)))
    yield Street(
        12,
        "Behind a car that stops twice",
        traffic=True,
        actors=(
            car_ahead(
                18, v30, 30, (0, v30), (4, 0), (5, 0), (8, 6), (10, 6), (12, 0), (14, 0), (18, 8)
            ),
        ),
    )
    yield Street(13, "A wide road at 50 km/h", 50, slope=0.025, traffic=True, plan=empty)
    yield Street(14, "A pedestrian crosses a wide road", 50, plan=empty, actors=(adult(110, v50),))
    yield Street(15, "A crowded street", traffic=True, plan=crowded)
    yield Street(16, "Downhill", slope=-0.05, actors=(adult(90, v30, side=1),))
    yield Street(17, "Behind a cyclist", traffic=True, actors=(slow_cyclist(25),))
    yield Street(
        18,
        "Rain, a dirty bonnet and a child",
        rain=60,
        has_dirty_bonnet=True,
        actors=(child(75, v30),),
    )
    yield Street(19, "A pedestrian runs", actors=(adult(80, v30, pace=2.22),), plan=crowded)
    yield Street(
        20,
        "Everything at once",
        rain=40,
        has_dirty_bonnet=True,
        slope=0.03,
        actors=(
            child(60, v30),
            car_ahead(75, 4.0, 45, (0, 4.0), (2, v30)),
            crossing_cyclist(120, v30),
        ),
        plan=crowded,
    )


STREETS: tuple[Street, ...] = tuple(_streets())
