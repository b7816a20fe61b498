"""Streams of simulated frames, by the name under which lessons import them."""

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
