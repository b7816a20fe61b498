"""Messages and pictures of the box checks."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from grader.course.lessons import load_reference
from utils.checks import CheckFailed, boxes
from utils.checks.boxes import assert_box_corners, assert_contains_points, corners_between
from utils.checks.core import notes_of, run_check

CORNERS = {
    "zigzag": [0, 1, 3, 2, 4, 5, 7, 6],
    "roof corners first": [4, 5, 6, 7, 0, 1, 2, 3],
    "the roof from another corner": [0, 1, 2, 3, 5, 6, 7, 4],
}


def notes_for(exercise, function):
    """Return the names of the notes that `check` would show for a function."""
    return {note.name for note in notes_of(exercise) if run_check(note, function).failure}


@pytest.mark.parametrize(
    "exercise, name, note",
    [
        ("get_bounding_boxes", "08_bounding_boxes", "numbers_the_corners"),
        ("get_oriented_boxes", "11_pca_boxes", "orders_the_corners"),
    ],
)
def test_corners_in_another_order_get_a_note(exercise, name, note):
    right = getattr(load_reference(name), exercise)
    assert notes_for(exercise, right) == set()
    for order in CORNERS.values():
        assert notes_for(exercise, lambda *given, order=order: right(*given)[:, order]) == {note}


def test_a_list_of_boxes_gets_a_note():
    for exercise, name, note in (
        ("get_bounding_boxes", "08_bounding_boxes", "returns_an_array"),
        ("get_oriented_boxes", "11_pca_boxes", "returns_boxes_as_an_array"),
    ):
        right = getattr(load_reference(name), exercise)
        assert notes_for(exercise, lambda *given, right=right: right(*given).tolist()) == {note}


def test_axes_as_lists_get_a_note():
    right = load_reference("11_pca_boxes").principal_axes
    assert notes_for("principal_axes", right) == set()
    assert notes_for("principal_axes", lambda points: right(points).tolist()) == {
        "returns_an_array"
    }


def limits_of(failure):
    failure.draw()
    axes = plt.gcf().axes[0]
    limits = np.array([axes.get_xlim(), axes.get_ylim()])
    plt.close("all")
    return limits


@pytest.mark.parametrize("shift", [0.0, 12.0])
def test_the_picture_contains_the_box_and_its_cluster(shift):
    cloud = np.random.default_rng(0).uniform(-1, 1, (50, 3)) * [4, 2, 1] + [9, 5, 0]
    labels = np.ones(50, dtype=int)
    box = corners_between([8.9 + shift, 4.9, -1], [9.1 + shift, 5.1, 1])[None]
    for check in (
        lambda: assert_contains_points(box, cloud, labels),
        lambda: assert_box_corners(
            box, corners_between(cloud.min(axis=0), cloud.max(axis=0))[None], cloud, labels
        ),
    ):
        with pytest.raises(CheckFailed) as caught:
            check()
        limits = limits_of(caught.value)
        for part in (cloud, box[0]):
            assert (limits[:, 0] < part[:, :2].min(axis=0)).all()
            assert (limits[:, 1] > part[:, :2].max(axis=0)).all()


def test_messages_use_singular_and_plural():
    one_cluster = np.ones(3, dtype=int)
    box = corners_between([0, 0, 0], [1, 1, 1])
    with pytest.raises(CheckFailed, match=" 2 boxes for 1 cluster.$"):
        assert_box_corners(np.stack([box, box]), box[None], np.zeros((3, 3)), one_cluster)
    with pytest.raises(CheckFailed, match=" 1 box for 2 clusters.$"):
        assert_box_corners(box[None], np.stack([box, box]), np.zeros((3, 3)), np.array([1, 1, 2]))


def test_the_picture_shows_the_axis_in_the_message():
    """The message names y, so the picture is not a side view, which would hide y."""
    points = np.array([[-2.0, -1.5, -1.2], [3.0, 2.5, 0.8]])
    right = corners_between(*points)
    wrong = corners_between(points[0], np.full(3, 3.0))
    with pytest.raises(CheckFailed, match="largest y") as caught:
        assert_box_corners(wrong[None], right[None], points, np.ones(2, dtype=int))
    caught.value.draw()
    assert "y" in plt.gca().get_ylabel()
    plt.close("all")


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("end", range(2))
def test_the_picture_circles_a_right_corner_that_the_answer_lacks(axis, end, monkeypatch):
    points = np.array([[4.0, 1.0, -1.5], [6.0, 3.0, 0.2], [5.0, 2.0, -0.4]])
    ends = np.array([points.min(axis=0), points.max(axis=0)])
    right = corners_between(*ends)
    ends[end, axis] = 0.6 * ends[end, axis] + 0.4 * ends[1 - end, axis]
    wrong, drawn = corners_between(*ends), []
    with pytest.raises(CheckFailed) as caught:
        assert_box_corners(wrong[None], right[None], points, np.ones(3, dtype=int))
    monkeypatch.setattr(boxes, "_draw_box", lambda *about: drawn.append(about))
    caught.value.draw()
    [(_, _, _, [circled], view, _)] = drawn
    columns = [0, 1] if view == "above" else [0, 2]
    gaps = np.abs(wrong[:, columns] - circled[columns]).max(axis=1)
    assert gaps.min() > 0.2
    assert (right == circled).all(axis=1).any()


def test_the_hint_distinguishes_a_repeated_corner_from_a_leaning_box():
    cloud = np.random.default_rng(0).uniform(-1, 1, (50, 3)) * [4, 2, 1]
    labels = np.ones(50, dtype=int)
    box = corners_between([-4, -2, -1], [4, 2, 1])
    repeated, leaning = box.copy(), box.copy()
    first, second, *_ = floor = np.flatnonzero(box[:, 2] == -1)
    repeated[second] = box[first]
    leaning[floor, 0] += 0.5
    for wrong, hint in ((repeated, "one corner occurs twice"), (leaning, "about z only")):
        with pytest.raises(CheckFailed) as failure:
            boxes.assert_upright(wrong[None], cloud, labels)
        assert hint in failure.value.hint
