"""Keep a log of every changed mark: old and new points, time, and the verdict or person behind it.

``marks.jsonl`` in the course folder has one line per change, and lines are only appended. Each run
compares the last known marks with the gradebook, so the log includes marks that a person entered in
between. If a power cut loses or truncates a line, the next run logs the change again.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from nbgrader.api import (
    Assignment,
    BaseCell,
    Grade,
    Gradebook,
    Notebook,
    SubmittedAssignment,
    SubmittedNotebook,
)
from sqlalchemy.orm import Query

from grader.course.paths import Course
from grader.lms.autograded import verdict_key_of_copy

TOLERANCE = 1e-6  # points are written with two decimal places
LATE_PENALTY = "late penalty"  # used instead of an exercise's name
A_PERSON, A_VERDICT, LATE = "a person", "verdict", "lateness"
REMOVED = "removed from the gradebook"

Place = tuple[str, str, str, str]  # student, stage, lesson, exercise


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

    @property
    def place(self) -> Place:
        """Student, stage, lesson and exercise of the mark."""
        return self.student, self.stage, self.lesson, self.exercise


def read_changes(course: Course) -> Iterator[MarkChange]:
    """Yield all changes, the oldest first; unreadable lines are skipped."""
    try:
        text = _path(course).read_text("utf-8", errors="surrogateescape")
    except FileNotFoundError:
        return
    for line in text.split("\n"):
        try:
            fields = json.loads(line)
            by_hand = fields.pop("by_hand", None)
            before, after = fields.pop("from"), fields.pop("to")
            yield MarkChange(
                **fields, before=before, after=after, by_hand=by_hand and tuple(by_hand)
            )
        except (ValueError, TypeError, KeyError, AttributeError):
            continue


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
    known = {change.place: change for change in read_changes(course)}
    now = datetime.now(UTC).isoformat(timespec="seconds")
    marks = {**_marks(course, book), **_penalties(book)}
    lines = []
    for place in sorted({*known, *marks}):
        last = known.get(place)
        before = last.after if last else None
        after, by_hand = marks.get(place, (None, None))
        if _is_close(before, after):
            continue
        by = _cause(course, place, place in marks, by_hand != (last and last.by_hand), keys or {})
        lines.append(_as_json_line(MarkChange(now, *place, before, after, by, by_hand)))
    _append(course, lines)


def _cause(
    course: Course,
    place: Place,
    exists: bool,
    changed_by_hand: bool,
    keys: Mapping[tuple[str, str], str],
) -> str:
    """Return the cause of a change: a verdict, a person, lateness or a removal."""
    student, stage, lesson, exercise = place
    if exercise == LATE_PENALTY:
        return LATE
    if not exists:
        return REMOVED
    if changed_by_hand:
        return A_PERSON
    key = keys.get((student, lesson)) or verdict_key_of_copy(course, student, stage, lesson)
    return f"{A_VERDICT} {key}" if key else A_VERDICT


def _marks(course: Course, book: Gradebook) -> dict[Place, tuple[float | None, tuple | None]]:
    """Return (mark, points given by a person) for each graded cell."""
    columns = (
        SubmittedAssignment.student_id,
        Assignment.name,
        Notebook.name,
        BaseCell.name,
        Grade.auto_score,
        Grade.manual_score,
        Grade.extra_credit,
    )
    rows = (
        _query(book, columns)
        .join(Grade, Grade.notebook_id == SubmittedNotebook.id)
        .join(BaseCell, BaseCell.id == Grade.cell_id)
    )
    marks = {}
    for student, stage, lesson, cell, auto, manual, extra in rows:
        mark = auto if manual is None else manual
        by_hand = None if manual is None and not extra else (manual, extra or None)
        if by_hand is None and not mark:  # nbgrader stores 0 for a lesson that was not submitted
            copy = course.autograded / student / stage / f"{lesson}.ipynb"
            mark = mark if copy.is_file() else None
        elif extra:
            mark = (mark or 0.0) + extra
        marks[student, stage, lesson, cell.removeprefix("test_")] = (mark, by_hand)
    return marks


def _penalties(book: Gradebook) -> dict[Place, tuple[float, None]]:
    """Return the points subtracted for lateness, for each notebook with a late penalty."""
    columns = (
        SubmittedAssignment.student_id,
        Assignment.name,
        Notebook.name,
        SubmittedNotebook.late_submission_penalty,
    )
    return {
        (*identity, LATE_PENALTY): (points, None)
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
    by_hand = {"by_hand": change.by_hand} if change.by_hand else {}
    return json.dumps(fields | by_hand, ensure_ascii=False) + "\n"


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
