"""An exercise that calls a wrong one is judged a second time, with a right one in its place.

Its own work still earns points. That second time it has a process of its own, in which nothing
else is asked: what is right in there is no answer to any question. And nothing that is said
there is told, so that nobody reads in the feedback what the right one looks like.

Two tries are not better than one. Beside that, it is asked once more with its own helpers: what
fails both times, fails for their sake, and has the second judging; what holds has to hold again.
So who answers alike each time loses nothing, and a coin that shows heads with probability p earns
p² + (1 - p)² p, which is never more than p.
"""

from __future__ import annotations

import ast
import dataclasses
from dataclasses import dataclass

from grader.course.lessons import Exercise, Lesson
from grader.intake.notebook import read_notebook
from grader.judging.points import points_of
from grader.judging.program_run import Asked, Setting, ask
from grader.sandbox.failures import StudentStopped
from grader.sandbox.program import Given, Program
from utils.checks.outcomes import Outcome
from utils.notebooks import slicing

_FICKLE = (
    "{name} was asked once more, as it calls a function that is wrong: what held the first time "
    "and not the second does not count. Does it answer by chance?"
)


@dataclass(frozen=True)
class Followed:
    """How an exercise fared with right helpers.

    Attributes
    ----------
    outcomes : tuple of Outcome
    sentence : str
        Which function is at fault.
    program : grader.sandbox.program.Program
        The notebook, with right helpers where these made it better.
    """

    outcomes: tuple[Outcome, ...]
    sentence: str
    program: Program


def follow_through(
    setting: Setting, program: Program, asked: Asked
) -> tuple[dict[str, Followed], bool]:
    """Judge again what calls a wrong exercise.

    Parameters
    ----------
    setting : grader.judging.program_run.Setting
    program : grader.sandbox.program.Program
        The notebook.
    asked : grader.judging.program_run.Asked
        What came of judging it; also what calls what, read behind the wall: nobody parses a
        stranger's code here.

    Returns
    -------
    followed : dict of str to Followed
        By exercise; only those that fare otherwise so.
    starved : bool
        Whether a time limit was reached by code that hardly had a processor.
    """
    exercises = setting.lesson.machine_graded
    lost = {outcome.check.exercise for outcome in asked.outcomes if outcome.failure}
    better, starved = {}, False
    for number, exercise in enumerate(exercises):
        # What comes after it may be made of it, and a right one might tell it the answer.
        earlier = [before.name for before in exercises[:number]]
        called = lost.intersection(asked.uses.get(exercise.name, ()))
        helpers = tuple(name for name in earlier if name in called)
        if not helpers:
            continue
        codes = [program]
        if exercise.name in lost:
            codes.append(_with_right(setting.lesson, program, exercise, helpers))
        tries = [
            ask(setting, code, lambda check, e=exercise: check.exercise == e.name) for code in codes
        ]
        if any(attempt.fault for attempt in tries):  # said of the first time, which counts
            continue
        starved |= any(attempt.starved for attempt in tries)
        first = asked.about(exercise.name)
        by_check = [{one.check: one for one in again.outcomes} for again in tries]
        # Where all held there is nothing to put right; it holds again, or was luck.
        outcomes = tuple(
            settled(one, by_check[0][one.check], by_check[-1][one.check]) for one in first
        )
        before, after = (points_of(exercise.points, ended) for ended in (first, outcomes))
        if after > before:
            sentence = _sentence(exercise, helpers, before, after)
            better[exercise.name] = Followed(outcomes, sentence, codes[-1])
        elif any(one.failure and not was.failure for was, one in zip(first, outcomes, strict=True)):
            sentence = _FICKLE.format(name=exercise.name)
            better[exercise.name] = Followed(outcomes, sentence, program)
    return better, starved


def settled(first: Outcome, once_more: Outcome, with_right: Outcome) -> Outcome:
    """How a check counts that was asked twice with a student's helpers, and then with right ones.

    A process that had to be stopped has not answered: it takes nothing from an answer that held,
    and repeats no wrong one.
    """
    if not first.failure:
        wrong = once_more.failure and not _is_stop(once_more)
        return once_more if wrong else first
    alike = once_more.failure and _is_stop(first) == _is_stop(once_more)
    return with_right if alike else first


def _is_stop(outcome: Outcome) -> bool:
    return isinstance(outcome.failure, StudentStopped)


def _with_right(
    lesson: Lesson, program: Program, exercise: Exercise, helpers: tuple[str, ...]
) -> Program:
    """The notebook, with the lesson's own helpers in the place of the student's.

    They are what the lesson's rehearsal has judged, and not what an author has written since.
    """
    statements, _ = slicing.parse_notebook(read_notebook(lesson.solved).code)
    right = [
        ast.unparse(statement.node)
        for statement in slicing.slice_for(helpers, statements)
        if exercise.name not in statement.binds
    ]
    given = program.given
    return dataclasses.replace(
        program,
        names=(exercise.name, *given.names),
        given=Given((*given.names, *helpers), "\n".join([given.source, *right]), given.open),
    )


def _sentence(exercise: Exercise, helpers: tuple[str, ...], before: float, after: float) -> str:
    wrong, right = ("is", "a right one") if len(helpers) == 1 else ("are", "right ones")
    return (
        f"{' and '.join(helpers)}, which {exercise.name} calls, {wrong} wrong. Judged with {right} "
        f"instead, {exercise.name} earns {after:g} of {exercise.points:g} points, not {before:g}."
    )
