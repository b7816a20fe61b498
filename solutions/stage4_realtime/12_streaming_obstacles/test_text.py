"""Tests of the statements in lesson 12, with answers that follow its hints."""

import functools
import json
import re
import time
from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.path import Path

from grader.course.kept_answers import answers_to
from grader.course.lessons import find_lesson
from utils import load_my_functions, scenes, scoring
from utils.checks.core import checks_of, notes_of, run_check
from utils.checks.detections import _contains_obstacle
from utils.checks.failures import NotYet
from utils.checks.run_cache import cached_run
from utils.checks.scans import square_with_people
from utils.drive import drive_street, on_time
from utils.drive.rules import BUMPER, SCANS_TO_BE_SURE
from utils.drive.standards import DRIVERS, reference_results
from utils.notebooks import slicing
from utils.scoring import counted, holders, name_mistakes
from utils.scoring.card import hidden_shares
from utils.simulator.scanner import CLASSES

pytestmark = pytest.mark.slow  # simulating three seconds of a city is slow

LESSON = find_lesson("12_streaming_obstacles")
TEXT = LESSON.source.read_text("utf-8")
EGO_BOX = ((-1.5, -1.7, -1.0), (2.6, 1.7, -0.4))
LENGTH_AND_WIDTH = slice(None), slice(None, 2)
DETECTORS = """
voxel_grid, thin = mine.voxel_grid, lambda cloud: cloud[::2]

def from_here(cloud):
    return thin(cloud)

def from_a_file(cloud):
    return load_my_functions("06_filter_ground.ipynb").voxel_grid(cloud)

def from_its_functions(cloud):
    return [mine.voxel_grid(one) for one in (cloud,)]

def from_one_of_them(cloud):
    return voxel_grid(cloud)

def from_a_helper(cloud):
    return from_one_of_them(cloud)
"""


@pytest.fixture(scope="module")
def lesson_names():
    """Variables and functions of the solved notebook that these tests need, by name."""
    statements, _ = slicing.parse_notebook([LESSON.text])
    wanted = (
        "detect_obstacles",
        "match_boxes",
        "cardboard_street",
        "occupied_squares",
        "f1_of_kinds",
        "boxes_of_truth",
        "card_of",
        "heading_of",
        "corners_of",
        "sweep",
        "follow",
        "mistakes_of",
        "counts_of",
        "confirm",
        "show_ghost",
        "boxes_of_colleagues",
        "gain_curve",
        "wobble_of",
        "gain_for",
        "detected",
        "bonnet",
        "lost",
    )
    namespace = {"__name__": LESSON.name}
    for statement in slicing.slice_for(wanted, statements):
        exec(slicing.compile_statement(statement, LESSON.source.name), namespace)
    return namespace


@pytest.fixture(scope="module")
def tracked_objects(lesson_names):
    return [
        holders(boxes, frame.cloud[::3], frame.scan.objects[::3])
        for boxes, frame in zip(lesson_names["detected"], lesson_names["city"], strict=True)
    ]


def run_steps(lesson_names, cloud, *without):
    """Run the steps in the hints, except `without`, and return the thinned points and the boxes."""

    def step(name, points, *arguments):
        return points if name in without else lesson_names[name](points, *arguments)

    points = step("drop_invalid", cloud[:, :3])
    points = step("crop_region", points, (-15.0, -7.0, -3.0), (35.0, 9.0, 1.0))
    points = step("remove_ego_returns", points, *EGO_BOX)
    if "ransac_plane" not in without:
        low = points[points[:, 2] < -1.2]
        plane = lesson_names["fit_plane"](low[lesson_names["ransac_plane"](low, 50, 0.2, 0)[1]])
        points = points[lesson_names["point_plane_distance"](points, plane) > 0.3]
    points = step("voxel_grid", points, 0.2)
    labels = lesson_names["euclidean_clustering_accelerated"](points, 0.5)
    return points, lesson_names["get_oriented_boxes"](points, step("filter_clusters", labels, 10))


def ego_car_boxes(boxes):
    middles = boxes.mean(axis=1)[:, :2]
    return ((middles > (-1.5, -1.7)) & (middles < (2.6, 1.7))).all(axis=1).sum()


def misalignment(box, car):
    """Return the angle (degrees, at most 45) between the sides of a box and of a car."""
    side = box[1, :2] - box[0, :2]
    angle = np.degrees(np.arctan2(side[1], side[0]) - car.yaw)
    return abs((angle + 45) % 90 - 45)


def test_naive_squares_cover_road_and_the_ego_car(lesson_names):
    first = lesson_names["city"][0]
    middles = lesson_names["occupied_squares"](first.cloud).mean(axis=1)[:, :2]
    assert len(middles) > 3 * len(first.boxes)
    assert (np.abs(middles - (0, 0)) < 1.7).all(axis=1).any()
    ringed = middles[np.hypot(*(middles - (29, 1.2)).T) < 2.1]
    assert len(ringed) >= 3
    square_of = np.floor(first.cloud[:, :2]) + 0.5
    for middle in ringed:
        held = (square_of == middle).all(axis=1) & (first.cloud[:, 2] > -1.2)
        assert not first.scan.objects[held].any()  # this square contains only road


def test_no_box_is_on_empty_road(lesson_names):
    for number in (0, 4, 8):
        frame = lesson_names["city"][number]
        assert all(_contains_obstacle(box, frame) for box in lesson_names["detected"][number])


def test_a_fixed_level_leaves_road_on_a_climbing_street(lesson_names):
    frame, found = lesson_names["city"][4], []
    for steps in ("plane", "level"):
        cloud = lesson_names["crop_region"](
            frame.cloud[:, :3], (-15.0, -7.0, -3.0), (35.0, 9.0, 1.0)
        )
        if steps == "level":
            cloud = cloud[cloud[:, 2] >= -1.2]
            points = lesson_names["voxel_grid"](cloud, 0.2)
            labels = lesson_names["euclidean_clustering_accelerated"](points, 0.5)
            boxes = lesson_names["get_oriented_boxes"](
                points, lesson_names["filter_clusters"](labels, 10)
            )
        else:
            boxes = lesson_names["detected"][4]
        ghosts = np.array(
            [box.mean(axis=0)[0] for box in boxes if not _contains_obstacle(box, frame)]
        )
        found.append(ghosts)
    assert len(found[0]) == 0 and len(found[1]) > 0
    assert found[1].min() > 15  # in a region that ends at 15 m, there would be none


def test_boxes_are_aligned_with_cars_within_15_m(lesson_names):
    crooked = []
    for number in (0, 4, 8):
        frame, boxes = lesson_names["city"][number], lesson_names["detected"][number]
        for car in frame.boxes:
            if car.kind != "car" or car.returns < 30 or np.hypot(*car.centre[:2]) > 15:
                continue
            overlaps = scoring.plane_iou(boxes, car.corners[None])[:, 0]
            if overlaps.max(initial=0) >= 0.5:
                crooked.append(misalignment(boxes[overlaps.argmax()], car))
    assert len(crooked) >= 12
    assert np.median(crooked) < 2 and np.mean(np.array(crooked) < 10) > 0.9


def test_each_step_has_the_stated_effect(lesson_names):
    cloud = lesson_names["city"][0].cloud
    points, boxes = run_steps(lesson_names, cloud)
    thick, _ = run_steps(lesson_names, cloud, "voxel_grid")
    with_road, slabs = run_steps(lesson_names, cloud, "ransac_plane", "voxel_grid")
    assert 110_000 < len(cloud) < 118_000 and 2_000 < len(points) < 4_000
    assert len(points) < 0.1 * len(thick)
    assert 0.45 < (len(with_road) - len(thick)) / len(with_road) < 0.55  # "half of what is left"
    assert len(run_steps(lesson_names, cloud, "filter_clusters")[1]) > 1.7 * len(boxes)
    assert len(run_steps(lesson_names, cloud, "crop_region")[1]) > 3 * len(boxes)
    sides = np.ptp(run_steps(lesson_names, cloud, "ransac_plane")[1], axis=1)[LENGTH_AND_WIDTH]
    assert sides.max() > 20  # with the road, everything near the car is one cluster
    assert np.ptp(boxes, axis=1)[LENGTH_AND_WIDTH].max() < 12


def test_a_voxel_grid_that_sorts_rows_takes_longer_than_ransac(lesson_names):
    thick, _ = run_steps(lesson_names, lesson_names["city"][0].cloud, "voxel_grid")
    whole, _ = run_steps(lesson_names, lesson_names["city"][0].cloud, "voxel_grid", "ransac_plane")
    low = whole[whole[:, 2] < -1.2]

    def seconds(work):
        times = []
        for _ in range(5):
            start = time.process_time()
            work()
            times.append(time.process_time() - start)
        return min(times)

    def by_rows():
        np.unique(np.floor(thick / 0.2), axis=0, return_inverse=True, return_counts=True)

    by_numbers = functools.partial(lesson_names["voxel_grid"], thick, 0.2)
    search = functools.partial(lesson_names["ransac_plane"], low, 50, 0.2, 0)
    assert seconds(by_rows) > max(seconds(search), 3 * seconds(by_numbers))


def test_a_bad_scan_shows_missing_steps(lesson_names):
    good = lesson_names["city"][0].cloud
    bad = np.vstack([good, lesson_names["bonnet"], lesson_names["lost"]])
    assert len(lesson_names["detect_obstacles"](good)) == len(lesson_names["detect_obstacles"](bad))
    assert np.hypot(*(lesson_names["bonnet"][:, :2] - (1.7, 0)).T).max() < 1.3  # in the ring
    assert ego_car_boxes(run_steps(lesson_names, good, "remove_ego_returns")[1]) == 0
    assert ego_car_boxes(run_steps(lesson_names, bad, "remove_ego_returns")[1]) == 1
    # Without drop_invalid, later steps happen to remove the same returns.
    assert len(run_steps(lesson_names, bad, "drop_invalid")[1]) == len(
        lesson_names["detect_obstacles"](good)
    )
    lost = np.zeros((3000, 3))
    labels = lesson_names["euclidean_clustering_accelerated"](lost, 0.5)
    # Without thinning, the lost returns are a large cluster.
    assert lesson_names["filter_clusters"](labels, 10).all()


def test_half_of_the_returns_fill_nearly_as_many_voxels(lesson_names):
    whole, half = (
        len(run_steps(lesson_names, lesson_names["city"][0].cloud[::step])[0]) for step in (1, 2)
    )
    assert whole < 1.3 * half


def test_a_detector_that_loads_its_functions_gets_a_note():
    notebook = find_lesson("06_filter_ground").solved
    space = {"__name__": "__main__", "load_my_functions": load_my_functions}
    exec(f"mine = load_my_functions({str(notebook)!r})\n{DETECTORS}", space)
    note = next(
        candidate
        for candidate in notes_of("detect_obstacles")
        if candidate.name == "uses_this_notebook_only"
    )
    failures = {name: run_check(note, space[name]).failure for name in space if name[:4] == "from"}
    assert failures.pop("from_here") is None
    assert len(failures) == 4
    for failure in failures.values():
        assert "comes from another notebook" in failure.message


def test_a_cardboard_car_gets_one_box(lesson_names):
    toy = lesson_names["cardboard_street"]()
    boxes = lesson_names["detect_obstacles"](toy)
    assert len(boxes) == 1
    drawn = toy[toy[:, 2] > -1.7, :2]
    distances = np.hypot(*(drawn[drawn.any(axis=1)] - (8, 2)).T)
    assert len(drawn) > 1000 and (distances > 0.8).all() and (distances < 2.3).all()  # no road
    sides = sorted(np.linalg.norm(boxes[0][[1, 2]] - boxes[0][[0, 1]], axis=1))
    assert np.allclose(sides, (1.8, 4.0), atol=0.15)


def test_principal_axes_make_the_curve_fall(lesson_names):
    f1 = lesson_names["f1_of_kinds"](
        lesson_names["streams"]["streets"], lesson_names["carriageway"]
    )
    fall = {kind: values[0] - values[2] for kind, (values, _) in f1.items()}
    assert fall["principal axes"] > 0.5
    assert max(fall["along the axes"], fall["smallest rectangle"]) < 0.25


def test_statements_about_the_score_card_are_true(lesson_names):
    card = lesson_names["card_of"]("streets")
    assert card["recall in plain view"].texts[0] == "0.84 ± 0.03"
    assert card["recall, partly hidden"].texts[0] == "0.92 ± 0.05"
    for nearer, farther in (
        ("recall to 10 m", "recall beyond 20 m"),
        ("recall in plain view", "recall, half hidden or more"),
    ):
        apart = np.subtract(card[nearer].values, card[farther].values)
        assert (apart > 2.5 * np.hypot(card[nearer].errors, card[farther].errors)).all()


def f1_with_error(lesson_names, frames, region, *kinds):
    """Return F1 with its standard error at each overlap, for boxes around true clusters.

    For two kinds of boxes, return the difference in F1.
    """
    said = []
    for overlap in scoring.OVERLAPS:
        parts = []
        for frame in frames:
            truth, part = lesson_names["corners_of"](counted(frame, region)), []
            for kind in kinds:
                boxes = lesson_names["boxes_of_truth"](frame, region, kind)
                hits = scoring.score_boxes(boxes, truth, overlap).true_positives
                part += [2 * hits, len(boxes) + len(truth)]
            parts.append(part)
        said.append(
            scoring.with_error(
                parts,
                lambda sums: sums[0] / sums[1] - (sums[2] / sums[3] if len(sums) > 2 else 0),
            )
        )
    return np.array(said)


@pytest.mark.proof
def test_boxes_along_the_axes_are_better_on_streets_and_worse_on_squares(lesson_names):
    streets = [scenes.city_block(seed, frames=1)[0] for seed in range(24)]
    ways = "along the axes", "smallest rectangle"
    better = f1_with_error(lesson_names, streets, lesson_names["carriageway"], *ways)
    assert np.array_equal(np.round(better, 2), [(0.02, 0.01)] * 3)
    squares = [scenes.cyclist(seed, frames=1)[0] for seed in range(8)]
    around = ((-15, 35), (-20, 20))
    for kind, expected in ((ways[1], (0.93, 0.03)), (ways[0], (0.39, 0.03))):
        said = f1_with_error(lesson_names, squares, around, kind)[1]
        assert np.allclose(said, expected, atol=0.0051)


def test_distant_rectangles_may_have_wrong_headings(lesson_names):
    off = {True: [], False: []}  # key: whether the object is within 15 m
    for frame in lesson_names["streams"]["streets"]:
        for thing in counted(frame, lesson_names["carriageway"]):
            points = frame.cloud[frame.scan.objects == thing.identity, :3]
            points = points[points[:, 2] > points[:, 2].min() + 0.3]
            if len(points) >= 5:
                yaw = np.degrees(
                    lesson_names["heading_of"](points[:, :2], "smallest rectangle") - thing.yaw
                )
                off[np.hypot(*thing.centre[:2]) < 15].append(abs((yaw + 45) % 90 - 45))
    assert np.quantile(off[True], 0.9) < 3 and np.quantile(off[False], 0.9) > 8


def test_statements_about_the_two_sweeps_are_true(lesson_names):
    precision, recall, f1 = lesson_names["sweep"]("threshold", [0.2, 0.5, 1.0])
    assert precision[0, 0] < precision[0, 1] and recall[0, 0] < recall[0, 1] > recall[0, 2]
    assert f1[0].argmax() == 1
    precision, recall, f1 = lesson_names["sweep"]("min_num_points", [2, 10, 80])
    assert (np.diff(precision[0]) > 0).all() and recall[0, 2] < recall[0, 1]
    assert f1[0].argmax() == 2  # although a pedestrian has fewer points


def count_voxels_of_people(frame, nearest, farthest):
    """Count the occupied voxels of people in full view, without the functions of the lessons."""
    people = [box for box in frame.boxes if box.kind == "pedestrian" and box.returns >= 5]
    counts = []
    for person, hidden in zip(people, hidden_shares(frame, people), strict=True):
        if hidden < 0.1 and nearest < np.hypot(*person.centre[:2]) < farthest:
            own = frame.cloud[frame.scan.objects == person.identity, :3]
            own = own[own[:, 2] > person.centre[2] - person.size[2] / 2 + 0.3]
            counts.append(len(np.unique(np.floor(own / 0.2), axis=0)))
    return counts


def test_statements_about_people_in_full_view_are_true():
    frames = [frame for seed in range(8) for frame in scenes.city_block(seed, frames=30)[::10]]
    near = [
        count_voxels_of_people(frame, 0, 7)
        for frame in [*frames, *map(square_with_people, range(12))]
    ]
    near, ten_metres = (
        sum(near, []),
        sum((count_voxels_of_people(frame, 9, 11) for frame in frames), []),
    )
    assert len(near) > 30 and len(ten_metres) >= 10
    assert min(near) >= 25 and np.quantile(near, 0.95) <= 50
    assert np.median(ten_metres) == pytest.approx(35, abs=1)
    assert np.mean(np.array(ten_metres) < 40) > 0.6  # "removes most pedestrians 10 m away"
    assert max(ten_metres) < 80  # the best minimum of the sweep would remove them all


def test_ransac_needs_fewer_rounds_below_the_ground_level():
    """The rounds follow from the share of points on the road, as in lesson 02."""
    frame = scenes.city_block(frames=1)[0]
    points, classes = frame.cloud[:, :3], frame.scan.classes
    road = points[(classes == CLASSES.index("ground")) & (abs(points[:, 1]) < 3)]
    coefficients = np.linalg.lstsq(np.insert(road[:, :2], 2, 1, axis=1), road[:, 2])[0]
    is_near = abs(np.insert(points[:, :2], 2, 1, axis=1) @ coefficients - points[:, 2]) <= 0.2
    lowest, highest = (-15, -7, -3), (35, 9, 1)
    in_region = ((points >= lowest) & (points <= highest)).all(axis=1)
    rounds = []
    for kept in (in_region & (points[:, 2] < -1.2), in_region):
        share = is_near[kept].mean()
        rounds.append(np.log(0.001) / np.log(1 - share**3))
    assert round(100 * is_near[in_region & (points[:, 2] < -1.2)].mean()) == 85
    assert round(100 * is_near[in_region].mean(), 1) == 48.4
    assert np.ceil(rounds).tolist() == [8, 58]
    stated = np.array([0.85, 0.484])  # a reader gets the same rounds from the stated shares
    assert np.ceil(np.log(0.001) / np.log(1 - stated**3)).tolist() == [8, 58]


def test_the_road_reaches_the_ground_level_24_m_ahead():
    assert scenes.ROAD.slope == 0.022
    assert (1.73 - 1.2) / scenes.ROAD.slope == pytest.approx(24, abs=0.2)


def test_each_step_of_the_tracker_has_the_stated_effect(lesson_names, tracked_objects):
    """Compare the switches after each step, at the distance in the lesson's table and at others."""
    made = {
        use: {
            limit: lesson_names["mistakes_of"](limit, use)
            for limit in (0.3, 0.5, 0.7, 1.0, 1.5, 10.0)
        }
        for use in ((), ("predict",), ("predict", "correct"), lesson_names["ALL"])
    }
    alone, predicted, corrected, coasting = made.values()
    # If the distance is shorter than the ego car's motion per frame, matching alone loses parked
    # cars, but prediction keeps them.
    assert alone[0.3].switches > 200 > 3 * predicted[0.5].switches / 2
    assert alone[0.3].switches > 2 * predicted[0.3].switches
    assert predicted[1.0].switches < 0.7 * alone[1.0].switches
    assert abs(corrected[1.0].switches - predicted[1.0].switches) <= 5
    assert coasting[1.0].switches < 0.7 * corrected[1.0].switches
    for way in made.values():
        assert way[10.0].shared > 1.5 * way[1.0].shared > 0
        assert way[0.3].switches > 2 * way[1.5].switches


def test_statements_about_confirmed_tracks_are_true(lesson_names, tracked_objects):
    counts_of, everything = lesson_names["counts_of"], lesson_names["ALL"]
    assert counts_of(1) == (84, 54, 0) and counts_of(3) == (84 - 25, 54 - 3, 2)
    plain, _, _ = lesson_names["follow"](lesson_names["detected"], 1.0)
    track_ids, _, confirmed = lesson_names["follow"](
        lesson_names["detected"], 1.0, use=(*everything, "confirm")
    )
    assert all(map(np.array_equal, plain, track_ids))  # "It does not change any ID"
    assert all(thing for things in tracked_objects for thing in things)
    assert lesson_names["mistakes_of"](1.0, everything).switches > 0
    boxes_of_track, appears, parts = Counter(np.concatenate(track_ids)), {}, set()
    for number, (things, names) in enumerate(zip(tracked_objects, track_ids, strict=True)):
        for thing, track in zip(things.tolist(), names.tolist(), strict=True):
            appears.setdefault(thing, number)
            if boxes_of_track[track] < 3 and np.count_nonzero(things == thing) > 1:
                parts.add(track)
    assert len(parts) >= 8  # "parts of others had a box of their own for a frame or two"
    kinds = {box.identity: box.kind for frame in lesson_names["city"] for box in frame.boxes}
    counting = np.concatenate(tracked_objects)[np.concatenate(confirmed)]
    lost = {thing: number for thing, number in appears.items() if thing not in counting}
    late = [kinds[thing] for thing, number in lost.items() if number >= 27]
    assert len(lost) == 3 and late == ["car", "car"]
    assert SCANS_TO_BE_SURE == 3


def test_a_ghost_has_a_track_for_four_frames_but_it_is_never_confirmed(lesson_names, monkeypatch):
    tables = []
    monkeypatch.setitem(lesson_names, "show_table", lambda columns, rows: tables.append(rows))
    lesson_names["show_ghost"]()
    lesson_names["show_ghost"](confirm=lesson_names["confirm"])
    counts = [[row[2] for row in rows] for rows in tables]
    assert counts == [[0, 1, 1, 1, 1, 0], [0] * 6]


@pytest.fixture(scope="module")
def drives(lesson_names):
    """Three seconds of eight streets: boxes, the object in each box, and the true boxes."""
    made = []
    for seed in range(8):
        boxes, tracked_objects, truth = [], [], []
        for frame in scenes.city_block(seed, frames=30):
            boxes.append(lesson_names["detect_obstacles"](frame.cloud))
            tracked_objects.append(holders(boxes[-1], frame.cloud[::3], frame.scan.objects[::3]))
            truth.append(SimpleNamespace(boxes=frame.boxes))
        made.append((boxes, tracked_objects, truth))
    return made


def run_on_eight_streets(drives, lesson_names, name, *arguments):
    """Run an experiment of the lesson on each of the eight streets, and return the results."""
    kept = {key: lesson_names[key] for key in ("detected", "things", "city")}
    answers = []
    try:
        for detected, tracked_objects, truth in drives:
            lesson_names.update(detected=detected, things=tracked_objects, city=truth)
            answers.append(lesson_names[name](*arguments))
    finally:
        lesson_names.update(kept)
    return answers


@pytest.mark.proof
def test_statements_about_switches_on_eight_streets_are_true(lesson_names, drives):
    said = {(): (76, 29), ("predict",): (38, 11), ("predict", "correct"): (38, 11)}
    counts = {}
    for use, expected in {**said, lesson_names["ALL"]: (18, 8)}.items():
        made = run_on_eight_streets(drives, lesson_names, "mistakes_of", 1.0, use)
        counts[use] = np.array([mistakes.switches for mistakes in made])
        assert (round(counts[use].mean()), round(counts[use].std(ddof=1))) == expected
        shared = np.array([mistakes.shared for mistakes in made])
        assert round(shared.mean()) in (2, 3) and round(shared.std(ddof=1)) == 2
    alone, predicted, _, coasting = counts.values()
    assert (alone > predicted).all() and (predicted > coasting).all()


@pytest.mark.proof
def test_statements_about_gains_on_eight_streets_are_true(lesson_names, drives):
    gains = [0.3, 0.5, 0.7]
    curves = np.array(run_on_eight_streets(drives, lesson_names, "gain_curve", gains))
    for place, (switches, spread, error) in enumerate(
        [(38, 14, 0.06), (18, 8, 0.08), (16, 7, 0.15)]
    ):
        assert round(curves[:, 0, place].mean()) == switches
        assert round(curves[:, 0, place].std(ddof=1)) == spread
        assert curves[:, 1, place].mean() == pytest.approx(error, abs=0.0051)
        assert 0.005 < curves[:, 1, place].std(ddof=1) < 0.025
    wobbles = run_on_eight_streets(drives, lesson_names, "wobble_of", 1.0)
    assert all(0.44 < lesson_names["gain_for"](wobble, 2.0) < 0.56 for wobble in wobbles)


def test_statements_about_wobble_and_gain_are_true(lesson_names, tracked_objects):
    assert 0.05 < lesson_names["wobble_of"](1.0) < 0.1
    bends, (track_ids, *_) = [], lesson_names["follow"](lesson_names["detected"], 1.0)
    for number in range(2, len(track_ids)):
        first, second, third = (
            dict(zip(track_ids[frame], lesson_names["detected"][frame].mean(axis=1), strict=True))
            for frame in (number - 2, number - 1, number)
        )
        bends += [
            np.hypot(*(first[track] - 2 * second[track] + third[track])[:2])
            for track in first.keys() & second.keys() & third.keys()
        ]
    assert 0.01 < np.median(bends) / np.sqrt(6) < 0.03  # "half of the boxes"
    assert max(bends) > 1  # "now and then, a box grows by a metre"
    switches, error = lesson_names["gain_curve"]([0.1, 0.5, 0.9])
    assert switches[0] > 2 * switches[1]
    assert error[1] <= 0.1 and error[2] == pytest.approx(0.3, abs=0.05)


def test_most_boxes_move_half_a_metre_per_frame(lesson_names):
    """The ego car moves, so even parked objects move relative to it."""
    way = [
        np.linalg.norm(after.mean(axis=1)[:, None] - before.mean(axis=1)[None], axis=2).min(axis=1)
        for before, after in zip(
            lesson_names["detected"], lesson_names["detected"][1:], strict=False
        )
    ]
    assert 0.4 < np.median(np.concatenate(way)) < 0.7
    assert np.mean([len(boxes) for boxes in lesson_names["detected"]]) == pytest.approx(30, abs=2)


def test_oncoming_cars_come_one_metre_nearer_per_frame(lesson_names):
    speeds = {
        box.velocity[0] for box in lesson_names["city"][0].boxes if box.kind in ("car", "truck")
    }
    assert 0.1 * (5.0 - min(speeds)) == pytest.approx(1, abs=0.05)


def test_the_ringed_box_holds_two_objects_that_had_boxes_before(lesson_names):
    boxes_of = {}
    for number in (26, 29):
        frame, boxes = lesson_names["city"][number], lesson_names["detected"][number]
        holding = {}
        for identity in {box.identity for box in frame.boxes if box.kind in ("car", "truck")}:
            points = frame.cloud[frame.scan.objects == identity, :2]
            if len(points) >= 1000:
                inside = [Path(box[:4, :2]).contains_points(points).mean() for box in boxes]
                holding[identity] = int(np.argmax(inside)) if max(inside) > 0.5 else -1
        boxes_of[number] = holding
    last = lesson_names["detected"][29].mean(axis=1)[:, :2]
    ringed = int(np.argmin(np.hypot(*(last - (-2.8, 4.1)).T)))
    held = [identity for identity, box in boxes_of[29].items() if box == ringed]
    kinds = {box.identity: box.kind for box in lesson_names["city"][29].boxes}
    assert sorted(kinds[identity] for identity in held) == ["car", "truck"]
    assert len({boxes_of[26][identity] for identity in held} - {-1}) == 2


def test_at_no_distance_are_both_mistakes_zero(lesson_names, tracked_objects):
    (limits,) = re.findall(r"^limits = (\[.*\])$", TEXT, re.M)
    assert len(json.loads(limits)) == 10 and "The next figure compares ten distances" in TEXT
    for use in ((), ("predict",), ("predict", "correct"), lesson_names["ALL"]):
        made = [lesson_names["mistakes_of"](limit, use) for limit in (0.2, 0.5, 1.0, 2.0, 10.0)]
        assert all(mistakes.switches + mistakes.shared > 10 for mistakes in made)


@pytest.mark.proof
def test_a_minimum_of_100_points_makes_the_car_hit_the_cyclist(lesson_names):
    """Drive as the cell of the lesson does; the detector's computing time does not count."""
    collisions = []
    for least in (10, 45, 50, 100):
        detect = functools.partial(lesson_names["detect_obstacles"], min_num_points=least)
        trip = drive_street(3, detect, seconds=10, clock=on_time)
        collisions.append(str(trip.report.collision or ""))
    assert collisions[:2] == ["", ""] and "a cyclist at 17 km/h" in collisions[2]
    assert "for the first time 1.2 s before" in collisions[2]
    assert "cyclist" in collisions[3] and "never had a box" in collisions[3]


def test_three_wrong_detectors_lose_what_the_answer_says(lesson_names):
    frame = lesson_names["city"][16]
    boxes = lesson_names["boxes_of_colleagues"](lesson_names["detect_obstacles"], frame.cloud)
    places = {name: found.mean(axis=1)[:, :2] for name, found in boxes.items()}
    (lorry,) = (box for box in frame.boxes if box.kind == "truck" and abs(box.centre[0]) < 15)
    assert lorry.velocity[0] < 0
    shared = {
        name: scoring.plane_iou(found, lorry.corners[None])[:, 0] for name, found in boxes.items()
    }
    assert shared["yours"].max() > 0.7 and shared["C"].max() == 0
    assert np.count_nonzero(shared["A"]) == 2 and shared["A"].max() < 0.2
    assert BUMPER + 1 < 4  # a child 1 m ahead of the bumper is in the hole of A
    far = boxes["yours"][shared["yours"].argmax(), :, 1].max()
    near = boxes["B"][shared["B"].argmax(), :, 1].max()
    assert far - near == pytest.approx(0.5, abs=0.15)
    on_the_left = {name: np.count_nonzero(of[:, 1] > 3.5) for name, of in places.items()}
    assert on_the_left["yours"] > 3 and on_the_left["B"] == 0
    ahead = {
        name: ((of > (4, -4)) & (of < (20, -1))).all(axis=1).sum() for name, of in places.items()
    }
    assert set(ahead.values()) == {2}  # "All three find the parked cars ahead"


def test_match_boxes_solves_the_tiny_case(lesson_names):
    box = np.zeros((8, 3))
    before = box + np.array([[0.0, 0, 0], [10, 0, 0]])[:, None]
    after = box + np.array([[0.8, 0, 0], [0.3, 0, 0], [9.6, 0, 0]])[:, None]
    assert lesson_names["match_boxes"](before, after, 1.0).tolist() == [-1, 0, 1]


def test_three_rules_for_matching_are_right_and_differ():
    """The second box is nearest to a box that is closer to the first, so it may stay alone."""
    before, after = (np.zeros((2, 8, 3)) for _ in range(2))
    before[:, :, 0], after[:, :, 0] = [[0.0], [1.2]], [[0.1], [0.5]]
    answers = {}
    for answer in answers_to("match_boxes"):
        if answer.right and not answer.name.startswith("each previous box"):
            exec(answer.source, space := {"np": np})
            answers[answer.name] = np.asarray(space["match_boxes"](before, after, 1.0)).tolist()
    assert answers["the closest pair first"] == answers["optimal assignment"] == [0, 1]
    assert answers["mutual nearest boxes"] == [0, -1]
    # Pairing the closest boxes first leaves one box alone; the smallest sum pairs both boxes.
    after[:, :, 0] = [[0.7], [1.8]]
    for answer in answers_to("match_boxes"):
        if answer.name in ("the closest pair first", "optimal assignment"):
            exec(answer.source, space := {"np": np})
            answers[answer.name] = np.asarray(space["match_boxes"](before, after, 1.0)).tolist()
    assert answers["the closest pair first"] == [1, -1]
    assert answers["optimal assignment"] == [0, 1]


def test_the_highway_needs_other_settings(lesson_names):
    frame = scenes.highway(frames=1)[0]
    true = lesson_names["corners_of"](frame.boxes)
    settings = {"threshold": 2.0, "min_num_points": 3, "ground_level": -2.1}
    assert sorted(box.returns for box in frame.boxes) == [6, 12, 35]
    for more, count, hits in (({}, 1, 0), (settings, 3, 1)):
        boxes = lesson_names["detect_obstacles"](frame.cloud, **more)
        assert len(boxes) == count
        assert scoring.score_boxes(boxes, true, 0.5).true_positives == hits
        assert scoring.score_boxes(boxes, true, 0.05).true_positives == 1


def test_the_model_answer_has_the_stated_scores_on_the_second_data_set(lesson_names):
    around, wide = ((-15, 35), (-20, 20)), {"minimum": (-15, -18.5, -3), "maximum": (35, 18.5, 1)}
    for settings, expected in (
        ({}, (1.00, 0.50, 0.67)),
        (wide, (0.64, 1.00, 0.78)),
        (wide | {"min_num_points": 40}, (1.00, 1.00, 1.00)),
        (wide | {"min_num_points": 40, "threshold": 0.8}, (1.00, 1.00, 1.00)),
        (wide | {"min_num_points": 40, "threshold": 1.0}, (1.00, 1.00, 1.00)),
    ):
        card = lesson_names["card_of"]("cyclist", around, **settings)
        said = [card[row].values[0] for row in ("precision", "recall", "F1")]
        assert np.allclose(said, expected, atol=0.006) and card["recall"].count == 16
        if settings == wide | {"min_num_points": 40}:
            assert card["recall"].values[2] == 9 / 16  # "seven of the sixteen are missed"


def test_the_cyclist_keeps_one_track_id(lesson_names):
    settings = {"minimum": (-15, -18.5, -3), "maximum": (35, 18.5, 1), "min_num_points": 40}
    frames = list(lesson_names["cyclist"])
    boxes = [lesson_names["detect_obstacles"](frame.cloud, **settings) for frame in frames]
    names, *_ = lesson_names["follow"](boxes, 1.2, speed=4.5)
    rider = next(box.identity for box in frames[0].boxes if box.kind == "cyclist")
    found = [
        set(mine[holders(of_frame, frame.cloud, frame.scan.objects) == rider].tolist())
        for of_frame, frame, mine in zip(boxes, frames, names, strict=True)
    ]
    assert len(set.union(*found)) == 1 and all(found)


# ---- mistakes of a tracker -----------------------------------------------------------------------


def arrays_of(*frames):
    return [np.array(frame) for frame in frames]


def test_switches_and_shared_track_ids_are_counted():
    tracked_objects = arrays_of([1, 2, 0], [2, 1], [1], [2, 3])
    assert name_mistakes(tracked_objects, arrays_of([7, 8, 9], [8, 7], [7], [8, 9])).switches == 0
    assert name_mistakes(tracked_objects, arrays_of([7, 8, 9], [8, 7], [7], [8, 9])).shared == 0
    swapped = name_mistakes(tracked_objects, arrays_of([7, 8, 9], [7, 8], [8], [7, 9]))
    assert (swapped.switches, swapped.shared) == (2, 2)
    passed_on = name_mistakes(tracked_objects, arrays_of([7, 8, 9], [8, 7], [7], [8, 7]))
    assert (passed_on.switches, passed_on.shared) == (0, 1)
    new = name_mistakes(tracked_objects, arrays_of([1, 2, 3], [4, 5], [6], [7, 8]))
    assert (new.switches, new.shared) == (4, 0)


def test_an_object_in_two_boxes_may_have_two_track_ids():
    tracked_objects = arrays_of([1, 1], [1], [1, 1])
    assert name_mistakes(tracked_objects, arrays_of([1, 2], [2], [2, 3])).switches == 0


def test_boxes_belong_to_the_object_with_most_points():
    box = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (0, 1))], float)
    cloud = np.array([[0.5, 0.5, 0], [1.5, 0.5, 0], [1.0, 0.9, 0], [1, 0.2, 0], [9, 9, 0.0]])
    objects = np.array([4, 4, 6, 0, 6])
    assert holders(np.stack([box, box + 8, box + 50]), cloud, objects).tolist() == [4, 6, 0]
    assert holders(np.empty((0, 8, 3)), cloud, objects).tolist() == []


def test_stored_answers_are_listed_and_sittings_are_marked():
    header = LESSON.header
    assert all(f"def {name}(" in TEXT for name in header.lent)
    cells = json.loads(LESSON.released.read_text("utf-8"))["cells"]
    stops = sum("**A good place to stop.**" in "".join(cell["source"]) for cell in cells)
    assert stops == 3
    rows = re.findall(
        r"<td>[^<]*read by a person\)</td><td>(\d+)</td>", "".join(cells[0]["source"])
    )
    (stated,) = re.findall(r"Each report takes about (\d+) minutes", TEXT)
    assert [int(minutes) for minutes in rows] == pytest.approx([int(stated)] * 2, abs=2)


def test_the_bar_to_beat_is_the_result_of_the_stored_drives():
    results = reference_results(range(1, 21))
    course, squares = (results[name] for name in DRIVERS[1:])
    assert f"with the occupied squares, the car drives {squares.metres:.0f} m in all" in TEXT
    assert f"it drives {course.metres:,.0f} m without a collision, and brakes once" in TEXT
    assert (course.collisions, course.needless) == (0, 1)


def test_no_check_waits_for_a_passed_check():
    (lucky,) = (answer for answer in answers_to("detect_obstacles") if "one round" in answer.name)
    for seed in range(4):  # with some seeds, a single round finds the road
        namespace = {"np": np}
        exec(lucky.source.replace("(low, 1, 0.2, 0)", f"(low, 1, 0.2, {seed})"), namespace)
        with cached_run():
            outcomes = [
                run_check(check, namespace["detect_obstacles"])
                for check in checks_of("detect_obstacles")
            ]
        failed = {outcome.check.name: outcome.failure for outcome in outcomes if outcome.failure}
        waiting = [name for name, failure in failed.items() if isinstance(failure, NotYet)]
        assert bool(waiting) == ("finds_cars" in failed) == (seed < 2), failed
        if waiting:
            assert failed["finds_cars"].hint.startswith("Draw the clusters first.")
