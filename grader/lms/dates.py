"""Let the gradebook know when work is due, for whom later, so that nbgrader's penalties agree.

nbgrader keeps one date for a stage, and with a student's submission how much later that student
may hand in. So a date that was given before anything was handed in is entered with what is. What
was entered is remembered in ``verdicts/``, so that what leaves the file is taken back, and what a
person has entered in the gradebook is not.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from pathlib import Path

from nbgrader.api import Assignment, Gradebook, MissingEntry, SubmittedAssignment

from grader.course.atomic_files import write_atomically
from grader.course.deadlines import Dates, Deadlines
from grader.course.lessons import stages
from grader.course.paths import Course
from grader.lms.gradebook import is_there, open_gradebook


def enter_due_dates(course: Course, book: Gradebook, deadlines: Deadlines) -> None:
    """Enter when each stage that the gradebook knows is due.

    A date that has left the file leaves the gradebook, too, which has again what it had before.
    """
    for stage in stages():
        with contextlib.suppress(MissingEntry):
            due = deadlines.stages.get(stage, Dates()).due
            _enter_due_date(course, book, book.find_assignment(stage), due and _naive(due))


def _enter_due_date(
    course: Course, book: Gradebook, assignment: Assignment, wanted: datetime | None
) -> None:
    path = course.verdicts / f".due.{assignment.name}"
    remembered = entered, before = _read_due(path)
    if assignment.duedate != entered:  # a person has entered it
        before = assignment.duedate
    if wanted is not None and (wanted, before) != remembered:
        times = [time and time.isoformat() for time in (wanted, before)]
        write_atomically(json.dumps(times), path)  # first: what is forgotten would stay for good
    due = before if wanted is None else wanted
    if assignment.duedate != due:
        assignment.duedate = due
        book.db.commit()
    if wanted is None:
        path.unlink(missing_ok=True)


def _read_due(path: Path) -> tuple[datetime | None, datetime | None]:
    """What was entered as due, and what the gradebook had before."""
    try:
        entered, before = json.loads(path.read_text("utf-8"))
        return datetime.fromisoformat(entered), before and datetime.fromisoformat(before)
    except (OSError, ValueError, TypeError):
        return None, None


def extension(
    course: Course, submission: SubmittedAssignment, deadlines: Deadlines
) -> timedelta | None:
    """How much later than everybody a student may hand in a stage, which may be negative.

    Where somebody has granted more in the gradebook, that counts, until the file names the student.
    """
    student, stage = submission.student.id, submission.assignment.name
    dates = deadlines.stages.get(stage, Dates())
    granted = submission.extension
    if granted is not None and granted == _entered(course, student, stage):
        granted = None  # nobody's wish but the file's
    if dates.due is None:
        return granted
    wanted = deadlines.due(student, stage) - dates.due
    if granted is not None and granted > wanted and student not in dates.students:
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


def granted_in_gradebook(
    course: Course, stages: Iterable[str], deadlines: Deadlines
) -> dict[str, dict[str, datetime]]:
    """Until when stages may be handed in, as far as the gradebook says more than the file.

    Returns
    -------
    dict of str to (dict of str to datetime)
        By stage and student, aware; `""` is everybody, where the file has no date.
    """
    found: dict[str, dict[str, datetime]] = {stage: {} for stage in stages}
    if not is_there(course):
        return found
    with open_gradebook(course) as book:
        for stage, names in found.items():
            with contextlib.suppress(MissingEntry):
                names |= _granted(course, book.find_assignment(stage), deadlines)
    return found


def _granted(course: Course, assignment: Assignment, deadlines: Deadlines) -> dict[str, datetime]:
    date_of_file = deadlines.stages.get(assignment.name, Dates()).due
    due = date_of_file or (assignment.duedate and assignment.duedate.replace(tzinfo=UTC))
    if due is None:
        return {}
    names = {} if date_of_file else {"": due}
    for submission in assignment.submissions:
        student = submission.student.id
        until = due + (extension(course, submission, deadlines) or timedelta())
        if until > (deadlines.due(student, assignment.name) or due):
            names[student] = until
    return names


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
