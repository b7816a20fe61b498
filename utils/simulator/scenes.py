"""Ready-made scenes: a highway, a city block, a ride behind a cyclist, and random streets.

`python -m utils.simulator.scenes` rewrites `data/cloud.txt` and `data/cloud_truth.npz`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from utils.simulator.frames import Frame, Stream, observe
from utils.simulator.ground import Ground
from utils.simulator.layouts import lesson_obstacles, square, winding_pose
from utils.simulator.pose import Pose
from utils.simulator.scanner import CLASSES
from utils.simulator.sensor import Sensor, hdl64, highway_sensor
from utils.simulator.streets import (
    EGO_LANE,
    ROAD_WIDTH,
    StreetPlan,
    numbered,
    placed,
    street,
    world_of,
)
from utils.simulator.traffic import block_car
from utils.simulator.traffic import cyclist as bicycle
from utils.simulator.world import World

__all__ = [
    "city_block",
    "cyclist",
    "highway",
    "lesson_street",
    "random_street",
    "simple_highway",
    "write_lesson_cloud",
]


def simple_highway(seed: int = 0) -> Frame:
    """Return three block cars on a flat road, seen by the 8-layer sensor on a fourth car."""
    return _highway_frame(seed, 0)


def highway(seed: int = 0, frames: int = 30) -> Stream:
    """Return the simple highway in motion, with different speeds and the ego car at 20 m/s."""
    return Stream(partial(_highway_frame, seed), range(frames))


def _highway_frame(seed: int, number: int) -> Frame:
    time, ego_speed = number / 10, 20.0
    obstacles = (
        placed(block_car(), 15.0, 0.0, speed=21.0),
        placed(block_car(), 8.0, -4.0, speed=18.0),
        placed(block_car(), -12.0, 4.0, speed=23.0),
    )
    # The ego car is 0.1 m lower than the others, because the rays of the original simulation took
    # steps of 0.2 m and so passed through the edge of the ego car's roof.
    world = World(Ground(), numbered(obstacles), ego=block_car(height=1.9).solids)
    vehicle = Pose(ego_speed * time)
    return observe(world.seen_from(vehicle, time), highway_sensor(), (seed, number), time)


ROAD = Ground(slope=0.022, width=ROAD_WIDTH, crown=0.02, kerb=0.13, pavement_slope=0.02)
"""A street that climbs gently."""


def lesson_street(seed: int = 0) -> Frame:
    """Return the frame in `data/cloud.txt`: a street laid out by hand near the sensor.

    Within 10 m there are parked, passing and turning cars, people, a cyclist, poles and trees.
    """
    rng = np.random.default_rng((seed, 1))
    far = StreetPlan(
        spans=((-85.0, -27.0), (27.0, 95.0)), parked=2.0, furniture=6.0, untidiness=0.05
    )
    obstacles = [*lesson_obstacles(), *street(rng, far)]
    world = world_of(ROAD, obstacles).seen_from(Pose(0.0, EGO_LANE))
    return observe(world, hdl64(), (seed, 2))


def city_block(seed: int = 0, frames: int = 30) -> Stream:
    """Return a drive at 5 m/s through a street with parked and moving cars, people and trees."""
    return Stream(partial(_city_frame, seed), range(frames))


def _city_frame(seed: int, number: int) -> Frame:
    time = number / 10
    vehicle = Pose(5.0 * time, EGO_LANE)
    return observe(_city_world(seed).seen_from(vehicle, time), hdl64(), (seed, number), time)


@lru_cache(maxsize=4)
def _city_world(seed: int) -> World:
    plan = StreetPlan(spans=((-80.0, 110.0),), parked=2.5, walkers=7.0, driving=14.0)
    return world_of(ROAD, street(np.random.default_rng((seed, 3)), plan))


def cyclist(seed: int = 0, frames: int = 60) -> Stream:
    """Return a winding ride behind a weaving cyclist, past turning cars."""
    return Stream(partial(_cyclist_frame, seed), range(frames))


def _cyclist_frame(seed: int, number: int) -> Frame:
    time = number / 10
    world = square(seed)
    x, y, yaw, speed = winding_pose(9.0 + 4.2 * time, 4.2, 1.4, 1.6)
    rider = placed(bicycle(), x, y, yaw, speed)
    rider = replace(rider, identity=len(world.obstacles) + 1)
    # `seen_from` advances every obstacle by `time`, but the rider's pose is already at that time.
    rider = replace(rider.at(-time), turn_rate=0.0)
    world = replace(world, obstacles=(*world.obstacles, rider))
    x, y, yaw, _ = winding_pose(4.5 * time, 4.5, 0.0, 0.0)
    vehicle = Pose(x, y, 0.0, yaw)
    return observe(world.seen_from(vehicle, time), hdl64(), (seed, number), time)


def random_street(seed: int, difficulty: float = 0.5, sensor: Sensor | None = None) -> Frame:
    """Return a random street.

    Parameters
    ----------
    seed : int
        The same seed, difficulty and sensor give the same frame.
    difficulty : float
        From 0 (flat, empty, wide gaps) to 1 (steep, crowded, 0.7 m gaps).
    sensor : Sensor, optional
        By default `hdl64()`.

    Raises
    ------
    ValueError
        The difficulty is not between 0 and 1.
    """
    if not 0.0 <= difficulty <= 1.0:
        raise ValueError(f"The difficulty must be a number from 0 to 1, not {difficulty}.")
    rng = np.random.default_rng((seed, 5))
    ease = 1.0 - difficulty
    plan = StreetPlan(
        parked=2.0 + 10.0 * ease,
        furniture=5.0 + 20.0 * ease,
        walkers=5.0 + 35.0 * ease,
        driving=12.0 + 25.0 * ease,
        clearance=0.7 + 1.3 * ease,
        untidiness=0.05 * difficulty,
        hedges=difficulty,
    )
    ground = Ground(
        slope=difficulty * 0.03 * (2 * rng.random() - 1),
        width=ROAD_WIDTH,
        crown=0.02 * difficulty,
        kerb=0.04 + 0.10 * difficulty,
        pavement_slope=0.02 * difficulty,
    )
    vehicle = Pose(0.0, EGO_LANE, 0.0, 0.05 * (2 * rng.random() - 1))
    world = world_of(ground, street(rng, plan)).seen_from(vehicle)
    return observe(world, sensor or hdl64(), (seed, 6))


def write_lesson_cloud(folder: Path) -> None:
    """Write `cloud.txt` and `cloud_truth.npz` into a folder.

    The text file has one return per line: x y z to the millimetre, intensity to the hundredth.
    """
    frame = lesson_street()
    cloud = np.round(frame.cloud, 3) + 0.0  # adding zero turns -0.0 into 0.0
    # With a point at exactly z = -1.200, a lesson's answer would depend on `>` or `>=`.
    cloud[cloud[:, 2] == -1.2, 2] = -1.201
    line = "%.3f %.3f %.3f %.2f\n"
    text = (line * len(cloud)) % tuple(cloud.ravel().tolist())
    (folder / "cloud.txt").write_bytes(text.encode("ascii"))
    boxes = frame.boxes
    np.savez_compressed(
        folder / "cloud_truth.npz",
        classes=frame.scan.classes,
        objects=frame.scan.objects,
        beams=frame.scan.beams,
        class_names=np.array(CLASSES),
        box_centres=np.array([box.centre for box in boxes]),
        box_sizes=np.array([box.size for box in boxes]),
        box_yaws=np.array([box.yaw for box in boxes]),
        box_kinds=np.array([box.kind for box in boxes]),
        box_identities=np.array([box.identity for box in boxes], dtype=np.int32),
        box_velocities=np.array([box.velocity for box in boxes]),
        box_returns=np.array([box.returns for box in boxes], dtype=np.int32),
    )


if __name__ == "__main__":
    write_lesson_cloud(Path(__file__).resolve().parents[2] / "data")
