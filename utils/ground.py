"""A part of `utils.simulator`, by the name under which a lesson imports it."""

from utils.simulator.ground import Ground

__all__ = ["Ground"]
