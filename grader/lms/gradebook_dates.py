"""Enter due dates and extensions into the gradebook, so that nbgrader computes the right penalties.

nbgrader stores one due date per stage, and each student's extension with the submission. An
extension that is granted before a student submits is therefore entered with the submission. Each
entered date is recorded in ``verdicts/``, so that a date deleted from deadlines.toml is also
removed from the gradebook, and a date that a person entered there is kept.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from pathlib import Path

from nbgrader.api import Assignment, Gradebook, MissingEntry, SubmittedAssignment

from grader.course.atomic_files import write_atomically
from grader.course.deadlines import Deadlines, DueDates
from grader.course.lessons import stages
from grader.course.paths import Course
from grader.lms.gradebook import gradebook_exists, open_gradebook


def enter_due_dates(course: Course, book: Gradebook, deadlines: Deadlines) -> None:
    """Enter the due date of each stage that the gradebook contains.

    If a date was deleted from deadlines.toml, the gradebook's earlier date is restored.
    """
    for stage in stages():
        with contextlib.suppress(MissingEntry):
            due = deadlines.stages.get(stage, DueDates()).due
            _enter_due_date(course, book, book.find_assignment(stage), due and _to_naive_utc(due))


def _enter_due_date(
    course: Course, book: Gradebook, assignment: Assignment, due_date: datetime | None
) -> None:
    path = course.verdicts / f".due.{assignment.name}"
    recorded = entered, previous_date = _read_due(path)
    if assignment.duedate != entered:  # a person has changed the date
        previous_date = assignment.duedate
    if due_date is not None and (due_date, previous_date) != recorded:
        times = [time and time.isoformat() for time in (due_date, previous_date)]
        # Record the date before entering it, because an unrecorded date could never be removed.
        write_atomically(json.dumps(times), path)
    due = previous_date if due_date is None else due_date
    if assignment.duedate != due:
        assignment.duedate = due
        book.db.commit()
    if due_date is None:
        path.unlink(missing_ok=True)


def _read_due(path: Path) -> tuple[datetime | None, datetime | None]:
    """Return the due date that was entered, and the gradebook's earlier date."""
    try:
        entered, before = json.loads(path.read_text("utf-8"))
        return datetime.fromisoformat(entered), before and datetime.fromisoformat(before)
    except (OSError, ValueError, TypeError):
        return None, None


def extension_of(
    course: Course, submission: SubmittedAssignment, deadlines: Deadlines
) -> timedelta | None:
    """Return a student's extension relative to the stage's due date; it may be negative.

    A longer extension that a person granted in the gradebook counts, unless deadlines.toml names
    the student.
    """
    student, stage = submission.student.id, submission.assignment.name
    dates = deadlines.stages.get(stage, DueDates())
    granted = submission.extension
    if granted is not None and granted == _entered_extension(course, student, stage):
        granted = None  # the extension came from deadlines.toml, not from a person
    if dates.due is None:
        return granted
    wanted = deadlines.due_date(student, stage) - dates.due
    if granted is not None and granted > wanted and student not in dates.students:
        return granted
    return wanted or None


def set_extension(course: Course, submission: SubmittedAssignment, deadlines: Deadlines) -> None:
    """Give a submission its extension, and record that it came from deadlines.toml."""
    extension = extension_of(course, submission, deadlines)
    if extension == submission.extension:
        return
    path = _extension_path(course, submission.student.id, submission.assignment.name)
    if extension is None:
        path.unlink(missing_ok=True)
    else:
        write_atomically(json.dumps(extension.total_seconds()), path)
    submission.extension = extension


def gradebook_extensions(
    course: Course, stages: Iterable[str], deadlines: Deadlines
) -> dict[str, dict[str, datetime]]:
    """Return the due dates that are later in the gradebook than in deadlines.toml.

    Returns
    -------
    dict of str to (dict of str to datetime)
        Due dates with a time zone, by stage and student. The student `""` means the whole class; it
        is used if deadlines.toml has no date.
    """
    granted: dict[str, dict[str, datetime]] = {stage: {} for stage in stages}
    if not gradebook_exists(course):
        return granted
    with open_gradebook(course) as book:
        for stage, dates in granted.items():
            with contextlib.suppress(MissingEntry):
                dates |= _granted_dates(course, book.find_assignment(stage), deadlines)
    return granted


def _granted_dates(
    course: Course, assignment: Assignment, deadlines: Deadlines
) -> dict[str, datetime]:
    date_of_file = deadlines.stages.get(assignment.name, DueDates()).due
    due = date_of_file or (assignment.duedate and assignment.duedate.replace(tzinfo=UTC))
    if due is None:
        return {}
    dates = {} if date_of_file else {"": due}
    for submission in assignment.submissions:
        student = submission.student.id
        extended_date = due + (extension_of(course, submission, deadlines) or timedelta())
        if extended_date > (deadlines.due_date(student, assignment.name) or due):
            dates[student] = extended_date
    return dates


def _entered_extension(course: Course, student: str, stage: str) -> timedelta | None:
    try:
        return timedelta(
            seconds=json.loads(_extension_path(course, student, stage).read_text("utf-8"))
        )
    except (OSError, ValueError, TypeError):
        return None


def _extension_path(course: Course, student: str, stage: str) -> Path:
    return course.verdicts / student / stage / ".extension"


def _to_naive_utc(time: datetime) -> datetime:
    """Convert a time to a naive time in UTC, as nbgrader stores it."""
    return time.astimezone(UTC).replace(tzinfo=None)
