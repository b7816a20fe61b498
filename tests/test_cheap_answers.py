"""Cheap answers, which do not try to solve the task, earn at most a tenth of its points.

The answers run in this process, because the sandbox is too slow for so many of them. As in the
sandbox, each function gets copies of its arguments.
"""

from itertools import zip_longest
from types import SimpleNamespace

import numpy as np
import pytest

from grader.course.kept_answers import ANOTHER_CELL, answers_to
from grader.course.lessons import find_lesson, load_reference
from grader.judging.runner import run_checks
from tests.cheap_answers import (
    CHEAP_ANSWERS,
    GENERAL_ANSWERS,
    LARGEST_SHARE,
    PARKED,
    SEED,
    fixed_boxes_with_returns,
    nothing,
)
from tests.course_lessons import COURSE
from tests.students import student_with
from utils.checks import checks_of
from utils.checks.diagnosis import diagnose

# ---- answers that are partly right --------------------------------------------------------------


def nearest(previous, current, max_distance):
    """Match each box with the nearest previous one, even if several boxes share it."""
    if not len(previous):
        return np.full(len(current), -1)
    table = np.linalg.norm(current.mean(axis=1)[:, None] - previous.mean(axis=1), axis=2)
    return np.where(table.min(axis=1) <= max_distance, table.argmin(axis=1), -1)


# Fraction of the points that each answer may keep, with the reason.
PARTLY_RIGHT = {
    # Right unless two boxes share their nearest box, which only the most important check tests.
    "match_boxes": {"the nearest box, even if it is shared": (nearest, 0.75)},
    # The answer is a permutation and begins with the right median, which two checks test.
    "median_order": {
        "the median, then the rest": (
            lambda points: np.roll(np.argsort(points[:, 0]), -((len(points) - 1) // 2)),
            0.15,
        )
    },
    # Looking for obstacles in four fixed places is a very simple detector.
    "detect_obstacles": {
        f"{name}, where something is": (fixed_boxes_with_returns(boxes), 0.15)
        for name, boxes in PARKED.items()
    },
}

# ---- small expressions --------------------------------------------------------------------------

# Expressions in the arguments a, b and c that do little or nothing.
SMALL_EXPRESSIONS = """
a | a.ravel() | a.copy() | a[None] | a[:0] | a[None][:0] | a[0] | a[:1] | a[-1:] | a[1:] | a[:-1]
a[::2] | a[::-1] | a[:, 0] | a[:, 1] | a[:, 2] | a[:, :2] | a[:, :3] | abs(a[:, 0]) | abs(a[:, 1])
abs(a[:, 2]) | abs(a) | -a | a**2 | a + 1 | a - 1 | 2 * a | a.sum(0) | a.sum(1) | a.mean(0)
a.mean(1) | a.max(0) | a.min(0) | a.max(1) | a.min(1) | a.std(0) | norm(a, axis=1) | norm(a)
norm(a[:, :2], axis=1) | norm(a[:, :3], axis=1) | len(a) | a.shape | np.sort(a, axis=0)
np.argsort(a[:, 0]) | np.argsort(a[:, 2]) | np.unique(a) | np.unique(a, axis=0) | np.zeros(len(a))
np.ones(len(a), int) | np.arange(len(a)) | np.arange(len(a)) + 1 | np.eye(3) | a.T | a.tolist()
np.cov(a[:, :3].T) | eigh(np.cov(a[:, :3].T))[1] | svd(a[:, :3])[2] | svd(a[:, :3])[2].T
np.round(a) | np.floor(a) | np.sign(a) | a[~np.isnan(a).any(1)] | a[np.isfinite(a).all(1)]
a[(a != 0).all(1)] | a[(a != 0).any(1)] | a[a[:, 0] > 0] | a[np.isfinite(a)]
np.ones(len(a), bool) | np.zeros(len(a), bool) | b | c | (a, b) | a - b | b - a | a + b | a * b
a @ b | np.dot(a, b) | np.cross(a, b) | norm(b - a) | np.where(a < b, 0, a) | np.where(a >= b, a, 0)
a >= b | a[a >= b] | a[a[:, 0] <= b] | a[abs(a[:, 0]) <= b] | a[a[:, 2] >= b] | a[a[:, 2] > b]
a[a[:, 1] <= b] | a[abs(a[:, 1]) <= b] | a[a[:, 2] < b] | a[(a[:, :3] >= b).all(1)]
a[(a[:, :3] <= b).all(1)] | a[(a[:, :3] <= c).all(1)] | a[~(a[:, :3] >= b).all(1)]
a[~(a[:, :3] <= c).all(1)] | np.unique(np.floor(a[:, :3] / b), axis=0) | (a >= b).astype(int) * a
np.cumsum(np.r_[1, abs(np.diff(a[:, 0])) >= b]) | (0.0, 0.0, 1.0, 0.0) | (0.0, 1.0, 0.0) | None
[a[b == label] for label in np.unique(b) if label > 0] | np.arange(len(b)) | np.full(len(b), -1)
np.array([a[b == label, :3].mean(0) for label in np.unique(b) if label > 0])
int(np.ceil(1 / a**b))
norm(a.mean(1)[None] - b.mean(1)[:, None], axis=2).argmin(1) | np.inf | a**b | 1 / a
"""
# These do most of the work, and their mistake is a genuine slip.
NEARLY_RIGHT = {
    ("drop_invalid", "a[np.isfinite(a)]"),
    ("filter_ground", "a[a[:, 2] < b]"),
    ("principal_axes", "eigh(np.cov(a[:, :3].T))[1]"),
    ("principal_axes", "svd(a[:, :3])[2].T"),
}


@pytest.mark.filterwarnings("ignore")
def test_no_small_expression_counts_as_a_slip(lesson):
    """Known mistakes that these expressions make are marked as cheap, or as missing the task."""
    expressions = [
        text.strip() for text in SMALL_EXPRESSIONS.replace("\n", "|").split("|") if text.strip()
    ]
    names = {"np": np, **{name: getattr(np.linalg, name) for name in ("norm", "eigh", "svd")}}
    assert len(expressions) > 100
    keep = set()
    for graded in lesson.machine_graded:
        checks_of(graded.name)  # importing the checks declares the mistakes
        for text in expressions:
            function = eval(f"lambda a, b=None, c=None, d=None: {text}", names)
            mistake = diagnose(graded.name, function)
            if mistake and not (mistake.is_cheap or mistake.is_the_task):
                keep.add((graded.name, text))
    assert keep <= NEARLY_RIGHT


# ---- running the checks ------------------------------------------------------------------------


def earned_shares(lesson, answers, seed):
    """Return the earned fraction of points and the weights of passed checks, by exercise."""
    shares = {}
    outcomes = run_checks(lesson, student_with(lesson, answers), seed)
    for exercise in answers:
        outcomes_of_exercise = [
            outcome for outcome in outcomes if outcome.check.exercise == exercise
        ]
        whole = sum(outcome.check.weight for outcome in outcomes_of_exercise)
        passed = [outcome.check for outcome in outcomes_of_exercise if outcome.failure is None]
        names = {check.name: check.weight / whole for check in passed}
        shares[exercise] = (sum(names.values()), names)
    return shares


def answer_combinations(lesson, tables):
    """Yield combinations of one answer per exercise of a lesson, until all answers are used."""
    columns = [
        [(exercise.name, name, answer) for name, answer in tables(exercise.name).items()]
        for exercise in lesson.machine_graded
    ]
    for row in zip_longest(*columns):
        yield [chosen for chosen in row if chosen]


def overpaid_answers(lesson, tables, seed=SEED):
    """Return the answers that earn too much, with the earned fraction and the passed checks."""
    found = {}
    for chosen in answer_combinations(lesson, tables):
        answers = {exercise.name: nothing for exercise in lesson.machine_graded}
        answers |= {exercise: answer for exercise, _, (answer, _) in chosen}
        shares = earned_shares(lesson, answers, seed)
        for exercise, name, (_, most) in chosen:
            share, passed = shares[exercise]
            if share > most + 1e-9:
                found[exercise, name] = (round(share, 3), passed)
    return found


def cheap_answers_to(exercise):
    return {
        name: (answer, LARGEST_SHARE)
        for name, answer in (GENERAL_ANSWERS | CHEAP_ANSWERS[exercise]).items()
    }


def test_there_are_cheap_answers_to_every_exercise():
    names = {exercise.name for lesson in COURSE for exercise in lesson.machine_graded}
    assert set(CHEAP_ANSWERS) == names


@pytest.mark.slow
def test_no_cheap_answer_earns_more_than_a_tenth(lesson):
    assert overpaid_answers(lesson, cheap_answers_to) == {}


@pytest.mark.slow
@pytest.mark.parametrize("exercise", PARTLY_RIGHT)
def test_a_partly_right_answer_earns_part_of_the_points(exercise):
    lesson = next(
        lesson for lesson in COURSE if exercise in [graded.name for graded in lesson.machine_graded]
    )
    assert (
        overpaid_answers(lesson, lambda name: PARTLY_RIGHT[name] if name == exercise else {}) == {}
    )


# ---- answers with one slip ----------------------------------------------------------------------


def lost_tests(variant_of, name, lesson_name):
    """Return the names of the tests that a kept answer fails, in an otherwise right notebook."""
    variant = next(answer for answer in answers_to(variant_of) if answer.name == name)
    reference = load_reference(lesson_name)
    space = {**vars(reference), "np": np}
    exec(variant.source.replace(ANOTHER_CELL, ""), space)
    lesson = find_lesson(lesson_name)
    answers = {exercise.name: space[exercise.name] for exercise in lesson.machine_graded}
    student = SimpleNamespace(**answers, exercise="", close=lambda: None)
    return [
        outcome.check.name
        for outcome in run_checks(lesson, student, SEED)
        if outcome.failure and outcome.check.exercise == variant_of
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    "exercise, name, lesson_name, test",
    [
        (
            "ransac_line",
            "makes no generator from a seed",
            "02_ransac_line",
            "takes_a_seed",
        ),
        ("ransac_plane", "takes generators only", "03_ransac_plane", "takes_a_seed"),
        (
            "filter_clusters",
            "returns its input if nothing changes",
            "09_filter_clusters",
            "returns_a_new_array",
        ),
    ],
)
def test_one_slip_costs_one_check(exercise, name, lesson_name, test):
    assert lost_tests(exercise, name, lesson_name) == [test]
