"""What nbgrader takes off a notebook for lateness, by the plugin that the course chose."""

from __future__ import annotations

from nbgrader.api import SubmittedAssignment, SubmittedNotebook
from nbgrader.preprocessors import AssignLatePenalties

from grader.course.nbgrader_settings import course_settings
from grader.course.paths import Course


def late_penalties(course: Course) -> AssignLatePenalties:
    """Nbgrader's penalties for lateness, with the plugin that the course chose."""
    penalties = AssignLatePenalties(config=course_settings(course.root))
    penalties.init_plugin()
    return penalties


def penalty_of(
    submission: SubmittedAssignment, notebook: SubmittedNotebook, late: AssignLatePenalties
) -> float | None:
    """Points to take off a notebook; None in time."""
    if submission.assignment.duedate is None or not submission.total_seconds_late:
        return None
    penalty = late.plugin_inst.late_submission_penalty(
        submission.student.id, notebook.score, submission.total_seconds_late
    )
    return None if penalty is None else late._check_late_penalty(notebook, penalty)
