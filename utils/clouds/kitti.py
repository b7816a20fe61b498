"""KITTI's and nuScenes' scans: files of float32 records without a header.

KITTI stores x y z reflectance, nuScenes x y z intensity and the number of the beam. Other data sets
use the same suffix for other records, so a file is accepted only if its numbers look like a scan.
"""

import numpy as np

from utils.clouds.errors import PRINTABLE, CloudFileError, excerpt, file_error

KITTI_COLUMNS = 4
NUSCENES_COLUMNS = 5
LARGEST = 1e6  # metres; random bytes give larger numbers
SMALLEST = 1e-12  # metres; whole numbers that are read as float32 give smaller ones
TOLERATED = 0.05  # share of numbers that may look wrong
MAX_BEAMS = 256
FEWEST_POINTS = 16  # fewer points do not show what the columns are
OTHER_RECORDS = (("<f4", 3), ("<f4", 5), ("<f4", 6), ("<f8", 4), ("<f8", 3), (">f4", 4))


def decode_kitti(data: bytes, name: str = "cloud.bin") -> np.ndarray:
    """Read a cloud from the bytes of a ``.bin`` file of KITTI or nuScenes.

    Returns
    -------
    ndarray, shape (n, 4), float32
        x y z in metres, and reflectance 0..1 (KITTI) or intensity 0..255 (nuScenes). An empty file
        gives an empty cloud.

    Raises
    ------
    CloudFileError
        The file is text, ends in the middle of a point, or contains other records.
    """
    if data and PRINTABLE.issuperset(data[:512]):
        raise file_error(
            name,
            "byte 0",
            f"found the text {excerpt(data[:80].decode())}, expected binary points",
            "Give a text file the suffix .txt.",
        )
    if (rows := _records(data, "<f4", NUSCENES_COLUMNS)) is not None and (
        name.lower().endswith(".pcd.bin") or (_is_scan(rows) and _are_beams(rows[:, 4]))
    ):
        return rows[:, :4].astype(np.float32)
    rows = _records(data, "<f4", KITTI_COLUMNS)
    if rows is not None and (len(rows) < FEWEST_POINTS or _is_scan(rows)):
        return rows.astype(np.float32)
    raise _wrong_records_error(data, rows, name)


def encode_kitti(cloud: np.ndarray) -> bytes:
    """Encode a cloud as KITTI records; a missing intensity becomes 0."""
    records = np.zeros((len(cloud), KITTI_COLUMNS), "<f4")
    records[:, : cloud.shape[1]] = cloud
    return records.tobytes()


def _records(data: bytes, kind: str, columns: int) -> np.ndarray | None:
    """Return the data as records of `columns` numbers, or None if the last one is incomplete."""
    if len(data) % (np.dtype(kind).itemsize * columns):
        return None
    return np.frombuffer(data, kind).reshape(-1, columns)


def has_plausible_sizes(coordinates: np.ndarray) -> bool:
    """Return whether nearly all coordinates are 0 or have the size of metres on Earth.

    Bytes that are read as numbers of another kind or byte order have far larger or smaller sizes.
    """
    with np.errstate(invalid="ignore"):
        size = np.abs(coordinates)
        odd = (size > LARGEST) | ((size > 0) & (size < SMALLEST))
    return bool(odd.mean() <= TOLERATED)


def _is_scan(rows: np.ndarray) -> bool:
    """Return whether nearly all numbers are plausible and nearly no intensity is negative."""
    if len(rows) < FEWEST_POINTS or not has_plausible_sizes(rows[:, :4]):
        return False
    with np.errstate(invalid="ignore"):
        return rows.shape[1] < 4 or bool((rows[:, 3] < 0).mean() <= TOLERATED)


def _are_beams(column: np.ndarray) -> bool:
    """Return whether a column contains only beam numbers, from at least two beams."""
    with np.errstate(invalid="ignore"):
        whole = (column >= 0) & (column < MAX_BEAMS) & (column % 1 == 0)
    return bool(whole.all()) and len(np.unique(column)) > 1


def _wrong_records_error(data: bytes, rows: np.ndarray | None, name: str) -> CloudFileError:
    """Build the error for a file that does not contain KITTI's records."""
    scans = {}
    for kind, columns in OTHER_RECORDS:
        other = _records(data, kind, columns)
        if other is not None and _is_scan(other):
            scans[kind, columns] = _spread(other)
    if scans:
        kind, columns = min(scans, key=scans.get)
        return file_error(
            name,
            "",
            "the numbers are not a KITTI scan of x y z reflectance as float32; they look like "
            f"{columns} columns of {np.dtype(kind).name}"
            f"{' in big-endian order' if kind[0] == '>' else ''}",
            f"If so, read the file with np.fromfile(path, {kind!r}).reshape(-1, {columns}).",
        )
    if rows is not None:
        return file_error(
            name,
            "",
            "the numbers are not a KITTI scan of x y z reflectance as float32; too many are "
            f"negative intensities, or coordinates above {LARGEST:.0e} m or below {SMALLEST:.0e} m",
            "If you know the format, read the file with np.fromfile.",
        )
    over = len(data) % (4 * KITTI_COLUMNS)
    return file_error(
        name,
        f"byte {len(data) - over}",
        f"{over} bytes are left after {len(data) // (4 * KITTI_COLUMNS)} points of 16 bytes "
        "(x y z reflectance as float32)",
        "Was the file copied completely, and is it a KITTI scan?",
    )


def _spread(rows: np.ndarray) -> float:
    """Return the mean logarithm of the columns' standard deviations.

    It is smallest for the true number of columns, because a wrong number mixes coordinates with
    intensities. It is rounded so that twice the true number does not win by chance.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        deviations = np.nanstd(rows.astype(np.float64), axis=0)
    return round(float(np.log(deviations + SMALLEST).mean()), 1)
