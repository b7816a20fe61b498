"""Visible checks of lesson 03: planes, distances, RANSAC, refitting and the number of rounds."""

# Import in the order of the lesson, because exercises are listed in the order of import.
from utils.checks.lesson_03 import plane_through, point_plane_distance, ransac_plane

# isort: split
from utils.checks.lesson_03 import fit_plane, iterations_needed

__all__ = [
    "plane_through",
    "point_plane_distance",
    "ransac_plane",
    "fit_plane",
    "iterations_needed",
]
