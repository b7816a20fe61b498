"""A survey of mutants: every answer that is one edit away from a right one.

Each loses points, or answers as the solution does whatever it is asked, or stands in `KNOWN` with
a reason. They are asked here, and not in the sandbox; `python -m tests.survey` judges a sample of
them behind the walls, and says what a slip costs.
"""

import copy
import random
from types import SimpleNamespace

import numpy as np
import pytest

from grader.course.lessons import all_lessons, lesson_of, load_reference
from grader.course.variants import ANOTHER_CELL, variants_of
from grader.judging.asking import hidden_questions, run_tests, shown_questions
from tests.students import student_with, walled
from tests.test_cheap_edits import holds
from tests.test_slips import solution_of
from utils.checks import checks_of
from utils.notebooks import slicing
from utils.notebooks.edits import edits_of

SEED, SEEDS = 7, (11, 12, 13)  # for the checks, and for the calls that tell two answers apart
CALLS = 1000
EXERCISES = [exercise.name for lesson in all_lessons() for exercise in lesson.machine_graded]
# Edits that lose nothing though they answer otherwise, by exercise: the changed line, and why.
KNOWN = {}


class Recorder:
    """The right function, and what it was called with."""

    def __init__(self, function):
        self.function, self.calls = function, []

    def __call__(self, *arguments, **keywords):
        self.calls.append(copy.deepcopy((arguments, keywords)))
        return self.function(*arguments, **keywords)


def same(one, other):
    """Whether two answers are the same, nearly."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        one, other = np.asarray(one), np.asarray(other)
        return one.shape == other.shape and bool(
            np.array_equal(one, other)
            if one.dtype == object or one.dtype == bool
            else np.allclose(one, other, rtol=1e-6, atol=1e-9, equal_nan=True)
        )
    if isinstance(one, (tuple, list)) and isinstance(other, (tuple, list)):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, (int, float, np.number)) and isinstance(other, (int, float, np.number)):
        return bool(np.isclose(one, other, rtol=1e-6, atol=1e-9, equal_nan=True))
    if isinstance(one, np.random.Generator):
        return one.bit_generator.state == other.bit_generator.state
    if hasattr(one, "__dict__"):
        return type(one).__name__ == type(other).__name__ and same(
            [*vars(one).values()], [*vars(other).values()]
        )
    return one == other


def outcome_of(function, call):
    """What a call returns or raises, and what it makes of its arguments."""
    arguments, keywords = copy.deepcopy(call)
    try:
        answer = function(*arguments, **keywords)
    except Exception as error:
        answer = type(error).__name__
    return [answer, list(arguments)]


def calls_of(lesson, exercise, right):
    """Calls that the checks make on other streets and other draws."""
    recorder = Recorder(right[exercise])
    student = student_with(lesson, {**right, exercise: recorder})
    for seed in SEEDS:
        run_tests(lesson, student, seed, lambda check: check.exercise == exercise)
    random.Random(1).shuffle(recorder.calls)
    return recorder.calls[:CALLS]


def answers_to(exercise):
    """The solution and the right answers, each as cells and the names that they need."""
    yield "the solution", [solution_of(exercise)]
    for variant in variants_of(exercise):
        if variant.right:
            yield variant.name, variant.source.split(ANOTHER_CELL)


def mutants_of(exercise, cells, reference):
    """Every answer that is one edit away: the changed line, and the function."""
    statements, _ = slicing.parse_notebook(cells)
    theirs = [one for one in statements if exercise in one.binds]
    for edit in edits_of(cells, theirs):
        changed = list(cells)
        lines = changed[edit.cell - 1].split("\n")
        text = "\n".join([*lines[: edit.first - 1], edit.text, *lines[edit.last :]])
        changed[edit.cell - 1] = text
        space = {**vars(reference), "np": np}
        try:
            exec(compile("\n".join(changed), "<mutant>", "exec"), space)
        except Exception:
            continue
        yield edit.text.strip(), space[exercise]


def survivors(exercise, cells, right, reference):
    """The mutants that lose nothing, and how many there were."""
    lesson = lesson_of(exercise)
    student = SimpleNamespace(**vars(student_with(lesson, right)))
    shown = shown_questions
    count, found, hidden = 0, [], None
    for line, function in mutants_of(exercise, cells, reference):
        count += 1
        setattr(student, exercise, walled(function))
        if all(map(holds, shown(student, checks_of(exercise)))):
            if hidden is None:
                checks = [one.check for one in everything(lesson, exercise, right)]
                hidden = hidden_questions(lesson, student, SEED, checks)
            if all(map(holds, hidden)):
                found.append((line, function))
    return count, found


def everything(lesson, exercise, right):
    return run_tests(
        lesson, student_with(lesson, right), SEED, lambda check: check.exercise == exercise
    )


@pytest.mark.slow
@pytest.mark.proof
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("exercise", EXERCISES)
def test_an_edit_of_a_right_answer_loses_points_or_changes_nothing(exercise):
    lesson = lesson_of(exercise)
    reference = load_reference(lesson.name)
    right = vars(reference)
    calls = calls_of(lesson, exercise, right)
    assert len(calls) > 20
    escaped = []
    with np.errstate(all="ignore"):
        expected = [outcome_of(right[exercise], call) for call in calls]
        for name, cells in answers_to(exercise):
            count, found = survivors(exercise, cells, right, reference)
            assert count > 20
            for line, function in found:
                unlike = sum(
                    not same(outcome_of(function, call), answer)
                    for call, answer in zip(calls, expected, strict=True)
                )
                if unlike and line not in KNOWN.get(exercise, {}):
                    escaped.append((name, line, unlike))
            print(name, count, len(found))
    assert escaped == []
