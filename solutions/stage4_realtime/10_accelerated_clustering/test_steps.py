"""Tests that the checks of lesson 10's three steps judge right and wrong answers correctly."""

import pytest

from grader.course.kept_answers import answers_to
from grader.course.lessons import load_reference
from tests.lesson_texts import source_of
from tests.ungraded_steps import assert_notes_hold, failures_of
from utils.checks.diagnosis import diagnose

STEPS = ("points_in_cells", "join_cheaply", "join_exactly")
LESSON = load_reference("10_accelerated_clustering", *STEPS, "on_floors")
ANSWERS = [(name, variant) for name in STEPS for variant in answers_to(name)]


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
    function = namespace[name]
    assert_notes_hold(variant, failures_of(name, function), diagnose(name, function))


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
