"""Reading small ROS recordings, written by rosbags, both intact and damaged."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from utils.clouds import CloudFileError
from utils.recordings import read_bag
from utils.recordings.messages import decode_point_cloud

TIMES = [1_000_000_000, 1_100_000_000, 1_100_000_000, 1_300_000_000]


def cloud(frame: int) -> np.ndarray:
    return np.random.default_rng(frame).normal(size=(20 + frame, 4)).astype(np.float32)


def layout(names="x y z intensity", offsets=(0, 4, 8, 12), datatypes=(7, 7, 7, 7)):
    return [
        SimpleNamespace(name=name, offset=offset, datatype=datatype, count=1)
        for name, offset, datatype in zip(names.split(), offsets, datatypes, strict=True)
    ]


def message(data, fields=None, height=1, width=None, point_step=16, row_step=None, big=False):
    """Return a PointCloud2 message with the given bytes as its data."""
    width = len(data) // point_step if width is None else width
    return SimpleNamespace(
        fields=layout() if fields is None else fields, height=height, width=width,
        point_step=point_step, row_step=width * point_step if row_step is None else row_step,
        is_bigendian=big, data=np.frombuffer(data, np.uint8),
    )  # fmt: skip


def record(path, kind: str, topics=("/velodyne_points",)):
    """Record four clouds per topic, and a topic of strings, in a bag of the given kind."""
    store = get_typestore(Stores.ROS1_NOETIC if kind == "bag" else Stores.ROS2_HUMBLE)
    types = store.types
    if kind == "bag":
        writer, pack, extra = Writer1(path), store.serialize_ros1, {"seq": 0}
    else:
        plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
        writer = Writer2(path, version=9, storage_plugin=plugin)
        pack, extra = store.serialize_cdr, {}
    with writer:
        text = writer.add_connection("/log", "std_msgs/msg/String", typestore=store)
        writer.write(text, 5, pack(types["std_msgs/msg/String"]("hello"), "std_msgs/msg/String"))
        for topic in topics:
            name = "sensor_msgs/msg/PointCloud2"
            connection = writer.add_connection(topic, name, typestore=store)
            for frame, time in enumerate(TIMES):
                plain = message(cloud(frame).tobytes())
                stamp = types["builtin_interfaces/msg/Time"](sec=0, nanosec=time)
                header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="velodyne", **extra)
                fields = [types["sensor_msgs/msg/PointField"](**vars(f)) for f in plain.fields]
                full = vars(plain) | {"header": header, "fields": fields, "is_dense": True}
                writer.write(connection, time, pack(types[name](**full), name))
    return path


@pytest.fixture(params=["bag", "db3", "mcap", "db3 folder", "mcap folder"])
def bag(request, tmp_path):
    kind, *folder = request.param.split()
    path = record(tmp_path / ("street.bag" if kind == "bag" else "street"), kind)
    return path if folder or kind == "bag" else next(path.glob(f"*.{kind}"))


def test_clouds_are_read_by_index_with_their_times(bag):
    clouds = read_bag(bag)
    assert clouds.topic == "/velodyne_points" and len(clouds) == 4
    assert clouds.timestamps.tolist() == TIMES
    np.testing.assert_allclose(clouds.times, [0, 0.1, 0.1, 0.3])
    for frame in [2, 0, 3, 1]:  # frames 1 and 2 have the same time
        np.testing.assert_array_equal(clouds[frame], cloud(frame))
    np.testing.assert_array_equal(clouds[-1], cloud(3))
    for frame, read in enumerate(clouds):
        np.testing.assert_array_equal(read, cloud(frame))
    late = clouds[2:]
    assert len(late) == 2 and late.timestamps.tolist() == TIMES[2:]
    np.testing.assert_array_equal(late[0], cloud(2))
    with pytest.raises(IndexError):
        clouds[4]


@pytest.mark.parametrize("kind", ["bag", "db3"])
def test_the_topic_must_be_named_if_there_are_several(tmp_path, kind):
    path = record(tmp_path / ("two.bag" if kind == "bag" else "two"), kind, ["/left", "/right"])
    assert len(read_bag(path, "/right")) == 4
    for topic in (None, "/middle"):
        with pytest.raises(CloudFileError, match="/left, /right"):
            read_bag(path, topic)
    empty = record(tmp_path / ("no.bag" if kind == "bag" else "no"), kind, [])
    with pytest.raises(CloudFileError, match=r"only /log \(String\)"):
        read_bag(empty)


def test_errors_explain_missing_and_unsuitable_files(tmp_path):
    (tmp_path / "other.bag").write_text("hello")
    with pytest.raises(CloudFileError, match=r"other\.bag"):
        read_bag(tmp_path / "street.bag")
    for name in ("other.bag", "empty.bag", "other.mcap", "other.db3"):
        (tmp_path / name).write_bytes(b"" if name == "empty.bag" else b"hello" * 99)
        with pytest.raises(CloudFileError, match="not an intact ROS recording"):
            read_bag(tmp_path / name)
    (tmp_path / "cloud.txt").write_text("1 2 3")
    with pytest.raises(CloudFileError, match="expected a file ending in .bag"):
        read_bag(tmp_path / "cloud.txt")
    with pytest.raises(CloudFileError, match="not an intact ROS recording"):
        read_bag(tmp_path)


@pytest.mark.parametrize("kind", ["bag", "db3", "mcap"])
def test_suffixes_may_have_capital_letters(tmp_path, kind):
    path = record(tmp_path / ("street.bag" if kind == "bag" else "street"), kind)
    file = path if kind == "bag" else next(path.glob(f"*.{kind}"))
    shouted = file.rename(tmp_path / f"STREET.{kind.upper()}")
    np.testing.assert_array_equal(read_bag(shouted)[2], cloud(2))


@pytest.mark.parametrize("kind", ["db3", "mcap"])
def test_the_only_recording_in_a_folder_is_read_despite_wrong_metadata(tmp_path, kind):
    folder = record(tmp_path / "street", kind).rename(tmp_path / "street.bag")
    np.testing.assert_array_equal(read_bag(folder)[2], cloud(2))
    metadata = folder / "metadata.yaml"
    text = metadata.read_text()
    assert "storage_identifier: " in text
    metadata.write_text(re.sub("storage_identifier: .*", "storage_identifier: ''", text))
    np.testing.assert_array_equal(read_bag(folder)[2], cloud(2))
    next(folder.glob(f"*.{kind}")).rename(folder / f"my run.{kind}")  # the metadata are now wrong
    np.testing.assert_array_equal(read_bag(folder)[2], cloud(2))
    metadata.unlink()
    np.testing.assert_array_equal(read_bag(folder)[2], cloud(2))
    (folder / f"second.{kind}").touch()
    with pytest.raises(CloudFileError, match="not an intact ROS recording"):
        read_bag(folder)


def test_errors_name_the_file_and_the_topic(tmp_path, monkeypatch):
    path = record(tmp_path / "street.bag", "bag")
    monkeypatch.setattr("utils.recordings.messages.KINDS", {})
    with pytest.raises(CloudFileError, match=r"^street\.bag, topic /velodyne_points, message 1: "):
        read_bag(path)[1]


def test_errors_explain_recordings_that_were_not_closed_or_not_downloaded(tmp_path):
    (tmp_path / "street.bag.active").touch()
    with pytest.raises(CloudFileError, match="rosbag reindex"):
        read_bag(tmp_path / "street.bag.active")
    (tmp_path / "street.bag").write_bytes(
        b"version https://git-lfs.github.com/spec/v1\noid sha256:0"
    )
    with pytest.raises(CloudFileError, match="Git LFS pointer"):
        read_bag(tmp_path / "street.bag")


def test_the_error_explains_a_truncated_recording(bag):
    files = [bag] if bag.is_file() else [*bag.glob("*.db3"), *bag.glob("*.mcap")]
    data = files[0].read_bytes()
    files[0].write_bytes(data[: len(data) // 3])
    with pytest.raises(CloudFileError, match=bag.name):
        list(read_bag(bag))


class TestMessages:
    points = np.array([[1.5, -2, 3, 7], [4, 5, np.nan, 0], [-1, 0, 2, 255]])

    @pytest.mark.parametrize("big", [False, True])
    def test_fields_of_any_type_in_any_order_with_gaps_are_read(self, big):
        kind = np.dtype({"names": ["z", "i", "y", "x"], "formats": ["f8", "u1", "f4", "f4"],
                         "offsets": [1, 12, 16, 24], "itemsize": 32})  # fmt: skip
        records = np.zeros(3, kind.newbyteorder(">" if big else "<"))
        for name, column in zip("xyzi", self.points.T, strict=True):
            records[name] = column
        fields = layout("z ring x intensity y", (1, 30, 24, 12, 16), (8, 4, 7, 2, 7))
        result = decode_point_cloud(message(records.tobytes(), fields, point_step=32, big=big), "a")
        assert result.dtype == np.float64
        np.testing.assert_array_equal(result, self.points)

    def test_organised_clouds_with_padded_rows_are_read(self):
        rows = np.zeros((2, 3 * 16 + 5), np.uint8)
        expected = np.random.default_rng(0).normal(size=(2, 3, 4)).astype("<f4")
        rows[:, :48] = expected.view(np.uint8).reshape(2, 48)
        fields = layout()[:3]
        made = message(rows.tobytes()[:-5], fields, height=2, width=3, row_step=53)
        np.testing.assert_array_equal(
            decode_point_cloud(made, "a"), expected[..., :3].reshape(6, 3)
        )

    def test_empty_clouds_and_a_missing_row_step_are_read(self):
        assert decode_point_cloud(message(b""), "a").shape == (0, 4)
        made = message(self.points.astype("<f4").tobytes(), row_step=0)
        np.testing.assert_array_equal(decode_point_cloud(made, "a"), self.points)

    @pytest.mark.parametrize("row_step", [0, 2, 96])
    @pytest.mark.parametrize(("height", "width"), [(2, 3), (6, 1)])
    def test_a_wrong_row_step_is_ignored_if_the_points_fill_the_data(self, row_step, height, width):
        expected = np.random.default_rng(1).normal(size=(6, 4)).astype("<f4")
        made = message(expected.tobytes(), height=height, width=width, row_step=row_step)
        np.testing.assert_array_equal(decode_point_cloud(made, "a"), expected)

    @pytest.mark.parametrize("size", [{"height": 0, "width": 6}, {"height": 0, "width": 0}])
    def test_points_are_read_even_if_the_message_claims_to_have_none(self, size):
        expected = np.random.default_rng(1).normal(size=(6, 4)).astype("<f4")
        np.testing.assert_array_equal(
            decode_point_cloud(message(expected.tobytes(), **size), "a"), expected
        )

    @pytest.mark.parametrize("kind", ["<f4", ">f4"])
    def test_a_wrong_byte_order_flag_is_ignored(self, kind):
        expected = np.random.default_rng(1).normal(scale=20, size=(50, 4)).astype(kind)
        for big in (False, True):
            made = message(expected.tobytes(), big=big)
            np.testing.assert_array_equal(decode_point_cloud(made, "a"), expected)

    @pytest.mark.parametrize(
        ("options", "reason"),
        [
            ({"fields": layout()[:2]}, "the fields are y, x, expected x, y and z"),
            ({"fields": layout(datatypes=(7, 7, 9, 7))}, "expected x, y and z as numbers"),
            ({"width": 4}, "1 x 4 points of 16 bytes in rows of 64 bytes, but contains 48"),
            ({"width": 2**32 - 1, "height": 2**32 - 1}, "4294967295 x 4294967295 points"),
            ({"point_step": 8}, "end at byte 16, but a point has 8 bytes"),
            ({"point_step": 0, "width": 3}, "end at byte 16, but a point has 0 bytes"),
            ({"height": 2, "row_step": 16}, "2 x 3 points of 16 bytes in rows of 48 bytes"),
            ({"height": 2, "width": 1, "row_step": 12}, "has 16 bytes, but row_step is 12"),
            ({"fields": layout(offsets=(0, 4, 2**32 - 1, 12))}, "end at byte 4294967299"),
        ],
    )
    def test_errors_explain_impossible_layouts(self, options, reason):
        with pytest.raises(CloudFileError, match="street.bag, message 7") as caught:
            decode_point_cloud(message(bytes(48), **options), "street.bag", "message 7")
        assert reason in str(caught.value)
        assert ("cut off" in str(caught.value)) == ("in rows of" in str(caught.value))
