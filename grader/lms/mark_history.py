"""Keep a log of every changed mark: old and new points, time, and the verdict or person behind it.

``marks.jsonl`` in the course folder has one line per change. Lines are only appended, except when
`grader.lms.forget` deletes those about a student. Each run compares the last known marks with the
gradebook, so the log includes marks and comments that a person entered in between. If a power cut
loses or truncates a line, the next run logs the change again. If the gradebook is lost,
`grader.lms.marks_by_hand` restores a person's work from the log.
"""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

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

from grader.course.atomic_files import write_atomically
from grader.course.paths import Course
from grader.lms.answer_fingerprints import read_fingerprints
from grader.lms.autograded_copy import verdict_key_of_copy

TOLERANCE = 1e-6  # points are written with two decimal places
LATE_PENALTY = "late penalty"  # used instead of an exercise's name
A_PERSON, A_VERDICT, LATE = "a person", "verdict", "lateness"
REMOVED = "removed from the gradebook"

MarkKey = tuple[str, str, str, str]  # student, stage, lesson, exercise


@dataclass(frozen=True)
class CurrentMark:
    """A mark in the gradebook; see `MarkChange` for the attributes."""

    points: float | None = None
    by_hand: tuple[float | None, float | None] | None = None
    comment: str = ""
    graded: str = ""


@dataclass(frozen=True)
class MarkChange:
    """A change of a mark.

    Attributes
    ----------
    when : str
        When the change was noticed, in ISO 8601.
    student, stage, lesson : str
    exercise : str
        Name of the exercise, or `LATE_PENALTY`, whose points are subtracted.
    before, after : float or None
        Points; None if there is no mark.
    by : str
        "verdict" with its key, or one of this module's other causes, such as "a person".
    by_hand : tuple of (float or None, float or None) or None
        The mark and the extra points that a person gave.
    comment : str
        The comment that a person wrote.
    graded : str
        What the person graded: the digest of a written answer, or the judge's points for code.
        Empty if a person still has to grade it, or if the line is older than this attribute.
    """

    when: str
    student: str
    stage: str
    lesson: str
    exercise: str
    before: float | None
    after: float | None
    by: str
    by_hand: tuple[float | None, float | None] | None = None
    comment: str = ""
    graded: str = ""

    @property
    def key(self) -> MarkKey:
        """Student, stage, lesson and exercise of the mark."""
        return self.student, self.stage, self.lesson, self.exercise


def read_changes(course: Course) -> Iterator[MarkChange]:
    """Yield all changes, the oldest first; unreadable lines are skipped."""
    for line in _lines(course):
        try:
            fields = json.loads(line)
            by_hand = fields.pop("by_hand", None)
            before, after = fields.pop("from"), fields.pop("to")
            yield MarkChange(
                **fields, before=before, after=after, by_hand=by_hand and tuple(by_hand)
            )
        except (ValueError, TypeError, KeyError, AttributeError):
            continue


def count_changes_of(course: Course, student: str) -> int:
    """Return the number of lines about a student."""
    return len(_lines(course)) - len(_lines_without(course, student))


def delete_changes_of(course: Course, student: str) -> None:
    """Delete all lines about a student."""
    content = "".join(f"{line}\n" for line in _lines_without(course, student))
    write_atomically(content.encode(errors="surrogateescape"), _path(course))


def _lines_without(course: Course, student: str) -> list[str]:
    return [line for line in _lines(course) if not _is_about(line, student)]


def _lines(course: Course) -> list[str]:
    try:
        text = _path(course).read_text("utf-8", errors="surrogateescape")
    except FileNotFoundError:
        return []
    return [line for line in text.split("\n") if line]


def _is_about(line: str, student: str) -> bool:
    try:
        return json.loads(line)["student"] == student
    except (ValueError, TypeError, KeyError):
        return student in line  # a torn line is not read, but may contain a comment


def log_changes(
    course: Course, book: Gradebook, keys: Mapping[tuple[str, str], str] | None = None
) -> None:
    """Append a line for each mark that differs from the last line about that mark.

    Parameters
    ----------
    course : grader.course.paths.Course
    book : nbgrader.api.Gradebook
    keys : dict of (str, str) to str, optional
        Known verdict keys by student and lesson. Other keys are read from ``autograded/``.
    """
    known = {change.key: change for change in read_changes(course)}
    timestamp = datetime.now(UTC).isoformat(timespec="seconds")
    marks = {**current_marks(course, book), **_penalties(book)}
    lines = []
    for key in sorted({*known, *marks}):
        last_change = known.get(key) or MarkChange(timestamp, *key, None, None, "")
        mark = marks.get(key, CurrentMark())
        is_by_person = (mark.by_hand, mark.comment) != (
            last_change.by_hand,
            last_change.comment,
        ) or (mark.graded not in ("", last_change.graded))
        if not is_by_person and _is_close(last_change.after, mark.points):
            continue
        by = _cause(course, key, key in marks, is_by_person, keys or {})
        lines.append(
            _as_json_line(
                MarkChange(
                    *(timestamp, *key, last_change.after, mark.points, by),
                    *(mark.by_hand, mark.comment, mark.graded),
                )
            )
        )
    _append(course, lines)


def _cause(
    course: Course,
    mark_key: MarkKey,
    exists: bool,
    is_by_person: bool,
    keys: Mapping[tuple[str, str], str],
) -> str:
    """Return the cause of a change: a verdict, a person, lateness or a removal."""
    student, stage, lesson, exercise = mark_key
    if exercise == LATE_PENALTY:
        return LATE
    if not exists:
        return REMOVED
    if is_by_person:
        return A_PERSON
    key = keys.get((student, lesson)) or verdict_key_of_copy(course, student, stage, lesson)
    return f"{A_VERDICT} {key}" if key else A_VERDICT


def current_marks(course: Course, book: Gradebook) -> dict[MarkKey, CurrentMark]:
    """Return the mark and the grader's comment for each exercise in the gradebook."""
    columns = (
        SubmittedAssignment.student_id,
        Assignment.name,
        Notebook.name,
        BaseCell.name,
    )
    grades = (
        _query(
            book,
            (
                *columns,
                Grade.auto_score,
                Grade.manual_score,
                Grade.extra_credit,
                Grade.needs_manual_grade,
            ),
        )
        .join(Grade, Grade.notebook_id == SubmittedNotebook.id)
        .join(BaseCell, BaseCell.id == Grade.cell_id)
    )
    comments = (
        _query(book, (*columns, Comment.manual_comment))
        .join(Comment, Comment.notebook_id == SubmittedNotebook.id)
        .join(BaseCell, BaseCell.id == Comment.cell_id)
    )
    answers = functools.cache(functools.partial(read_fingerprints, course))
    marks = {}
    for student, stage, lesson, cell, auto_score, manual, extra_credit, is_waiting in grades:
        mark = auto_score if manual is None else manual
        by_hand = None if manual is None and not extra_credit else (manual, extra_credit or None)
        graded = ""
        if by_hand is None and not mark:  # nbgrader stores 0 for a lesson that was not submitted
            copy = course.autograded / student / stage / f"{lesson}.ipynb"
            mark = mark if copy.is_file() else None
        elif extra_credit:
            mark = (mark or 0.0) + extra_credit
        if by_hand and not is_waiting:
            graded = answers(student, stage).get(lesson, {}).get(cell, str(auto_score))
        key = (student, stage, lesson, exercise_of(cell))
        marks[key] = CurrentMark(mark, by_hand, "", graded)
    for student, stage, lesson, cell, comment in comments:
        if comment and comment.strip():
            key = (student, stage, lesson, exercise_of(cell))
            marks[key] = replace(marks.get(key, CurrentMark()), comment=comment)
    return marks


def exercise_of(cell: str) -> str:
    """Return the name of the exercise that a graded cell or a solution cell belongs to."""
    return cell.removeprefix("test_")


def _penalties(book: Gradebook) -> dict[MarkKey, CurrentMark]:
    """Return the points subtracted for lateness, for each notebook with a late penalty."""
    columns = (
        SubmittedAssignment.student_id,
        Assignment.name,
        Notebook.name,
        SubmittedNotebook.late_submission_penalty,
    )
    return {
        (*identity, LATE_PENALTY): CurrentMark(points)
        for *identity, points in _query(book, columns)
        if points
    }


def _query(book: Gradebook, columns: tuple) -> Query:
    return (
        book.db.query(*columns)
        .select_from(SubmittedNotebook)
        .join(SubmittedNotebook.assignment)
        .join(SubmittedAssignment.assignment)
        .join(SubmittedNotebook.notebook)
    )


def _is_close(first: float | None, second: float | None) -> bool:
    if first is None or second is None:
        return first is second
    return abs(first - second) < TOLERANCE


def _as_json_line(change: MarkChange) -> str:
    fields = {
        "when": change.when,
        "student": change.student,
        "stage": change.stage,
        "lesson": change.lesson,
        "exercise": change.exercise,
        "from": change.before,
        "to": change.after,
        "by": change.by,
    }
    by_person = {name: getattr(change, name) for name in ("by_hand", "comment", "graded")}
    fields |= {name: value for name, value in by_person.items() if value}
    return json.dumps(fields, ensure_ascii=False) + "\n"


def _append(course: Course, lines: list[str]) -> None:
    if not lines:
        return
    with _path(course).open("ab") as file:
        if file.tell() and not _ends_with_newline(course):
            lines = ["\n", *lines]
        file.write("".join(lines).encode(errors="surrogateescape"))
        file.flush()
        os.fsync(file.fileno())


def _ends_with_newline(course: Course) -> bool:
    with _path(course).open("rb") as file:
        file.seek(-1, os.SEEK_END)
        return file.read() == b"\n"


def _path(course: Course) -> Path:
    return course.root / "marks.jsonl"
