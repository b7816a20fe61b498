"""Geometry of planes and kd-trees for checks, hidden tests and pictures."""

from utils.geometry.planes import best_plane, gaps_from, plane_at, spread_of, with_unit_normal
from utils.geometry.trees import SIDES, TreeNode, grown, in_turn, places_of, regions_of, table_of

__all__ = [
    "SIDES",
    "TreeNode",
    "best_plane",
    "gaps_from",
    "grown",
    "in_turn",
    "places_of",
    "plane_at",
    "regions_of",
    "spread_of",
    "table_of",
    "with_unit_normal",
]
