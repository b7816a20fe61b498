"""The pictures at the head of each lesson, one module a lesson: ``make pictures``."""
