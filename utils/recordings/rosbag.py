"""Clouds from ROS recordings, without ROS: .bag files, .db3 and .mcap files and their folders.

The `rosbags` library reads the recordings, and `utils.recordings.messages` decodes their messages.
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from utils.clouds.errors import CloudFileError, excerpt, file_error, listing, missing_file_error
from utils.clouds.signatures import refuse_other_content
from utils.recordings.messages import MESSAGES, decode_message

if TYPE_CHECKING:
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2

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
        connections = _connections(reader, self.topic)
        messages = reader.messages(connections, start=time, stop=time + 1)
        for repeat, (connection, _, data) in enumerate(messages):
            if repeat == self.repeats[index]:
                place = f"topic {self.topic}, message {index}"
                return decode_message(
                    data, connection.msgtype, _is_ros1(self.path), self.path.name, place
                )
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
        A topic with points: PointCloud2, CustomMsg of Livox, or LaserScan. Required if the
        recording has several topics with the first of these types that it contains.

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
        topic = _chosen_topic(reader, path, topic)
        connections = _connections(reader, topic)
        seen: dict[int, int] = {}
        timestamps, repeats = [], []
        for _, time, _ in reader.messages(connections):
            timestamps.append(time)
            repeats.append(seen.get(time, 0))
            seen[time] = repeats[-1] + 1
        return Bag(path, topic, np.array(timestamps, np.int64), np.array(repeats, np.int64))


def _chosen_topic(reader: Reader1 | Reader2, path: Path, topic: str | None) -> str:
    """Return the wanted topic, or the only one with the most useful type of message."""
    kinds = {
        connection.topic: MESSAGES.index(connection.msgtype) for connection in _connections(reader)
    }
    if not kinds:
        others = {
            f"{connection.topic} ({connection.msgtype.rpartition('/')[2]})"
            for connection in reader.connections
        }
        found = listing(sorted(others)) or "nothing"
        raise file_error(
            path,
            "",
            f"there is no topic of type PointCloud2, CustomMsg or LaserScan, only {found}",
            "Record the points as PointCloud2, the message type that most drivers publish.",
        )
    best = [name for name, kind in kinds.items() if kind == min(kinds.values())]
    if topic is None and len(best) == 1:
        return best[0]
    if topic not in kinds:
        raise file_error(
            path,
            "",
            f"the topics with clouds are {listing(sorted(kinds))}",
            f'Choose one of them, for instance topic="{min(best)}".',
        )
    return topic


def _connections(reader: Reader1 | Reader2, topic: str | None = None) -> list[Any]:
    """Return the connections of a topic, or of all topics, that carry points."""
    return [
        connection
        for connection in reader.connections
        if connection.msgtype in MESSAGES and topic in (None, connection.topic)
    ]


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
        opened = _open_folder(Reader, path) if path.is_dir() else _open(Reader, path)
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


def _open(reader: type, path: Path) -> Reader1 | Reader2:
    opened = reader(_RecordingPath(path))
    opened.open()
    return opened


def _open_folder(reader: type, folder: Path) -> Reader2:
    """Open a recording's folder, or its only file if the metadata are missing or wrong."""
    try:
        return _open(reader, folder)
    except Exception:  # rosbags passes on errors from yaml
        files = [file for file in folder.iterdir() if file.suffix.lower() in (".db3", ".mcap")]
        if len(files) != 1:
            raise
        return _open(reader, files[0])


class _RecordingPath(type(Path())):
    """A path whose open file never reads, or allocates memory for, more bytes than it contains.

    A damaged recording may contain any length, and rosbags requests that many bytes. The suffix is
    in lower case, because rosbags does not recognise capitals.
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
