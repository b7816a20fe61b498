"""Collect the hidden tests of a lesson with pytest, once per process.

Collecting the tests takes as long as running them. Each test then runs for many students and edits
in the same process, so it must not keep anything from one run to the next. A test that could do so,
or that pytest would leave out, is reported as a fault of the lesson. Settings in the environment,
plugins and ``conftest.py`` files have no effect.
"""

from __future__ import annotations

import contextlib
import copy
import functools
import hashlib
import inspect
import os
import random
import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from grader.judging.hidden_tests import check_of
from grader.sandbox.student import StudentProxy
from utils.checks import Check

# Pytest plugins that hidden tests do not need.
_NOT_NEEDED = (
    *("assertion", "cacheprovider", "capture", "debugging", "doctest", "faulthandler", "junitxml"),
    *("legacypath", "logging", "pastebin", "recwarn", "reports", "setuponly", "setupplan"),
    *("skipping", "stepwise", "subtests", "terminal", "threadexception", "unittest"),
    "unraisableexception",
)
_OPTIONS = (
    "--collect-only",
    "--noconftest",
    "--import-mode=importlib",
    f"--rootdir={os.sep}",
    "-c",
    os.devnull,
    "-o",
    "markers=judged: belongs to an exercise",
    "-o",
    "empty_parameter_set_mark=fail_at_collect",
    *(option for plugin in _NOT_NEEDED for option in ("-p", f"no:{plugin}")),
)
_JUDGED = "judged"  # the mark that `hidden` returns
_ARGUMENTS = ("student", "seed")
_ALLOWED = "student, seed and the parameters of pytest.mark.parametrize"
_TEST_FUNCTION = re.compile(r"^def (test\w*)\(", re.MULTILINE)
_RANDOM_GENERATORS = (np.random.Generator, np.random.RandomState, random.Random)


class JudgeFault(Exception):
    """The tests themselves could not be run. This is the course's fault, not the student's."""


@dataclass(frozen=True)
class HiddenTest:
    """A hidden test that can run for any student, and more than once.

    Attributes
    ----------
    check : utils.checks.Check
    function : callable
    arguments : dict of str to object
        All arguments except the student.
    takes_student : bool
    """

    check: Check
    function: Callable[..., object]
    arguments: dict[str, object]
    takes_student: bool

    def __call__(self, student: StudentProxy) -> None:
        """Raise an exception for a wrong answer."""
        # Copies, because a test may change its parameters, and later runs need the original ones.
        arguments = {name: _copy(value) for name, value in self.arguments.items()}
        if self.takes_student:
            arguments["student"] = student
        try:
            result = self.function(**arguments)
        except (KeyboardInterrupt, Exception):
            raise
        except BaseException as error:  # such as those of pytest.fail, pytest.skip, pytest.raises
            raise AssertionError(f"{type(error).__name__}: {error}") from error
        if result is not None:
            raise TypeError(
                f"{self.check.name} returned a {type(result).__name__}. A hidden test must return "
                "nothing, and raise an exception for a wrong answer."
            )


def _copy(value: object) -> object:
    try:
        return copy.deepcopy(value)
    except Exception:  # a module, for example, cannot be copied
        return value


@functools.cache
def collect_hidden_tests(file: Path, course_seed: int) -> tuple[HiddenTest, ...]:
    """Return the hidden tests in a file.

    Raises
    ------
    JudgeFault
        If the tests cannot be collected.
    KeyboardInterrupt
        Pytest catches it, so it is raised again here.
    """
    # Verdicts of earlier releases depend on this text, so it must not change.
    text = f"{course_seed} test_{file.parent.name}.py"
    collector = _Collector(int.from_bytes(hashlib.sha256(text.encode()).digest()[:15], "big"))
    # Without this option, pytest searches all parent folders for configuration.
    option = f"--confcutdir={file.parent}"
    with _plain_environment():
        code = int(pytest.main([str(file), option, *_OPTIONS], plugins=[collector]))
    if collector.interrupted:
        raise KeyboardInterrupt
    if code == pytest.ExitCode.OK and not collector.complaints and collector.tests:
        return tuple(collector.tests)
    name = f"{file.parent.name}/{file.name}"
    if code == pytest.ExitCode.OK:
        reason = f"The hidden tests in {name} cannot be used."
    else:
        reason = (
            f"pytest cannot collect the tests in {name} (exit code {code}). Run pytest on this "
            "file to see why."
        )
    raise JudgeFault("\n".join([reason, *dict.fromkeys(collector.complaints)]))


class _Collector:
    """A pytest plugin that stores the hidden tests, which pytest only collects."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self.tests: list[HiddenTest] = []
        self.complaints: list[str] = []
        self.interrupted = False

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Store each test with its arguments."""
        for module in dict.fromkeys(item.module for item in items):
            self.complaints += _complaints_about_module(module, items)
        for item in items:
            if complaint := _complaint_about_test(item):
                self.complaints.append(complaint)
                continue
            arguments = {**item.callspec.params} if hasattr(item, "callspec") else {}
            taken = set(_names_to_fill(item)) - arguments.keys()
            if "seed" in taken:
                arguments["seed"] = self._seed
            self.tests.append(HiddenTest(check_of(item), item.obj, arguments, "student" in taken))

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Record why a test file could not be read."""
        if report.failed:
            self.complaints.append(str(report.longrepr))

    def pytest_internalerror(self, excinfo: pytest.ExceptionInfo) -> bool:
        """Record an error in a hook, and return True to keep pytest from printing it."""
        self.complaints.append(excinfo.exconly())
        return True

    def pytest_keyboard_interrupt(self, excinfo: pytest.ExceptionInfo) -> None:
        """Record whether the run was interrupted by a person and not by pytest itself."""
        self.interrupted = not isinstance(excinfo.value, pytest.Session.Interrupted)


def _complaints_about_module(module: ModuleType, items: list[pytest.Item]) -> Iterator[str]:
    """Yield sentences about tests that pytest leaves out, and about state that runs would share."""
    collected = {part for item in items for part in (item.function, item.cls)}
    source = Path(module.__file__).read_text("utf-8")
    for name, count in Counter(_TEST_FUNCTION.findall(source)).items():
        if count > 1:
            yield f"The file defines {name} {count} times, so only the last one would be run."
    for name, value in vars(module).items():
        if isinstance(value, type):
            if value not in collected and any(map(_is_judged, vars(value).values())):
                yield f"{name} is a class. Write its hidden tests as functions outside a class."
        elif _is_fixture(value):
            yield f"{name} is a fixture. A hidden test may take only {_ALLOWED}."
        elif isinstance(value, _RANDOM_GENERATORS):
            yield (
                f"{name} is a random generator that all students would share. Create a generator "
                "from seed in each hidden test."
            )
        elif _is_judged(value) and value not in collected:
            yield f"{name} is marked as a hidden test, but its name does not begin with test_."


def _complaint_about_test(item: pytest.Item) -> str:
    """Return a sentence about a test that cannot run, or that pytest would not run as written."""
    name = item.originalname
    marks = {mark.name for mark in item.iter_markers()} - {_JUDGED, "parametrize"}
    if item.cls:
        return f"{name} is in a class. Write hidden tests as functions outside a class."
    if not item.get_closest_marker(_JUDGED):
        return f"{name} is not marked with @hidden. Mark it, or rename it if it is not a test."
    if marks:
        names = ", ".join(f"pytest.mark.{name}" for name in sorted(marks))
        return f"{name} is marked with {names}, which has no effect here. Delete this mark."
    if fixtures := _fixtures_of(item):
        return f"{name} needs {fixtures}. A hidden test may take only {_ALLOWED}."
    if inspect.iscoroutinefunction(item.function) or inspect.isasyncgenfunction(item.function):
        return f"{name} is an async function. Write it as an ordinary function."
    try:
        check_of(item)
    except (LookupError, ValueError):
        return (
            f"The title of {name} contains braces that are not {{}}. Write {{{{ and }}}} for "
            "braces in the title of a parametrized test."
        )
    return ""


def _fixtures_of(item: pytest.Item) -> str:
    """Return the names of a test's fixtures from outside its module."""
    # `_complaints_about_module` names the fixtures inside the module.
    module = {name for name, value in vars(item.module).items() if _is_fixture(value)}
    parameters = item.callspec.params if hasattr(item, "callspec") else {}
    allowed = {*parameters, *_ARGUMENTS, *module}
    taken = {*_names_to_fill(item)} - allowed
    # If the test itself takes no fixture, another fixture may still apply to it, such as
    # `setup_function`, to which pytest gives a long name.
    names = taken or {*item.fixturenames} - allowed - {"request"}
    return ", ".join(re.sub(r"^_xunit_(\w+?)_fixture.*", r"\1", name) for name in sorted(names))


def _is_fixture(value: object) -> bool:
    return type(value).__module__ == "_pytest.fixtures"


def _is_judged(value: object) -> bool:
    # `getattr` would create a mark of this name if the value is `pytest.mark`.
    marks = getattr(value, "__dict__", {}).get("pytestmark", ())
    return any(mark.name == _JUDGED for mark in marks)


def _names_to_fill(item: pytest.Item) -> list[str]:
    """Return the names of a test's parameters for which pytest needs a value."""
    kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    return [
        parameter.name
        for parameter in inspect.signature(item.function).parameters.values()
        if parameter.kind in kinds and parameter.default is parameter.empty
    ]


@contextlib.contextmanager
def _plain_environment() -> Iterator[None]:
    """Hide pytest's environment variables inside a with statement."""
    before = {name: text for name, text in os.environ.items() if name.startswith(("PYTEST", "PY_"))}
    for name in before:
        del os.environ[name]
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    try:
        yield
    finally:
        del os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"]
        os.environ.update(before)
