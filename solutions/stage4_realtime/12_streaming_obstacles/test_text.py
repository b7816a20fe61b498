"""What lesson 12 says in its text, on the path that its hints spell out."""

import json
from types import SimpleNamespace

import nbformat
import numpy as np
import pytest

from grader.course import durations
from grader.course.kept_answers import answers_to
from grader.course.lessons import find_lesson
from utils import load_my_functions, scenes, scoring
from utils.checks.core import checks_of, notes_of, run_check
from utils.checks.detections import _holds_obstacle
from utils.checks.failures import NotYet
from utils.checks.run_cache import one_run
from utils.notebooks import slicing
from utils.scoring import counted, holders, name_mistakes

pytestmark = pytest.mark.slow  # three seconds of a city take some to make

LESSON = find_lesson("12_streaming_obstacles")
OWN_CAR = ((-1.5, -1.7, -1.0), (2.6, 1.7, -0.4))
CAR_STANDS = slice(None), slice(None, 2)
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
def told():
    """The solved notebook's own names, as far as these tests ask for them."""
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
def things(told):
    return [
        holders(boxes, frame.cloud[::3], frame.scan.objects[::3])
        for boxes, frame in zip(told["detected"], told["city"], strict=True)
    ]


def kept(told, cloud, *without):
    """Boxes of the chain of the hints, with the steps of these names left out."""

    def step(name, points, *arguments):
        return points if name in without else told[name](points, *arguments)

    points = step("drop_invalid", cloud[:, :3])
    points = step("crop_region", points, (-15.0, -7.0, -3.0), (35.0, 9.0, 1.0))
    points = step("remove_ego_returns", points, *OWN_CAR)
    if "ransac_plane" not in without:
        low = points[points[:, 2] < -1.2]
        plane = told["fit_plane"](low[told["ransac_plane"](low, 50, 0.2, 0)[1]])
        points = points[told["point_plane_distance"](points, plane) > 0.3]
    points = step("voxel_grid", points, 0.2)
    labels = told["euclidean_clustering_accelerated"](points, 0.5)
    return points, told["get_oriented_boxes"](points, step("filter_clusters", labels, 10))


def own_car_boxes(boxes):
    middles = boxes.mean(axis=1)[:, :2]
    return ((middles > (-1.5, -1.7)) & (middles < (2.6, 1.7))).all(axis=1).sum()


def crookedness(box, car):
    """Degrees between the sides of a box and those of a car; at most 45."""
    side = box[1, :2] - box[0, :2]
    angle = np.degrees(np.arctan2(side[1], side[0]) - car.yaw)
    return abs((angle + 45) % 90 - 45)


def test_naive_squares_are_many_on_road_and_on_the_own_car(told):
    first = told["city"][0]
    middles = told["occupied_squares"](first.cloud).mean(axis=1)[:, :2]
    assert len(middles) > 3 * len(first.boxes)
    assert (np.abs(middles - (0, 0)) < 1.7).all(axis=1).any()
    ringed = middles[np.hypot(*(middles - (29, 1.2)).T) < 2.1]
    assert len(ringed) >= 3
    square_of = np.floor(first.cloud[:, :2]) + 0.5
    for middle in ringed:
        held = (square_of == middle).all(axis=1) & (first.cloud[:, 2] > -1.2)
        assert not first.scan.objects[held].any()  # nothing but road


def test_no_box_is_on_bare_road(told):
    for number in (0, 4, 8):
        frame = told["city"][number]
        assert all(_holds_obstacle(box, frame) for box in told["detected"][number])


def test_a_level_alone_leaves_road_where_the_street_climbs(told):
    frame, found = told["city"][4], []
    for steps in ("plane", "level"):
        cloud = told["crop_region"](frame.cloud[:, :3], (-15.0, -7.0, -3.0), (35.0, 9.0, 1.0))
        if steps == "level":
            cloud = cloud[cloud[:, 2] >= -1.2]
            points = told["voxel_grid"](cloud, 0.2)
            labels = told["euclidean_clustering_accelerated"](points, 0.5)
            boxes = told["get_oriented_boxes"](points, told["filter_clusters"](labels, 10))
        else:
            boxes = told["detected"][4]
        ghosts = np.array([box.mean(axis=0)[0] for box in boxes if not _holds_obstacle(box, frame)])
        found.append(ghosts)
    assert len(found[0]) == 0 and len(found[1]) > 0
    assert found[1].min() > 15  # so a region that ends there is safe


def test_boxes_lie_along_the_cars_within_15_m(told):
    crooked = []
    for number in (0, 4, 8):
        frame, boxes = told["city"][number], told["detected"][number]
        for car in frame.boxes:
            if car.kind != "car" or car.returns < 30 or np.hypot(*car.centre[:2]) > 15:
                continue
            overlaps = scoring.plane_iou(boxes, car.corners[None])[:, 0]
            if overlaps.max(initial=0) >= 0.5:
                crooked.append(crookedness(boxes[overlaps.argmax()], car))
    assert len(crooked) >= 12
    assert np.median(crooked) < 2 and np.mean(np.array(crooked) < 10) > 0.9


def test_what_each_step_takes_away(told):
    cloud = told["city"][0].cloud
    points, boxes = kept(told, cloud)
    thick, _ = kept(told, cloud, "voxel_grid")
    with_road, slabs = kept(told, cloud, "ransac_plane", "voxel_grid")
    assert 110_000 < len(cloud) < 118_000 and 2_000 < len(points) < 4_000
    assert len(points) < 0.1 * len(thick)
    assert 0.45 < (len(with_road) - len(thick)) / len(with_road) < 0.55  # "half of what is left"
    assert len(kept(told, cloud, "filter_clusters")[1]) > 1.7 * len(boxes)
    assert len(kept(told, cloud, "crop_region")[1]) > 3 * len(boxes)
    sides = np.ptp(kept(told, cloud, "ransac_plane")[1], axis=1)[CAR_STANDS]
    assert sides.max() > 20  # all that is near is one cluster
    assert np.ptp(boxes, axis=1)[CAR_STANDS].max() < 12


def test_a_bad_day_shows_whether_the_own_car_and_lost_returns_go(told):
    good = told["city"][0].cloud
    bad = np.vstack([good, told["bonnet"], told["lost"]])
    assert len(told["detect_obstacles"](good)) == len(told["detect_obstacles"](bad))
    assert own_car_boxes(kept(told, good, "remove_ego_returns")[1]) == 0
    assert own_car_boxes(kept(told, bad, "remove_ego_returns")[1]) == 1
    # Later steps happen to catch what drop_invalid would have taken away.
    assert len(kept(told, bad, "drop_invalid")[1]) == len(told["detect_obstacles"](good))
    lost = np.zeros((3000, 3))
    labels = told["euclidean_clustering_accelerated"](lost, 0.5)
    assert told["filter_clusters"](labels, 10).all()  # unthinned they are a large cluster


def test_twice_the_returns_fall_into_much_the_same_voxels(told):
    whole, half = (len(kept(told, told["city"][0].cloud[::step])[0]) for step in (1, 2))
    assert whole < 1.3 * half


def test_a_detector_that_loads_its_functions_gets_a_note():
    notebook = find_lesson("06_filter_ground").solved
    space = {"__name__": "__main__", "load_my_functions": load_my_functions}
    exec(f"mine = load_my_functions({str(notebook)!r})\n{DETECTORS}", space)
    note = next(one for one in notes_of("detect_obstacles") if one.name == "stands_alone")
    told = {name: run_check(note, space[name]).failure for name in space if name[:4] == "from"}
    assert told.pop("from_here") is None
    assert len(told) == 4
    for failure in told.values():
        assert "functions of another notebook" in failure.message


def test_the_car_of_cardboard_has_one_box(told):
    boxes = told["detect_obstacles"](told["cardboard_street"]())
    assert len(boxes) == 1
    sides = sorted(np.linalg.norm(boxes[0][[1, 2]] - boxes[0][[0, 1]], axis=1))
    assert np.allclose(sides, (1.8, 4.0), atol=0.15)


def test_principal_axes_are_what_makes_the_curve_fall(told):
    f1 = told["f1_of_kinds"](told["streams"]["streets"], told["carriageway"])
    fall = {kind: values[0] - values[2] for kind, (values, _) in f1.items()}
    assert fall["principal axes"] > 0.5
    assert max(fall["along the axes"], fall["smallest rectangle"]) < 0.25


def test_what_is_said_of_the_score_card(told):
    card = told["card_of"]("streets")
    assert card["recall in plain view"].texts[0] == "0.84 ± 0.03"
    assert card["recall, partly hidden"].texts[0] == "0.92 ± 0.05"
    for nearer, farther in (
        ("recall to 10 m", "recall beyond 20 m"),
        ("recall in plain view", "recall, half hidden or more"),
    ):
        apart = np.subtract(card[nearer].values, card[farther].values)
        assert (apart > 2.5 * np.hypot(card[nearer].errors, card[farther].errors)).all()


def f1_with_error(told, frames, region, *kinds):
    """F1 of a kind of boxes around true clusters at each overlap; of two, their difference."""
    said = []
    for overlap in scoring.OVERLAPS:
        parts = []
        for frame in frames:
            truth, part = told["corners_of"](counted(frame, region)), []
            for kind in kinds:
                boxes = told["boxes_of_truth"](frame, region, kind)
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
def test_boxes_along_the_axes_are_better_on_streets_and_worse_on_squares(told):
    streets = [scenes.city_block(seed, frames=1)[0] for seed in range(24)]
    ways = "along the axes", "smallest rectangle"
    better = f1_with_error(told, streets, told["carriageway"], *ways)
    assert np.array_equal(np.round(better, 2), [(0.02, 0.01)] * 3)
    squares = [scenes.cyclist(seed, frames=1)[0] for seed in range(8)]
    around = ((-15, 35), (-20, 20))
    for kind, expected in ((ways[1], (0.93, 0.03)), (ways[0], (0.39, 0.03))):
        said = f1_with_error(told, squares, around, kind)[1]
        assert np.allclose(said, expected, atol=0.0051)


def test_far_rectangles_may_be_turned_badly(told):
    off = {True: [], False: []}  # by whether a thing is within 15 m
    for frame in told["streams"]["streets"]:
        for thing in counted(frame, told["carriageway"]):
            points = frame.cloud[frame.scan.objects == thing.identity, :3]
            points = points[points[:, 2] > points[:, 2].min() + 0.3]
            if len(points) >= 5:
                yaw = np.degrees(
                    told["heading_of"](points[:, :2], "smallest rectangle") - thing.yaw
                )
                off[np.hypot(*thing.centre[:2]) < 15].append(abs((yaw + 45) % 90 - 45))
    assert np.quantile(off[True], 0.9) < 3 and np.quantile(off[False], 0.9) > 8


def test_what_the_two_sweeps_say(told):
    precision, recall, f1 = told["sweep"]("threshold", [0.2, 0.5, 1.0])
    assert precision[0, 0] < precision[0, 1] and recall[0, 0] < recall[0, 1] > recall[0, 2]
    assert f1[0].argmax() == 1
    precision, recall, f1 = told["sweep"]("min_num_points", [2, 10, 80])
    assert (np.diff(precision[0]) > 0).all() and recall[0, 2] < recall[0, 1]
    assert f1[0].argmax() == 2  # more points than a pedestrian has


def test_a_person_ten_metres_away_has_about_thirty_points(told):
    counts = []
    for frame in told["city"][:10]:
        for person in frame.boxes:
            away = np.hypot(*person.centre[:2])
            if person.kind == "pedestrian" and 9 < away < 11 and person.returns >= 60:
                own = frame.cloud[frame.scan.objects == person.identity, :3]
                floor = person.centre[2] - person.size[2] / 2
                counts.append(len(told["voxel_grid"](own[own[:, 2] > floor + 0.3])))
    assert 20 <= np.median(counts) <= 40 and max(counts) < 80


def test_what_each_move_brings(told, things):
    """On the stream of the lesson, at the distance of its table and at others."""
    made = {
        use: {limit: told["mistakes_of"](limit, use) for limit in (0.3, 0.5, 0.7, 1.0, 1.5, 10.0)}
        for use in ((), ("predict",), ("predict", "correct"), told["ALL"])
    }
    alone, predicted, corrected, coasting = made.values()
    # Left of our own way matching alone loses what is parked; prediction does not.
    assert alone[0.3].switches > 200 > 3 * predicted[0.5].switches / 2
    assert alone[0.3].switches > 2 * predicted[0.3].switches
    assert predicted[1.0].switches < 0.7 * alone[1.0].switches
    assert abs(corrected[1.0].switches - predicted[1.0].switches) <= 5
    assert coasting[1.0].switches < 0.7 * corrected[1.0].switches
    for way in made.values():
        assert way[10.0].shared > 1.5 * way[1.0].shared > 0
        assert way[0.3].switches > 2 * way[1.5].switches


@pytest.fixture(scope="module")
def drives(told):
    """Three seconds of each of eight streets: boxes, things, and the frames without clouds."""
    made = []
    for seed in range(8):
        boxes, things, truth = [], [], []
        for frame in scenes.city_block(seed, frames=30):
            boxes.append(told["detect_obstacles"](frame.cloud))
            things.append(holders(boxes[-1], frame.cloud[::3], frame.scan.objects[::3]))
            truth.append(SimpleNamespace(boxes=frame.boxes))
        made.append((boxes, things, truth))
    return made


def over(drives, told, name, *arguments):
    """An experiment of the lesson on each of eight streets."""
    kept = {key: told[key] for key in ("detected", "things", "city")}
    answers = []
    try:
        for detected, things, truth in drives:
            told.update(detected=detected, things=things, city=truth)
            answers.append(told[name](*arguments))
    finally:
        told.update(kept)
    return answers


@pytest.mark.proof
def test_what_is_said_of_switches_on_eight_streets(told, drives):
    said = {(): (76, 29), ("predict",): (38, 11), ("predict", "correct"): (38, 11)}
    counts = {}
    for use, expected in {**said, told["ALL"]: (18, 8)}.items():
        made = over(drives, told, "mistakes_of", 1.0, use)
        counts[use] = np.array([one.switches for one in made])
        assert (round(counts[use].mean()), round(counts[use].std(ddof=1))) == expected
        shared = np.array([one.shared for one in made])
        assert round(shared.mean()) in (2, 3) and round(shared.std(ddof=1)) == 2
    alone, predicted, _, coasting = counts.values()
    assert (alone > predicted).all() and (predicted > coasting).all()


@pytest.mark.proof
def test_what_is_said_of_gains_on_eight_streets(told, drives):
    gains = [0.3, 0.5, 0.7]
    curves = np.array(over(drives, told, "gain_curve", gains))
    for place, (switches, spread, error) in enumerate(
        [(38, 14, 0.06), (18, 8, 0.08), (16, 7, 0.15)]
    ):
        assert round(curves[:, 0, place].mean()) == switches
        assert round(curves[:, 0, place].std(ddof=1)) == spread
        assert curves[:, 1, place].mean() == pytest.approx(error, abs=0.0051)
        assert curves[:, 1, place].std(ddof=1) < 0.025
    wobbles = over(drives, told, "wobble_of", 1.0)
    assert all(0.44 < told["gain_for"](wobble, 2.0) < 0.56 for wobble in wobbles)


def test_what_is_said_of_wobble_and_gain(told, things):
    assert 0.05 < told["wobble_of"](1.0) < 0.1
    switches, error = told["gain_curve"]([0.1, 0.5, 0.9])
    assert switches[0] > 2 * switches[1]
    assert error[1] <= 0.1 and error[2] == pytest.approx(0.3, abs=0.05)


def test_more_names_move_half_a_metre_than_stand_still(told):
    """That is us, driving."""
    way = [
        np.linalg.norm(after.mean(axis=1)[:, None] - before.mean(axis=1)[None], axis=2).min(axis=1)
        for before, after in zip(told["detected"], told["detected"][1:], strict=False)
    ]
    assert 0.4 < np.median(np.concatenate(way)) < 0.7


def test_the_tiny_case_of_match_boxes(told):
    box = np.zeros((8, 3))
    before = box + np.array([[0.0, 0, 0], [10, 0, 0]])[:, None]
    after = box + np.array([[0.8, 0, 0], [0.3, 0, 0], [9.6, 0, 0]])[:, None]
    assert told["match_boxes"](before, after, 1.0).tolist() == [-1, 0, 1]


def test_the_highway_needs_settings_of_its_own(told):
    frame = scenes.highway(frames=1)[0]
    true = told["corners_of"](frame.boxes)
    settings = {"threshold": 2.0, "min_num_points": 3, "ground_level": -2.1}
    assert sorted(box.returns for box in frame.boxes) == [6, 12, 35]
    for more, count, hits in (({}, 1, 0), (settings, 3, 1)):
        boxes = told["detect_obstacles"](frame.cloud, **more)
        assert len(boxes) == count
        assert scoring.score_boxes(boxes, true, 0.5).true_positives == hits
        assert scoring.score_boxes(boxes, true, 0.05).true_positives == 1


def test_the_model_answer_on_the_second_data_set(told):
    around, wide = ((-15, 35), (-20, 20)), {"minimum": (-15, -18.5, -3), "maximum": (35, 18.5, 1)}
    for settings, expected in (
        ({}, (1.00, 0.50, 0.67)),
        (wide, (0.64, 1.00, 0.78)),
        (wide | {"min_num_points": 40}, (1.00, 1.00, 1.00)),
        (wide | {"min_num_points": 40, "threshold": 0.8}, (1.00, 1.00, 1.00)),
        (wide | {"min_num_points": 40, "threshold": 1.0}, (1.00, 1.00, 1.00)),
    ):
        card = told["card_of"]("cyclist", around, **settings)
        said = [card[row].values[0] for row in ("precision", "recall", "F1")]
        assert np.allclose(said, expected, atol=0.006) and card["recall"].count == 16


def test_the_cyclist_keeps_one_name(told):
    settings = {"minimum": (-15, -18.5, -3), "maximum": (35, 18.5, 1), "min_num_points": 40}
    frames = list(told["cyclist"])
    boxes = [told["detect_obstacles"](frame.cloud, **settings) for frame in frames]
    names, _ = told["follow"](boxes, 1.2, speed=4.5)
    rider = next(box.identity for box in frames[0].boxes if box.kind == "cyclist")
    found = [
        set(mine[holders(of_frame, frame.cloud, frame.scan.objects) == rider].tolist())
        for of_frame, frame, mine in zip(boxes, frames, names, strict=True)
    ]
    assert len(set.union(*found)) == 1 and all(found)


# ---- the counting itself ------------------------------------------------------------------------


def names_of(*frames):
    return [np.array(frame) for frame in frames]


def test_switches_and_shared_names_are_counted():
    things = names_of([1, 2, 0], [2, 1], [1], [2, 3])
    assert name_mistakes(things, names_of([7, 8, 9], [8, 7], [7], [8, 9])).switches == 0
    assert name_mistakes(things, names_of([7, 8, 9], [8, 7], [7], [8, 9])).shared == 0
    swapped = name_mistakes(things, names_of([7, 8, 9], [7, 8], [8], [7, 9]))
    assert (swapped.switches, swapped.shared) == (2, 2)
    passed_on = name_mistakes(things, names_of([7, 8, 9], [8, 7], [7], [8, 7]))
    assert (passed_on.switches, passed_on.shared) == (0, 1)
    new = name_mistakes(things, names_of([1, 2, 3], [4, 5], [6], [7, 8]))
    assert (new.switches, new.shared) == (4, 0)


def test_a_thing_in_two_boxes_may_have_two_names():
    things = names_of([1, 1], [1], [1, 1])
    assert name_mistakes(things, names_of([1, 2], [2], [2, 3])).switches == 0


def test_boxes_belong_to_what_they_hold_most_of():
    box = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (0, 1))], float)
    cloud = np.array([[0.5, 0.5, 0], [1.5, 0.5, 0], [1.0, 0.9, 0], [1, 0.2, 0], [9, 9, 0.0]])
    objects = np.array([4, 4, 6, 0, 6])
    assert holders(np.stack([box, box + 8, box + 50]), cloud, objects).tolist() == [4, 6, 0]
    assert holders(np.empty((0, 8, 3)), cloud, objects).tolist() == []


def test_the_untouched_notebook_names_what_it_may_borrow():
    header = LESSON.header
    text = LESSON.source.read_text("utf-8")
    assert all(f"def {name}(" in text for name in header.lent)
    cells = json.loads(LESSON.released.read_text("utf-8"))["cells"]
    stops = sum("**A good place to stop.**" in "".join(cell["source"]) for cell in cells)
    assert stops == 3


def test_the_minutes_are_those_of_four_sittings():
    """What the head of the lesson says of them, and that the reports are most of the last."""
    sittings = durations.sittings(nbformat.read(LESSON.solved, as_version=4))
    assert len(sittings) == 4 and max(sittings) < 60
    assert sum(sittings[:3]) < 140 and sittings[3] > 2 * durations.MINUTES_A_REPORT


def test_no_row_waits_for_one_that_is_green():
    (lucky,) = (answer for answer in answers_to("detect_obstacles") if "one round" in answer.name)
    for seed in range(4):  # in some, a road is found at once
        namespace = {"np": np}
        exec(lucky.source.replace("(low, 1, 0.2, 0)", f"(low, 1, 0.2, {seed})"), namespace)
        with one_run():
            outcomes = [
                run_check(check, namespace["detect_obstacles"])
                for check in checks_of("detect_obstacles")
            ]
        failed = {outcome.check.name: outcome.failure for outcome in outcomes if outcome.failure}
        waiting = [name for name, failure in failed.items() if isinstance(failure, NotYet)]
        assert bool(waiting) == ("finds_cars" in failed) == (seed < 2), failed
        if waiting:
            assert failed["finds_cars"].hint.startswith("Draw the clusters before the boxes")
