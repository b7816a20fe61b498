"""Read an unpacked drive of KITTI's raw data: scans, times and tracklets."""

import codecs
import os
import xml.etree.ElementTree as ElementTree
from datetime import datetime
from pathlib import Path

import numpy as np

from utils.boxes import Box
from utils.clouds.errors import excerpt, file_error, listing, read_bytes
from utils.clouds.sequence import CloudFolder, read_sequence
from utils.recordings.kitti_labels import UNKNOWN
from utils.recordings.recording import Recording


def read_kitti_raw(folder: str | os.PathLike) -> Recording:
    """Open a drive of KITTI's raw data.

    Parameters
    ----------
    folder : str or path
        The drive's folder, for instance ``2011_09_26/2011_09_26_drive_0005_sync``. It contains
        ``velodyne_points`` and, if you downloaded the tracklets, ``tracklet_labels.xml``.

    Returns
    -------
    Recording
        Frames with cloud (n, 4), boxes and time. Boxes are in the scanner's coordinates; their
        identity is the tracklet's number. Their velocity is NaN, because KITTI does not label it.

    Raises
    ------
    CloudFileError
        The drive does not exist, or one of its files is malformed.
    """
    folder = Path(folder)
    scans = folder / "velodyne_points" / "data"
    if not scans.is_dir():
        there = listing(sorted(entry.name for entry in folder.iterdir())) if folder.is_dir() else ""
        raise file_error(
            folder,
            "",
            f"there is no folder {scans.absolute()}",
            f"Pass the folder of one drive. This folder contains: {there or 'no files'}.",
        )
    clouds = read_sequence(scans)  # .bin, or .txt in KITTI's unsynchronised drives
    numbers = _frame_numbers(clouds)
    boxes = ()
    tracklets = folder / "tracklet_labels.xml"
    if tracklets.exists():
        labelled = read_tracklets(tracklets)
        boxes = tuple(labelled.get(number, ()) for number in numbers)
    times = _times(folder / "velodyne_points" / "timestamps.txt", numbers)
    return Recording(clouds, times, boxes)


def read_tracklets(path: str | os.PathLike) -> dict[int, tuple]:
    """Read the boxes of a drive from ``tracklet_labels.xml``.

    Returns
    -------
    dict of int to tuple of utils.boxes.Box
        The boxes of each frame that has any, by the number in the scan's file name. They are in
        sensor coordinates; ``returns`` is 0, and a `Recording` counts the returns on access.

    Raises
    ------
    CloudFileError
        The file is not XML, or not a list of tracklets.
    """
    path = Path(path)
    data = read_bytes(path, (".xml",))
    if b"<!ENTITY" in data:  # nested entities can fill the memory; KITTI's files have none
        raise file_error(path, "", "the file defines XML entities, which no KITTI file does")
    boxes: dict[int, tuple] = {}
    try:
        for identity, item in enumerate(ElementTree.fromstring(data).findall("tracklets/item")):
            size = _numbers(item, "l", "w", "h")
            first = int(_numbers(item, "first_frame")[0])
            kind = item.findtext("objectType", "").strip().lower()
            for frame, pose in enumerate(item.findall("poses/item"), first):
                x, y, z, yaw = _numbers(pose, "tx", "ty", "tz", "rz")
                box = Box(
                    centre=(x, y, z + size[2] / 2),  # KITTI gives the centre of the bottom face
                    size=size,
                    yaw=yaw,
                    kind=kind,
                    identity=identity,
                    velocity=UNKNOWN,
                    returns=0,
                )
                boxes[frame] = (*boxes.get(frame, ()), box)
    except (ElementTree.ParseError, ValueError, OverflowError) as error:
        raise file_error(
            path,
            "",
            f"these are not KITTI tracklets ({excerpt(error, 80)})",
            "Unpack the drive's tracklets again, or delete the file.",
        ) from None
    return boxes


def _numbers(item: ElementTree.Element, *names: str) -> tuple[float, ...]:
    """Parse the named children of an element as finite numbers."""
    texts = [item.findtext(name) for name in names]
    if None in texts:
        raise ValueError(f"<{names[texts.index(None)]}> is missing")
    numbers = tuple(map(float, texts))
    if not np.isfinite(numbers).all():
        raise ValueError(f"{' '.join(texts)} are not finite numbers")
    return numbers


def _frame_numbers(clouds: CloudFolder) -> list[int]:
    """Return the frame numbers in the file names; some drives lack a few scans."""
    for path in clouds.paths:
        if not (path.stem.isascii() and path.stem.isdecimal()):
            raise file_error(path, "", "the name must be a frame number, as in 0000000000.bin")
    return [int(path.stem) for path in clouds.paths]


def _times(path: Path, numbers: list[int]) -> np.ndarray:
    """Return the time of each scan in seconds since the first; without the file, assume 10 Hz."""
    if not path.exists():
        return (np.array(numbers) - numbers[0]) / 10
    lines = read_bytes(path).removeprefix(codecs.BOM_UTF8).decode("latin-1").split("\n")
    seconds = []
    for number in numbers:
        text = lines[number].strip() if number < len(lines) else ""
        try:
            moment, _, fraction = text.partition(".")  # nine digits, too many for datetime
            start_of_second = datetime.fromisoformat(f"{moment}+00:00").timestamp()
            seconds.append(start_of_second + float(f"0.{fraction or 0}"))
        except ValueError:
            raise file_error(
                path,
                f"line {number + 1}",
                f"found {excerpt(text)}, expected the date and time of frame {number}",
                "Unpack the drive again.",
            ) from None
    return np.array(seconds) - seconds[0]
