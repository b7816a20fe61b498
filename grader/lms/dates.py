"""Let the gradebook know when work is due, for whom later, so that nbgrader's penalties agree.

nbgrader keeps one date for a stage, and with a student's submission how much later that student
may hand in. So a date that was given before anything was handed in is entered with what is.
"""

from __future__ import annotations

import contextlib
import json
from datetime import UTC, datetime, timedelta
from pathlib import Path

from nbgrader.api import Gradebook, MissingEntry, SubmittedAssignment

from grader.course.deadlines import Deadlines
from grader.course.paths import Course
from grader.judging.verdict import write_atomically


def enter_due_dates(book: Gradebook, deadlines: Deadlines) -> None:
    """Enter when each stage that the gradebook knows is due."""
    for stage, dates in deadlines.stages.items():
        with contextlib.suppress(MissingEntry):
            assignment = book.find_assignment(stage)
            if dates.due and assignment.duedate != _naive(dates.due):
                assignment.duedate = _naive(dates.due)
                book.db.commit()


def extension(
    course: Course, submission: SubmittedAssignment, deadlines: Deadlines
) -> timedelta | None:
    """How much later than everybody a student may hand in a stage, which may be negative.

    Where somebody has granted more in the gradebook, that counts, until the file names the student.
    """
    student, stage = submission.student.id, submission.assignment.name
    dates = deadlines.stages.get(stage)
    if dates is None or dates.due is None:
        return submission.extension
    wanted = deadlines.due(student, stage) - dates.due
    granted = submission.extension
    if (
        granted is not None
        and granted != _entered(course, student, stage)
        and granted > wanted
        and student not in dates.students
    ):
        return granted
    return wanted or None


def extend(course: Course, submission: SubmittedAssignment, deadlines: Deadlines) -> None:
    """Give a submission its extension, and remember that it was not a person who did."""
    wanted = extension(course, submission, deadlines)
    if wanted == submission.extension:
        return
    path = _path(course, submission.student.id, submission.assignment.name)
    if wanted is None:
        path.unlink(missing_ok=True)
    else:
        write_atomically(json.dumps(wanted.total_seconds()), path)
    submission.extension = wanted


def _entered(course: Course, student: str, stage: str) -> timedelta | None:
    try:
        return timedelta(seconds=json.loads(_path(course, student, stage).read_text("utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def _path(course: Course, student: str, stage: str) -> Path:
    return course.verdicts / student / stage / ".extension"


def _naive(time: datetime) -> datetime:
    """A time as nbgrader keeps it: in UTC, without saying so."""
    return time.astimezone(UTC).replace(tzinfo=None)
