"""Planes, as checks, the judge's tests and pictures measure them."""

from utils.geometry.planes import best_plane, gaps_from, plane_at, spread_of, with_unit_normal

__all__ = ["best_plane", "gaps_from", "plane_at", "spread_of", "with_unit_normal"]
