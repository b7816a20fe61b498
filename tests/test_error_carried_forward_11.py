"""Lesson 11: get_oriented_boxes calls principal_axes, but loses points only for its own faults."""

import pytest

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.judging.judge import judge
from tests.slip_tables import solution_of
from utils.checks import check
from utils.checks.core import ChecksFailed

pytestmark = pytest.mark.slow

LESSON = find_lesson("11_pca_boxes")
# An answer that follows the lesson's hints and calls the notebook's principal_axes.
AS_HINTED = """\
def get_oriented_boxes(cloud, cluster_labels):
    names = np.unique(cluster_labels[cluster_labels > 0])
    boxes = np.zeros((len(names), 8, 3))
    for row, name in enumerate(names):
        points = cloud[cluster_labels == name, :3]
        first = principal_axes(points * [1, 1, 0])[:, 0]
        yaw = np.arctan2(first[1], first[0])
        local = turned(points, -yaw)
        (x, y, z), (to_x, to_y, to_z) = local.min(axis=0), local.max(axis=0)
        around = [(x, y), (to_x, y), (to_x, to_y), (x, to_y)]
        box = np.array([(a, b, c) for c in (z, to_z) for a, b in around])
        boxes[row] = turned(box, yaw)
    return boxes
"""
BOTH_PLUS = AS_HINTED.replace("turned(points, -yaw)", "turned(points, yaw)")
STUB = "def principal_axes(points):\n    raise NotImplementedError\n"


def wrong_axes(name):
    return next(answer.source for answer in answers_to("principal_axes") if answer.name == name)


def results(axes, boxes, sandbox, folder):
    """Judge the two answers; return the results of both exercises by name."""
    path = folder / f"{LESSON.name}.ipynb"
    answers = {"principal_axes": axes, "get_oriented_boxes": boxes}
    path.write_text(fill_in(LESSON, answers), "utf-8")
    return {exercise.name: exercise for exercise in judge(path, 7, sandbox).exercises}


@pytest.mark.parametrize(
    "axes, least",
    [
        (STUB, 0),
        # A single missing [:, ::-1] used to cost all 30 points of the lesson.
        (wrong_axes("columns left in ascending order"), 6),
        (wrong_axes("np.cov of rows instead of columns"), 0),
    ],
    ids=["stub", "ascending", "np.cov of rows"],
)
def test_right_boxes_over_wrong_axes_earn_everything(axes, least, sandbox, tmp_path):
    judged = results(axes, AS_HINTED, sandbox, tmp_path)
    boxes = judged["get_oriented_boxes"]
    assert boxes.score == boxes.max_score == 20
    assert "principal_axes, which get_oriented_boxes calls, is wrong" in boxes.cause
    assert "not started" not in boxes.cause
    assert least <= judged["principal_axes"].score < 10


def test_axes_in_a_list_cost_nothing(sandbox, tmp_path):
    """The hint's principal_axes(...)[:, 0] does not work on a list."""
    axes = solution_of("principal_axes")
    in_a_list = axes.replace("def principal_axes(", "def axes_of(") + (
        "\n\ndef principal_axes(points):\n    return axes_of(points).tolist()\n"
    )
    judged = results(in_a_list, AS_HINTED, sandbox, tmp_path)
    assert all(result.score == result.max_score for result in judged.values())
    assert "principal_axes, which get_oriented_boxes calls, is right" in (
        judged["get_oriented_boxes"].cause
    )


@pytest.mark.parametrize("axes", ["not centred", "sometimes left-handed"])
def test_other_wrong_axes_do_not_cost_points_for_the_boxes(axes, sandbox, tmp_path):
    assert results(wrong_axes(axes), AS_HINTED, sandbox, tmp_path)["get_oriented_boxes"].score == 20


def test_wrong_boxes_keep_their_own_mistake(sandbox, tmp_path):
    boxes = results(STUB, BOTH_PLUS, sandbox, tmp_path)["get_oriented_boxes"]
    assert 0 < sum(test.score for test in boxes.tests) < 12
    assert "principal_axes, which get_oriented_boxes calls, is wrong" in boxes.cause
    assert "is outside" in boxes.cause or "are outside" in boxes.cause


def test_a_notebook_names_the_unwritten_function(capsys):
    namespace = {}
    exec("import numpy as np\n" + STUB + AS_HINTED, namespace)
    with pytest.raises(ChecksFailed, match="calls principal_axes, which is not written yet"):
        check(namespace["get_oriented_boxes"])
    assert "get_oriented_boxes is not started" not in capsys.readouterr().out
