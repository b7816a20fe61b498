"""Tests of the statements in lesson 07, with answers that follow its hints."""

import numpy as np
import pytest

from tests.lesson_texts import kept_function, run_statements_for
from utils import load_cloud
from utils.datasets import DATA
from utils.drive import STREETS
from utils.simulator import Sensor, World, hdl64, layers, scan
from utils.simulator.ground import Ground
from utils.simulator.streets import numbered, placed
from utils.simulator.traffic import pedestrian

REGION = (-10, -5, -2), (30, 6, 1)
EGO_BOX = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)


filter_by_distance = kept_function("filter_by_distance")
crop_region = kept_function("crop_region")
remove_ego_returns = kept_function("remove_ego_returns")

CLOUD = load_cloud("cloud.txt")
TRUTH = np.load(DATA / "cloud_truth.npz")
NAMES = TRUTH["class_names"].tolist()
UPRIGHT = CLOUD[:, 2] >= -1.2
USER = UPRIGHT & np.isin(
    TRUTH["classes"], [NAMES.index(kind) for kind in ("car", "truck", "pedestrian", "cyclist")]
)
USERS = np.column_stack([CLOUD[:, :3], TRUTH["objects"]])[USER]


def of_kind(kind):
    return TRUTH["classes"] == NAMES.index(kind)


def seen(rows, minimum=20):
    """Return the objects with at least `minimum` returns. Rows are x, y, z and object number."""
    numbers, counts = np.unique(rows[:, 3], return_counts=True)
    return set(numbers[counts >= minimum].astype(int).tolist())


def test_the_small_examples_are_right():
    four = np.array([[11.0, 1, 0, 0.1], [6, 2, 9, 0.1], [4, 3, -12, 0.1], [13, 2, -0.2, 0.1]])
    assert filter_by_distance(four).tolist() == [[6, 2, 9, 0.1], [4, 3, -12, 0.1]]
    assert np.hypot(four[:, 0], four[:, 1])[[1, 2]] == pytest.approx([6.3, 5.0], abs=0.05)
    six = np.array([[-11.0, 2, -1], [31, 2, -1], [1, 2, -1], [1, -6, -1], [1, 7, -1], [1, 2, 1.5]])
    assert crop_region(six, *REGION).tolist() == [[1, 2, -1]]
    five = np.array([[0.9, 1, -0.6], [9, 0, -0.7], [-4, 0, -0.7], [0.5, 6, -0.7], [0.5, -3, -0.7]])
    assert remove_ego_returns(five, *EGO_BOX).tolist() == five[1:].tolist()
    inside = (five >= EGO_BOX[0]) & (five <= EGO_BOX[1])
    assert inside.sum(axis=1).tolist() == [3, 2, 2, 2, 2]


def test_neighbouring_beams_are_similar_angles_apart():
    steps = np.abs(np.diff(np.degrees(hdl64().elevations)))
    assert steps.min() > 0.3 and steps.max() < 0.55


def test_the_length_of_whole_rows_fails_only_with_bright_intensities():
    kept = np.linalg.norm(CLOUD * [1, 1, 1, 255], axis=1) <= 10
    assert kept.mean() < 0.001, "nearly all points vanish"
    flat = np.hypot(CLOUD[:, 0], CLOUD[:, 1])
    near, in_space = flat <= 10, np.linalg.norm(CLOUD[:, :3], axis=1) <= 10
    lost = near & ~in_space
    assert lost.sum() > 300 and flat[lost].min() > 9.8, "these points are just inside the circle"
    assert np.quantile(CLOUD[lost, 2], 0.9) < -1, "they are far below the sensor"
    whole_rows = np.linalg.norm(CLOUD, axis=1) <= 10
    assert not (lost & whole_rows).any()
    assert (in_space & ~whole_rows).sum() < lost.sum() / 5, "intensities below 1 add few"
    assert near.mean() > 0.5, "the share of points is far above the 1.6 % of the area"


def test_a_sphere_loses_the_child_and_a_cylinder_keeps_it():
    sensor = Sensor(
        elevations=layers(64, -50, 15), azimuth_step=np.radians(0.3), origin=(0, 0, 3.4)
    )
    yard = World(Ground(), numbered([placed(pedestrian(1.2), 5.7, 0)]))
    view = scan(yard, sensor, seed=7)
    child = view.cloud[view.objects > 0]
    assert len(child) > 100
    assert not (np.linalg.norm(child[:, :3], axis=1) <= 6).any()
    assert len(filter_by_distance(child, 6.0)) == len(child)
    low, high = child[:, 2].min(), child[:, 2].max()
    assert low < -3.1 and high > -2.3, "the child is seen from head to foot"


def test_each_metre_adds_thousands_of_points_and_finally_dozens():
    obstacles = CLOUD[~(of_kind("invalid") | of_kind("ground") | of_kind("ego"))]
    distances = np.hypot(obstacles[:, 0], obstacles[:, 1])
    brought = np.histogram(distances, np.arange(61))[0]
    assert min(brought[4:12]) > 2000
    assert 24 < np.median(brought[40:]) < 99


def test_half_of_the_upright_points_are_house_fronts():
    assert (UPRIGHT & of_kind("wall")).sum() / UPRIGHT.sum() > 0.5


def test_the_car_ahead_is_in_our_lane_and_alone_in_it():
    ahead = CLOUD[TRUTH["objects"] == 11]
    assert np.abs(ahead[:, 1].mean()) < 0.3
    radius = next(r for r in range(1, 81) if len(filter_by_distance(ahead, r)) >= 20)
    assert 20 <= radius <= 22
    obstacles = CLOUD[~(of_kind("invalid") | of_kind("ground") | of_kind("ego"))]
    assert len(filter_by_distance(obstacles, 30)) / len(obstacles) > 0.95, (
        "the picture stops growing"
    )


def test_far_points_are_few_but_far_road_users_are_many():
    """Beyond the stopping distance from 50 km/h there are few points but many road users."""
    stops = {speed: 2.6 + 0.5 * speed / 3.6 + (speed / 3.6) ** 2 / 14 for speed in (30, 50)}
    near = {
        speed: len(filter_by_distance(CLOUD[UPRIGHT], stop)) / UPRIGHT.sum()
        for speed, stop in stops.items()
    }
    users = {
        speed: len(seen(filter_by_distance(USERS, stop))) / len(seen(USERS))
        for speed, stop in stops.items()
    }
    assert near[50] > 0.9 and near[50] ** 2 > 0.8
    assert users[50] < 0.75
    assert users[30] < users[50]
    assert 10 < stops[30] < 12 < stops[50], "10 m is not enough for 30 km/h"


def test_the_box_reaches_far_with_fewer_points_than_the_circle():
    box = crop_region(CLOUD[UPRIGHT], *REGION)
    assert len(box) < len(filter_by_distance(CLOUD[UPRIGHT], 10))
    assert len(crop_region(CLOUD[UPRIGHT & of_kind("wall")], *REGION)) == 0
    ahead = USERS[USERS[:, 0] > 0]
    in_street = ahead[np.abs(ahead[:, 1] - 0.5) < 5.5]
    big = seen(filter_by_distance(in_street, 30))
    assert seen(crop_region(in_street, *REGION)) == big, (
        "the box reaches as far ahead as the big circle"
    )
    lost = seen(filter_by_distance(ahead, 30)) - seen(crop_region(ahead, *REGION))
    kinds = dict(zip(TRUTH["box_identities"].tolist(), TRUTH["box_kinds"].tolist(), strict=True))
    assert lost and {kinds[number] for number in lost} == {"pedestrian"}, (
        "only pedestrians on the pavement are lost"
    )


def nearest_objects_in_lane(function, curvature):
    """Return the kind and the nearest x of each object up to 25 m ahead in a lane, by number."""
    ahead = UPRIGHT & (TRUTH["objects"] > 0) & (CLOUD[:, 0] > 0) & (CLOUD[:, 0] < 25)
    rows = np.column_stack([CLOUD[ahead, :3], TRUTH["objects"][ahead]])
    rows = function(rows, 2.6, curvature)
    kinds = dict(zip(TRUTH["box_identities"].tolist(), TRUTH["box_kinds"].tolist(), strict=True))
    return {
        number: (kinds[number], rows[rows[:, 3] == number, 0].min())
        for number in sorted(seen(rows), key=lambda number: rows[rows[:, 3] == number, 0].min())
    }


def test_a_bent_lane_holds_other_obstacles_than_a_straight_one():
    given = run_statements_for("07_filter_by_distance", "crop_lane")["crop_lane"]

    def bent(cloud, width, curvature):
        """Return the points in a bent lane, as in the lesson's answer."""
        middle = curvature * cloud[:, 0] ** 2 / 2
        return cloud[np.abs(cloud[:, 1] - middle) <= width / 2]

    three = np.array([[10.0, 2.0, -1.0], [10.0, 0.0, -1.0], [20.0, 8.5, -1.0]])
    assert bent(three, 2.6, 0.04).tolist() == three[[0, 2]].tolist()
    assert given(three, 2.6, 0.04).tolist() == three[[1]].tolist(), "the given lane is straight"
    straight = nearest_objects_in_lane(given, 0.04)
    assert [kind for kind, _ in straight.values()][0] == "pedestrian"
    found = nearest_objects_in_lane(bent, 0.04)
    assert [kind for kind, _ in found.values()] == ["car", "truck"]
    (car, (_, nearest)), (truck, _) = found.items()
    assert nearest == pytest.approx(6, abs=0.1)
    velocity = {
        number: TRUTH["box_velocities"][TRUTH["box_identities"] == number][0]
        for number in (car, truck)
    }
    assert velocity[car][0] < -1, "the car is oncoming"
    assert not velocity[truck].any(), "the lorry is parked"


def test_the_formula_of_the_bent_lane_is_good_only_near_the_car():
    radius, ahead = 25.0, np.array([10.0, 20.0])
    on_the_circle = radius - np.sqrt(radius**2 - ahead**2)
    assert on_the_circle - ahead**2 / radius / 2 == pytest.approx([0.09, 2.0], abs=0.005)


def test_the_ego_car_and_invalid_returns_are_nearest():
    close = filter_by_distance(CLOUD[UPRIGHT])
    distances = np.sort(np.hypot(close[:, 0], close[:, 1]))
    invalid = int(of_kind("invalid").sum())
    assert (distances == 0).sum() == invalid > 0
    assert distances[invalid] == pytest.approx(1.3, abs=0.01), (
        "the nearest part of the ego car is 1.3 m away"
    )
    assert (distances < 3).sum() == invalid + of_kind("ego").sum(), "nothing else is that near"
    mirrors = np.abs(CLOUD[of_kind("ego"), 1]).max()
    assert EGO_BOX[1][1] - mirrors == pytest.approx(0.6, abs=0.05), (
        "the box is 0.6 m wider than the mirrors"
    )
    assert hdl64().minimum_range == 1.0
    free = remove_ego_returns(close, *EGO_BOX)
    assert len(close) - len(free) == of_kind("ego").sum()
    rest = remove_ego_returns(free, (-0.1,) * 3, (0.1,) * 3)
    assert len(free) - len(rest) == invalid
    assert np.hypot(rest[:, 0], rest[:, 1]).min() > 3


def test_the_colleague_loses_the_car_ahead_and_half_of_every_near_car():
    given = run_statements_for("07_filter_by_distance", "remove_like_a_colleague")
    colleague = given["remove_like_a_colleague"]
    cars = UPRIGHT & of_kind("car")
    rows = np.column_stack([CLOUD[cars, :3], TRUTH["objects"][cars]])
    left = colleague(rows, *EGO_BOX)
    assert len(remove_ego_returns(rows, *EGO_BOX)) == len(rows)
    assert not (left[:, 3] == 11).any(), "the car ahead is gone"
    assert not ((left[:, 2] >= -1.0) & (left[:, 2] <= -0.4)).any(), "all points at this height"
    is_near = np.hypot(rows[:, 0], rows[:, 1]) < 25
    near = np.unique(rows[is_near, 3])
    assert len(near) == 10
    for number in near:
        kept = (left[:, 3] == number).sum() / (rows[:, 3] == number).sum()
        assert kept < 0.5, "each car within 25 m loses more than half of its points"
    assert len(colleague(CLOUD[of_kind("ego")], *EGO_BOX)) == 0, "the ego car is removed"
    # Changing one word makes it right.
    outside = (CLOUD[:, :3] < EGO_BOX[0]) | (CLOUD[:, :3] > EGO_BOX[1])
    assert np.array_equal(CLOUD[outside.any(axis=1)], remove_ego_returns(CLOUD, *EGO_BOX))


def test_common_mistakes_look_as_described():
    x, y = CLOUD[:, 0], CLOUD[:, 1]
    assert np.hypot(10, 10) / 10 == pytest.approx(1.41, abs=0.005)
    assert np.sqrt(10) == pytest.approx(3.2, abs=0.05)
    square = (np.abs(x) <= 10) & (np.abs(y) <= 10)
    assert np.hypot(x, y)[square].max() > 13
    in_small_disc = x**2 + y**2 <= 10
    assert in_small_disc.mean() < 0.01, "hardly anything is left"
    assert in_small_disc.sum() == 635, "returns within 3.2 m"
    assert (in_small_disc & of_kind("ego")).sum() == 547, "most of them come from the ego car"
    inside = (CLOUD[:, :3] >= REGION[0]) & (CLOUD[:, :3] <= REGION[1])
    assert inside.any(axis=1).mean() > 0.99, "nearly everything stays"
    assert inside[:, 2].mean() > 0.95, "since most heights are inside"


def test_the_child_runs_out_at_the_stated_time():
    (street,) = (candidate for candidate in STREETS if candidate.number == 2)
    (running,) = street.actors
    assert int(running.start_position / street.limit) == 5


def test_no_cloud_contains_nan():
    assert np.isfinite(CLOUD).all()
