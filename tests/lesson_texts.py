"""A lesson as it is for whoever follows its hints: its functions, its names, what it shows."""

import contextlib
import io
import re
from dataclasses import dataclass

import jupytext
import matplotlib
import matplotlib.pyplot as plt
import numpy as np

from grader.course.kept_answers import answers_to
from grader.course.lessons import find_lesson
from utils.notebooks import slicing

FOLLOWED = "the hints followed to the letter"


def source_of(exercise, variant=FOLLOWED):
    """The answer to an exercise that the course keeps under a name."""
    return next(answer.source for answer in answers_to(exercise) if answer.name == variant)


def taught(exercise, variant=FOLLOWED):
    """The function that the hints lead to, or another variant of it."""
    namespace = {"np": np}
    exec(source_of(exercise, variant), namespace)
    return namespace[exercise]


def names_of(name, *wanted, **variants):
    """Run the statements of a lesson that `wanted` needs.

    Parameters
    ----------
    name : str
        Such as "06_filter_ground".
    *wanted : str
        Variables and functions.
    **variants : str
        Where an exercise shall be another variant than the hints followed.

    Returns
    -------
    dict
        All that these statements define.
    """
    lesson, namespace = find_lesson(name), {"__name__": name, "np": np}
    statements, problems = slicing.parse_notebook([lesson.source.read_text("utf-8")])
    assert not problems
    mine = {exercise.name for exercise in lesson.machine_graded}
    for statement in slicing.slice_for(wanted, statements):
        if exercises := statement.binds & mine:
            for exercise in exercises:
                exec(source_of(exercise, variants.get(exercise, FOLLOWED)), namespace)
        else:
            exec(slicing.compile_statement(statement, str(lesson.source)), namespace)
    return namespace


@dataclass(frozen=True)
class Told:
    """What a lesson left behind: its names, and all that it printed and compared."""

    names: dict
    text: str

    def numbers_after(self, start):
        """The numbers in the line that begins with `start`, without those of the start."""
        line = next(line for line in self.text.splitlines() if line.strip().startswith(start))
        rest = line.strip().removeprefix(start).replace(",", "")
        return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", rest)]


def tell(name):
    """Run a whole lesson in this process, with the answers that its hints describe.

    Parameters
    ----------
    name : str
        Such as "01_point_clouds".

    Returns
    -------
    Told
    """
    matplotlib.use("Agg")
    lesson, names, text = find_lesson(name), {"__name__": name}, io.StringIO()
    with contextlib.redirect_stdout(text):
        for cell in jupytext.read(lesson.source).cells:
            about = cell.metadata.get("nbgrader", {})
            if cell.cell_type != "code" or about.get("grade"):
                continue
            if {"setup", "badge", "footer"} & set(cell.metadata.get("tags", ())):
                continue
            source = source_of(about["grade_id"]) if about.get("solution") else cell.source
            exec(compile(source, name, "exec"), names)
            plt.close("all")
    return Told(names, text.getvalue())
