"""An exercise that calls a wrong function earns the points for its own work."""

import ast
import shutil

import pytest

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import Lesson, find_lesson, lesson_of
from grader.judging import judge as judging
from grader.judging.judge import judge
from tests.slip_tables import solution_of
from utils.notebooks import slicing

LESSON = find_lesson("02_ransac_line")


def source_of(exercise, name=""):
    """Return the source of an exercise: the lesson's solution, or the kept answer `name`."""
    if not name:
        statements, _ = slicing.parse_notebook([LESSON.source.read_text("utf-8")])
        return next(
            ast.unparse(statement.node) for statement in statements if exercise in statement.binds
        )
    return next(answer.source for answer in answers_to(exercise) if answer.name == name)


def judge_with(answers, sandbox, tmp_path):
    """Judge a notebook in which all other answers are right; return the results by name."""
    right = {exercise.name: source_of(exercise.name) for exercise in LESSON.machine_graded}
    path = tmp_path / f"{LESSON.name}.ipynb"
    path.write_text(fill_in(LESSON, right | answers), "utf-8")
    return {exercise.name: exercise for exercise in judge(path, 7, sandbox).exercises}


@pytest.mark.slow
@pytest.mark.parametrize(
    "helper, name",
    [
        ("line_through", "the normal has any length"),
        ("line_through", "always None"),
        ("point_line_distance", "no absolute value"),
        ("point_line_distance", "stub left in place"),
    ],
)
def test_an_exercise_that_calls_a_wrong_helper_keeps_its_points(helper, name, sandbox, tmp_path):
    results = judge_with({helper: source_of(helper, name)}, sandbox, tmp_path)
    assert results[helper].score < results[helper].max_score
    calls = results["ransac_line"]
    assert calls.score == calls.max_score
    assert f"{helper}, which ransac_line calls, is wrong." in calls.cause
    assert [test.message for test in calls.tests if not test.passed] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("helper", "caller"),
    [("point_line_distance", "ransac_line"), ("point_plane_distance", "ransac_plane")],
)
def test_a_helper_that_returns_a_list_costs_nothing(helper, caller, sandbox, tmp_path):
    sources = {variant.name: variant.source for variant in answers_to(helper)}
    returns_a_list = sources["returns a list"]
    lesson = lesson_of(helper)
    path = tmp_path / f"{lesson.name}.ipynb"
    right = {exercise.name: solution_of(exercise.name) for exercise in lesson.machine_graded}
    path.write_text(fill_in(lesson, right | {helper: returns_a_list}), "utf-8")
    verdict = judge(path, 7, sandbox)
    assert verdict.score == verdict.max_score
    [result] = [exercise for exercise in verdict.exercises if exercise.name == caller]
    assert f"{helper}, which {caller} calls, is right" in result.cause


@pytest.mark.slow
def test_mistakes_in_the_exercise_itself_still_lose_points(sandbox, tmp_path):
    helper = source_of("line_through", "the normal has any length")
    gives_up = source_of("ransac_line").replace("continue", "break")
    results = judge_with({"line_through": helper, "ransac_line": gives_up}, sandbox, tmp_path)
    calls = results["ransac_line"]
    assert 0.8 * calls.max_score < calls.score < calls.max_score
    assert "line_through, which ransac_line calls, is wrong." in calls.cause
    assert "in some runs no line was found" in calls.cause


@pytest.mark.slow
def test_both_of_two_wrong_helpers_are_named(sandbox, tmp_path):
    helpers = {
        "line_through": source_of("line_through", "c with the wrong sign"),
        "point_line_distance": source_of("point_line_distance", "c forgotten"),
    }
    calls = judge_with(helpers, sandbox, tmp_path)["ransac_line"]
    assert calls.score == calls.max_score
    assert "line_through and point_line_distance, which ransac_line calls, are wrong" in calls.cause


@pytest.mark.slow
def test_a_right_helper_is_not_blamed(sandbox, tmp_path):
    gives_up = source_of("ransac_line").replace("continue", "break")
    calls = judge_with({"ransac_line": gives_up}, sandbox, tmp_path)["ransac_line"]
    assert calls.score < calls.max_score
    assert "which ransac_line calls" not in calls.cause


PLANE = find_lesson("03_ransac_plane")


@pytest.fixture
def copied_lesson(tmp_path, monkeypatch):
    """Return the lesson on planes with copies of its source and solution that tests can change."""
    folder = tmp_path / "solutions" / PLANE.name
    folder.mkdir(parents=True)
    shutil.copy(PLANE.source, folder)
    shutil.copy(PLANE.solved, folder.parent)
    monkeypatch.setattr(Lesson, "source", folder / PLANE.source.name)
    monkeypatch.setattr(Lesson, "solved", folder.parent / PLANE.solved.name)
    # The key covers only the project's own files.
    monkeypatch.setattr(judging, "verdict_key", lambda *about: "")
    return Lesson(PLANE.name, PLANE.stage)


def add_slip(path):
    """Add a slip to plane_through, so that its normals do not have unit length."""
    text = path.read_text("utf-8")
    assert text.count("normal = normal / length") == 1
    path.write_text(text.replace("normal = normal / length", "normal = normal * length"), "utf-8")


@pytest.mark.slow
def test_a_slip_in_an_unbuilt_source_has_no_effect(copied_lesson, sandbox, tmp_path):
    path = tmp_path / PLANE.solved.name
    shutil.copy(PLANE.solved, path)
    add_slip(path)  # the student submits the slip too
    add_slip(copied_lesson.source)
    results = {
        exercise.name: exercise for exercise in judge(path, 7, sandbox, copied_lesson).exercises
    }
    assert results["plane_through"].score < results["plane_through"].max_score
    assert results["ransac_plane"].score == results["ransac_plane"].max_score
    assert "plane_through, which ransac_plane calls, is wrong." in results["ransac_plane"].cause


@pytest.mark.slow
def test_a_slip_in_the_built_solution_is_found_before_judging(copied_lesson, sandbox):
    find_fault = judging.reference_failures.__wrapped__  # bypasses the cache
    add_slip(copied_lesson.solved)
    assert any(text.startswith("plane_through, ") for text in find_fault(copied_lesson, 7, sandbox))
