"""Streams of simulated frames, under the names that lessons import."""

from utils.simulator.frames import Frame, Stream
from utils.simulator.scenes import (
    ROAD,
    city_block,
    cyclist,
    highway,
    lesson_street,
    random_street,
    simple_highway,
)

__all__ = [
    "ROAD",
    "Frame",
    "Stream",
    "city_block",
    "cyclist",
    "highway",
    "lesson_street",
    "random_street",
    "simple_highway",
]
