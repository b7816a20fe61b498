"""Read the gradebook's data about each notebook of each student in one query."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta

from nbgrader.api import (
    Assignment,
    Grade,
    Gradebook,
    GradeCell,
    Notebook,
    SubmittedAssignment,
    SubmittedNotebook,
)
from sqlalchemy import exists, func, or_

# SQL condition on a notebook: a person has given points for it.
HAS_MARK_BY_HAND = exists().where(
    Grade.notebook_id == SubmittedNotebook.id,
    or_(Grade.manual_score.is_not(None), func.coalesce(Grade.extra_credit, 0.0) != 0.0),
)


@dataclass(frozen=True)
class GradebookRow:
    """The gradebook's data about one notebook of a student.

    Attributes
    ----------
    student, stage, lesson : str
    score, max_score, penalty : float
    needs_person : bool
        Whether a person still has to grade a part of the notebook.
    has_mark_by_hand : bool
        Whether a person has given points for the notebook.
    submitted_at, due : datetime or None
        Naive times in UTC, as nbgrader stores them.
    extension : timedelta or None
    """

    student: str
    stage: str
    lesson: str
    score: float
    max_score: float
    penalty: float
    needs_person: bool
    has_mark_by_hand: bool
    submitted_at: datetime | None
    due: datetime | None
    extension: timedelta | None


def read_rows(book: Gradebook) -> list[GradebookRow]:
    """Read all rows of a gradebook."""
    # One query reads everything, because nbgrader's objects need three queries each, which is slow
    # with a remote server.
    columns = (
        SubmittedAssignment.student_id,
        Assignment.name,
        Notebook.name,
        SubmittedNotebook.score,
        SubmittedNotebook.max_score,
        func.coalesce(SubmittedNotebook.late_submission_penalty, 0.0),
        SubmittedNotebook.needs_manual_grade,
        HAS_MARK_BY_HAND,
        SubmittedAssignment.timestamp,
        Assignment.duedate,
        SubmittedAssignment.extension,
    )
    rows = (
        book.db.query(*columns)
        .select_from(SubmittedNotebook)
        .join(SubmittedNotebook.assignment)
        .join(SubmittedAssignment.assignment)
        .join(SubmittedNotebook.notebook)
        .all()
    )
    return [GradebookRow(*row) for row in rows]


def read_excessive_marks(book: Gradebook) -> list[tuple[str, str, str, float, float]]:
    """Return (student, lesson, cell, points, maximum) of manual marks above their maximum.

    Such marks remain if an exercise was graded before its points were reduced.
    """
    columns = (SubmittedAssignment.student_id, Notebook.name, GradeCell.name)
    points = (Grade.manual_score, GradeCell.max_score)
    rows = (
        book.db.query(*columns, *points)
        .select_from(Grade)
        .join(GradeCell, Grade.cell_id == GradeCell.id)
        .join(SubmittedNotebook, Grade.notebook_id == SubmittedNotebook.id)
        .join(SubmittedNotebook.assignment)
        .join(SubmittedNotebook.notebook)
        .filter(Grade.manual_score > GradeCell.max_score)
        .order_by(*columns)
    )
    return [tuple(row) for row in rows]
