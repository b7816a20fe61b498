"""Decide whether a named mistake explains all points that an exercise lost.

A copy of the lesson's own solution makes this mistake and no other. Two conditions must be met:

- The copy fails exactly the checks that the student's function fails.
- In all checks, visible and hidden, both functions give the same answers.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

from grader.course.lessons import Lesson
from grader.intake.notebook import read_notebook
from grader.judging.program_run import JudgingContext
from grader.judging.runner import run_checks
from grader.sandbox.program import Program
from grader.sandbox.student import StudentProxy
from utils.checks import Check
from utils.checks.diagnosis import Mistake, imitation_of
from utils.notebooks import slicing


@functools.cache
def _load_solution(lesson: Lesson, exercise: str) -> Callable:
    """Return the function from the lesson's built solution, which the rehearsal has judged."""
    statements, _ = slicing.parse_notebook(read_notebook(lesson.solved).code)
    namespace = {"__name__": lesson.name}
    for statement in slicing.slice_for((exercise,), statements):
        exec(slicing.compile_statement(statement, str(lesson.solved)), namespace)
    return namespace[exercise]


class _SubstituteProxy:
    """A student proxy in which another function replaces the student's for one exercise.

    Parameters
    ----------
    student : object
        The original proxy.
    exercise : str
    function : callable
        Called instead of the student's function.
    """

    def __init__(self, student: object, exercise: str, function: Callable) -> None:
        self._student, self._exercise, self._function = student, exercise, function
        self.exercise = exercise

    def __getattr__(self, name: str) -> object:
        return self._function if name == self._exercise else getattr(self._student, name)

    def close(self) -> None:
        """Do nothing: the owner of the student proxy closes it."""


def mistake_explains(
    context: JudgingContext,
    program: Program,
    exercise: str,
    mistake: Mistake,
    failed: frozenset[Check],
) -> bool:
    """Return whether one mistake alone explains the failed checks of an exercise.

    Parameters
    ----------
    context : grader.judging.program_run.JudgingContext
    program : grader.sandbox.program.Program
        The notebook.
    exercise : str
    mistake : utils.checks.diagnosis.Mistake
    failed : frozenset of utils.checks.Check
    """
    imitation = imitation_of(exercise, mistake, _load_solution(context.lesson, exercise))
    if imitation is None:
        return False
    with StudentProxy(program, context.sandbox, context.limits, context.budget) as student:
        failed_alone = _failed_checks(context, student, exercise, imitation.call)
        if failed_alone != failed:
            return False
        student.exercise = exercise
        student_function, calls, equal_answers = getattr(student, exercise), [], []

        def call_and_compare(*arguments: object, **keywords: object) -> object:
            calls.append(True)
            answer = student_function(*arguments, **keywords)
            if imitation.same(answer, imitation.call(*arguments, **keywords)):
                equal_answers.append(True)
            return answer

        failed_again = _failed_checks(context, student, exercise, call_and_compare)
        return failed_again == failed and len(equal_answers) == len(calls)


def _failed_checks(
    context: JudgingContext, student: StudentProxy, exercise: str, function: Callable
) -> frozenset[Check]:
    """Return the checks of an exercise that fail when a function replaces the student's."""
    proxy = _SubstituteProxy(student, exercise, function)
    outcomes = run_checks(
        context.lesson, proxy, context.seed, lambda check: check.exercise == exercise
    )
    return frozenset(outcome.check for outcome in outcomes if outcome.failure)
