"""Visible checks of lesson 12: the detector, the matching, and the tracker's steps."""

# Import in the order of the lesson, because exercises are listed in the order of import.
from utils.checks.lesson_12 import detect_obstacles, match_boxes

# isort: split
from utils.checks.lesson_12 import steps

__all__ = ["detect_obstacles", "match_boxes", "steps"]
