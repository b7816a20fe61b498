"""Visible checks of lesson 12: the detector, the matching, and the tracker's steps."""

# In the order of the lesson, in which exercises are listed.
from utils.checks.lesson_12 import detect_obstacles, match_boxes

# isort: split
from utils.checks.lesson_12 import steps

__all__ = ["detect_obstacles", "match_boxes", "steps"]
