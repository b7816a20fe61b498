"""An exercise that calls a wrong one keeps what its own work is worth."""

import ast

import pytest

from grader.course.lessons import find_lesson
from grader.course.variants import fill_in, variants_of
from grader.judging.judge import judge
from utils.notebooks import slicing

LESSON = find_lesson("02_ransac_line")


def source_of(exercise, name=""):
    """The lesson's own solution of an exercise, or one of its variants."""
    if not name:
        statements, _ = slicing.parse_notebook([LESSON.source.read_text("utf-8")])
        return next(ast.unparse(one.node) for one in statements if exercise in one.binds)
    return next(one.source for one in variants_of(exercise) if one.name == name)


def judged(answers, sandbox, tmp_path):
    """Results by exercise, where all others are right."""
    right = {one.name: source_of(one.name) for one in LESSON.machine_graded}
    path = tmp_path / f"{LESSON.name}.ipynb"
    path.write_text(fill_in(LESSON, right | answers), "utf-8")
    return {one.name: one for one in judge(path, 7, sandbox).exercises}


@pytest.mark.slow
@pytest.mark.parametrize(
    "helper, name",
    [
        ("line_through", "the normal has any length"),
        ("line_through", "always None"),
        ("point_line_distance", "no absolute value"),
        ("point_line_distance", "a list back"),
        ("point_line_distance", "stub left in place"),
    ],
)
def test_what_calls_a_wrong_helper_keeps_its_points(helper, name, sandbox, tmp_path):
    results = judged({helper: source_of(helper, name)}, sandbox, tmp_path)
    assert results[helper].score < results[helper].max_score
    calls = results["ransac_line"]
    assert calls.score == calls.max_score
    assert f"{helper}, which ransac_line calls, is wrong." in calls.cause
    assert [test.message for test in calls.tests if not test.passed] == []


@pytest.mark.slow
def test_what_is_wrong_itself_still_loses_points(sandbox, tmp_path):
    helper = source_of("line_through", "the normal has any length")
    gives_up = source_of("ransac_line").replace("continue", "break")
    results = judged({"line_through": helper, "ransac_line": gives_up}, sandbox, tmp_path)
    calls = results["ransac_line"]
    assert 0.8 * calls.max_score < calls.score < calls.max_score
    assert "line_through, which ransac_line calls, is wrong." in calls.cause
    assert "in some runs no line was found" in calls.cause


@pytest.mark.slow
def test_two_wrong_helpers_are_both_named(sandbox, tmp_path):
    helpers = {
        "line_through": source_of("line_through", "c with the wrong sign"),
        "point_line_distance": source_of("point_line_distance", "c forgotten"),
    }
    calls = judged(helpers, sandbox, tmp_path)["ransac_line"]
    assert calls.score == calls.max_score
    assert "line_through and point_line_distance, which ransac_line calls, are wrong" in calls.cause


def test_a_right_helper_is_not_blamed(sandbox, tmp_path):
    gives_up = source_of("ransac_line").replace("continue", "break")
    calls = judged({"ransac_line": gives_up}, sandbox, tmp_path)["ransac_line"]
    assert calls.score < calls.max_score
    assert "which ransac_line calls" not in calls.cause
