"""Named data sets: the course's cloud, simulated sequences, recordings from the internet."""

from __future__ import annotations

import hashlib
import io
import json
import os
import tempfile
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from utils.clouds import SUFFIXES, CloudFileError, read_cloud
from utils.clouds.errors import missing_file_error, write_bytes
from utils.progress import progress
from utils.recordings import Recording

if TYPE_CHECKING:
    from utils.simulator.frames import Frame

DATA = Path(__file__).resolve().parent.parent / "data"
SCENES = {"highway": "highway", "city": "city_block", "cyclist": "cyclist"}


def load_cloud(name: str | os.PathLike = "cloud.txt") -> np.ndarray:
    """Load the course's point cloud or one of your own files.

    Parameters
    ----------
    name : str or path
        A path relative to the working folder or, if it does not exist there, to the project's
        ``data`` folder. The file may have any format that `utils.clouds.read_cloud` reads. If both
        folders contain the file, a sentence says which of them is read.

    Returns
    -------
    ndarray, shape (n, 3) or (n, 4)
        x forward, y left, z up in metres, with the sensor at the origin; then intensity.

    Raises
    ------
    CloudFileError
        The file is in neither folder or is malformed; the message gives the next step.
    """
    path = Path(name).expanduser()
    # An absolute path overrides the folder.
    found = [file for file in (Path.cwd() / path, DATA / path) if os.path.exists(file)]
    if not found:
        raise missing_file_error(path, [Path.cwd(), DATA], SUFFIXES)
    if len(found) == 2 and not os.path.samefile(*found):
        print(f"Reading {found[0]}, not the course's file of the same name.")
    return read_cloud(found[0])


def load_street() -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Load the course's scan and its ground truth.

    The truth belongs to this scan only. If ``data/cloud.txt`` is another scan, a sentence says so,
    and the course's scan is simulated again.

    Returns
    -------
    cloud : ndarray, shape (115451, 4)
        x forward, y left, z up in metres, with the sensor at the origin; then intensity.
    truth : dict of str to ndarray
        The arrays of ``cloud_truth.npz``, which ``data/README.md`` describes.
    """
    cloud, truth, is_simulated = course_street()
    if is_simulated:
        print(
            "data/cloud.txt is not the course's scan. This lesson compares a scan with its true "
            "labels, so it uses the course's scan. To read your own file, pass its path to "
            "load_cloud."
        )
    return cloud, truth


def course_street() -> tuple[np.ndarray, dict[str, np.ndarray], bool]:
    """Return what `load_street` returns, and whether it was simulated again; print nothing."""
    cloud, truth = _read_street(DATA)
    if len(cloud) == len(truth["classes"]):
        return cloud, truth, False
    from utils.simulator.scenes import write_lesson_cloud

    with tempfile.TemporaryDirectory() as folder:
        write_lesson_cloud(Path(folder))
        return *_read_street(Path(folder)), True


def _read_street(folder: Path) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    with np.load(folder / "cloud_truth.npz") as arrays:
        return read_cloud(folder / "cloud.txt"), dict(arrays)


def load_sequence(name: str = "city", seed: int = 0) -> Sequence:
    """Load a simulated sequence; the first call simulates its frames, later calls use the cache.

    Parameters
    ----------
    name : {"highway", "city", "cyclist"}
    seed : int
        Random seed for the street.

    Returns
    -------
    sequence of utils.simulator.frames.Frame
        A lazy sequence: each access reads a frame with ``cloud`` (n, 4), ``boxes``, ``time`` and
        the truth of every return in ``scan``. `utils.scenes` returns equal frames.

    Raises
    ------
    ValueError
        There is no sequence with this name.
    """
    if name not in SCENES:
        raise ValueError(f"There is no sequence {name!r}. Choose one of {', '.join(SCENES)}.")
    from utils import scenes

    stream = getattr(scenes, SCENES[name])(seed=seed)
    folder = cache_folder() / "sequences" / f"{name}-{seed}-{_simulator_version()}"
    frames = CachedFrames(stream, folder, range(len(stream)))
    missing = [index for index in range(len(frames)) if not frames.path(index).exists()]
    for index in progress(missing, f"Simulating the sequence {name}") if missing else ():
        if not _write_frame(stream[index], frames.path(index)):
            break  # the disk is full or read-only, so frames are simulated on access
    return frames


def fetch_recording(name: str) -> Recording:
    """Open a real recording; the first call downloads it, and resumes an interrupted download.

    The recordings are not part of this project. Their licence is shown before the first download.

    Parameters
    ----------
    name : {"udacity_city", "udacity_cyclist", "kitti_0002", "kitti_0005"}
        Name of the recording.

    Returns
    -------
    utils.recordings.Recording
        A lazy sequence of frames with ``cloud`` (n, 4), ``boxes`` (KITTI only) and ``time``.

    Raises
    ------
    ValueError
        There is no recording with this name.
    utils.recordings.download.DownloadError
        There is no connection, or the files are not the expected ones.
    """
    from utils.recordings.sources import fetch

    return fetch(name, cache_folder() / "recordings")


def cache_folder() -> Path:
    """Return the folder of cached data: ``LIDAR_LAB_CACHE``, or the user's cache folder."""
    if folder := os.environ.get("LIDAR_LAB_CACHE"):
        return Path(folder).expanduser()
    import platformdirs  # pooch has the same function, but Colab may lack pooch

    return Path(platformdirs.user_cache_dir("lidar-obstacle-lab"))


@dataclass(frozen=True)
class CachedFrames(Sequence):
    """A lazy sequence of frames cached in files; a missing or damaged frame is simulated again.

    Attributes
    ----------
    stream : sequence of utils.simulator.frames.Frame
        Source that simulates the frames.
    folder : Path
        Folder with one file per frame.
    numbers : range
        Indices of these frames in the stream.
    """

    stream: Sequence
    folder: Path
    numbers: range

    def __len__(self) -> int:
        return len(self.numbers)

    def __getitem__(self, index: int | slice) -> Frame | CachedFrames:
        """Read frame `index`, or return a lazy sequence for a slice."""
        if isinstance(index, slice):
            return CachedFrames(self.stream, self.folder, self.numbers[index])
        path = self.path(index)
        try:
            return _read_frame(path)
        except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error):
            frame = self.stream[self.numbers[index]]
            _write_frame(frame, path)
            return frame

    def path(self, index: int) -> Path:
        """Return the file of frame `index`."""
        return self.folder / f"{self.numbers[index]:04d}.npz"


def _simulator_version() -> str:
    """Return a hash of the simulator's code, so that a change to the code invalidates the cache."""
    folder = Path(__file__).parent / "simulator"
    code = b"".join(path.read_bytes() for path in sorted(folder.glob("*.py")))
    return hashlib.sha256(code).hexdigest()[:12]


def _write_frame(frame: Frame, path: Path) -> bool:
    """Write a frame to the cache; return whether this succeeded."""
    buffer = io.BytesIO()
    truth = {"time": frame.time, "boxes": [asdict(box) for box in frame.boxes]}
    arrays = {field.name: getattr(frame.scan, field.name) for field in fields(frame.scan)}
    np.savez_compressed(buffer, truth=np.array(json.dumps(truth)), **arrays)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, buffer.getvalue())
    except (OSError, CloudFileError):
        return False
    return True


def _read_frame(path: Path) -> Frame:
    """Read a frame that `_write_frame` wrote."""
    from utils.boxes import Box
    from utils.simulator import Scan
    from utils.simulator.frames import Frame

    with np.load(path, allow_pickle=False) as arrays:
        truth = json.loads(str(arrays["truth"]))
        scan = Scan(**{field.name: arrays[field.name] for field in fields(Scan)})
    boxes = (
        Box(
            **{
                key: tuple(value) if isinstance(value, list) else value
                for key, value in box.items()
            }
        )
        for box in truth["boxes"]
    )
    return Frame(scan=scan, boxes=tuple(boxes), time=truth["time"])
