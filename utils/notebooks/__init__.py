"""Notebooks as files: their code, cut down to what some functions need, and your own functions."""
