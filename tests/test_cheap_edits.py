"""No edit makes a right answer of one that does not look at its task."""

import ast
import contextlib
import inspect
import signal
import warnings

import pytest

from grader.course.lessons import lesson_of
from grader.judging.asking import hidden_questions, run_tests, shown_questions
from tests import test_cheap
from tests.students import student_with, walled
from utils.notebooks import slicing
from utils.notebooks.edits import edits_of

SECONDS = 2  # for what an edit has made endless


def sources():
    """Each function of the table's module, by where its code begins."""
    tree = ast.parse(inspect.getsource(test_cheap))
    kinds = (ast.Lambda, ast.FunctionDef)
    return {(node.lineno, type(node)): [] for node in ast.walk(tree) if isinstance(node, kinds)} | {
        (node.lineno, type(node)): node for node in ast.walk(tree) if isinstance(node, kinds)
    }


SOURCES = sources()


def as_text(function):
    """A function of the table as a definition of its own, and the names that it may use."""
    kind = ast.Lambda if function.__name__ == "<lambda>" else ast.FunctionDef
    node = SOURCES[function.__code__.co_firstlineno, kind]
    closure = inspect.getclosurevars(function).nonlocals
    if kind is ast.FunctionDef:
        return ast.unparse(node), function.__globals__ | closure
    text = f"def answer({ast.unparse(node.args)}):\n    return {ast.unparse(node.body)}"
    return text, function.__globals__ | closure


def edited(function):
    """All functions that are one edit away from a function of the table."""
    text, names = as_text(function)
    statements, _ = slicing.parse_notebook([text])
    for edit in edits_of([text], statements):
        space = dict(names)
        with contextlib.suppress(SyntaxError):
            exec(edit.statement, space)
            yield edit.statement, space[statements[0].node.name]


@contextlib.contextmanager
def not_for_ever():
    def stop(*about):
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(SECONDS)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def holds(question):
    try:
        with not_for_ever():
            question()
    except BaseException:
        return False
    return True


def mended_by_one_edit(exercise, function):
    """The edits of an answer with which it passes what it failed."""
    lesson = lesson_of(exercise)
    student = student_with(lesson, {one.name: test_cheap.nothing for one in lesson.machine_graded})
    setattr(student, exercise, walled(function))
    about = lambda check: check.exercise == exercise  # noqa: E731
    failed = [
        outcome.check
        for outcome in run_tests(lesson, student, test_cheap.SEED, about)
        if outcome.failure
    ]
    found, hidden = [], None
    for text, changed in edited(function):
        setattr(student, exercise, walled(changed))
        shown = shown_questions(student, failed)
        if not all(map(holds, shown)):
            continue
        hidden = hidden or hidden_questions(lesson, student, test_cheap.SEED, failed)
        if all(map(holds, hidden)):
            found.append(text)
    return found


if __name__ == "__main__":
    import sys, time

    warnings.simplefilter("ignore")
    import numpy

    numpy.seterr(all="ignore")
    for exercise, table in test_cheap.CHEAP.items():
        if len(sys.argv) > 1 and exercise not in sys.argv[1:]:
            continue
        t = time.time()
        for name, function in (test_cheap.ANYTHING | table).items():
            if not inspect.isfunction(function):
                continue
            try:
                found = mended_by_one_edit(exercise, function)
            except Exception as e:
                print(exercise, name, "ERROR", repr(e)[:200])
                continue
            if found:
                print(exercise, name, found[:3])
        print("--", exercise, round(time.time() - t, 1), flush=True)
