"""File formats by suffix, and the two functions that most callers need."""

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from utils.clouds.errors import CloudFileError, file_error, read_bytes, write_bytes
from utils.clouds.kitti import decode_kitti, encode_kitti
from utils.clouds.libraries import decode_las, decode_ply
from utils.clouds.npz import decode_npy, decode_npz, encode_npy, encode_npz
from utils.clouds.pcd import decode_pcd, encode_pcd
from utils.clouds.signatures import refuse_other_content
from utils.clouds.text import decode_text, encode_text


class Format(NamedTuple):
    """Functions that decode and encode a file format; `encode` is None if it is read-only."""

    decode: Callable[[bytes, str], np.ndarray]
    encode: Callable[[np.ndarray], bytes] | None


FORMATS = {
    ".txt": Format(decode_text, encode_text),
    ".xyz": Format(decode_text, encode_text),
    ".asc": Format(decode_text, encode_text),
    ".pts": Format(decode_text, encode_text),
    ".csv": Format(decode_text, partial(encode_text, separator=",")),
    ".bin": Format(decode_kitti, encode_kitti),
    ".pcd": Format(decode_pcd, encode_pcd),
    ".npz": Format(decode_npz, encode_npz),
    ".npy": Format(decode_npy, encode_npy),
    ".ply": Format(decode_ply, None),
    ".las": Format(decode_las, None),
    ".laz": Format(decode_las, None),
}
SUFFIXES = tuple(FORMATS)
WRITABLE_SUFFIXES = tuple(suffix for suffix, form in FORMATS.items() if form.encode)


def read_cloud(path: str | os.PathLike) -> np.ndarray:
    """Read a point cloud in the format given by the file's suffix.

    Parameters
    ----------
    path : str or path
        A .txt, .csv, .xyz, .asc, .pts, .bin (KITTI or nuScenes), .pcd, .npz, .npy, .ply or .las
        file. PLY needs the package plyfile, and LAS needs laspy.

    Returns
    -------
    ndarray, shape (n, 3) or (n, 4)
        x y z in metres, then intensity if the file contains it. float32 if the file stores
        float32, otherwise float64.

    Raises
    ------
    CloudFileError
        The file is missing or malformed; the message gives the place and the next step.

    Examples
    --------
    >>> cloud = read_cloud("data/cloud.txt")     # doctest: +SKIP
    >>> cloud.shape                              # doctest: +SKIP
    (115451, 4)
    """
    path = Path(path)
    if os.path.isdir(path):  # Path.is_dir raises for invalid file names
        raise file_error(
            path,
            "",
            "found a folder, expected a file",
            "Read a folder of clouds with read_sequence.",
        )
    form = _format_of(path)
    data = read_bytes(path, SUFFIXES)
    refuse_other_content(data, path.name, path.suffix.lower())
    return form.decode(data, path.name)


def write_cloud(path: str | os.PathLike, cloud: np.ndarray) -> None:
    """Write a point cloud in the format given by the file's suffix.

    Parameters
    ----------
    path : str or path
        A .txt, .csv, .xyz, .asc, .pts, .bin (KITTI), .pcd, .npz or .npy file. An existing file is
        replaced atomically.
    cloud : array_like, shape (n, 3) or (n, 4)
        KITTI files have four float32 columns; in them, a missing intensity is written as 0.

    Raises
    ------
    CloudFileError
        The array is not a cloud, the suffix is unknown, or the file cannot be written.
    """
    path = Path(path)
    form = _format_of(path)
    if form.encode is None:
        raise file_error(
            path,
            "",
            f"{path.suffix} files can only be read",
            f"Choose one of {', '.join(WRITABLE_SUFFIXES)}.",
        )
    try:
        cloud = np.asarray(cloud)
        cloud = cloud if cloud.dtype in (np.float32, np.float64) else cloud.astype(np.float64)
    except (TypeError, ValueError):
        raise CloudFileError(
            f"{path.name}: a cloud is an array of numbers, but this cannot be turned into one."
        ) from None
    if cloud.ndim != 2 or cloud.shape[1] not in (3, 4):
        raise CloudFileError(
            f"{path.name}: a cloud has shape (n, 3) or (n, 4), one row per "
            f"point, but this array has shape {cloud.shape}."
        )
    write_bytes(path, form.encode(cloud))


def _format_of(path: Path) -> Format:
    """Return the format for a path's suffix, ignoring case."""
    try:
        return FORMATS[path.suffix.lower()]
    except KeyError:
        kind = path.suffix or "no suffix"
        raise file_error(
            path,
            "",
            f"found {kind}, expected a file ending in {', '.join(SUFFIXES)}",
            "Read recordings (.bag, .db3, .mcap) with read_bag, and folders with read_sequence.",
        ) from None
