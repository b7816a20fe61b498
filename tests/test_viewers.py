"""Files for Rerun, Foxglove and RViz contain the right data, according to independent readers."""

import itertools
import sys
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from tests.prerequisites import LIBRARIES, RERUN
from utils import films, play
from utils.boxes import Box
from utils.drive import STREETS, Trip
from utils.drive.loop import drive
from utils.films.streams import OUTLINE, write_stream
from utils.recordings import read_bag
from utils.simulator.sensor import Sensor, layers

SIZES = [(4.1, 1.8, 1.5), (0.7, 0.6, 1.7)]
PLACES = [(8.3, 2.9, -0.9, 0.4), (5.2, -3.7, -0.8, -1.1)]  # x, y, z and yaw


def made_frame(number: int) -> tuple[films.DetectedFrame, np.ndarray]:
    """Return a frame with a sloping road, two boxes, a point high above and a missing return.

    Also return the kind of each point: 0 for the road, 1 and 2 for the boxes, 3 for no layer.
    """
    rng = np.random.default_rng(number)
    road = rng.uniform(-20, 20, (500, 3))
    road[:, 2] = -1.75 + 0.01 * road[:, 0] + rng.normal(scale=0.02, size=500)
    parts, corners = [road], []
    for size, (x, y, z, yaw) in zip(SIZES, PLACES, strict=True):
        turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
        points = rng.uniform(-0.49, 0.49, (60, 3)) * size
        points[:, :2] = points[:, :2] @ turn
        parts.append(points + (x + number, y, z + 0.5))
        unit = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) / 2 * size[:2] @ turn
        floor, roof = -size[2] / 2, size[2] / 2
        box = np.vstack([np.insert(unit, 2, height, axis=1) for height in (floor, roof)])
        corners.append(box + (x + number, y, z + 0.5))
    xyz = np.vstack([*parts, [(3.0, 3.0, 6.0)], [(np.nan, 0.0, 0.0)]])
    kinds = np.repeat([0, 1, 2, 3, 4], [500, 60, 60, 1, 1])
    cloud = np.column_stack([xyz, rng.uniform(size=len(xyz))]).astype(np.float32)
    order = rng.permutation(len(cloud))
    truth = (Box((1.0, 2.0, -1.0), (4.0, 2.0, 1.5), 0.3, "car", 17, (0.0, 0.0), 5),)
    frame = films.DetectedFrame(
        number + 1, 3, 0.1 * number, cloud[order], truth, np.array(corners),
        track_ids=(4, 11 + number), decision=f"decision {number}",
    )  # fmt: skip
    return frame, kinds[order]


FRAMES = [made_frame(number) for number in range(3)]


def expected_layers(frame: films.DetectedFrame, kinds: np.ndarray) -> dict[str, np.ndarray]:
    """Return the rows of each layer, in any order."""
    return {
        "scan": frame.cloud[kinds < 4],
        "ground": frame.cloud[kinds == 0],
        "clusters": frame.cloud[(kinds == 1) | (kinds == 2)],
    }


def sorted_rows(rows: np.ndarray) -> np.ndarray:
    return rows[np.lexsort(rows.T)]


def messages(path: Path, topic: str) -> list:
    store = get_typestore(Stores.ROS2_HUMBLE)
    with AnyReader([path], default_typestore=store) as reader:
        return [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages()
            if connection.topic == topic
        ]


@pytest.fixture(scope="module")
def mcap(tmp_path_factory):
    path = tmp_path_factory.mktemp("stream") / "street.mcap"
    write_stream(path, (frame for frame, _ in FRAMES))
    assert [file.name for file in path.parent.iterdir()] == ["street.mcap"]
    return path


@pytest.mark.parametrize("layer", ["scan", "ground", "clusters"])
def test_the_course_reads_the_points_of_an_mcap_file(mcap, layer):
    bag = read_bag(mcap, f"/{layer}")
    np.testing.assert_allclose(bag.times, [0, 0.1, 0.2])
    for cloud, (frame, kinds) in zip(bag, FRAMES, strict=True):
        expected = expected_layers(frame, kinds)[layer]
        np.testing.assert_array_equal(sorted_rows(cloud), sorted_rows(expected))


def test_clusters_in_an_mcap_file_have_track_ids(mcap):
    for message, (frame, kinds) in zip(messages(mcap, "/clusters"), FRAMES, strict=True):
        assert [field.name for field in message.fields] == ["x", "y", "z", "intensity", "track_id"]
        rows = message.data.view("<f4").reshape(-1, 5)
        for kind, track in enumerate(frame.track_ids, start=1):
            expected = frame.cloud[kinds == kind]
            np.testing.assert_array_equal(
                sorted_rows(rows[rows[:, 4] == track][:, :4]), sorted_rows(expected)
            )


def test_markers_in_an_mcap_file_replace_the_boxes_of_the_previous_frame(mcap):
    for message, (frame, _) in zip(messages(mcap, "/boxes"), FRAMES, strict=True):
        delete, *drawn = message.markers
        assert delete.action == 3 and delete.header.frame_id == "lidar"
        assert len({marker.id for marker in drawn}) == len(drawn) == 4
        assert [marker.text for marker in drawn[1::2]] == [str(name) for name in frame.track_ids]
        for marker, box in zip(drawn[::2], frame.boxes, strict=True):
            path = [(point.x, point.y, point.z) for point in marker.points]
            np.testing.assert_allclose(path, box[OUTLINE])
    (truth,) = FRAMES[0][0].true_boxes
    assert messages(mcap, "/true_boxes")[0].markers[2].text == str(truth.identity)
    decisions = [message.data for message in messages(mcap, "/decision")]
    assert decisions == ["decision 0", "decision 1", "decision 2"]


def test_the_outline_of_a_box_follows_all_of_its_edges_and_nothing_else():
    corners = FRAMES[0][0].boxes[0]
    sides = {frozenset(pair) for pair in itertools.pairwise(OUTLINE)}
    lengths = [np.linalg.norm(corners[first] - corners[last]) for first, last in map(tuple, sides)]
    np.testing.assert_allclose(sorted(lengths), sorted(SIZES[0] * 4))


def test_another_library_reads_an_mcap_file(mcap):
    decoder = pytest.importorskip("mcap_ros2.decoder", reason=LIBRARIES)
    from mcap.reader import make_reader

    with mcap.open("rb") as file:
        reader = make_reader(file, decoder_factories=[decoder.DecoderFactory()])
        topics = [channel.topic for _, channel, _, _ in reader.iter_decoded_messages()]
    names = ("scan", "ground", "clusters", "boxes", "true_boxes", "decision")
    assert {topic: topics.count(topic) for topic in topics} == {f"/{name}": 3 for name in names}


def test_rerun_reads_an_rrd_file(tmp_path):
    chunk = pytest.importorskip("rerun.chunk", reason=RERUN)
    write_stream(tmp_path / "street.rrd", (frame for frame, _ in FRAMES))
    found = {}
    for part in chunk.RrdReader(tmp_path / "street.rrd").stream().to_chunks():
        rows = part.to_record_batch().to_pydict()
        for number in range(part.num_rows if "time" in rows else 0):
            moment = round(rows["time"][number].total_seconds() * 10)
            found[part.entity_path, moment] = {name: value[number] for name, value in rows.items()}
    for number, (frame, kinds) in enumerate(FRAMES):
        for layer, expected in expected_layers(frame, kinds).items():
            points = np.array(found[f"/lidar/{layer}", number]["Points3D:positions"], np.float32)
            np.testing.assert_array_equal(sorted_rows(points), sorted_rows(expected[:, :3]))
        tracks = found["/lidar/clusters", number]["Points3D:class_ids"]
        assert sorted(tracks) == sorted(np.repeat(frame.track_ids, 60))
        boxes = found["/lidar/boxes", number]
        np.testing.assert_allclose(boxes["LineStrips3D:strips"], frame.boxes[:, OUTLINE], atol=1e-5)
        assert boxes["LineStrips3D:labels"] == [str(name) for name in frame.track_ids]
        assert found["/lidar/true_boxes", number]["LineStrips3D:labels"] == ["17"]
        assert found["/decision", number]["TextLog:text"] == [f"decision {number}"]


def test_a_missing_package_is_reported_and_no_file_is_left(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(ValueError, match="pip install rerun-sdk"):
        films.record([FRAMES[0][0].cloud], tmp_path / "street.rrd")
    assert not list(tmp_path.iterdir())


def test_a_stream_can_be_recorded_without_boxes(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert play.main(["highway", "--frames", "2", "--record", "street.mcap"]) == 0
    assert "A stream for Foxglove and RViz. 2 frames." in capsys.readouterr().out
    assert len(messages(Path("street.mcap"), "/boxes")[1].markers) == 1  # only the deletion
    assert not messages(Path("street.mcap"), "/decision")


def test_a_drive_is_saved_with_the_boxes_and_decisions_of_the_planner(tmp_path):
    coarse = Sensor(layers(16, -24, 2), azimuth_step=np.radians(2.0))
    driven = drive(STREETS[2], seconds=0.5, sensor=coarse)
    path = tmp_path / "drive.mcap"
    assert Trip(driven).save(path) == "A stream for Foxglove and RViz."
    decisions = [message.data for message in messages(path, "/decision")]
    assert len(decisions) == len(driven.moments) == 5
    assert decisions[0].startswith(f"{3.6 * driven.moments[0].speed:.0f} km/h")
    for message, moment in zip(messages(path, "/boxes"), driven.moments, strict=True):
        labels = [marker.text for marker in message.markers if marker.text]
        assert labels == [str(box.track_id) for box in moment.tracked_boxes]
    assert labels
