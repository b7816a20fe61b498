"""In simulated scenes, the truth agrees with the cloud, and a seed always gives the same scene."""

import hashlib
import math
import os
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from shapely.geometry import Polygon

from tests.prerequisites import RECORDINGS
from utils.simulator import CLASSES, Sensor, layers
from utils.simulator.frames import Frame
from utils.simulator.scenes import (
    city_block,
    cyclist,
    highway,
    lesson_street,
    random_street,
    simple_highway,
    write_lesson_cloud,
)

DATA = Path(__file__).parents[1] / "data"
CHEAP = Sensor(layers(16, 2.0, -24.0), math.radians(1.0), weakest_signal=0.05)


@pytest.fixture(scope="module")
def lesson_frame() -> Frame:
    return lesson_street()


def assert_nothing_overlaps(frame):
    # Tree crowns extend over cars, and hedges may touch the houses next to them.
    solid = [box for box in frame.boxes if box.kind != "foliage"]
    for box, other in combinations(solid, 2):
        reach = (math.hypot(*box.size[:2]) + math.hypot(*other.size[:2])) / 2
        if math.dist(box.centre[:2], other.centre[:2]) < reach:
            first, second = (Polygon(b.corners[:4, :2]) for b in (box, other))
            assert first.intersection(second).area < 1e-9, (box, other)


ANY_FRAMES = {
    "highway": lambda: simple_highway(3),
    "highway stream": lambda: highway()[12],
    "lesson": lesson_street,
    "city": lambda: city_block()[5],
    "cyclist": lambda: cyclist()[20],
    "random 0.0": lambda: random_street(11, 0.0),
    "random 0.5": lambda: random_street(11, 0.5),
    "random 1.0": lambda: random_street(11, 1.0),
}


@pytest.fixture(scope="module", params=ANY_FRAMES)
def name(request):
    return request.param


@pytest.fixture(scope="module")
def frame(name):
    return ANY_FRAMES[name]()


class TestTruth:
    """Properties that the truth of every scene must have."""

    def test_arrays_have_matching_lengths(self, name, frame):
        swept, n = frame.scan, len(frame.cloud)
        assert frame.cloud is swept.cloud and swept.cloud.shape == (n, 4)
        assert swept.cloud.dtype == np.float64 and np.isfinite(swept.cloud).all()
        for array, kind in (
            (swept.classes, np.uint8),
            (swept.objects, np.int32),
            (swept.times, np.float64),
        ):
            assert array.shape == (n,) and array.dtype == kind
        assert swept.beams.shape == (n,)
        assert swept.cloud[:, 3].min() >= 0 and swept.cloud[:, 3].max() <= 1

    def test_returns_are_inside_the_box_of_their_object(self, name, frame):
        slack = 6 * 0.05 if "highway" in name else 6 * 0.02
        for box in frame.boxes:
            points = frame.cloud[frame.scan.objects == box.identity, :3]
            cosine, sine = math.cos(box.yaw), math.sin(box.yaw)
            x, y, z = (points - box.centre).T
            inside = np.column_stack([cosine * x + sine * y, cosine * y - sine * x, z])
            # The solids of walls and hedges extend below their boxes. This part is visible if the
            # ground slopes down from the middle of the box.
            sink = 0.03 * box.size[0] if box.kind in ("wall", "foliage") else 0.0
            excess = np.abs(inside) - np.array(box.size) / 2 - (0, 0, sink)
            assert excess.max() <= slack, (box, excess.max(axis=0))

    def test_boxes_have_the_number_and_the_class_of_their_returns(self, name, frame):
        identities = [box.identity for box in frame.boxes]
        assert len(set(identities)) == len(identities) and min(identities) > 0
        assert set(np.unique(frame.scan.objects)) == {0, *identities}
        for box in frame.boxes:
            mine = frame.scan.objects == box.identity
            assert box.returns == np.count_nonzero(mine) > 0
            assert_array_equal(frame.scan.classes[mine], CLASSES.index(box.kind))
            assert -math.pi <= box.yaw < math.pi
        not_an_object = np.isin(np.array(CLASSES)[frame.scan.classes], ("invalid", "ground", "ego"))
        assert_array_equal(frame.scan.objects == 0, not_an_object)

    def test_corners_form_a_box_of_the_stated_size(self, name, frame):
        for box in frame.boxes:
            floor, roof = box.corners[:4], box.corners[4:]
            assert_allclose(roof - floor, np.broadcast_to((0, 0, box.size[2]), (4, 3)), atol=1e-9)
            sides = np.linalg.norm(np.roll(floor, -1, axis=0) - floor, axis=1)
            assert_allclose(sides, np.array(box.size)[[0, 1, 0, 1]])
            assert_allclose(box.corners.mean(axis=0), box.centre, atol=1e-9)
            ahead = floor[[0, 3]].mean(axis=0) - floor[[1, 2]].mean(axis=0)
            assert math.isclose(math.cos(math.atan2(ahead[1], ahead[0]) - box.yaw), 1.0)

    def test_objects_do_not_overlap(self, name, frame):
        assert_nothing_overlaps(frame)


@pytest.mark.parametrize("make", [city_block, cyclist, highway])
def test_a_stream_is_a_lazy_sequence(make):
    stream = make(frames=12)
    assert len(stream) == 12
    third = stream[3]
    assert isinstance(third, Frame) and third.time == 0.3
    assert stream[-9].cloud.tobytes() == third.cloud.tobytes()
    part = stream[2:9:2]
    assert len(part) == 4 and part[1].time == 0.4
    assert [frame.time for frame in stream[:3]] == [0.0, 0.1, 0.2]
    with pytest.raises(IndexError):
        stream[12]
    assert len(make(frames=0)) == 0 and list(make(frames=0)) == []


@pytest.mark.parametrize("make", [city_block, cyclist, highway])
def test_identities_and_sizes_are_constant_in_a_stream_and_motion_is_small(make):
    first, second = make()[10], make()[11]
    before = {box.identity: box for box in first.boxes}
    after = {box.identity: box for box in second.boxes}
    common = before.keys() & after.keys()
    assert len(common) >= 0.8 * len(before)
    for identity in common:
        assert before[identity].kind == after[identity].kind
        assert before[identity].size == after[identity].size
        ranges = (np.hypot(*box.centre[:2]) for box in (before[identity], after[identity]))
        assert abs(next(ranges) - next(ranges)) < 2.0


def test_velocity_is_the_motion_of_a_box_over_the_ground():
    frames = cyclist()[30:32]
    boxes = [{box.identity: box for box in frame.boxes} for frame in frames]
    # The rigid motion of the parked cars between two frames shows how the ego car moves.
    parked = [i for i in boxes[0].keys() & boxes[1].keys() if boxes[0][i].velocity == (0.0, 0.0)]
    a, b = (np.array([complex(*box[i].centre[:2]) for i in parked]) for box in boxes)
    turn = np.vdot(a - a.mean(), b - b.mean())
    turn /= abs(turn)
    shift = b.mean() - turn * a.mean()
    moving = [i for i in boxes[0].keys() & boxes[1].keys() if i not in parked]
    assert len(moving) >= 4
    for identity in moving:
        travelled = (complex(*boxes[1][identity].centre[:2]) - shift) / turn
        travelled -= complex(*boxes[0][identity].centre[:2])
        assert abs(travelled / 0.1 - complex(*boxes[0][identity].velocity)) < 0.35
    turning = [i for i in moving if abs(boxes[0][i].yaw - boxes[1][i].yaw) > 0.02]
    assert len(turning) >= 3


def test_the_cyclist_is_always_in_view():
    stream = cyclist()
    rider = next(box.identity for box in stream[0].boxes if box.kind == "cyclist")
    for index in range(0, len(stream), 12):
        box = next(box for box in stream[index].boxes if box.identity == rider)
        assert box.returns > 50 and box.centre[0] > 0


def test_the_city_has_every_kind_of_object():
    kinds = {}
    for box in city_block()[0].boxes:
        kinds.setdefault(box.kind, []).append(box)
    assert {"car", "pedestrian", "pole", "wall", "foliage"} <= kinds.keys()
    speeds = [math.hypot(*box.velocity) for box in kinds["car"]]
    assert min(speeds) == 0.0 and max(speeds) > 3.0


@pytest.mark.slow
def test_random_streets_have_more_objects_with_more_difficulty():
    counts = [
        np.mean([len(random_street(seed, level, CHEAP).boxes) for seed in range(4)])
        for level in (0.0, 0.5, 1.0)
    ]
    assert counts[0] < counts[1] < counts[2]
    assert counts[2] > 60


def test_random_streets_accept_any_sensor_and_differ_by_seed():
    cheap = random_street(5, 0.5, CHEAP)
    assert 1000 < len(cheap.cloud) < 16 * 360
    again, other = random_street(5, 0.5, sensor=CHEAP), random_street(6, 0.5, sensor=CHEAP)
    assert cheap.cloud.tobytes() == again.cloud.tobytes() != other.cloud.tobytes()
    assert cheap.boxes == again.boxes


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(30))
def test_objects_on_random_streets_do_not_overlap(seed):
    assert_nothing_overlaps(random_street(seed, 1.0, CHEAP))


@pytest.mark.slow
def test_the_space_of_the_ego_car_is_empty_on_random_streets():
    for seed in range(20):
        frame = random_street(seed, seed % 3 / 2, CHEAP)
        points = frame.cloud[:, :3]
        near = np.all((points > (-1.5, -1.7, -1.0)) & (points < (2.6, 1.7, -0.4)), axis=1)
        kinds = np.array(CLASSES)[frame.scan.classes[near]]
        assert set(kinds) <= {"invalid", "ego", "ground"}


@pytest.mark.slow
def test_nothing_collides_while_a_stream_runs():
    for stream in (city_block(seed=1)[::7], cyclist(frames=100)[::9], highway()[::7]):
        for frame in stream:
            assert_nothing_overlaps(frame)


@pytest.mark.parametrize("difficulty", [-0.1, 1.5, math.nan])
def test_a_difficulty_out_of_range_is_refused(difficulty):
    with pytest.raises(ValueError, match="from 0 to 1"):
        random_street(0, difficulty)


# The lesson's cloud


def test_the_simulator_reproduces_the_lesson_cloud_on_disk(tmp_path):
    write_lesson_cloud(tmp_path)
    assert (tmp_path / "cloud.txt").read_bytes() == (DATA / "cloud.txt").read_bytes()
    with np.load(tmp_path / "cloud_truth.npz") as new, np.load(DATA / "cloud_truth.npz") as old:
        assert new.files == old.files
        for name in new.files:
            assert new[name].dtype == old[name].dtype
            if new[name].dtype.kind == "f":
                assert_allclose(new[name], old[name], rtol=0, atol=1e-9)
            else:
                assert_array_equal(new[name], old[name])


def test_the_lesson_cloud_is_small_and_its_truth_has_a_row_per_line(lesson_frame):
    path = DATA / "cloud.txt"
    assert path.stat().st_size < 4e6
    cloud = np.loadtxt(path)
    with np.load(DATA / "cloud_truth.npz") as truth:
        assert tuple(truth["class_names"]) == CLASSES
        for name in ("classes", "objects", "beams"):
            assert truth[name].shape == (len(cloud),)
        assert len(truth["box_centres"]) == len(truth["box_kinds"]) == len(lesson_frame.boxes)
    assert f"({len(cloud)}, 4)" in (DATA / "README.md").read_text(encoding="utf-8")
    assert_allclose(cloud[:, :3], lesson_frame.cloud[:, :3], atol=0.00151)


def test_the_lesson_cloud_has_the_properties_that_the_lessons_need(lesson_frame):
    cloud, classes = lesson_frame.cloud, np.array(CLASSES)[lesson_frame.scan.classes]
    distance = np.hypot(cloud[:, 0], cloud[:, 1])
    assert 105_000 < len(cloud) < 128_000
    assert 1 <= np.count_nonzero((cloud[:, :3] == 0).all(axis=1)) <= 5
    # A ground level of -1.2 m removes the road nearby, but not the slope farther away.
    high_ground = (classes == "ground") & (cloud[:, 2] >= -1.2)
    assert distance[high_ground].min() > 15.0 and high_ground.sum() > 100
    # Ego returns are in the box that lesson 07 removes.
    ego = cloud[classes == "ego", :3]
    assert 100 < len(ego) < 1000
    assert np.all(ego > (-1.5, -1.7, -1.0)) and np.all(ego < (2.6, 1.7, -0.4))
    near = (distance <= 10) & (cloud[:, 2] >= -1.2)
    big = {kind: 0 for kind in CLASSES}
    for box in lesson_frame.boxes:
        big[box.kind] += np.count_nonzero(near & (lesson_frame.scan.objects == box.identity)) >= 100
    assert big["car"] >= 5 and big["pedestrian"] >= 4 and big["pole"] >= 3
    assert big["cyclist"] >= 1 and big["foliage"] >= 2 and big["wall"] >= 2
    # No value is exactly equal to a limit that the lessons use.
    rounded = np.loadtxt(DATA / "cloud.txt")
    assert not np.any(rounded[:, 2] == -1.2)
    assert not np.any(rounded[:, 0] ** 2 + rounded[:, 1] ** 2 == 100.0)


# ---- the highway ---------------------------------------------------------------------------------


def test_the_highway_has_about_976_rays_and_no_ego_returns():
    frame = simple_highway()
    assert abs(len(frame.cloud) - 976) <= 0.05 * 976
    assert [box.kind for box in frame.boxes] == ["car"] * 3
    assert CLASSES.index("ego") not in frame.scan.classes
    ranges = np.linalg.norm(frame.cloud[:, :3], axis=1)
    assert ranges.min() >= 5.0 and ranges.max() <= 50.0


def test_frame_zero_of_the_moving_highway_is_the_simple_highway():
    assert highway(seed=2)[0].cloud.tobytes() == simple_highway(seed=2).cloud.tobytes()


REAL = os.environ.get("REAL_CLOUDS")


@pytest.mark.skipif(not REAL, reason=RECORDINGS)
def test_the_highway_has_as_many_returns_per_object_as_the_published_recording():
    from tests.benchmarks.compare_real import highway_counts, read_highway

    ours = highway_counts(simple_highway().cloud[:, :3])
    # The noise of the recorded points is uniform between 0 and 0.2 m, so it averages 0.1 m.
    theirs = highway_counts(read_highway(Path(REAL)) - 0.1)
    assert sum(ours) == len(simple_highway().cloud) and sum(theirs) == 976
    for mine, recorded in zip(ours, theirs, strict=True):
        assert abs(mine - recorded) <= 0.05 * recorded


def test_a_seed_gives_the_same_bytes_as_in_earlier_releases():
    """If these checksums change, so do all clouds that hidden tests draw."""
    frames = simple_highway(1), random_street(1, 0.5, CHEAP), cyclist(1)[3]
    digests = (hashlib.sha256(np.round(frame.cloud, 3).tobytes()).hexdigest() for frame in frames)
    assert [digest[:12] for digest in digests] == ["2635125a4faf", "c9e745b6c15f", "36f326700c0a"]
