"""Points add up exactly, wherever they are shown."""

import json
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as some

from grader.classroom.item_analysis import hardest_checks
from grader.course.kept_answers import answers_to, fill_in
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import judge_files
from grader.judging.points import points_of, shares, total
from grader.judging.verdict import JUDGED, CheckResult, ExerciseResult, Verdict
from utils.checks import Check
from utils.checks.failures import CheckFailed
from utils.checks.outcomes import Outcome

WEIGHTS = some.lists(some.sampled_from([0.5, 1.0, 1.5, 2.0, 3.0, 4.0]), min_size=1, max_size=30)


@given(some.integers(1, 10_000), WEIGHTS)
def test_shares_add_up_and_are_within_a_cent_of_exact(cents, weights):
    shares_in_cents = [round(100 * share) for share in shares(cents / 100, weights)]
    assert sum(shares_in_cents) == cents
    total_weight = sum(map(Fraction, weights))
    for share, weight in zip(shares_in_cents, weights, strict=True):
        assert abs(share - cents * Fraction(weight) / total_weight) < 1
    for weight, next_weight in zip(weights, weights[1:], strict=False):
        if weight == next_weight:
            first, second = weights.index(weight), weights.index(next_weight)
            assert abs(shares_in_cents[first] - shares_in_cents[second]) <= 1


@pytest.mark.parametrize(
    ("points", "weights", "expected"),
    [
        (1.0, [1, 1, 1], [0.34, 0.33, 0.33]),
        (0.1, [1, 1, 1, 1, 1, 1], [0.02, 0.02, 0.02, 0.02, 0.01, 0.01]),
        (20.0, [1, 2, 4], [2.86, 5.71, 11.43]),
        (0.05, [3, 1], [0.04, 0.01]),
        (5.0, [2.5], [5.0]),
    ],
)
def test_remaining_cents_go_to_the_largest_fractions(points, weights, expected):
    assert shares(points, weights) == expected


@given(some.integers(1, 5000), WEIGHTS, some.data())
def test_an_exercise_earns_the_sum_of_the_shares_of_its_passed_checks(cents, weights, data):
    outcomes = [
        Outcome(
            Check(str(number), "f", "a title", "a hint", weight),
            data.draw(some.sampled_from([None, CheckFailed("no")])),
        )
        for number, weight in enumerate(weights)
    ]
    earned = points_of(cents / 100, outcomes)
    shown = shares(cents / 100, weights)
    passed = [share for share, run in zip(shown, outcomes, strict=True) if run.failure is None]
    assert Fraction(round(100 * earned)) == sum(round(100 * share) for share in passed)
    if len(passed) == len(outcomes):
        assert earned == cents / 100


@pytest.mark.slow
def test_a_verdict_adds_up(lesson, sandbox):
    """The points of right, wrong and untouched exercises add up to the verdict's score."""
    answers = {}
    for number, exercise in enumerate(lesson.machine_graded):
        kept = answers_to(exercise.name)
        if number % 3 != 2:
            answers[exercise.name] = next(
                answer.source for answer in kept if answer.right == bool(number)
            )
    submission = SubmittedFiles(f"{lesson.name}.ipynb", fill_in(lesson, answers).encode())
    verdict = judge_files(submission, 11, sandbox, lesson)
    shown = json.loads(json.dumps(verdict.as_dict()))
    for exercise in shown["exercises"]:
        names = [test["name"] for test in exercise["tests"]]
        assert len(names) == len(set(names)) >= 3
        assert {test["visible"] for test in exercise["tests"]} == {True, False}
        kept = [exercise["slip"]["score"]] if exercise["slip"] else []
        assert total([test["score"] for test in exercise["tests"]] + kept) == exercise["score"]
        assert total([test["max_score"] for test in exercise["tests"]]) == exercise["max_score"]
        for test in exercise["tests"]:
            assert test["score"] == (test["max_score"] if test["passed"] else 0)
            assert round(test["max_score"], 2) == test["max_score"] > 0
    assert total([exercise["score"] for exercise in shown["exercises"]]) == shown["score"]
    assert total([exercise["max_score"] for exercise in shown["exercises"]]) == shown["max_score"]


def test_the_report_names_the_check_that_failed():
    """The report finds the check by name, because two checks of an exercise may share a title."""
    shown, hidden = (
        CheckResult(name, "Finds it", False, 0.0, 1.0, "", visible)
        for name, visible in (("finds_it", True), ("test_finds_it", False))
    )
    exercise = ExerciseResult("f", 0.0, 2.0, (shown, hidden), "It is not found.", "test_finds_it")
    verdict = Verdict("09", "ada", JUDGED, 0.0, 2.0, (exercise,), (), 0.0, "")
    (found,) = hardest_checks([verdict])
    assert (found.title, found.visible) == ("Finds it", False)
