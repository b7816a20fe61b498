"""Tests of the ungraded function in lesson 11, smallest_rectangle_yaw, and of its checks."""

import numpy as np
import pytest
import shapely

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson, load_reference
from grader.judging.judge import judge
from tests.ungraded_steps import assert_mistakes_have_answers, assert_notes_hold, failures_of
from utils.checks import check
from utils.checks.core import ChecksFailed
from utils.checks.diagnosis import diagnose

LESSON = find_lesson("11_pca_boxes")
NAME = "smallest_rectangle_yaw"
GIVEN = ("turned", "floor_area_at", "principal_axes", "angles")
REFERENCE = load_reference(LESSON.name, NAME, "angles")
ANSWERS = answers_to(NAME)


def function_of(variant):
    namespace = {"np": np} | {name: getattr(REFERENCE, name) for name in GIVEN}
    exec(variant.source, namespace)
    return namespace[NAME]


def test_the_step_has_checks_and_gives_no_points():
    assert LESSON.steps == (NAME,) and NAME not in {exercise.name for exercise in LESSON.exercises}
    assert LESSON.source.read_text("utf-8").count(f"\ncheck({NAME})\n") == 1
    right = [variant.right for variant in ANSWERS]
    assert sum(right) >= 5 and len(right) - sum(right) >= 8


def test_the_solution_passes():
    step = getattr(REFERENCE, NAME)
    assert not failures_of(NAME, step) and diagnose(NAME, step) is None


@pytest.mark.parametrize("variant", [pytest.param(variant, id=variant.name) for variant in ANSWERS])
def test_kept_answers_pass_or_fail_as_claimed(variant):
    function = function_of(variant)
    assert_notes_hold(variant, failures_of(NAME, function), diagnose(NAME, function))


def test_every_known_mistake_has_a_kept_answer():
    assert_mistakes_have_answers(NAME, ANSWERS)


def test_an_index_is_shown_as_an_angle_in_radians(capsys):
    (index,) = (kept for kept in ANSWERS if kept.name == "the index of the smallest area")
    with pytest.raises(ChecksFailed):
        check(function_of(index))
    shown = capsys.readouterr().out
    assert "30.0000 rad, which is 1718.9°" in shown and "0.5236 rad, which is 30°" in shown


@pytest.mark.parametrize("seed", range(5))
def test_the_area_is_nearly_the_smallest_of_all(seed):
    """Compare with Shapely, which tries the edges of the convex hull, not ninety angles."""
    rng = np.random.default_rng(seed)
    points = REFERENCE.turned(rng.uniform(-1, 1, (60, 3)) * [2.1, 0.9, 0.7], rng.uniform(0, 3))
    hull = shapely.oriented_envelope(shapely.multipoints(points[:, :2]))
    area = REFERENCE.floor_area_at(points, REFERENCE.smallest_rectangle_yaw(points))
    assert hull.area <= area + 1e-9 and area == pytest.approx(hull.area, rel=0.03)


CALLS_THE_STEP = """\
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for label in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == label, :3]
        yaw = smallest_rectangle_yaw(points)
        (a, b, c), (d, e, f) = (pick(turned(points, -yaw), axis=0) for pick in (np.min, np.max))
        corners = [(x, y, z) for z in (c, f) for x, y in ((a, b), (d, b), (d, e), (a, e))]
        boxes.append(turned(np.array(corners), yaw))
    return np.array(boxes).reshape(-1, 8, 3)
"""


@pytest.mark.slow
@pytest.mark.parametrize("calls", [True, False])
def test_boxes_earn_all_points_with_the_step_or_without_it(calls, sandbox, tmp_path):
    right = next(variant.source for variant in ANSWERS if variant.right)
    boxes = CALLS_THE_STEP
    if not calls:
        boxes = boxes.replace(
            "smallest_rectangle_yaw(points)", "angles[floor_area_at(points, angles).argmin()]"
        )
    path = tmp_path / f"{LESSON.name}.ipynb"
    path.write_text(
        fill_in(LESSON, {"get_oriented_boxes": boxes} | ({NAME: right} if calls else {})), "utf-8"
    )
    judged = {result.name: result for result in judge(path, 7, sandbox).exercises}
    assert judged["get_oriented_boxes"].score == 20 and NAME not in judged
