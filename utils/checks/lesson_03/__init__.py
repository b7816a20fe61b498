"""Visible checks of lesson 03: planes through points, distances, RANSAC, refit, rounds."""

# In the order of the lesson, in which exercises are listed.
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
