"""Visible checks of lesson 02: lines, distances and RANSAC."""

# Import in the order of the lesson, because exercises are listed in the order of import.
from utils.checks.lesson_02 import line_through, point_line_distance, ransac_line

__all__ = ["line_through", "point_line_distance", "ransac_line"]
