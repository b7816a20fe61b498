"""A car that follows the boxes of a detector: single rules and whole drives."""

import copy
import importlib
import json
import re
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from sklearn.cluster import DBSCAN

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import all_lessons
from utils.drive import STREETS, Trip, askew, chain, drive_street, occupied_squares, on_time
from utils.drive import __main__ as command
from utils.drive.actors import Actor, car_ahead, child
from utils.drive.clock import Clock, ticks
from utils.drive.ground_truth import distances_to_objects
from utils.drive.loop import drive
from utils.drive.metrics import measure
from utils.drive.motion import Motion, make_motion, match_by_total_distance
from utils.drive.person import BRAKING_RANGE, SCENERY, look_at_person, street_with_person
from utils.drive.planner import Planner, TrackedBox, braking_gap, gap_to, plan
from utils.drive.rules import stopping_distance
from utils.drive.standards import DriveResult, reference_results
from utils.drive.streets import Street
from utils.play import load_detector
from utils.progress import progress
from utils.simulator.pose import Pose
from utils.simulator.scanner import CLASSES
from utils.simulator.sensor import Sensor, layers
from utils.simulator.streets import StreetPlan, placed
from utils.simulator.traffic import pedestrian
from utils.simulator.world import World
from utils.tracking import Tracker

COARSE_SENSOR = Sensor(layers(12, 1.0, -12.0), np.radians(1.5), maximum_range=40.0)
NARROW_SENSOR = Sensor(layers(2, 0.0, -1.0), np.radians(90), maximum_range=5.0)
EMPTY_PLAN = StreetPlan(parked=np.inf, furniture=np.inf, walkers=np.inf)


def box(x, y, length=1.0, width=1.0):
    """Return the corners (8, 3) of a box with its nearest face at x and its centre at y."""
    floor = [(x, y - width / 2), (x + length, y - width / 2)]
    floor += [(x + length, y + width / 2), (x, y + width / 2)]
    return np.array([(*corner, z) for z in (-1.7, 0.0) for corner in floor])


def tracked_box(x, y=0.0, forward=0.0, left=0.0, seen=True, name=0, **size):
    return TrackedBox(box(x, y, **size), (forward, left), seen, name)


def empty_street(**settings):
    """Return an empty street."""
    return Street(99, "A made-up street", plan=EMPTY_PLAN, **settings)


def find_nothing(cloud):
    return np.empty((0, 8, 3))


# The planner -------------------------------------------------------------------------------


# Computed by hand: the distance in 0.5 s, plus the square of the speed divided by 14 m/s².
@pytest.mark.parametrize(
    ("speed", "metres"), [(0, 0.0), (7, 3.5 + 3.5), (14, 7.0 + 14.0), (2.8, 1.4 + 0.56)]
)
def test_the_stopping_distance_agrees_with_lesson_07(speed, metres):
    assert stopping_distance(speed) == pytest.approx(metres)


def test_the_car_reaches_the_speed_limit_on_a_free_road():
    assert plan(5.0, 8.0, []).acceleration == 2.0
    assert plan(7.9, 8.0, []).acceleration == pytest.approx(0.2)
    assert plan(8.0, 8.0, []).acceleration == 0.0
    assert plan(9.0, 8.0, []).acceleration < 0


# The bumper is at 2.6 m. At 7 m/s, the car needs 7 m to stop, and it keeps a gap of 2 m.
@pytest.mark.parametrize(("x", "brakes"), [(2.6 + 8.9, True), (2.6 + 9.1, False)])
def test_the_car_brakes_for_obstacles_within_the_stopping_distance(x, brakes):
    decision = plan(7.0, 7.0, [tracked_box(x)])
    assert (decision.acceleration <= -1) == brakes
    assert (decision.cause is not None) == brakes
    if brakes:
        # The deceleration v² / 2d over the remaining 6.9 m is 3.55 m/s².
        assert decision.acceleration == pytest.approx(-49 / (2 * 6.9))
        assert decision.gap == pytest.approx(8.9)


def test_the_car_brakes_fully_for_obstacles_that_are_too_near():
    assert plan(7.0, 7.0, [tracked_box(2.6 + 4.0)]).acceleration == -7.0


# The corridor extends 1.3 m to either side: half the car's width plus 0.4 m. The box is 1 m wide.
@pytest.mark.parametrize("y", [1.79, -1.79])
def test_boxes_that_reach_into_the_corridor_count(y):
    assert gap_to(tracked_box(10.0, y), 7.0) == pytest.approx(7.4)


@pytest.mark.parametrize("y", [1.81, -1.81])
def test_boxes_next_to_the_corridor_do_not_count(y):
    assert gap_to(tracked_box(10.0, y), 7.0) == np.inf
    assert plan(7.0, 7.0, [tracked_box(5.0, y)]).cause is None


# The nearest corner of a square, turned by 45 degrees, is 10 m ahead. The corridor reaches 1.3 m
# to either side.
@pytest.mark.parametrize(
    ("y", "metres"), [(0.0, 10 - 2.6), (3.3, 10 + 2.0 - 2.6), (-3.3, 10 + 2.0 - 2.6), (5.4, np.inf)]
)
def test_only_the_part_of_a_turned_box_in_the_corridor_counts(y, metres):
    half = 4.0
    ring = [(10.0, y), (10.0 + half, y - half), (10.0 + 2 * half, y), (10.0 + half, y + half)]
    corners = np.array([(*corner, z) for z in (-1.7, 0.0) for corner in ring])
    assert gap_to(TrackedBox(corners), 7.0) == pytest.approx(metres)


def box_along(axes, points):
    """Return the upright box along two axes around points seen from above."""
    seen = points @ axes
    (a, c), (b, d) = seen.min(axis=0), seen.max(axis=0)
    floor = np.array([(a, c), (b, c), (b, d), (a, d)]) @ axes.T
    return TrackedBox(np.array([(*corner, z) for z in (-1.7, 0.0) for corner in floor]))


def test_the_car_brakes_for_a_parked_car_only_if_its_box_leans():
    """The principal axes of an L lean (lesson 11), whatever their order and signs."""
    side = np.c_[np.linspace(6.3, 10.5, 85), np.full(85, -2.1)]
    rear = np.c_[np.full(37, 6.3), np.linspace(-3.9, -2.1, 37)]
    points = np.vstack([side, rear])
    assert plan(7.0, 7.0, [box_along(np.eye(2), points)]).cause is None
    _, axes = np.linalg.eig(np.cov(points.T))
    decisions = [
        plan(7.0, 7.0, [box_along(order, points)]) for order in (axes, axes[:, ::-1], -axes)
    ]
    assert all(decision.acceleration < -3.0 for decision in decisions)
    assert np.ptp([decision.gap for decision in decisions]) < 1e-9


def test_obstacles_moving_into_the_corridor_are_counted():
    # At 7 m/s the ego car stops after 1.5 s. The obstacle has to move by 2.2 m, from 4 m to 1.8 m.
    assert gap_to(tracked_box(10.0, 4.0, left=-1.5), 7.0) == pytest.approx(7.4)
    assert gap_to(tracked_box(10.0, 4.0, left=-1.4), 7.0) == np.inf
    assert gap_to(tracked_box(10.0, 4.0, left=1.5), 7.0) == np.inf


def test_obstacles_behind_the_car_do_not_count():
    assert plan(7.0, 7.0, [tracked_box(-3.0)]).cause is None


def test_a_box_on_the_bonnet_stops_the_car_forever():
    decision = plan(7.0, 7.0, [tracked_box(0.9, length=1.4)])
    assert decision.acceleration == -7.0
    assert plan(0.0, 7.0, [tracked_box(0.9, length=1.4)]).acceleration <= 0.0
    along = tracked_box(0.9, length=1.4, forward=7.0)  # to a tracker, it moves with the ego car
    assert plan(7.0, 7.0, [along]).acceleration == -7.0


def test_the_gap_to_a_moving_car_may_be_smaller():
    # If both cars drive at 7 m/s, the ego car needs the distance that it covers in 0.5 s, plus 2 m.
    assert braking_gap(tracked_box(10.0, forward=7.0), 7.0) == pytest.approx(5.5)
    assert braking_gap(tracked_box(10.0), 7.0) == pytest.approx(9.0)
    assert plan(7.0, 7.0, [tracked_box(2.6 + 6.0, forward=7.0)]).acceleration == 0.0


def test_the_car_slows_down_gently_behind_a_slow_car():
    decision = plan(7.0, 7.0, [tracked_box(2.6 + 14.0, forward=4.0)])
    assert -1.01 < decision.acceleration < 0


def test_the_most_urgent_obstacle_decides():
    near, far = tracked_box(2.6 + 6.0), tracked_box(2.6 + 8.0)
    assert plan(7.0, 7.0, [far, near]).cause is near


def test_a_stopped_car_starts_when_there_is_room_again():
    assert plan(0.0, 7.0, [tracked_box(2.6 + 2.5)]).acceleration == 0.0
    assert plan(0.0, 7.0, [tracked_box(2.6 + 3.5)]).acceleration == 2.0


def test_the_car_brakes_for_an_obstacle_in_three_consecutive_scans():
    planner, near = Planner(), [tracked_box(2.6 + 6.0)]
    first, second, third = (planner.decide(7.0, 8.0, near) for _ in range(3))
    assert first.acceleration == second.acceleration == 0.0, "the car does not accelerate either"
    assert third.acceleration < -1 and third.cause is near[0]
    assert planner.decide(7.0, 8.0, []).acceleration > 0
    assert planner.decide(7.0, 8.0, near).cause is None, "the count starts again"


def decide(*scans, speed=7.0):
    """Return the planner's decision for each scan; a scan is a list of tracked boxes."""
    planner = Planner()
    return [planner.decide(speed, 8.0, tracks) for tracks in scans]


def test_obstacles_in_the_lane_for_a_single_scan_do_not_stop_the_car():
    """A raindrop next to a lorry extends the lorry's box into the ego car's lane for one scan."""
    next_to_lane = [tracked_box(2.6 + 6.0, 1.9, name=name) for name in range(3)]
    in_lane = [tracked_box(2.6 + 6.0, 1.6, name=name) for name in range(3)]
    scans = [[in_lane[k] if k == scan else next_to_lane[k] for k in range(3)] for scan in range(3)]
    assert [decision.cause for decision in decide(*scans)] == [None, None, None]
    assert [decision.acceleration for decision in decide(*scans)] == [0.0, 0.0, 0.0]
    decisions = decide(*[[*scan, in_lane[0]] for scan in scans[1:]], scans[0])
    assert decisions[-1].cause is in_lane[0], "one of the obstacles stays in the lane"


def test_a_track_over_the_car_counts_only_if_it_is_usually_seen():
    """A track that coasts with the ego car counts only if it is seen in most scans."""
    drops = [tracked_box(0.9, length=1.4, seen=scan % 3 == 0) for scan in range(24)]
    assert {decision.cause for decision in decide(*([drop] for drop in drops))} == {None}
    dirt = [tracked_box(0.9, length=1.4, seen=scan % 3 > 0) for scan in range(24)]
    assert decide(*([patch] for patch in dirt))[-1].cause is dirt[-1]


def test_raindrops_over_the_car_do_not_stop_it():
    """In each scan, the raindrops are at least half a metre from those in the previous scan."""
    ends = np.tile([0.2, 1.4, 0.7, 1.9, -0.8], 12)
    for decision in decide(*([tracked_box(end, length=1.0)] for end in ends)):
        assert decision.cause is None and decision.acceleration > 0


def test_dirt_on_the_bonnet_stops_the_car_after_a_second():
    ends = 0.9 + np.tile([0.0, 0.1, -0.1], 5)  # varies because voxels have sides of 0.2 m
    brakes = [
        decision.cause is not None
        for decision in decide(*([tracked_box(end, length=1.4)] for end in ends))
    ]
    assert brakes == [False] * 11 + [True] * 4, "ten scans in one place and three in the lane"


def test_the_car_brakes_as_soon_as_a_hidden_person_steps_off_the_kerb():
    """The car brakes whatever the distance to the person, with and without raindrops."""
    drops, nothing = [tracked_box(0.5)], []
    for metres in (0.1, 1.0, 6.0):
        person = tracked_box(2.6 + metres, -1.5, length=0.5, width=0.5)
        for before in (nothing, drops):
            decisions = decide(before, *[[*before, person]] * 3)
            assert [decision.cause for decision in decisions] == [None, None, None, person]
            assert decisions[-1].acceleration < -3


def test_road_users_who_approach_from_the_side_count_as_ahead():
    """Their predicted position overlaps the ego car, although their present one does not."""
    cyclist = tracked_box(9.0, 4.0, forward=-6.0, left=-2.0, length=1.8, width=0.6)
    assert gap_to(cyclist, 8.0) < -0.5
    assert decide(*[[cyclist]] * 3, speed=8.0)[-1].cause is cyclist


def test_boxes_that_extend_forward_from_the_car_count_as_ahead():
    """Such boxes may contain raindrops and a person 2 m ahead, or all points of a scan."""
    both, everything = (
        tracked_box(0.5, length=4.6),
        [tracked_box(-20.0 - jump, length=60.0) for jump in (0, 3)],
    )
    assert decide(*[[both]] * 3)[-1].cause is both
    assert decide(*([box] for box in everything * 2))[-1].cause is everything[1]


def test_the_car_waits_for_a_person_next_to_the_bumper():
    """A person next to the bumper counts, even if the box begins behind the bumper."""
    person = tracked_box(2.2, 1.2, length=0.5, width=0.5)
    assert decide(*[[person]] * 4, speed=0.0)[-1].cause is person


# Motion ------------------------------------------------------------------------------------


def test_speeds_over_ground_are_estimated_from_a_moving_car():
    motion = Motion()
    for scan in range(30):
        time = scan / 10
        # The ego car drives at 6 m/s towards a parked box. A pedestrian crosses at 1.4 m/s.
        boxes = np.stack([box(30 - 6 * time, 5), box(25 - 6 * time, -4 + 1.4 * time)])
        tracks = motion.update(boxes, 0.6 if scan else 0.0, 0.1)
    parked, walker = (np.array(track.velocity) for track in tracks)
    assert np.allclose(parked, 0.0, atol=0.1)
    assert np.allclose(walker, (0.0, 1.4), atol=0.1)


def test_a_jumping_box_has_no_speed():
    """A box may jump because it grows to include a neighbouring obstacle."""
    motion = Motion()
    for scan in range(14):
        aside = 5.0 - 1.2 * (scan >= 7)
        (parked,) = motion.update(box(30 - 0.6 * scan, aside)[None], 0.6, 0.1)
        assert parked.velocity == (0.0, 0.0)


STEPS = {
    "predict": lambda boxes, velocities, seconds: boxes + velocities[:, None] * seconds,
    "correct": lambda expected, velocities, found, gain, seconds: (
        found + (1 - gain) * (expected - found).mean(axis=1, keepdims=True),
        velocities + gain**2 / (2 - gain) * (found - expected).mean(axis=1) / seconds,
    ),
    "coast": lambda missed, partners, patience: (missed + 1, missed < patience),
}
ALPHA_BETA = Tracker(match_by_total_distance, **STEPS)


@pytest.mark.parametrize("tracker", [None, ALPHA_BETA], ids=["the given motion", "a tracker"])
@pytest.mark.parametrize("side", [-1, 1])
def test_a_car_whose_box_shrinks_to_one_side_has_no_speed(tracker, side):
    """From the tenth scan on, the box contains only the side that faces the ego car's lane."""
    motion = make_motion(tracker)
    for scan in range(20):
        width = 1.6 if scan < 10 else 0.15
        aside = side * (1.9 + width / 2)
        (car,) = motion.update(box(30 - 0.6 * scan, aside, 4.0, width)[None], 0.6, 0.1)
        assert car.velocity[1] == 0.0, scan


def match_all_with_first(previous, current, max_distance):
    """Wrongly match every box with the first one."""
    return np.full(len(current), -1 if len(previous) == 0 else 0)


@pytest.mark.parametrize("match", [match_all_with_first, lambda *_: np.full(6, 9)])
def test_a_wrong_match_does_not_end_a_drive(match):
    tracker = copy.copy(ALPHA_BETA)
    tracker.match = match
    for motion in (make_motion(tracker), make_motion(Tracker(match))):
        for scan in range(8):
            boxes = np.stack([box(10 * row, 3 * row - 0.1 * scan) for row in range(6)])
            tracks = motion.update(boxes, 0.6, 0.1)
            assert np.isfinite([track.velocity for track in tracks]).all()
            assert len(tracks) >= 6


@pytest.mark.parametrize("tracker", [None, ALPHA_BETA], ids=["the given motion", "a tracker"])
def test_an_obstacle_keeps_its_track_id_and_coasts_while_unseen(tracker):
    motion = make_motion(tracker)
    scans = [motion.update(np.stack([box(20, 5), box(25, -4 + 0.14 * scan)]), 0.0, 0.1)
             for scan in range(8)]  # fmt: skip
    assert len({tuple(track.track_id for track in tracks) for tracks in scans}) == 1
    (stays, gone) = motion.update(box(20, 5)[None], 0.0, 0.1)
    assert [stays.track_id, gone.track_id] == [track.track_id for track in scans[-1]]
    assert stays.was_seen and not gone.was_seen
    assert gone.velocity == pytest.approx((0.0, 1.4), abs=0.15), "at its observed speed"


@pytest.mark.parametrize(("scans", "is_kept"), [(1, False), (2, False), (3, True)])
def test_an_unseen_obstacle_counts_only_if_its_track_is_confirmed(scans, is_kept):
    def confirm(hits, partners, needed):
        counts = np.array([hits[partner] + 1 if partner >= 0 else 1 for partner in partners], int)
        return counts, counts >= needed

    motion = make_motion(Tracker(match_by_total_distance, **STEPS, confirm=confirm))
    for _ in range(scans):
        assert len(motion.update(box(20, 0)[None], 0.0, 0.1)) == 1, "while it has a box"
    assert len(motion.update(np.empty((0, 8, 3)), 0.0, 0.1)) == is_kept


def test_a_new_track_has_no_speed_for_three_scans():
    motion = Motion()
    for scan in range(3):
        (newcomer,) = motion.update(box(20, 5 - scan)[None], 0.0, 0.1)
        assert newcomer.velocity == (0.0, 0.0)


def test_a_flickering_box_is_kept_for_three_scans():
    motion, none = Motion(), np.empty((0, 8, 3))
    for _ in range(2):
        motion.update(box(20, 0)[None], 0.0, 0.1)
    assert [len(motion.update(none, 0.5, 0.1)) for _ in range(4)] == [1, 1, 1, 0]
    motion.update(box(20, 0)[None], 0.0, 0.1)
    assert motion.update(none, 0.0, 0.1) == [], "seen only once"


def test_a_coasting_obstacle_approaches_as_the_car_drives():
    motion = Motion()
    for _ in range(2):
        motion.update(box(20, 0)[None], 0.0, 0.1)
    (coasting,) = motion.update(np.empty((0, 8, 3)), 0.5, 0.1)
    assert coasting.corners[:, 0].min() == pytest.approx(19.5)


def test_the_students_matching_function_is_called():
    calls = []

    def match_boxes(previous, current, max_distance):
        calls.append((len(previous), len(current), max_distance))
        return match_by_total_distance(previous, current, max_distance)

    motion = Motion(match_boxes)
    motion.update(np.stack([box(10, 0), box(20, 0)]), 0.0, 0.1)
    motion.update(box(10, 0)[None], 0.0, 0.1)
    assert calls == [(0, 2, 1.5), (2, 1, 1.5)]


@pytest.mark.parametrize(
    ("partners", "message"),
    [
        (lambda count: [0] * (count - 1), "match_boxes returned 0 numbers for 1 boxes"),
        (lambda count: 1 / 0, "ZeroDivisionError: division by zero"),
        (lambda count: ["first"], "ValueError: invalid literal"),
    ],
)
def test_a_matching_function_that_fails_is_reported_as_a_problem(partners, message):
    def match_boxes(previous, current, max_distance):
        return partners(len(current))

    result = drive(
        *(empty_street(), lambda cloud: box(20, 0)[None], Tracker(match_boxes)),
        seconds=0.5,
        sensor=NARROW_SENSOR,
        clock=on_time,
    )
    assert result.moments[-1].number == 4
    assert len(result.problems) >= 2 and all(message in problem for problem in result.problems)


def test_the_students_tracker_estimates_velocities():
    """The estimates are right although the tracker uses ego coordinates, where parked cars move."""
    for _ in range(2):  # the second drive starts without tracks
        motion = make_motion(ALPHA_BETA)
        for scan in range(20):
            boxes = np.stack([box(30 - 0.6 * scan, 5), box(20 - 0.6 * scan, -4 + 0.14 * scan)])
            tracks = motion.update(boxes, 0.6, 0.1)
            if scan < 3:
                assert {track.velocity for track in tracks} == {(0.0, 0.0)}
        assert np.allclose([track.velocity for track in tracks], [(0, 0), (0, 1.4)], atol=0.1)


def test_a_tracker_predicts_each_scan_with_the_time_since_the_last():
    intervals = []

    def predict(boxes, velocities, seconds):
        intervals.append(seconds)
        return boxes + velocities[:, None] * seconds

    tracker = Tracker(
        match_by_total_distance,
        predict=predict,
        correct=lambda expected, velocities, found, gain, seconds: (found, velocities),
    )
    boxes = np.stack([box(12, 5), box(20, -5)])
    driven = drive(STREETS[0], lambda cloud: boxes, tracker, seconds=1.0, clock=on_time,
                   sensor=NARROW_SENSOR)  # fmt: skip
    assert len(driven.moments) == 10 and np.allclose(intervals, 0.1) and len(intervals) == 8


def test_a_tracker_that_only_matches_gets_default_steps():
    motion = make_motion(Tracker(match_by_total_distance))
    for scan in range(10):
        (walker,) = motion.update(box(20 - 0.6 * scan, -4 + 0.14 * scan)[None], 0.6, 0.1)
    assert np.allclose(walker.velocity, (0.0, 1.4), atol=0.1)


def test_matches_are_near_and_one_to_one():
    before, now = np.stack([box(0, 0), box(10, 0)]), np.stack([box(0.8, 0), box(0.3, 0), box(9, 0)])
    assert match_by_total_distance(before, now, 1.2).tolist() == [-1, 0, 1]
    assert match_by_total_distance(before, now, 0.9).tolist() == [-1, 0, -1]
    assert match_by_total_distance(before[:0], now, 1.0).tolist() == [-1, -1, -1]


# Actors ------------------------------------------------------------------------------------


def test_an_actor_waits_for_its_start_and_follows_its_speeds():
    actor = Actor(placed(pedestrian(), 50.0, -5.0, np.pi / 2), 20.0, ((0, 2.0), (2, 0.0)))
    assert actor.at(7.0, None).pose.y == -5.0
    slowing = actor.at(7.0 + 1.0, 7.0)
    # Slowing down evenly from 2 m/s to 1 m/s within a second takes 1.5 m.
    assert slowing.pose.y == pytest.approx(-3.5) and slowing.speed == pytest.approx(1.0)
    assert actor.at(30.0, 7.0).pose.y == pytest.approx(-3.0)


def test_a_car_ahead_drives_before_its_changes_of_speed_begin():
    actor = car_ahead(20.0, 5.0, 30.0, (0, 5.0), (1, 0.0))
    assert actor.at(4.0, None).pose.x == pytest.approx(40.0)
    assert actor.at(6.0, 4.0).pose.x == pytest.approx(42.5)


def test_a_crossing_child_is_in_the_lane_when_the_car_arrives():
    actor, speed = child(70.0, 8.0), 8.0
    arrives = (70.0 - 2.6) / speed
    walker = actor.at(arrives, actor.start_position / speed)
    assert walker.pose.y == pytest.approx(-1.2, abs=0.01)


def test_actors_start_when_the_car_reaches_a_position():
    street = empty_street(actors=(child(60.0, 30 / 3.6),))
    begun = [
        moment.position
        for moment in drive(
            street, find_nothing, seconds=6.0, clock=on_time, sensor=COARSE_SENSOR
        ).moments
        if moment.start_times
    ]
    assert street.actors[0].start_position <= begun[0] < street.actors[0].start_position + 1.0


# The loop ----------------------------------------------------------------------------------


def test_drives_are_reproducible():
    first, second = (
        drive(STREETS[8], occupied_squares, seconds=0.6, clock=on_time, sensor=COARSE_SENSOR)
        for _ in range(2)
    )
    assert [m.position for m in first.moments] == [m.position for m in second.moments]
    assert np.array_equal(first.frame(5).cloud, second.frame(5).cloud)
    assert not np.array_equal(first.frame(5).cloud, first.frame(4).cloud)


def test_the_detector_gets_only_the_scan():
    seen = []

    def detect(cloud):
        seen.append(cloud)
        cloud[:] = 0.0  # a detector may change its copy of the cloud
        return find_nothing(cloud)

    trip = drive(empty_street(), detect, seconds=0.5, clock=on_time, sensor=COARSE_SENSOR)
    assert {type(cloud) for cloud in seen} == {np.ndarray}
    assert {cloud.shape[1] for cloud in seen} == {4}
    assert np.abs(trip.frame(2).cloud).sum() > 0


def test_a_car_that_sees_nothing_hits_a_crossing_child():
    street = empty_street(actors=(child(40.0, 30 / 3.6),))
    trip = Trip(drive(street, find_nothing, seconds=8.0, clock=on_time, sensor=COARSE_SENSOR))
    assert trip.drive.hit_identity is not None
    assert street.kind_of(trip.drive.hit_identity) == "pedestrian"
    assert "The car hits a person at 30 km/h." in trip.report.collision
    assert re.search(r"The person was in \d+ .*never had a box", trip.report.collision)
    assert trip.drive.metres < 45


@pytest.mark.slow
def test_the_car_with_true_boxes_stops_for_a_child_and_drives_on():
    street = empty_street(actors=(child(40.0, 30 / 3.6),))
    trip = drive_street(street, seconds=12.0)
    assert trip.drive.hit_identity is None and trip.report.collision == ""
    (braking,) = [braking for braking in trip.report.brakings if not braking.needless]
    assert "a person" in braking.reason
    assert trip.report.needless == 0
    assert trip.drive.metres > 42, "the car continued behind the child"


def test_braking_for_an_empty_box_counts_as_needless():
    ghost = box(9.0, 0.0)[None] + (0, 0, 0.5)  # above the road, where it contains no returns
    trip = drive(
        empty_street(), lambda cloud: ghost, seconds=1.5, clock=on_time, sensor=COARSE_SENSOR
    )
    braking = measure(trip).brakings[0]
    assert braking.needless and braking.reason == "a box without returns"
    assert min(moment.acceleration for moment in trip.moments) < -1


@pytest.mark.parametrize(
    ("settings", "corners", "reason"),
    [
        ({}, box(9.0, 0.0, 4.0, 3.0) - (0, 0, 0.3), "road mistaken for an obstacle"),
        ({"has_dirty_bonnet": True}, box(0.9, 0.0, 1.4, 1.8) + (0, 0, 0.1), "the ego car"),
        ({"rain": 4000}, box(6.0, 0.0, 3.0, 3.0) + (0, 0, 0.9), "rain mistaken for an obstacle"),
    ],
)
def test_the_cause_of_needless_braking_is_named(settings, corners, reason):
    trip = drive(
        empty_street(**settings),
        lambda cloud: corners[None],
        seconds=2.0,
        clock=on_time,
        sensor=COARSE_SENSOR,
    )
    braking, *_ = measure(trip).brakings
    assert braking.needless and reason in braking.reason


def test_an_exception_affects_only_one_scan():
    calls = []

    def detect(cloud):
        calls.append(1)
        if len(calls) == 4:
            raise ValueError("odd scan")
        return find_nothing(cloud)

    trip = drive(empty_street(), detect, seconds=1.0, clock=on_time, sensor=COARSE_SENSOR)
    assert len(trip.moments) == 10
    assert trip.problems == ("scan 2: ValueError: odd scan",)
    with pytest.raises(ZeroDivisionError):
        drive(empty_street(), lambda cloud: 1 / 0, seconds=1.0, clock=on_time, sensor=COARSE_SENSOR)


@pytest.mark.parametrize("answer", [[], np.full((2, 8, 3), np.nan), box(50, 20)[None].tolist()])
def test_unusual_answers_are_accepted(answer):
    trip = drive(
        empty_street(), lambda cloud: answer, seconds=0.5, clock=on_time, sensor=COARSE_SENSOR
    )
    assert trip.problems == () and len(trip.moments) == 5


# Latency -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("seconds", "scans"), [(0.0, 1), (0.1, 1), (0.11, 2), (0.2, 2), (0.95, 10)]
)
def test_the_time_of_an_answer_is_rounded_up_to_scans(seconds, scans):
    assert ticks(seconds) == scans


def test_a_slow_detector_sees_fewer_scans():
    seen = []

    def slow_clock(call):
        return call(), 0.34

    def detect(cloud):
        seen.append(1)
        return find_nothing(cloud)

    trip = drive(empty_street(), detect, seconds=2.0, clock=slow_clock, sensor=COARSE_SENSOR)
    assert len(seen) == 1 + 5, "every fourth scan, and the first one, which loads libraries"
    assert [moment.latest_scan for moment in trip.moments[:9]] == [None] * 4 + [0] * 4 + [4]
    assert sum(moment.is_busy for moment in trip.moments) == 15


def test_the_car_with_a_slow_detector_stops_later():
    street = empty_street(actors=(Actor(placed(pedestrian(), 30.0, -1.2), np.inf, ((0, 0.0),)),))

    def detect(cloud):
        near = np.hypot(cloud[:, 0], cloud[:, 1]) < 14
        person = cloud[near & (cloud[:, 2] > -1.2) & (np.abs(cloud[:, 1]) < 1) & (cloud[:, 0] > 3)]
        return box(person[:, 0].min(), 0.0)[None] if len(person) else find_nothing(cloud)

    quick, late = (
        drive(
            street, detect, seconds=6.0, clock=lambda call, s=s: (call(), s), sensor=COARSE_SENSOR
        )
        for s in (0.05, 0.9)
    )
    assert quick.hit_identity is None
    assert late.hit_identity is not None or late.metres > quick.metres + 0.5


def test_the_clock_ignores_single_short_measurements():
    clock = Clock()
    answer, idle = clock(lambda: 7)
    assert answer == 7 and idle < 0.01

    def work():
        return sum(range(300_000))

    times = [clock(call)[1] for call in (work, work, work, lambda: 0, work)]
    assert times[-1] > 0, "the median of the last five"


# Measures of a drive -----------------------------------------------------------------------


def test_distances_are_between_footprints():
    person = replace(pedestrian(), pose=Pose(5.0, 3.0), identity=1)  # 0.6 m by 0.6 m
    far = replace(pedestrian(), pose=Pose(0.0, 40.0), identity=2)
    gaps = distances_to_objects(World(obstacles=(person, far)))
    # This is the distance from the corner (2.6, 0.9) to the corner (4.7, 2.7).
    assert gaps == {1: pytest.approx(np.hypot(2.1, 1.8))}


def test_twenty_streets_have_numbers_and_different_titles():
    assert [street.number for street in STREETS] == list(range(1, 21))
    assert len({street.title for street in STREETS}) == 20


@pytest.mark.parametrize("street", STREETS, ids=lambda street: street.title)
def test_only_actors_are_in_the_lane_of_the_ego_car(street):
    for obstacle in street.static_world.obstacles:
        across = abs(obstacle.pose.y + 1.2)
        assert across - obstacle.size[1] / 2 > 1.3 or abs(obstacle.pose.y) > 5
    assert all(kind in CLASSES for kind in street.road_users.values())


@pytest.mark.parametrize(
    ("place", "has_box", "brakes"),
    [
        ((BRAKING_RANGE - 1.0, 0.0), True, True),
        ((BRAKING_RANGE + 1.0, 0.0), True, False),  # too far away
        ((10.0, 2.2), True, False),  # next to our lane
        ((11.0, -3.2), False, False),  # hidden by a parked car
    ],
)
def test_a_person_is_seen_and_the_car_brakes_in_its_way(place, has_box, brakes):
    seen = look_at_person(*place, lambda labels: labels * (np.bincount(labels) >= 10)[labels])
    assert (seen.has_box, seen.brakes) == (has_box, brakes)
    assert seen.returns >= seen.points > 0
    blind = look_at_person(*place, np.zeros_like)
    assert (blind.returns, blind.points) == (seen.returns, seen.points)
    assert not blind.has_box and not blind.brakes


def test_a_person_shares_the_cluster_of_a_parked_car():
    assert look_at_person(9.0, -1.6, lambda labels: labels).points > 150


def test_the_parked_cars_are_where_they_are_drawn():
    street = street_with_person(12.0, 0.5)
    *cars, person = street.world(0.0, 40.0, {}).obstacles[-3:]
    assert (person.pose.x, person.pose.y) == pytest.approx((12.0, 0.5))
    drawn = np.array(SCENERY["rectangles"]["parked cars"])
    centres = [(one.pose.x, one.pose.y) for one in cars]
    assert (drawn[:, :2] + drawn[:, 2:]) / 2 == pytest.approx(np.array(centres))
    assert drawn[:, 2:] - drawn[:, :2] == pytest.approx(np.array([one.size[:2] for one in cars]))


def test_results_of_drives_are_summed():
    both = DriveResult(100.0, 2, 0, 1) + DriveResult(50.0, 0, 1, 0)
    assert both == DriveResult(150.0, 2, 1, 1)
    assert str(both).strip() == "150 m, 2 needless braking events, 1 collision"


# Reports and films -------------------------------------------------------------------------


@pytest.mark.slow
def test_each_braking_event_in_a_notebook_links_to_its_frame():
    trip = drive_street(STREETS[0], occupied_squares, seconds=1.0, clock=on_time)
    page = trip._repr_html_()
    assert repr(trip) == str(trip)
    assert page.count("<details>") == len(trip.report.brakings) > 0
    assert page.count("data:image/png;base64,") == len(trip.report.brakings)
    assert "<script" not in page and "needless" in page and "aria-label" in page
    # With role='img', screen readers would skip the links inside the SVG.
    assert "<svg" in page and "<a xlink:href='#braking-" in page and "role='img'" not in page


@pytest.mark.slow
def test_films_and_pages_are_written(tmp_path):
    trip = drive_street(STREETS[0], find_nothing, seconds=0.5, clock=on_time)
    message = trip.save(tmp_path / "film.gif")
    assert Image.open(tmp_path / "film.gif").n_frames == 3 and "street 1" in message
    trip.save(tmp_path / "strip.html")
    assert "<svg" in (tmp_path / "strip.html").read_text("utf-8")
    with pytest.raises(ValueError, match="film must end in"):
        trip.save(tmp_path / "film.avi")


def test_the_command_drives_and_compares(capsys):
    assert command.main(["--street", "1", "--seconds", "1"]) == 0
    output = capsys.readouterr().out
    assert "Street 1 · A quiet street: 8 m in 1 s.\n  Mean speed: 30 km/h." in output
    assert "yours" in output


def test_the_progress_bar_says_how_many_seconds_are_left(capsys, monkeypatch):
    ticks = iter((0.0, 6.0, 12.0, 18.0))
    monkeypatch.setattr("utils.progress.time", SimpleNamespace(monotonic=lambda: next(ticks)))
    monkeypatch.setitem(sys.modules, "ipykernel", None)
    assert list(progress("abc", "Driving")) == ["a", "b", "c"]
    _, first, second, last = capsys.readouterr().out.split("\r")
    assert "1/3, 12 s left" in first and "2/3, 6 s left" in second
    assert last.rstrip().endswith("3/3") and len(last) == len(first) + 1, "first is overwritten"


def test_the_command_explains_errors(tmp_path, capsys):
    cell = {"cell_type": "code", "source": "def filter_ground(cloud):\n    return cloud",
            "metadata": {}, "outputs": [], "execution_count": None}  # fmt: skip
    notebook = {"cells": [cell], "metadata": {}, "nbformat": 4, "nbformat_minor": 4}
    path = tmp_path / "06_filter_ground.ipynb"
    path.write_text(json.dumps(notebook))
    assert command.main([str(path), "--street", "1"]) == 2
    assert "has no function detect_obstacles(cloud)" in capsys.readouterr().out
    assert command.main([str(tmp_path / "none.ipynb")]) == 2
    assert "There is no notebook" in capsys.readouterr().out
    assert command.main(["--to", "film.mp4"]) == 2
    assert "--to needs exactly one street" in capsys.readouterr().out
    for wrong in (["--street", "21"], ["--to", "film.avi"], ["--seconds", "no"]):
        with pytest.raises(SystemExit):
            command.main(wrong)


def test_ctrl_c_keeps_finished_drives(capsys, monkeypatch):
    driven = []

    def stop_after_first(street, *arguments, **options):
        if driven:
            raise KeyboardInterrupt
        driven.append(street)
        return drive_street(street, seconds=1.0)

    monkeypatch.setattr(command, "drive_street", stop_after_first)
    assert command.main(["--seconds", "1"]) == 130
    output = capsys.readouterr().out
    assert "Stopped." in output and "yours" in output


# Right and wrong detectors, each on one street ---------------------------------------------


@pytest.mark.proof
@pytest.mark.parametrize("street", STREETS, ids=lambda street: street.title)
def test_the_car_without_boxes_hits_the_actors_of_every_street(street):
    """A drive without a detector ends in a collision on every street that has actors."""
    trip = drive(street, find_nothing, clock=on_time, sensor=NARROW_SENSOR)
    assert (trip.hit_identity is not None) == bool(street.actors)


@pytest.mark.proof
@pytest.mark.parametrize("name", reference_results([]))
def test_stored_standards_agree_with_new_drives(name):
    module = "solutions.stage4_realtime.12_streaming_obstacles.drive_standards"
    for number, result in importlib.import_module(module).drive_all(name).items():
        stored = reference_results([number])[name]
        assert result.metres == pytest.approx(stored.metres, abs=1.0), number
        assert (result.needless, result.collisions) == (stored.needless, stored.collisions), number


def test_lesson_12_states_the_result_of_the_courses_detector():
    result = reference_results(range(1, 21))["the course's detector"]
    (lesson,) = [lesson for lesson in all_lessons() if lesson.number == "12"]
    assert result.collisions == result.near_misses == 0
    times = "once" if result.needless == 1 else f"{result.needless} times"
    claim = f"{result.metres:,.0f} m without a collision, and brakes {times} for nothing"
    assert claim in lesson.source.read_text("utf-8")


def above(metres):
    return chain(ground=lambda points: points[points[:, 2] >= metres])


def half_width(metres):
    low, high = (-5, -metres, -2.5), (35, metres, 1)  # like the region of lesson 07
    return chain(region=lambda points: points[((points >= low) & (points <= high)).all(axis=1)])


def at_least(count):
    return chain(keep=lambda labels: np.where(np.bincount(labels)[labels] < count, 0, labels))


def within(threshold):
    cluster = DBSCAN(eps=threshold, min_samples=1)
    return chain(cluster=lambda points: cluster.fit_predict(points) + 1, voxel=0.4)


def along_the_axes(points, labels):
    ends = [[pick(points[labels == label], axis=0) for pick in (np.min, np.max)]
            for label in np.unique(labels[labels > 0])]  # fmt: skip
    rows = [[[ends_[k >> axis & 1][axis] for axis in range(3)] for k in range(8)] for ends_ in ends]
    return np.reshape(rows, (-1, 8, 3))


# Claims that lessons make about drives: a street, a detector, words that the report of the drive
# must contain, and words that it must not contain.
CLAIMS = {
    "06: -1.2 m keeps asphalt": (6, above(-1.2), "road mistaken for an obstacle", "hits"),
    "06: -0.6 m does not stop the car": (6, above(-0.6), "", "needless"),
    "05: 0.4 m splits obstacles": (11, within(0.4), "hits a person at 24 km/h", "needless"),
    "05: 0.5 m stops the car": (11, within(0.5), "Closest pass: 1.5 m from a person", "hits"),
    "05: 0.45 m stops the car": (11, within(0.45), "Closest pass: 1.5 m from a person", "hits"),
    "05: 0.85 m stops the car": (11, within(0.85), "Closest pass: 1.5 m from a person", "hits"),
    "06: -0.6 m fails downhill": (16, above(-0.6), "hits a person at 30 km/h", "needless"),
    "06: -1.2 m is late downhill": (16, above(-1.2), "hits a person at 4 km/h", "needless"),
    "06: -1.7 m is right downhill": (16, above(-1.7), "enter our lane, 9 m", "hits"),
    "07: 1.6 m is too narrow": (2, half_width(1.6), "The car hits a person", "needless"),
    "05: 0.9 m causes a jumping box": (11, within(0.9), "8.6 s  a person in our lane", "needless"),
    "05: 0.9 m is too late": (11, within(0.9), "The car hits a person", "needless"),
    "07: 6 m is enough": (2, half_width(6.0), "a person about to enter our lane, 9 m", "hits"),
    "07: 2.5 m is enough": (2, half_width(2.5), "a person about to enter our lane, 8 m", "hits"),
    "07: 2.3 m is enough": (2, half_width(2.3), "7.2 s  a person in our lane, 7 m", "hits"),
    "07: 1.6 m brakes late": (2, half_width(1.6), "7.4 s  a person in our lane, 5 m", "needless"),
    "07: 2.2 m brakes late": (2, half_width(2.2), "7.4 s  a person in our lane, 5 m", "needless"),
    "07: 2.2 m is too late": (2, half_width(2.2), "The car hits a person", "needless"),
    "09: 100 points drop a cyclist": (3, at_least(100), "The car hits a cyclist", "needless"),
    "09: 10 points keep the cyclist": (3, at_least(10), "a cyclist", "hits"),
    "09: 1 point keeps rain": (8, at_least(1), "rain mistaken for an obstacle", "hits"),
    "08: 12 degrees": (
        1,
        askew(chain(boxes=along_the_axes), 12.0),
        "a car next to our lane",
        "hits",
    ),
    "08: 0 degrees": (1, askew(chain(boxes=along_the_axes), 0.0), "", "needless"),
    "08: 9 degrees": (1, askew(chain(boxes=along_the_axes), 9.0), ": 13 m in 13 s", "hits"),
    "09: 10 points do not stop the car": (8, at_least(10), "", "rain"),
}


@pytest.mark.proof
@pytest.mark.parametrize("claim", CLAIMS)
def test_claims_of_lessons_about_drives_are_true(claim):
    street, detect, words, absent = CLAIMS[claim]
    report = str(drive_street(street, detect, seconds=13.0, clock=on_time))
    assert words in report and absent not in report, report


@pytest.mark.proof
@pytest.mark.parametrize(("degrees", "first"), [(4.0, ""), (5.0, "a lorry"), (8.0, "a car")])
def test_the_first_box_that_blocks_the_lane_agrees_with_lesson_08(degrees, first):
    detect = askew(chain(boxes=along_the_axes), degrees)
    trip = drive_street(1, detect, seconds=10.0, clock=on_time)
    assert bool(trip.report.brakings) == bool(first) and first in str(trip)


# Wrong detectors, each with a street and words that the report of its drive contains.
WRONG_DETECTORS = [
    ("returns no boxes", 2, "never had a box"),
    ("one box around everything", 1, "needless: "),
    ("boxes around parts of the road", 1, "road mistaken for an obstacle"),
    ("the road stays in", 1, "needless: "),
    ("the ego car stays in", 10, "the ego car mistaken"),
    ("the minimum of lesson 09 on a thinned cloud", 14, "never had a box"),
    ("cars and walls are one cluster", 15, "needless: "),
    ("small clusters stay", 8, "rain mistaken for an obstacle"),
    ("the ground level is 0, as on a map", 2, "The car hits a person"),
    ("a threshold far below the distance between points", 14, "The car hits a person"),
]


@pytest.mark.proof
@pytest.mark.parametrize(
    ("name", "street", "words"), WRONG_DETECTORS, ids=[row[0] for row in WRONG_DETECTORS]
)
def test_a_wrong_detector_fails_for_the_expected_reason(name, street, words, tmp_path):
    (variant,) = [answer for answer in answers_to("detect_obstacles") if answer.name == name]
    (lesson,) = [lesson for lesson in all_lessons() if lesson.number == "12"]
    notebook = tmp_path / "12_streaming_obstacles.ipynb"
    notebook.write_text(fill_in(lesson, {"detect_obstacles": variant.source}), "utf-8")
    detect, _ = load_detector(str(notebook))
    assert words in str(drive_street(street, detect, clock=on_time))
