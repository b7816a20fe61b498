"""Take out of the gradebook what is no longer handed in, but for what a person did."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterable

from nbgrader.api import Comment, Gradebook, MissingEntry, SubmittedNotebook
from sqlalchemy import exists, func, or_

from grader.course.paths import Course
from grader.lms.gradebook_rows import MARKED_BY_HAND

# Of a notebook: a person has written about it.
_COMMENTED = exists().where(
    Comment.notebook_id == SubmittedNotebook.id, func.coalesce(Comment.manual_comment, "") != ""
)


def withdraw(
    course: Course,
    book: Gradebook,
    stages: Iterable[str],
    known: set[tuple[str, str]],
    only: str | None,
) -> list[str]:
    """Take out what is no longer handed in; what a person has graded is named and stays.

    `known` has the (student, stage) of what is; `only` is who alone was graded, or None.
    """
    trouble = []
    for stage in stages:
        with contextlib.suppress(MissingEntry):
            for submission in list(book.find_assignment(stage).submissions):
                student = submission.student.id
                if (student, stage) in known or only not in (None, student):
                    continue
                of_a_person = book.db.query(SubmittedNotebook.id).filter(
                    SubmittedNotebook.assignment_id == submission.id,
                    or_(MARKED_BY_HAND, _COMMENTED),
                )
                if of_a_person.first():
                    trouble.append(
                        f"{student}, {stage}: nothing is handed in any more, but the gradebook "
                        "holds marks or comments of a person. Put the submission back, or take it "
                        f"out with: nbgrader db assignment list, and Gradebook.remove_submission"
                        f"({stage!r}, {student!r})"
                    )
                    continue
                book.remove_submission(stage, student)
                shutil.rmtree(course.autograded / student / stage, ignore_errors=True)
    return trouble
