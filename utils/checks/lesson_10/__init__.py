"""Visible checks of lesson 10: its three steps, which give no points, and the exercise."""

# In the order of the lesson, in which exercises are listed.
from utils.checks.lesson_10 import steps

# isort: split
from utils.checks.lesson_10 import accelerated

__all__ = ["steps", "accelerated"]
