"""What the gradebook says about each notebook of each student, read in one question."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta

from nbgrader.api import (
    Assignment,
    Grade,
    Gradebook,
    Notebook,
    SubmittedAssignment,
    SubmittedNotebook,
)
from sqlalchemy import exists, func, or_

# Of a notebook: a person has given points for it.
MARKED_BY_HAND = exists().where(
    Grade.notebook_id == SubmittedNotebook.id,
    or_(Grade.manual_score.is_not(None), func.coalesce(Grade.extra_credit, 0.0) != 0.0),
)


@dataclass(frozen=True)
class GradebookRow:
    """What the gradebook says about a notebook of a student.

    Attributes
    ----------
    student, stage, lesson : str
    score, max_score, penalty : float
    needs_person : bool
        Whether a person has still to grade something in it.
    has_mark_by_hand : bool
    handed_in, due : datetime or None
        In UTC, without saying so, as nbgrader keeps them.
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
    handed_in: datetime | None
    due: datetime | None
    extension: timedelta | None


def read_rows(book: Gradebook) -> list[GradebookRow]:
    """All rows of a gradebook."""
    # All in one question: each object by itself is three, which a server far away answers slowly.
    asked = (
        SubmittedAssignment.student_id,
        Assignment.name,
        Notebook.name,
        SubmittedNotebook.score,
        SubmittedNotebook.max_score,
        func.coalesce(SubmittedNotebook.late_submission_penalty, 0.0),
        SubmittedNotebook.needs_manual_grade,
        MARKED_BY_HAND,
        SubmittedAssignment.timestamp,
        Assignment.duedate,
        SubmittedAssignment.extension,
    )
    found = (
        book.db.query(*asked)
        .select_from(SubmittedNotebook)
        .join(SubmittedNotebook.assignment)
        .join(SubmittedAssignment.assignment)
        .join(SubmittedNotebook.notebook)
        .all()
    )
    return [GradebookRow(*row) for row in found]
