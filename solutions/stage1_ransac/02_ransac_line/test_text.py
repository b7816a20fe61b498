"""Tests of the statements in lesson 02, with answers that follow its hints."""

import re

import numpy as np
import pytest

from tests.lesson_texts import run_lesson
from utils import load_cloud
from utils.datasets import DATA

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def lesson_run():
    return run_lesson("02_ransac_line")


def numbers_in(line):
    return [float(number) for number in re.findall(r"-?\d+\.\d*", line)]


def test_tiny_examples_give_the_expected_results(lesson_run):
    lines = lesson_run.text.splitlines()
    yours = [number for number, line in enumerate(lines) if line.startswith("yours:   ")]
    assert len(yours) == 4
    for number in yours[:3]:
        assert numbers_in(lines[number]) == numbers_in(lines[number + 1])
    line, inliers = lesson_run.names["ransac_line"](lesson_run.names["five"], 20, 0.1, 0)
    assert np.allclose(np.abs(line), [0, 1, 1]) and inliers.tolist() == [True] * 4 + [False]


def test_the_picture_of_the_quarter_turn_is_right(lesson_run):
    p, q = (1, 2), (4, 6)
    direction, (a, b, c) = np.subtract(q, p), (-0.8, 0.6, -0.4)
    assert (a, b) == pytest.approx(np.array([-direction[1], direction[0]]) / 5)
    assert [a * x + b * y + c for x, y in (p, q)] == pytest.approx([0, 0])
    assert np.hypot(a, b) == pytest.approx(1)
    # The student's function gives the same line, up to its sign.
    line = lesson_run.names["line_through"](np.array(p, dtype=float), np.array(q, dtype=float))
    assert np.abs(line) == pytest.approx(np.abs((a, b, c)))


def test_outliers_flatten_the_least_squares_line(lesson_run):
    points = lesson_run.names["points"]
    assert abs(np.polyfit(*points.T, 1)[0]) < 0.2
    assert abs(np.polyfit(*points[:10].T, 1)[0] - 1) < 0.1


def test_circles_fit_into_the_picture(lesson_run):
    (left, right), (low, high) = lesson_run.names["window"]
    some = lesson_run.names["some"]
    radius = lesson_run.names["point_line_distance"](
        some, lesson_run.names["line_through"](np.array([-5.0, -2.0]), np.array([5.0, 3.0]))
    )
    assert (some[:, 0] - radius > left).all() and (some[:, 0] + radius < right).all()
    assert (some[:, 1] - radius > low).all() and (some[:, 1] + radius < high).all()


def test_the_table_of_rounds_is_as_described(lesson_run):
    counts = lesson_run.names["counts"]
    assert counts[3] == max(counts) >= 10
    assert max(counts[:3] + counts[4:]) <= 7
    rng, points, lengths = np.random.default_rng(3), lesson_run.names["points"], {}
    for number in range(1, 11):
        i, j = rng.choice(20, size=2, replace=False)
        if i < 10 and j < 10:
            lengths[number] = np.hypot(*(points[i] - points[j]))
    assert list(lengths) == [2, 4, 7, 9]
    assert max(lengths[number] for number in (2, 7, 9)) < 0.5 * lengths[4]


def test_one_run_in_ten_fails(lesson_run):
    points, ransac_line = lesson_run.names["points"], lesson_run.names["ransac_line"]
    found = [ransac_line(points, 10, 1.0, seed)[1][:10].sum() >= 8 for seed in range(400)]
    assert sum(found[:4]) >= 3
    assert 0.06 < 1 - np.mean(found) < 0.15


def test_ransac_accepts_the_dragged_point_and_rejects_it_again(lesson_run):
    low, high = lesson_run.names["window"][1]
    wall, kept, slopes, directions = lesson_run.names["points"][:10], [], [], []
    heights = np.round(np.arange(low, high + 0.05, 0.1), 1)
    for y in heights:
        drawing = lesson_run.names["two_lines"](np.vstack([wall, (4, y)]))
        kept.append(drawing.labels[10] == 1)
        a, b, _ = drawing.lines["least squares"]
        slopes.append(-a / b)
        directions.append(error_of(drawing.lines["RANSAC"]))
    # The answer says "at about y = 1.4 m", "before 6 m", "a few degrees" and "no effect".
    assert heights[kept] == pytest.approx(np.arange(1.4, 5.91, 0.1))
    assert len(np.unique(np.round(np.array(directions)[~np.array(kept)], 6))) == 1
    assert np.ptp(directions) < 6
    assert (np.diff(slopes) > 0).all(), "the least-squares line never rejects the point"


def test_all_seeds_agree_after_two_thousand_rounds(lesson_run):
    assert lesson_run.names["always_the_same"] == ["2,000 rounds"]
    line_through, distance = (
        lesson_run.names["line_through"],
        lesson_run.names["point_line_distance"],
    )
    points = lesson_run.names["points"]
    votes = [
        (distance(points, line_through(points[i], points[j])) <= 1.0).sum()
        for i, j in lesson_run.names["pairs"]
    ]
    assert len(votes) == 190
    assert sorted(votes)[-2:] == [11, 12]
    # Twenty rounds are enough for a good line.
    found = lesson_run.names["directions"](20, 1.0)
    assert np.abs(found - 45).max() <= 10.5


def test_half_a_metre_is_more_accurate_than_a_metre(lesson_run):
    ransac_line, points = lesson_run.names["ransac_line"], lesson_run.names["points"]
    errors = {}
    for threshold in (0.5, 1.0):
        found = [ransac_line(points, 200, threshold, seed) for seed in range(10)]
        errors[threshold] = np.mean([error_of(line) for line, _ in found])
        assert all(inliers[:10].sum() >= 9 for _, inliers in found)
    assert errors[0.5] + 1 < errors[1.0] < 5


def test_code_without_a_test_for_none_works_on_the_twenty_points(lesson_run):
    assert len(np.unique(lesson_run.names["points"], axis=0)) == 20
    assert len(np.unique(lesson_run.names["rounded"], axis=0)) < 20


def test_directions_vary_more_with_a_wider_band(lesson_run):
    spread = [
        np.ptp(lesson_run.names["directions"](200, threshold))
        for threshold in (0.2, 0.5, 1, 2, 3, 4)
    ]
    assert spread == sorted(spread)
    wall, others = (
        lesson_run.numbers_after("within 0.2 m:")[0],
        lesson_run.numbers_after("within 3.5 m:")[-1],
    )
    assert wall == 5 and others >= 5
    assert spread[1] < 3 and lesson_run.numbers_after("within 0.5 m:") == [9, 10, 1]
    assert lesson_run.numbers_after("within 1.0 m:")[0] >= 9
    assert lesson_run.numbers_after("within 1.0 m:")[-1] <= 2


def test_the_wall_is_within_its_band(lesson_run):
    rng, furthest = np.random.default_rng(0), np.hypot(0.6, 0.6)
    for _ in range(50):
        wall = lesson_run.names["quiz_points"](rng)[:10]
        assert np.abs(wall @ [1, -1]).max() / np.sqrt(2) < furthest < 0.85


def test_success_follows_the_formula(lesson_run):
    rate = lesson_run.names["success_rate"]
    assert rate(10, 0.2) < 0.5 and rate(10, 2 / 3) > 0.95
    for rounds in (2, 10, 40):
        # The text says that measurements are off by "a few percentage points".
        assert rate(rounds, 0.3) == pytest.approx(1 - (1 - 0.3**2) ** rounds, abs=0.06)
    assert rate(10, 0.26) == pytest.approx(0.5, abs=0.12)


def test_rough_walls_need_two_or_three_times_as_many_rounds(lesson_run):
    rate = lesson_run.names["success_rate"]

    def theory(rounds):
        return 1 - (1 - 0.5**2) ** rounds

    by_roughness = [rate(8, 0.5, roughness, 0.6) for roughness in (0.005, 0.1, 0.25)]
    assert by_roughness == sorted(by_roughness, reverse=True)
    assert theory(8) == pytest.approx(0.9, abs=0.005)
    assert by_roughness[-1] < theory(8) - 0.1
    assert rate(24, 0.5, 0.25, 0.6) > theory(8)


def test_the_answer_about_the_refit_is_right(lesson_run):
    points, ransac_line = lesson_run.names["points"], lesson_run.names["ransac_line"]
    (a, b, _), inliers = ransac_line(points, 40, 1.0, 0)
    slope = np.polyfit(points[inliers, 0], points[inliers, 1], 1)[0]
    assert inliers.sum() == 11 and [round(-a / b, 2), round(slope, 2)] == [1.18, 0.98]
    assert lesson_run.names["refit"](points, inliers)[0] == pytest.approx(0.14, abs=0.005)


def test_least_squares_on_the_inliers_helps(lesson_run):
    assert np.median(lesson_run.names["refitted"]) < 0.8 * np.median(lesson_run.names["alone"])


def test_two_walls_of_the_street_are_found(lesson_run):
    cloud, truth = load_cloud("cloud.txt"), np.load(DATA / "cloud_truth.npz")
    is_wall = (truth["class_names"][truth["classes"]] == "wall")[lesson_run.names["in_slice"]]
    left_over, found = cloud[lesson_run.names["in_slice"], :2], []
    for _ in range(2):
        _, inliers = lesson_run.names["ransac_line"](left_over, 100, 0.1, 1)
        assert inliers.sum() > 1500 and is_wall[inliers].mean() > 0.99
        found.append((inliers.sum(), np.ptp(left_over[inliers, 0])))
        along = left_over[inliers, 0]
        left_over, is_wall = left_over[~inliers], is_wall[~inliers]
    (most, short_length), (fewer, long_length) = found  # both walls run along x
    assert most > 1.3 * fewer and long_length > 1.3 * short_length
    # The second line follows house fronts on both sides of the first wall.
    assert min((along < -3).sum(), (along > 13).sum()) > 200
    assert not ((along > -2) & (along < 13)).any()


def test_the_scikit_learn_example_finds_the_wall(lesson_run):
    from sklearn.linear_model import RANSACRegressor

    points = lesson_run.names["points"]
    ransac = RANSACRegressor(max_trials=50, residual_threshold=1.0, random_state=0)
    ransac.fit(points[:, :1], points[:, 1])
    assert ransac.inlier_mask_.sum() >= 8
    assert abs(ransac.estimator_.coef_[0] - 1) < 0.3


def best_line(lesson_run, points, rounds, threshold, rng, score, second=None):
    """Run RANSAC with `score`; `second` may restrict the second points to "near" or "far" ones."""
    line_through, distance = (
        lesson_run.names["line_through"],
        lesson_run.names["point_line_distance"],
    )
    rng, best = np.random.default_rng(rng), (-np.inf, None)
    for _ in range(rounds):
        i, j = rng.choice(len(points), size=2, replace=False)
        if second:
            order = np.argsort(np.hypot(*(points - points[i]).T))
            j = rng.choice(order[1:6] if second == "near" else order[-5:])
        line = line_through(points[i], points[j])
        best = max(
            best,
            (score(distance(points, line), threshold), line),
            key=lambda candidate: candidate[0],
        )
    return best[1]


def error_of(line):
    return abs((np.degrees(np.arctan2(-line[0], line[1])) - 45 + 90) % 180 - 90)


def inliers_within(distances, threshold):
    return np.sum(distances <= threshold)


def test_the_answer_about_msac_is_right(lesson_run):
    def msac(distances, threshold):
        return -np.minimum(distances**2, threshold**2).sum()

    def errors(score, threshold):
        """Yield errors. As in the lesson, one generator draws both the points and the samples."""
        for seed in range(300):
            rng = np.random.default_rng(seed)
            points = lesson_run.names["quiz_points"](rng)
            yield error_of(best_line(lesson_run, points, 40, threshold, rng, score))

    plain, better = (
        {threshold: np.median([*errors(score, threshold)]) for threshold in (0.3, 0.7, 1.0, 3.0)}
        for score in (inliers_within, msac)
    )
    assert plain[0.3] == pytest.approx(better[0.3], abs=0.2)
    assert better[0.7] < plain[0.7] - 0.2
    in_the_text = [[2.2, 1.6], [7.1, 2.6]]
    assert (
        np.round([[plain[tolerance], better[tolerance]] for tolerance in (1.0, 3.0)], 1).tolist()
        == in_the_text
    )


def test_the_answer_about_the_second_point_is_right(lesson_run):
    points, distance = lesson_run.names["points"], lesson_run.names["point_line_distance"]

    def misses(seed, second):
        line = best_line(lesson_run, points, 10, 1.0, seed, inliers_within, second)
        return (distance(points, line)[:10] <= 1.0).sum() < 8

    missed = [
        np.mean([misses(seed, second) for seed in range(1000)]) for second in (None, "near", "far")
    ]
    assert missed == pytest.approx([0.10, 0.18, 0.03], abs=0.02)


def test_sampling_without_replacement_lowers_the_success_rate():
    put_back, as_drawn = ((12 / 60) * (12 / 60), (12 / 60) * (11 / 59))
    shares = [1 - (1 - good) ** 10 for good in (as_drawn, put_back)]
    assert np.round(shares, 2).tolist() == [0.32, 0.34]
