"""Run the tests of a lesson with pytest, here, in a process that no student's code enters.

Nothing from outside has a say: no setting in the environment, no plugin, no ``conftest.py``.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pytest

from grader.course.lessons import Lesson
from grader.sandbox import SandboxUnavailable
from grader.sandbox.student import Student, StudentStopped
from utils.checks.failures import FarTooMuch
from utils.checks.remembering import one_run

# Processor seconds that one test may take here, beside what the student's code takes there.
SECONDS_OF_A_TEST = 30.0
# Answers far larger than any right one that an exercise may give: reading each takes seconds.
MOST_TOO_LARGE = 5
_NOT_NEEDED = ("terminal", "cacheprovider", "logging", "unraisableexception", "threadexception")
_OPTIONS = (
    "--noconftest",
    "--capture=no",
    "--assert=plain",
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


@dataclass(frozen=True)
class Outcome:
    """How one test ended.

    Attributes
    ----------
    name : str
    mark : dict
        What `grader.judging.marks` says about it.
    error : BaseException or None
        Why it failed.
    """

    name: str
    mark: dict
    error: BaseException | None


class _Collector:
    """A pytest plugin: hands the student to the tests and notes how each ended."""

    def __init__(self, student: Student, seed: int, asked: Callable[[dict], bool]) -> None:
        self.proxy, self.course_seed, self.asked = student, seed, asked
        self.collected: list[str] = []
        self.outcomes: dict[str, Outcome] = {}
        self.too_large: Counter[str] = Counter()
        self.broken = None

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out what was not asked for, and ask what students may see first.

        Their words are shown there; by then they have met no hidden question.
        """
        items[:] = [item for item in items if self.asked(_mark(item))]
        items.sort(key=lambda item: not _mark(item)["visible"])

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Note all there is to earn, whatever happens to the tests."""
        self.collected = [item.nodeid for item in session.items]

    @pytest.fixture
    def student(self) -> Student:
        """The functions under test."""
        return self.proxy

    @pytest.fixture
    def seed(self, request: pytest.FixtureRequest) -> int:
        """A number that the course's secret decides, one for each lesson."""
        text = f"{self.course_seed} {request.path.name}"
        return int.from_bytes(hashlib.sha256(text.encode()).digest()[:6], "big")

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> object:
        """Say which exercise is asked about, and let the judge's own work end in time."""
        self.proxy.exercise = exercise = _mark(item)["exercise"]
        if self.too_large[exercise] >= MOST_TOO_LARGE:
            raise StudentStopped(
                f"Not tried: {self.too_large[exercise]} answers of this exercise were far larger "
                "than any right one."
            )
        with _own_time(SECONDS_OF_A_TEST):
            return (yield)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo
    ) -> pytest.TestReport:
        """Note how a test ended, and spare pytest its tracebacks: half of its time."""
        error = call.excinfo.value if call.excinfo else None
        if call.when == "call" or error:
            self.too_large[_mark(item)["exercise"]] += isinstance(error, FarTooMuch)
            if isinstance(error, SandboxUnavailable):
                self.broken = error
            if isinstance(error, JudgeTimeout):
                self.proxy.close()  # it may have been in the middle of a sentence
            self.outcomes[item.nodeid] = Outcome(item.name, _mark(item), error)
        outcome = "failed" if error else "passed"
        return pytest.TestReport(item.nodeid, item.location, {}, outcome, None, call.when)


def everything(mark: dict) -> bool:
    """Ask all there is to ask."""
    return True


def run_tests(
    lesson: Lesson, student: Student, seed: int, asked: Callable[[dict], bool] = everything
) -> list[Outcome]:
    """Run the tests of a lesson.

    Parameters
    ----------
    lesson : grader.course.lessons.Lesson
    student : grader.sandbox.student.Student
    seed : int
        The course's secret.
    asked : callable
        Takes what `grader.judging.marks` says about a test: whether to run it.

    Returns
    -------
    list of Outcome
        One for each test that was asked for.

    Raises
    ------
    JudgeFault
        If not every test could be run.
    grader.sandbox.SandboxUnavailable
    KeyboardInterrupt
        pytest would keep it to itself.
    """
    collector = _Collector(student, seed, asked)
    with _plain_environment(), one_run():
        code = pytest.main([str(lesson.tests), *_OPTIONS], plugins=[collector])
    if collector.broken:
        raise collector.broken
    if code == pytest.ExitCode.INTERRUPTED:
        raise KeyboardInterrupt
    missing = len(collector.collected) - len(collector.outcomes)
    if not collector.collected or missing:
        raise JudgeFault(
            f"pytest ran {len(collector.outcomes)} of {len(collector.collected)} tests in "
            f"{lesson.tests.name} (exit code {int(code)}). Run it by hand to see why."
        )
    return [collector.outcomes[item] for item in collector.collected]


def _mark(item: pytest.Item) -> dict:
    return item.get_closest_marker("judged").kwargs


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
