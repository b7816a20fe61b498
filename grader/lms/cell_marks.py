"""Points and comments for individual cells in the gradebook."""

from __future__ import annotations

from dataclasses import dataclass

from nbgrader.api import (
    Assignment,
    BaseCell,
    Comment,
    Grade,
    Gradebook,
    Notebook,
    SubmittedAssignment,
    SubmittedNotebook,
)
from sqlalchemy.orm import Query


@dataclass(frozen=True)
class CellMark:
    """A student's points for one graded cell.

    Attributes
    ----------
    score : float
        The points that count: points given by hand or, without them, automatic points; in both
        cases plus extra points.
    by_hand : bool
        Whether a person gave or changed the points.
    is_waiting : bool
        Whether a person still has to grade the cell.
    max_score : float
    """

    score: float
    by_hand: bool
    is_waiting: bool
    max_score: float = 0.0


@dataclass(frozen=True)
class CellMarks:
    """Marks and comments for the cells of one stage or of all stages.

    Attributes
    ----------
    marks : dict of (str, str, str) to CellMark
        Marks by student, lesson and the cell's name in nbgrader.
    comments : dict of (str, str, str) to str
        Comments that a person wrote, by student, lesson and cell.
    """

    marks: dict[tuple[str, str, str], CellMark]
    comments: dict[tuple[str, str, str], str]


def cell_marks(book: Gradebook, stage: str | None = None) -> CellMarks:
    """Read the cells of a stage, or of all stages, for all students in two queries."""
    grades = _rows(
        book,
        stage,
        Grade,
        Grade.score,
        Grade.manual_score,
        Grade.extra_credit,
        Grade.needs_manual_grade,
        Grade.max_score,
    )
    comments = _rows(book, stage, Comment, Comment.manual_comment)
    return CellMarks(
        {
            (student, lesson, cell): CellMark(
                score or 0.0, manual is not None or bool(extra), bool(waiting), max_score
            )
            for student, lesson, cell, score, manual, extra, waiting, max_score in grades
        },
        {
            (student, lesson, cell): comment
            for student, lesson, cell, comment in comments
            if comment and comment.strip()
        },
    )


def _rows(book: Gradebook, stage: str | None, table: type, *columns: object) -> Query:
    """Query columns of grades or comments, preceded by student, lesson and cell."""
    rows = (
        book.db.query(SubmittedAssignment.student_id, Notebook.name, BaseCell.name, *columns)
        .select_from(table)
        .join(BaseCell, table.cell_id == BaseCell.id)
        .join(SubmittedNotebook, table.notebook_id == SubmittedNotebook.id)
        .join(Notebook, SubmittedNotebook.notebook_id == Notebook.id)
        .join(SubmittedAssignment, SubmittedNotebook.assignment_id == SubmittedAssignment.id)
        .join(Assignment, SubmittedAssignment.assignment_id == Assignment.id)
    )
    return rows if stage is None else rows.filter(Assignment.name == stage)
