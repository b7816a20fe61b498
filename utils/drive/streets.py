"""Twenty streets to drive through, each with something that happens, or with nothing."""

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
    peeping,
    slow_cyclist,
    standing,
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
"""As `hdl64`, but with a third of its returns, so that a drive takes no longer than it lasts."""

BEHIND, AHEAD = -12.0, 50.0
"""Metres along the road in which things are made: little farther than anybody has to look."""


@dataclass(frozen=True, eq=False)
class Street:
    """A street, what happens in it, and in which weather.

    Parameters
    ----------
    number : int
        From 1.
    title : str
    speed : float
        What is allowed, in km/h; we come that fast.
    slope : float
        Rise per metre.
    actors : tuple of Actor
    rain : int
        Drops in a scan.
    dirt : bool
        On the bonnet.
    traffic : bool
        Whether anything comes towards us.
    plan : StreetPlan
        What stands along it.
    drawn_from : int, optional
        What everything random in it is drawn from; by default its number.
    """

    number: int
    title: str
    speed: float = 30.0
    slope: float = 0.0
    actors: tuple[Actor, ...] = ()
    rain: int = 0
    dirt: bool = False
    traffic: bool = False
    plan: StreetPlan = StreetPlan(parked=5.0, furniture=10.0, walkers=14.0)  # noqa: RUF009
    drawn_from: int | None = None

    @property
    def seed(self) -> int:
        """What everything random in it is drawn from."""
        return self.number if self.drawn_from is None else self.drawn_from

    @property
    def limit(self) -> float:
        """The speed that is allowed, in m/s."""
        return self.speed / 3.6

    @cached_property
    def still(self) -> World:
        """All but the actors, in road coordinates, at the beginning."""
        length = 20.0 * self.limit + AHEAD
        plan = replace(self.plan, spans=((BEHIND, length),), driving=20.0)
        things = street(np.random.default_rng((self.seed, 30)), plan)
        ground = Ground(slope=self.slope, width=ROAD_WIDTH, crown=0.02, kerb=0.13, verge=0.02)
        return world_of(ground, [thing for thing in things if self._fits(thing)])

    def _fits(self, thing: Obstacle) -> bool:
        """Whether a thing is in nobody's way: traffic in our lane is an actor's part."""
        x, y, *_ = thing.pose.x, thing.pose.y
        if abs(y) < PARKED - 1.0:
            return y > 0 and self.traffic
        if self.traffic and 0 < y < FURNITURE - 1.0:
            return False  # nobody parks where two cars just pass each other
        return not any(_is_in_the_way(thing, x, y, actor) for actor in self.actors)

    def world(self, time: float, position: float, began: dict[int, float]) -> World:
        """The world around us, seen from the car.

        Parameters
        ----------
        time : float
            Seconds since the beginning of the drive.
        position : float
            Metres along the road of our scanner.
        began : dict of int to float
            When each actor began, by its place in `actors`.
        """
        still = self.still
        moved = [thing.at(time) if thing.speed else thing for thing in still.obstacles]
        moved += [
            replace(actor.at(time, began.get(place)), identity=self._identity(place))
            for place, actor in enumerate(self.actors)
        ]
        near = (thing for thing in moved if BEHIND < thing.pose.x - position < AHEAD)
        world = replace(still, obstacles=tuple(near))
        return world.seen_from(Pose(position, EGO_LANE))

    def _identity(self, place: int) -> int:
        return len(self.still.obstacles) + 1 + place

    @cached_property
    def road_users(self) -> dict[int, str]:
        """Kinds of all that moves or may move in this street, by identity."""
        moving = {thing.identity: thing.kind for thing in self.still.obstacles if thing.speed}
        return moving | {
            self._identity(place): actor.obstacle.kind for place, actor in enumerate(self.actors)
        }

    def kind_of(self, identity: int) -> str:
        """What a thing is, by its identity."""
        if identity in self.road_users:
            return self.road_users[identity]
        return self.still.obstacles[identity - 1].kind


def _is_in_the_way(thing: Obstacle, x: float, y: float, actor: Actor) -> bool:
    """Whether a thing stands where an actor walks, or hides it."""
    pose, moves = actor.obstacle.pose, actor.speeds[-1][1] > 0
    across = moves and abs(math.sin(pose.yaw)) > 0.5
    if not across:
        return (
            abs(y - pose.y) < 3.0
            and abs(x - pose.x) < (thing.size[0] + actor.obstacle.size[0]) / 2 + 1.0
        )
    same_side = y * pose.y > 0
    half = thing.size[0] / 2
    from_afar = abs(pose.y) > WALKERS  # out of a side street, so there is one
    if abs(y) > FRONTS or from_afar:
        return same_side and from_afar and abs(x - pose.x) < half + 3.5
    if thing.speed:  # walkers make room
        return same_side and abs(x - pose.x) < 12.0
    # What hides somebody who steps off the kerb is put there on purpose, or not at all.
    return -half - 1.5 < x - pose.x < half + 1.5 or (same_side and -9.0 < x - pose.x < half + 1.5)


def _streets() -> Iterable[Street]:
    """The twenty, in order."""
    v30, v50 = 30 / 3.6, 50 / 3.6
    empty = StreetPlan(parked=math.inf, furniture=16.0, walkers=30.0)
    crowded = StreetPlan(parked=1.5, furniture=6.0, walkers=7.0, clearance=1.2)
    lorry = standing(truck(width=2.3), 70.0, -4.05)
    yield Street(1, "A quiet street", traffic=True)
    yield Street(2, "A child runs out from the kerb", actors=(child(70, v30),))
    yield Street(3, "A cyclist crosses", actors=(crossing_cyclist(75, v30, 2.78),))
    yield Street(4, "Somebody behind a parked lorry", 20, actors=(lorry, peeping(75.5, 20 / 3.6)))
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
    yield Street(10, "A dirty bonnet", dirt=True, traffic=True)
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
    yield Street(13, "A wide road at 50", 50, slope=0.025, traffic=True, plan=empty)
    yield Street(14, "Somebody crosses a wide road", 50, plan=empty, actors=(adult(110, v50),))
    yield Street(15, "A crowded street", traffic=True, plan=crowded)
    yield Street(16, "Downhill", slope=-0.05, actors=(adult(90, v30, side=1),))
    yield Street(17, "Behind a cyclist", traffic=True, actors=(slow_cyclist(25),))
    yield Street(
        18, "Rain, a dirty bonnet and a child", rain=60, dirt=True, actors=(child(75, v30),)
    )
    yield Street(19, "Somebody runs", actors=(adult(80, v30, pace=2.22),), plan=crowded)
    yield Street(
        20,
        "All of it",
        rain=40,
        dirt=True,
        slope=0.03,
        actors=(
            child(60, v30),
            car_ahead(75, 4.0, 45, (0, 4.0), (2, v30)),
            crossing_cyclist(120, v30),
        ),
        plan=crowded,
    )


STREETS: tuple[Street, ...] = tuple(_streets())
