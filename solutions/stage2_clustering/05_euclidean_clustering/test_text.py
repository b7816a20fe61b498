"""Tests of the statements in lesson 05, with an answer that follows its hints."""

from collections import deque

import numpy as np
import pytest
from scipy.cluster.hierarchy import cophenet, linkage
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import pdist, squareform
from sklearn.cluster import DBSCAN

from tests.lesson_texts import kept_function, run_statements_for

LESSON = "05_euclidean_clustering"


@pytest.fixture(scope="module")
def cluster():
    return kept_function("euclidean_clustering")


@pytest.fixture(scope="module")
def street():
    """Variables and functions that the lesson's cells define, by name."""
    return run_statements_for(
        LESSON, "objects", "kinds", "yard", "in_yard", "true_number", "seven", "close_pairs",
        "balls", "car", "member", "near", "which_thresholds", "pieces_at", "rising", "two_errors",
    )  # fmt: skip


@pytest.fixture(scope="module")
def labels(street, cluster):
    return cluster(street["obstacles"])


def same_partition(first, second):
    pairs = np.unique(np.stack([first, second]), axis=1)
    return pairs.shape[1] == len(np.unique(first)) == len(np.unique(second))


def in_space(points):
    return np.column_stack([points, np.zeros(len(points))])


def test_close_points_are_the_ego_car_or_invalid(street):
    names = street["truth"]["class_names"][street["truth"]["classes"]]
    close = (np.hypot(street["x"], street["y"]) <= 2) & (street["z"] > -1.2)
    assert set(names[close]) == {"ego", "invalid"}
    assert "ego" not in names[street["standing"]]


def test_with_the_road_nearly_all_points_are_one_cluster(street):
    x, y = street["x"], street["y"]
    around = (x > -8) & (x < 22) & (np.abs(y) < 9) & (np.hypot(x, y) > 2)
    points = street["cloud"][around][::4, :3]
    sizes = np.bincount(DBSCAN(eps=0.5, min_samples=1).fit_predict(points))
    assert sizes.max() > 0.9 * len(points)


def test_no_ball_radius_is_right(street):
    obstacles, objects, kinds = (street[name] for name in ("obstacles", "objects", "kinds"))
    for radius in (0.5, 3.0):
        number = street["balls"](obstacles, radius)
        assert len(np.unique(number[objects == 30])) > 4  # the long wall is split
    kinds_of_balls = [set(kinds[number == ball_number]) for ball_number in np.unique(number)]
    assert any({"pedestrian", "car"} <= kinds_of_ball for kinds_of_ball in kinds_of_balls)
    # The ring in the picture has the centre and the radius of this ball.
    ball = number == number[np.argmin(np.hypot(obstacles[:, 0] - 8.9, obstacles[:, 1] + 0.3))]
    assert {"pedestrian", "car"} == set(kinds[ball])
    middle = obstacles[np.argmax(ball), :2]
    assert np.allclose(middle, (8.9, -0.3), atol=0.05)
    assert np.hypot(*(obstacles[ball, :2] - middle).T).max() < 3.0


def test_the_seven_points_match_the_table(street, cluster):
    seven = street["seven"]
    pairs = street["close_pairs"](seven, 0.8).tolist()
    assert pairs == [[0, 2], [0, 4], [1, 3], [2, 4], [2, 5], [4, 5]]
    assert np.linalg.norm(seven[0] - seven[5]) == pytest.approx(0.91)
    assert cluster(in_space(seven), 0.8).tolist() == [1, 2, 1, 2, 1, 1, 3]


def labelled_on_leaving(points, threshold, most):
    """Label points as they leave the queue; return all queue entries and the number of labels."""
    labelled, entries = np.zeros(len(points), dtype=bool), [0]
    queue = deque(entries)
    while queue and len(entries) < most:
        point = queue.popleft()
        labelled[point] = True
        close = np.linalg.norm(points[:, :3] - points[point, :3], axis=1) < threshold
        new = np.flatnonzero(close & ~labelled).tolist()
        queue.extend(new)
        entries += new
    return entries, labelled.sum()


def test_one_more_point_can_join_all_seven_points(street):
    def pieces(points):
        return connected_components(squareform(pdist(points)) < 0.8)[0]

    seven = street["seven"]
    assert pieces(seven) == 3
    grid = np.stack(np.meshgrid(np.arange(0, 2.4, 0.05), np.arange(-1.1, 0.2, 0.05)), -1)
    joins = [pieces(np.vstack([seven, place])) == 1 for place in grid.reshape(-1, 2)]
    assert 0 < np.mean(joins) < 0.1, "possible, but only in a small region"
    answer = [1.5, -0.35]
    assert pieces(np.vstack([seven, answer])) == 1
    assert np.flatnonzero(np.linalg.norm(seven - answer, axis=1) < 0.8).tolist() == [1, 5, 6]


def test_a_point_labelled_on_leaving_enters_the_queue_again(street):
    entries, _ = labelled_on_leaving(in_space(street["seven"]), 0.8, 1000)
    assert entries == [0, 2, 4, 4, 5, 5, 5] and len(set(entries)) == 4
    car = street["obstacles"][street["objects"] == 1]
    gaps = np.linalg.norm(car[:, None, :3] - car[None, :, :3], axis=2)
    assert 18 < np.mean(np.sum(gaps < 0.5, axis=1) - 1) < 22
    entries, done = labelled_on_leaving(car, 0.5, 50 * len(car))
    assert len(entries) >= 50 * len(car) and done < 0.6 * len(car)


def test_the_growing_cluster_ends_at_the_car(street, cluster):
    car = street["car"]
    labels = cluster(car)
    assert labels.max() == 2  # the car, and the pedestrian that stays grey
    first = np.argmin(car @ [1, 1, 0])
    assert np.sum(labels == labels[first]) > 0.8 * len(car)
    assert (street["states"][-1] > 0).tolist() == (labels == labels[first]).tolist()
    assert (street["states"][-2] > 0).sum() < (street["states"][-1] > 0).sum()


def test_the_longest_cluster_is_three_walls(street, labels):
    lengths = [
        np.ptp(street["obstacles"][labels == label, :2], axis=0).max()
        for label in range(1, labels.max() + 1)
    ]
    inside = street["objects"][labels == 1 + np.argmax(lengths)]
    assert np.unique(inside).tolist() == [29, 30, 36]
    # The picture has a ring around the short wall, which touches the two others.
    middle = street["obstacles"][street["objects"] == 36, :2].mean(axis=0)
    assert np.allclose(middle, (-2.0, -8.2), atol=0.3)


def test_two_errors_cancel_at_half_a_metre(street, cluster):
    yard, things = street["yard"], street["objects"][street["in_yard"]]
    found = cluster(yard, 0.5)
    assert found.max() == len(np.unique(things))
    assert set(found[things == 15]) & set(found[things == 16])
    assert len(np.unique(found[things == 10])) > 1


def test_cyclist_and_car_are_one_cluster_at_a_metre_and_a_half(street, cluster):
    found, things = cluster(street["yard"], 1.5), street["objects"][street["in_yard"]]
    assert set(found[things == 12]) == set(found[things == 10])


def test_counts_of_larger_clusters_match_the_answer(street, cluster):
    yard, things = street["yard"], street["objects"][street["in_yard"]]
    larger, pieces = [], []
    for threshold in (0.3, 0.5, 0.7):
        found = cluster(yard, threshold)
        larger.append(np.sum(np.bincount(found) >= 10))
        pieces.append(np.sum(np.bincount(found[things == 10]) >= 10))
        people = np.isin(things, (15, 16))
        assert len(np.unique(found[people])) == 1
    assert larger == [7, 5, 5] and pieces == [3, 1, 1]
    assert np.sum(np.bincount(things) >= 10) == 6


def test_no_threshold_is_right_for_both(street):
    tried = np.array([0.1, 0.15, 0.2, 0.25, 0.3, 0.5, 0.65, 0.7, 1.0, 2.5])
    apart, whole = street["which_thresholds"](tried)
    assert apart.any() and whole.any() and not (apart & whole).any()


def test_the_dendrogram_agrees_with_single_linkage(street):
    rows, found = street["pieces_at"](street["rising"])
    yard, things = street["yard"], street["objects"][street["in_yard"]]
    joins = squareform(cophenet(linkage(yard[:, :3], "single")))[np.ix_(rows, rows)]
    for threshold, labels in zip(street["rising"], found, strict=True):
        assert ((labels[:, None] == labels) == (joins < threshold)).all()
    names = things[rows]
    people, car = np.isin(names, (15, 16)), names == 10
    assert joins[np.ix_(people, people)].max() < 0.25 and people.sum() == 2
    assert 0.65 < joins[np.ix_(car, car)].max() < 0.7 and car.sum() > 2
    # At the default threshold, the larger pieces belong to all of the clusters in the picture.
    assert len(np.unique(found[street["rising"] < 0.5][-1])) == 7


@pytest.mark.slow
def test_one_of_the_two_errors_always_remains(street):
    torn, joined = street["two_errors"](np.array([0.2, 0.25, 0.5, 0.7, 2.0]))
    assert (torn + joined > 0).all()
    assert (np.diff(torn) <= 0).all() and (np.diff(joined) >= 0).all()
    assert torn[2] > joined[2]  # the curves cross at a threshold above the default


@pytest.mark.slow
def test_at_seven_tenths_no_road_user_is_torn_and_a_moving_car_is_joined(street, cluster):
    torn, joined = street["two_errors"](np.array([0.5, 0.6, 0.65, 0.7]))
    assert np.round(18 * torn).tolist() == [5, 4, 2, 0]
    assert np.round(18 * joined).tolist() == [2, 2, 4, 4]
    objects, truth = street["objects"], street["truth"]
    users = np.unique(objects[np.isin(street["kinds"], ["car", "truck", "pedestrian", "cyclist"])])
    new = []
    # The gap between the two cars is 0.640 m.
    narrow, wide = (cluster(street["obstacles"], threshold) for threshold in (0.635, 0.645))
    for user in users:
        before, after = (
            set(objects[np.isin(found, found[objects == user])].tolist())
            for found in (narrow, wide)
        )
        if before == {user} != after:
            new.append((int(user), sorted(after)))
    assert new == [(6, [6, 9]), (9, [6, 9])]
    speeds = np.hypot(*truth["box_velocities"].T)
    parked, moving = (speeds[truth["box_identities"] == car].item() for car in (6, 9))
    assert parked == 0 and moving == pytest.approx(8, abs=0.1)


@pytest.mark.slow
def test_a_car_counts_as_torn_when_it_lost_a_single_point(street, cluster):
    lost = []
    for car in np.unique(street["objects"][street["kinds"] == "car"]):
        found = cluster(street["obstacles"])[street["objects"] == car]
        lost.append(sorted(np.unique(found, return_counts=True)[1].tolist()))
    assert [1, 228] in lost


def test_common_mistakes_match_the_table(street, cluster, labels):
    obstacles, objects, kinds = (street[name] for name in ("obstacles", "objects", "kinds"))
    # A threshold of 0.71 m (the square root of 0.5) joins the parts of the turning car, and also
    # two other cars.
    wider = cluster(obstacles, 0.5**0.5)
    assert len(np.unique(labels[objects == 10])) == 2 and len(np.unique(wider[objects == 10])) == 1
    cars = np.unique(objects[kinds == "car"])
    together = [
        (a, b)
        for a in cars
        for b in cars[cars > a]
        if set(wider[objects == a]) & set(wider[objects == b])
    ]
    assert together
    assert not any(set(labels[objects == a]) & set(labels[objects == b]) for a, b in together)
    # If distances include the intensity, the clusters change only when intensities go up to 255.
    for scale, same in ((1, True), (255, False)):
        four = obstacles * [1, 1, 1, scale]
        found = DBSCAN(eps=0.5, min_samples=1).fit_predict(four)
        assert same_partition(found, labels) == same
    assert found.max() > 10 * labels.max()


def test_with_a_first_label_of_zero_the_queue_never_becomes_empty(street):
    points = in_space(street["seven"])
    labels, queue = np.zeros(len(points), dtype=int), deque([0])
    for _ in range(100):
        gaps = np.linalg.norm(points - points[queue.popleft()], axis=1)
        new = np.flatnonzero((gaps < 0.8) & (labels == 0))
        labels[new] = 0
        queue.extend(new)
    assert len(queue) > 100


def test_scikit_learn_also_joins_points_at_the_threshold(cluster):
    pair = np.array([[0.0, 0, 0], [0.5, 0, 0]])
    assert len(set(DBSCAN(eps=0.5, min_samples=1).fit_predict(pair))) == 1
    assert cluster(pair, 0.5).tolist() == [1, 2]


def test_scikit_learn_gives_the_same_clusters(street, labels):
    found = DBSCAN(eps=0.5, min_samples=1).fit_predict(street["obstacles"][:, :3]) + 1
    assert same_partition(found, labels) and found.min() == 1


def test_the_beams_are_a_third_of_a_degree_apart(street):
    cloud, beams = street["cloud"], street["truth"]["beams"]
    far = np.hypot(cloud[:, 0], cloud[:, 1]) > 5
    up = np.degrees(np.arctan2(cloud[:, 2], np.hypot(cloud[:, 0], cloud[:, 1])))
    angles = [np.median(up[far & (beams == beam)]) for beam in range(2, 12)]
    step = -np.mean(np.diff(angles))
    assert step == pytest.approx(1 / 3, abs=0.02)
    assert [round(100 * r * np.radians(1 / 3)) for r in (30, 80)] == [17, 47]


def test_far_cars_are_torn_into_pieces(street):
    cloud, truth = street["cloud"], street["truth"]
    kinds = truth["class_names"][truth["classes"]]
    far = (truth["objects"] > 0) & (np.hypot(cloud[:, 0], cloud[:, 1]) > 30)
    found = DBSCAN(eps=0.5, min_samples=1).fit_predict(cloud[far, :3])
    pieces = {}
    for car in np.unique(truth["objects"][far & (kinds == "car")]):
        mine = truth["objects"][far] == car
        if mine.sum() >= 10 and np.hypot(*cloud[far][mine, :2].mean(axis=0)) > 40:
            pieces[car] = len(np.unique(found[mine]))
    assert len(pieces) > 5 and min(pieces.values()) > 1
