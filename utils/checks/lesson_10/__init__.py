"""Visible checks of lesson 10: its three steps, which give no points, and the exercise."""

# Import in the order of the lesson, because exercises are listed in the order of import.
from utils.checks.lesson_10 import steps

# isort: split
from utils.checks.lesson_10 import accelerated

__all__ = ["steps", "accelerated"]
