"""Turn the outcomes of an exercise's checks into the exercise's result in the verdict."""

from __future__ import annotations

from grader.course.lessons import Exercise, Lesson
from grader.course.rules import MISSED_TASK_KEEPS, ONE_SLIP_KEEPS
from grader.judging.error_carried_forward import CarriedForward
from grader.judging.messages import Message, message_of, messages_of, shareable
from grader.judging.points import shares, total
from grader.judging.program_run import RunResults
from grader.judging.repair import Repair
from grader.judging.verdict import CheckResult, ExerciseResult, Slip
from utils.checks.diagnosis import Mistake
from utils.checks.outcomes import Outcome
from utils.checks.summary import summarise


def unjudged_results(lesson: Lesson) -> tuple[ExerciseResult, ...]:
    """Return the results of a lesson whose checks did not run."""
    return tuple(
        ExerciseResult(exercise.name, 0.0, exercise.points, ())
        for exercise in lesson.machine_graded
    )


def result_of(
    exercise: Exercise,
    run_results: RunResults,
    carried: CarriedForward | None,
    proven: Repair | Mistake | None = None,
) -> ExerciseResult:
    """Return the result of an exercise.

    Parameters
    ----------
    exercise : grader.course.lessons.Exercise
    run_results : grader.judging.program_run.RunResults
        The results of running the checks on the notebook.
    carried : grader.judging.error_carried_forward.CarriedForward or None
        The result with correct helpers, if that is better.
    proven : grader.judging.repair.Repair, utils.checks.diagnosis.Mistake or None
        The proven slip, if there is one.
    """
    sentences, mistake = [], run_results.mistakes.get(exercise.name)
    outcomes = run_results.outcomes_of(exercise.name)
    if carried:
        sentences, mistake, outcomes = [carried.sentence], None, carried.outcomes
    shareable_outcomes = [shareable(outcome, open_to_all=carried is None) for outcome in outcomes]
    story = summarise(shareable_outcomes, mistake=mistake, one_mistake=proven is not None)
    messages = messages_of(story)
    maxima = shares(exercise.points, [outcome.check.weight for outcome in outcomes])
    checks = tuple(
        _result(outcome, points, messages.get(outcome, Message("")))
        for outcome, points in zip(shareable_outcomes, maxima, strict=True)
    )
    sentences += [message_of(story.first, story.mistake).text] if story.first else []
    first = story.first.check.name if story.first and not story.not_started else ""
    score = total([result.score for result in checks])
    keeps = MISSED_TASK_KEEPS if mistake and mistake.is_the_task else ONE_SLIP_KEEPS
    slip = _slip(proven, exercise.points, score, keeps) if proven else None
    score = total([score, slip.score]) if slip else score
    cause = "\n".join(sentences)
    return ExerciseResult(exercise.name, score, exercise.points, checks, cause, first, slip)


def _slip(proven: Repair | Mistake, points: float, score: float, keeps: float) -> Slip:
    """Return the slip, with the points that the answer keeps in addition to those of its checks."""
    kept = max(round(100 * keeps * points) - round(100 * score), 0) / 100
    if isinstance(proven, Mistake):
        return Slip(0, 0, "", "", kept)
    return Slip(proven.cell, proven.line, proven.before, proven.after, kept)


def _result(outcome: Outcome, points: float, message: Message) -> CheckResult:
    check, passed = outcome.check, outcome.failure is None
    return CheckResult(
        check.name,
        check.title,
        passed,
        points if passed else 0.0,
        points,
        message.text,
        check.is_shown,
        message.kind,
        message.subject,
        message.hint,
    )
