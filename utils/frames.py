"""One sweep with its true boxes, and streams of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from utils.pose import Pose
from utils.simulator import Scan, Sensor, scan
from utils.world import World


@dataclass(frozen=True)
class Box:
    """The true box of an obstacle that returned at least one echo, in sensor coordinates.

    Parameters
    ----------
    centre : tuple of float
        x, y, z of its middle in metres.
    size : tuple of float
        Length, width, height in metres.
    yaw : float
        Heading of its length in radians, from the x axis towards y, in [-pi, pi).
    kind : str
        One of `utils.simulator.CLASSES`.
    identity : int
        The same number in every frame of a stream, and in `Scan.objects`.
    velocity : tuple of float
        Metres per second over the ground along the sensor's x and y axes.
    returns : int
        Number of echoes in this frame.
    """

    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    yaw: float
    kind: str
    identity: int
    velocity: tuple[float, float] = (0.0, 0.0)
    returns: int = 0

    @property
    def corners(self) -> np.ndarray:
        """Shape (8, 3): the floor anticlockwise from front left, then the roof alike."""
        signs = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) / 2
        half = self.size[2] / 2
        floor = np.column_stack([signs * self.size[:2], np.full(4, -half)])
        return Pose(*self.centre, self.yaw).apply(np.vstack([floor, floor + (0, 0, 2 * half)]))


@dataclass(frozen=True, eq=False)
class Frame:
    """One sweep, the true boxes in it, and when it began, in seconds."""

    scan: Scan
    boxes: tuple[Box, ...]
    time: float = 0.0

    @property
    def cloud(self) -> np.ndarray:
        """The returns, shape (n, 4); see `utils.simulator.Scan`."""
        return self.scan.cloud


@dataclass(frozen=True)
class Stream(Sequence):
    """Frames that are rendered when asked for, always with the same result.

    Parameters
    ----------
    render : callable
        Makes the frame of a given number.
    numbers : range
        The frames in this stream. A slice of a stream is a stream.
    """

    render: Callable[[int], Frame]
    numbers: range

    def __len__(self) -> int:
        return len(self.numbers)

    def __getitem__(self, index):
        chosen = self.numbers[index]
        return Stream(self.render, chosen) if isinstance(index, slice) else self.render(chosen)


def observe(
    world: World, sensor: Sensor, seed: int | Sequence[int], time: float = 0.0
) -> Frame:
    """Scan a world, given in the vehicle's frame, and box what was seen of it."""
    swept = scan(world, sensor, seed)
    echoes = np.bincount(swept.objects) if len(swept.objects) else np.zeros(1, dtype=int)
    boxes = []
    for thing in world.obstacles:
        if thing.identity >= len(echoes) or not echoes[thing.identity]:
            continue
        base = world.base(thing)
        x, y, floor = np.subtract((base.x, base.y, base.z), sensor.origin).tolist()
        velocity = thing.speed * np.array([math.cos(base.yaw), math.sin(base.yaw)]) + 0.0
        boxes.append(
            Box(
                (x, y, floor + thing.size[2] / 2),
                thing.size,
                (base.yaw + math.pi) % (2 * math.pi) - math.pi,
                thing.kind,
                thing.identity,
                tuple(velocity.tolist()),
                int(echoes[thing.identity]),
            )
        )
    return Frame(swept, tuple(boxes), time)
