"""Real recordings that the course can use but does not ship: their addresses and licences."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from utils.clouds.sequence import read_sequence
from utils.progress import progress
from utils.recordings.download import DownloadError, download, unpack
from utils.recordings.kitti_raw import read_kitti_raw
from utils.recordings.recording import Recording

KITTI = "https://s3.eu-central-1.amazonaws.com/avg-kitti/raw_data"
UDACITY = (
    "https://raw.githubusercontent.com/udacity/SFND_Lidar_Obstacle_Detection/"
    "ef15da2bc172359e7d6edfdd156a2a243d10977e/src/sensors/data/pcd"
)
CHECKSUMS = Path(__file__).parent / "checksums.json"
"""SHA-256 of each frame in these folders at this commit, by the name of the recording."""

LICENCE = (
    "Recorded by the KITTI project (Geiger, Lenz, Stiller and Urtasun, IJRR 2013; "
    "www.cvlibs.net/datasets/kitti) and published under CC BY-NC-SA 3.0: use it only for "
    "non-commercial purposes, name the authors, and share it only under the same terms."
)


@dataclass(frozen=True)
class RecordingSource:
    """A recording on the internet.

    Attributes
    ----------
    address : str
        Base address to which the file names are appended.
    files : dict of str to str or None
        SHA-256 of each file by name; None if it is unknown.
    read : callable
        Opens the folder with the unpacked files.
    about : str
        Description of the recording.
    licence : str
        Terms of use, shown before the first download.
    """

    address: str
    files: dict[str, str | None]
    read: Callable[[Path], Recording]
    about: str
    licence: str = LICENCE


def _source_of_frames(name: str, folder: str, about: str) -> RecordingSource:
    """Return the source of a folder of numbered PCD files recorded at 10 Hz."""
    checksums = json.loads(CHECKSUMS.read_text())[name]
    files = {f"{number:010d}.pcd": checksum for number, checksum in enumerate(checksums)}
    return RecordingSource(f"{UDACITY}/{folder}", files, _read_frames, about)


def _read_frames(folder: Path) -> Recording:
    clouds = read_sequence(folder, ".pcd")
    return Recording(clouds, np.arange(len(clouds)) / 10)


def _source_of_drive(day: str, number: str, about: str) -> RecordingSource:
    """Return the source of a drive of KITTI's raw data, with its calibration and tracklets."""
    drive = f"{day}_drive_{number}"
    names = (f"{day}_calib.zip", f"{drive}/{drive}_tracklets.zip", f"{drive}/{drive}_sync.zip")
    return RecordingSource(
        KITTI,
        dict.fromkeys(names),
        lambda folder: read_kitti_raw(folder / day / f"{drive}_sync"),
        about,
    )


SOURCES = {
    "udacity_city": _source_of_frames(
        "udacity_city", "data_1", "22 frames of a street with parked cars, 42 MB"
    ),
    "udacity_cyclist": _source_of_frames(
        "udacity_cyclist", "data_2", "154 frames behind a cyclist, 301 MB"
    ),
    "kitti_0002": _source_of_drive("2011_09_26", "0002", "77 labelled frames in the city"),
    "kitti_0005": _source_of_drive("2011_09_26", "0005", "154 labelled frames behind a cyclist"),
}


def fetch(name: str, cache: Path) -> Recording:
    """Open a recording, downloading the files that are not yet in the cache.

    Parameters
    ----------
    name : str
        A key of `SOURCES`.
    cache : Path
        Folder in which each recording has a subfolder.

    Raises
    ------
    ValueError
        There is no recording with this name.
    DownloadError
        A file cannot be downloaded, or the cache cannot be written.
    """
    if name not in SOURCES:
        known = "; ".join(f"{key!r} ({source.about})" for key, source in SOURCES.items())
        raise ValueError(f"There is no recording {name!r}. Choose one of {known}.")
    source = SOURCES[name]
    folder = cache / name
    complete = folder / ".complete"  # written last, so if it is missing the download resumes
    if not complete.exists():
        print(f"{name}: {source.about}. {source.licence}")
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise DownloadError(
                f"{name} cannot be saved ({error}). Set LIDAR_LAB_CACHE to a folder that you may "
                "write to, and run this again."
            ) from None
        for file, checksum in progress(source.files.items(), f"Fetching {name}"):
            path = folder / Path(file).name
            download(f"{source.address}/{file}", path, checksum)
            if path.suffix == ".zip":
                unpack(path, folder, lambda member: not member.endswith(".png"))
        complete.touch()
        for archive in folder.glob("*.zip"):  # large, with mostly camera images
            archive.unlink()
    return source.read(folder)
