"""Checks that an exercise declares: examples and common checks."""

import numpy as np
import pytest

from utils.checks import core
from utils.checks.core import checks_of, run_check
from utils.checks.exercise import Exercise, assert_answer
from utils.checks.failures import CheckFailed, NotYet, WrongForm

EXPLANATION = {"why": "It matters.", "hint": "Look."}


@pytest.fixture
def total(monkeypatch):
    """Return an exercise whose input is a plain list."""
    monkeypatch.setattr(core, "_CHECKS", {})
    exercise = Exercise(
        __name__,
        "total",
        {"numbers": [3.0, 4.0], "start": 1},
        8.0,
        title="Adds",
        weight=3,
        **EXPLANATION,
    )
    exercise.example("empty", {"numbers": []}, 1.0, title="Works without numbers", **EXPLANATION)
    exercise.promise("names")
    exercise.promise("untouched", why="They are needed again.", weight=2)
    return exercise


def failures_of(function):
    function.__name__ = "total"
    outcomes = {check.name: run_check(check, function).failure for check in checks_of("total")}
    return {name: type(failure) for name, failure in outcomes.items() if failure}


def total_of(numbers, start):
    return start + sum(numbers)


def test_each_declaration_adds_a_check(total):
    checks = checks_of("total")
    assert [(check.name, check.weight) for check in checks] == [
        ("plain_case", 3),
        ("empty", 1.0),
        ("keeps_the_names", 1),
        ("leaves_its_input", 2),
    ]
    assert {check.run.__module__ for check in checks} == {__name__}
    assert checks[-1].why == "They are needed again." and checks[-1].hint == "Work on a copy."


def test_a_right_answer_passes(total):
    assert failures_of(total_of) == {}


@pytest.mark.parametrize(
    ("function", "failed"),
    [
        (lambda numbers, start: start + sum(numbers) if numbers else 0, {"empty": CheckFailed}),
        (lambda a, start: start + sum(a), {"keeps_the_names"}),
        (
            lambda numbers, start: start + sum(numbers.pop() for _ in range(len(numbers))),
            {"leaves_its_input": CheckFailed},
        ),
        (
            lambda numbers, start: sum(numbers),
            {
                "plain_case": CheckFailed,
                "empty": NotYet,
                "keeps_the_names": NotYet,
                "leaves_its_input": NotYet,
            },
        ),
    ],
    ids=[
        "fails for an empty list",
        "renames a parameter",
        "changes its input",
        "fails in the plain case",
    ],
)
def test_a_slip_fails_one_check_but_the_other_checks_wait_for_the_plain_case(
    total, function, failed
):
    found = failures_of(function)
    assert found == failed if isinstance(failed, dict) else set(found) == failed


@pytest.mark.parametrize(
    ("answer", "expected"),
    [
        (7.5055535, 7.505553499),
        (np.float32(2), 2),
        ([1, 2.0], np.array([1, 2])),
        ([[1, 2]], [[1, 2]]),
        ("left", "left"),
        (True, True),
        ({"a": [1]}, {"a": [1]}),
        ([[1], [2, 3]], [[1], [2, 3]]),
    ],
)
def test_only_numbers_may_differ_slightly(answer, expected):
    assert_answer(answer, expected)


@pytest.mark.parametrize(
    ("answer", "expected", "kind"),
    [
        (7.51, 7.505, CheckFailed),
        ([1, 2], [1, 2, 3], WrongForm),
        ([7.5], 7.5, WrongForm),
        (None, 2.0, WrongForm),
        ("left", "right", CheckFailed),
        (1, True, WrongForm),
        ([[1], [2, 4]], [[1], [2, 3]], CheckFailed),
    ],
)
def test_the_failure_shows_the_wrong_and_the_right_answer(answer, expected, kind):
    with pytest.raises(CheckFailed) as failure:
        assert_answer(answer, expected, "f(2)")
    assert type(failure.value) is kind and failure.value.input_text == "f(2)"
    assert failure.value.yours and failure.value.expected
