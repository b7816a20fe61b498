"""True objects around the car, to evaluate a drive and to replace a missing detector."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from utils.boxes import Box
from utils.drive.planner import TrackedBox
from utils.drive.rules import BUMPER, HALF_WIDTH, TAIL
from utils.simulator.frames import Frame
from utils.simulator.world import Obstacle, World

FEWEST_RETURNS = 5
"""Smallest number of returns with which an object counts as visible."""


def true_boxes(frame: Frame) -> np.ndarray:
    """Return the boxes (N, 8, 3) of all visible objects, like a perfect detector."""
    seen = [box.corners for box in frame.boxes if box.returns >= FEWEST_RETURNS]
    return np.reshape(seen, (-1, 8, 3)).astype(float)


def true_tracked_boxes(world: World) -> Iterator[tuple[Obstacle, TrackedBox]]:
    """Yield each obstacle of a world, in the vehicle's frame, with its `TrackedBox`."""
    for obstacle in world.obstacles:
        pose = obstacle.pose
        box = Box((pose.x, pose.y, obstacle.size[2] / 2), obstacle.size, pose.yaw, obstacle.kind, 0)
        velocity = obstacle.speed * math.cos(pose.yaw), obstacle.speed * math.sin(pose.yaw)
        yield obstacle, TrackedBox(box.corners, velocity)


def distances_to_objects(world: World) -> dict[int, float]:
    """Return the horizontal distance in metres from the ego car to each object near it.

    The keys are the identities of the objects.
    """
    import shapely

    near = [
        pair
        for pair in true_tracked_boxes(world)
        if np.hypot(*pair[1].corners[:4, :2].T).min() < 15
    ]
    footprints = shapely.convex_hull(shapely.multipoints([box.corners[:4, :2] for _, box in near]))
    apart = shapely.distance(_ego_footprint(), footprints).tolist() if near else []
    return {obstacle.identity: gap for (obstacle, _), gap in zip(near, apart, strict=True)}


@lru_cache(maxsize=1)
def _ego_footprint() -> object:
    import shapely

    return shapely.box(TAIL, -HALF_WIDTH, BUMPER, HALF_WIDTH)
