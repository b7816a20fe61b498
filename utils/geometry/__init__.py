"""Geometry of planes and kd-trees for checks, hidden tests and pictures."""

from utils.geometry.planes import (
    best_plane,
    distances_from_plane,
    plane_through_point,
    principal_components,
    with_unit_normal,
)
from utils.geometry.trees import (
    SIDES,
    TreeNode,
    alternating_axis,
    grow_tree,
    nodes_by_path,
    regions_by_index,
    tree_as_lists,
)

__all__ = [
    "SIDES",
    "TreeNode",
    "best_plane",
    "distances_from_plane",
    "grow_tree",
    "alternating_axis",
    "nodes_by_path",
    "plane_through_point",
    "regions_by_index",
    "principal_components",
    "tree_as_lists",
    "with_unit_normal",
]
