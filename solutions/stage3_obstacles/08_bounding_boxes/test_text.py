"""Tests of the statements in lesson 08, with answers that follow its hints."""

import importlib
import re

import matplotlib.pyplot as plt
import numpy as np
import pytest

from grader.course.lessons import find_lesson
from tests.lesson_texts import FOLLOWS_HINTS, kept_function, run_statements_for, source_of
from utils import load_cloud, plots
from utils.datasets import DATA
from utils.drive import askew, chain, drive_street, on_time
from utils.plots import corners

LOOPS = "corners from three nested loops, as the text suggests"


get_bounding_boxes = kept_function("get_bounding_boxes")

CLOUD = load_cloud("cloud.txt")
TRUTH = np.load(DATA / "cloud_truth.npz")
NEAR = (CLOUD[:, 2] >= -1.2) & (np.hypot(CLOUD[:, 0], CLOUD[:, 1]) < 20)
LABELS = np.where(NEAR, TRUTH["objects"], 0)
PRESENT = [label for label in np.unique(LABELS).tolist() if label > 0]
KINDS = dict(zip(TRUTH["box_identities"].tolist(), TRUTH["box_kinds"].tolist(), strict=True))


@pytest.fixture(scope="module")
def boxes():
    return get_bounding_boxes(CLOUD, LABELS)


def points_of(label, labels=LABELS):
    return CLOUD[labels == label, :3]


def area(box):
    return float(np.prod(np.ptp(box[:, :2], axis=0)))


def shape_of(label):
    row = np.flatnonzero(TRUTH["box_identities"] == label)[0]
    return TRUTH["box_centres"][row], TRUTH["box_sizes"][row], TRUTH["box_yaws"][row]


def test_the_stated_length_matches_the_answer():
    stated = int(
        re.search(r"roughly (\d+) lines", find_lesson("08_bounding_boxes").source.read_text())[1]
    )
    lines = source_of("get_bounding_boxes").replace(",\n", ", ").strip().splitlines()[1:]
    assert len(lines) == stated


def test_clusters_have_hundreds_or_thousands_of_points():
    sizes = np.unique(LABELS[LABELS > 0], return_counts=True)[1]
    assert np.median(sizes) > 100 and sizes.max() > 1000


def distance_from_edges(corner, drawn):
    """Return a corner's distance from the nearest edge of other corners, in drawing widths."""
    distances = []
    for start in range(8):
        for axis in (1, 2, 4):
            end = start | axis
            if end != start and corner not in (start, end):
                along = drawn[end] - drawn[start]
                share = np.clip((drawn[corner] - drawn[start]) @ along / (along @ along), 0, 1)
                distances.append(np.linalg.norm(drawn[corner] - drawn[start] - share * along))
    return min(distances) / np.ptp(drawn, axis=0).max()


@pytest.mark.parametrize("low, high", [((0, 0, 0), (4, 2, 1.5)), ((-2, -1.5, -1.2), (3, 2.5, 0.8))])
def test_corner_numbers_are_not_drawn_on_other_edges(low, high):
    drawn = corners._project_obliquely(
        get_bounding_boxes(np.array([low, high]), np.ones(2, dtype=int))[0]
    )
    assert min(distance_from_edges(corner, drawn) for corner in range(8)) > 0.1


def test_the_box_of_seven_points_is_right():
    seven = np.array(
        [
            [0.5, 0.2, -0.1],
            [-2.0, 0.4, 0.3],
            [3.0, -0.3, 0.2],
            [0.1, -1.5, -0.4],
            [-0.6, 2.5, 0.1],
            [1.0, 0.7, -1.2],
            [-0.2, -0.5, 0.8],
        ]
    )
    box = get_bounding_boxes(seven, np.ones(7, dtype=int))
    assert box.shape == (1, 8, 3)
    assert box[0, [0, 7]].tolist() == [[-2, -1.5, -1.2], [3, 2.5, 0.8]]


@pytest.mark.parametrize("name", [FOLLOWS_HINTS, LOOPS])
def test_corners_match_the_table(name):
    """Compare the corners with the table in the lesson's text."""
    text = find_lesson("08_bounding_boxes").source.read_text()
    opposite = np.array([[1.0, 2, 3], [4, 5, 6]])
    box = kept_function("get_bounding_boxes", name)(opposite, np.array([1, 1]))[0]
    for axis, letter in enumerate("xyz"):
        row = re.search(rf"^# \| {letter} \|(.+)\|$", text, re.M)[1].replace("*", "").split("|")
        expected = [opposite[int(word.strip() == "max"), axis] for word in row]
        assert box[:, axis].tolist() == expected
    assert (box[4:, :2] == box[:4, :2]).all(), "the roof is directly above the floor"


def test_the_preview_shows_as_many_boxes_as_the_lesson(boxes):
    assert max(PRESENT) > len(PRESENT) == len(boxes)
    figure = importlib.import_module("solutions.stage3_obstacles.08_bounding_boxes.preview").draw()
    legend = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    plt.close(figure)
    assert f"boxes: {len(boxes)}" in legend


def test_boxes_contain_their_clusters(boxes):
    for label, box in zip(PRESENT, boxes, strict=True):
        points = points_of(label)
        assert (points >= box.min(axis=0)).all() and (points <= box.max(axis=0)).all()
        assert not ((box.min(axis=0) <= 0) & (box.max(axis=0) >= 0)).all(), (
            "no box contains the sensor"
        )


def test_the_first_picture_names_only_the_obstacles_with_the_most_points():
    near = run_statements_for("08_bounding_boxes", "street")["street"]
    axes = plots.clusters(CLOUD[LABELS > 0], LABELS[LABELS > 0], names=True, limits=near)
    named = {int(text.get_text()) for text in axes.texts if text.get_text().isdigit()}
    plt.close(axes.figure)
    counts = {label: np.count_nonzero(label == LABELS) for label in PRESENT}
    largest = sorted(PRESENT, key=counts.get)[-len(named) - 3 :]
    assert 5 < len(named) < len(PRESENT) / 2 and named <= set(largest)


def test_the_box_around_label_0_reaches_beyond_all_others_but_not_to_the_frame():
    given = run_statements_for("08_bounding_boxes", "wide")
    with_noise, (across, up) = get_bounding_boxes(CLOUD, LABELS + 1), given["wide"]
    low, high = with_noise[0].min(axis=0), with_noise[0].max(axis=0)
    assert (with_noise[1:].min(axis=(0, 1)) > low).all()
    assert across[0] + 10 < low[0] and high[0] < across[1] - 10
    assert up[0] + 10 < low[1] and high[1] < up[1] - 10


def test_more_circles_than_obstacles_reach_into_the_lane(boxes):
    circles, obstacles = set(), set()
    for label in PRESENT:
        xy = points_of(label)[:, :2]
        middle = xy.mean(axis=0)
        radius = np.linalg.norm(xy - middle, axis=1).max()
        if abs(middle[1]) - radius < 1:
            circles.add(label)
        if (np.abs(xy[:, 1]) < 1).any():
            obstacles.add(label)
    assert obstacles < circles
    assert {"car", "wall"} <= {KINDS[label] for label in circles - obstacles}


def test_the_box_of_the_diagonal_car_is_larger_than_the_car(boxes):
    _, size, yaw = shape_of(10)
    length, width = size[:2]
    cosine, sine = abs(np.cos(yaw)), abs(np.sin(yaw))
    whole = (length * cosine + width * sine) * (length * sine + width * cosine)
    assert 1.3 * length * width < area(boxes[PRESENT.index(10)]) < 0.8 * whole


def test_the_box_of_a_whole_car_is_largest_at_45_degrees():
    _, size, _ = shape_of(10)
    length, width = size[:2]
    angles = np.radians(np.arange(0, 91, 5))
    along = length * np.cos(angles) + width * np.sin(angles)
    aside = length * np.sin(angles) + width * np.cos(angles)
    formula = length * width + (length**2 + width**2) * np.sin(2 * angles) / 2
    assert along * aside == pytest.approx(formula)
    assert (along * aside).argmax() == 9
    assert along[9] == pytest.approx(aside[9])
    assert length * width / formula[9] < 0.5, "more than half of the box is empty"


def test_unseen_parts_of_vehicles_are_outside_their_boxes(boxes):
    across = np.linspace(-0.5, 0.5, 50)
    spots = np.array([(x, y) for x in across for y in across])
    for label in (10, 4, 13):
        centre, size, yaw = shape_of(label)
        turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        footprint = (spots * size[:2]) @ turn.T + centre[:2]
        box = boxes[PRESENT.index(label), :, :2]
        outside = ((footprint < box.min(axis=0)) | (footprint > box.max(axis=0))).any(axis=1)
        assert outside.mean() > 0.15


def test_only_one_vehicle_is_diagonal():
    vehicles = np.isin(TRUTH["box_kinds"], ["car", "truck", "cyclist"])
    vehicles &= np.isin(TRUTH["box_identities"], PRESENT)
    off = np.degrees(TRUTH["box_yaws"][vehicles]) % 90
    off = np.minimum(off, 90 - off)
    assert np.count_nonzero(off >= 10) == 1


def test_boxes_of_parallel_vehicles_hold_little_air():
    vehicles = [label for label in PRESENT if KINDS[label] in ("car", "truck", "cyclist")]
    air = {}
    for label in vehicles:
        _, (length, width, _), yaw = shape_of(label)
        cosine, sine = abs(np.cos(yaw)), abs(np.sin(yaw))
        whole = (length * cosine + width * sine) * (length * sine + width * cosine)
        air[label] = 1 - length * width / whole
    diagonal = air.pop(10)
    assert max(air.values()) < 0.25 and np.median(list(air.values())) < 0.1 < 0.5 < diagonal


def test_only_a_cyclist_and_a_pedestrian_are_in_the_corridor(boxes):
    """The answer in the text is right for the blocks and for the street; the first line is not."""
    names = run_statements_for("08_bounding_boxes", "in_corridor", "corridor", "places", "block")
    corridor, blocks = names["corridor"], np.array(names["block"]) + names["places"][:, None]
    text = find_lesson("08_bounding_boxes").source.read_text()
    size = (corridor[1] - corridor[0]).tolist()
    assert f"a corridor {size[1]:g} m wide and {size[0]:g} m long" in text
    answer = re.search(r"Write `return (\(\(low < corridor.*?)`", text)[1]

    def in_corridor(some_boxes):
        low, high = some_boxes.min(axis=1), some_boxes.max(axis=1)
        return eval(answer, {"low": low, "high": high, "corridor": corridor})

    assert in_corridor(blocks).tolist() == [True, False, False, False]
    found = [KINDS[PRESENT[row]] for row in np.flatnonzero(in_corridor(boxes))]
    assert sorted(found) == ["cyclist", "pedestrian"]
    assert names["in_corridor"](boxes, corridor).sum() > 5 * len(found)


@pytest.mark.proof
@pytest.mark.parametrize("degrees", [0, 4])
def test_the_car_drives_82_m_up_to_four_degrees(degrees):
    detect = askew(chain(boxes=get_bounding_boxes), degrees)
    trip = drive_street(1, detect, seconds=10, clock=on_time)
    assert round(trip.report.metres) == 82 and not trip.report.brakings


def test_boxes_pay_off_after_a_hundred_queries(boxes):
    by_point, by_box = 6 * np.count_nonzero(LABELS), 6 * len(boxes)
    assert by_point + by_box > by_point, "nothing is gained with a single query"
    assert by_point + 100 * by_box < 100 * by_point / 50


def test_elif_is_right_for_most_maxima_and_wrong_mostly_for_heights():
    wrong = []
    for label in PRESENT:
        points = points_of(label)
        for axis in range(3):
            values = points[:, axis]
            # With elif, a new minimum is never compared with the maximum.
            tried = values[1:][values[1:] >= np.minimum.accumulate(values)[:-1]]
            if len(tried) and tried.max() < values.max():
                wrong.append(axis)
    assert 0 < len(wrong) < 3 * len(PRESENT) / 4, "elif is right for most maxima"
    assert wrong.count(2) > len(wrong) / 2, "most wrong maxima are heights"


def test_common_mistakes_look_as_described():
    box = get_bounding_boxes(CLOUD, (LABELS == 0).astype(int))[0]
    assert (box.min(axis=0) < 0).all() and (box.max(axis=0) > 0).all(), (
        "the box contains the ego car"
    )
    assert np.ptp(box[:, 0]) > 100, "the box covers the whole street"
    assert np.array([]).shape == (0,)
    points = points_of(10)
    cube = get_bounding_boxes(np.array([[points.min()] * 3, [points.max()] * 3]), np.array([1, 1]))[
        0
    ]
    assert np.ptp(np.ptp(cube, axis=0)) == 0
    with pytest.raises(ValueError):
        points_of(8).min(axis=0)  # label 8 does not occur
