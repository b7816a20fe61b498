"""Remove withdrawn submissions from the gradebook, unless a person has graded them."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterable

from nbgrader.api import Comment, Gradebook, MissingEntry, SubmittedNotebook
from sqlalchemy import exists, func, or_

from grader.course.paths import Course
from grader.lms.gradebook_rows import HAS_MARK_BY_HAND

# SQL condition on a notebook: a person has written a comment on it.
_HAS_COMMENT = exists().where(
    Comment.notebook_id == SubmittedNotebook.id, func.coalesce(Comment.manual_comment, "") != ""
)


def withdraw(
    course: Course,
    book: Gradebook,
    stages: Iterable[str],
    submitted_stages: set[tuple[str, str]],
    student_id: str | None,
) -> list[str]:
    """Remove withdrawn submissions; those with manual marks or comments stay and are reported.

    `submitted_stages` contains the (student, stage) of each existing submission. If `student_id` is
    given, only that student's submissions are removed.
    """
    problems = []
    for stage in stages:
        with contextlib.suppress(MissingEntry):
            for submission in list(book.find_assignment(stage).submissions):
                student = submission.student.id
                if (student, stage) in submitted_stages or student_id not in (None, student):
                    continue
                graded_by_hand = book.db.query(SubmittedNotebook.id).filter(
                    SubmittedNotebook.assignment_id == submission.id,
                    or_(HAS_MARK_BY_HAND, _HAS_COMMENT),
                )
                if graded_by_hand.first():
                    problems.append(
                        f"{student}, {stage}: the submission is gone, but the gradebook has a "
                        "grader's marks or comments on it. Put the submission back, or remove it "
                        "from the gradebook with nbgrader's "
                        f"Gradebook.remove_submission({stage!r}, {student!r})"
                    )
                    continue
                book.remove_submission(stage, student)
                shutil.rmtree(course.autograded / student / stage, ignore_errors=True)
    return problems
