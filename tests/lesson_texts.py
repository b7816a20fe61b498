"""Run lessons with answers that follow the hints, and return functions, variables and text."""

import contextlib
import io
import re
from dataclasses import dataclass

import jupytext
import matplotlib
import matplotlib.pyplot as plt
import numpy as np

from grader.course.build import COMMON_CELLS
from grader.course.kept_answers import answers_to
from grader.course.lessons import find_lesson
from utils.notebooks import slicing

FOLLOWS_HINTS = "the hints followed to the letter"


def source_of(exercise, variant=FOLLOWS_HINTS):
    """Return the source of the kept answer with this name."""
    return next(answer.source for answer in answers_to(exercise) if answer.name == variant)


def kept_function(exercise, variant=FOLLOWS_HINTS):
    """Return the function from the kept answer with this name."""
    namespace = {"np": np}
    exec(source_of(exercise, variant), namespace)
    return namespace[exercise]


def run_statements_for(name, *wanted, **variants):
    """Run only the statements that some names of a lesson need; return all names they define.

    Parameters
    ----------
    name : str
        Name of the lesson, such as "06_filter_ground".
    *wanted : str
        Variables and functions that are needed.
    **variants : str
        Names of kept answers, for exercises that should not follow the hints.

    Returns
    -------
    dict
        All names that the statements define, with their values.
    """
    lesson, namespace = find_lesson(name), {"__name__": name, "np": np}
    statements, skipped = slicing.parse_notebook([lesson.source.read_text("utf-8")])
    assert not skipped
    own_exercises = {exercise.name for exercise in lesson.machine_graded}
    for statement in slicing.slice_for(wanted, statements):
        if exercises := statement.binds & own_exercises:
            for exercise in exercises:
                exec(source_of(exercise, variants.get(exercise, FOLLOWS_HINTS)), namespace)
        else:
            exec(slicing.compile_statement(statement, str(lesson.source)), namespace)
    return namespace


@dataclass(frozen=True)
class LessonRun:
    """The variables of a finished lesson, and the text that it printed."""

    names: dict
    text: str

    def numbers_after(self, start):
        """Return the numbers after `start` in the first line that begins with `start`."""
        line = next(line for line in self.text.splitlines() if line.strip().startswith(start))
        rest = line.strip().removeprefix(start).replace(",", "")
        return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", rest)]


def run_lesson(name):
    """Run a whole lesson in this process, with answers that follow the hints.

    Parameters
    ----------
    name : str
        Name of the lesson, such as "01_point_clouds".
    """
    matplotlib.use("Agg")
    lesson, names, text = find_lesson(name), {"__name__": name}, io.StringIO()
    with contextlib.redirect_stdout(text):
        for cell in jupytext.read(lesson.source).cells:
            grading = cell.metadata.get("nbgrader", {})
            if cell.cell_type != "code" or grading.get("grade"):
                continue
            if COMMON_CELLS.keys() & set(cell.metadata.get("tags", ())):
                continue
            source = source_of(grading["grade_id"]) if grading.get("solution") else cell.source
            exec(compile(source, name, "exec"), names)
            plt.close("all")
    return LessonRun(names, text.getvalue())
