"""The results of a class, as used by the report, the marks table and the exporters.

The attribute `status` distinguishes a missing lesson, a mark, an excused student, an auditor and a
waiting submission.
"""

from __future__ import annotations

import functools
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta

from grader.course.deadlines import TermRules
from grader.course.roster import Person
from grader.errors import UserError
from grader.judging.verdict import Verdict

MISSING = "missing"  # the lesson was not submitted
EXCUSED = "excused"  # the student is excused from the lesson
AUDITOR = "auditor"  # the student takes the course without earning marks
WAITING = "waiting"  # a person still has to grade a part, or the submission is not entered yet
MARKED = "marked"  # there is a mark, which may be 0


class GradebookUnavailable(UserError):
    """The gradebook cannot be opened; the message is shown to the user."""


@dataclass(frozen=True)
class ExerciseMark:
    """A student's points for an exercise that counts, before the penalty for lateness.

    Attributes
    ----------
    name : str
    points : float or None
        None if the lesson is missing, or if a person still has to grade the exercise.
    max_score : float
    """

    name: str
    points: float | None
    max_score: float


@dataclass(frozen=True)
class NotebookResult:
    """A student's result in one lesson.

    Attributes
    ----------
    student : str
        ID of the student.
    stage, lesson : str
    status : str
        `MISSING`, `EXCUSED`, `AUDITOR`, `WAITING` or `MARKED`.
    score : float or None
        Points earned so far, by machine and by hand, before the penalty. None if the lesson is
        missing or not entered yet.
    max_score : float
    penalty : float
        Points that nbgrader subtracts for lateness.
    submitted_at, due : datetime or None
        Times with time zones; None if unknown.
    late : timedelta
        As in `StageResult`.
    exercises : tuple of ExerciseMark
    has_shared_time : bool
        Whether lessons of the stage have their own due dates, but only the time of the whole stage
        is known.
    """

    student: str
    stage: str
    lesson: str
    status: str
    score: float | None
    max_score: float
    penalty: float = 0.0
    submitted_at: datetime | None = None
    due: datetime | None = None
    late: timedelta = timedelta()
    exercises: tuple[ExerciseMark, ...] = ()
    has_shared_time: bool = False

    @property
    def counts(self) -> bool:
        """Whether the result counts in sums and means."""
        return self.status not in (EXCUSED, AUDITOR)

    @property
    def points(self) -> float | None:
        """Points after the penalty; None if `score` is None."""
        return _after_penalty(self.score, self.penalty)


@dataclass(frozen=True)
class StageResult:
    """A student's result in one stage.

    Attributes
    ----------
    student, stage : str
    status : str
        `AUDITOR`, `EXCUSED`, `MISSING` if no lesson was submitted, `WAITING` if a lesson waits,
        otherwise `MARKED`. In a marked stage, a missing lesson counts as 0.
    score : float or None
    max_score, penalty : float
        Sums over all lessons of the stage; see `NotebookResult`.
    submitted_at, due : datetime or None
        Submission time and due date, with time zones; None if unknown.
    late : timedelta
        Time between due date and submission, in which each day on the clock has 24 hours; zero if
        the submission was on time. If lessons of the stage have their own dates, the longest of
        their times.
    undecided : str
        Why the submission time is unknown, if the stage has a due date; otherwise empty. A person
        then has to decide whether the submission is late.
    lacks_zone : bool
        Whether the submission time was written without a time zone, so that it was read as UTC.
    """

    student: str
    stage: str
    status: str
    score: float | None
    max_score: float
    penalty: float = 0.0
    submitted_at: datetime | None = None
    due: datetime | None = None
    late: timedelta = timedelta()
    undecided: str = ""
    lacks_zone: bool = False

    @property
    def points(self) -> float | None:
        """Points after the penalty; None if `score` is None."""
        return _after_penalty(self.score, self.penalty)


@dataclass(frozen=True)
class ClassResults:
    """The results of a class in all lessons that count in its stages.

    Stages to which no student has submitted anything have no results.

    Attributes
    ----------
    people : tuple of grader.course.roster.Person
        All students on the roster, in the roster's order; without a roster, all who submitted.
    notebooks : tuple of NotebookResult
        One result for each student and lesson, ordered by student, then by lesson.
    stages : tuple of StageResult
        One result for each student and stage.
    unlisted : tuple of str
        IDs with marks in the gradebook that are not on the roster. They have no results here.
    excessive : tuple of (str, str)
        Student and description of manual marks above the maximum of their exercise.
    unassigned : tuple of (str, str)
        Student and lesson of submissions that have no results here, because deadlines.toml does not
        list the lesson.
    rules : grader.course.deadlines.TermRules
    outdated : tuple of (str, str)
        Student and stage of marks whose inputs have changed; see `grader.lms.mark_inputs`.
    """

    people: tuple[Person, ...]
    notebooks: tuple[NotebookResult, ...]
    stages: tuple[StageResult, ...]
    unlisted: tuple[str, ...] = ()
    excessive: tuple[tuple[str, str], ...] = ()
    unassigned: tuple[tuple[str, str], ...] = ()
    rules: TermRules = TermRules()
    outdated: tuple[tuple[str, str], ...] = ()

    def notebook(self, student: str, lesson: str) -> NotebookResult | None:
        """Return a student's result in a lesson, or None if the lesson does not count."""
        return self._notebooks.get((student, lesson))

    def stage(self, student: str, stage: str) -> StageResult | None:
        """Return a student's result in a stage, or None if no student submitted to the stage."""
        return self._stages.get((student, stage))

    def of_student(self, student: str) -> Sequence[NotebookResult]:
        """Return a student's results in all lessons that count."""
        return self._by_student.get(student, ())

    def of_people(self, people: Collection[Person]) -> ClassResults:
        """Return the results of some students, without anything about others."""
        ids = {person.id for person in people}
        return replace(
            self,
            people=tuple(person for person in self.people if person.id in ids),
            notebooks=tuple(result for result in self.notebooks if result.student in ids),
            stages=tuple(result for result in self.stages if result.student in ids),
            unlisted=(),
            excessive=tuple(pair for pair in self.excessive if pair[0] in ids),
            unassigned=tuple(pair for pair in self.unassigned if pair[0] in ids),
            outdated=tuple(pair for pair in self.outdated if pair[0] in ids),
        )

    def judged_points(self, verdict: Verdict) -> float:
        """Return the judge's points in the exercises that count."""
        return verdict.points_without(self.rules.excluded_exercises)[0]

    @functools.cached_property
    def lessons(self) -> dict[str, float]:
        """Maximum score of each lesson that counts, in lesson order."""
        return {result.lesson: result.max_score for result in sorted(self.notebooks, key=_lesson)}

    @functools.cached_property
    def _by_student(self) -> dict[str, list[NotebookResult]]:
        results_by_student: dict[str, list[NotebookResult]] = {}
        for result in self.notebooks:
            results_by_student.setdefault(result.student, []).append(result)
        return results_by_student

    @functools.cached_property
    def _notebooks(self) -> dict[tuple[str, str], NotebookResult]:
        return {(result.student, result.lesson): result for result in self.notebooks}

    @functools.cached_property
    def _stages(self) -> dict[tuple[str, str], StageResult]:
        return {(result.student, result.stage): result for result in self.stages}


def combined_status(lessons: Iterable[NotebookResult]) -> str:
    """Combine the statuses in the lessons of a stage into one."""
    present = {result.status for result in lessons}
    return next(
        (status for status in (AUDITOR, EXCUSED, WAITING, MARKED) if status in present),
        MISSING,
    )


def format_points(points: float, decimal_mark: str = ".") -> str:
    """Format points with at most two decimal places."""
    return f"{points:.2f}".rstrip("0").rstrip(".").replace(".", decimal_mark)


def rounded_points(points: float) -> str:
    """Format points with one decimal place, or with two if rounding would give a whole number.

    For example, 29.97 points are not shown as 30. Halves are rounded up.
    """
    short = f"{points + 1e-6:.1f}"
    if float(short).is_integer() and abs(points - float(short)) >= 0.005:
        return format_points(points)
    return short.removesuffix(".0")


def _lesson(result: NotebookResult) -> str:
    return result.lesson


def _after_penalty(score: float | None, penalty: float) -> float | None:
    return None if score is None else max(0.0, score - penalty)
