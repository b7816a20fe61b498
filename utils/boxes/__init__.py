"""Boxes and their geometry: corners, what lies inside, how much two of them overlap."""

from utils.boxes.box import Box, inside
from utils.boxes.overlap import plane_iou, space_iou

__all__ = ["Box", "inside", "plane_iou", "space_iou"]
