"""Boxes and their geometry: corners, the points inside, and the overlap of two boxes."""

from utils.boxes.box import Box
from utils.boxes.containment import distance_outside, inside
from utils.boxes.overlap import plane_iou, space_iou

__all__ = ["Box", "distance_outside", "inside", "plane_iou", "space_iou"]
