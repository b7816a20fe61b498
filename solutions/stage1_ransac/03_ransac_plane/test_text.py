"""Tests of the statements in lesson 03, with answers that follow its hints."""

import ast
import math
from types import SimpleNamespace

import numpy as np
import pytest

from grader.course.lessons import find_lesson
from tests.lesson_texts import source_of
from utils import load_cloud
from utils.datasets import DATA
from utils.scenes import ROAD

LESSON = find_lesson("03_ransac_plane")
EXERCISES = [exercise.name for exercise in LESSON.machine_graded]


@pytest.fixture(scope="module")
def street():
    """The notebook's variables and functions, with answers that follow the hints."""
    cloud = load_cloud("cloud.txt")
    nearby = (cloud[:, 0] > -10) & (cloud[:, 0] < 30) & (np.abs(cloud[:, 1]) < 5)
    truth = np.load(DATA / "cloud_truth.npz")
    names = truth["class_names"].tolist()
    rows = np.flatnonzero(nearby)[::8]
    kinds = truth["classes"][rows]
    known = {"np": np, "math": math, "cloud": cloud, "rows": rows, "street": cloud[rows]}
    known |= {"truth": truth, "names": names, "kinds": kinds}
    known["is_ground"] = kinds == names.index("ground")
    for exercise in EXERCISES:
        exec(source_of(exercise), known)
    for statement in ast.parse(LESSON.source.read_text("utf-8")).body:
        given = isinstance(statement, ast.FunctionDef) and not statement.decorator_list
        if given and statement.name not in EXERCISES:
            exec(ast.unparse(statement), known)
    return SimpleNamespace(**known, known=known)


def same_plane(plane, expected, within=1e-6):
    return min(np.abs(np.add(plane, sign * np.array(expected))).max() for sign in (1, -1)) < within


def test_small_examples_give_the_expected_results(street):
    level = np.array([[4.0, 1.0, -1.7], [9.0, -2.0, -1.7], [6.0, 3.0, -1.7]])
    assert np.cross(level[1] - level[0], level[2] - level[0]).tolist() == [0, 0, 16]
    assert same_plane(street.plane_through(*level), (0, 0, 1, 1.7))
    assert street.plane_through(*np.array([[0.0, 0, 0], [1, 1, 1], [3, 3, 3]])) is None
    # Rounding leaves a length that is not 0, although the three points are on one line.
    side = np.array([0.1, 0.2, 0.3])
    assert 0 < np.linalg.norm(np.cross(side, 3 * side)) < 1e-15
    assert street.plane_through(0 * side, side, 3 * side) is None
    four = np.array([[5, 2, -1.7, 0.3], [6, 4, -1.57, 0.3], [9, 0, -0.2, 0.8], [7, 1, -1.8, 0.2]])
    distances = street.point_plane_distance(four, (0.0, 0.0, 1.0, 1.7))
    assert np.round(distances, 2).tolist() == [0, 0.13, 1.5, 0.1]
    seven = np.array([[0, 0, -1.7], [4, 0, -1.7], [1, 3, -1.7], [5, 4, -1.7], [2, 5, -1.7]])
    seven = np.vstack([seven, [[1.5, 1.0, -0.2], [3.0, 2.0, 0.5]]])
    for seed in range(20):
        model, inliers = street.ransac_plane(seven, 60, 0.1, seed)
        assert same_plane(model, (0, 0, 1, 1.7))
        assert inliers.tolist() == [True] * 5 + [False] * 2
    floor = np.array([[0, 0, -1.6], [4, 0, -1.8], [0, 2, -1.8], [4, 2, -1.6]])
    assert same_plane(street.fit_plane(floor), (0, 0, 1, 1.7))
    assert street.iterations_needed(0.5, 1, 0.9) == 4


def test_shares_of_ground_and_cars_are_as_described(street):
    assert 0.5 < street.is_ground.mean() < 0.6
    others = street.kinds[~street.is_ground]
    assert (others == street.names.index("car")).mean() > 0.5
    picks = np.random.default_rng(5).integers(len(street.rows), size=(10_000, 3))
    share = street.is_ground[picks].all(axis=1).mean()
    assert abs(share - street.is_ground.mean() ** 3) < 0.02
    assert 5 < 50 * share < 15  # the text says "in fifty rounds it happens several times"


def test_the_naive_plane_floats_above_the_ground(street):
    table = np.column_stack([street.street[:, :2], np.ones(len(street.rows))])
    fitted = np.linalg.lstsq(table, street.street[:, 2], rcond=None)[0]
    above = (table @ fitted - street.street[:, 2])[street.is_ground]
    assert np.median(above) > 0.3
    assert (np.abs(above) < 0.2).mean() < 0.01


def test_four_rounds_are_as_described(street):
    rng = np.random.default_rng(2)
    on_ground, inliers = [], []
    for _ in range(4):
        three, plane, near = street.one_round(rng)
        on_ground.append(int(street.is_ground[three].sum()))
        inliers.append(int(near.sum()))
        assert np.hypot(plane[0], plane[2]) > 0.5  # seen from the side, the plane is a line
    assert sorted(on_ground) == [0, 1, 2, 3]
    best = on_ground.index(3)
    assert all(2 * count < inliers[best] for place, count in enumerate(inliers) if place != best)


def test_a_thin_band_loses_ground_because_of_crown_and_kerb(street):
    ground = street.street[street.is_ground]
    plane = np.array(street.fit_plane(ground))
    plane *= np.sign(plane[2])
    height = ground[:, :3] @ plane[:3] + plane[3]
    assert (np.abs(height) > 0.03).mean() > 1 / 3
    strips = np.floor(ground[:, 1])
    middles = [height[strips == strip].mean() for strip in np.unique(strips)]
    assert max(middles) > 0.05 and min(middles) < -0.04
    # The picture removes the slope. The road then falls from its middle to both of its edges.
    y, level = ground[:, 1], ground[:, 2] - ROAD.slope * ground[:, 0]
    parts = y > 1.5, (y < 0.5) & (y > -3.5), y < -4.1  # left side, right side, right pavement
    lean = [np.polyfit(y[part], level[part], 1)[0] for part in parts]
    assert lean == pytest.approx([-0.02, 0.02, -0.02], abs=0.005)
    # The thin band contains nearly the whole road on one side, and hardly any on the other.
    _, near = street.ransac_plane(street.street, 50, 0.03, 1)
    held = sorted(near[street.is_ground][side].mean() for side in parts[:2])
    assert held[0] < 0.1 and held[1] > 0.9
    # In a small area, the ground is flat except for a little noise.
    places = np.unique(np.floor(ground[:, :2] / 0.5), axis=0, return_inverse=True)[1].ravel()
    scatter = [height[places == place].std() for place in np.unique(places)]
    assert np.median(scatter) < 0.01


def test_thresholds_act_as_described(street):
    shares_held, slopes = {}, {}
    for threshold in (0.03, 0.2, 0.8):
        plane, near = street.ransac_plane(street.street, 50, threshold, 1)
        shares_held[threshold] = near[street.is_ground].mean(), near[~street.is_ground].mean()
        slopes[threshold] = street.slope_of(plane)
    assert shares_held[0.03][0] < 2 / 3
    assert shares_held[0.2][0] > 0.995 and shares_held[0.2][1] < 0.12
    assert shares_held[0.8][1] > 0.6
    assert abs(slopes[0.8] - 2.2) > 1.5 > 5 * abs(slopes[0.2] - 2.2)


def test_the_wall_wins_unless_the_normal_is_checked(street):
    x, y = street.cloud[:, 0], street.cloud[:, 1]
    chosen = np.flatnonzero((x > -1) & (x < 13) & (y > -8.6) & (y < -4))[::3]
    next_to_the_wall, kinds = street.cloud[chosen], street.truth["classes"][chosen]
    for seed in range(3):
        won, near = street.ransac_plane(next_to_the_wall, 100, 0.2, seed)
        assert abs(won[2]) < 0.2
        assert (kinds[near] == street.names.index("wall")).mean() > 0.9
    ground, found = street.ground_plane(next_to_the_wall)
    assert abs(ground[2]) > 0.9
    assert (kinds[found] == street.names.index("ground")).mean() > 0.9
    # The figure cuts the plane at y = -6, in the middle of its points. At y = 0, where other
    # figures cut planes, it is far below them.
    points = next_to_the_wall[found]
    below = {
        y: np.median(
            points[:, 2] + (ground[0] * points[:, 0] + ground[1] * y + ground[3]) / ground[2]
        )
        for y in (-6, 0)
    }
    assert points[:, 1].min() < -6 < points[:, 1].max()
    assert abs(below[-6]) < 0.05 < 0.08 < abs(below[0])


@pytest.mark.parametrize("mask", [True, False])
def test_ground_plane_stops_for_any_result_of_ransac_plane(street, mask):
    known = dict(street.known)
    known["ransac_plane"] = lambda points, *_: ((0.0, 1.0, 0.0, 0.0), np.full(len(points), mask))
    tree = ast.parse(LESSON.source.read_text("utf-8")).body
    source = next(
        statement for statement in tree if getattr(statement, "name", "") == "ground_plane"
    )
    exec(ast.unparse(source), known)
    plane, found = known["ground_plane"](street.street[:50])
    assert plane is None and len(found) == 0


def test_the_last_direction_has_the_smallest_sum_of_squares():
    rng = np.random.default_rng(4)
    points = rng.normal(size=(60, 3)) @ rng.normal(size=(3, 3))
    centred = points - points.mean(axis=0)
    _, singular, directions = np.linalg.svd(centred, full_matrices=False)
    along = centred @ directions.T
    np.testing.assert_allclose(along.T @ along, np.diag(singular**2), atol=1e-9)
    mixtures = rng.normal(size=(500, 3))
    mixtures /= np.linalg.norm(mixtures, axis=1, keepdims=True)
    sums = ((centred @ (mixtures @ directions).T) ** 2).sum(axis=0)
    np.testing.assert_allclose(sums, mixtures**2 @ singular**2)
    assert sums.min() >= singular[2] ** 2


def test_refitted_slopes_scatter_less_but_stay_biased(street):
    assert 100 * ROAD.slope == pytest.approx(2.2)
    slopes = street.slopes_of(range(30))
    mean = {name: np.mean(values) for name, values in slopes.items()}
    scatter = {name: np.std(values) for name, values in slopes.items()}
    assert scatter["all inliers"] < scatter["three points"] / 3
    assert max(slopes["all inliers"]) < 2.2
    # The text says that all four means are near the true slope.
    assert list(mean.values()) == pytest.approx([2.2] * 4, abs=0.3)
    # The text says that planes through three points are biased more than twice as much on average.
    assert 2.2 - mean["three points"] > 2 * (2.2 - mean["all inliers"])
    # The answer to the prediction is that averaging does not remove the bias.
    assert 2.2 - mean["all inliers"] > 3 * scatter["all inliers"] / 30**0.5
    alone = mean["inliers on the ground"]
    assert 2.2 - alone < 0.3 * (2.2 - mean["all inliers"])
    assert abs(mean["again, within 0.1 m"] - alone) < 0.005
    assert 2.2 - alone > 0.01
    # The text says that these errors are 9 cm, 2 cm and 5 mm at a distance of 30 m.
    errors = scatter["three points"], 2.2 - mean["all inliers"], 2.2 - mean["again, within 0.1 m"]
    assert np.round([0.3 * error for error in errors], 3) == pytest.approx(
        [0.09, 0.022, 0.005], abs=0.003
    )


def test_false_inliers_behind_the_car_lower_the_slope(street):
    behind = street.street[:, 0] < 0
    alone, with_behind, with_ahead, swallowed = [], [], [], []
    for seed in range(10):
        _, near = street.ransac_plane(street.street, 50, 0.2, seed)
        for slopes, mask in (
            (alone, street.is_ground),
            (with_behind, street.is_ground | behind),
            (with_ahead, street.is_ground | ~behind),
        ):
            slopes.append(street.slope_of(street.fit_plane(street.street[near & mask])))
        swallowed.append(behind[near & ~street.is_ground].mean())
    assert np.mean(swallowed) > 0.5
    assert np.mean(with_behind) < np.mean(alone) - 0.05
    assert np.mean(with_ahead) > np.mean(alone)


def test_the_rounds_in_the_table_decrease_to_one(street):
    shares = (0, 0.1, 0.3, 0.5, 0.7, 0.9, 1)
    line, plane = ([street.iterations_needed(w, s, 0.99) for w in shares] for s in (2, 3))
    assert all(np.diff(line[1:]) < 0) and all(np.diff(plane[1:]) < 0)
    assert line[-1] == plane[-1] == 1
    assert all(
        line_rounds <= plane_rounds for line_rounds, plane_rounds in zip(line, plane, strict=True)
    )
    assert street.iterations_needed(1e-6, 3, 0.99) > 1e18  # not lost to rounding


@pytest.fixture(scope="module")
def search_clouds(street):
    """The two clouds of 700 points that the lesson searches, each with its mask of the ground."""
    rng = np.random.default_rng(2)
    far = np.flatnonzero(np.hypot(street.cloud[:, 0], street.cloud[:, 1]) < 20)
    clouds = []
    for place in (street.rows, far):
        few = rng.choice(place, 700, replace=False)
        ground = street.truth["classes"][few] == street.names.index("ground")
        clouds.append((street.cloud[few], ground))
    return clouds


def test_noise_on_the_flattened_ground_is_along_the_ray(street, search_clouds):
    from utils.simulator.sensor import Sensor

    for points, ground in search_clouds:
        flat = street.flattened(points, ground)
        assert np.array_equal(flat[~ground], points[~ground])
        rays = flat[ground, :3] / np.linalg.norm(flat[ground, :3], axis=1, keepdims=True)
        # A plane z = a x + b y + c meets the ray of length r where r (z - a x - b y) = c.
        table = np.column_stack([points[ground, :2], np.ones(ground.sum())])
        a, b, c = np.linalg.lstsq(table, points[ground, 2], rcond=None)[0]
        ranges = c / (rays @ [-a, -b, 1])
        noise = np.linalg.norm(flat[ground, :3], axis=1) - ranges
        assert abs(noise.mean()) < 0.003
        assert noise.std() == pytest.approx(Sensor.range_noise, rel=0.1)
        # The text says that the noise moves a point up or down by only about 6 mm.
        upwards = Sensor.range_noise * np.abs(rays[:, 2])
        assert np.median(upwards) == pytest.approx(0.006, abs=0.001)


def test_the_model_causes_most_failures_of_good_samples(street, search_clouds):
    kept, kept_if_flat, ratios = [], [], []
    for points, ground in search_clouds:
        pure, good, chance = street.good_samples(points, ground)
        assert pure == pytest.approx(ground.mean() ** 3, abs=0.03)
        kept.append(good)
        ratios.append(
            street.iterations_needed(chance, 1, 0.99)
            / street.iterations_needed(ground.mean(), 3, 0.99)
        )
        kept_if_flat.append(street.good_samples(street.flattened(points, ground), ground)[1])
    # The text says "nine good samples in ten", "seven in ten" and "only one in three".
    assert kept_if_flat == pytest.approx([0.9, 0.9], abs=0.03)
    assert kept == pytest.approx([0.7, 1 / 3], abs=0.03)
    # The text says that crown, kerbs and pavements cause most failures, in both clouds.
    for share, share_if_flat in zip(kept, kept_if_flat, strict=True):
        assert share_if_flat - share > 0.6 * (1 - share)
    assert 1.1 < ratios[0] < ratios[1] < 3.2  # the text says "two or three times"


def test_the_ground_around_the_car_is_not_a_plane(street):
    near = np.hypot(street.cloud[:, 0], street.cloud[:, 1]) < 20
    ground = street.cloud[near & (street.truth["classes"] == street.names.index("ground"))]
    plane = np.array(street.fit_plane(ground))
    height = (ground[:, :3] @ plane[:3] + plane[3]) * np.sign(plane[2])
    assert np.round(np.percentile(height, [5, 95]), 2) == pytest.approx([-0.08, 0.12])


def test_failing_samples_of_the_ground_are_small_triangles(street):
    rng = np.random.default_rng(8)
    ground = np.flatnonzero(street.is_ground)
    widths = {True: [], False: []}
    for _ in range(300):
        p, q, r = street.street[rng.choice(ground, 3, replace=False), :3]
        near = street.point_plane_distance(street.street, street.plane_through(p, q, r)) <= 0.2
        longest = max(np.linalg.norm(p - q), np.linalg.norm(q - r), np.linalg.norm(r - p))
        height = np.linalg.norm(np.cross(q - p, r - p)) / longest
        widths[bool(near[street.is_ground].mean() >= 0.9)].append(height)
    assert np.median(widths[False]) < 0.5 * np.median(widths[True])


def test_the_first_three_mistakes_look_as_described(street):
    _, near = street.ransac_plane(street.street, 50, 0.2, 1)
    plane = np.array(street.fit_plane(street.street[near]))
    plane *= np.sign(plane[2])
    above = street.street[:, :3] @ plane[:3] + plane[3]
    assert (np.abs(8 * above) < 0.2).sum() < 0.5 * near.sum()
    assert (-above < 0.2).all()
    assert not (np.abs(above - 2 * plane[3]) < 0.2).any()


@pytest.mark.slow
def test_the_success_rate_stays_below_the_formula(street, search_clouds):
    for points, ground in search_clouds:
        found = street.success_rate(points, 16, ground)
        assert found < 1 - (1 - ground.mean() ** 3) ** 16


@pytest.mark.slow
def test_the_lorry_wins_twice_in_ten_frames(street):
    lines = street.drive("simulated")
    assert [number for number, upright, *_ in lines if upright < 0.9] == [21, 24]
    for _, upright, part, slope, height in lines:
        assert upright < 0.2 or upright > 0.99
        assert 0.25 < part < 0.6
        assert abs(slope - 2.2) < 0.15 and abs(height - 1.73) < 0.015


def test_the_lorry_is_the_largest_plane_when_it_passes(street):
    from utils.scenes import city_block
    from utils.simulator import CLASSES

    frame = city_block(frames=30)[21]
    cloud = frame.cloud
    chosen = (cloud[:, 0] > -10) & (cloud[:, 0] < 30) & (np.abs(cloud[:, 1]) < 5)
    largest, near = street.ransac_plane(street.around_us(cloud), 200, 0.2, 1)
    assert abs(largest[2]) == pytest.approx(0.01, abs=0.005)
    kinds = frame.scan.classes[chosen][::8]
    assert CLASSES.index("wall") not in kinds  # the text says that there are no houses
    assert (kinds[near] == CLASSES.index("truck")).mean() > 0.9
    assert (kinds == CLASSES.index("truck")).sum() > (kinds == CLASSES.index("ground")).sum()
    lorry = next(box for box in frame.boxes if box.kind == "truck" and abs(box.centre[0]) < 5)
    assert lorry.velocity[0] < 0
