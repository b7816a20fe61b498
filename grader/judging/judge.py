"""Judge one notebook: run the tests of its lesson against the student's functions.

The tests are pytest tests and run here, in a process that a student's code never enters.
"""

import functools
import hashlib
import os
import time
from pathlib import Path

import pytest

from grader.course.lessons import find_lesson
from grader.course.paths import PROJECT
from grader.intake.notebook import read_file, read_notebook
from grader.judging.verdict import ExerciseResult, TestResult, Verdict
from grader.sandbox import SandboxUnavailable
from grader.sandbox.student import Student, StudentError, StudentStopped
from utils.checks import CheckFailed
from utils.checks.tips import tip_for
from utils.notebooks.reading import UnreadableNotebook

_PYTEST = (
    "-p",
    "no:terminal",
    "-p",
    "no:cacheprovider",
    "-p",
    "no:logging",
    "-p",
    "no:unraisableexception",
    "-p",
    "no:threadexception",
    "--capture=no",
    "--assert=plain",
    "--import-mode=importlib",
    "-c",
    os.devnull,
    "-o",
    "markers=judged: belongs to an exercise",
)


class UnknownLesson(Exception):
    """A notebook does not say which lesson it is; `str()` is the sentence to show."""


def judge(path, seed, sandbox, lesson=None, student="", limits=None):
    """Judge one notebook.

    Parameters
    ----------
    path : pathlib.Path
    seed : int
        The course's secret; the hidden scenes are drawn from it.
    sandbox : grader.sandbox.Sandbox
    lesson : grader.course.lessons.Lesson, optional
        By default taken from the notebook's name or its metadata.
    student : str, optional
        Identity to note in the verdict.
    limits : grader.sandbox.Limits, optional

    Returns
    -------
    grader.judging.verdict.Verdict
        Whatever the student's code did.

    Raises
    ------
    UnknownLesson
    grader.sandbox.SandboxUnavailable
    """
    begin = time.perf_counter()
    path = Path(path)
    lesson = lesson or find_lesson(path.stem)
    try:
        notebook = read_notebook(path)
    except UnreadableNotebook as error:
        if lesson is None:
            raise UnknownLesson(str(error)) from None
        results, problems = None, [str(error)]
    else:
        lesson = lesson or find_lesson(notebook.lesson_name)
        if lesson is None:
            raise UnknownLesson(
                f"{path.name}: cannot tell which lesson this is. Give the file the name it was "
                "released under, such as 06_filter_ground.ipynb."
            )
        with Student(
            notebook.cells, lesson.names, sandbox, limits, lesson.header.forbidden
        ) as proxy:
            results = run_tests(lesson, proxy, seed)
            problems = proxy.problems
    exercises = tuple(_score(exercise, results) for exercise in lesson.machine_graded)
    return Verdict(
        lesson.name,
        student,
        round(sum(item.score for item in exercises), 2),
        sum(item.max_score for item in exercises),
        exercises,
        tuple(problems),
        round(time.perf_counter() - begin, 3),
        verdict_key(path, lesson, seed, student),
    )


def verdict_key(path, lesson, seed, student=""):
    """Fingerprint of all that a verdict depends on."""
    digest = hashlib.sha256(f"{seed} {student} {lesson.name} {rules_key()}".encode())
    try:
        digest.update(read_file(Path(path)))
    except UnreadableNotebook as error:
        digest.update(str(error).encode())
    return digest.hexdigest()


@functools.cache
def rules_key():
    """Fingerprint of the tests, the checks, the judge and the points."""
    digest = hashlib.sha256()
    for folder, pattern in (("grader", "*.py"), ("utils", "*.py"), ("notebooks", "*.ipynb")):
        for path in sorted((PROJECT / folder).rglob(pattern)):
            digest.update(f"{path.relative_to(PROJECT)}\0".encode() + path.read_bytes())
    return digest.hexdigest()


class _Collector:
    """A pytest plugin: hands the student to the tests and notes how each ended."""

    def __init__(self, proxy, seed):
        self.proxy, self.course_seed = proxy, seed
        self.results, self.broken = [], None

    def pytest_configure(self, config):
        """Spare pytest its long tracebacks, which nobody reads: most of a judge's time."""
        config.option.tbstyle = "native"

    @pytest.fixture
    def student(self):
        """The functions under test."""
        return self.proxy

    @pytest.fixture
    def seed(self, request):
        """A number that the course's secret decides, one for each lesson."""
        text = f"{self.course_seed} {request.path.name}"
        return int.from_bytes(hashlib.sha256(text.encode()).digest()[:6], "big")

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item, call):
        report = yield
        if report.when == "call" or report.failed:
            error = call.excinfo.value if call.excinfo else None
            if isinstance(error, SandboxUnavailable):
                self.broken = error
            self.results.append((item.name, item.get_closest_marker("judged").kwargs, error))
        return report


def run_tests(lesson, proxy, seed):
    """Run the tests of a lesson.

    Parameters
    ----------
    lesson : grader.course.lessons.Lesson
    proxy : grader.sandbox.student.Student
    seed : int
        The course's secret.

    Returns
    -------
    list of (str, dict, Exception or None)
        Name, mark and fault of each test.
    """
    collector = _Collector(proxy, seed)
    plugins = os.environ.get("PYTEST_DISABLE_PLUGIN_AUTOLOAD")
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    try:
        code = pytest.main([str(lesson.tests), *_PYTEST], plugins=[collector])
    finally:
        if plugins is None:
            del os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"]
    if collector.broken:
        raise collector.broken
    if code not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED) or not collector.results:
        raise RuntimeError(
            f"pytest could not run {lesson.tests.name} (exit code {code!r}): "
            f"run it by hand to see why"
        )
    return collector.results


def _score(exercise, results):
    """`ExerciseResult` of one exercise; nothing was tried where `results` is None."""
    if results is None:
        return ExerciseResult(exercise.name, 0.0, exercise.points, ())
    mine = [result for result in results if result[1]["exercise"] == exercise.name]
    whole = sum(mark["weight"] for _, mark, _ in mine)
    if not whole:
        raise RuntimeError(f"No test belongs to {exercise.name}: its points cannot be earned")
    tests = tuple(
        _result(name, mark, error, exercise.points * mark["weight"] / whole)
        for name, mark, error in mine
    )
    passed = sum(mark["weight"] for _, mark, error in mine if error is None)
    return ExerciseResult(
        exercise.name, round(exercise.points * passed / whole, 2), exercise.points, tests
    )


def _result(name, mark, error, points):
    passed, points = error is None, round(points, 2)
    return TestResult(
        name,
        mark["title"],
        passed,
        points if passed else 0.0,
        points,
        "" if passed else _message(mark, error),
        mark["visible"],
    )


def _message(mark, error):
    """What a student reads about a failed test."""
    lines = []
    if isinstance(error, CheckFailed):
        lines.append(error.message)
        if error.yours is not None:
            expected = f"; expected: {error.expected}" if error.expected is not None else ""
            lines.append(f"Yours: {error.yours}{expected}")
    elif isinstance(error, StudentError) and error.type_name == "NotImplementedError":
        lines.append(
            f"{mark['exercise']} still raises NotImplementedError: it was not written, "
            "or its cell was lost."
        )
        return lines[0]
    elif isinstance(error, StudentError):
        lines.append(str(error))
        lines.append(tip_for(error.type_name, error.message))
    elif isinstance(error, StudentStopped):
        return str(error)
    else:
        lines.append(
            "The answer could not be compared with the right one "
            f"({type(error).__name__}): is it what the docstring promises?"
        )
    lines.append(f"Hint: {mark['hint']}")
    return "\n".join(line for line in lines if line)
