"""What a student gets back for a stage: every lesson, exercise, mark and comment."""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from datetime import datetime, timedelta, tzinfo

import nbformat

from grader.course.deadlines import read_deadlines
from grader.course.lessons import Exercise, Lesson, find_lesson
from grader.course.paths import Course
from grader.course.roster import Person
from grader.judging.verdict import ExerciseResult, Verdict, read_verdict
from grader.lms.autograded import graded_cells
from grader.lms.cells import CellMark, CellMarks, cell_marks
from grader.lms.check_summary import Folded, fold
from grader.lms.gradebook import open_gradebook
from grader.lms.results import (
    EXCUSED,
    WAITING,
    ClassResults,
    NotebookResult,
    StageResult,
    write_number,
)
from grader.lms.sanitizer import harmless
from grader.lms.standings import class_results


@dataclass(frozen=True)
class Text:
    """Markdown of a person, in which nothing is HTML any more, and its pictures."""

    markdown: str
    attachments: dict = field(default_factory=dict)


@dataclass(frozen=True)
class ExerciseFeedback:
    """What is said of an exercise.

    Attributes
    ----------
    exercise : grader.course.lessons.Exercise
    mark : grader.lms.cells.CellMark
    judged : grader.judging.verdict.ExerciseResult or None
        None where a person grades.
    folded : grader.lms.check_summary.Folded or None
    answer : Text or None
        What was written; None where nothing was, or where nothing is to be written.
    comment : Text or None
        What a person wrote about it.
    """

    exercise: Exercise
    mark: CellMark
    judged: ExerciseResult | None
    folded: Folded | None
    answer: Text | None
    comment: Text | None


@dataclass(frozen=True)
class LessonFeedback:
    """What is said of a lesson.

    Attributes
    ----------
    lesson : grader.course.lessons.Lesson
    title : str
    result : grader.lms.results.NotebookResult
    problems : tuple of str
        About the notebook as a whole.
    exercises : tuple of ExerciseFeedback
        None where nothing was handed in.
    """

    lesson: Lesson
    title: str
    result: NotebookResult
    problems: tuple[str, ...] = ()
    exercises: tuple[ExerciseFeedback, ...] = ()


@dataclass(frozen=True)
class Feedback:
    """What a student gets back for a stage.

    Attributes
    ----------
    person : grader.course.roster.Person
    result : grader.lms.results.StageResult
    lessons : tuple of LessonFeedback
    zone : tzinfo or None
        In which times are told; None for that of this machine.
    """

    person: Person
    result: StageResult
    lessons: tuple[LessonFeedback, ...]
    zone: tzinfo | None = None

    @property
    def sentences(self) -> tuple[str, ...]:
        """What is to be known about the whole."""
        if self.result.standing == EXCUSED:
            return ("You are excused from this stage: none of this counts, for you or against.",)
        waiting = self.result.standing == WAITING
        about = "A person has still to grade a part of this: the points are not final."
        return (*([about] if waiting else ()), *lateness(self.result, self.zone))


class NotReady(Exception):
    """There is no feedback for somebody yet; `str()` is the sentence to show."""


class FeedbackWriter:
    """Reads what there is to say about the students of a stage."""

    def __init__(self, course: Course, stage: str) -> None:
        self._course, self._stage = course, stage
        self._results: ClassResults = class_results(course)
        deadlines = read_deadlines(course)
        self._zone = deadlines.zone if deadlines else None
        with open_gradebook(course) as book:
            self._cells: CellMarks = cell_marks(book, stage)

    def people(self, wanted: Collection[str] = ()) -> list[Person]:
        """Those who have handed something in; of these only some, where ids are given."""
        return [
            person
            for person in self._results.people
            if (not wanted or person.id in wanted) and self._has_handed_in(person.id)
        ]

    def strangers(self) -> tuple[str, ...]:
        """Who has marks in this stage, and is not on the roster."""
        with_marks = {student for student, _, _ in self._cells.marks}
        return tuple(id for id in self._results.strangers if id in with_marks)

    def feedback(self, person: Person) -> Feedback:
        """All that there is to say to one of them.

        Raises
        ------
        NotReady
        """
        lessons = [self._lesson(result) for result in self._notebooks(person.id)]
        result = self._results.stage(person.id, self._stage)
        return Feedback(person, result, tuple(lessons), self._zone)

    def _has_handed_in(self, student: str) -> bool:
        results = self._notebooks(student)
        return any(result.score is not None or result.standing == WAITING for result in results)

    def _notebooks(self, student: str) -> list[NotebookResult]:
        found = (self._results.notebook(student, lesson) for lesson in self._results.lessons)
        return [result for result in found if result and result.stage == self._stage]

    def _lesson(self, result: NotebookResult) -> LessonFeedback:
        lesson = find_lesson(result.lesson)
        if result.score is None and result.standing != WAITING:
            return LessonFeedback(lesson, title_of(lesson), result)
        place = (result.student, lesson.stage)
        verdict = read_verdict(self._course.verdicts.joinpath(*place, f"{lesson.name}.json"))
        copy = self._copy(*place, lesson)
        # Who has a mark by hand, and no file any more, has neither.
        if result.score is None or copy.metadata.get("verdict_key") != (verdict and verdict.key):
            raise NotReady(
                f"{result.student}, {lesson.name}: what was handed in and judged last is not in "
                "the gradebook. Run: python -m grader grade"
            )
        answers = {cell.metadata.nbgrader.grade_id: cell for cell in graded_cells(copy)}
        exercises = tuple(
            self._exercise(result, exercise, verdict, answers) for exercise in lesson.exercises
        )
        problems = verdict.problems if verdict else ()
        return LessonFeedback(lesson, title_of(lesson), result, problems, exercises)

    def _copy(self, student: str, stage: str, lesson: Lesson) -> nbformat.NotebookNode:
        """The autograded copy, which is ours and valid; an empty one where there is none."""
        path = self._course.autograded / student / stage / f"{lesson.name}.ipynb"
        try:
            return nbformat.v4.reads(path.read_text("utf-8"))
        except (OSError, ValueError):
            return nbformat.v4.new_notebook()

    def _exercise(
        self,
        result: NotebookResult,
        exercise: Exercise,
        verdict: Verdict | None,
        answers: dict[str, nbformat.NotebookNode],
    ) -> ExerciseFeedback:
        where = (result.student, result.lesson)
        exercises = verdict.exercises if verdict else ()
        judged = next((one for one in exercises if one.name == exercise.name), None)
        written = answers.get(exercise.cell) if exercise.by_hand else None
        comment = self._cells.comments.get((*where, exercise.name), "")
        return ExerciseFeedback(
            exercise,
            self._cells.marks[*where, exercise.cell],
            judged,
            fold(judged) if judged else None,
            _written(written, exercise.cell, find_lesson(result.lesson)) if written else None,
            Text(harmless(comment)) if comment else None,
        )


def _written(cell: nbformat.NotebookNode, name: str, lesson: Lesson) -> Text | None:
    """A written answer, as it was made harmless for the copy; None where nothing was written."""
    if cell.source.strip() in ("", _placeholders(lesson).get(name)):
        return None
    return Text(cell.source, dict(cell.get("attachments", {})))


@functools.cache
def _placeholders(lesson: Lesson) -> dict[str, str]:
    """What stands in the cells of the release for written answers."""
    released = nbformat.v4.reads(lesson.released.read_text("utf-8"))
    return {cell.metadata.nbgrader.grade_id: cell.source.strip() for cell in graded_cells(released)}


@functools.cache
def title_of(lesson: Lesson) -> str:
    """The heading of a lesson's notebook."""
    for cell in json.loads(lesson.released.read_text("utf-8"))["cells"]:
        found = re.match(r"# (.+)", "".join(cell["source"]))
        if cell["cell_type"] == "markdown" and found:
            return found[1]
    return lesson.name


def lateness(result: StageResult, zone: tzinfo | None = None) -> Iterator[str]:
    """Sentences on when a stage was handed in, by the clocks of a zone, and what that costs."""
    if result.undecided:
        yield (
            "Whether this is late, a person has still to decide: nobody knows yet when it was "
            "handed in."
        )
    elif result.handed_in and result.due:
        handed_in, due = (_moment(when, zone) for when in (result.handed_in, result.due))
        how = f"{_span(result.late)} late" if result.late else "in time"
        yield f"Handed in {how}, on {handed_in}; it was due on {due}."
    if result.penalty:
        yield f"For lateness {write_number(result.penalty)} points are taken off."


def _moment(when: datetime, zone: tzinfo | None) -> str:
    return f"{when.astimezone(zone):%d %B %Y at %H:%M %Z}"


def _span(time: timedelta) -> str:
    """Such as "2 days and 3 hours": the two largest units."""
    minutes = -(-int(time.total_seconds()) // 60)
    days, rest = divmod(minutes, 24 * 60)
    hours, minutes = divmod(rest, 60)
    parts = [
        f"{count} {unit}{'s' * (count > 1)}"
        for count, unit in ((days, "day"), (hours, "hour"), (minutes, "minute"))
        if count
    ]
    return " and ".join(parts[:2]) or "less than a minute"
