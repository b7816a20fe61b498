"""Examine the gradebook for the `doctor` command."""

from __future__ import annotations

from collections.abc import Iterator

from grader.classroom.doctor import Finding
from grader.course.deadlines import DeadlinesError
from grader.course.paths import Course
from grader.course.roster import RosterError
from grader.lms.gradebook import gradebook_location
from grader.lms.instructor_notes import unlisted_notes
from grader.lms.results import GradebookUnavailable
from grader.lms.standings import class_results


def check_gradebook(course: Course) -> Iterator[Finding]:
    """Examine whether the gradebook opens and all students with marks are on the roster."""
    try:
        results = class_results(course)
    except GradebookUnavailable as error:
        yield Finding("gradebook", False, str(error))
        return
    except (RosterError, DeadlinesError):
        return  # other examinations of `doctor` report these problems
    marked = {result.student for result in results.notebooks if result.score is not None}
    yield Finding(
        "gradebook", True, f"{gradebook_location(course)}, with marks of {len(marked)} students"
    )
    for sentence in unlisted_notes(results):
        yield Finding("gradebook", False, sentence)
