"""What the gradebook holds of each cell: points by machine and by hand, and comments."""

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
    """How a graded cell of a student's stands.

    Attributes
    ----------
    score : float
        What counts: a person's points where there are some, else those of the machine; and extra
        points.
    by_hand : bool
        Whether a person gave or changed them.
    waiting : bool
        Whether a person has still to look.
    """

    score: float
    by_hand: bool
    waiting: bool


@dataclass(frozen=True)
class CellMarks:
    """The cells of a stage.

    Attributes
    ----------
    marks : dict of (str, str, str) to CellMark
        By student, lesson and nbgrader's name of the cell.
    comments : dict of (str, str, str) to str
        What a person wrote beside a solution.
    """

    marks: dict[tuple[str, str, str], CellMark]
    comments: dict[tuple[str, str, str], str]


def cell_marks(book: Gradebook, stage: str) -> CellMarks:
    """Read the cells of a stage, of all students at once."""
    grades = _rows(
        book,
        stage,
        Grade,
        Grade.score,
        Grade.manual_score,
        Grade.extra_credit,
        Grade.needs_manual_grade,
    )
    comments = _rows(book, stage, Comment, Comment.manual_comment)
    return CellMarks(
        {
            (student, lesson, cell): CellMark(
                score or 0.0, manual is not None or bool(extra), bool(waiting)
            )
            for student, lesson, cell, score, manual, extra, waiting in grades
        },
        {
            (student, lesson, cell): comment
            for student, lesson, cell, comment in comments
            if comment and comment.strip()
        },
    )


def _rows(book: Gradebook, stage: str, table: type, *columns: object) -> Query:
    """Columns of all grades, or of all comments, behind student, lesson and cell."""
    return (
        book.db.query(SubmittedAssignment.student_id, Notebook.name, BaseCell.name, *columns)
        .select_from(table)
        .join(BaseCell, table.cell_id == BaseCell.id)
        .join(SubmittedNotebook, table.notebook_id == SubmittedNotebook.id)
        .join(Notebook, SubmittedNotebook.notebook_id == Notebook.id)
        .join(SubmittedAssignment, SubmittedNotebook.assignment_id == SubmittedAssignment.id)
        .join(Assignment, SubmittedAssignment.assignment_id == Assignment.id)
        .filter(Assignment.name == stage)
    )
