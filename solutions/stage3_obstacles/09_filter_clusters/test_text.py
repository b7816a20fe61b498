"""Tests of the statements in lesson 09, with an answer that follows its hints."""

import re

import numpy as np
import pytest

from grader.course.lessons import find_lesson, load_reference
from utils import check, load_cloud
from utils.checks.core import notes_of, run_check
from utils.datasets import DATA
from utils.drive import STREETS, chain, drive_street, on_time
from utils.drive.person import BRAKING_RANGE, look_at_person, street_with_person
from utils.scenes import random_street
from utils.simulator import vlp16
from utils.simulator.streets import EGO_LANE

NAME = "09_filter_clusters"


NAMES = ("ten", "size_of_puff", "theory", "minima", "moved_up_in_the_loop")
DRAWN = ("cluster_labels", "left_over", "thin")


@pytest.fixture(scope="module")
def lesson_run():
    """Functions and variables of the lesson, as attributes. The simulation takes a second."""
    return load_reference(
        NAME,
        *NAMES,
        *DRAWN,
        "in_view",
        "kind",
        "distance",
        "size",
        "frames",
        "clusters_of",
        "plain_view",
        "names",
    )


@pytest.mark.slow
def test_ten_points_give_the_printed_results(lesson_run):
    """Compare the results with those that the notebook prints as "expected"."""
    text = find_lesson(NAME).source.read_text("utf-8")
    for minimum in (2, 3):
        assert (
            f"({minimum}, {lesson_run.filter_clusters(lesson_run.ten, minimum).tolist()})" in text
        )
    filtered = lesson_run.filter_clusters(lesson_run.ten, 3)
    assert (len(set(filtered[filtered > 0])), (filtered == 0).sum()) == (1, 6)


@pytest.mark.slow
def test_the_slider_reaches_the_default_and_clears_the_road(lesson_run):
    slider = find_lesson(NAME).source.read_text("utf-8").split("IntSlider(")[1].split(")")[0]
    settings = dict(part.strip().split("=") for part in slider.split(",")[:4])
    low, high, step, value = (int(settings[name]) for name in ("min", "max", "step", "value"))
    assert (100 - low) % step == 0
    assert value < lesson_run.size_of_puff.max() < 100 < high, (
        "the road is not clear before the slider is moved"
    )


@pytest.mark.slow
def test_thinned_pictures_contain_all_noise(lesson_run):
    for minimum in (5, 10, 100, 500, 600):
        noise = (lesson_run.filter_clusters(lesson_run.cluster_labels, minimum) == 0).sum()
        assert (lesson_run.left_over(minimum) == 0).sum() == noise > 0
    assert len(lesson_run.thin) < 0.4 * len(lesson_run.cluster_labels)


@pytest.mark.slow
def test_the_largest_house_front_has_as_many_points_as_hundreds_of_small_clusters(lesson_run):
    sizes = np.bincount(lesson_run.cluster_labels)[1:]
    assert sizes.max() / sizes[sizes < 100].mean() > 200


def test_a_lower_minimum_keeps_near_pedestrians_and_removes_ghosts(lesson_run):
    group = {"ghost": lesson_run.kind == "ground", "near": lesson_run.distance < 15}
    group["near"] &= lesson_run.kind == "pedestrian"
    gone = {
        name: [(lesson_run.size[some] < minimum).mean() for minimum in (10, 100)]
        for name, some in group.items()
    }
    assert gone["ghost"][1] == 1 and gone["near"][1] > 0.3
    assert gone["ghost"][0] > 0.9 and gone["near"][0] < 0.1
    assert not lesson_run.in_view[group["near"] & (lesson_run.size < 100)].any()


def test_returns_of_pedestrians_fall_with_the_square_of_the_distance(lesson_run):
    assert lesson_run.theory(20.0) == pytest.approx(lesson_run.theory(10.0) / 4)
    reach = np.sqrt(lesson_run.theory(1.0) / 100)
    assert reach == pytest.approx(15, abs=0.5)
    slow, fast = (2.6 + 0.5 * speed + speed**2 / 14 for speed in (30 / 3.6, 50 / 3.6))
    assert slow < reach < fast == pytest.approx(23.3, abs=0.1), "only a slow car can stop in time"


def test_the_theory_applies_to_pedestrians_in_plain_view(lesson_run):
    away, size = lesson_run.distance, lesson_run.size
    person = (lesson_run.kind == "pedestrian") & (away > 5) & (away < 25)
    times = size / lesson_run.theory(away)
    free, hidden = times[person & lesson_run.in_view], times[person & ~lesson_run.in_view]
    assert np.median(free) == pytest.approx(1, abs=0.1) and np.quantile(free, 0.9) < 1.5
    assert len(free) < len(hidden) / 4 and np.median(hidden) < 0.5


def test_only_the_heads_of_distant_people_in_plain_view_are_above_the_ground_level(lesson_run):
    far = (lesson_run.kind == "pedestrian") & lesson_run.in_view & (lesson_run.distance > 25)
    ratios = lesson_run.size[far] / lesson_run.theory(lesson_run.distance[far])
    assert np.median(ratios) < 0.3 and ratios.max() < 0.8 and far.sum() == 6
    upper, lower, near = [], [], []  # metres above the ground level, and of the street below ours
    for frame in lesson_run.frames:
        labels, kinds, distances = lesson_run.clusters_of(frame)
        shown = (kinds == "pedestrian") & lesson_run.plain_view(frame)
        boxes = {box.identity: box for box in frame.boxes}
        use = frame.cloud[:, 2] >= -1.2
        use &= ~np.isin(
            frame.scan.classes, [lesson_run.names.index(kind) for kind in ("invalid", "ego")]
        )
        for row in np.flatnonzero(shown):
            number = frame.scan.objects[use][np.flatnonzero(labels == row + 1)[0]]
            box = boxes[number]
            height = box.corners[:, 2].max() + 1.2
            if distances[row] < 25:
                near.append(height)
            else:
                upper.append(height)
                lower.append(-1.73 - box.corners[:, 2].min())
    assert len(upper) == 6
    assert min(upper) > 0.19 and max(upper) < 0.6
    assert min(lower) > 0.7 and max(lower) < 1.2
    assert np.median(near) == pytest.approx(1.2, abs=0.05)
    # The smaller area explains the number of points.
    assert np.mean(ratios) == pytest.approx(np.mean(upper) / np.median(near), rel=0.3)


def test_each_minimum_removes_a_third_of_the_people_within_its_distance(lesson_run):
    for minimum in (5, 10, 30, 100, 300):
        reach = np.sqrt(lesson_run.theory(1.0) / minimum)
        within = (lesson_run.kind == "pedestrian") & (lesson_run.distance < reach)
        removed = within & (lesson_run.size < minimum)
        assert removed.sum() > 0.3 * within.sum()
        assert lesson_run.in_view[removed].mean() < 0.2


def test_distant_people_do_not_reach_the_distances_of_the_theory_where_the_street_falls(lesson_run):
    far = (lesson_run.kind == "pedestrian") & lesson_run.in_view & (lesson_run.distance > 25)
    assert (lesson_run.size[far] >= 5).sum() == 1  # the table says "up to 66.2 m" and "46.8 m"
    assert (lesson_run.size[far] >= 10).sum() == 0
    reaches = [np.sqrt(lesson_run.theory(1.0) / minimum) for minimum in (5, 10, 30)]
    assert (np.array(reaches) > 25).tolist() == [True, True, True]


def test_puffs_have_10_points_on_average(lesson_run):
    assert lesson_run.size_of_puff.mean() == pytest.approx(10, abs=0.5)
    assert lesson_run.size_of_puff.min() == 1 and lesson_run.size_of_puff.max() > 50


def test_a_minimum_that_falls_with_the_distance_keeps_as_many_people_and_ghosts_as_stated(
    lesson_run,
):
    text = find_lesson(NAME).source.read_text("utf-8")
    function = re.search(r"def minimum_at.*?# change this line\n", text, re.S)[0]
    assert function.count("return 100 + 0 * distance  # change this line") == 1
    (answer,) = re.findall(r"Write `(return 100 \* [^`]*)`", text)
    namespace = {}
    exec(function.replace("return 100 + 0 * distance  # change this line", answer), namespace)
    distance, size = lesson_run.distance, lesson_run.size
    person, ghost = (lesson_run.kind == kind for kind in ("pedestrian", "ground"))
    near = distance < 15
    assert ((person & near).sum(), (person & ~near).sum()) == (69, 201)
    fixed, falling = size >= 10, size >= namespace["minimum_at"](distance)
    groups = ghost, person & near, person & ~near
    assert [(falling & group).sum() for group in groups] == [203, 42, 73]
    assert [(fixed & group).sum() for group in groups] == [40, 67, 66]
    assert [((size >= 100) & group).sum() for group in groups][::2] == [0, 0]
    assert distance[falling & ghost].min() > 30
    assert namespace["minimum_at"](np.array([30.0])) < 12
    assert not lesson_run.in_view[person & near & ~falling].any()


def test_a_list_gets_a_note(lesson_run):
    def filter_clusters(cluster_labels, min_num_points=100):
        return lesson_run.filter_clusters(cluster_labels, min_num_points).tolist()

    failed = [
        note.name
        for note in notes_of("filter_clusters")
        if run_check(note, filter_clusters).failure
    ]
    assert failed == ["returns_an_array"]


def test_the_car_brakes_as_in_lesson_07():
    ours, theirs = (
        find_lesson(name).source.read_text("utf-8") for name in (NAME, "07_filter_by_distance")
    )
    assert "drives on for half a second while it thinks, and then brakes at 7 m/s²" in ours
    assert "drives on for half a second while it thinks, and then brakes at 7 m/s²" in theirs


def test_the_naive_loop_keeps_every_second_small_neighbour(lesson_run):
    labels = np.repeat([1, 2, 3, 4, 5, 6], [9, 1, 1, 1, 1, 9])
    kept = lesson_run.moved_up_in_the_loop(labels, 3)
    assert np.unique(labels[kept > 0]).tolist() == [1, 3, 5, 6]
    alone = np.repeat([1, 2, 3], [9, 1, 9])  # the text: "with a single small cluster all is well"
    assert np.array_equal(lesson_run.moved_up_in_the_loop(alone, 3) > 0, alone != 2)


def test_cars_and_walls_overlap_in_size():
    truth, scan = np.load(DATA / "cloud_truth.npz"), load_cloud("cloud.txt")
    near = (scan[:, 2] >= -1.2) & (np.hypot(scan[:, 0], scan[:, 1]) < 30)
    sizes = {}
    for kind in ("car", "wall"):
        chosen = near & (truth["classes"] == truth["class_names"].tolist().index(kind))
        sizes[kind] = np.unique(truth["objects"][chosen], return_counts=True)[1]
    assert sizes["wall"].min() < sizes["car"].max() < sizes["wall"].max()


def test_a_failed_check_shows_the_minimum(capsys):
    def filter_clusters(cluster_labels, min_num_points=100):
        filtered, found = cluster_labels.copy(), np.unique(cluster_labels)
        for label in found:
            if np.sum(cluster_labels == label) < 100:
                filtered[cluster_labels == label] = 0
        return filtered

    with pytest.raises(Exception, match="checks failed"):
        check(filter_clusters)
    assert "minimum 3" in capsys.readouterr().out


@pytest.mark.slow
def test_16_beams_give_objects_about_a_sixth_of_the_points_and_keep_people_within_15_m():
    ratios, people = [], []
    for seed in (3, 5):
        many, few = random_street(seed), random_street(seed, sensor=vlp16())
        returns = {box.identity: box.returns for box in few.boxes}
        for box in many.boxes:
            distance = np.hypot(*box.centre[:2])
            if box.kind in ("car", "pedestrian") and box.returns > 50 and distance < 25:
                ratios.append(box.returns / returns[box.identity])
            if box.kind == "pedestrian" and box.returns > 50 and distance < 15:
                people.append(returns[box.identity])
    assert 5 < np.median(ratios) < 7
    assert min(people) > 10 and np.median(people) < 50  # far below the minimum of 100


def test_the_cyclist_meets_the_car_at_the_stated_time():
    (street,) = (candidate for candidate in STREETS if candidate.number == 3)
    (cyclist,) = street.actors
    ((_, pace),) = cyclist.speeds
    meeting = cyclist.start_position / street.limit + abs(cyclist.obstacle.pose.y - EGO_LANE) / pace
    assert round(meeting) == 9


@pytest.mark.proof
@pytest.mark.parametrize(("minimum", "hits"), [(10, False), (40, False), (50, True)])
def test_the_largest_minimum_that_spares_the_cyclist_is_40(lesson_run, minimum, hits):
    detect = chain(keep=lambda labels: lesson_run.filter_clusters(labels, minimum))
    trip = drive_street(3, detect, seconds=10, clock=on_time)
    assert bool(trip.report.collision) == hits
    if hits:
        assert "a cyclist in our lane, 3 m ahead" in str(trip)
        assert "for the first time 1.0 s before the collision" in str(trip)
    else:
        assert trip.report.closest_distance == pytest.approx(2, abs=0.2)


@pytest.mark.parametrize(
    ("place", "points", "has_box", "words"),
    [
        ((11.0, -0.6), 25, False, "At the start, 25 points are left"),
        ((11.0, -0.4), 35, True, "At y = -0.4, only 20 cm farther to the left, there are 35"),
        ((11.0, -3.0), 4, False, "at (11, -3), only 4 points are left"),
    ],
)
def test_a_person_has_the_stated_number_of_points(lesson_run, place, points, has_box, words):
    seen = look_at_person(*place, lambda labels: lesson_run.filter_clusters(labels, 30))
    assert (seen.points, seen.has_box, seen.brakes) == (points, has_box, has_box)
    text = find_lesson(NAME).source.read_text("utf-8")
    assert "place = [11.0, -0.6]" in text and words in text


@pytest.mark.proof
def test_a_person_has_a_box_in_the_stated_places(lesson_run):
    """Look at places in our lane, half a metre apart."""
    aside = np.arange(-1.0, 1.1, 0.5)
    points = {
        x: [look_at_person(x, y, lambda labels: labels).points for y in aside.tolist()]
        for x in np.arange(3.0, 20.1, 0.5).tolist()
    }
    kept = {x: np.mean(np.array(sizes) >= 30) for x, sizes in points.items()}
    assert np.mean([kept[x] for x in kept if x <= 6]) > 0.95
    assert 0.3 < np.mean([kept[x] for x in kept if 7 <= x <= 13.5]) < 0.5
    assert np.mean([kept[x] for x in kept if x >= 14]) < 0.05
    near = np.concatenate([sizes for x, sizes in points.items() if x < BRAKING_RANGE])
    assert (near.size, near.min()) == (110, 20)


@pytest.mark.proof
@pytest.mark.parametrize(("minimum", "words"), [(20, "9 m ahead"), (30, "at 19 km/h")])
def test_the_car_meets_the_person_as_stated(lesson_run, minimum, words):
    detect = chain(keep=lambda labels: lesson_run.filter_clusters(labels, minimum))
    trip = drive_street(street_with_person(11.0, -0.6), detect, seconds=10, clock=on_time)
    assert words in str(trip)
    assert bool(trip.report.collision) == (minimum == 30) == ("3 m ahead" in str(trip))
