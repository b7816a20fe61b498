"""Visible checks of lesson 04: `insert` and `search` through `KdTree`, and `median_order`."""

# Import in the order of the lesson, because exercises are listed in the order of import.
from utils.checks.lesson_04 import insert, search

# isort: split
from utils.checks.lesson_04 import median_order

__all__ = ["insert", "search", "median_order"]
