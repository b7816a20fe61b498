"""Notes for the instructor about the marks of a class, one sentence each."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from datetime import UTC

from grader.course.deadlines import Deadlines, deadlines_path
from grader.course.paths import Course
from grader.lms.results import ClassResults, StageResult


def notes(course: Course, results: ClassResults, deadlines: Deadlines | None) -> Iterator[str]:
    """Yield notes about late work and enrolment that require a decision after grading."""
    for stage in results.stages:
        label = f"{stage.student}, {stage.stage}"
        if stage.undecided:
            yield (
                f"{label}: {stage.undecided}, so lateness is undecided. Write the time "
                "into timestamp.txt in that folder, such as 2026-11-22 18:30:00 UTC, and run "
                "grade again."
            )
        if deadlines and _is_granted(stage, deadlines):
            until = stage.due.astimezone(UTC)
            yield (
                f"{label}: the gradebook grants more time than {deadlines_path(course).name}, "
                f"until {until:%Y-%m-%d %H:%M} UTC, and this date counts. To keep it, add it to "
                f'the file below [{stage.stage}.students]: "{stage.student}" = '
                f"{until:%Y-%m-%dT%H:%M:%S}Z. To replace it, write another date there."
            )
    yield from excessive_notes(results)
    yield from unlisted_notes(results)


def excessive_notes(results: ClassResults) -> Iterator[str]:
    """Yield one sentence for each mark by hand that is above the maximum of its exercise."""
    for mark in results.excessive:
        yield f"{mark}. Its maximum was reduced after a person graded it: grade it again."


def unlisted_notes(results: ClassResults) -> Iterator[str]:
    """Yield one sentence for each student with marks who is not on the roster."""
    for student in results.unlisted:
        yield (
            f"{student!r} has marks in the gradebook and is not on the roster, so tables and "
            "exports omit them. Add a line to roster.csv, or remove the marks: "
            f"nbgrader db student remove {shlex.quote(student)} --force"
        )


def _is_granted(stage: StageResult, deadlines: Deadlines) -> bool:
    """Return whether the gradebook grants more time than deadlines.toml."""
    due = deadlines.due(stage.student, stage.stage)
    return due is not None and stage.due is not None and stage.due > due
