"""Checks of the gradebook for the `doctor` command."""

from __future__ import annotations

from collections.abc import Iterator

from grader.classroom.doctor import Finding
from grader.course.deadlines import DeadlinesTrouble
from grader.course.paths import Course
from grader.course.roster import RosterTrouble
from grader.lms.gradebook import address
from grader.lms.instructor_notes import not_on_the_roster
from grader.lms.results import GradebookUnreachable
from grader.lms.standings import class_results


def examine_gradebook(course: Course) -> Iterator[Finding]:
    """Check that the gradebook opens and that all students with marks are on the roster."""
    try:
        results = class_results(course)
    except GradebookUnreachable as error:
        yield Finding("gradebook", False, str(error))
        return
    except (RosterTrouble, DeadlinesTrouble):
        return  # other checks of `doctor` report these problems
    marked = {result.student for result in results.notebooks if result.score is not None}
    yield Finding("gradebook", True, f"{address(course)}, with marks of {len(marked)} students")
    for sentence in not_on_the_roster(results):
        yield Finding("gradebook", False, sentence)
