"""Notes for the instructor about the marks of a class, one sentence each."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from datetime import UTC, timedelta, tzinfo

from grader.course.deadlines import Deadlines, deadlines_path
from grader.course.paths import Course
from grader.course.times import time_late, to_utc
from grader.lms.marks_table import duration
from grader.lms.results import ClassResults, StageResult


def notes(course: Course, results: ClassResults, deadlines: Deadlines | None) -> Iterator[str]:
    """Yield notes about late work and enrolment that require a decision after grading."""
    for stage in results.stages:
        label = f"{stage.student}, {stage.stage}"
        if stage.undecided:
            yield (
                f"{label}: {stage.undecided}, so it is not known whether the work is late, and no "
                "penalty is subtracted. Write the time into timestamp.txt in that folder, such as "
                "2026-11-22 18:30:00 UTC, and run grade again."
            )
        yield from _zone_notes(stage, label, deadlines.zone if deadlines else None)
        if deadlines and _is_granted(stage, deadlines):
            until = stage.due.astimezone(UTC)
            yield (
                f"{label}: the gradebook grants more time than {deadlines_path(course).name}, "
                f"until {until:%Y-%m-%d %H:%M} UTC, and this date counts. To keep it, add it to "
                f'the file below [{stage.stage}.students]: "{stage.student}" = '
                f"{until:%Y-%m-%dT%H:%M:%S}Z. To replace it, write another date there."
            )
    yield from unlisted_notes(results)


def unlisted_notes(results: ClassResults) -> Iterator[str]:
    """Yield one sentence for each student with marks who is not on the roster."""
    for student in results.unlisted:
        yield (
            f"{student!r} has marks in the gradebook and is not on the roster, so tables and "
            "exports omit them. Add a line to roster.csv, or remove the marks: "
            f"nbgrader db student remove {shlex.quote(student)} --force"
        )


def _zone_notes(stage: StageResult, label: str, zone: tzinfo | None) -> Iterator[str]:
    """Yield a sentence if it matters whether a time without a zone is in UTC or in the course's."""
    if not (stage.lacks_zone and stage.submitted_at and stage.due):
        return
    local = to_utc(stage.submitted_at.replace(tzinfo=None), zone).astimezone(zone)
    late = time_late(local, stage.due, zone)
    if late == stage.late:
        return
    yield (
        f"{label}: the time in timestamp.txt has no time zone and was read as UTC: "
        f"{_lateness(stage.late)}. In the time zone of the course, the work would be "
        f"{_lateness(late)}. Write the zone into that file, as in "
        f"{stage.submitted_at:%Y-%m-%d %H:%M:%S} UTC or {local:%Y-%m-%d %H:%M:%S%z}, and run grade "
        "again."
    )


def _lateness(late: timedelta) -> str:
    return f"{duration(late)} late" if late else "on time"


def _is_granted(stage: StageResult, deadlines: Deadlines) -> bool:
    """Return whether the gradebook grants more time than deadlines.toml."""
    due = deadlines.due(stage.student, stage.stage)
    return due is not None and stage.due is not None and stage.due > due
