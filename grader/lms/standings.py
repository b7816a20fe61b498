"""How each person stands: the gradebook's rows beside roster, dates and what was handed in."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import UTC, timedelta

from grader.classroom.submissions import Submission, find_submissions
from grader.course.deadlines import Deadlines, read_deadlines
from grader.course.lessons import Lesson, find_lesson
from grader.course.paths import Course
from grader.course.roster import Person, read_roster
from grader.lms.gradebook import open_gradebook
from grader.lms.gradebook_rows import GradebookRow, read_rows
from grader.lms.people import people_in
from grader.lms.results import (
    EXCUSED,
    MARKED,
    MISSING,
    WAITING,
    ClassResults,
    NotebookResult,
    StageResult,
    standing_in_stage,
)
from grader.lms.submission_times import Undecided, handed_in_at


def class_results(course: Course) -> ClassResults:
    """How everybody stands, by the gradebook, the roster and the dates of a course.

    Raises
    ------
    grader.course.roster.RosterTrouble, grader.course.deadlines.DeadlinesTrouble
    """
    with open_gradebook(course) as book:
        rows, known = read_rows(book), people_in(book)
    roster, deadlines = read_roster(course), read_deadlines(course) or Deadlines({})
    given = {
        (submission.student, submission.lesson.name): submission
        for submission in find_submissions(course)
    }
    entered = {(row.student, row.lesson): row for row in rows}
    used = {pair for pair, row in entered.items() if _is_handed_in(course, row)}
    lessons = [find_lesson(name) for name in sorted({name for _, name in {*used, *given}})]
    worth = _worth(lessons, rows)
    people = roster.people if roster else _without_roster(known, {*entered, *given})
    notebooks, stages = [], []
    for person in people:
        for stage in dict.fromkeys(lesson.stage for lesson in lessons):
            excused = deadlines.excused(person.id, stage)
            mine = []
            for lesson in (one for one in lessons if one.stage == stage):
                pair = (person.id, lesson.name)
                row = entered[pair] if pair in used else None
                standing = EXCUSED if excused else _standing(row, pair in given)
                mine.append(_notebook(person, lesson, standing, row, worth[lesson.name]))
            files = [given[pair] for one in mine if (pair := (one.student, one.lesson)) in given]
            row = next(
                (entered[pair] for one in mine if (pair := (one.student, one.lesson)) in entered),
                None,
            )
            notebooks += mine
            stages.append(_stage(course, mine, row, files, deadlines))
    strangers = {row.student for row in rows} - {person.id for person in people}
    return ClassResults(tuple(people), tuple(notebooks), tuple(stages), tuple(sorted(strangers)))


def _is_handed_in(course: Course, row: GradebookRow) -> bool:
    """Whether there is work behind a row: nbgrader has one with 0 points, too, where there is none.

    Who has points, or a mark by hand, has them whatever became of the files.
    """
    copy = course.autograded / row.student / row.stage / f"{row.lesson}.ipynb"
    return row.score > 0 or row.has_mark_by_hand or copy.is_file()


def _worth(lessons: Sequence[Lesson], rows: Sequence[GradebookRow]) -> dict[str, float]:
    """What each lesson is worth: in the gradebook, or for who has no mark yet in the release."""
    released = {
        lesson.name: sum(exercise.points for exercise in lesson.exercises) for lesson in lessons
    }
    return released | {row.lesson: row.max_score for row in rows}


def _without_roster(
    known: Sequence[Person], handed_in: Iterable[tuple[str, str]]
) -> tuple[Person, ...]:
    """Those who have handed in something, as far as the gradebook knows their names."""
    named = {person.id: person for person in known}
    return tuple(named.get(id, Person(id)) for id in sorted({student for student, _ in handed_in}))


def _standing(row: GradebookRow | None, is_given: bool) -> str:
    """How somebody who is not excused stands in a lesson."""
    if row is None:
        return WAITING if is_given else MISSING
    return WAITING if row.needs_person else MARKED


def _notebook(
    person: Person, lesson: Lesson, standing: str, row: GradebookRow | None, worth: float
) -> NotebookResult:
    return NotebookResult(
        person.id,
        lesson.stage,
        lesson.name,
        standing,
        row.score if row else None,
        worth,
        row.penalty if row else 0.0,
    )


def _stage(
    course: Course,
    lessons: Sequence[NotebookResult],
    row: GradebookRow | None,
    files: Sequence[Submission],
    deadlines: Deadlines,
) -> StageResult:
    """What the lessons of a stage come to, and when they were handed in.

    Of what is entered the gradebook says it, by which nbgrader takes points off.
    """
    student, stage = lessons[0].student, lessons[0].stage
    scores = [result.score for result in lessons if result.score is not None]
    due = deadlines.due(student, stage)
    if row and row.due:
        due = (row.due + (row.extension or timedelta())).replace(tzinfo=UTC)
    handed_in, undecided = row and row.handed_in and row.handed_in.replace(tzinfo=UTC), ""
    if not handed_in:
        try:
            handed_in = handed_in_at({file.place(course) for file in files})
        except Undecided as error:
            undecided = str(error) if due else ""
    return StageResult(
        student,
        stage,
        standing_in_stage(lessons),
        sum(scores) if scores else None,
        sum(result.max_score for result in lessons),
        sum(result.penalty for result in lessons),
        handed_in,
        due,
        max(timedelta(), handed_in - due) if handed_in and due else timedelta(),
        undecided,
    )
