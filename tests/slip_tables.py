"""The likely slips in each exercise, by lesson, and the functions that they change."""

import ast
import importlib

from grader.course.lessons import lesson_of
from tests.course_lessons import COURSE

TABLES = {
    lesson.name: importlib.import_module(f"solutions.{lesson.stage}.{lesson.name}.slips").SLIPS
    for lesson in COURSE
}


def solution_of(exercise):
    """Return the source of an exercise's function in the lesson's solution."""
    lesson = lesson_of(exercise)
    for node in ast.parse(lesson.text).body:
        if isinstance(node, ast.FunctionDef) and node.name == exercise:
            return ast.get_source_segment(lesson.text, node)
    raise LookupError(exercise)
