"""Tests of the ungraded function in lesson 11, smallest_rectangle_yaw, and of its checks."""

import numpy as np
import pytest
import shapely

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson, load_reference
from grader.judging.judge import judge
from utils.checks import check, checks_of
from utils.checks.core import ChecksFailed, run_check
from utils.checks.diagnosis import diagnose, known_mistakes

LESSON = find_lesson("11_pca_boxes")
NAME = "smallest_rectangle_yaw"
GIVEN = ("turned", "floor_area_at", "principal_axes", "angles")
REFERENCE = load_reference(LESSON.name, NAME, "angles")
ANSWERS = answers_to(NAME)


def function_of(variant):
    namespace = {"np": np} | {name: getattr(REFERENCE, name) for name in GIVEN}
    exec(variant.source, namespace)
    return namespace[NAME]


def failures_of(function):
    outcomes = [run_check(check, function) for check in checks_of(NAME)]
    return {outcome.check.name: outcome for outcome in outcomes if outcome.failure}


def test_the_step_has_checks_and_gives_no_points():
    assert LESSON.steps == (NAME,) and NAME not in {one.name for one in LESSON.exercises}
    assert LESSON.source.read_text("utf-8").count(f"\ncheck({NAME})\n") == 1
    right = [variant.right for variant in ANSWERS]
    assert sum(right) >= 5 and len(right) - sum(right) >= 8


def test_the_solution_passes():
    step = getattr(REFERENCE, NAME)
    assert not failures_of(step) and diagnose(NAME, step) is None


@pytest.mark.parametrize("variant", [pytest.param(variant, id=variant.name) for variant in ANSWERS])
def test_kept_answers_pass_or_fail_as_claimed(variant):
    function = function_of(variant)
    failed = failures_of(function)
    if variant.right:
        assert not failed and diagnose(NAME, function) is None
        return
    assert set(variant.loses) <= set(failed), sorted(failed)
    assert not variant.loses_only or set(failed) <= set(variant.loses), sorted(failed)
    messages = " ".join(f"{one.failure.message} {one.failure.hint} {one.check.hint}"
                    for one in failed.values())  # fmt: skip
    assert variant.says in messages, messages
    mistake = diagnose(NAME, function)
    assert bool(mistake) == bool(variant.told), mistake
    assert variant.told in (mistake.description if mistake else "")


def test_every_known_mistake_has_a_kept_answer():
    claims = [variant.told for variant in ANSWERS if variant.told]
    for mistake in known_mistakes(NAME):
        assert any(words in mistake.description for words in claims), mistake.description


def test_an_index_is_shown_as_an_angle_in_radians(capsys):
    (index,) = (one for one in ANSWERS if one.name == "the index of the smallest area")
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
    judged = {one.name: one for one in judge(path, 7, sandbox).exercises}
    assert judged["get_oriented_boxes"].score == 20 and NAME not in judged
