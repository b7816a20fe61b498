"""Look for a single edit that makes a wrong answer right.

The search applies one edit after another to the student's functions (see `utils.notebooks.edits`)
and repeats the checks that the answer failed, in one process unless an edit ends it. If these
checks pass, the edited notebook is judged like a submission, including hidden tests. If it then
earns full marks, the answer is proven to have a single slip, and the student keeps part of the
points.

An empty answer gains nothing, because no edit repairs it. An answer that returns guesses gains
nothing either, because an edit would have to make every guess right.

Clara (Gulwani, Radiček and Zuleger, PLDI 2018) and Refactory (Hu et al., ASE 2019) use the answers
of other students for repairs. This search does not need them, because the checks decide.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from grader.course.lessons import Lesson
from grader.course.rules import ONE_SLIP_KEEPS
from grader.intake.preflight import cells_as_released
from grader.judging.error_carried_forward import CarriedForwardResult
from grader.judging.mistake_diagnosis import mistake_explains
from grader.judging.program_run import JudgingContext, RunResults, run_program
from grader.judging.runner import hidden_calls, visible_calls
from grader.sandbox import Limits
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.program import Program, cell_and_line
from grader.sandbox.student import CALL_TIMEOUT, StudentProxy
from grader.sandbox.time_budget import Budget
from utils.checks.diagnosis import Mistake
from utils.checks.outcomes import Outcome
from utils.checks.run_cache import cached_run

# Processor seconds of the student's code after which only the likeliest edits are tried.
FURTHER_EDITS_SECONDS = 1.0
# Limit on elapsed seconds, because code that sleeps in each call uses little processor time. The
# time for which code waits for a processor does not count; see `Budget.postpone_deadline`.
MAX_SECONDS = 300.0
# Limit per call, because an edit may create an endless loop. A right answer needs less time.
CALL_SECONDS = 0.25
# Limits per call in the first check, once an edit has not finished there. The second limit applies
# if the answer itself does not finish, because most of its edits then do not finish either. In
# lesson 12, a right answer needs half of the first limit.
SHORT_CALL_SECONDS, SHORTEST_CALL_SECONDS = CALL_SECONDS / 4, CALL_SECONDS / 16
# Edits may end at most this many worker processes. The time limit is usually reached first.
MAX_RESTARTS = 100
# The search stops after it has found this many edits that pass the failed checks.
MAX_JUDGED_EDITS = 3
# `ModuleNotFoundError` is not listed, because deleting a progress bar may make an answer right.
UNREPAIRABLE_ERRORS = ("NotImplementedError", "ImportError")
# The time is checked only after this many edits, because reading the processor's clock takes longer
# than most edits. It is also checked after this many seconds, because an edit may loop endlessly.
EDITS_PER_POLL = 16
POLLING_INTERVAL = 0.1


@dataclass(frozen=True)
class SearchLimits:
    """Limits on the search for one exercise.

    The search tries a fixed number of edits, so that marks do not depend on the speed and the load
    of the machine. The limit on processor time protects the judge against expensive edits.

    Attributes
    ----------
    likeliest_edits : int
        Number of edits that are tried even after `FURTHER_EDITS_SECONDS`.
    cpu_seconds : float
        Processor seconds for all edits, in the judge and the sandbox together.
    """

    likeliest_edits: int
    cpu_seconds: float


FULL_SEARCH = SearchLimits(320, 16.0)
# For an exercise whose failed calls, or whose comparisons, have used up the time of one call. Calls
# with edits are then slow as well, and most are interrupted after `SHORTEST_CALL_SECONDS`.
SEARCH_IN_SLOW_CODE = SearchLimits(128, 4.0)
# For an exercise that already earns more than a slip keeps. An edit then only explains the mistake.
SEARCH_WITHOUT_POINTS = SearchLimits(0, 2.0)


@dataclass(frozen=True)
class Repair:
    """One edit that makes an answer right.

    Attributes
    ----------
    cell : int
        Number of the code cell.
    line : int
        Number of the first line that changes.
    before, after : str
        The lines that change, and their new text.
    """

    cell: int
    line: int
    before: str
    after: str


def find_slips(
    context: JudgingContext,
    program: Program,
    results: RunResults,
    carried: dict[str, CarriedForwardResult],
) -> dict[str, Repair | Mistake]:
    """Return the proven slips of exercises that lost points, by the exercise's name.

    A slip is the edit that repairs the exercise, or the named mistake that explains all its wrong
    answers. If the notebook's own cells do not finish, no edit is tried, because each exercise
    would have to wait for them again.
    """
    slips = {}
    if context.budget and not context.budget.cells_finish:
        return slips
    for exercise in context.lesson.machine_graded if ONE_SLIP_KEEPS else ():
        mistake = results.mistakes.get(exercise.name)
        improved = carried.get(exercise.name)
        outcomes = improved.outcomes if improved else results.outcomes_of(exercise.name)
        failed = tuple(outcome for outcome in outcomes if outcome.failure)
        if failed and not any(map(_is_unrepairable, failed)):
            judged_program = improved.program if improved else program
            failed_checks = frozenset(outcome.check for outcome in failed)
            limits = FULL_SEARCH
            if _earned_share(outcomes) >= ONE_SLIP_KEEPS:
                limits = SEARCH_WITHOUT_POINTS
            elif _has_used_its_time(context, exercise.name):
                limits = SEARCH_IN_SLOW_CODE
            if repair := find_repair(context, judged_program, exercise.name, failed, limits):
                slips[exercise.name] = repair
            elif (
                mistake
                and not (mistake.is_cheap or mistake.is_the_task or improved)
                and mistake_explains(context, program, exercise.name, mistake, failed_checks)
            ):
                slips[exercise.name] = mistake
    return slips


def _has_used_its_time(context: JudgingContext, exercise: str) -> bool:
    """Return whether failed calls, or the comparison of answers, used up the time of one call."""
    if context.budget is None:
        return False
    limit = (context.limits or Limits()).call_seconds
    budget = context.budget
    return max(budget.failed_seconds.get(exercise, 0.0), budget.judge_seconds[exercise]) >= limit


def _earned_share(outcomes: Sequence[Outcome]) -> float:
    """Return the share of an exercise's points that the passed checks earn."""
    earned = sum(outcome.check.weight for outcome in outcomes if not outcome.failure)
    return earned / sum(outcome.check.weight for outcome in outcomes)


def _is_unrepairable(outcome: Outcome) -> bool:
    """Return whether a check failed because of an unwritten function or a forbidden import.

    A forbidden import is not a slip: the function would not work without that line.
    """
    failure = outcome.failure
    return isinstance(failure, StudentError) and failure.type_name in UNREPAIRABLE_ERRORS


def _raising_lines(failed: tuple[Outcome, ...]) -> frozenset[tuple[int, int]]:
    """Return the cell and line numbers where student code raised, or called code that raised."""
    errors = [outcome.failure for outcome in failed if isinstance(outcome.failure, StudentError)]
    locations = [
        location for error in errors for location in (error.place, error.call_place) if location
    ]
    return frozenset(filter(None, map(cell_and_line, locations)))


def find_repair(
    context: JudgingContext,
    program: Program,
    exercise: str,
    failed: tuple[Outcome, ...],
    search_limits: SearchLimits = FULL_SEARCH,
) -> Repair | None:
    """Return an edit that gives an exercise full marks, or None if none was found.

    Parameters
    ----------
    context : grader.judging.program_run.JudgingContext
    program : grader.sandbox.program.Program
        The notebook.
    exercise : str
    failed : tuple of utils.checks.outcomes.Outcome
        Outcomes of the checks that the exercise failed.
    search_limits : SearchLimits
    """
    edits = _passing_edits(context, program, exercise, failed, search_limits)
    for cell, first, last, text in edits:
        program_with_edit = program.edited(cell, first, last, text)
        results = run_program(
            context, program_with_edit, lambda check: check.exercise == exercise, keep_going=False
        )
        if not results.fault and not any(outcome.failure for outcome in results.outcomes):
            before = program.cells[cell - 1].split("\n")[first - 1 : last]
            return Repair(cell, first, "\n".join(before), text)
    return None


def _sort_by_likelihood(
    edits: Sequence[tuple[int, int, int, str]], failed: tuple[Outcome, ...]
) -> list[tuple[int, tuple[int, int, int, str]]]:
    """Return numbered edits in the order in which to try them.

    Three kinds of edits come first: edits of lines that raised an exception, edits that end a
    function that had to be stopped, and edits that return a value instead of None.
    """
    raised_at = _raising_lines(failed)
    was_stopped = any(_was_stopped(outcome.failure) for outcome in failed)
    returned_none = any(getattr(outcome.failure, "yours", "") == "None" for outcome in failed)

    def is_unlikely(numbered: tuple[int, tuple[int, int, int, str]]) -> bool:
        cell, first, last, text = numbered[1]
        words = text.split()
        ends = was_stopped and words[-1:] in (["return"], ["break"])
        returns = returned_none and words[:1] == ["return"] and len(words) > 1
        return not (ends or returns) and not any(
            cell == raising_cell and first <= line <= last for raising_cell, line in raised_at
        )

    return sorted(enumerate(edits), key=is_unlikely)


def _unchanged_cells(lesson: Lesson, program: Program) -> frozenset[int]:
    """Return the numbers of the cells that the student did not change."""
    released_sources = {cell.source.strip() for cell in cells_as_released(lesson)}
    cells = enumerate(program.cells, start=1)
    return frozenset(number for number, cell in cells if cell.strip() in released_sources)


class _FailedChecks:
    """The checks that an answer failed: first visible checks, then hidden tests.

    Parameters
    ----------
    context : grader.judging.program_run.JudgingContext
    student : grader.sandbox.student.StudentProxy
    budget : grader.sandbox.time_budget.Budget
        The student's remaining time.
    failed : tuple of utils.checks.outcomes.Outcome
    """

    def __init__(
        self,
        context: JudgingContext,
        student: StudentProxy,
        budget: Budget,
        failed: tuple[Outcome, ...],
    ) -> None:
        checks = [outcome.check for outcome in failed]
        self._student, self._budget = student, budget
        self._first_seconds = CALL_SECONDS
        self._seconds_after_hang = SHORTEST_CALL_SECONDS
        self._visible = visible_calls(student, checks)
        self._hidden = functools.cache(
            lambda: hidden_calls(context.lesson, student, context.seed, checks)
        )

    def __iter__(self) -> Iterator[Callable[[], object]]:
        yield from self._visible
        yield from self._hidden()

    def fail_without_edit(self) -> bool:
        """Return whether the answer without an edit fails the first check."""
        fails = self.first_check_fails()
        if self._first_seconds == CALL_SECONDS:  # unchanged, because the check was not stopped
            self._seconds_after_hang = SHORT_CALL_SECONDS
        return fails

    def first_check_fails(self) -> bool:
        """Return whether the first check fails.

        An edit that causes an endless loop usually causes it in this check. After the first such
        edit, the time limit here is much shorter.
        """
        self._student.interrupts_after = self._first_seconds
        with cached_run():
            failure = _catch_failure(next(iter(self)))
        if _was_stopped(failure):
            self._first_seconds = self._seconds_after_hang
        return failure is not None

    def pass_with(self, number: int) -> bool:
        """Return whether an edit passes all checks, within a time limit for each call.

        On the large input of a hidden test, even a right answer may exceed this limit. An edit
        that does not finish there counts as passing, and the full judgement decides.
        """
        self._budget.failed_seconds.pop(self._student.exercise, None)
        self._student.edit(number)
        if self.first_check_fails() or self._student.edit_failed:
            return False
        self._student.interrupts_after = CALL_SECONDS
        with cached_run():  # a new cache, because each edit gives other answers
            for index, call in enumerate(self):
                failure = _catch_failure(call) if index else None
                if failure is not None:
                    return index >= len(self._visible) and _was_stopped(failure)
        return True


def _catch_failure(call: Callable[[], object]) -> Exception | None:
    try:
        call()
    except Exception as error:  # a wrong answer may cause any exception in a check
        return error
    return None


def _was_stopped(failure: Exception | None) -> bool:
    """Return whether a call did not end and had to be stopped or interrupted.

    A check may wrap the original exception in another one.
    """
    original = failure and failure.__context__
    return any(
        isinstance(error, StudentStopped)
        or (isinstance(error, StudentError) and error.type_name == CALL_TIMEOUT)
        for error in (failure, original)
    )


def _passing_edits(
    context: JudgingContext,
    program: Program,
    exercise: str,
    failed: tuple[Outcome, ...],
    search_limits: SearchLimits,
) -> Iterator[tuple[int, int, int, str]]:
    """Yield edits that pass the checks that the answer failed, at most `MAX_JUDGED_EDITS`."""
    limits = context.limits or Limits()
    seconds = min(2 * CALL_SECONDS, limits.call_seconds)
    limits = replace(limits, call_seconds=seconds, restarts=MAX_RESTARTS)
    budget = context.budget or Budget(limits)
    with StudentProxy(program, context.sandbox, limits, budget, exercise) as student:
        # A separate name, so that a stopped edit does not count against the student's own answer.
        student.exercise = f"an edit of {exercise}"
        try:
            student.start()
        except StudentStopped:
            return
        judge_start, student_start = time.process_time(), student.cpu_seconds
        sleep_seconds, yielded_count, next_poll = 0.0, 0, 0.0
        last_second = budget.seconds_to_deadline() - MAX_SECONDS
        failed_checks = _FailedChecks(context, student, budget, failed)
        # An answer that passes now but failed before depends on chance, and gets no second try.
        if not failed_checks.fail_without_edit():
            return
        released_cells = _unchanged_cells(context.lesson, program)
        edits = [
            (number, edit)
            for number, edit in _sort_by_likelihood(student.edits, failed)
            if edit[0] not in released_cells
        ]
        for edit_count, (number, edit) in enumerate(edits):
            if edit_count % EDITS_PER_POLL == 0 or time.monotonic() > next_poll:
                next_poll = time.monotonic() + POLLING_INTERVAL
                student_seconds = student.cpu_seconds - student_start
                cpu_seconds = student_seconds + time.process_time() - judge_start
                if max(cpu_seconds, sleep_seconds) > search_limits.cpu_seconds:
                    return
                is_further = edit_count >= search_limits.likeliest_edits
                if is_further and max(student_seconds, sleep_seconds) > FURTHER_EDITS_SECONDS:
                    return
                if budget.seconds_to_deadline() < last_second:
                    budget.starved = True  # the mark is not final
                    return
            seconds_left = budget.seconds
            passes = failed_checks.pass_with(number)
            sleep_seconds += seconds_left - budget.seconds
            if passes:
                before = time.process_time()
                yield edit
                judge_start += time.process_time() - before  # judging the edit has its own limits
                yielded_count += 1
            if yielded_count == MAX_JUDGED_EDITS:
                return
