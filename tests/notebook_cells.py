"""Notebooks that students submit, and single cells, as JSON."""

import json

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.intake.preflight import prepare
from grader.intake.submission import SubmittedFiles

LESSON = find_lesson("06_filter_ground")
WRITTEN_LESSON = find_lesson("12_streaming_obstacles")
EXERCISES = ("filter_ground", "voxel_grid")
REPORT = "I widened the region to 18.5 m, because the lorry *stands* at 17 m."


def right_answer(exercise):
    return next(variant.source for variant in answers_to(exercise) if variant.right)


def right_notebook():
    """Return a notebook of lesson 06 with right answers, as JSON."""
    return json.loads(fill_in(LESSON, {name: right_answer(name) for name in EXERCISES}))


def with_report():
    """Return a notebook of lesson 12 with a written answer, as JSON."""
    return json.loads(fill_in(WRITTEN_LESSON, {"write_up": REPORT}))


def cell_of(notebook, grade_id):
    return next(
        cell
        for cell in notebook["cells"]
        if cell["metadata"].get("nbgrader", {}).get("grade_id") == grade_id
    )


def code(source, **metadata):
    return {
        "cell_type": "code",
        "metadata": metadata,
        "source": source,
        "outputs": [],
        "execution_count": None,
    }


def text(source, **metadata):
    return {"cell_type": "markdown", "metadata": metadata, "source": source}


def from_cells(*cells, lesson=LESSON, modules=None, name="", lesson_name=""):
    """Return the prepared notebook of a submission that consists of these cells."""
    notebook = {"cells": list(cells), "nbformat": 4, "nbformat_minor": 5}
    notebook["metadata"] = {"lidar_obstacle_lab": {"lesson": lesson_name}} if lesson_name else {}
    data = json.dumps(notebook).encode()
    return prepare(
        SubmittedFiles(name or f"{lesson.name}.ipynb", data, modules=modules or {}), lesson
    )


def with_grade_id(cell, grade_id):
    """Return a copy of a cell with an nbgrader grade ID."""
    return {**cell, "metadata": {"nbgrader": {"grade_id": grade_id}}}
