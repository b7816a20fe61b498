"""Turn the outcomes of an exercise's checks into the exercise's result in the verdict."""

from __future__ import annotations

from grader.course.lessons import Exercise, Lesson
from grader.course.rules import MISSED_TASK_KEEPS, ONE_SLIP_KEEPS
from grader.judging.error_carried_forward import CarriedForwardResult
from grader.judging.messages import Message, message_of, messages_of, shareable_outcome
from grader.judging.points import divide_points, sum_points
from grader.judging.program_run import RunResults
from grader.judging.repair import Repair
from grader.judging.verdict import CheckResult, ExerciseResult, Slip
from utils.checks.diagnosis import Mistake
from utils.checks.outcomes import Outcome
from utils.checks.summary import summarise


def unjudged_results(lesson: Lesson) -> tuple[ExerciseResult, ...]:
    """Return results without points and checks, for a notebook that could not be judged."""
    return tuple(
        ExerciseResult(exercise.name, 0.0, exercise.points, ())
        for exercise in lesson.machine_graded
    )


def result_of(
    exercise: Exercise,
    run_results: RunResults,
    carried: CarriedForwardResult | None,
    proven_slip: Repair | Mistake | None = None,
) -> ExerciseResult:
    """Return the result of an exercise.

    Parameters
    ----------
    exercise : grader.course.lessons.Exercise
    run_results : grader.judging.program_run.RunResults
        The results of running the checks on the notebook.
    carried : grader.judging.error_carried_forward.CarriedForwardResult or None
        The result that replaces the first one, if `carry_forward` changed it.
    proven_slip : grader.judging.repair.Repair, utils.checks.diagnosis.Mistake or None
        The proven slip, if there is one.
    """
    sentences, mistake = [], run_results.mistakes.get(exercise.name)
    outcomes = run_results.outcomes_of(exercise.name)
    if carried:
        sentences, mistake, outcomes = [carried.sentence], None, carried.outcomes
    shareable_outcomes = [
        shareable_outcome(outcome, is_public=carried is None) for outcome in outcomes
    ]
    summary = summarise(shareable_outcomes, mistake=mistake, one_mistake=proven_slip is not None)
    messages = messages_of(summary)
    maxima = divide_points(exercise.points, [outcome.check.weight for outcome in outcomes])
    checks = tuple(
        _build_check_result(outcome, points, messages.get(outcome, Message("")))
        for outcome, points in zip(shareable_outcomes, maxima, strict=True)
    )
    sentences += [message_of(summary.first, summary.mistake).text] if summary.first else []
    first = summary.first.check.name if summary.first and not summary.not_started else ""
    score = sum_points([result.score for result in checks])
    kept_share = MISSED_TASK_KEEPS if mistake and mistake.is_the_task else ONE_SLIP_KEEPS
    slip = None
    if proven_slip:
        slip = _build_slip(proven_slip, exercise.points, score, kept_share)
    score = sum_points([score, slip.score]) if slip else score
    cause = "\n".join(sentences)
    gain = carried.gain if carried else None
    return ExerciseResult(exercise.name, score, exercise.points, checks, cause, first, slip, gain)


def _build_slip(
    proven_slip: Repair | Mistake, points: float, score: float, kept_share: float
) -> Slip:
    """Return the slip, with the points that the answer keeps in addition to those of its checks."""
    kept = max(round(100 * kept_share * points) - round(100 * score), 0) / 100
    if isinstance(proven_slip, Mistake):
        return Slip(0, 0, "", "", kept)
    return Slip(proven_slip.cell, proven_slip.line, proven_slip.before, proven_slip.after, kept)


def _build_check_result(outcome: Outcome, points: float, message: Message) -> CheckResult:
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
