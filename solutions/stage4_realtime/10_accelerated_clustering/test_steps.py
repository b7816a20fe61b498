"""Tests that the checks of lesson 10's three steps judge right and wrong answers correctly."""

import pytest

from grader.course.kept_answers import answers_to
from grader.course.lessons import load_reference
from tests.lesson_texts import source_of
from utils.checks import checks_of
from utils.checks.core import run_check
from utils.checks.diagnosis import diagnose

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


# For each kept answer with a known mistake, words of its diagnosis.
DIAGNOSES = {
    "the threshold used as the side": "The side of a cell is the threshold",
    "rounded towards 0": "perhaps with .astype(int)",
    "the diagonal of a square": "right only in the plane",
    "only one cell gets the new label": "Only cell j gets the new label",
    "only one cell gets the new label, and all pairs are compared": "Only cell j gets",
}


@pytest.mark.parametrize(
    ("name", "variant"),
    [pytest.param(*answer, id=f"{answer[0]}: {answer[1].name}") for answer in ANSWERS],
)
def test_only_known_mistakes_are_diagnosed(name, variant):
    namespace = dict(getattr(LESSON, name).__globals__)
    exec(variant.source, namespace)
    mistake = diagnose(name, namespace[name])
    assert bool(mistake) == (variant.name in DIAGNOSES)
    assert not mistake or DIAGNOSES[variant.name] in mistake.description


@pytest.mark.parametrize(
    ("name", "right", "wrong", "words"),
    [
        (
            "points_in_cells",
            "np.floor(points / side)",
            "np.round(points / side)",
            "rounds 0.6 to 1",
        ),
        (
            "join_exactly",
            "label[label == label[j]] = label[i]",
            "label[i] = label[j]",
            "Only cell i",
        ),
    ],
)
def test_other_mistakes_of_one_edit_are_diagnosed(name, right, wrong, words):
    namespace = dict(getattr(LESSON, name).__globals__)
    source = source_of(name)
    assert source.count(right) == 1
    exec(source.replace(right, wrong), namespace)
    assert words in diagnose(name, namespace[name]).description
