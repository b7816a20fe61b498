"""A part of `utils.simulator`, by the name under which a lesson imports it."""

from utils.simulator.streets import numbered, placed

__all__ = ["numbered", "placed"]
