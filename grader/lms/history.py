"""Every mark that changed: from what, to what, when, and by which verdict or by a person.

``marks.jsonl`` beside the course has a line for each change, and is only ever added to. What it
says last is compared with the gradebook, so that marks are noticed that somebody gave in between;
a line that is lost, or torn by a power cut, is written again.
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
from grader.lms.autograded import key_of_copy

CLOSE = 1e-6  # points are written with two digits
LATENESS = "late penalty"  # stands in the place of an exercise
A_PERSON, A_VERDICT, LATE = "a person", "verdict", "lateness"
GONE = "taken out of the gradebook"

Place = tuple[str, str, str, str]  # student, stage, lesson, exercise


@dataclass(frozen=True)
class Change:
    """One mark that changed.

    Attributes
    ----------
    when : str
        When it was noticed, in ISO 8601.
    student, stage, lesson : str
    exercise : str
        Or `LATENESS`, of which the points are those taken off.
    before, after : float or None
        None where there is no mark.
    by : str
        "verdict" with its key, "a person", or what else it was.
    by_hand : tuple of (float or None, float or None) or None
        The mark and the extra points that a person has given by then.
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
        """Which mark it is."""
        return self.student, self.stage, self.lesson, self.exercise


def read_changes(course: Course) -> Iterator[Change]:
    """All changes, the oldest first; lines that cannot be read are left out."""
    try:
        text = _path(course).read_text("utf-8", errors="surrogateescape")
    except FileNotFoundError:
        return
    for line in text.split("\n"):
        try:
            about = json.loads(line)
            by_hand = about.pop("by_hand", None)
            before, after = about.pop("from"), about.pop("to")
            yield Change(**about, before=before, after=after, by_hand=by_hand and tuple(by_hand))
        except (ValueError, TypeError, KeyError, AttributeError):
            continue


def note_changes(
    course: Course, book: Gradebook, keys: Mapping[tuple[str, str], str] | None = None
) -> None:
    """Add a line for each mark that is another than the last line about it says.

    Parameters
    ----------
    course : grader.course.paths.Course
    book : nbgrader.api.Gradebook
    keys : dict of (str, str) to str, optional
        Keys of the verdicts by student and lesson, where they are known; the copies in
        ``autograded/`` have them, too.
    """
    known = {change.place: change for change in read_changes(course)}
    now = datetime.now(UTC).isoformat(timespec="seconds")
    marks = {**_marks(course, book), **_penalties(book)}
    lines = []
    for place in sorted({*known, *marks}):
        last = known.get(place)
        before = last.after if last else None
        after, by_hand = marks.get(place, (None, None))
        if _same(before, after):
            continue
        by = _by(course, place, place in marks, by_hand != (last and last.by_hand), keys or {})
        lines.append(_line(Change(now, *place, before, after, by, by_hand)))
    _append(course, lines)


def _by(
    course: Course,
    place: Place,
    is_there: bool,
    other_hand: bool,
    keys: Mapping[tuple[str, str], str],
) -> str:
    """Who or what changed a mark."""
    student, stage, lesson, exercise = place
    if exercise == LATENESS:
        return LATE
    if not is_there:
        return GONE
    if other_hand:
        return A_PERSON
    key = keys.get((student, lesson)) or key_of_copy(course, student, stage, lesson)
    return f"{A_VERDICT} {key}" if key else A_VERDICT


def _marks(course: Course, book: Gradebook) -> dict[Place, tuple[float | None, tuple | None]]:
    """(mark, what a person has given) of every graded cell."""
    asked = (
        SubmittedAssignment.student_id,
        Assignment.name,
        Notebook.name,
        BaseCell.name,
        Grade.auto_score,
        Grade.manual_score,
        Grade.extra_credit,
    )
    rows = (
        _joined(book, asked)
        .join(Grade, Grade.notebook_id == SubmittedNotebook.id)
        .join(BaseCell, BaseCell.id == Grade.cell_id)
    )
    found = {}
    for student, stage, lesson, cell, auto, manual, extra in rows:
        mark = auto if manual is None else manual
        by_hand = None if manual is None and not extra else (manual, extra or None)
        if by_hand is None and not mark:  # nbgrader has 0 for what was not handed in
            copy = course.autograded / student / stage / f"{lesson}.ipynb"
            mark = mark if copy.is_file() else None
        elif extra:
            mark = (mark or 0.0) + extra
        found[student, stage, lesson, cell.removeprefix("test_")] = (mark, by_hand)
    return found


def _penalties(book: Gradebook) -> dict[Place, tuple[float, None]]:
    """Points taken off for lateness, where there are any."""
    asked = (
        SubmittedAssignment.student_id,
        Assignment.name,
        Notebook.name,
        SubmittedNotebook.late_submission_penalty,
    )
    return {(*about, LATENESS): (off, None) for *about, off in _joined(book, asked) if off}


def _joined(book: Gradebook, asked: tuple) -> Query:
    return (
        book.db.query(*asked)
        .select_from(SubmittedNotebook)
        .join(SubmittedNotebook.assignment)
        .join(SubmittedAssignment.assignment)
        .join(SubmittedNotebook.notebook)
    )


def _same(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    return abs(one - other) < CLOSE


def _line(change: Change) -> str:
    about = {
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
    return json.dumps(about | by_hand, ensure_ascii=False) + "\n"


def _append(course: Course, lines: list[str]) -> None:
    if not lines:
        return
    with _path(course).open("ab") as file:
        if file.tell() and not _ends_whole(course):
            lines = ["\n", *lines]
        file.write("".join(lines).encode(errors="surrogateescape"))
        file.flush()
        os.fsync(file.fileno())


def _ends_whole(course: Course) -> bool:
    with _path(course).open("rb") as file:
        file.seek(-1, os.SEEK_END)
        return file.read() == b"\n"


def _path(course: Course) -> Path:
    return course.root / "marks.jsonl"
