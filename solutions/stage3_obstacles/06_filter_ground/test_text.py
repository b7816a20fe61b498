"""Tests of the statements in lesson 06, with answers that follow its hints."""

import numpy as np
import pytest
from sklearn.cluster import DBSCAN

from tests.lesson_texts import kept_function, run_statements_for
from utils.drive import STREETS, chain, drive_street, on_time

LESSON = "06_filter_ground"


@pytest.fixture(scope="module")
def street():
    """Variables and functions that the lesson's cells define, by name."""
    return run_statements_for(
        LESSON, "near", "kinds", "ground", "upright", "thin", "vanishes_at", "two_errors", "levels",
        "rising", "by_skipping", "by_voxels", "points_left", "few", "flank",
        "as_numbers",
    )  # fmt: skip


@pytest.fixture(scope="module")
def filter_ground():
    return kept_function("filter_ground")


@pytest.fixture(scope="module")
def voxel_grid():
    return run_statements_for("06_filter_ground", "voxel_grid")["voxel_grid"]


def test_the_peak_of_the_histogram_is_the_ground(street):
    z, is_ground = street["cloud"][:, 2], street["kinds"] == "ground"
    counts, edges = np.histogram(z, bins=np.arange(-3.5, 3.05, 0.1))
    low = edges[np.argmax(counts)]
    assert np.mean(is_ground[(z >= low) & (z < low + 0.1)]) > 0.9
    assert -1.73 < low + 0.05 < -1.6
    assert f"{low:.1f} {low + 0.1:.1f}" == "-1.7 -1.6"
    assert np.mean(is_ground) < 0.5  # more than half of the returns are from objects
    assert np.mean(np.isin(street["kinds"], ["wall", "car"])) > 0.4


def test_nearby_cars_are_lower_than_the_sensor(street):
    cloud, mine = street["cloud"], street["kinds"] == "car"
    mine &= np.hypot(cloud[:, 0], cloud[:, 1]) < 15
    assert cloud[mine, 2].max() < 0.05
    # Farther ahead in the drawing's slice, the roofs of some cars are above the line.
    ahead = (street["kinds"] == "car") & (cloud[:, 0] > 15) & (np.abs(cloud[:, 1]) < 4)
    assert len(np.unique(street["truth"]["objects"][ahead & (cloud[:, 2] > 0)])) >= 4
    # The drawing's slice has hardly any points above the line.
    assert np.mean(street["near"][:, 2] > 0) < 0.02


def test_a_car_without_its_wheels_is_nearly_one_cluster(street, filter_ground):
    cloud, objects = street["cloud"], street["truth"]["objects"]
    whole = []
    for number in np.unique(objects[street["kinds"] == "car"]):
        car = cloud[objects == number]
        if np.hypot(*car[:, :2].mean(axis=0)) < 25:
            left = filter_ground(car)
            assert 0.5 < len(left) / len(car) < 1
            found = DBSCAN(eps=0.5, min_samples=1).fit_predict(left[:, :3])
            assert np.bincount(found).max() >= 0.96 * len(left)
            whole.append(found.max() == 0)
    assert (sum(whole), len(whole)) == (7, 10)


def test_a_car_vanishes_before_a_wall_and_a_pedestrian(street):
    car, pedestrian, wall = (
        street["vanishes_at"](kind, street["rising"]) for kind in ("car", "pedestrian", "wall")
    )
    assert car < wall < pedestrian < np.inf
    # The wall that vanishes is a garden wall. House fronts within 15 m are visible up to half a
    # metre above the sensor.
    truth, cloud = street["truth"], street["cloud"]
    tops = {}
    for number in np.unique(truth["objects"][street["kinds"] == "wall"]):
        mine = (truth["objects"] == number) & (np.hypot(cloud[:, 0], cloud[:, 1]) < 15)
        if mine.sum() >= 100:
            tops[number] = cloud[mine, 2].max()
    assert tops.pop(36) < wall
    assert truth["box_sizes"][truth["box_identities"] == 36][0, 2] == pytest.approx(1.3)
    assert len(tops) == 3 and all(0.45 < top < 0.55 for top in tops.values())
    assert all(
        truth["box_sizes"][truth["box_identities"] == identity][0, 2] > 6 for identity in tops
    )
    # The ringed car is in the picture for the default level, but not in the last picture.
    cloud = street["thin"]
    ringed = np.hypot(cloud[:, 0] + 11.7, cloud[:, 1] + 2.7) < 2.2
    assert (cloud[ringed, 2] >= -1.2).any() and not (cloud[ringed, 2] >= -0.5).any()


def test_the_default_is_above_the_crossing_of_the_errors(street):
    stays, goes = street["two_errors"](street["levels"])
    crossing = street["levels"][np.argmin(np.abs(stays - goes))]
    assert np.median(street["ground"][:, 2]) < crossing < -1.3
    assert np.tan(np.radians(1)) * 30 == pytest.approx(0.5, abs=0.03)


def test_the_remaining_ground_is_far_away(street, filter_ground):
    left_over = filter_ground(street["ground"])
    assert len(left_over) and np.hypot(left_over[:, 0], left_over[:, 1]).min() > 20
    assert np.mean(left_over[:, 0] > 0) > 0.8  # most of it is ahead, because the street climbs


def test_density_falls_faster_on_the_road(street):
    def per_square_metre(points, near, far):
        distance = np.hypot(points[:, 0], points[:, 1])
        return np.sum((distance > near) & (distance < far)) / (far**2 - near**2)

    ground = street["ground"]
    assert per_square_metre(ground, 6, 8) > 4 * per_square_metre(ground, 12, 16)


def test_skipping_and_voxels_leave_about_equally_many_points(street):
    everything = np.arange(len(street["upright"]))
    skipped, thinned = street["by_skipping"](everything), street["by_voxels"](everything)
    assert skipped == pytest.approx(thinned, rel=0.1)
    assert thinned == pytest.approx(len(everything) / 5, rel=0.1)


def test_voxels_thin_near_objects_more_than_far_ones(street):
    numbers = street["truth"]["objects"][street["truth"]["objects"] > 0]
    left = {}
    for number in (30, 15, 1, 8, 72):
        rows = np.flatnonzero(numbers == number)
        left[number] = street["by_skipping"](rows), street["by_voxels"](rows)
    assert all(left[number][1] < left[number][0] for number in (30, 15, 1))
    assert all(left[number][1] > 30 for number in left)
    assert [round(left[number][1] / left[number][0]) for number in (8, 72)] == [4, 3]


def test_four_voxels_match_the_values_in_the_text(street, voxel_grid):
    four = voxel_grid(street["few"], 0.5)
    by_hand = [[-0.2, 0.3, 0.1, 0.5], [0.2, 0.2, 0.2, 0.3]]
    by_hand += [[0.7, 0.2, 0.1, 0.6], [0.7, 0.7, 0.2, 0.4]]
    assert np.allclose(four[np.lexsort(np.round(four[:, 1::-1], 6).T)], by_hand)


def test_each_square_of_the_flank_has_one_centroid(street, voxel_grid):
    for size in np.arange(0.1, 1.01, 0.1):
        squares = np.floor(voxel_grid(street["flank"], size)[:, [0, 2]] / size)
        assert len(np.unique(squares, axis=0)) == len(squares)


def test_cells_twice_as_wide_leave_two_to_four_times_fewer(street):
    left = street["points_left"](np.array([0.05, 0.1, 0.2, 0.4, 0.8, 1.6]))
    factors = left[:-1] / left[1:]
    assert (factors[1:] > 2).all() and (factors[1:] < 4).all()
    assert factors[0] < 2
    cells = np.floor(street["upright"][:, :3] / 0.05)
    _, counts = np.unique(cells, axis=0, return_counts=True)
    assert np.mean(counts == 1) > 0.5  # most cells of 5 cm contain a single point


def test_common_mistakes_match_the_table(street, voxel_grid):
    cloud = street["thin"]
    assert (np.abs(cloud[:, 2]) >= -1.2).all()
    assert cloud[cloud[:, 1] >= -1.2, 1].min() >= -1.2  # nothing remains far to the right
    points = street["upright"][:2000]
    _, which, counts = np.unique(
        np.floor(points[:, :3] / 0.2), axis=0, return_inverse=True, return_counts=True
    )
    sums = np.zeros((len(counts), 4))
    sums[which.ravel()] += points
    wrong, right = sums / counts[:, None], voxel_grid(points, 0.2)
    shared = counts > 1
    lengths = [np.linalg.norm(rows[shared, :3], axis=1) for rows in (wrong, right)]
    assert (lengths[0] < 0.7 * lengths[1]).all()


def test_the_numbers_of_rows_match_the_text(street):
    cells = np.array([[0, 1], [3, 2], [0, 1], [0, 1]])
    assert street["as_numbers"](cells).tolist() == [0, 3 * 2 + 1, 0, 0]
    assert (cells - cells.min(axis=0)).max(axis=0).tolist() == [3, 1]
    slower = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    assert slower[1].ravel().tolist() == [0, 1, 0, 0] and slower[2].tolist() == [3, 1]


def test_no_cloud_contains_nan(street):
    assert np.isfinite(street["cloud"]).all()


def test_a_climb_of_six_per_cent_reaches_the_level_nine_metres_ahead():
    (street,) = (candidate for candidate in STREETS if candidate.number == 6)
    assert street.slope == 0.06
    margin = 1.73 - 1.2
    assert margin == pytest.approx(0.53) and margin / street.slope == pytest.approx(9, abs=0.5)
    ground = street.world(0.0, 0.0, {}).ground
    lane, left, right = (ground.height(0.0, y) for y in (0.0, 9.0, -5.7))
    assert left - lane == pytest.approx(0.1, abs=0.02)
    assert right - lane == pytest.approx(0.1, abs=0.02)


@pytest.mark.proof
def test_with_the_default_the_car_gets_less_than_half_as_far_uphill(filter_ground):
    def report_with(level):
        detect = chain(ground=lambda points: filter_ground(points, level))
        return drive_street(6, detect, seconds=10, clock=on_time).report

    high, default = report_with(-0.6), report_with(-1.2)
    assert round(high.metres) == 82 and not high.brakings
    assert default.metres < high.metres / 2 and default.brakings
    assert np.mean([braking.gap for braking in default.brakings]) == pytest.approx(4, abs=0.5)


@pytest.mark.proof
def test_downhill_the_car_stops_in_time_only_with_a_low_level(filter_ground):
    for level, speed in ((-0.6, "at 30 km/h"), (-1.2, "at 4 km/h"), (-1.7, "")):
        detect = chain(ground=lambda points, level=level: filter_ground(points, level))
        report = drive_street(16, detect, seconds=13, clock=on_time).report
        assert bool(report.collision) == bool(speed) and speed in str(report.collision)
    assert report.brakings  # with the lowest level
