"""True objects around the car, to evaluate a drive and to replace a missing detector."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from utils.boxes import Box, distances_between
from utils.drive.planner import TrackedBox
from utils.drive.rules import BUMPER, HALF_WIDTH, TAIL
from utils.simulator.frames import Frame
from utils.simulator.world import Obstacle, World

FEWEST_RETURNS = 5
"""Smallest number of returns with which an object counts as visible."""
EGO_CAR = Box(((TAIL + BUMPER) / 2, 0.0, 0.0), (BUMPER - TAIL, 2 * HALF_WIDTH, 1.0), 0.0, "car", 0)


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
    near = [
        pair
        for pair in true_tracked_boxes(world)
        if np.hypot(*pair[1].corners[:4, :2].T).min() < 15
    ]
    corners = np.reshape([box.corners for _, box in near], (-1, 8, 3))
    apart = distances_between(EGO_CAR.corners[None], corners)[0].tolist()
    return {obstacle.identity: gap for (obstacle, _), gap in zip(near, apart, strict=True)}
