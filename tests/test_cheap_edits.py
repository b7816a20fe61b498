"""No single edit turns a cheap answer, which ignores the task, into a right answer."""

import ast
import contextlib
import inspect
import resource
import signal
from pathlib import Path

import numpy as np
import pytest

from grader.course.kept_answers import fill_in
from grader.course.lessons import lesson_of
from grader.course.rules import MISSED_TASK_KEEPS
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import judge_files
from grader.judging.runner import hidden_calls, run_checks, visible_calls
from tests import cheap_answers
from tests.students import student_with, with_copied_arguments
from utils.checks import checks_of
from utils.checks.diagnosis import diagnose
from utils.notebooks import slicing
from utils.notebooks.edits import edits_of

SECONDS = 2  # time limit, because an edit may cause an endless loop
MEMORY = 4 * 2**30  # additional bytes, because an edit may create huge arrays


def sources():
    """Return the syntax nodes of all functions in `cheap_answers`, by first line and type."""
    tree = ast.parse(inspect.getsource(cheap_answers))
    kinds = (ast.Lambda, ast.FunctionDef)
    return {(node.lineno, type(node)): node for node in ast.walk(tree) if isinstance(node, kinds)}


SOURCES = sources()


def source_and_names(function):
    """Return the source of a function in the table, and the names that it can use."""
    kind = ast.Lambda if function.__name__ == "<lambda>" else ast.FunctionDef
    node = SOURCES[function.__code__.co_firstlineno, kind]
    closure = inspect.getclosurevars(function).nonlocals
    if kind is ast.FunctionDef:
        return ast.unparse(node), function.__globals__ | closure
    text = f"def answer({ast.unparse(node.args)}):\n    return {ast.unparse(node.body)}"
    return text, function.__globals__ | closure


def edited_functions(function):
    """Yield (source, function) for all functions one edit away from a function in the table."""
    text, names = source_and_names(function)
    names.pop("answer", None)
    statements, _ = slicing.parse_notebook([text])
    for edit in edits_of([text], statements):
        space = dict(names)
        with contextlib.suppress(Exception):
            exec(edit.statement, space)  # an edit may move a failing statement out of the function
        changed = space.get(statements[0].node.name)
        if changed is not None:
            yield edit.statement, changed


@contextlib.contextmanager
def time_limit():
    def stop(*about):
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(SECONDS)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def passes(check):
    try:
        with time_limit():
            check()
    except BaseException:
        return False
    return True


def repairing_edits(exercise, function):
    """Return the edits after which a function passes all the checks that it failed."""
    lesson = lesson_of(exercise)
    student = student_with(
        lesson,
        {graded.name: cheap_answers.nothing for graded in lesson.machine_graded},
    )
    setattr(student, exercise, with_copied_arguments(function))
    outcomes = run_checks(
        lesson, student, cheap_answers.SEED, lambda check: check.exercise == exercise
    )
    failed = [outcome.check for outcome in outcomes if outcome.failure]
    found, hidden = [], None
    for text, changed in edited_functions(function):
        setattr(student, exercise, with_copied_arguments(changed))
        shown = visible_calls(student, failed)
        if not all(map(passes, shown)):
            continue
        hidden = hidden or hidden_calls(lesson, student, cheap_answers.SEED, failed)
        if all(map(passes, hidden)):
            found.append(text)
    return found


def misses_the_task(exercise, function):
    mistake = diagnose(exercise, function)
    return mistake is not None and mistake.is_the_task


@pytest.fixture
def limit_memory():
    """Limit the memory, because the kernel kills a process that uses it up."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MEMORY, hard))
    yield
    resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.usefixtures("limit_memory")
@pytest.mark.parametrize("exercise", cheap_answers.CHEAP_ANSWERS)
def test_no_cheap_answer_is_one_edit_from_a_right_one(exercise):
    """Answers that miss the point of the exercise are skipped, because they keep fewer points."""
    checks_of(exercise)  # declares the mistakes
    kept, tried = {}, 0
    with np.errstate(all="ignore"):
        for name, function in (
            cheap_answers.GENERAL_ANSWERS | cheap_answers.CHEAP_ANSWERS[exercise]
        ).items():
            if inspect.isfunction(function) and not misses_the_task(exercise, function):
                kept[name] = repairing_edits(exercise, function)
                tried += 1
    assert tried > 25
    assert {name: edits for name, edits in kept.items() if edits} == {}


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_known_mistakes_of_cheap_answers_are_marked_as_cheap():
    """Otherwise, a cheap answer with a known mistake would keep 60 % of its points."""
    named = {}
    for exercise, table in cheap_answers.CHEAP_ANSWERS.items():
        checks_of(exercise)  # declares the mistakes
        for name, function in (cheap_answers.GENERAL_ANSWERS | table).items():
            with np.errstate(all="ignore"):
                mistake = diagnose(exercise, function)
            if mistake:
                named[exercise, name, mistake.description] = mistake.is_cheap or mistake.is_the_task
    assert len(named) > 20
    assert {mistake_made for mistake_made, is_declared in named.items() if not is_declared} == set()


def test_a_slip_that_misses_the_task_keeps_fewer_points(sandbox):
    """A horizontal distance ignores the height, so an answer that includes it misses the task."""
    lesson = lesson_of("horizontal_distance")
    answer = "def horizontal_distance(cloud):\n    return np.linalg.norm(cloud[:, :3], axis=1)"
    submission = SubmittedFiles(
        f"{lesson.name}.ipynb", fill_in(lesson, {"horizontal_distance": answer}).encode()
    )
    result = judge_files(submission, 5, sandbox, lesson).exercises[0]
    assert result.slip.before == "    return np.linalg.norm(cloud[:, :3], axis=1)"
    assert result.score == MISSED_TASK_KEEPS * result.max_score
    assert result.score - result.slip.score <= result.max_score / 10  # earned by checks
