"""Ask the checks of a lesson here, in a process that no student's code enters.

What students see runs as in their notebook; what they do not see are tests of pytest. Nothing from
outside has a say: no setting in the environment, no plugin, no ``conftest.py``.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import importlib
import inspect
import os
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import NoReturn

import pytest

from grader.course.lessons import Lesson
from grader.judging.hidden_tests import check_of
from grader.sandbox import SandboxUnavailable
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.student import StudentProxy
from utils.checks import Check, checks_of
from utils.checks.diagnosis import asked_through
from utils.checks.failures import FarTooMuch
from utils.checks.outcomes import Outcome
from utils.checks.run_cache import one_run

# Processor seconds that one test may take here, beside what the student's code takes there.
SECONDS_OF_A_TEST = 30.0
# Answers far larger than any right one that an exercise may give: reading each takes seconds.
MOST_TOO_LARGE = 5
# Plugins of pytest's that no hidden test needs. Each takes a quarter of a millisecond.
_NOT_NEEDED = (
    *("assertion", "cacheprovider", "capture", "debugging", "doctest", "faulthandler", "junitxml"),
    *("legacypath", "logging", "pastebin", "recwarn", "reports", "setuponly", "setupplan"),
    *("skipping", "stepwise", "subtests", "terminal", "threadexception", "unittest"),
    "unraisableexception",
)
_OPTIONS = (
    "--noconftest",
    "--import-mode=importlib",
    f"--rootdir={os.sep}",
    "-c",
    os.devnull,
    "-o",
    "markers=judged: belongs to an exercise",
    *(option for plugin in _NOT_NEEDED for option in ("-p", f"no:{plugin}")),
)


class JudgeTimeout(Exception):
    """Comparing an answer took longer than any right answer needs."""


class JudgeFault(Exception):
    """The tests themselves could not be run; the fault is ours."""


class _Asking:
    """Asks a student one check after another, and notes how each ended.

    Also a pytest plugin, for the checks that students do not see.
    """

    def __init__(
        self,
        student: StudentProxy,
        seed: int,
        asked: Callable[[Check], bool],
        to_the_end: bool = True,
    ) -> None:
        self.proxy, self.course_seed, self.asked = student, seed, asked
        self.goes_on, self.to_the_end = True, to_the_end
        self.tests = 0
        self.outcomes: dict[Check, Outcome | None] = {}
        self.too_large: Counter[str] = Counter()
        self.broken = self.interrupted = None
        self.said: list[str] = []

    def show(self, check: Check) -> None:
        """Ask a check that students see."""
        error = None
        try:
            with self.about(check):
                check.run(getattr(self.proxy, asked_through(check.exercise)))
        except Exception as caught:
            error = caught
        self.note(check, error)

    @contextlib.contextmanager
    def about(self, check: Check) -> Iterator[None]:
        """Say which exercise is asked about, and let the judge's own work end in time."""
        self.proxy.exercise = exercise = check.exercise
        if not self.goes_on:
            raise StudentStopped("Not tried: another check has failed.")
        if self.too_large[exercise] >= MOST_TOO_LARGE:
            raise StudentStopped(
                f"Not tried: {self.too_large[exercise]} answers of this exercise were far larger "
                "than any right one."
            )
        with _own_time(SECONDS_OF_A_TEST):
            yield

    def note(self, check: Check, error: Exception | None) -> None:
        """Note how a check ended."""
        self.too_large[check.exercise] += isinstance(error, FarTooMuch)
        self.goes_on &= self.to_the_end or error is None
        if isinstance(error, SandboxUnavailable):
            self.broken = error
        if isinstance(error, JudgeTimeout):
            self.proxy.close()  # it may have been in the middle of a sentence
        self.outcomes[check] = Outcome(check, error)

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out what was not asked for; note all there is to earn, whatever happens to it."""
        self.tests = len(items)
        items[:] = [item for item in items if self.asked(check_of(item))]
        self.outcomes |= {check_of(item): None for item in items}

    @pytest.fixture
    def student(self) -> StudentProxy:
        """The functions under test."""
        return self.proxy

    @pytest.fixture
    def seed(self, request: pytest.FixtureRequest) -> int:
        """A number that the course's secret decides, one for each lesson."""
        # Verdicts of earlier releases rest on this very text.
        text = f"{self.course_seed} test_{request.path.parent.name}.py"
        return int.from_bytes(hashlib.sha256(text.encode()).digest()[:15], "big")

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> object:
        """Ask a check that students do not see."""
        with self.about(check_of(item)):
            return (yield)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo
    ) -> pytest.TestReport:
        """Note how a test ended, and spare pytest its tracebacks: half of its time."""
        error = call.excinfo.value if call.excinfo else None
        if call.when == "call" or error:
            self.note(check_of(item), error)
        outcome = "failed" if error else "passed"
        return pytest.TestReport(item.nodeid, item.location, {}, outcome, None, call.when)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Note why a file could not be read."""
        if report.failed:
            self.said.append(str(report.longrepr))

    def pytest_keyboard_interrupt(self, excinfo: pytest.ExceptionInfo) -> None:
        """Note whether a person stopped it, or pytest itself did."""
        self.interrupted = not isinstance(excinfo.value, pytest.Session.Interrupted)


class _NotAsking(_Asking):
    """Knows the answer to each check without asking: nobody has written anything yet."""

    def about(self, check: Check) -> NoReturn:
        """Raise what a function raises that stands as it was handed out."""
        raise StudentError(check.exercise, "NotImplementedError")


class _Collecting(_Asking):
    """Keeps the checks that students do not see, to be asked later, as often as one likes."""

    def __init__(self, student: StudentProxy, seed: int, asked: Callable[[Check], bool]) -> None:
        super().__init__(student, seed, asked)
        self.questions: list[Callable[[], object]] = []

    def pytest_pyfunc_call(self, pyfuncitem: pytest.Function) -> bool:
        """Keep a check, and say that it has been asked."""
        names = inspect.signature(pyfuncitem.obj).parameters
        arguments = {name: pyfuncitem.funcargs[name] for name in names}
        self.questions.append(functools.partial(pyfuncitem.obj, **arguments))
        return True


def shown_questions(
    student: StudentProxy, checks: Iterable[Check]
) -> tuple[Callable[[], object], ...]:
    """Those of some checks that students see, each as something that raises at a wrong answer."""
    return tuple(
        functools.partial(check.run, getattr(student, asked_through(check.exercise)))
        for check in checks
        if check.is_shown
    )


def hidden_questions(
    lesson: Lesson, student: StudentProxy, seed: int, checks: Iterable[Check]
) -> tuple[Callable[[], object], ...]:
    """Those of some checks that students do not see, as `shown_questions`; see `run_tests`."""
    wanted = {check.name for check in checks if not check.is_shown}
    if not wanted:
        return ()
    collecting = _Collecting(student, seed, lambda check: check.name in wanted)
    _ask_hidden(lesson, collecting)
    return tuple(collecting.questions)


def everything(check: Check) -> bool:
    """Ask all there is to ask."""
    return True


def run_tests(
    lesson: Lesson,
    student: StudentProxy,
    seed: int,
    asked: Callable[[Check], bool] = everything,
    to_the_end: bool = True,
) -> list[Outcome]:
    """Ask the checks of a lesson.

    Those that students may see come first: more is told of them, and by then the student's code
    has met no hidden question.

    Parameters
    ----------
    lesson : grader.course.lessons.Lesson
    student : grader.sandbox.student.StudentProxy
    seed : int
        The course's secret.
    asked : callable
        Takes a check: whether to ask it.
    to_the_end : bool
        Whether to go on once a check has failed; else those after it fail untried.

    Returns
    -------
    list of Outcome
        One for each check that was asked.

    Raises
    ------
    JudgeFault
        If not every check could be asked.
    grader.sandbox.SandboxUnavailable
    KeyboardInterrupt
        pytest would keep it to itself.
    """
    return _run(lesson, _Asking(student, seed, asked, to_the_end))


@functools.cache
def tests_of_nothing(lesson: Lesson) -> tuple[Outcome, ...]:
    """What `run_tests` finds where nobody has written anything, without a scene or a process."""
    return tuple(_run(lesson, _NotAsking(None, 0, everything)))


def _run(lesson: Lesson, asking: _Asking) -> list[Outcome]:
    importlib.import_module(f"utils.checks.lesson_{lesson.number}")  # and no other lesson's
    with one_run():
        for exercise in lesson.machine_graded:
            for check in filter(asking.asked, checks_of(exercise.name)):
                asking.show(check)
        code = _ask_hidden(lesson, asking)
    if asking.broken:
        raise asking.broken
    if asking.interrupted:
        raise KeyboardInterrupt
    missing = [check.name for check, outcome in asking.outcomes.items() if outcome is None]
    if not asking.tests or missing:
        raise JudgeFault(
            f"pytest ran {asking.tests - len(missing)} of {asking.tests} tests in "
            f"{lesson.name}/{lesson.tests.name} (exit code {code}). Run it by hand to see why."
            + "".join(f"\n{said}" for said in asking.said)
        )
    return [*asking.outcomes.values()]


def _ask_hidden(lesson: Lesson, asking: _Asking) -> int:
    """Have pytest ask what students do not see; its exit code."""
    # Else pytest looks at all that lies in each folder above.
    alone = f"--confcutdir={lesson.tests.parent}"
    with _plain_environment():
        return int(pytest.main([str(lesson.tests), alone, *_OPTIONS], plugins=[asking]))


@contextlib.contextmanager
def _plain_environment() -> Iterator[None]:
    """No setting of pytest's from outside, while it lasts."""
    before = {name: text for name, text in os.environ.items() if name.startswith(("PYTEST", "PY_"))}
    for name in before:
        del os.environ[name]
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    try:
        yield
    finally:
        del os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"]
        os.environ.update(before)


@contextlib.contextmanager
def _own_time(seconds: float) -> Iterator[None]:
    """Raise `JudgeTimeout` once this process has worked for so long; waiting does not count."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only there can Python be interrupted
        return

    def stop(*signal_and_frame: object) -> None:
        raise JudgeTimeout

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
