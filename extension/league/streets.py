"""The streets of a league, drawn from the secret seed so that students cannot practise on them.

In each street, a vehicle blocks our lane and drives off only some seconds after our car comes near.
Further on, another road user gets in the way. A car that sees nothing therefore hits one of them,
whether it drives fast or slowly.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable

import numpy as np

from utils.drive.actors import Actor, adult, child, crossing_cyclist, slow_cyclist
from utils.drive.streets import Street
from utils.simulator.streets import EGO_LANE, StreetPlan, placed
from utils.simulator.traffic import car, truck

SPEED = 30 / 3.6
CROWDED_STREET = StreetPlan(parked=1.5, furniture=6.0, walkers=7.0, clearance=1.2)

WAIT_DISTANCE = 18.0
"""Distance in metres from our scanner to the waiting vehicle at which its waiting time begins.

Our car has to brake at this distance at the latest.
"""


def _waiting_vehicle(rng: np.random.Generator) -> Actor:
    """Return a car or lorry in our lane that drives off some seconds after our car comes near."""
    vehicle = (
        truck(width=2.3)
        if rng.random() < 0.3
        else car(*rng.uniform((4, 1.7, 1.4), (4.6, 1.8, 1.6)))
    )
    place, wait = rng.uniform(37.0, 43.0), rng.uniform(5.0, 6.0)
    tail = place + vehicle.size[0] / 2
    pace = ((0.0, 0.0), (wait, 0.0), (wait + 3.0, 12.0))
    return Actor(placed(vehicle, tail, EGO_LANE), place - WAIT_DISTANCE, pace)


def _random_position(rng: np.random.Generator) -> float:
    """Return a random position along the road, in metres, beyond the waiting vehicle."""
    return rng.uniform(88.0, 100.0)


def _waiting_street(rng: np.random.Generator) -> dict:
    return {"title": "A vehicle waits in the lane", "traffic": True}


def _child_street(rng: np.random.Generator) -> dict:
    return {"title": "A child runs out", "actors": (child(_random_position(rng), SPEED),)}


def _cyclist_street(rng: np.random.Generator) -> dict:
    rider = crossing_cyclist(_random_position(rng), SPEED, rng.uniform(2.6, 4.2))
    return {"title": "A cyclist crosses", "actors": (rider,)}


def _uphill_street(rng: np.random.Generator) -> dict:
    return {
        "title": "Uphill in the rain",
        "slope": rng.uniform(0.035, 0.06),
        "rain": int(rng.integers(40, 70)),
        "actors": (adult(_random_position(rng), SPEED, side=int(rng.choice((-1, 1)))),),
    }


def _dirty_bonnet_street(rng: np.random.Generator) -> dict:
    rider = slow_cyclist(_random_position(rng) - 10.0)
    return {
        "title": "Behind a dirty bonnet",
        "has_dirty_bonnet": True,
        "traffic": True,
        "actors": (rider,),
    }


def _crowded_street(rng: np.random.Generator) -> dict:
    x = _random_position(rng)
    pair = adult(x, SPEED), adult(x + rng.uniform(0.8, 1.0), SPEED)
    slope = -rng.uniform(0.02, 0.05)
    return {"title": "Two people, downhill", "slope": slope, "plan": CROWDED_STREET, "actors": pair}


STREET_KINDS: tuple[Callable[[np.random.Generator], dict], ...] = (
    _waiting_street,
    _child_street,
    _cyclist_street,
    _uphill_street,
    _dirty_bonnet_street,
    _crowded_street,
)
"""One function per street, for the settings that differ from those of the other streets."""


@functools.cache
def draw_streets(seed: int) -> tuple[Street, ...]:
    """Return the streets of a course.

    Parameters
    ----------
    seed : int
        The course's secret. Streets are drawn from digests of the seed. A digest does not reveal
        the seed, and no hidden test uses it.
    """
    return tuple(_draw_street(seed, number) for number in range(1, len(STREET_KINDS) + 1))


def _draw_street(seed: int, street_number: int) -> Street:
    source = derive_secret(seed, f"street {street_number}")
    rng = np.random.default_rng((source, 29))
    first = _waiting_vehicle(rng)
    settings = STREET_KINDS[street_number - 1](rng)
    actors = (first, *settings.pop("actors", ()))
    return Street(street_number, **settings, actors=actors, random_seed=source)


def derive_secret(seed: int, label: str) -> int:
    """Derive a number from the seed and a label; it reveals neither the seed nor other numbers."""
    digest = hashlib.sha256(f"league: {seed} {label}".encode()).digest()
    return int.from_bytes(digest, "big")
