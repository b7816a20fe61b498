"""Towards the systems that keep a course: nbgrader's gradebook."""
