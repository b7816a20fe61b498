"""Points inside boxes, compared with distances computed by hand."""

import numpy as np
from numpy.testing import assert_allclose

from utils.boxes import Box, distance_outside, inside


def rotate(points, yaw):
    cosine, sine = np.cos(yaw), np.sin(yaw)
    return np.asarray(points) @ [[cosine, sine], [-sine, cosine]]


def test_distance_outside_is_measured_along_the_sides():
    rectangle = np.array([[2.0, 1.0], [-2.0, 1.0], [-2.0, -1.0], [2.0, -1.0]])
    points = np.array([[0.0, 0.0], [2.0, 0.5], [2.5, 0.0], [0.0, -1.5], [2.3, 1.4]])
    expected = [-1.0, 0.0, 0.5, 0.5, 0.4]
    for yaw in (0.0, 0.4, np.pi / 2, -2.0):
        for start in range(4):
            corners = rotate(np.roll(rectangle, start, axis=0), yaw) + (9.0, -4.0)
            measured = distance_outside(rotate(points, yaw) + (9.0, -4.0), corners)
            assert_allclose(measured, expected, atol=1e-12)


def test_distance_outside_works_for_a_line_and_for_a_point():
    line = np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 4.0], [0.0, 0.0]])
    assert_allclose(
        distance_outside(np.array([[1.5, 2.0], [6.0, 8.0], [-0.8, 0.6]]), line), [0, 5, 1]
    )
    assert_allclose(distance_outside(np.array([[1.0, 1.0], [1.5, 3.0]]), np.ones((4, 2))), [0, 2])


def test_a_box_and_its_corners_contain_the_same_points():
    rng = np.random.default_rng(0)
    for yaw in rng.uniform(-4, 4, 50):
        box = Box(tuple(rng.uniform(-9, 9, 3)), tuple(rng.uniform(0.2, 5, 3)), yaw, "car", 1)
        points = box.centre + rng.uniform(-3, 3, (200, 3))
        level = np.abs(points[:, 2] - box.centre[2]) <= box.size[2] / 2
        over = distance_outside(points[:, :2], box.corners[:4, :2]) <= 0
        assert (inside(points, box) == (level & over)).all()
