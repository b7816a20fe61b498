"""Look for the one edit that makes a wrong answer right.

Each edit of the student's own functions (`utils.notebooks.edits`) is asked the questions that the
answer failed, all in one process. What passes these is handed in, so to speak: the notebook with
that edit is judged as any other is, hidden questions and all, and only where it loses nothing is
it proven that one thing alone is wrong. So a repair earns what its author nearly wrote, and who
has written nothing has nothing that one edit could mend.

Clara (Gulwani, Radiček and Zuleger, PLDI 2018) and Refactory (Hu et al., ASE 2019) mend with the
answers of other students. Here nobody's answer is needed, as the questions decide.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from grader.course.rules import ONE_SLIP_KEEPS
from grader.judging.asking import hidden_questions, shown_questions
from grader.judging.explained import explains
from grader.judging.followed import Followed
from grader.judging.trial import Asked, Setting, ask
from grader.sandbox import Limits
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.patience import Budget
from grader.sandbox.program import Program, cell_and_line
from grader.sandbox.student import Student
from utils.checks import Check
from utils.checks.diagnosis import Mistake
from utils.checks.outcomes import Outcome
from utils.checks.remembering import one_run

# Of the processor, here and behind the walls, for the edits of one exercise.
SECONDS = 1.0
# By the clock on the wall, for code that sleeps a little each time.
MOST_SECONDS = 60.0
# A right answer takes less for the first questions, and an edit may well make an endless loop.
SECONDS_OF_A_CALL = 0.25
# Edits that pass what the answer failed, of which none passes everything: then there is none.
MOST_JUDGED = 3
NO_SLIPS = ("NotImplementedError", "ImportError", "ModuleNotFoundError")
LOOK_AFTER = 16  # edits, as looking at the clock takes longer than most
LOOK_SOON = 0.1  # seconds by whatever clock: one edit that hangs takes as much as many


@dataclass(frozen=True)
class Repair:
    """One edit with which an answer is right.

    Attributes
    ----------
    cell : int
        Number of the code cell.
    line : int
        Number of the first line that changes.
    before, after : str
        The lines that change, and what they become.
    """

    cell: int
    line: int
    before: str
    after: str


def slips_in(
    setting: Setting, program: Program, asked: Asked, followed: dict[str, Followed]
) -> dict[str, Repair | Mistake]:
    """What alone is wrong in each exercise that lost something, by name, where it is proven.

    The edit that mends it; or the named mistake that explains all its answers. Of a notebook whose
    own cells never end, nothing is tried: it would be waited for once more for each exercise.
    """
    found = {}
    if setting.budget and not setting.budget.begins:
        return found
    for exercise in setting.lesson.machine_graded if ONE_SLIP_KEEPS else ():
        mistake = asked.mistakes.get(exercise.name)
        if mistake and mistake.is_the_task:
            continue
        better = followed.get(exercise.name)
        outcomes = better.outcomes if better else asked.about(exercise.name)
        failed = tuple(outcome for outcome in outcomes if outcome.failure)
        if failed and not any(map(_is_no_slip, failed)):
            checks = tuple(outcome.check for outcome in failed)
            its = better.program if better else program
            if repair := repair_of(setting, its, exercise.name, checks, _raised_at(failed)):
                found[exercise.name] = repair
            elif (
                mistake
                and not better
                and explains(setting, program, exercise.name, mistake, frozenset(checks))
            ):
                found[exercise.name] = mistake
    return found


def _is_no_slip(outcome: Outcome) -> bool:
    """Whether a check met a function that nobody has written, or one that is not allowed.

    Of one that imports what the lesson forbids, no line is wrong that one could take away.
    """
    failure = outcome.failure
    return isinstance(failure, StudentError) and failure.type_name in NO_SLIPS


def _raised_at(failed: tuple[Outcome, ...]) -> frozenset[tuple[int, int]]:
    """Cells and lines at which the student's code raised, or called what raised."""
    errors = [one.failure for one in failed if isinstance(one.failure, StudentError)]
    places = [place for error in errors for place in (error.place, error.calling) if place]
    return frozenset(filter(None, map(cell_and_line, places)))


def repair_of(
    setting: Setting,
    program: Program,
    exercise: str,
    failed: tuple[Check, ...],
    raised_at: frozenset[tuple[int, int]] = frozenset(),
) -> Repair | None:
    """The edit with which an exercise loses nothing; None where there is none, or none was found.

    Parameters
    ----------
    setting : grader.judging.trial.Setting
    program : grader.sandbox.program.Program
        The notebook.
    exercise : str
    failed : tuple of utils.checks.Check
        The checks that it lost.
    raised_at : frozenset of (int, int)
        Cells and lines at which it raised: what changes one of them is tried first.
    """
    for cell, first, last, text in _passing(setting, program, exercise, failed, raised_at):
        mended = program.edited(cell, first, last, text)
        asked = ask(setting, mended, lambda check: check.exercise == exercise)
        if not asked.fault and not any(outcome.failure for outcome in asked.outcomes):
            before = program.cells[cell - 1].split("\n")[first - 1 : last]
            return Repair(cell, first, "\n".join(before), text)
    return None


def _in_order(
    edits: Sequence[tuple[int, int, int, str]], raised_at: frozenset[tuple[int, int]]
) -> list[tuple[int, tuple[int, int, int, str]]]:
    """Numbers and edits, those of certain lines first."""

    def is_elsewhere(numbered: tuple[int, tuple[int, int, int, str]]) -> bool:
        cell, first, last, _ = numbered[1]
        return not any(cell == where and first <= line <= last for where, line in raised_at)

    return sorted(enumerate(edits), key=is_elsewhere)


def _fails(question: Callable[[], object]) -> bool:
    try:
        question()
    except Exception:  # whatever a wrong answer makes a question raise
        return True
    return False


def _passing(
    setting: Setting,
    program: Program,
    exercise: str,
    failed: tuple[Check, ...],
    raised_at: frozenset[tuple[int, int]] = frozenset(),
) -> Iterator[tuple[int, int, int, str]]:
    """The first few edits that pass what the answer failed."""
    limits = setting.limits or Limits()
    limits = replace(limits, call_seconds=min(SECONDS_OF_A_CALL, limits.call_seconds))
    budget = setting.budget or Budget(limits)
    with one_run(), Student(program, setting.sandbox, limits, budget, exercise) as student:
        student.exercise = f"an edit of {exercise}"  # what hangs with it, did not hang before
        try:
            student.start()
        except StudentStopped:
            return
        shown = shown_questions(student, failed)
        hidden = functools.cache(
            lambda: hidden_questions(setting.lesson, student, setting.seed, failed)
        )

        def questions(number: int) -> Iterator[Callable[[], object]]:
            yield functools.partial(student.edit, number)
            yield from shown
            yield from hidden()

        begin, slept, found, look_at = time.process_time(), 0.0, 0, 0.0
        until = time.monotonic() + MOST_SECONDS
        if shown and not _fails(shown[0]):  # whoever throws a coin gets no more throws
            return
        for tried, (number, edit) in enumerate(_in_order(student.edits, raised_at)):
            if tried % LOOK_AFTER == 0 or time.monotonic() > look_at:
                look_at = time.monotonic() + LOOK_SOON
                worked = time.process_time() - begin + student.cpu_seconds
                if max(worked, slept) > SECONDS or time.monotonic() > until:
                    return
            budget.lost.pop(student.exercise, None)  # by the edit before
            left = budget.seconds
            passes = not any(map(_fails, questions(number)))
            slept += left - budget.seconds
            if passes:
                yield edit
                found += 1
            if found == MOST_JUDGED:
                return
