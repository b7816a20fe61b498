"""Notes for the instructor about the marks of a class, one sentence each."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Iterable, Iterator
from datetime import UTC, timedelta, tzinfo

from grader.course.deadlines import Deadlines
from grader.course.deadlines_file import deadlines_path
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.course.times import compute_lateness, to_utc
from grader.lms.marks_table import format_duration
from grader.lms.results import WAITING, ClassResults, NotebookResult, StageResult, format_points

DEADLINES_FILE = "deadlines.toml"


def counted_lesson_notes(results: ClassResults) -> dict[str, str]:
    """Return a sentence about the lessons that count in each stage, by stage."""
    stages: dict[str, dict[str, float]] = {}
    for result in results.notebooks:
        stages.setdefault(result.stage, {})[result.lesson] = result.max_score
    sentences = {}
    for stage, points in stages.items():
        numbers = ", ".join(name[:2] for name in points)
        excluded = [
            name for lesson in points for name in results.rules.excluded_in(find_lesson(lesson))
        ]
        without = f", without {', '.join(excluded)}" if excluded else ""
        total = format_points(sum(points.values()))
        sentences[stage] = (
            f"Lessons that count in {stage}: {numbers} ({total} points in total{without})."
        )
    return sentences


def assignment_notes(
    results: ClassResults, deadlines: Deadlines | None, only: Collection[str] = ()
) -> Iterator[str]:
    """Yield notes about lessons and work that may not count, and about outdated marks.

    `only` lists the stages to describe; by default, all stages are described.
    """
    students: dict[str, list[str]] = {}
    for student, lesson in results.unassigned:
        if not only or find_lesson(lesson).stage in only:
            students.setdefault(lesson, []).append(student)
    for lesson, names in students.items():
        yield (
            f"{lesson} does not count for {', '.join(names)}, because {DEADLINES_FILE} does not "
            "list it below the stage."
        )
    for stage in dict.fromkeys(result.stage for result in results.notebooks):
        if only and stage not in only:
            continue
        if deadlines is None or deadlines.assigned_lessons(stage) is None:
            yield from _rarely_submitted(results, stage)
        yield from outdated_mark_notes(results, stage)


def outdated_mark_notes(results: ClassResults, stage: str) -> Iterator[str]:
    """Yield a note about marks in a stage that were entered before something changed."""
    students = [student for student, outdated in results.outdated if outdated == stage]
    if students:
        yield (
            f"Files, submission times, due dates or points have changed since {stage} was graded, "
            f"so these marks may be out of date: {', '.join(students)}. Run: python -m grader "
            f"grade {stage}"
        )


def _rarely_submitted(results: ClassResults, stage: str) -> Iterator[str]:
    """Yield a note about lessons that no student, or only one of at least three, submitted."""
    students: dict[str, list[str]] = {}
    for result in results.notebooks:
        if result.stage == stage:
            has_work = result.score is not None or result.status == WAITING
            students.setdefault(result.lesson, []).extend([result.student] * has_work)
    submitters = {student for names in students.values() for student in names}
    least = 2 if len(submitters) > 2 else 1
    rare = {lesson: names for lesson, names in students.items() if len(names) < least}
    others = ", ".join(f'"{lesson[:2]}"' for lesson in students if lesson not in rare)
    if rare and others and len(submitters) > 1:
        missing = ", ".join(lesson for lesson, names in rare.items() if not names)
        who = [f"no student submitted {missing}"] * bool(missing)
        who += [f"only {names[0]} submitted {lesson}" for lesson, names in rare.items() if names]
        yield (
            f"{stage}: {'; '.join(who)}. All released lessons count. If you have not assigned all "
            f"of them, write lessons = [{others}] below [{stage}] in {DEADLINES_FILE}."
        )


def notes(course: Course, results: ClassResults, deadlines: Deadlines | None) -> Iterator[str]:
    """Yield all notes about marks that an instructor sees after grading."""
    for stage in results.stages:
        label = f"{stage.student}, {stage.stage}"
        if stage.undecided:
            yield (
                f"{label}: {stage.undecided}, so it is unknown whether the work is late, and no "
                "penalty is subtracted. Write the time, such as 2026-11-22 18:30:00 UTC, into "
                "timestamp.txt in the folder of this stage, and run grade again."
            )
        yield from _zone_notes(
            stage, results.of_student(stage.student), deadlines.zone if deadlines else None
        )
        if deadlines and _grants_more_time(stage, deadlines):
            until = stage.due.astimezone(UTC)
            yield (
                f"{label}: the gradebook grants more time than {deadlines_path(course).name}, "
                f"until {until:%Y-%m-%d %H:%M} UTC. The later date counts. To keep that date, add "
                f'this line below [{stage.stage}.students] in the file: "{stage.student}" = '
                f"{until:%Y-%m-%dT%H:%M:%S}Z. To change the date, write a different one."
            )
    yield from _shared_time_notes(results)
    yield from assignment_notes(results, deadlines)
    yield from excessive_mark_notes(results)
    yield from unlisted_student_notes(results)


def excessive_mark_notes(results: ClassResults) -> Iterator[str]:
    """Yield one sentence for each manual mark that is above the maximum of its exercise."""
    for _, mark in results.excessive:
        yield f"{mark}. The maximum was reduced after a person graded this answer. Grade it again."


def unlisted_student_notes(results: ClassResults) -> Iterator[str]:
    """Yield one sentence for each student with marks who is not on the roster."""
    for student in results.unlisted:
        yield (
            f"{student!r} has marks in the gradebook but is not on the roster, so tables and "
            "exports omit these marks. Add a line to roster.csv, or remove the marks: "
            f"nbgrader db student remove {shlex.quote(student)} --force"
        )


def _shared_time_notes(results: ClassResults) -> Iterator[str]:
    """Yield a sentence for each stage in which one lesson's time may make another one late."""
    students_by_stage: dict[str, list[str]] = {}
    for stage in results.stages:
        submitted = [
            result
            for result in results.of_student(stage.student)
            if result.stage == stage.stage and result.submitted_at
        ]
        if len(submitted) > 1 and any(
            result.late and result.has_shared_time for result in submitted
        ):
            students_by_stage.setdefault(stage.stage, []).append(stage.student)
    for stage, names in students_by_stage.items():
        yield (
            f"{stage}: lessons have their own due dates, but only the time of the whole stage is "
            f"known for {', '.join(names)}, so a lesson that was on time may count as late. "
            "Collect after each due date with --timestamps, or use one due date for the stage."
        )


def _zone_notes(
    stage: StageResult, notebooks: Iterable[NotebookResult], zone: tzinfo | None
) -> Iterator[str]:
    """Yield a sentence if the time zone of a submission time is unknown and affects lateness."""
    own = [result for result in notebooks if result.stage == stage.stage and result.submitted_at]
    dues = {result.due for result in own if result.due} or {stage.due} - {None}
    if not (stage.lacks_zone and stage.submitted_at and dues):
        return
    local = to_utc(stage.submitted_at.replace(tzinfo=None), zone).astimezone(zone)
    late = max(compute_lateness(local, due, zone) for due in dues)
    if late == stage.late:
        return
    yield (
        f"{stage.student}, {stage.stage}: the time in timestamp.txt has no time zone, so it was "
        f"read as UTC. The work counts as {_format_lateness(stage.late)}. In the time zone of the "
        f"course, it would be {_format_lateness(late)}. Add the zone to that time, as in "
        f"{stage.submitted_at:%Y-%m-%d %H:%M:%S} UTC or {local:%Y-%m-%d %H:%M:%S%z}, and run grade "
        "again."
    )


def _format_lateness(late: timedelta) -> str:
    return f"{format_duration(late)} late" if late else "on time"


def _grants_more_time(stage: StageResult, deadlines: Deadlines) -> bool:
    """Return whether the gradebook grants more time than deadlines.toml."""
    due = deadlines.due_date(stage.student, stage.stage)
    return due is not None and stage.due is not None and stage.due > due
