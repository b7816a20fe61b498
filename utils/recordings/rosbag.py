"""Clouds from ROS recordings, without ROS: .bag files, .db3 and .mcap files and their folders.

The `rosbags` library reads the recordings; this module decodes their PointCloud2 messages.
https://docs.ros.org/en/noetic/api/sensor_msgs/html/msg/PointCloud2.html
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from utils.clouds.errors import CloudFileError, excerpt, file_error, listing, missing_file_error
from utils.clouds.pcd_header import cloud_fields

if TYPE_CHECKING:
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2

MESSAGE = "sensor_msgs/msg/PointCloud2"
KINDS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
SUFFIXES = (".bag", ".db3", ".mcap")


@dataclass(frozen=True, eq=False)
class Bag(Sequence):
    """A lazy sequence of the clouds of one topic of a recording; each access reads one message.

    Attributes
    ----------
    path : Path
        A file, or the folder of a ROS 2 recording.
    topic : str
    timestamps : ndarray, shape (number of messages,), int64
        Recording time of each message, in nanoseconds since 1970.
    repeats : ndarray, shape (number of messages,), int64
        Number of earlier messages with the same timestamp.
    """

    path: Path
    topic: str
    timestamps: np.ndarray
    repeats: np.ndarray

    @property
    def times(self) -> np.ndarray:
        """Seconds since the first message, shape (number of messages,)."""
        return (self.timestamps - self.timestamps[:1]) / 1e9

    def __len__(self) -> int:
        return len(self.timestamps)

    def __getitem__(self, index: int | slice) -> np.ndarray | Bag:
        """Read cloud `index`, or return a lazy sequence for a slice."""
        if isinstance(index, slice):
            return Bag(self.path, self.topic, self.timestamps[index], self.repeats[index])
        index = range(len(self))[index]
        with _open_reader(self.path) as reader:
            return self._read(reader, index)

    def __iter__(self) -> Iterator[np.ndarray]:
        with _open_reader(self.path) as reader:
            for index in range(len(self)):
                yield self._read(reader, index)

    def _read(self, reader: Reader1 | Reader2, index: int) -> np.ndarray:
        time = int(self.timestamps[index])
        connections = [
            connection for connection in reader.connections if connection.topic == self.topic
        ]
        messages = reader.messages(connections, start=time, stop=time + 1)
        for repeat, (_, _, data) in enumerate(messages):
            if repeat == self.repeats[index]:
                message = _unpacker(1 if self.path.suffix == ".bag" else 2)(data, MESSAGE)
                return decode_message(message, f"{self.path.name}, topic {self.topic}", index)
        raise file_error(
            self.path,
            f"message {index}",
            "the message no longer exists",
            "The file was changed while it was open. Open it again.",
        )


def read_bag(path: str | os.PathLike, topic: str | None = None) -> Bag:
    """Open the point clouds of a ROS recording as a lazy sequence.

    Opening reads the timestamps of all messages; a cloud is decoded when it is accessed.

    Parameters
    ----------
    path : str or path
        A ROS 1 .bag, a ROS 2 .db3 or .mcap, or the folder of a ROS 2 recording.
    topic : str, optional
        A PointCloud2 topic; required if the recording has several.

    Returns
    -------
    Bag
        A sequence of clouds (n, 3) or (n, 4) with `timestamps`.

    Raises
    ------
    CloudFileError
        The file is missing, damaged or not a recording, or it lacks the topic.
    """
    path = Path(path)
    if not path.exists():
        raise missing_file_error(path.name, [path.parent], SUFFIXES)
    with _open_reader(path) as reader:
        topics = sorted(
            {connection.topic for connection in reader.connections if connection.msgtype == MESSAGE}
        )
        if not topics:
            others = (
                listing(sorted({connection.topic for connection in reader.connections}))
                or "nothing"
            )
            raise file_error(path, "", f"there is no topic of type PointCloud2, only {others}")
        if topic is None and len(topics) > 1 or topic not in (None, *topics):
            raise file_error(
                path,
                "",
                f"the topics with clouds are {listing(topics)}",
                f'Choose one of them, for instance topic="{topics[0]}".',
            )
        topic = topic or topics[0]
        connections = [connection for connection in reader.connections if connection.topic == topic]
        seen: dict[int, int] = {}
        timestamps, repeats = [], []
        for _, time, _ in reader.messages(connections):
            timestamps.append(time)
            repeats.append(seen.get(time, 0))
            seen[time] = repeats[-1] + 1
        return Bag(path, topic, np.array(timestamps, np.int64), np.array(repeats, np.int64))


def decode_message(message: Any, name: str, number: int = 0) -> np.ndarray:
    """Convert a PointCloud2 message to a cloud.

    Parameters
    ----------
    message : object
        An object with the attributes of ``sensor_msgs/PointCloud2``. Fields may be in any order,
        points and rows may be padded, and either byte order is accepted.
    name, number : str, int
        Origin and index of the message, shown in errors.

    Returns
    -------
    ndarray, shape (n, 3) or (n, 4)
        float32, or float64 if a field is a double or a long integer.

    Raises
    ------
    CloudFileError
        x, y or z is missing, or the layout does not fit the data.
    """
    place = f"message {number}"
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
    order = ">" if message.is_bigendian else "<"
    kinds = [np.dtype(order + KINDS[fields[field].datatype]) for field in wanted]
    precision = np.result_type(np.float32, *kinds)
    height, width, step = message.height, message.width, message.point_step
    if height * width == 0:
        return np.empty((0, len(wanted)), precision)
    # Some drivers omit `row_step` for a single row.
    row_step = step * width if height == 1 else message.row_step
    ends = [fields[field].offset + kind.itemsize for field, kind in zip(wanted, kinds, strict=True)]
    if (
        max(ends) > step
        or step * width > row_step
        or (row_step * (height - 1) + step * width > len(message.data))
    ):
        raise file_error(
            name,
            place,
            f"the message announces {height} x {width} points of {step} bytes, but contains "
            f"{len(message.data)} bytes",
            "Was the recording cut off?",
        )
    cloud = np.empty((height, width, len(wanted)), precision)
    data = np.ascontiguousarray(message.data)
    for index, (field, kind) in enumerate(zip(wanted, kinds, strict=True)):
        cloud[:, :, index] = np.ndarray(
            (height, width), kind, data, fields[field].offset, (row_step, step)
        )
    return cloud.reshape(-1, len(wanted))


@contextmanager
def _open_reader(path: Path) -> Iterator[Reader1 | Reader2]:
    """Open a recording with the reader for its kind; every error names the file."""
    if path.suffix not in SUFFIXES and not path.is_dir():
        raise file_error(
            path,
            "",
            f"expected a file ending in {', '.join(SUFFIXES)} or the folder of a ROS 2 recording",
        )
    try:
        if path.suffix == ".bag":
            from rosbags.rosbag1 import Reader
        else:
            from rosbags.rosbag2 import Reader
    except ImportError:
        raise file_error(
            path,
            "",
            "reading ROS recordings needs the package rosbags",
            "Install it with: pip install rosbags",
        ) from None
    try:
        with Reader(_BoundedPath(path)) as reader:
            yield reader
    except CloudFileError:
        raise
    except Exception as error:  # rosbags passes on errors from struct, sqlite, lz4, yaml ...
        raise file_error(
            path,
            "",
            f"this is not an intact ROS recording ({excerpt(error, 80)})",
            "Was the file copied completely, and was the recording closed properly?",
        ) from None


@cache
def _unpacker(generation: int) -> Callable[[bytes, str], Any]:
    """Return the function that unpacks messages of ROS 1 or 2.

    PointCloud2 is the same in all releases of one ROS generation.
    """
    from rosbags.typesys import Stores, get_typestore

    if generation == 1:
        return get_typestore(Stores.ROS1_NOETIC).deserialize_ros1
    return get_typestore(Stores.LATEST).deserialize_cdr


class _BoundedPath(type(Path())):
    """A path whose files never read, and so never allocate, more bytes than they contain.

    A damaged recording may contain any length, and rosbags requests that many bytes.
    """

    def open(self, mode: str = "r", *arguments: Any, **options: Any) -> IO[Any]:
        if mode != "rb":
            return super().open(mode, *arguments, **options)
        return _BoundedFile(io.FileIO(self, "rb"))


class _BoundedFile(io.BufferedReader):
    def read(self, size: int | None = -1) -> bytes:
        remaining = max(os.fstat(self.fileno()).st_size - self.tell(), 0)
        return super().read(remaining if size is None or size < 0 else min(size, remaining))
