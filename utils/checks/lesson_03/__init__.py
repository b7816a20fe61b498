"""Visible checks of lesson 03: planes through points, distances, RANSAC, refit, rounds."""

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
