"""Boxes and their geometry: corners, the points inside, and the overlap of two boxes."""

from utils.boxes.box import Box
from utils.boxes.containment import distance_outside, inside
from utils.boxes.overlap import distances_between, footprints, plane_iou, space_iou

__all__ = [
    "Box",
    "distance_outside",
    "distances_between",
    "footprints",
    "inside",
    "plane_iou",
    "space_iou",
]
