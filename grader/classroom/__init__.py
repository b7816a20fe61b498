"""Collect, judge and compare the submissions of a class, and create a sample class."""
