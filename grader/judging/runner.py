"""Run the checks of a lesson in this process, which never executes student code.

Visible checks run as in the notebook. Hidden tests are functions that pytest has collected.
"""

from __future__ import annotations

import contextlib
import functools
import importlib
import itertools
import signal
import sys
import threading
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from types import FrameType
from typing import NoReturn

import numpy as np

from grader.course.lessons import Lesson
from grader.judging.collection import HiddenTest, collect_hidden_tests
from grader.sandbox import Limits, SandboxUnavailable
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.student import StudentProxy
from grader.sandbox.time_budget import Budget
from utils.checks import Check, checks_of
from utils.checks.core import notes_of
from utils.checks.diagnosis import object_to_diagnose
from utils.checks.failures import AnswerTooLarge, CheckFailed, NotYet
from utils.checks.outcomes import Outcome
from utils.checks.run_cache import cached_run

# Limit on the processor seconds of one test in this process, without the student's code. The limit
# also applies to all failed checks of an exercise together, in all runs with the same budget.
TEST_SECONDS = 15.0
# The limit is extended by this time, repeatedly, while a module is being imported.
IMPORT_POLLING_INTERVAL = 0.02
# An exercise is not called again after this many answers that are far too large, because reading
# each one takes seconds.
MAX_TOO_LARGE = 5
# If a check fails, a reply with more bytes than this counts as such an answer. The largest scan
# needs less than 12 MB, even as a list of rows.
MAX_REPLY_BYTES = 12 * 2**20


class JudgeTimeout(Exception):
    """Comparing an answer took longer than it takes for any right answer."""


# Exceptions that a wrong answer may cause in a check. Any other exception may be the check's fault.
EXPECTED_FAILURES = (CheckFailed, StudentError, StudentStopped, JudgeTimeout)


class _Runner:
    """Runs checks one by one, and records the outcome of each."""

    def __init__(
        self,
        student: StudentProxy,
        is_selected: Callable[[Check], bool],
        keep_going: bool = True,
        budget: Budget | None = None,
    ) -> None:
        self.proxy, self.is_selected = student, is_selected
        self.budget = budget or Budget(Limits())
        self.continues, self.keep_going = True, keep_going
        self.outcomes: dict[Check, Outcome] = {}
        self.too_large: Counter[str] = Counter()
        self.sandbox_error = None

    def run_visible(self, check: Check) -> None:
        """Run a visible check."""
        self._run(check, _call_visible_check, check)

    def run_hidden(self, test: HiddenTest) -> None:
        """Run a hidden test."""
        with warnings.catch_warnings():
            # A wrong answer may cause any warning, which would appear on the instructor's terminal.
            warnings.simplefilter("ignore")
            self._run(test.check, test)

    def _run(self, check: Check, call: Callable[..., object], *arguments: object) -> None:
        error = None
        try:
            with self.under_test(check):
                call(self.proxy, *arguments)
        except Exception as caught:
            error = caught
        self.record(check, error)

    @contextlib.contextmanager
    def under_test(self, check: Check) -> Iterator[None]:
        """Set the exercise under test and limit the judge's own processor time, in a with block."""
        self.proxy.exercise = exercise = check.exercise
        if not self.continues:
            raise StudentStopped("Not run: another check has failed.")
        if self.too_large[exercise] >= MAX_TOO_LARGE:
            raise StudentStopped(
                f"Not run: {self.too_large[exercise]} answers to this exercise were far larger "
                "than any right answer."
            )
        seconds_left = TEST_SECONDS - self.budget.judge_seconds[exercise]
        if seconds_left <= 0:
            raise StudentStopped(
                "Not run: comparing earlier answers to this exercise took longer than any right "
                "answer needs."
            )
        start, self.proxy.largest_reply = time.process_time(), 0
        try:
            with (
                self.budget.charge_if_failed(exercise),
                limited_cpu_time(seconds_left),
                np.errstate(all="ignore"),  # a wrong answer may contain any number
            ):
                yield
        except Exception as error:
            used_seconds = time.process_time() - start
            if isinstance(error, JudgeTimeout):  # which the kernel may raise a little early
                used_seconds = max(used_seconds, seconds_left)
            self.budget.judge_seconds[exercise] += used_seconds
            is_large = self.proxy.largest_reply > MAX_REPLY_BYTES
            self.too_large[exercise] += is_large or isinstance(error, AnswerTooLarge)
            raise

    def record(self, check: Check, error: Exception | None) -> None:
        """Record how a check ended."""
        self.continues &= self.keep_going or error is None
        if isinstance(error, SandboxUnavailable):
            self.sandbox_error = error
        if isinstance(error, JudgeTimeout):
            self.proxy.close()  # a call may have been interrupted before its reply was read
        _release_answers(error)
        self.outcomes[check] = Outcome(check, error)


def _release_answers(error: Exception | None) -> None:
    """Remove tracebacks and drawings from an exception and its causes, because they hold answers.

    An answer may take 64 MB, and the outcomes are kept until the whole notebook is judged. If the
    exception is unexpected, the text of its traceback is kept as a note.
    """
    if error is not None and not isinstance(error, EXPECTED_FAILURES):
        error.add_note("".join(traceback.format_tb(error.__traceback__)))
    waiting, seen = [error], set()
    while waiting:
        link = waiting.pop()
        if link is None or id(link) in seen:
            continue
        seen.add(id(link))
        link.__traceback__ = None
        if isinstance(link, CheckFailed):
            link.draw = None  # the judge draws nothing
        waiting += [link.__context__, link.__cause__]
        waiting += [link.reason] if isinstance(link, NotYet) else []


class _UntouchedRunner(_Runner):
    """A runner that records each check as not started, without calling the student's functions."""

    def under_test(self, check: Check) -> NoReturn:
        """Raise the error of an untouched stub."""
        raise StudentError(check.exercise, "NotImplementedError")


def _call_visible_check(student: StudentProxy, check: Check) -> None:
    check.run(getattr(student, object_to_diagnose(check.exercise)))


def visible_calls(
    student: StudentProxy, checks: Iterable[Check]
) -> tuple[Callable[[], object], ...]:
    """Return the visible checks as callables that raise an exception for a wrong answer."""
    return tuple(
        functools.partial(_call_visible_check, student, check) for check in checks if check.is_shown
    )


def hidden_calls(
    lesson: Lesson, student: StudentProxy, seed: int, checks: Iterable[Check]
) -> tuple[Callable[[], object], ...]:
    """Return the hidden tests as callables that raise an exception for a wrong answer."""
    names = {check.name for check in checks if not check.is_shown}
    if not names:
        return ()
    tests = collect_hidden_tests(lesson.tests, seed)
    return tuple(functools.partial(test, student) for test in tests if test.check.name in names)


def every_check(check: Check) -> bool:
    """Return True, which selects every check."""
    return True


def run_checks(
    lesson: Lesson,
    student: StudentProxy,
    seed: int,
    is_selected: Callable[[Check], bool] = every_check,
    keep_going: bool = True,
    budget: Budget | None = None,
) -> list[Outcome]:
    """Run the checks of a lesson.

    Visible checks come first, because their messages show students more. At that point, the
    student's code has not yet received any hidden input.

    Parameters
    ----------
    lesson : grader.course.lessons.Lesson
    student : grader.sandbox.student.StudentProxy
    seed : int
        The course's secret.
    is_selected : callable
        Takes a check and returns whether to run it.
    keep_going : bool
        Whether to continue after a failure. If not, all later checks fail without being run.
    budget : grader.sandbox.time_budget.Budget, optional
        The student's budget, in which failed checks count as failed calls. By default, a new one.

    Returns
    -------
    list of Outcome
        One for each check that was run.

    Raises
    ------
    JudgeFault
        If a check could not be run.
    grader.sandbox.SandboxUnavailable
    """
    return _run_all_checks(lesson, seed, _Runner(student, is_selected, keep_going, budget))


def exercises_with_notes(
    student: StudentProxy, exercises: Iterable[str], budget: Budget
) -> frozenset[str]:
    """Return the exercises whose answers get a note, which costs no points.

    Parameters
    ----------
    student : grader.sandbox.student.StudentProxy
    exercises : iterable of str
    budget : grader.sandbox.time_budget.Budget
        As in `run_checks`.
    """
    runner = _Runner(student, every_check, budget=budget)
    with cached_run():
        for note in itertools.chain.from_iterable(map(notes_of, exercises)):
            runner.run_visible(note)
    outcomes = runner.outcomes.items()
    return frozenset(
        note.exercise for note, outcome in outcomes if isinstance(outcome.failure, CheckFailed)
    )


@functools.cache
def outcomes_of_untouched(lesson: Lesson) -> tuple[Outcome, ...]:
    """Return the outcomes of `run_checks` for an untouched notebook, without running it."""
    return tuple(_run_all_checks(lesson, 0, _UntouchedRunner(None, every_check)))


def _run_all_checks(lesson: Lesson, seed: int, runner: _Runner) -> list[Outcome]:
    importlib.import_module(f"utils.checks.lesson_{lesson.number}")  # registers the checks
    hidden_tests = collect_hidden_tests(lesson.tests, seed)
    with cached_run():
        for exercise in lesson.machine_graded:
            for check in filter(runner.is_selected, checks_of(exercise.name)):
                runner.run_visible(check)
        for test in hidden_tests:
            if runner.is_selected(test.check):
                runner.run_hidden(test)
    if runner.sandbox_error:
        raise runner.sandbox_error
    return [*runner.outcomes.values()]


def _import_depth(frame: FrameType | None) -> int:
    """Return how many frames belong to imports, among a frame and its callers."""
    depth = 0
    while frame is not None:
        depth += frame.f_code.co_filename.startswith("<frozen importlib")
        frame = frame.f_back
    return depth


@contextlib.contextmanager
def limited_cpu_time(seconds: float) -> Iterator[threading.Event]:
    """Raise `JudgeTimeout` after this many processor seconds, inside a with statement.

    Yields
    ------
    threading.Event
        Set when the exception has been raised, even if other code has caught it.
    """
    is_over = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield is_over  # Python can be interrupted only in the main thread
        return

    depth = _import_depth(sys._getframe())

    def raise_timeout(number: int, frame: FrameType | None) -> None:
        if _import_depth(frame) > depth:
            # An interrupted import could leave a module unusable, for all later students as well.
            signal.setitimer(signal.ITIMER_PROF, IMPORT_POLLING_INTERVAL)
            return
        is_over.set()
        raise JudgeTimeout

    before = signal.signal(signal.SIGPROF, raise_timeout)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield is_over
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
