"""Run the checks on a notebook's program in a separate worker process."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from grader.course.lessons import Lesson
from grader.judging.runner import JudgeFault, every_check, outcomes_of_untouched, run_checks
from grader.sandbox import Limits, Sandbox
from grader.sandbox.program import Program
from grader.sandbox.student import StudentProxy
from grader.sandbox.time_budget import Budget
from utils.checks import Check, CheckFailed
from utils.checks.diagnosis import Mistake, diagnose, object_to_diagnose
from utils.checks.outcomes import Outcome


@dataclass(frozen=True)
class Setting:
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
    newer : dict of str to str
        The part of the notebook that only a newer Python can run, by the exercise that needs it.
    """

    outcomes: tuple[Outcome, ...]
    problems: tuple[str, ...] = ()
    uses: dict[str, tuple[str, ...]] = field(default_factory=dict)
    mistakes: dict[str, Mistake] = field(default_factory=dict)
    fault: str = ""
    newer: dict[str, str] = field(default_factory=dict)

    def outcomes_of(self, exercise: str) -> list[Outcome]:
        """Return the outcomes of one exercise's checks."""
        return [outcome for outcome in self.outcomes if outcome.check.exercise == exercise]


def run_program(
    setting: Setting,
    program: Program,
    selected: Callable[[Check], bool] = every_check,
    explain: bool = False,
    keep_going: bool = True,
) -> RunResults:
    """Run the checks of a lesson on one program.

    Parameters
    ----------
    setting : Setting
    program : grader.sandbox.program.Program
    selected : callable
        Takes a check and returns whether to run it.
    explain : bool
        Whether to look for mistakes that explain wrong answers.
    keep_going : bool
        Whether to continue after a failure. If not, all later checks fail without being run.

    Raises
    ------
    grader.sandbox.SandboxUnavailable
    """
    budget = setting.budget or Budget(setting.limits or Limits())
    with StudentProxy(program, setting.sandbox, setting.limits, budget) as student:
        outcomes, mistakes, fault = [], {}, ""
        try:
            outcomes = run_checks(
                setting.lesson, student, setting.seed, selected, keep_going, budget
            )
        except JudgeFault as error:
            fault = str(error)
        observed = (tuple(student.problems), student.uses)
    if explain:
        mistakes = _diagnose_mistakes(outcomes, setting, program, budget)
    return RunResults(tuple(outcomes), *observed, mistakes, fault, student.newer)


def untouched_results(lesson: Lesson) -> RunResults:
    """Return the results of an untouched notebook, without running it."""
    try:
        return RunResults(outcomes_of_untouched(lesson))
    except JudgeFault as error:
        return RunResults((), fault=str(error))


def _diagnose_mistakes(
    outcomes: Iterable[Outcome], setting: Setting, program: Program, budget: Budget
) -> dict[str, Mistake]:
    """Return the mistake that explains an exercise's wrong answers, by the exercise's name.

    A new process answers, because the earlier one may have been stopped too often to start again.
    """
    wrong = {o.check.exercise for o in outcomes if isinstance(o.failure, CheckFailed)}
    if not wrong:
        return {}
    found = {}
    with StudentProxy(program, setting.sandbox, setting.limits, budget) as student:
        for exercise in sorted(wrong):
            student.exercise, seconds = exercise, budget.seconds
            found[exercise] = diagnose(exercise, getattr(student, object_to_diagnose(exercise)))
            budget.add_failed_seconds(exercise, seconds - budget.seconds)
    return {exercise: mistake for exercise, mistake in found.items() if mistake}
