"""Item analysis: which checks are hard, and which distinguish strong from weak students."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from grader.judging.messages import common_text, remove_numbers
from grader.judging.verdict import ExerciseResult, MessageKind, Verdict

# With fewer students, chance alone can produce a discrimination of 0.4.
MIN_STUDENTS = 20


@dataclass(frozen=True)
class HardCheck:
    """A check that was the first failure of some students.

    Attributes
    ----------
    lesson, exercise, title : str
    visible : bool
    failed, tried : int
        How many students failed this check before any other, and how many started its exercise.
    """

    lesson: str
    exercise: str
    title: str
    visible: bool
    failed: int
    tried: int


@dataclass(frozen=True)
class Item:
    """One check of a lesson, with its item statistics.

    Attributes
    ----------
    exercise, title : str
    visible : bool
    passed, tried : int
        How many students passed the check, and how many have started its exercise.
    discrimination : float or None
        Correlation between passing this check and the points for the rest of the lesson. None for
        fewer than `MIN_STUDENTS` students, or if either quantity is the same for all students.
    """

    exercise: str
    title: str
    visible: bool
    passed: int
    tried: int
    discrimination: float | None


def hardest_checks(verdicts: Sequence[Verdict], limit: int = 10) -> list[HardCheck]:
    """Return the checks that were most often a student's first failure, the hardest first.

    Only the first failure in each exercise counts, because further failures may have the same
    cause.
    """
    attempts, first_failures = Counter(), Counter()
    for verdict in verdicts:
        for exercise in _started_exercises(verdict):
            attempts[verdict.lesson, exercise.name] += 1
            first = next((test for test in exercise.tests if test.name == exercise.first), None)
            if first:
                first_failures[verdict.lesson, exercise.name, first.title, first.visible] += 1
    summaries = [
        HardCheck(*check, count, attempts[check[:2]]) for check, count in first_failures.items()
    ]
    return sorted(summaries, key=lambda check: -check.failed / check.tried)[:limit]


def items_of(verdicts: Sequence[Verdict]) -> list[Item]:
    """Return an `Item` for each check of one lesson, in the order of the lesson.

    Parameters
    ----------
    verdicts : sequence of Verdict
        Verdicts for one lesson.
    """
    # The key is the name, because two checks may have the same title.
    outcomes: dict[tuple[str, str], list[tuple[float, float]]] = {}
    tests = {}
    for verdict in verdicts:
        for exercise in _started_exercises(verdict):
            for test in exercise.tests:
                check_key = exercise.name, test.name
                tests.setdefault(check_key, test)
                score_without_check = verdict.score - test.score
                outcomes.setdefault(check_key, []).append((float(test.passed), score_without_check))
    return [
        Item(
            check_key[0],
            tests[check_key].title,
            tests[check_key].visible,
            sum(passed > 0 for passed, _ in results),
            len(results),
            _discrimination(results),
        )
        for check_key, results in outcomes.items()
    ]


def _discrimination(outcomes: Sequence[tuple[float, float]]) -> float | None:
    passed, other_scores = zip(*outcomes, strict=True)
    if len(outcomes) < MIN_STUDENTS or len(set(passed)) == 1 or len(set(other_scores)) == 1:
        return None
    return statistics.correlation(passed, other_scores)


def is_not_started(exercise: ExerciseResult) -> bool:
    """Return whether the stub of an exercise is unchanged."""
    stubs = {test.subject for test in exercise.tests if test.kind == MessageKind.NOT_STARTED}
    return not exercise.first and exercise.name in stubs


def _started_exercises(verdict: Verdict) -> list[ExerciseResult]:
    """Return the exercises that a student started; none if the file could not be read."""
    return [
        exercise
        for exercise in verdict.exercises
        if exercise.tests and not is_not_started(exercise)
    ]


def count_not_started(verdicts: Sequence[Verdict]) -> list[tuple[str, int]]:
    """Return (exercise, number of students who have not started it), in the order of the course."""
    found: Counter[str] = Counter()
    for verdict in sorted(verdicts, key=lambda verdict: verdict.lesson):
        for exercise in verdict.exercises:
            found[exercise.name] += is_not_started(exercise)
    return [(name, count) for name, count in found.items() if count]


def common_messages(verdicts: Sequence[Verdict], limit: int = 8) -> list[tuple[str, str, int]]:
    """Return (exercise, message, number of students), the most frequent messages first."""
    students: dict[tuple[str, str], set[str]] = {}
    first_lines: dict[tuple[str, str], list[str]] = {}
    for verdict in verdicts:
        for exercise in _started_exercises(verdict):
            if exercise.cause:
                gain = exercise.gain
                first = gain.reason if gain else exercise.cause.splitlines()[0]
                mistake = (exercise.name, remove_numbers(first))
                students.setdefault(mistake, set()).add(verdict.student)
                first_lines.setdefault(mistake, []).append(first)
    messages = [
        (mistake[0], common_text(first_lines[mistake]), len(names))
        for mistake, names in students.items()
    ]
    return sorted(messages, key=lambda mistake: -mistake[2])[:limit]


def exercises_out_of_time(verdict: Verdict) -> list[str]:
    """Return the exercises of a notebook in which a call took too long."""
    return [
        exercise.name
        for exercise in verdict.exercises
        if any(test.kind == MessageKind.OUT_OF_TIME for test in exercise.tests)
    ]
