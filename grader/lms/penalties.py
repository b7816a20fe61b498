"""Compute nbgrader's late penalties with the plugin that the course has configured."""

from __future__ import annotations

from nbgrader.api import SubmittedAssignment, SubmittedNotebook
from nbgrader.preprocessors import AssignLatePenalties

from grader.course.nbgrader_settings import course_settings
from grader.course.paths import Course


def load_penalty_plugin(course: Course) -> AssignLatePenalties:
    """Create nbgrader's preprocessor for late penalties, with the course's plugin."""
    penalties = AssignLatePenalties(config=course_settings(course.root))
    penalties.init_plugin()
    return penalties


def penalty_of(
    submission: SubmittedAssignment, notebook: SubmittedNotebook, late: AssignLatePenalties
) -> float | None:
    """Return the points to subtract from a notebook, or None if it is on time."""
    if submission.assignment.duedate is None or not submission.total_seconds_late:
        return None
    penalty = late.plugin_inst.late_submission_penalty(
        submission.student.id, notebook.score, submission.total_seconds_late
    )
    return None if penalty is None else late._check_late_penalty(notebook, penalty)
