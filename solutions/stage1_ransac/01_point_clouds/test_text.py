"""Tests of the statements in lesson 01, with answers that follow its hints."""

import timeit
from dataclasses import replace

import nbformat
import numpy as np
import pytest

from grader.course import durations
from grader.course.lessons import find_lesson
from tests.lesson_texts import run_lesson
from utils.scenes import simple_highway
from utils.simulator import hdl64, scenes

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def lesson_run():
    return run_lesson("01_point_clouds")


def test_the_first_exercise_begins_within_five_minutes():
    notebook = nbformat.read(find_lesson("01_point_clouds").solved, as_version=4)
    first = next(i for i, cell in enumerate(notebook.cells) if cell.source.startswith("mine = "))
    before = nbformat.v4.new_notebook(cells=notebook.cells[:first])
    assert sum(durations.section_minutes(before).values()) < 5


def test_tiny_examples_give_the_expected_results(lesson_run):
    assert "yours:    [ 5. 10.  7.]\nexpected: [ 5. 10.  7.]\n" in lesson_run.text
    kept = lesson_run.names["drop_invalid"](lesson_run.names["six"])
    np.testing.assert_array_equal(kept, lesson_run.names["six"][[0, 4, 5]])


def test_a_height_threshold_keeps_only_cars():
    frame = simple_highway()
    on_car = frame.scan.objects > 0
    kept = frame.cloud[:, 2] > -2.5
    assert not (kept & ~on_car).any()
    assert 1 <= (on_car & ~kept).sum() <= 6
    assert set(frame.scan.objects[kept]) == {1, 2, 3}


def test_the_roof_blocks_the_steepest_beam_at_its_four_corners():
    x, y, z = simple_highway().cloud[:, :3].T
    azimuths, elevations = np.degrees(np.arctan2(y, x)), np.degrees(np.arctan2(z, np.hypot(x, y)))
    gaps = {}
    for name, lowest, highest in (("innermost", -32, -28.5), ("third", -25, -22)):
        on_ring = (elevations > lowest) & (elevations < highest)
        seen = np.unique(np.round(azimuths[on_ring] / 2.8125).astype(int) % 128)
        gaps[name] = np.setdiff1d(np.arange(128), seen)
    assert len(gaps["third"]) == 0
    # The corners are at 45, 135, 225 and 315 degrees, which are steps 16, 48, 80 and 112.
    assert len(gaps["innermost"]) == 4 * 7
    assert np.abs(gaps["innermost"] % 32 - 16).max() == 3


def test_the_two_uppermost_rays_meet_the_car_ahead(lesson_run):
    car = max(simple_highway().boxes, key=lambda box: box.centre[0])
    assert (car.centre, car.size) == ((15, 0, -1.6), (4, 2, 2))  # as drawn
    ends = lesson_run.names["ahead"]
    assert np.sum(ends[:, 2] > -2.5) == 2
    assert np.allclose(ends[ends[:, 2] > -2.5, 0], 13.0, atol=0.2)
    assert np.allclose(ends[ends[:, 2] < -2.5, 2], -2.6, atol=0.03)  # the height of the scanner


def test_an_echo_from_120_metres_arrives_within_a_microsecond(lesson_run):
    assert "Even an echo from 120 m arrives within a microsecond." in lesson_run.text
    assert 2 * 120 / lesson_run.names["SPEED_OF_LIGHT"] < 1e-6


def test_four_beams_see_the_cars_and_no_pedestrian(lesson_run):
    assert len(lesson_run.names["cars"]) == 4
    assert len(lesson_run.names["pedestrians"]) == 3
    counted = lesson_run.names["counted"]
    assert min(counted["32 beams"]) >= 8
    last = counted["4 beams"]
    assert min(last[:4]) > 10
    assert sorted(last[4:]) == [0, 1, 2]


def test_marked_objects_vanish_as_described(lesson_run):
    pole, pedestrian = lesson_run.names["marked"]
    assert (pole.kind, pedestrian.kind) == ("pole", "pedestrian")

    def returns(box, **change):
        return np.sum(lesson_run.names["scan_with"](**change).scan.objects == box.identity)

    assert returns(pedestrian) >= 8 and returns(pedestrian, beams=8) == 0
    assert returns(pole) >= 10 and returns(pole, step=4.0) == 0
    assert returns(pole, noise=0.3) == returns(pole)


def test_one_of_six_pedestrians_is_hidden(lesson_run):
    assert lesson_run.names["found"] == 6
    truth = lesson_run.names["truth"]
    near = (truth["box_kinds"] == "pedestrian") & (
        np.abs(truth["box_centres"][:, :2]) < (25, 12)
    ).all(axis=1)
    few = (truth["box_kinds"] == "pedestrian") & (truth["box_returns"] == 9)
    (x, y, _), size = truth["box_centres"][few][0], truth["box_sizes"][few][0]
    assert few.sum() == 1 and size[2] < 1.3
    orange = lesson_run.names["is_near"] & lesson_run.names["on_person"]
    assert set(truth["objects"][orange]) == set(truth["box_identities"][near])
    assert orange.sum() == truth["box_returns"][near].sum()
    # A car parked on the left is between the child and the scanner.
    car = truth["box_centres"][(truth["box_kinds"] == "car")]
    between = [
        centre for centre in car if abs(centre[0] - x * centre[1] / y) < 2.2 and 0 < centre[1] < y
    ]
    assert between


def test_row_length_is_most_wrong_near_the_car(lesson_run):
    x, error = lesson_run.names["strip"][:, 0], lesson_run.names["error"]
    near, far = error[x < 8], error[(x > 10) & (x < 20)]
    assert near.min() > far.max()
    pedestrian = lesson_run.names["strip"][(x > 8.6) & (x < 9.2)]
    lengths = np.linalg.norm(pedestrian, axis=1)
    assert lengths[pedestrian[:, 2].argmin()] > lengths[pedestrian[:, 2].argmax()] + 0.1
    cloud, truth = lesson_run.names["cloud"], lesson_run.names["truth"]
    column = (np.abs(cloud[:, 1]) < 0.3) & (np.abs(cloud[:, 0] - 20.2) < 0.2) & (cloud[:, 2] > -1.2)
    assert {truth["class_names"][value] for value in truth["classes"][column]} == {"car"}


def test_rings_follow_the_curve_only_near_the_car(lesson_run):
    cloud, rings = lesson_run.names["cloud"], lesson_run.names["rings"]
    for side, sign in ((cloud[:, 0] > 2, -1), (cloud[:, 0] < -2, 1)):
        angle, ring = rings(side)
        flat = 1.73 / np.tan(np.radians(angle))
        near = flat < 6
        assert np.abs(ring - flat)[near].max() < 0.6
        assert (sign * (ring - flat)[flat > 15]).min() > 2


def test_the_car_itself_hides_road_in_front_and_behind(lesson_run, monkeypatch):
    steepest = -np.degrees(min(hdl64().elevations))
    assert steepest == pytest.approx(24.8)
    assert 1.73 / np.tan(np.radians(steepest)) == pytest.approx(3.7, abs=0.05)

    def nearest(cloud, azimuth):
        """Return the smallest distance of the road in this direction."""
        distances = lesson_run.names["horizontal_distance"](cloud)
        turned = np.degrees(np.arctan2(cloud[:, 1], cloud[:, 0])) - azimuth
        return distances[(np.abs((turned + 180) % 360 - 180) < 5) & (distances > 2)].min()

    as_seen, observe = lesson_run.names["cloud"], scenes.observe
    monkeypatch.setattr(
        scenes, "observe", lambda world, *rest: observe(replace(world, ego=()), *rest)
    )
    without_car = scenes.lesson_street().cloud
    for azimuth in (0, 180):
        assert nearest(as_seen, azimuth) > nearest(without_car, azimuth) + 1
    assert nearest(as_seen, 90) == pytest.approx(nearest(without_car, 90), abs=0.001)


def test_gaps_grow_faster_than_the_distance(lesson_run):
    places = lesson_run.names["places"]
    at = [np.abs(places - place).argmin() for place in (5, 10, 20, 40)]
    gaps = [places[ring + 1] - places[ring] for ring in at]
    assert all(after > 2 * before for before, after in zip(gaps, gaps[1:], strict=False))


def test_the_nearest_valid_returns_are_the_ego_car(lesson_run):
    assert len(lesson_run.names["too_near"]) == 3 and not lesson_run.names["too_near"][:, :3].any()
    cloud, truth = lesson_run.names["cloud"], lesson_run.names["truth"]
    distance = lesson_run.names["horizontal_distance"](cloud)
    near = (distance < 3) & (distance > 0)
    assert {truth["class_names"][value] for value in truth["classes"][near]} == {"ego"}
    assert distance[near].min() >= 1 and distance[near].max() < 2
    # Three groups of points: a mirror in front, the tailgate and the aerial behind.
    ahead, left = cloud[near, 0] > 0, cloud[near, 1] > 0
    assert [np.any(value) for value in (ahead & left, ~ahead & left, ~ahead & ~left)] == [True] * 3


def test_only_the_bar_at_zero_changes(lesson_run):
    assert "bars that changed, by their left edge: [0] m" in lesson_run.text
    before, after = lesson_run.names["bars"]["before"], lesson_run.names["bars"]["after"]
    assert before[0] >= 4000 - 40 and after[0] == 0


def test_without_the_square_root_the_radius_is_the_root_of_ten(lesson_run):
    cloud = lesson_run.names["cloud"]
    kept = cloud[lesson_run.names["wrong"]["no square root"] <= 10]
    assert lesson_run.names["horizontal_distance"](kept).max() < 3.2


def test_the_loop_is_much_slower(lesson_run):
    times = lesson_run.names["times"]
    assert times["loop"][-1] > 20 * times["yours"][-1]

    def shortest_time(n):
        """Return the shortest of many runs, because other load on the machine only adds time."""
        cloud, function = lesson_run.names["cloud"][:n], lesson_run.names["horizontal_distance"]
        return min(timeit.repeat(lambda: function(cloud), number=20, repeat=40))

    assert shortest_time(100) < 20 * shortest_time(1)  # with few points, the overhead dominates


def test_the_answer_about_the_pedestrian_is_right():
    upper = np.degrees(hdl64().elevations)[:32]
    assert np.diff(upper) == pytest.approx(-1 / 3, abs=0.01)
    across, up = 0.5 / np.radians(0.18), 1.7 / np.radians(1 / 3)
    as_written = 0.5 / 0.00314 * 1.7 / 0.00582
    assert as_written == pytest.approx(across * up, rel=0.001)
    assert across * up == pytest.approx(46_500, abs=50)
    assert np.sqrt(across * up / 10) == pytest.approx(68, abs=1)
