"""What `doctor` says about the gradebook."""

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
    """Whether it opens, whose marks it holds, and whether they all are on the roster."""
    try:
        results = class_results(course)
    except GradebookUnreachable as error:
        yield Finding("gradebook", False, str(error))
        return
    except (RosterTrouble, DeadlinesTrouble):
        return  # which is said already
    marked = {notebook.student for notebook in results.notebooks if notebook.score is not None}
    yield Finding("gradebook", True, f"{address(course)}, with marks of {len(marked)} students")
    for sentence in not_on_the_roster(results):
        yield Finding("gradebook", False, sentence)
