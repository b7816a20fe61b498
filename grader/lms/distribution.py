"""The distribution of a class's scores in one lesson."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from grader.course.lessons import Lesson
from grader.judging.verdict import Verdict
from grader.lms.results import AUDITOR, EXCUSED, MARKED, MISSING, WAITING, ClassResults

BINS = 10


@dataclass(frozen=True)
class Distribution:
    """The distribution of the scores in one lesson, before penalties for lateness.

    Attributes
    ----------
    name, stage : str
    count : int
        Number of students with a score; mean and median are computed from these.
    waiting : int
        Number of these students with a part that a person still has to grade.
    not_entered, missing, excused, auditors : int
        Numbers of students who are not counted, by reason.
    mean, median, max_score : float
    histogram : tuple of int
        Number of students in each of `BINS` equal ranges from 0 to the maximum score.
    seconds : float or None
        Median time to judge one submission.
    """

    name: str
    stage: str
    count: int
    waiting: int
    not_entered: int
    missing: int
    excused: int
    auditors: int
    mean: float
    median: float
    max_score: float
    histogram: tuple[int, ...]
    seconds: float | None

    @property
    def population(self) -> str:
        """Phrase that describes which students the mean and the median include and exclude."""
        phrase = (
            f"for {self.count} students with a score"
            if self.count > 1
            else "for the only student with a score"
        )
        if self.waiting:
            some = "who" if self.count == 1 else f"{self.waiting} of whom"
            verb = "is" if self.waiting == 1 else "are"
            phrase += f", {some} {verb} still waiting for a grader"
        excluded = {
            "not yet entered": self.not_entered,
            "missing": self.missing,
            "excused": self.excused,
            "auditing": self.auditors,
        }
        parts = [f"{number} {reason}" for reason, number in excluded.items() if number]
        return f"{phrase}; not counted: {', '.join(parts)}" if parts else phrase


def distribution_of(
    lesson: Lesson, results: ClassResults, verdicts: Sequence[Verdict]
) -> Distribution:
    """Return a lesson's distribution from the gradebook or, without one, from the verdicts."""
    judged = [verdict for verdict in verdicts if verdict.lesson == lesson.name]
    own = [result for result in results.notebooks if result.lesson == lesson.name]
    scores = [result.score for result in own if result.counts and result.score is not None]
    max_score = results.lessons.get(lesson.name)
    if not own and judged:
        scores, max_score = [verdict.score for verdict in judged], judged[0].max_score
    kinds = Counter((result.status, result.score is not None) for result in own)
    histogram = [0] * BINS
    for score in scores:
        histogram[max(0, min(BINS - 1, int(BINS * score / max_score)))] += 1
    return Distribution(
        lesson.name,
        lesson.stage,
        len(scores),
        kinds[WAITING, True],
        kinds[WAITING, False] + kinds[MARKED, False],
        kinds[MISSING, False],
        kinds[EXCUSED, False] + kinds[EXCUSED, True],
        kinds[AUDITOR, False] + kinds[AUDITOR, True],
        statistics.mean(scores) if scores else 0.0,
        statistics.median(scores) if scores else 0.0,
        max_score or 0.0,
        tuple(histogram),
        statistics.median(verdict.seconds for verdict in judged) if judged else None,
    )
