"""Combine each student's results from the gradebook, the roster, due dates and submitted files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta

from grader.classroom.submissions import Submission, find_submissions
from grader.course.deadlines import Deadlines, TermRules
from grader.course.deadlines_file import read_deadlines
from grader.course.lessons import Lesson, find_lesson, released_lessons
from grader.course.paths import Course
from grader.course.roster import Person, read_roster
from grader.course.times import compute_lateness
from grader.lms.cell_marks import CellMark, CellMarks, cell_marks
from grader.lms.gradebook import open_gradebook
from grader.lms.gradebook_rows import GradebookRow, read_excessive_marks, read_rows
from grader.lms.gradebook_students import students_in_gradebook
from grader.lms.mark_history import exercise_of
from grader.lms.mark_inputs import outdated_marks
from grader.lms.results import (
    AUDITOR,
    EXCUSED,
    MARKED,
    MISSING,
    WAITING,
    ClassResults,
    ExerciseMark,
    NotebookResult,
    StageResult,
    combined_status,
    format_points,
)
from grader.lms.submission_times import (
    SubmissionTimeUnknown,
    lacks_zone,
    lesson_times,
    submission_time,
)


def class_results(course: Course) -> ClassResults:
    """Return the results of all students in a course.

    Raises
    ------
    grader.course.roster.RosterError, grader.course.deadlines_file.DeadlinesError
    """
    roster, deadlines = read_roster(course), read_deadlines(course) or Deadlines({})
    with open_gradebook(course) as book:
        cells = _group_by_notebook(cell_marks(book))
        rows = [
            _exclude_exercises(row, cells.get((row.student, row.lesson), {}), deadlines.rules)
            for row in read_rows(book)
        ]
        in_gradebook = students_in_gradebook(book)
        excessive = tuple(
            (
                student,
                f"{student}, {lesson}, {exercise_of(cell)}: {format_points(points)} of "
                f"{format_points(maximum)} points",
            )
            for student, lesson, cell, points, maximum in read_excessive_marks(book)
            if exercise_of(cell) not in deadlines.rules.excluded_exercises
        )
    submitted = {
        (submission.student, submission.lesson.name): submission
        for submission in find_submissions(course)
    }
    entered = {(row.student, row.lesson): row for row in rows}
    existing_stages = {pair for pair, row in entered.items() if _has_work(course, row)}
    lessons, unassigned = _lessons_that_count(course, deadlines, {*existing_stages, *submitted})
    max_scores = _max_scores(lessons, rows, deadlines.rules)
    people = roster.people if roster else _without_roster(in_gradebook, {*entered, *submitted})
    notebooks, stages = [], []
    for person in people:
        for stage in dict.fromkeys(lesson.stage for lesson in lessons):
            uncounted = EXCUSED if deadlines.is_excused(person.id, stage) else None
            uncounted = AUDITOR if person.is_auditor else uncounted
            in_stage = [lesson for lesson in lessons if lesson.stage == stage]
            pairs = [(person.id, lesson.name) for lesson in in_stage]
            files = [submitted[pair] for pair in pairs if pair in submitted]
            row = next((entered[pair] for pair in pairs if pair in entered), None)
            times = _stage_times(course, person.id, stage, row, files, deadlines)
            results = []
            for lesson, pair in zip(in_stage, pairs, strict=True):
                row = entered[pair] if pair in existing_stages else None
                result = NotebookResult(
                    person.id,
                    stage,
                    lesson.name,
                    uncounted or _lesson_status(row, pair in submitted),
                    row.score if row else None,
                    max_scores[lesson.name],
                    row.penalty if row else 0.0,
                    due=deadlines.lesson_due_date(
                        person.id, stage, lesson.name, times.due, times.due_in_gradebook
                    ),
                    exercises=_exercises(lesson, cells.get(pair, {}) if row else {}, deadlines),
                )
                if row or pair in submitted:
                    result = _add_times(result, times, deadlines)
                results.append(result)
            notebooks += results
            stages.append(_combine_stage(results, times, deadlines))
    unlisted = {row.student for row in rows} - {person.id for person in people}
    return ClassResults(
        tuple(people),
        tuple(notebooks),
        tuple(stages),
        tuple(sorted(unlisted)),
        excessive,
        tuple(unassigned),
        deadlines.rules,
        tuple(outdated_marks(course, submitted.values(), deadlines)),
    )


def _group_by_notebook(marks: CellMarks) -> dict[tuple[str, str], dict[str, CellMark]]:
    """Group marks by student and lesson, and name them by exercise."""
    marks_by_notebook: dict[tuple[str, str], dict[str, CellMark]] = {}
    for (student, lesson, cell), mark in marks.marks.items():
        marks_by_notebook.setdefault((student, lesson), {})[exercise_of(cell)] = mark
    return marks_by_notebook


def _exclude_exercises(
    row: GradebookRow, marks: Mapping[str, CellMark], rules: TermRules
) -> GradebookRow:
    """Leave out the exercises that are switched off."""
    if marks.keys().isdisjoint(rules.excluded_exercises):
        return row
    counted = [mark for exercise, mark in marks.items() if exercise not in rules.excluded_exercises]
    return replace(
        row,
        score=sum(mark.score for mark in counted),
        max_score=sum(mark.max_score for mark in counted),
        needs_person=any(mark.is_waiting for mark in counted),
        has_mark_by_hand=any(mark.by_hand for mark in counted),
    )


def _exercises(
    lesson: Lesson, marks: Mapping[str, CellMark], deadlines: Deadlines
) -> tuple[ExerciseMark, ...]:
    """Return the marks for the exercises of a lesson that count."""
    exercise_marks = []
    for exercise in lesson.exercises:
        mark = marks.get(exercise.name)
        points = mark.score if mark and not mark.is_waiting else None
        exercise_marks.append(
            ExerciseMark(exercise.name, points, mark.max_score if mark else exercise.points)
        )
    return tuple(
        mark for mark in exercise_marks if mark.name not in deadlines.rules.excluded_exercises
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
        assigned = deadlines.assigned_lessons(stage)
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


def _max_scores(
    lessons: Sequence[Lesson], rows: Sequence[GradebookRow], rules: TermRules
) -> dict[str, float]:
    """Return the maximum score of each lesson, from the gradebook or, if missing, the release."""
    released = {
        lesson.name: sum(
            exercise.points
            for exercise in lesson.exercises
            if exercise.name not in rules.excluded_exercises
        )
        for lesson in lessons
    }
    return released | {row.lesson: row.max_score for row in rows}


def _without_roster(
    in_gradebook: Sequence[Person], submitted: Iterable[tuple[str, str]]
) -> tuple[Person, ...]:
    """Return the students who submitted, with names if the gradebook has them."""
    by_id = {person.id: person for person in in_gradebook}
    return tuple(by_id.get(id, Person(id)) for id in sorted({student for student, _ in submitted}))


def _lesson_status(row: GradebookRow | None, is_submitted: bool) -> str:
    """Return the status of a lesson for a student who is not excused."""
    if row is None:
        return WAITING if is_submitted else MISSING
    return WAITING if row.needs_person else MARKED


@dataclass(frozen=True)
class _StageTimes:
    """When a student submitted a stage and its lessons; see `StageResult`."""

    submitted_at: datetime | None
    due: datetime | None
    due_in_gradebook: datetime | None
    undecided: str
    lacks_zone: bool
    lesson_times: Mapping[str, datetime]


def _stage_times(
    course: Course,
    student: str,
    stage: str,
    row: GradebookRow | None,
    files: Sequence[Submission],
    deadlines: Deadlines,
) -> _StageTimes:
    """Determine when a stage was submitted.

    The gradebook's times take precedence, because nbgrader computes penalties from them.
    """
    due, due_in_gradebook = deadlines.due_date(student, stage), None
    if row and row.due:
        due_in_gradebook = row.due.replace(tzinfo=UTC)
        due = due_in_gradebook + (row.extension or timedelta())
    submitted_at, undecided = row and row.submitted_at and row.submitted_at.replace(tzinfo=UTC), ""
    folders = {submission.stage_folder(course) for submission in files}
    if not submitted_at:
        try:
            submitted_at = submission_time(folders)
        except SubmissionTimeUnknown as error:
            undecided = str(error) if due or deadlines.lessons_with_dates(stage) else ""
    times = lesson_times(files, deadlines) if submitted_at else {}
    return _StageTimes(submitted_at, due, due_in_gradebook, undecided, lacks_zone(folders), times)


def _add_times(result: NotebookResult, times: _StageTimes, deadlines: Deadlines) -> NotebookResult:
    """Add the submission time and the lateness of a lesson."""
    submitted_at = times.lesson_times.get(result.lesson, times.submitted_at)
    late = _lateness(submitted_at, result.due, deadlines)
    is_shared = result.lesson not in times.lesson_times and deadlines.lessons_with_dates(
        result.stage
    )
    return replace(result, submitted_at=submitted_at, late=late, has_shared_time=bool(is_shared))


def _combine_stage(
    lessons: Sequence[NotebookResult], times: _StageTimes, deadlines: Deadlines
) -> StageResult:
    """Combine the results in a stage's lessons."""
    student, stage = lessons[0].student, lessons[0].stage
    scores = [result.score for result in lessons if result.score is not None]
    late = _lateness(times.submitted_at, times.due, deadlines)
    if deadlines.lessons_with_dates(stage):
        late = max(result.late for result in lessons)
    return StageResult(
        student,
        stage,
        combined_status(lessons),
        sum(scores) if scores else None,
        sum(result.max_score for result in lessons),
        sum(result.penalty for result in lessons),
        times.submitted_at,
        times.due,
        late,
        times.undecided,
        times.lacks_zone,
    )


def _lateness(
    submitted_at: datetime | None, due: datetime | None, deadlines: Deadlines
) -> timedelta:
    if not submitted_at or not due:
        return timedelta()
    return compute_lateness(submitted_at, due, deadlines.zone)
