"""How a class did in a lesson, and over whom that is reckoned."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from grader.course.lessons import Lesson
from grader.judging.verdict import Verdict
from grader.lms.results import EXCUSED, MARKED, MISSING, WAITING, ClassResults

BINS = 10


@dataclass(frozen=True)
class Distribution:
    """The scores of one lesson, before points are taken off for lateness.

    Attributes
    ----------
    name, stage : str
    count : int
        How many have a score: the mean is over them.
    waiting : int
        For how many of these a person has still to add something.
    not_entered, missing, excused : int
        How many others there are, and have none.
    mean, median, max_score : float
    histogram : tuple of int
        Students by score, from 0 to the most.
    seconds : float or None
        What it took to judge one, as the median.
    """

    name: str
    stage: str
    count: int
    waiting: int
    not_entered: int
    missing: int
    excused: int
    mean: float
    median: float
    max_score: float
    histogram: tuple[int, ...]
    seconds: float | None

    @property
    def over(self) -> str:
        """Over whom mean and median are, and who is left out."""
        who = f"over the {self.count} with a score" if self.count > 1 else "of the one with a score"
        if self.waiting:
            who += f", {self.waiting} of them still to be graded by a person"
        others = {
            "not yet entered": self.not_entered,
            "missing": self.missing,
            "excused": self.excused,
        }
        left = [f"{number} {what}" for what, number in others.items() if number]
        return f"{who}; not counted: {', '.join(left)}" if left else who


def distribution_of(
    lesson: Lesson, results: ClassResults, verdicts: Sequence[Verdict]
) -> Distribution:
    """The `Distribution` of a lesson: by the gradebook, or without one by the verdicts."""
    judged = [verdict for verdict in verdicts if verdict.lesson == lesson.name]
    mine = [result for result in results.notebooks if result.lesson == lesson.name]
    scores = [result.score for result in mine if result.score is not None]
    most = results.lessons.get(lesson.name)
    if not mine and judged:
        scores, most = [verdict.score for verdict in judged], judged[0].max_score
    kinds = Counter((result.standing, result.score is not None) for result in mine)
    histogram = [0] * BINS
    for score in scores:
        histogram[max(0, min(BINS - 1, int(BINS * score / most)))] += 1
    return Distribution(
        lesson.name,
        lesson.stage,
        len(scores),
        kinds[WAITING, True],
        kinds[WAITING, False] + kinds[MARKED, False],
        kinds[MISSING, False],
        kinds[EXCUSED, False],
        statistics.mean(scores) if scores else 0.0,
        statistics.median(scores) if scores else 0.0,
        most or 0.0,
        tuple(histogram),
        statistics.median(verdict.seconds for verdict in judged) if judged else None,
    )
