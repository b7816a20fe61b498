"""A part of `utils.simulator`, by the name under which a lesson imports it."""

from utils.simulator.traffic import pedestrian

__all__ = ["pedestrian"]
