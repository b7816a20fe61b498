"""Register the released lessons in the gradebook, with their cells and points."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable

import nbformat
from nbgrader.api import Gradebook, MissingEntry
from nbgrader.preprocessors import SaveCells
from nbgrader.utils import is_grade, is_solution

from grader.course.lessons import Lesson, released_lessons
from grader.course.paths import Course
from grader.lms.autograded_copy import graded_cells
from grader.lms.changed_cells import change_cells, complete_submissions
from grader.lms.gradebook import database_url


def register_stages(
    course: Course,
    book: Gradebook,
    stages: Iterable[str],
    notify: Callable[[str], None] = print,
) -> None:
    """Register stages in the gradebook, with the cells and points of the release.

    The release itself is not changed. Lessons in the gradebook are compared with the release, so
    that changed points and cells are entered.

    Parameters
    ----------
    course : grader.course.paths.Course
    book : nbgrader.api.Gradebook
    stages : iterable of str
    notify : callable
        Called with a sentence about each change that affects submissions in the gradebook.
    """
    for stage in stages:
        lessons = released_lessons(course, stage)
        with contextlib.suppress(MissingEntry):
            lessons = [lesson for lesson in lessons if not _is_registered(book, lesson)]
        if lessons:
            book.update_or_create_assignment(stage)
            for lesson in lessons:
                change_cells(book, lesson, graded_cells(_released_notebook(lesson)), notify)
            book.db.commit()  # because SaveCells opens its own connection to the database
            for lesson in lessons:
                resources = {"notebook": lesson.name, "assignment": stage}
                resources["db_url"] = database_url(course)
                SaveCells().preprocess(_released_notebook(lesson), {"nbgrader": resources})
            book.db.expire_all()
        complete_submissions(book, stage)


def _released_notebook(lesson: Lesson) -> nbformat.NotebookNode:
    return nbformat.reads(lesson.released.read_text("utf-8"), as_version=4)


def _is_registered(book: Gradebook, lesson: Lesson) -> bool:
    """Return whether the gradebook contains the cells of a lesson as released."""
    notebook = book.find_notebook(lesson.name, lesson.stage)
    cells = graded_cells(_released_notebook(lesson))
    checksums = {
        (cell.metadata.nbgrader.grade_id, cell.metadata.nbgrader.get("checksum")) for cell in cells
    }
    points = {
        (cell.metadata.nbgrader.grade_id, float(cell.metadata.nbgrader.points))
        for cell in cells
        if is_grade(cell)
    }
    solutions = {cell.metadata.nbgrader.grade_id for cell in cells if is_solution(cell)}
    return (
        checksums == {(cell.name, cell.checksum) for cell in notebook.source_cells}
        and points == {(cell.name, cell.max_score) for cell in notebook.grade_cells}
        and solutions == {cell.name for cell in notebook.solution_cells}
    )
