"""The results of a class: what report, table and exporters are given.

Missing, 0, excused and waiting are four things. A student's standing says which of them it is.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime, timedelta

from grader.course.roster import Person

MISSING = "missing"  # nothing was handed in
EXCUSED = "excused"  # nothing is expected
WAITING = "waiting"  # a person has still to grade, or it is handed in and not yet entered
MARKED = "marked"  # there is a mark, and 0 is one


class GradebookUnreachable(Exception):
    """The gradebook cannot be opened; `str()` is the sentence to show."""


@dataclass(frozen=True)
class NotebookResult:
    """How somebody stands in a lesson.

    Attributes
    ----------
    student : str
        Id.
    stage, lesson : str
    standing : str
        `MISSING`, `EXCUSED`, `WAITING` or `MARKED`.
    score : float or None
        What was earned so far, by machine and by hand, before a penalty. None where nothing is
        entered: missing, or waiting to be entered.
    max_score : float
    penalty : float
        Points that nbgrader takes off for lateness.
    """

    student: str
    stage: str
    lesson: str
    standing: str
    score: float | None
    max_score: float
    penalty: float = 0.0

    @property
    def points(self) -> float | None:
        """What is left after the penalty; None as `score`."""
        return _after(self.score, self.penalty)


@dataclass(frozen=True)
class StageResult:
    """How somebody stands in a stage.

    Attributes
    ----------
    student, stage : str
    standing : str
        `EXCUSED`, `MISSING` where no lesson was handed in, `WAITING` where one waits, else
        `MARKED`: a lesson that is missing counts 0 then.
    score : float or None
    max_score, penalty : float
        As of a `NotebookResult`, for all lessons of the stage.
    handed_in, due : datetime or None
        Aware; None where nobody has said so.
    late : timedelta
        Since it was due; zero in time.
    undecided : str
        Where it is due, why nobody knows when it was handed in: whether it is late, a person has to
        say. Empty where it is known, and where there is nothing to say so.
    """

    student: str
    stage: str
    standing: str
    score: float | None
    max_score: float
    penalty: float = 0.0
    handed_in: datetime | None = None
    due: datetime | None = None
    late: timedelta = timedelta()
    undecided: str = ""

    @property
    def points(self) -> float | None:
        """What is left after the penalty; None as `score`."""
        return _after(self.score, self.penalty)


@dataclass(frozen=True)
class ClassResults:
    """How a class stands, in everything that anybody has handed in.

    Attributes
    ----------
    people : tuple of grader.course.roster.Person
        All on the roster, in its order; without a roster, all who handed in.
    notebooks : tuple of NotebookResult
        One for each of them and each lesson, in this order.
    stages : tuple of StageResult
        One for each of them and each stage.
    strangers : tuple of str
        Who has marks in the gradebook, and is not on the roster: they have no results here.
    """

    people: tuple[Person, ...]
    notebooks: tuple[NotebookResult, ...]
    stages: tuple[StageResult, ...]
    strangers: tuple[str, ...] = ()

    def notebook(self, student: str, lesson: str) -> NotebookResult | None:
        """How a student stands in a lesson; None where nobody has handed it in."""
        return self._notebooks.get((student, lesson))

    def stage(self, student: str, stage: str) -> StageResult | None:
        """How a student stands in a stage; None where nobody has handed anything in."""
        return self._stages.get((student, stage))

    @functools.cached_property
    def lessons(self) -> dict[str, float]:
        """What each lesson that was handed in is worth, in their order."""
        return {result.lesson: result.max_score for result in sorted(self.notebooks, key=_lesson)}

    @functools.cached_property
    def _notebooks(self) -> dict[tuple[str, str], NotebookResult]:
        return {(result.student, result.lesson): result for result in self.notebooks}

    @functools.cached_property
    def _stages(self) -> dict[tuple[str, str], StageResult]:
        return {(result.student, result.stage): result for result in self.stages}


def standing_in_stage(lessons: Iterable[NotebookResult]) -> str:
    """What the standing in each lesson of a stage comes to."""
    found = {result.standing for result in lessons}
    return next((one for one in (EXCUSED, WAITING, MARKED) if one in found), MISSING)


def write_number(points: float, decimal_mark: str = ".") -> str:
    """Points with two digits at most, as everything has them."""
    return f"{points:.2f}".rstrip("0").rstrip(".").replace(".", decimal_mark)


def _lesson(result: NotebookResult) -> str:
    return result.lesson


def _after(score: float | None, penalty: float) -> float | None:
    return None if score is None else max(0.0, score - penalty)
