"""Visible checks of lesson 03: planes through points, distances, RANSAC, refit, rounds."""

from utils.checks.lesson_03 import ransac_plane

__all__ = ["ransac_plane"]
