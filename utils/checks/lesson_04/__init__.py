"""Visible checks of lesson 04: `insert` and `search` through `KdTree`, and `median_order`."""

from utils.checks.lesson_04 import search

__all__ = ["search"]
