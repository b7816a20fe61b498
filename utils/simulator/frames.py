"""Frames (scans with their true boxes) and streams of frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from utils.boxes import Box
from utils.simulator.scanner import Scan, scan
from utils.simulator.sensor import Sensor
from utils.simulator.world import World


@dataclass(frozen=True, eq=False)
class Frame:
    """One scan with its true boxes and its start time in seconds."""

    scan: Scan
    boxes: tuple[Box, ...]
    time: float = 0.0

    @property
    def cloud(self) -> np.ndarray:
        """Returns of the scan, shape (n, 4); see `utils.simulator.Scan`."""
        return self.scan.cloud


@dataclass(frozen=True)
class Stream(Sequence):
    """Frames that are rendered on access, always with the same result.

    Parameters
    ----------
    render : callable
        Takes a frame number and returns the frame.
    numbers : range
        Numbers of the frames in this stream. A slice of a stream is a stream.
    """

    render: Callable[[int], Frame]
    numbers: range

    def __len__(self) -> int:
        return len(self.numbers)

    def __getitem__(self, index: int | slice) -> Frame | Stream:
        chosen = self.numbers[index]
        return Stream(self.render, chosen) if isinstance(index, slice) else self.render(chosen)


def observe(world: World, sensor: Sensor, seed: int | Sequence[int], time: float = 0.0) -> Frame:
    """Scan a world in the vehicle's frame, and add the true boxes of all obstacles seen."""
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
