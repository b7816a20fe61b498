"""Lesson 03: a right RANSAC loop keeps its points despite wrong helpers, and planes are drawn."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.judging.judge import judge
from utils.checks import CheckFailed
from utils.checks.lesson_03.fit_plane import assert_through_the_mean
from utils.checks.lesson_03.planes import scattered_plane
from utils.checks.lesson_03.results import assert_finds_plane, assert_nearest_are_inliers

RANSAC_PLANE = """\
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers
"""


def answer_to(exercise, name):
    return next(answer.source for answer in answers_to(exercise) if answer.name == name)


def right_answer_to(exercise):
    return next(answer.source for answer in answers_to(exercise) if answer.right)


@pytest.mark.slow
@pytest.mark.parametrize(
    "helper, name",
    [
        ("plane_through", "wrong sign of d"),
        ("plane_through", "forgets to normalise"),
        ("point_plane_distance", "no absolute value"),
    ],
)
def test_a_right_loop_earns_everything_with_wrong_helpers(helper, name, sandbox, tmp_path):
    lesson = find_lesson("03_ransac_plane")
    answers = {
        exercise: right_answer_to(exercise)
        for exercise in ("plane_through", "point_plane_distance")
    }
    answers |= {helper: answer_to(helper, name), "ransac_plane": RANSAC_PLANE}
    path = tmp_path / f"{lesson.name}.ipynb"
    path.write_text(fill_in(lesson, answers), "utf-8")
    results = {exercise.name: exercise for exercise in judge(path, 7, sandbox).exercises}
    assert results[helper].score < results[helper].max_score
    assert results["ransac_plane"].score == results["ransac_plane"].max_score
    assert f"{helper}, which ransac_plane calls, is wrong" in results["ransac_plane"].cause


@pytest.mark.slow
def test_a_wrong_loop_stays_wrong_with_right_helpers(sandbox, tmp_path):
    lesson = find_lesson("03_ransac_plane")
    answers = {
        "plane_through": answer_to("plane_through", "wrong sign of d"),
        "point_plane_distance": right_answer_to("point_plane_distance"),
        "ransac_plane": RANSAC_PLANE.replace("continue", "break"),
    }
    path = tmp_path / f"{lesson.name}.ipynb"
    path.write_text(fill_in(lesson, answers), "utf-8")
    results = {exercise.name: exercise for exercise in judge(path, 7, sandbox).exercises}
    ransac = results["ransac_plane"]
    assert 0.8 * ransac.max_score < ransac.score < ransac.max_score
    assert "plane_through, which ransac_plane calls, is wrong" in ransac.cause
    assert "continue with the next sample" in ransac.cause


@pytest.mark.parametrize(
    "plane", [(0.0, 0.6, 0.8, 1.7), (0.6, 0.8, 0.0, -4.0), (0.0, 0.0, 1.0, 2.0)]
)
@pytest.mark.parametrize("yours", [(0, 0, 1, 5.0), (1, 0, 0, 0.0), (0, -1, 0, 3.0)])
def test_planes_are_drawn_edge_on(plane, yours):
    points, belongs = scattered_plane(1, 40, 20, plane=plane)
    mask = np.arange(60) < 20
    for compare in (
        lambda: assert_finds_plane((yours, mask), points, 0.1, belongs),
        lambda: assert_nearest_are_inliers((yours, mask), points),
        lambda: assert_through_the_mean(yours, points),
    ):
        with pytest.raises(CheckFailed) as caught:
            compare()
        axes = caught.value.draw()
        assert axes.get_xlabel() == "along the plane (m)"
        assert not any("face on" in text.get_text() for text in axes.texts)
        plt.close("all")
