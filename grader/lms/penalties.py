"""Compute nbgrader's late penalties with the plugin that the course has configured.

nbgrader tells a plugin only the seconds since the due date. Here every day on the clock counts as
86,400 seconds, so that plugins which count days agree with the clock when it changes.
"""

from __future__ import annotations

from datetime import UTC

from nbgrader.api import SubmittedAssignment, SubmittedNotebook
from nbgrader.preprocessors import AssignLatePenalties

from grader.course.deadlines import Deadlines
from grader.course.nbgrader_settings import course_settings
from grader.course.paths import Course
from grader.course.times import time_late


def load_penalty_plugin(course: Course) -> AssignLatePenalties:
    """Create nbgrader's preprocessor for late penalties, with the course's plugin."""
    penalties = AssignLatePenalties(config=course_settings(course.root))
    penalties.init_plugin()
    return penalties


def penalty_of(
    submission: SubmittedAssignment,
    notebook: SubmittedNotebook,
    late: AssignLatePenalties,
    deadlines: Deadlines,
) -> float | None:
    """Return the points to subtract from a notebook, or None if it is on time."""
    # Without a due date, nbgrader cannot add an extension to it.
    if submission.assignment.duedate is None or submission.timestamp is None:
        return None
    submitted_at, due = (
        time.replace(tzinfo=UTC) for time in (submission.timestamp, submission.duedate)
    )
    seconds = time_late(submitted_at, due, deadlines.zone).total_seconds()
    if not seconds:
        return None
    penalty = late.plugin_inst.late_submission_penalty(
        submission.student.id, notebook.score, seconds
    )
    return None if penalty is None else late._check_late_penalty(notebook, penalty)
