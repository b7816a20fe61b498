"""Run the checks on a notebook's program in a separate worker process."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from grader.course.lessons import Lesson
from grader.judging.collection import JudgeFault
from grader.judging.runner import (
    TEST_SECONDS,
    JudgeTimeout,
    every_check,
    exercises_with_notes,
    limited_cpu_time,
    outcomes_of_untouched,
    run_checks,
)
from grader.sandbox import Limits, Sandbox
from grader.sandbox.program import Program
from grader.sandbox.student import StudentProxy
from grader.sandbox.time_budget import Budget
from utils.checks import Check, CheckFailed
from utils.checks.diagnosis import Mistake, diagnose, object_to_diagnose
from utils.checks.outcomes import Outcome


@dataclass(frozen=True)
class JudgingContext:
    """The rules for judging a notebook, and the sandbox in which it runs.

    Attributes
    ----------
    lesson : grader.course.lessons.Lesson
    seed : int
        The course's secret.
    sandbox : grader.sandbox.Sandbox
    limits : grader.sandbox.Limits, optional
    budget : grader.sandbox.time_budget.Budget, optional
        Remaining time of the notebook, shared by all runs. By default, each run gets a new budget.
    """

    lesson: Lesson
    seed: int
    sandbox: Sandbox
    limits: Limits | None = None
    budget: Budget | None = None


@dataclass(frozen=True)
class RunResults:
    """The results of one run of the checks.

    Attributes
    ----------
    outcomes : tuple of Outcome
        One for each check that was run; empty if there is a fault.
    problems : tuple of str
        One sentence for each problem in the notebook's own cells.
    uses : dict of str to tuple of str
        The functions that each exercise calls.
    mistakes : dict of str to utils.checks.diagnosis.Mistake
        The mistake that explains the wrong answers to an exercise, by the exercise's name.
    fault : str
        The reason why a check could not be run. If there is one, the student cannot be judged.
    newer_names : dict of str to str
        The part of the notebook that only a newer Python can run, by the exercise that needs it.
    noted : frozenset of str
        The exercises that others call and whose answers are right, but get a note, for example
        because they return a list.
    """

    outcomes: tuple[Outcome, ...]
    problems: tuple[str, ...] = ()
    uses: dict[str, tuple[str, ...]] = field(default_factory=dict)
    mistakes: dict[str, Mistake] = field(default_factory=dict)
    fault: str = ""
    newer_names: dict[str, str] = field(default_factory=dict)
    noted: frozenset[str] = frozenset()

    def outcomes_of(self, exercise: str) -> list[Outcome]:
        """Return the outcomes of one exercise's checks."""
        return [outcome for outcome in self.outcomes if outcome.check.exercise == exercise]


def run_program(
    context: JudgingContext,
    program: Program,
    is_selected: Callable[[Check], bool] = every_check,
    explain: bool = False,
    keep_going: bool = True,
) -> RunResults:
    """Run the checks of a lesson on one program.

    Parameters
    ----------
    context : JudgingContext
    program : grader.sandbox.program.Program
    is_selected : callable
        Takes a check and returns whether to run it.
    explain : bool
        Whether to look for mistakes that explain wrong answers, and for helpers with notes.
    keep_going : bool
        Whether to continue after a failure. If not, all later checks fail without being run.

    Raises
    ------
    grader.sandbox.SandboxUnavailable
    """
    budget = context.budget or Budget(context.limits or Limits())
    with StudentProxy(program, context.sandbox, context.limits, budget) as student:
        outcomes, mistakes, noted, fault = [], {}, frozenset(), ""
        try:
            outcomes = run_checks(
                context.lesson, student, context.seed, is_selected, keep_going, budget
            )
            if explain:
                noted = exercises_with_notes(student, _right_helpers(outcomes, student), budget)
        except JudgeFault as error:
            fault = str(error)
        observed = (tuple(student.problems), student.uses)
    if explain:
        mistakes = _diagnose_mistakes(outcomes, context, program, budget)
    return RunResults(tuple(outcomes), *observed, mistakes, fault, student.newer_names, noted)


def _right_helpers(outcomes: Iterable[Outcome], student: StudentProxy) -> list[str]:
    """Return the exercises that other exercises call and that pass all their checks."""
    passed = {outcome.check.exercise: True for outcome in outcomes}
    passed |= {outcome.check.exercise: False for outcome in outcomes if outcome.failure}
    called = set().union(*(student.uses.get(exercise, ()) for exercise in passed))
    return [exercise for exercise, is_right in passed.items() if is_right and exercise in called]


def untouched_results(lesson: Lesson) -> RunResults:
    """Return the results of an untouched notebook, without running it."""
    try:
        return RunResults(outcomes_of_untouched(lesson))
    except JudgeFault as error:
        return RunResults((), fault=str(error))


def _diagnose_mistakes(
    outcomes: Iterable[Outcome], context: JudgingContext, program: Program, budget: Budget
) -> dict[str, Mistake]:
    """Return the mistake that explains an exercise's wrong answers, by the exercise's name.

    A new proxy calls the student's functions, because the earlier proxy may have used up its
    restarts.
    """
    wrong = {o.check.exercise for o in outcomes if isinstance(o.failure, CheckFailed)}
    if not wrong:
        return {}
    with StudentProxy(program, context.sandbox, context.limits, budget) as student:
        found = {exercise: _diagnose(exercise, student, budget) for exercise in sorted(wrong)}
    return {exercise: mistake for exercise, mistake in found.items() if mistake}


def _diagnose(exercise: str, student: StudentProxy, budget: Budget) -> Mistake | None:
    """Return the mistake that explains one exercise, unless the search takes too long.

    The search counts as time of failed checks, for the student and for the judge.
    """
    seconds_left = TEST_SECONDS - budget.judge_seconds[exercise]
    if seconds_left <= 0:
        return None
    student.exercise, seconds, start = exercise, budget.seconds, time.process_time()
    mistake = None
    with contextlib.suppress(JudgeTimeout), limited_cpu_time(seconds_left) as is_over:
        mistake = diagnose(exercise, getattr(student, object_to_diagnose(exercise)))
    budget.judge_seconds[exercise] += time.process_time() - start
    if is_over.is_set():
        student.close()  # a call may have been interrupted before its reply was read
    budget.add_failed_seconds(exercise, seconds - budget.seconds)
    return mistake
