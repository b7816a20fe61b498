"""Clouds from ROS recordings, without ROS: .bag files, .db3 and .mcap files and their folders.

The `rosbags` library reads the recordings; this module decodes their PointCloud2 messages.
https://docs.ros.org/en/noetic/api/sensor_msgs/html/msg/PointCloud2.html
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from utils.clouds.errors import CloudFileError, excerpt, file_error, listing, missing_file_error
from utils.clouds.kitti import has_plausible_sizes
from utils.clouds.pcd_header import cloud_fields
from utils.clouds.signatures import refuse_other_content

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
                message = _unpacker(1 if _is_ros1(self.path) else 2)(data, MESSAGE)
                place = f"topic {self.topic}, message {index}"
                return decode_message(message, self.path.name, place)
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
            others = {
                f"{connection.topic} ({connection.msgtype.rpartition('/')[2]})"
                for connection in reader.connections
            }
            found = listing(sorted(others)) or "nothing"
            raise file_error(
                path,
                "",
                f"there is no topic of type PointCloud2, only {found}",
                "Record the points as PointCloud2, the message of most scanners' drivers.",
            )
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


def decode_message(message: Any, name: str, place: str = "message 0") -> np.ndarray:
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
    if height * width and (
        end > message.point_step
        or message.point_step * width > row_step
        or row_step * (height - 1) + message.point_step * width > len(message.data)
    ):
        raise file_error(
            name,
            place,
            f"the message announces {message.height} x {message.width} points of "
            f"{message.point_step} bytes, but contains {len(message.data)} bytes",
            "Was the recording cut off?",
        )
    data = np.ascontiguousarray(message.data)

    def decode(order: str) -> np.ndarray:
        precision = np.result_type(np.float32, *kinds)
        cloud = np.empty((height, width, len(wanted)), precision)
        for index, (offset, kind) in enumerate(zip(offsets, kinds, strict=True)):
            cloud[:, :, index] = np.ndarray(
                shape, kind.newbyteorder(order), data, offset, (row_step, message.point_step)
            )
        return cloud.reshape(-1, len(wanted))

    if not height * width:
        return np.empty((0, len(wanted)), np.result_type(np.float32, *kinds))
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


@contextmanager
def _open_reader(path: Path) -> Iterator[Reader1 | Reader2]:
    """Open a recording with the reader for its kind; every error names the file."""
    if path.is_file():
        _check_file(path)
    elif not path.is_dir():
        raise missing_file_error(path.name, [path.parent], SUFFIXES)
    try:
        if _is_ros1(path):
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
        opened = _opened_folder(Reader, path) if path.is_dir() else _opened(Reader, path)
        with closing(opened) as reader:
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


def is_recording_folder(path: Path) -> bool:
    """Return whether a folder contains the files of a ROS 2 recording."""
    return path.is_dir() and any(
        file.name == "metadata.yaml" or file.suffix.lower() in (".db3", ".mcap")
        for file in path.iterdir()
    )


def _check_file(path: Path) -> None:
    """Raise an error if the suffix or the first bytes show that a file is not a recording."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        advice = ""
        if suffix == ".active":
            advice = "The recording was not closed. Repair it with rosbag reindex, then rename it."
        raise file_error(
            path,
            "",
            f"expected a file ending in {', '.join(SUFFIXES)} or the folder of a ROS 2 recording",
            advice,
        )
    with path.open("rb") as file:
        refuse_other_content(file.read(512), path.name, suffix)


def _is_ros1(path: Path) -> bool:
    return path.suffix.lower() == ".bag" and not path.is_dir()


def _opened(reader: type, path: Path) -> Reader1 | Reader2:
    opened = reader(_RecordingPath(path))
    opened.open()
    return opened


def _opened_folder(reader: type, folder: Path) -> Reader2:
    """Open a recording's folder, or its only file if the metadata are missing or wrong."""
    try:
        return _opened(reader, folder)
    except Exception:  # rosbags passes on errors from yaml
        files = [file for file in folder.iterdir() if file.suffix.lower() in (".db3", ".mcap")]
        if len(files) != 1:
            raise
        return _opened(reader, files[0])


@cache
def _unpacker(generation: int) -> Callable[[bytes, str], Any]:
    """Return the function that unpacks messages of ROS 1 or 2.

    PointCloud2 is the same in all releases of one ROS generation.
    """
    from rosbags.typesys import Stores, get_typestore

    if generation == 1:
        return get_typestore(Stores.ROS1_NOETIC).deserialize_ros1
    return get_typestore(Stores.LATEST).deserialize_cdr


class _RecordingPath(type(Path())):
    """A path whose files never read, and so never allocate, more bytes than they contain.

    A damaged recording may contain any length, and rosbags requests that many bytes. The suffix is
    in small letters, because rosbags recognises no capitals.
    """

    @property
    def suffix(self) -> str:
        return super().suffix.lower()

    def open(self, mode: str = "r", *arguments: Any, **options: Any) -> IO[Any]:
        if mode != "rb":
            return super().open(mode, *arguments, **options)
        return _BoundedFile(io.FileIO(self, "rb"))


class _BoundedFile(io.BufferedReader):
    def read(self, size: int | None = -1) -> bytes:
        remaining = max(os.fstat(self.fileno()).st_size - self.tell(), 0)
        return super().read(remaining if size is None or size < 0 else min(size, remaining))
