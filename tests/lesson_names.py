"""What a lesson's own cells define, with the exercises as the hints have them written."""

import numpy as np

from grader.course.lessons import find_lesson
from grader.course.variants import variants_of
from utils.notebooks import slicing

TAUGHT = "the hints followed to the letter"


def taught(exercise):
    """The function that the hints lead to, from tests/variants."""
    source = next(one.source for one in variants_of(exercise) if one.name == TAUGHT)
    namespace = {"np": np}
    exec(source, namespace)
    return namespace[exercise]


def names_of(lesson, *names):
    """Run the statements of a lesson that `names` need.

    Parameters
    ----------
    lesson : str
        Such as "06_filter_ground".
    *names : str
        Variables and functions.

    Returns
    -------
    dict
        All that these statements define; the exercises are the taught ones.
    """
    lesson = find_lesson(lesson)
    statements, problems = slicing.parse_notebook([lesson.source.read_text("utf-8")])
    assert not problems
    namespace = {"__name__": lesson.name}
    mine = {exercise.name for exercise in lesson.machine_graded}
    for statement in slicing.slice_for(names, statements):
        if exercises := statement.binds & mine:
            namespace |= {name: taught(name) for name in exercises}
        else:
            exec(slicing.compile_statement(statement, str(lesson.source)), namespace)
    return namespace
