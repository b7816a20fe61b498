"""Formats that other libraries read: PLY with plyfile, and LAS with laspy."""

import io
import re
import struct

import numpy as np

from utils.clouds.errors import CloudFileError, excerpt, file_error
from utils.clouds.pcd_header import INTENSITY_NAMES

VERTICES = re.compile(rb"^element\s+vertex\s+(\d{1,18})\s*$", re.MULTILINE)
LONGEST_HEADER = 1 << 16  # bytes
LARGEST_RATIO = 50  # ratio of unpacked to packed bytes; real LAZ files stay below 20
SMALLEST_RECORD = 54  # bytes of a variable-length record in a LAS file


def decode_ply(data: bytes, name: str = "cloud.ply") -> np.ndarray:
    """Read the vertices of a PLY file, in text or binary form; other elements are skipped.

    Returns
    -------
    ndarray, shape (n, 3) or (n, 4)
        float32, or float64 if a property is a double or a long integer.

    Raises
    ------
    CloudFileError
        The file is damaged, x, y or z is missing, or plyfile is not installed.
    """
    try:
        import plyfile
    except ImportError:
        raise _missing_library_error("plyfile", name) from None
    announced = VERTICES.search(data[:LONGEST_HEADER])
    if announced and int(announced[1]) > len(data):  # plyfile would allocate memory for all
        raise file_error(
            name,
            "header",
            f"{int(announced[1])} points are announced, but the file has {len(data)} bytes",
            "Was the file copied completely?",
        )
    try:
        vertices = plyfile.PlyData.read(io.BytesIO(data))["vertex"].data
        names = {field.lower().removeprefix("scalar_"): field for field in vertices.dtype.names}
        wanted = ["x", "y", "z", *[field for field in INTENSITY_NAMES if field in names][:1]]
        columns = [vertices[names[field]] for field in wanted]
        precision = np.result_type(np.float32, *(column.dtype for column in columns))
        return np.column_stack(columns).astype(precision)
    except Exception as error:  # plyfile passes on errors from struct, NumPy and its parser
        raise _unreadable_error(name, "PLY file with x, y and z", error) from None


def decode_las(data: bytes, name: str = "cloud.las") -> np.ndarray:
    """Read the points of a LAS file.

    Compressed points (LAZ) are refused, because lazrs ends the whole process for some damaged
    files.

    Returns
    -------
    ndarray, shape (n, 4), float64
        x y z in the units of the file, usually metres on a map, and the intensity as stored.

    Raises
    ------
    CloudFileError
        The file is damaged or compressed, or laspy is not installed.
    """
    try:
        import laspy
    except ImportError:
        raise _missing_library_error("laspy", name) from None
    if data[104:105] >= b"\x80":  # the highest bit of the point format
        raise file_error(
            name,
            "",
            "the points are compressed (LAZ), expected LAS",
            "Convert the file, for instance with: pdal translate street.laz street.las",
        )
    try:
        _check_las_counts(data)
        points = laspy.read(io.BytesIO(data), laz_backend=())
        with np.errstate(over="ignore", invalid="ignore"):
            columns = [points.x, points.y, points.z, points.intensity]
            return np.column_stack(columns).astype(np.float64)
    except Exception as error:  # laspy passes on errors from struct and NumPy
        raise _unreadable_error(name, "LAS file", error) from None


def _check_las_counts(data: bytes) -> None:
    """Raise an error if the header announces more records than the file can contain.

    laspy would allocate memory for all points, and try to read all other records.
    """
    extended, points = 0, struct.unpack_from("<I", data, 107)[0]
    if data[25] >= 4:  # the minor version
        extended, points = struct.unpack_from("<IQ", data, 243)
    records = struct.unpack_from("<I", data, 100)[0] + extended
    size = points * struct.unpack_from("<H", data, 105)[0]
    if size > LARGEST_RATIO * len(data) or records * SMALLEST_RECORD > len(data):
        raise ValueError(f"{points} points and {records} records are announced")


def _missing_library_error(package: str, name: str) -> CloudFileError:
    return file_error(
        name,
        "",
        f"reading this format needs the package {package}",
        f"Install it with: pip install '{package}'",
    )


def _unreadable_error(name: str, expected: str, error: Exception) -> CloudFileError:
    return file_error(
        name,
        "",
        f"this is not an intact {expected} ({excerpt(error, 80)})",
        "Was the file copied completely?",
    )
