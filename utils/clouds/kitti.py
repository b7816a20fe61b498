"""KITTI's Velodyne scans: files of float32 records x y z reflectance without a header."""

import numpy as np

from utils.clouds.errors import excerpt, file_error

RECORD = 16  # bytes of one point
PRINTABLE = frozenset(b"\t\n\r" + bytes(range(32, 127)))


def decode_kitti(data: bytes, name: str = "cloud.bin") -> np.ndarray:
    """Read a cloud from the bytes of a KITTI ``.bin`` file.

    Returns
    -------
    ndarray, shape (n, 4), float32
        x y z in metres and reflectance 0..1. An empty file gives an empty cloud.

    Raises
    ------
    CloudFileError
        The file is text, or ends in the middle of a point.
    """
    if data and PRINTABLE.issuperset(data[:512]):
        raise file_error(
            name,
            "byte 0",
            f"found the text {excerpt(data[:80].decode())}, expected binary points",
            "Give a text file the suffix .txt.",
        )
    if over := len(data) % RECORD:
        raise file_error(
            name,
            f"byte {len(data) - over}",
            f"{over} bytes are left after "
            f"{len(data) // RECORD} points of {RECORD} bytes (x y z reflectance as "
            "float32)",
            "Was the file copied completely, and is it a KITTI scan?",
        )
    return np.frombuffer(data, "<f4").reshape(-1, 4).astype(np.float32)


def encode_kitti(cloud: np.ndarray) -> bytes:
    """Encode a cloud as KITTI records; a missing intensity becomes 0."""
    records = np.zeros((len(cloud), 4), "<f4")
    records[:, : cloud.shape[1]] = cloud
    return records.tobytes()
