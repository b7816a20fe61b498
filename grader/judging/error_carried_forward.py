"""Judge an exercise again with correct helpers if it calls a wrong helper.

The student can then still earn points for the exercise itself. The same applies to a helper that is
right but gets a note, for example because it returns a list. The second run uses a separate
process, in which no other exercise runs. The correct helper therefore cannot reveal the answer to
another exercise. Messages about that run contain no more detail than messages about hidden tests,
because more detail could reveal the helper.

A second try alone must not earn points. The exercise therefore also runs once more with the
student's own helpers. If a check fails both times, the run with correct helpers decides. A check
that passed must pass again. A deterministic answer loses nothing. An answer that passes by chance
with probability p earns p² + (1 - p)² p, which is never more than p.
"""

from __future__ import annotations

import ast
import dataclasses
from dataclasses import dataclass

from grader.course.lessons import Exercise, Lesson
from grader.intake.notebook import read_notebook
from grader.judging.points import points_of
from grader.judging.program_run import JudgingContext, RunResults, run_program
from grader.judging.verdict import Gain
from grader.sandbox.failures import StudentStopped
from grader.sandbox.program import GivenCode, Program
from utils.checks.outcomes import Outcome
from utils.notebooks import slicing

_INCONSISTENT_RUNS = (
    "The judge ran {name} a second time, because it calls a function that failed a check or got a "
    "note. A check that passed the first time but failed the second time earns no points. Does "
    "{name} use random numbers?"
)


@dataclass(frozen=True)
class CarriedForwardResult:
    """The result of an exercise with correct helpers.

    Attributes
    ----------
    outcomes : tuple of Outcome
    sentence : str
        A sentence for the student that explains the new result.
    program : grader.sandbox.program.Program
        The notebook, with correct helpers if they improved the result.
    gain : grader.judging.verdict.Gain or None
        The improvement; None if the second run only took points away.
    """

    outcomes: tuple[Outcome, ...]
    sentence: str
    program: Program
    gain: Gain | None = None


def carry_forward(
    context: JudgingContext, program: Program, results: RunResults
) -> dict[str, CarriedForwardResult]:
    """Repeat the judging of each exercise that calls a wrong helper, or one with a note.

    Parameters
    ----------
    context : grader.judging.program_run.JudgingContext
    program : grader.sandbox.program.Program
        The notebook.
    results : grader.judging.program_run.RunResults
        The results of the first run. Its `uses` come from the worker, because this process does
        not parse untrusted code.

    Returns
    -------
    dict of str to CarriedForwardResult
        The new result of each exercise whose result changes, by the exercise's name.
    """
    exercises = context.lesson.machine_graded
    failing = {outcome.check.exercise for outcome in results.outcomes if outcome.failure}
    replaceable = failing | results.noted
    improved = {}
    for number, exercise in enumerate(exercises):
        # Only earlier exercises are replaced. The solution of a later exercise may call the current
        # one, and could therefore contain its answer.
        earlier = [earlier_exercise.name for earlier_exercise in exercises[:number]]
        called = replaceable.intersection(results.uses.get(exercise.name, ()))
        helpers = tuple(name for name in earlier if name in called)
        if not helpers:
            continue
        programs = [program]
        if exercise.name in failing:
            programs.append(_replace_helpers(context.lesson, program, exercise, helpers))
        runs = [
            run_program(context, code, lambda check, e=exercise: check.exercise == e.name)
            for code in programs
        ]
        if any(run.fault for run in runs):  # keep the result of the first run
            continue
        first = results.outcomes_of(exercise.name)
        by_check = [{outcome.check: outcome for outcome in run.outcomes} for run in runs]
        # If every check passed, the only new run uses the student's helpers, and must pass again.
        outcomes = tuple(
            decisive_outcome(outcome, by_check[0][outcome.check], by_check[-1][outcome.check])
            for outcome in first
        )
        before, after = (points_of(exercise.points, ended) for ended in (first, outcomes))
        if after > before:
            wrong = tuple(name for name in helpers if name in failing)
            gain = Gain(exercise.name, exercise.points, helpers, wrong, before, after)
            improved[exercise.name] = CarriedForwardResult(
                outcomes, gain.sentence, programs[-1], gain
            )
        elif any(new.failure and not old.failure for old, new in zip(first, outcomes, strict=True)):
            sentence = _INCONSISTENT_RUNS.format(name=exercise.name)
            improved[exercise.name] = CarriedForwardResult(outcomes, sentence, program)
    return improved


def decisive_outcome(first: Outcome, repeated: Outcome, with_right_helpers: Outcome) -> Outcome:
    """Return the outcome that counts for a check.

    A stopped run gave no answer. A check that passed in the first run therefore still passes if the
    second run was stopped. If the first run failed, the run with correct helpers counts only if the
    second run failed in the same way: both with a wrong answer, or both by being stopped.

    Parameters
    ----------
    first, repeated : Outcome
        The outcomes of two runs with the student's own helpers.
    with_right_helpers : Outcome
    """
    if not first.failure:
        fails_again = repeated.failure and not _is_stop(repeated)
        return repeated if fails_again else first
    is_same_failure = repeated.failure and _is_stop(first) == _is_stop(repeated)
    return with_right_helpers if is_same_failure else first


def _is_stop(outcome: Outcome) -> bool:
    return isinstance(outcome.failure, StudentStopped)


def _replace_helpers(
    lesson: Lesson, program: Program, exercise: Exercise, helpers: tuple[str, ...]
) -> Program:
    """Return the notebook with the lesson's helpers in place of the student's.

    The helpers come from the built solution, which the rehearsal has judged. The lesson's source
    may have changed since then.
    """
    statements, _ = slicing.parse_notebook(read_notebook(lesson.solved).code)
    correct_helpers = [
        ast.unparse(statement.node)
        for statement in slicing.slice_for(helpers, statements)
        if exercise.name not in statement.binds
    ]
    given = program.given
    return dataclasses.replace(
        program,
        names=(exercise.name, *given.names),
        given=GivenCode(
            (*given.names, *helpers), "\n".join([given.source, *correct_helpers]), given.open_names
        ),
    )
