"""Simulated scans, with their true boxes, for the checks of detectors.

Detectors differ in the region that they keep, in how they thin the cloud and in the height at which
they cut the ground. The checks therefore rely on obstacles that every sensible detector finds: cars
and people near the sensor, with nothing close to them.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from utils.boxes import Box
from utils.checks.assertions import frozen

if TYPE_CHECKING:
    from utils.simulator import Sensor
    from utils.simulator.frames import Frame
    from utils.simulator.world import Obstacle

MAX_DISTANCES = {"car": 7.5, "pedestrian": 7.0}  # metres; whole cars are within 10 m
MIN_RETURNS = {"car": 1500, "pedestrian": 150}  # with every second azimuth
SQUARE_REACH = 12.0  # in metres, 2 m beyond the farthest corner of a car
MIN_GAP = 1.2  # minimum distance to the nearest other object, in metres
EGO_CAR = frozen(np.array([[-1.5, -1.7], [2.6, 1.7]]))  # ego car: lowest and highest x and y (m)


def half_sensor() -> Sensor:
    """Return the 64-beam scanner with every second azimuth: half the returns in half the time."""
    from utils.simulator import hdl64

    sensor = hdl64()
    return dataclasses.replace(sensor, azimuth_step=2 * sensor.azimuth_step)


@functools.cache
def street(distance: float = 0.0) -> Frame:
    """Return a scan of the street in `data/cloud.txt`, from the same or another place on the road.

    Parameters
    ----------
    distance : float
        Distance along the road from the place of the scan in that file, in metres.
    """
    from utils.scenes import ROAD
    from utils.simulator.frames import observe
    from utils.simulator.layouts import lesson_obstacles
    from utils.simulator.pose import Pose
    from utils.simulator.streets import EGO_LANE, world_of

    world = world_of(ROAD, lesson_obstacles()).seen_from(Pose(distance, EGO_LANE))
    return observe(world, half_sensor(), 12)


def street_further_back() -> Frame:
    """Return a scan of `street` from 4 m further back, so all its cars have other coordinates."""
    return street(-4.0)


@functools.lru_cache(maxsize=64)
def square(seed: int) -> Frame:
    """Return a scan of three cars around the sensor, not parallel to x or y, between houses.

    Most checks of detectors use these scans. To save time, they omit returns farther away than
    the cars.
    """
    frames = (_random_square((seed, 12, attempt), 3, 0) for attempt in itertools.count())
    frame = next(frame for frame in frames if len(clear_cars(frame)) == 3)
    return _select_returns(frame, np.hypot(frame.cloud[:, 0], frame.cloud[:, 1]) < SQUARE_REACH)


@functools.lru_cache(maxsize=64)
def square_with_people(seed: int) -> Frame:
    """Return a scan as in `square`, but of one car and three people, all clear of others."""
    frames = (_random_square((seed, 21, attempt), 1, 3) for attempt in itertools.count())
    return next(
        frame for frame in frames if len(clear_cars(frame)) == 1 and len(clear_people(frame)) == 3
    )


@functools.lru_cache(maxsize=64)
def car_crossing(seed: int) -> Frame:
    """Return a scan as in `square`, but of one small car across the road, 8 to 10 m ahead."""
    from utils.simulator.streets import placed
    from utils.simulator.traffic import car

    rng = np.random.default_rng((seed, 8))
    length, width = rng.uniform((3.7, 1.65), (3.8, 1.68))
    y = rng.uniform(-0.05, 0.05)
    x = math.sqrt(9.98**2 - (length / 2 + abs(y)) ** 2) - width / 2  # the corners are within 10 m
    yaw = np.radians(90 + 180 * rng.integers(2))
    return _scan_square([placed(car(length, width, rng.uniform(1.45, 1.6)), x, y, yaw)], rng, seed)


CLIMB = 0.04  # rise of the road in `climbing_road`, in metres per metre
GAP = 0.85  # distance between the two parked cars in `climbing_road`, in metres


@functools.lru_cache(maxsize=64)
def climbing_road(seed: int) -> Frame:
    """Return a scan of a road that climbs, with obstacles that simple detectors miss.

    A person stands right next to the bumper. A lorry is on the same side. On the other side, two
    cars are parked one close behind the other, at the edge of the road.
    """
    from utils.simulator.frames import observe
    from utils.simulator.ground import Ground
    from utils.simulator.streets import placed, random_car, random_pedestrian, world_of
    from utils.simulator.traffic import truck

    rng = np.random.default_rng((seed, 34))
    side = rng.choice([-1, 1])
    first, second = random_car(rng), random_car(rng)
    x, y = rng.uniform(1.5, 2.5), 4.9 * side
    gap = (first.size[0] + second.size[0]) / 2 + GAP
    person = (rng.uniform(3.2, 3.4), -side * rng.uniform(2.15, 2.35))
    obstacles = [
        placed(random_pedestrian(rng), *person),
        placed(truck(rng.uniform(11.5, 12.5)), rng.uniform(5.0, 6.0), -5.2 * side, 0.0),
        placed(first, x, y, 0.0),
        placed(second, x + gap, y, 0.0),
    ]
    return observe(world_of(Ground(slope=CLIMB), obstacles), half_sensor(), seed)


@functools.lru_cache(maxsize=64)
def people_around_ego_car(seed: int) -> Frame:
    """Return a scan of a level road, with a person ahead of the ego car and another next to it.

    A box of the ego car that is much too long or too wide contains one of them.
    """
    from utils.simulator.frames import observe
    from utils.simulator.ground import Ground
    from utils.simulator.streets import placed, random_pedestrian, world_of

    rng = np.random.default_rng((seed, 55))
    ahead = rng.uniform((3.6, -0.6), (4.2, 0.6))
    aside = rng.uniform((-0.8, 2.5), (1.9, 2.7)) * [1, rng.choice([-1, 1])]
    people = [placed(random_pedestrian(rng), *place) for place in (ahead, aside)]
    return observe(world_of(Ground(), people), half_sensor(), seed)


def car_across(frame: Frame) -> Box:
    """Return the true box of the car across the road in `car_crossing`."""
    return min(
        (box for box in frame.boxes if box.kind == "car"),
        key=lambda box: math.hypot(box.centre[0] - 9.0, box.centre[1]),
    )


def _random_square(seed: Sequence[int], cars: int, people: int) -> Frame:
    from utils.simulator.streets import placed, random_car, random_pedestrian

    rng = np.random.default_rng(seed)
    obstacles = []
    for _ in range(200):
        # Cars are diagonal, so that axis-aligned boxes are much too large. They are ahead or
        # behind, because there is little room next to the ego car.
        yaw = np.radians(45 + 90 * rng.integers(4) + rng.uniform(-12, 12))
        x, y = rng.uniform((-7.2, -3.6), (7.2, 3.6))
        obstacle = placed(
            random_car(rng) if len(obstacles) < cars else random_pedestrian(rng), x, y, yaw
        )
        if len(obstacles) < cars + people and _has_room(obstacle, obstacles):
            obstacles.append(obstacle)
    return _scan_square(obstacles, rng, seed)


def _scan_square(
    obstacles: list[Obstacle], rng: np.random.Generator, seed: int | Sequence[int]
) -> Frame:
    """Return a scan of obstacles around the sensor, two walking pedestrians and houses."""
    from utils.simulator.frames import observe
    from utils.simulator.ground import Ground
    from utils.simulator.streets import StreetPlan, placed, random_pedestrian, street, world_of

    obstacles = list(obstacles)
    obstacles += [placed(random_pedestrian(rng), x, 0.0, speed=1.3) for x in (-12.0, 12.0)]
    empty = float("inf")
    houses = StreetPlan(
        ((-40.0, 40.0),), parked=empty, furniture=empty, driving=empty, walkers=15.0
    )
    ground = Ground(slope=0.02 * rng.uniform(-1, 1), width=10.0, crown=0.01, kerb=0.1)
    return observe(world_of(ground, [*obstacles, *street(rng, houses)]), half_sensor(), seed)


def _has_room(obstacle: Obstacle, other_obstacles: Sequence[Obstacle]) -> bool:
    """Return whether an obstacle is near the sensor, and clear of the ego car and the others."""
    if not 4.0 < math.hypot(obstacle.pose.x, obstacle.pose.y) < 0.98 * MAX_DISTANCES[obstacle.kind]:
        return False
    rim = _outline_points(obstacle)
    if ((rim > EGO_CAR[0] - MIN_GAP) & (rim < EGO_CAR[1] + MIN_GAP)).all(axis=1).any():
        return False
    gaps = (
        np.linalg.norm(rim[:, None] - _outline_points(other), axis=2).min()
        for other in other_obstacles
    )
    return all(gap > 1.2 * MIN_GAP for gap in gaps)


def _outline_points(obstacle: Obstacle) -> np.ndarray:
    """Return points along the outline of an obstacle's footprint; shape (n, 2)."""
    side = np.linspace(-0.5, 0.5, 20)
    half = np.full(20, 0.5)
    rim = (
        np.vstack(
            [
                np.column_stack(pair)
                for pair in ((side, half), (side, -half), (half, side), (-half, side))
            ]
        )
        * obstacle.size[:2]
    )
    cosine, sine = math.cos(obstacle.pose.yaw), math.sin(obstacle.pose.yaw)
    turn = np.array([[cosine, sine], [-sine, cosine]])
    return rim @ turn + [obstacle.pose.x, obstacle.pose.y]


@functools.lru_cache(maxsize=64)
def clear_cars(frame: Frame) -> tuple[Box, ...]:
    """Return the cars that no detector may miss: near, with many returns, clear of others."""
    return _clear_objects(frame, "car")


@functools.lru_cache(maxsize=64)
def clear_people(frame: Frame) -> tuple[Box, ...]:
    """Return the people that no detector may miss; see `clear_cars`."""
    return _clear_objects(frame, "pedestrian")


def _clear_objects(frame: Frame, kind: str) -> tuple[Box, ...]:
    from scipy.spatial import cKDTree

    xyz, objects = frame.cloud[:, :3], frame.scan.objects
    chosen = []
    for box in frame.boxes:
        far = math.hypot(*box.centre[:2]) > MAX_DISTANCES[kind]
        if box.kind != kind or far or box.returns < MIN_RETURNS[kind]:
            continue
        close = np.hypot(*(xyz[:, :2] - box.centre[:2]).T) < 6.0
        own = xyz[objects == box.identity]
        close &= ((xyz > own.min(axis=0) - MIN_GAP) & (xyz < own.max(axis=0) + MIN_GAP)).all(axis=1)
        others = xyz[close & (objects > 0) & (objects != box.identity)]
        gaps = (
            cKDTree(others).query(own, distance_upper_bound=MIN_GAP)[0] if len(others) else np.inf
        )
        if np.isinf(gaps).all():
            chosen.append(box)
    return tuple(chosen)


def remove_car(car: Box, frame: Frame) -> Frame:
    """Return a frame without the returns and the box of one car; its shadow remains."""
    boxes = tuple(box for box in frame.boxes if box.identity != car.identity)
    left = _select_returns(frame, frame.scan.objects != car.identity)
    return dataclasses.replace(left, boxes=boxes)


def _select_returns(frame: Frame, rows: np.ndarray) -> Frame:
    """Return a frame with only the returns that a mask selects, but with all its boxes."""
    columns = {
        field.name: getattr(frame.scan, field.name)[rows]
        for field in dataclasses.fields(frame.scan)
    }
    return dataclasses.replace(frame, scan=dataclasses.replace(frame.scan, **columns))


def ego_car_points(seed: int) -> np.ndarray:
    """Return points all over the bonnet and roof of the ego car.

    They are inside the ego car's box in lesson 07 and remain dense after thinning.

    Returns
    -------
    numpy.ndarray, shape (n, 4)
    """
    rng = np.random.default_rng(seed)
    (back, right), (front, left) = EGO_CAR
    x, y = np.mgrid[back + 0.04 : front - 0.04 : 0.08, right + 0.04 : left - 0.04 : 0.08]
    bonnet, roof = rng.uniform((-0.95, -0.65), (-0.8, -0.5))
    z = np.where(x > 0.8, bonnet, roof)
    rows = np.stack([x, y, z, np.full(x.shape, 0.5)], axis=-1).reshape(-1, 4)
    rows[:, :3] += rng.uniform(-0.02, 0.02, (len(rows), 3))
    return rows


def insert_invalid(cloud: np.ndarray, seed: int) -> np.ndarray:
    """Insert 3000 lost returns into a cloud: at (0, 0, 0), or with a NaN or infinite coordinate.

    Parameters
    ----------
    cloud : numpy.ndarray, shape (n, 4)
    seed : int

    Returns
    -------
    numpy.ndarray, shape (n + 3000, 4)
    """
    rng = np.random.default_rng(seed)
    lost = np.zeros((3000, 4))
    lost[:1000, :3] = np.nan
    lost[1000:2000, :3] = rng.uniform((3, -3, -1), (9, 3, 0), (1000, 3))
    for first, (axis, value) in enumerate([(0, np.inf), (2, -np.inf), (1, np.nan), (2, np.nan)]):
        lost[1000 + 250 * first : 1250 + 250 * first, axis] = value
    return np.insert(cloud, rng.integers(0, len(cloud), len(lost)), lost, axis=0)


@functools.lru_cache(maxsize=64)
def raindrops(seed: int) -> np.ndarray:
    """Return single points in the air above a square, far from its objects and each other.

    Parameters
    ----------
    seed : int
        Seed of the `square`.

    Returns
    -------
    numpy.ndarray, shape (n, 4)
    """
    from scipy.spatial import cKDTree

    rng = np.random.default_rng(seed)
    frame = square(seed)
    places = rng.uniform((-11, -5.5), (18, 5.5), (400, 2))
    obstacles = cKDTree(frame.cloud[frame.scan.objects > 0, :2])
    places = places[(obstacles.query(places)[0] > 1.5) & (np.hypot(*places.T) > 3.5)]
    drops = []
    for place in places:
        if all(np.hypot(*(place - other)) > 2.0 for other in drops):
            drops.append(place)
    return np.column_stack([drops, rng.uniform((-0.9, 0.0), (0.3, 0.1), (len(drops), 2))])
