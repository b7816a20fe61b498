"""Change the cells of a lesson that has submissions in the gradebook; nbgrader refuses to.

Marks for cells that stay are kept. The marks of removed cells remain in ``marks.jsonl``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from nbformat import NotebookNode
from nbgrader.api import (
    Assignment,
    BaseCell,
    Comment,
    Grade,
    Gradebook,
    GradeCell,
    MissingEntry,
    Notebook,
    SolutionCell,
    SourceCell,
    SubmittedAssignment,
    SubmittedNotebook,
)
from nbgrader.utils import is_grade, is_solution
from sqlalchemy import exists

from grader.course.lessons import Lesson
from grader.lms.mark_history import exercise_of
from grader.lms.results import format_points


def change_cells(
    book: Gradebook, lesson: Lesson, cells: Sequence[NotebookNode], notify: Callable[[str], None]
) -> None:
    """Add and remove cells of a registered lesson, so that nbgrader can register the new release.

    Parameters
    ----------
    book : nbgrader.api.Gradebook
    lesson : grader.course.lessons.Lesson
    cells : list of NotebookNode
        The cells of the release that carry nbgrader metadata.
    notify : callable
        Called with a sentence about each change that affects submissions.
    """
    try:
        notebook = book.find_notebook(lesson.name, lesson.stage)
    except MissingEntry:
        return
    if not notebook.submissions:
        return
    released_cells = {(kind, _name(cell)): cell for cell in cells for kind in _cell_tables(cell)}
    existing_cells = {
        (type(cell), cell.name): cell for cell in (*notebook._base_cells, *notebook.source_cells)
    }
    _announce_changed_exercises(book, lesson, released_cells, existing_cells, notify)
    for key in existing_cells.keys() - released_cells.keys():
        for table in (Grade, Comment):
            book.db.query(table).filter(table.cell_id == existing_cells[key].id).delete()
        book.db.delete(existing_cells[key])
    for kind, name in released_cells.keys() - existing_cells.keys():
        cell, fields = released_cells[kind, name], {}
        if kind is not SolutionCell:
            fields["cell_type"] = cell.cell_type
        if kind is GradeCell:
            fields["max_score"] = _points(cell)
        book.db.add(kind(name=name, notebook=notebook, **fields))


def complete_submissions(book: Gradebook, stage: str) -> None:
    """Add the rows that submissions need for lessons and cells which were registered later.

    nbgrader adds these rows only to a new submission.
    """
    notebooks = (
        book.db.query(SubmittedAssignment.id, Notebook.id)
        .join(Assignment, SubmittedAssignment.assignment_id == Assignment.id)
        .join(Notebook, Notebook.assignment_id == Assignment.id)
        .filter(
            Assignment.name == stage,
            ~exists().where(
                SubmittedNotebook.assignment_id == SubmittedAssignment.id,
                SubmittedNotebook.notebook_id == Notebook.id,
            ),
        )
    )
    for submission, notebook in notebooks.all():
        book.db.add(SubmittedNotebook(assignment_id=submission, notebook_id=notebook))
    book.db.flush()
    for table, kind in ((Grade, GradeCell), (Comment, SolutionCell)):
        rows = (
            book.db.query(SubmittedNotebook.id, kind.id)
            .join(Notebook, SubmittedNotebook.notebook_id == Notebook.id)
            .join(Assignment, Notebook.assignment_id == Assignment.id)
            .join(kind, BaseCell.notebook_id == Notebook.id)
            .filter(
                Assignment.name == stage,
                ~exists().where(
                    table.notebook_id == SubmittedNotebook.id, table.cell_id == kind.id
                ),
            )
        )
        for notebook, cell in rows.all():
            book.db.add(table(notebook_id=notebook, cell_id=cell))
    book.db.commit()


def _announce_changed_exercises(
    book: Gradebook, lesson: Lesson, released: dict, existing: dict, notify: Callable[[str], None]
) -> None:
    """Report exercises that were added or removed, or whose points changed after manual marks."""
    before = {name: cell for (kind, name), cell in existing.items() if kind is GradeCell}
    new_points = {name: cell for (kind, name), cell in released.items() if kind is GradeCell}
    for name in new_points.keys() - before.keys():
        notify(
            f"{lesson.name}: {exercise_of(name)} was added to the gradebook, also for earlier "
            "submissions. All other marks are kept."
        )
    for name, cell in before.items():
        by_hand = (
            book.db.query(Grade)
            .filter(Grade.cell_id == cell.id, Grade.manual_score.is_not(None))
            .count()
        )
        exercise = exercise_of(name)
        marks = f"{by_hand} mark{'s' * (by_hand != 1)} given by hand"
        if name not in new_points:
            kept = f" Only marks.jsonl still contains its {marks}." if by_hand else ""
            notify(
                f"{lesson.name}: {exercise} is no longer in the release, so it was removed "
                f"from the gradebook.{kept}"
            )
        elif by_hand and cell.max_score != _points(new_points[name]):
            notify(
                f"{lesson.name}: {exercise} is now worth "
                f"{format_points(_points(new_points[name]))} "
                f"points instead of {format_points(cell.max_score)}, but {marks} did not change. "
                "Review these marks."
            )


def _cell_tables(cell: NotebookNode) -> list[type]:
    """Return the tables in which nbgrader registers a cell."""
    return [GradeCell] * is_grade(cell) + [SolutionCell] * is_solution(cell) + [SourceCell]


def _name(cell: NotebookNode) -> str:
    return cell.metadata.nbgrader.grade_id


def _points(cell: NotebookNode) -> float:
    return float(cell.metadata.nbgrader.points)
