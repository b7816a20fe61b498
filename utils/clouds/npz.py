"""Clouds in NumPy's files: ``.npz`` archives and single ``.npy`` arrays."""

import io
import zipfile
from typing import IO

import numpy as np

from utils.clouds.errors import CloudFileError, excerpt, file_error, listing

LARGEST_RATIO = 100  # ratio of unpacked to packed bytes; real clouds stay below 10
ALWAYS_ALLOWED = 64 << 20  # bytes that may be unpacked at any compression ratio
FORMAT_VERSIONS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}


def decode_npz(data: bytes, name: str = "cloud.npz") -> np.ndarray:
    """Read a cloud from the bytes of an ``.npz`` archive.

    The cloud is the array ``cloud`` or, if there is none, the only array of shape (n, 3) or (n, 4).
    Pickled objects are never loaded. Points are unpacked only if the size in the archive is
    plausible and matches the array's own header.

    Returns
    -------
    ndarray, shape (n, 3) or (n, 4)
        float32 or float64 as stored; any other kind of number becomes float64.

    Raises
    ------
    CloudFileError
        The data are damaged or not an archive, or no array, or several arrays, can be the cloud.
    """
    try:
        archive = zipfile.ZipFile(io.BytesIO(data))
    # A damaged archive can also look like a newer version, or contain an undecodable name.
    except (zipfile.BadZipFile, NotImplementedError, ValueError) as error:
        raise file_error(
            name,
            "",
            f"this is not an intact .npz archive ({excerpt(error, 80)})",
            "Was the file copied completely?",
        ) from None
    with archive:
        return _read_member(archive, name)


def encode_npz(cloud: np.ndarray) -> bytes:
    """Encode a cloud as a compressed ``.npz`` archive; equal clouds give equal bytes."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, cloud=cloud)
    return buffer.getvalue()


def decode_npy(data: bytes, name: str = "cloud.npy") -> np.ndarray:
    """Read a cloud from the bytes of an ``.npy`` file; pickled objects are never loaded.

    Returns
    -------
    ndarray, shape (n, 3) or (n, 4)
        float32 or float64 as stored; any other kind of number becomes float64.

    Raises
    ------
    CloudFileError
        The data are damaged, or the array is not numeric or of another shape.
    """
    return _read_array(io.BytesIO(data), len(data), "", name)


def encode_npy(cloud: np.ndarray) -> bytes:
    """Encode a cloud as an ``.npy`` file."""
    buffer = io.BytesIO()
    np.save(buffer, cloud)
    return buffer.getvalue()


def _read_member(archive: zipfile.ZipFile, name: str) -> np.ndarray:
    member = archive.getinfo(_cloud_member(archive, name))
    array = f"array {member.filename.removesuffix('.npy')!r}"
    allowed = max(ALWAYS_ALLOWED, LARGEST_RATIO * member.compress_size)
    if member.file_size > allowed:
        raise file_error(
            name,
            f"byte {member.header_offset}",
            f"{member.compress_size} bytes would decompress to {member.file_size}, which is "
            "impossible for a cloud",
        )
    try:
        stream = archive.open(member)
    except Exception as error:
        raise _damaged_error(name, array, error) from None
    with stream:
        return _read_array(stream, member.file_size, array, name)


def _cloud_member(archive: zipfile.ZipFile, name: str) -> str:
    """Return the name of the array ``cloud``, or of the only array of a cloud's shape."""
    names = archive.namelist()
    if "cloud.npy" in names:
        return "cloud.npy"
    fitting = [entry for entry in names if _has_shape_of_cloud(archive, entry)]
    if len(fitting) == 1:
        return fitting[0]
    found = listing(repr(entry.removesuffix(".npy")) for entry in fitting or names) or "nothing"
    raise file_error(
        name,
        "",
        f"the archive contains {found}, expected an array 'cloud' or exactly one array of shape "
        "(n, 3) or (n, 4)",
        "Save with np.savez_compressed(path, cloud=points).",
    )


def _has_shape_of_cloud(archive: zipfile.ZipFile, member: str) -> bool:
    try:
        with archive.open(member) as stream:
            shape, _, kind = _read_header(stream)
    except Exception:  # damaged, or not an array
        return False
    return len(shape) == 2 and shape[1] in (3, 4) and kind.kind in "fiu"


def _read_array(stream: IO[bytes], size: int, place: str, name: str) -> np.ndarray:
    """Read a whole ``.npy`` file of `size` bytes."""
    try:
        shape, by_column, kind = _read_header(stream)
        wanted = _check_size(shape, kind, size - stream.tell(), place, name)
        # Reading one byte more makes zipfile reach the end and verify the checksum.
        values = np.frombuffer(stream.read(wanted + 1), kind)
    except CloudFileError:
        raise
    except Exception as error:  # damaged data raise errors from zlib, lzma, struct and others
        raise _damaged_error(name, place, error) from None
    cloud = values.reshape(shape, order="F" if by_column else "C")
    target = np.float32 if kind.kind == "f" and kind.itemsize == 4 else np.float64
    return np.array(cloud, target, order="C")


def _damaged_error(name: str, place: str, error: Exception) -> CloudFileError:
    return file_error(
        name,
        place,
        f"the array is damaged ({excerpt(error, 80)})",
        "Copy the file again from its source.",
    )


def _read_header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype]:
    """Read shape, order and dtype from the header of an ``.npy`` file."""
    version = np.lib.format.read_magic(stream)
    if version not in FORMAT_VERSIONS:
        raise ValueError(f"unknown .npy version {version}")
    return FORMAT_VERSIONS[version](stream)


def _check_size(
    shape: tuple[int, ...], kind: np.dtype, available: int, place: str, name: str
) -> int:
    """Return the size of the array in bytes, or raise if the array is not a complete cloud."""
    if kind.kind not in "fiu":
        raise file_error(name, place, f"found {excerpt(kind)}, expected numbers")
    if len(shape) != 2 or shape[1] not in (3, 4):
        raise file_error(
            name,
            place,
            f"found shape {shape}, expected (n, 3) or (n, 4), one row per point",
        )
    expected_size = shape[0] * shape[1] * kind.itemsize
    if shape[0] < 0 or expected_size != available:
        raise file_error(
            name,
            place,
            f"shape {shape} needs {expected_size} bytes, but the file has {available}",
            "Was the file copied completely?",
        )
    return expected_size
