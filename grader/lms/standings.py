"""Combine each student's results from the gradebook, the roster, due dates and submitted files."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import UTC, timedelta

from grader.classroom.submissions import Submission, find_submissions
from grader.course.deadlines import Deadlines, read_deadlines
from grader.course.lessons import Lesson, find_lesson, released_lessons
from grader.course.paths import Course
from grader.course.roster import Person, read_roster
from grader.course.times import time_late
from grader.lms.gradebook import open_gradebook
from grader.lms.gradebook_rows import GradebookRow, read_excessive_marks, read_rows
from grader.lms.people import students_in_gradebook
from grader.lms.results import (
    AUDITOR,
    EXCUSED,
    MARKED,
    MISSING,
    WAITING,
    ClassResults,
    NotebookResult,
    StageResult,
    combined_status,
    format_points,
)
from grader.lms.submission_times import SubmissionTimeUnknown, lacks_zone, submission_time


def class_results(course: Course) -> ClassResults:
    """Return the results of all students in a course.

    Raises
    ------
    grader.course.roster.RosterError, grader.course.deadlines.DeadlinesError
    """
    with open_gradebook(course) as book:
        rows, in_gradebook = read_rows(book), students_in_gradebook(book)
        excessive = tuple(
            f"{student}, {lesson}, {cell.removeprefix('test_')}: {format_points(points)} of "
            f"{format_points(maximum)} points"
            for student, lesson, cell, points, maximum in read_excessive_marks(book)
        )
    roster, deadlines = read_roster(course), read_deadlines(course) or Deadlines({})
    submitted = {
        (submission.student, submission.lesson.name): submission
        for submission in find_submissions(course)
    }
    entered = {(row.student, row.lesson): row for row in rows}
    existing = {pair for pair, row in entered.items() if _has_work(course, row)}
    lessons, unassigned = _lessons_that_count(course, deadlines, {*existing, *submitted})
    max_scores = _max_scores(lessons, rows)
    people = roster.people if roster else _without_roster(in_gradebook, {*entered, *submitted})
    notebooks, stages = [], []
    for person in people:
        for stage in dict.fromkeys(lesson.stage for lesson in lessons):
            excused = EXCUSED if deadlines.is_excused(person.id, stage) else None
            excused = AUDITOR if person.is_auditor else excused
            results = []
            for lesson in (candidate for candidate in lessons if candidate.stage == stage):
                pair = (person.id, lesson.name)
                row = entered[pair] if pair in existing else None
                standing = excused or _standing(row, pair in submitted)
                results.append(_notebook(person, lesson, standing, row, max_scores[lesson.name]))
            files = [
                submitted[pair]
                for result in results
                if (pair := (result.student, result.lesson)) in submitted
            ]
            row = next(
                (
                    entered[pair]
                    for result in results
                    if (pair := (result.student, result.lesson)) in entered
                ),
                None,
            )
            notebooks += results
            stages.append(_stage(course, results, row, files, deadlines))
    unlisted = {row.student for row in rows} - {person.id for person in people}
    return ClassResults(
        tuple(people),
        tuple(notebooks),
        tuple(stages),
        tuple(sorted(unlisted)),
        excessive,
        tuple(unassigned),
    )


def _lessons_that_count(
    course: Course, deadlines: Deadlines, work: Iterable[tuple[str, str]]
) -> tuple[list[Lesson], list[tuple[str, str]]]:
    """Return the lessons that count in stages with work, and the (student, lesson) of other work.

    Unless deadlines.toml lists lessons, all released lessons of a stage count. If only submitted
    lessons counted, one student's work in a lesson would lower the share of all others.
    """
    by_lesson: dict[Lesson, list[str]] = {}
    for student, name in sorted(work):
        lesson = find_lesson(name)
        if lesson:  # the gradebook may contain lessons that the course does not have any more
            by_lesson.setdefault(lesson, []).append(student)
    counted: set[Lesson] = set()
    for stage in {lesson.stage for lesson in by_lesson}:
        assigned = deadlines.assigned(stage)
        if assigned is None:
            counted.update(lesson for lesson in by_lesson if lesson.stage == stage)
            counted.update(released_lessons(course, stage))
        else:
            counted.update(map(find_lesson, assigned))
    unassigned = [
        (student, lesson.name)
        for lesson, students in by_lesson.items()
        if lesson not in counted
        for student in students
    ]
    return sorted(counted, key=lambda lesson: lesson.name), unassigned


def _has_work(course: Course, row: GradebookRow) -> bool:
    """Return whether a row is about submitted work; nbgrader also creates rows for missing work.

    A row with points or with a mark given by hand counts even if the files no longer exist.
    """
    copy = course.autograded / row.student / row.stage / f"{row.lesson}.ipynb"
    return row.score > 0 or row.has_mark_by_hand or copy.is_file()


def _max_scores(lessons: Sequence[Lesson], rows: Sequence[GradebookRow]) -> dict[str, float]:
    """Return the maximum score of each lesson, from the gradebook or, if missing, the release."""
    released = {
        lesson.name: sum(exercise.points for exercise in lesson.exercises) for lesson in lessons
    }
    return released | {row.lesson: row.max_score for row in rows}


def _without_roster(
    in_gradebook: Sequence[Person], submitted: Iterable[tuple[str, str]]
) -> tuple[Person, ...]:
    """Return the students who submitted, with names if the gradebook has them."""
    by_id = {person.id: person for person in in_gradebook}
    return tuple(by_id.get(id, Person(id)) for id in sorted({student for student, _ in submitted}))


def _standing(row: GradebookRow | None, is_submitted: bool) -> str:
    """Return the standing in a lesson for a student who is not excused."""
    if row is None:
        return WAITING if is_submitted else MISSING
    return WAITING if row.needs_person else MARKED


def _notebook(
    person: Person, lesson: Lesson, standing: str, row: GradebookRow | None, max_score: float
) -> NotebookResult:
    return NotebookResult(
        person.id,
        lesson.stage,
        lesson.name,
        standing,
        row.score if row else None,
        max_score,
        row.penalty if row else 0.0,
    )


def _stage(
    course: Course,
    lessons: Sequence[NotebookResult],
    row: GradebookRow | None,
    files: Sequence[Submission],
    deadlines: Deadlines,
) -> StageResult:
    """Combine the results in a stage's lessons, and determine when the stage was submitted.

    The gradebook's times take precedence, because nbgrader computes penalties from them.
    """
    student, stage = lessons[0].student, lessons[0].stage
    scores = [result.score for result in lessons if result.score is not None]
    due = deadlines.due(student, stage)
    if row and row.due:
        due = (row.due + (row.extension or timedelta())).replace(tzinfo=UTC)
    submitted_at, undecided = row and row.submitted_at and row.submitted_at.replace(tzinfo=UTC), ""
    folders = {submission.stage_folder(course) for submission in files}
    if not submitted_at:
        try:
            submitted_at = submission_time(folders)
        except SubmissionTimeUnknown as error:
            undecided = str(error) if due else ""
    return StageResult(
        student,
        stage,
        combined_status(lessons),
        sum(scores) if scores else None,
        sum(result.max_score for result in lessons),
        sum(result.penalty for result in lessons),
        submitted_at,
        due,
        time_late(submitted_at, due, deadlines.zone) if submitted_at and due else timedelta(),
        undecided,
        lacks_zone(folders),
    )
