"""A notebook's program is asked, in a process of its own that ends with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from grader.course.lessons import Lesson
from grader.judging.runner import JudgeFault, everything, run_tests, tests_of_nothing
from grader.sandbox import Limits, Sandbox
from grader.sandbox.program import Program
from grader.sandbox.student import StudentProxy
from grader.sandbox.time_budget import Budget
from utils.checks import Check, CheckFailed
from utils.checks.diagnosis import Mistake, asked_through, diagnose
from utils.checks.outcomes import Outcome


@dataclass(frozen=True)
class Setting:
    """By what a notebook is judged, and where.

    Attributes
    ----------
    lesson : grader.course.lessons.Lesson
    seed : int
        The course's secret.
    sandbox : grader.sandbox.Sandbox
    limits : grader.sandbox.Limits, optional
    budget : grader.sandbox.time_budget.Budget, optional
        What is left of the notebook's time, however often it is asked; by default each asking has
        one of its own.
    """

    lesson: Lesson
    seed: int
    sandbox: Sandbox
    limits: Limits | None = None
    budget: Budget | None = None


@dataclass(frozen=True)
class Asked:
    """What came of asking.

    Attributes
    ----------
    outcomes : tuple of Outcome
        One for each check that was asked; none where there is a fault.
    problems : tuple of str
        What was wrong with the notebook's own cells, one sentence each.
    uses : dict of str to tuple of str
        Which exercises call which functions.
    starved : bool
        Whether a time limit was reached by code that hardly had a processor.
    mistakes : dict of str to utils.checks.diagnosis.Mistake
        What explains the answers to an exercise, by its name.
    fault : str
        Why not every check could be asked; then nothing can be said about the student.
    """

    outcomes: tuple[Outcome, ...]
    problems: tuple[str, ...] = ()
    uses: dict[str, tuple[str, ...]] = field(default_factory=dict)
    starved: bool = False
    mistakes: dict[str, Mistake] = field(default_factory=dict)
    fault: str = ""

    def about(self, exercise: str) -> list[Outcome]:
        """The outcomes of the checks of one exercise."""
        return [outcome for outcome in self.outcomes if outcome.check.exercise == exercise]


def ask(
    setting: Setting,
    program: Program,
    asked: Callable[[Check], bool] = everything,
    explain: bool = False,
    to_the_end: bool = True,
) -> Asked:
    """Ask the checks of a lesson of one program.

    Parameters
    ----------
    setting : Setting
    program : grader.sandbox.program.Program
    asked : callable
        Takes a check: whether to ask it.
    explain : bool
        Whether to look for what explains wrong answers.
    to_the_end : bool
        Whether to go on once a check has failed; else those after it fail untried.

    Raises
    ------
    grader.sandbox.SandboxUnavailable
    """
    with StudentProxy(program, setting.sandbox, setting.limits, setting.budget) as student:
        outcomes, mistakes, fault = [], {}, ""
        try:
            outcomes = run_tests(setting.lesson, student, setting.seed, asked, to_the_end)
        except JudgeFault as error:
            fault = str(error)
        if explain:
            mistakes = _mistakes(outcomes, student)
        about = (tuple(student.problems), student.uses, student.starved)
        return Asked(tuple(outcomes), *about, mistakes, fault)


def nothing_written(lesson: Lesson) -> Asked:
    """What comes of asking a notebook that stands as it was handed out, without asking it."""
    try:
        return Asked(tests_of_nothing(lesson))
    except JudgeFault as error:
        return Asked((), fault=str(error))


def _mistakes(outcomes: Iterable[Outcome], student: StudentProxy) -> dict[str, Mistake]:
    """What explains the answers to each exercise, by its name."""
    found = {}
    for outcome in outcomes:
        exercise = outcome.check.exercise
        if isinstance(outcome.failure, CheckFailed) and exercise not in found:
            student.exercise = exercise
            found[exercise] = diagnose(exercise, getattr(student, asked_through(exercise)))
    return {exercise: mistake for exercise, mistake in found.items() if mistake}
