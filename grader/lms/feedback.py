"""Collect the feedback for a student on one stage: lessons, exercises, marks and comments."""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta, tzinfo

import nbformat

from grader.course.deadlines_file import read_deadlines
from grader.course.lessons import Exercise, Lesson, find_lesson
from grader.course.paths import Course
from grader.course.roster import Person
from grader.judging.verdict import FAILED, ExerciseResult, Verdict, read_verdict
from grader.lms.autograded_copy import graded_cells
from grader.lms.cell_marks import CellMark, CellMarks, cell_marks
from grader.lms.check_summary import ExerciseSummary, summarise_checks
from grader.lms.gradebook import open_gradebook
from grader.lms.results import (
    AUDITOR,
    EXCUSED,
    WAITING,
    ClassResults,
    NotebookResult,
    StageResult,
    format_points,
)
from grader.lms.results_reader import class_results
from grader.lms.sanitizer import sanitize_markdown


@dataclass(frozen=True)
class SanitizedText:
    """Markdown that a person wrote, with all HTML disabled, and its pictures."""

    markdown: str
    attachments: dict = field(default_factory=dict)


@dataclass(frozen=True)
class ExerciseFeedback:
    """Feedback on one exercise.

    Attributes
    ----------
    exercise : grader.course.lessons.Exercise
    mark : grader.lms.cell_marks.CellMark
    judged : grader.judging.verdict.ExerciseResult or None
        None if a person grades the exercise.
    summary : grader.lms.check_summary.ExerciseSummary or None
        Summary of the checks; None if a person grades the exercise.
    answer : SanitizedText or None
        The student's written answer; None if it is blank or the exercise does not require one.
    comment : SanitizedText or None
        The grader's comment on the answer.
    counts : bool
        False if the exercise is switched off.
    """

    exercise: Exercise
    mark: CellMark
    judged: ExerciseResult | None
    summary: ExerciseSummary | None
    answer: SanitizedText | None
    comment: SanitizedText | None
    counts: bool = True


@dataclass(frozen=True)
class LessonFeedback:
    """Feedback on one lesson.

    Attributes
    ----------
    lesson : grader.course.lessons.Lesson
    title : str
    result : grader.lms.results.NotebookResult
    problems : tuple of str
        Messages about the notebook as a whole.
    exercises : tuple of ExerciseFeedback
        Empty if the lesson was not submitted.
    """

    lesson: Lesson
    title: str
    result: NotebookResult
    problems: tuple[str, ...] = ()
    exercises: tuple[ExerciseFeedback, ...] = ()

    @property
    def is_untouched(self) -> bool:
        """Whether the lesson was submitted, but no exercise was started or marked."""
        return bool(self.exercises) and all(map(_is_untouched, self.exercises))


@dataclass(frozen=True)
class Feedback:
    """Feedback for one student on one stage.

    Attributes
    ----------
    person : grader.course.roster.Person
    result : grader.lms.results.StageResult
    lessons : tuple of LessonFeedback
    zone : tzinfo or None
        Time zone for all times in the feedback; None for the zone of this machine.
    """

    person: Person
    result: StageResult
    lessons: tuple[LessonFeedback, ...]
    zone: tzinfo | None = None

    @property
    def is_untouched(self) -> bool:
        """Whether no lesson of the stage was started."""
        submitted = [lesson for lesson in self.lessons if lesson.exercises]
        return bool(submitted) and all(lesson.is_untouched for lesson in submitted)

    @property
    def sentences(self) -> tuple[str, ...]:
        """Sentences about the stage as a whole."""
        if self.result.status == EXCUSED:
            return ("You are excused from this stage, so none of these points count.",)
        if self.result.status == AUDITOR:
            return ("You are auditing the course, so none of these points count.",)
        waiting = self.result.status == WAITING
        untouched = (
            "You did not start any exercise in this stage. If you can still submit, replace "
            "`raise NotImplementedError` with your code and submit the notebooks again."
        )
        # If there is a problem with a file, the student's work may be missing from it.
        is_whole = not any(lesson.problems for lesson in self.lessons)
        not_final = "Some answers still have to be graded by hand, so the points are not final."
        return (
            *([untouched] if self.is_untouched and is_whole else ()),
            *([not_final] if waiting else ()),
            *lateness_sentences(self.result, self.zone, [lesson.result for lesson in self.lessons]),
        )


def _is_untouched(exercise: ExerciseFeedback) -> bool:
    if exercise.comment or exercise.mark.score:
        return False
    if exercise.summary is None:
        return exercise.answer is None
    return not exercise.summary.is_started


class FeedbackNotReady(Exception):
    """Feedback for a student is not ready yet; the message is shown to the user."""


class FeedbackCollector:
    """Collects the feedback for the students of one stage."""

    def __init__(self, course: Course, stage: str) -> None:
        self._course, self._stage = course, stage
        self._results: ClassResults = class_results(course)
        deadlines = read_deadlines(course)
        self._zone = deadlines.zone if deadlines else None
        with open_gradebook(course) as book:
            self._cells: CellMarks = cell_marks(book, stage)

    def people(self, requested_ids: Collection[str] = ()) -> list[Person]:
        """Return the students with a submission; only the requested ones if any are given."""
        return [
            person
            for person in self._results.people
            if (not requested_ids or person.id in requested_ids) and self._has_submitted(person.id)
        ]

    def unlisted_ids(self) -> tuple[str, ...]:
        """Return the IDs that have marks in this stage but are not on the roster."""
        with_marks = {student for student, _, _ in self._cells.marks}
        return tuple(id for id in self._results.unlisted if id in with_marks)

    def feedback(self, person: Person) -> Feedback:
        """Collect all feedback for one student.

        Raises
        ------
        FeedbackNotReady
            If the latest submission has not been judged and entered yet.
        """
        lessons = [self._lesson(result) for result in self._notebooks(person.id)]
        result = self._results.stage(person.id, self._stage)
        return Feedback(person, result, tuple(lessons), self._zone)

    def _has_submitted(self, student: str) -> bool:
        results = self._notebooks(student)
        return any(result.score is not None or result.status == WAITING for result in results)

    def _notebooks(self, student: str) -> list[NotebookResult]:
        results = (self._results.notebook(student, lesson) for lesson in self._results.lessons)
        return [result for result in results if result and result.stage == self._stage]

    def _lesson(self, result: NotebookResult) -> LessonFeedback:
        lesson = find_lesson(result.lesson)
        if result.score is None and result.status != WAITING:
            return LessonFeedback(lesson, title_of(lesson), result)
        place = (result.student, lesson.stage)
        verdict = read_verdict(self._course.verdicts.joinpath(*place, f"{lesson.name}.json"))
        autograded_copy = self._copy(*place, lesson)
        if verdict and verdict.status == FAILED:
            raise FeedbackNotReady(f"{result.student}, {lesson.name}: {verdict.reason}")
        # A student with a mark given by hand but without a file has neither a key nor a verdict.
        if result.score is None or autograded_copy.metadata.get("verdict_key") != (
            verdict and verdict.key
        ):
            raise FeedbackNotReady(
                f"{result.student}, {lesson.name}: the latest verdict is not in the gradebook. "
                "Run: python -m grader grade"
            )
        answers = {cell.metadata.nbgrader.grade_id: cell for cell in graded_cells(autograded_copy)}
        exercises = tuple(
            self._exercise(result, exercise, verdict, answers) for exercise in lesson.exercises
        )
        problems = verdict.problems if verdict else ()
        return LessonFeedback(lesson, title_of(lesson), result, problems, exercises)

    def _copy(self, student: str, stage: str, lesson: Lesson) -> nbformat.NotebookNode:
        """Return the autograded copy, or an empty notebook if there is none."""
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
        key = (result.student, result.lesson)
        exercises = verdict.exercises if verdict else ()
        judged = next(
            (candidate for candidate in exercises if candidate.name == exercise.name), None
        )
        written = answers.get(exercise.cell) if exercise.by_hand else None
        comment = self._cells.comments.get((*key, exercise.name), "")
        return ExerciseFeedback(
            exercise,
            self._cells.marks[*key, exercise.cell],
            judged,
            summarise_checks(judged) if judged else None,
            _written_answer(written, exercise.cell, find_lesson(result.lesson))
            if written
            else None,
            SanitizedText(sanitize_markdown(comment)) if comment else None,
            exercise.name not in self._results.rules.excluded_exercises,
        )


def _written_answer(cell: nbformat.NotebookNode, name: str, lesson: Lesson) -> SanitizedText | None:
    """Return a written answer, or None if it is blank; the copy is already sanitized."""
    if cell.source.strip() in ("", _placeholders(lesson).get(name)):
        return None
    return SanitizedText(cell.source, dict(cell.get("attachments", {})))


@functools.cache
def _placeholders(lesson: Lesson) -> dict[str, str]:
    """Return the released text in the cell of each written answer, by ``grade_id``."""
    released = nbformat.v4.reads(lesson.released.read_text("utf-8"))
    return {cell.metadata.nbgrader.grade_id: cell.source.strip() for cell in graded_cells(released)}


@functools.cache
def title_of(lesson: Lesson) -> str:
    """Return the first heading of a lesson's notebook."""
    for cell in json.loads(lesson.released.read_text("utf-8"))["cells"]:
        heading = re.match(r"# (.+)", "".join(cell["source"]))
        if cell["cell_type"] == "markdown" and heading:
            return heading[1]
    return lesson.name


def lateness_sentences(
    result: StageResult, zone: tzinfo | None = None, lessons: Sequence[NotebookResult] = ()
) -> Iterator[str]:
    """Yield sentences about the submission time of a stage and about the late penalty.

    If lessons have their own due dates, each lesson gets a sentence.
    """
    if result.undecided:
        yield (
            "The time of your submission is unknown, so your instructor has to decide whether it "
            "is late."
        )
    elif any(lesson.due and lesson.due != result.due for lesson in lessons):
        for lesson in lessons:
            if lesson.submitted_at and lesson.due:
                yield f"{lesson.lesson}: {_lateness_sentence(lesson, zone)}"
    elif result.submitted_at and result.due:
        yield _lateness_sentence(result, zone)
    if result.penalty:
        yield f"Points subtracted for lateness: {format_points(result.penalty)}."


def _lateness_sentence(result: StageResult | NotebookResult, zone: tzinfo | None) -> str:
    submitted_at, due = (_format_time(when, zone) for when in (result.submitted_at, result.due))
    punctuality = f"{_format_span(result.late)} late" if result.late else "on time"
    return f"Submitted {punctuality}, on {submitted_at}. It was due on {due}."


def _format_time(when: datetime, zone: tzinfo | None) -> str:
    return f"{when.astimezone(zone):%d %B %Y at %H:%M %Z}"


def _format_span(time: timedelta) -> str:
    """Format a time span in its two largest units, such as "2 days and 3 hours"."""
    minutes = -(-int(time.total_seconds()) // 60)
    days, rest = divmod(minutes, 24 * 60)
    hours, minutes = divmod(rest, 60)
    parts = [
        f"{count} {unit}{'s' * (count > 1)}"
        for count, unit in ((days, "day"), (hours, "hour"), (minutes, "minute"))
        if count
    ]
    return " and ".join(parts[:2]) or "less than a minute"
