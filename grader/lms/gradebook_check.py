"""Examine the gradebook for the `doctor` command."""

from __future__ import annotations

from collections.abc import Iterator

from grader.classroom.doctor import NOT_CHECKED, Finding
from grader.classroom.submissions import find_submissions
from grader.course.deadlines_file import DeadlinesError
from grader.course.paths import Course
from grader.course.roster import RosterError
from grader.lms.gradebook import gradebook_location, open_gradebook
from grader.lms.instructor_notes import excessive_mark_notes, unlisted_student_notes
from grader.lms.marks_by_hand import lost_marks, lost_sentence
from grader.lms.results import GradebookUnavailable
from grader.lms.results_reader import class_results


def check_gradebook(course: Course) -> Iterator[Finding]:
    """Examine whether the gradebook opens, and whether its marks are complete and valid."""
    try:
        results = class_results(course)
        submitted = {submission.student for submission in find_submissions(course)}
        with open_gradebook(course) as book:
            lost = lost_marks(course, book, submitted)
    except GradebookUnavailable as error:
        yield Finding("gradebook", False, str(error))
        return
    except (RosterError, DeadlinesError):  # other findings of `doctor` describe these problems
        yield Finding("gradebook", False, NOT_CHECKED)
        return
    marked = {result.student for result in results.notebooks if result.score is not None}
    students = f"{len(marked)} student{'s' * (len(marked) != 1)}"
    yield Finding("gradebook", True, f"{gradebook_location(course)}, with marks for {students}")
    if lost:
        yield Finding("gradebook", False, lost_sentence(course, lost))
    for sentence in (*excessive_mark_notes(results), *unlisted_student_notes(results)):
        yield Finding("gradebook", False, sentence)
