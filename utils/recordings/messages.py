"""Decode the ROS messages that contain points: PointCloud2, Livox's CustomMsg and LaserScan.

https://docs.ros.org/en/noetic/api/sensor_msgs/html/msg/PointCloud2.html
https://docs.ros.org/en/noetic/api/sensor_msgs/html/msg/LaserScan.html
https://github.com/Livox-SDK/livox_ros_driver2/tree/master/msg
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from utils.clouds.errors import file_error, listing
from utils.clouds.kitti import has_plausible_sizes
from utils.clouds.pcd_header import cloud_fields

POINT_CLOUD = "sensor_msgs/msg/PointCloud2"
LASER_SCAN = "sensor_msgs/msg/LaserScan"
LIVOX = tuple(
    f"{package}/msg/CustomMsg"
    for package in ("livox_ros_driver", "livox_ros_driver2", "livox_interfaces")
)
MESSAGES = (POINT_CLOUD, *LIVOX, LASER_SCAN)
"""Types of the messages that `decode_message` reads, the most useful first."""

KINDS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
LIVOX_POINT = np.dtype(
    [("offset_time", "u4"), ("xyz", "f4", 3), ("reflectivity", "u1"), ("tag", "u1"), ("line", "u1")]
)


def decode_message(
    data: bytes, kind: str, is_ros1: bool, name: str, place: str = "message 0"
) -> np.ndarray:
    """Convert the bytes of a message to a cloud.

    Parameters
    ----------
    data : bytes
    kind : str
        Type of the message, one of `MESSAGES`.
    is_ros1 : bool
        Whether ROS 1 or ROS 2 packed the message.
    name, place : str
        File and position of the message, shown in errors.

    Returns
    -------
    ndarray, shape (n, 3) or (n, 4)

    Raises
    ------
    CloudFileError
        The layout of a PointCloud2 message does not fit its data. Damaged messages also raise other
        exceptions, from rosbags and NumPy.
    """
    if kind in LIVOX:
        return _decode_livox(data, is_ros1)
    message = _unpacker(is_ros1)(data, kind)
    if kind == LASER_SCAN:
        return _decode_laser_scan(message)
    return decode_point_cloud(message, name, place)


def decode_point_cloud(message: Any, name: str, place: str = "message 0") -> np.ndarray:
    """Convert a PointCloud2 message to a cloud.

    Parameters
    ----------
    message : object
        An object with the attributes of ``sensor_msgs/PointCloud2``. Fields may be in any order,
        points and rows may be padded, and either byte order is accepted.
    name, place : str
        File and position of the message, shown in errors.

    Returns
    -------
    ndarray, shape (n, 3) or (n, 4)
        float32, or float64 if a field is a double or a long integer.

    Raises
    ------
    CloudFileError
        x, y or z is missing, or the layout does not fit the data.
    """
    fields = {entry.name.lower(): entry for entry in reversed(message.fields)}
    wanted = cloud_fields(fields)
    if not fields.keys() >= set("xyz") or any(
        fields[field].datatype not in KINDS for field in wanted
    ):
        raise file_error(
            name,
            place,
            f"the fields are {listing(fields) or 'none'}, expected x, y and z as numbers",
        )
    kinds = [np.dtype(KINDS[fields[field].datatype]) for field in wanted]
    offsets = [fields[field].offset for field in wanted]
    shape, row_step = _layout(message)
    end = max(offset + kind.itemsize for offset, kind in zip(offsets, kinds, strict=True))
    height, width = shape
    if not height * width:
        return np.empty((0, len(wanted)), np.result_type(np.float32, *kinds))
    if problem := _layout_problem(message, shape, row_step, end):
        raise file_error(name, place, *problem)
    data = np.ascontiguousarray(message.data)

    def decode(order: str) -> np.ndarray:
        precision = np.result_type(np.float32, *kinds)
        cloud = np.empty((height, width, len(wanted)), precision)
        for index, (offset, kind) in enumerate(zip(offsets, kinds, strict=True)):
            cloud[:, :, index] = np.ndarray(
                shape, kind.newbyteorder(order), data, offset, (row_step, message.point_step)
            )
        return cloud.reshape(-1, len(wanted))

    cloud = decode(">" if message.is_bigendian else "<")
    if not has_plausible_sizes(cloud[:, :3]):  # some drivers set the flag of the other byte order
        other = decode("<" if message.is_bigendian else ">")
        cloud = other if has_plausible_sizes(other[:, :3]) else cloud
    return cloud


def _layout(message: Any) -> tuple[tuple[int, int], int]:
    """Return height and width of a message, and the bytes from one row to the next.

    Many drivers fill in `height`, `width` or `row_step` wrongly. If the data have exactly the size
    of the points, rows have no padding; if the message announces no points, all data are points.
    """
    height, width, step, size = message.height, message.width, message.point_step, len(message.data)
    if height * width == 0 and size and step and size % step == 0:
        height, width = 1, size // step
    unpadded = height == 1 or size == height * width * step
    return (height, width), step * width if unpadded else message.row_step


def _layout_problem(
    message: Any, shape: tuple[int, int], row_step: int, end: int
) -> tuple[str, str] | None:
    """Return why points do not fit into the data, and advice; or None if they fit.

    `end` is the first byte after the wanted fields, counted from the beginning of a point.
    """
    height, width = shape
    step, size = message.point_step, len(message.data)
    row = max(step * width, row_step)
    if end > step:
        return (
            f"the fields of a point end at byte {end}, but a point has {step} bytes",
            "Correct point_step or the fields in the program that publishes the points.",
        )
    if row * (height - 1) + step * width > size:
        return (
            f"the message announces {height} x {width} points of {step} bytes in rows of {row} "
            f"bytes, but contains {size} bytes",
            "Was the recording cut off?",
        )
    if row > row_step:
        return (
            f"a row of {width} points has {row} bytes, but row_step is {row_step}",
            "Correct row_step in the program that publishes the points.",
        )
    return None


def _decode_laser_scan(message: Any) -> np.ndarray:
    """Convert a LaserScan message, one turn of a scanner with a single beam, to points at z = 0.

    As the message's definition demands, ranges outside `range_min` to `range_max` are left out.
    """
    ranges = np.asarray(message.ranges, float)
    with np.errstate(invalid="ignore", over="ignore"):  # a damaged message may contain any number
        angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
        columns = [ranges * np.cos(angles), ranges * np.sin(angles), np.zeros(len(ranges))]
        if len(message.intensities) == len(ranges):
            columns.append(message.intensities)
        valid = (message.range_min <= ranges) & (ranges <= message.range_max) & np.isfinite(ranges)
        return np.column_stack(columns)[valid].astype(np.float32)


def _decode_livox(data: bytes, is_ros1: bool) -> np.ndarray:
    """Convert the bytes of Livox's CustomMsg; the reflectivity ranges from 0 to 255.

    rosbags does not know this message. With its definition, rosbags would create an object for each
    point, and need half a second for a scan.
    """
    order = "<" if is_ros1 or data[1] & 1 else ">"

    def number_at(offset: int) -> int:
        return int(np.frombuffer(data, f"{order}u4", 1, offset)[0])

    # The frame's name starts at byte 16, after its length. The fields timebase, point_num, lidar_id
    # and rsvd follow, then the number of points. ROS 2 aligns numbers, counted from byte 4.
    fields = 16 + number_at(12)
    step = LIVOX_POINT.itemsize
    if not is_ros1:
        fields += -(fields - 4) % 8
        step += -step % 4
    kind = LIVOX_POINT.newbyteorder(order)
    points = np.ndarray(number_at(fields + 16), kind, data, fields + 20, step)
    return np.column_stack([points["xyz"], points["reflectivity"]]).astype(np.float32)


@cache
def _unpacker(is_ros1: bool) -> Callable[[bytes, str], Any]:
    """Return the function that unpacks ROS 1 or ROS 2 messages.

    The messages with points are the same in all releases of one ROS generation.
    """
    from rosbags.typesys import Stores, get_typestore

    if is_ros1:
        return get_typestore(Stores.ROS1_NOETIC).deserialize_ros1
    return get_typestore(Stores.LATEST).deserialize_cdr
