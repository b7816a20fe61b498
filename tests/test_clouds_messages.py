"""Livox's CustomMsg and LaserScan in ROS recordings.

The tests pack the messages with `struct`, or with rosbags and the definitions from Livox's drivers.
"""

import math
import struct
import warnings

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from utils.clouds import CloudFileError
from utils.recordings import read_bag
from utils.recordings.messages import LASER_SCAN, LIVOX, POINT_CLOUD, decode_message

POINT_DEFINITION = """uint32 offset_time
float32 x
float32 y
float32 z
uint8 reflectivity
uint8 tag
uint8 line"""
LIVOX_DEFINITION = """std_msgs/Header header
uint64 timebase
uint32 point_num
uint8 lidar_id
uint8[3] rsvd
CustomPoint[] points"""
POINTS = [(0.5, -2.25, 0.125, 255), (-30.75, 4.5, -1.5, 0), (7.0625, 0.25, 3.0, 91)]
KINDS = ("bag", "db3", "mcap")


def padded(data: bytes, size: int) -> bytes:
    """Append zeros, as ROS 2 does before a number of `size` bytes, counted from byte 4."""
    return data + bytes(-(len(data) - 4) % size)


def packed_header(frame: str, ros1: bool) -> bytes:
    name = frame.encode() + (b"" if ros1 else b"\0")
    start = struct.pack("<III", 3, 17, 250) if ros1 else struct.pack("<4sII", b"\0\1\0\0", 17, 250)
    return start + struct.pack("<I", len(name)) + name


def packed_livox(points, frame: str, ros1: bool) -> bytes:
    data = packed_header(frame, ros1)
    data = data if ros1 else padded(data, 8)
    data += struct.pack("<QIB3sI", 12345678901, len(points), 2, b"\1\2\3", len(points))
    for number, (x, y, z, reflectivity) in enumerate(points):
        data = data if ros1 else padded(data, 4)
        data += struct.pack("<IfffBBB", 1000 * number, x, y, z, reflectivity, 16, number)
    return data


def packed_scan(
    ranges, intensities, ros1: bool, start=-0.5, step=0.25, limits=(0.5, 30.0)
) -> bytes:
    data = packed_header("laser", ros1)
    data = data if ros1 else padded(data, 4)
    data += struct.pack("<7f", start, start + step * len(ranges), step, 0.001, 0.1, *limits)
    for numbers in (ranges, intensities):
        data += struct.pack(f"<I{len(numbers)}f", len(numbers), *numbers)
    return data


def typestore(ros1: bool):
    """Return rosbags' own definitions, with those of Livox's drivers."""
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    for name in LIVOX:
        point = get_types_from_msg(POINT_DEFINITION, name.replace("CustomMsg", "CustomPoint"))
        store.register(point | get_types_from_msg(LIVOX_DEFINITION, name))
    return store


def record(folder, kind: str, topics: dict[str, tuple[str, list[bytes]]]):
    """Write a recording with the messages of each topic, and return the path of its file."""
    if kind == "bag":
        writer = Writer1(folder / "street.bag")
    else:
        plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
        writer = Writer2(folder / "street", version=9, storage_plugin=plugin)
    store = typestore(kind == "bag")
    with writer:
        for topic, (name, messages) in topics.items():
            connection = writer.add_connection(topic, name, typestore=store)
            for time, message in enumerate(messages, start=1):
                writer.write(connection, time, message)
    return next(folder.rglob(f"street*.{kind}"))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", LIVOX)
def test_recordings_of_livox_scanners_are_read(tmp_path, kind, name):
    messages = [packed_livox(POINTS[:count], "livox_frame", kind == "bag") for count in (3, 0, 1)]
    clouds = read_bag(record(tmp_path, kind, {"/livox/lidar": (name, messages)}))
    for cloud, count in zip(clouds, (3, 0, 1), strict=True):
        assert cloud.dtype == np.float32
        np.testing.assert_array_equal(cloud, np.reshape(POINTS[:count], (count, 4)))


@pytest.mark.parametrize("length", range(10))  # the length of the name changes the alignment
@pytest.mark.parametrize("order", ["ROS 1", "little", "big"])
def test_messages_packed_by_the_rosbags_library_are_read(length, order):
    ros1 = order == "ROS 1"
    store = typestore(ros1)
    rng = np.random.default_rng(length)
    expected = rng.normal(scale=20, size=(40, 4)).astype(np.float32)
    expected[:, 3] = rng.integers(0, 256, 40)
    custom, point = store.types[LIVOX[0]], store.types[LIVOX[0].replace("Msg", "Point")]
    time = store.types["builtin_interfaces/msg/Time"](sec=5, nanosec=6)
    header = store.types["std_msgs/msg/Header"](
        stamp=time, frame_id="a" * length, **({"seq": 1} if ros1 else {})
    )
    points = [point(7, *map(float, row[:3]), int(row[3]), 1, 2) for row in expected]
    message = custom(header, 8, len(points), 1, np.zeros(3, np.uint8), points)
    if ros1:
        data = store.serialize_ros1(message, LIVOX[0])
    else:
        data = store.serialize_cdr(message, LIVOX[0], little_endian=order == "little")
    np.testing.assert_array_equal(decode_message(data, LIVOX[0], ros1, "a"), expected)


@pytest.mark.parametrize("kind", KINDS)
def test_laser_scans_are_points_at_height_0(tmp_path, kind):
    ranges = [2.0, 0.25, math.inf, 30.0, math.nan, 31.0, 7.5]  # the valid ones are 0, 3 and 6
    intensities = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0]
    messages = [
        packed_scan(ranges, values, kind == "bag", limits=(0.5, 30.0))
        for values in (intensities, [], intensities[:2])
    ]
    clouds = read_bag(record(tmp_path, kind, {"/scan": (LASER_SCAN, messages)}))
    expected = [
        (2.0 * math.cos(-0.5), 2.0 * math.sin(-0.5), 0, 10),
        (30.0 * math.cos(0.25), 30.0 * math.sin(0.25), 0, 40),
        (7.5 * math.cos(1.0), 7.5 * math.sin(1.0), 0, 70),
    ]
    for cloud, columns in zip(clouds, (4, 3, 3), strict=True):
        assert cloud.dtype == np.float32 and cloud.shape == (3, columns)
        np.testing.assert_allclose(cloud, np.array(expected)[:, :columns], rtol=1e-6)


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_the_topic_with_most_dimensions_is_read_unless_another_is_named(tmp_path, kind):
    scan = packed_scan([2.0], [], kind == "bag")
    livox = packed_livox(POINTS, "a", kind == "bag")
    topics = {"/floor": (LASER_SCAN, [scan]), "/roof": (LIVOX[1], [livox])}
    path = record(tmp_path, kind, topics)
    assert read_bag(path).topic == "/roof"
    assert read_bag(path, "/floor")[0].shape == (1, 3)
    with pytest.raises(CloudFileError, match="the topics with clouds are /floor, /roof"):
        read_bag(path, "/wall")


@pytest.mark.parametrize("ros1", [True, False])
@pytest.mark.parametrize("name", [LIVOX[0], LASER_SCAN, POINT_CLOUD])
def test_damaged_messages_are_refused_or_read_without_warnings(tmp_path, name, ros1):
    rng = np.random.default_rng(4)
    whole = (
        packed_livox(POINTS * 9, "a", ros1) if name in LIVOX else packed_scan([1.0] * 9, [], ros1)
    )
    messages = [whole[: rng.integers(len(whole))] for _ in range(60)]
    for _ in range(200):
        changed = bytearray(whole)
        start = rng.integers(len(whole) - 4)
        changed[start : start + 4] = rng.choice([b"\xff" * 4, b"\0\0\x80\x7f", rng.bytes(4)])
        messages.append(bytes(changed))
    path = record(tmp_path, "bag" if ros1 else "mcap", {"/points": (name, messages)})
    bag = read_bag(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for number in range(len(bag)):
            try:
                assert bag[number].shape[1] in (3, 4)
            except CloudFileError as error:
                assert path.name in str(error)
