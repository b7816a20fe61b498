"""Compute nbgrader's late penalties with the plugin that the course has configured.

nbgrader passes only the seconds since the due date to a plugin. Here, every day on the clock counts
as 86,400 seconds, so a plugin also counts days correctly when the clocks change.
"""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime

from nbgrader.api import SubmittedAssignment, SubmittedNotebook
from nbgrader.preprocessors import AssignLatePenalties

from grader.course.deadlines import Deadlines
from grader.course.nbgrader_settings import course_settings
from grader.course.paths import Course
from grader.course.times import compute_lateness
from grader.lms.mark_history import exercise_of


def load_late_penalties(course: Course) -> AssignLatePenalties:
    """Create nbgrader's preprocessor for late penalties, with the course's plugin."""
    penalties = AssignLatePenalties(config=course_settings(course.root))
    penalties.init_plugin()
    return penalties


def penalty_of(
    submission: SubmittedAssignment,
    notebook: SubmittedNotebook,
    late_penalties: AssignLatePenalties,
    deadlines: Deadlines,
    times: Mapping[str, datetime],
) -> float | None:
    """Return the points to subtract from a notebook, or None if it is on time.

    `times` contains the times of lessons that were submitted separately; see `lesson_times`.
    """
    if submission.timestamp is None:
        return None
    student, lesson = submission.student.id, notebook.name
    # If the class has no due date, nbgrader has no date to which it could add an extension.
    class_due = submission.assignment.duedate
    stage_due = submission.duedate.replace(tzinfo=UTC) if class_due else None
    class_due = class_due and class_due.replace(tzinfo=UTC)
    stage = submission.assignment.name
    due = deadlines.lesson_due_date(student, stage, lesson, stage_due, class_due)
    if due is None:
        return None
    submitted_at = times.get(lesson, submission.timestamp.replace(tzinfo=UTC))
    seconds = compute_lateness(submitted_at, due, deadlines.zone).total_seconds()
    if not seconds:
        return None
    score = notebook.score - sum(
        grade.score
        for grade in notebook.grades
        if exercise_of(grade.name) in deadlines.rules.excluded_exercises
    )
    penalty = late_penalties.plugin_inst.late_submission_penalty(student, score, seconds)
    return (
        None
        if penalty is None
        else min(score, late_penalties._check_late_penalty(notebook, penalty))
    )
