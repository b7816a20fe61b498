"""Judging: decides every point, outside the process that runs the student's code."""
