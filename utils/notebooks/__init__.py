"""Notebook files: read cells, slice out the code of an exercise, load a student's functions."""
