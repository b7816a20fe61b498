"""Tests that the checks of lesson 10's three steps judge right and wrong answers correctly."""

import pytest

from grader.course.kept_answers import answers_to
from grader.course.lessons import load_reference
from utils.checks import checks_of
from utils.checks.core import run_check

STEPS = ("points_in_cells", "join_cheaply", "join_exactly")
LESSON = load_reference("10_accelerated_clustering", *STEPS, "on_floors")
ANSWERS = [(name, variant) for name in STEPS for variant in answers_to(name)]


def failures_of(name, function):
    outcomes = [run_check(check, function) for check in checks_of(name)]
    return {outcome.check.name: outcome for outcome in outcomes if outcome.failure}


@pytest.mark.parametrize("name", STEPS)
def test_the_solution_passes(name):
    assert not failures_of(name, getattr(LESSON, name))


@pytest.mark.parametrize(
    ("name", "variant"),
    [pytest.param(*answer, id=f"{answer[0]}: {answer[1].name}") for answer in ANSWERS],
)
def test_kept_answers_pass_or_fail_as_claimed(name, variant):
    namespace = dict(getattr(LESSON, name).__globals__)  # the functions that the lesson gives
    exec(variant.source, namespace)
    failed = failures_of(name, namespace[name])
    if variant.right:
        assert not failed
        return
    assert set(variant.loses) <= set(failed), sorted(failed)
    assert not variant.loses_only or set(failed) <= set(variant.loses), sorted(failed)
    messages = [
        f"{outcome.failure.message} {outcome.failure.hint or outcome.check.hint}"
        for outcome in failed.values()
    ]
    assert variant.says in " ".join(messages), messages
