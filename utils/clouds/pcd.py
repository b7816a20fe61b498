"""PCD, the Point Cloud Library's format, version 0.7: ascii, binary and binary_compressed.

Format specification: https://pointclouds.org/documentation/tutorials/pcd_file_format.html
"""

import struct

import numpy as np

from utils.clouds import lzf
from utils.clouds.errors import PRINTABLE, CloudFileError, excerpt, file_error
from utils.clouds.pcd_header import ENCODINGS, PcdHeader, read_header
from utils.clouds.text import COMMA_IN_NUMBER, shortest_digits

ADVICE = "Was the file copied completely?"


def decode_pcd(data: bytes, name: str = "cloud.pcd") -> np.ndarray:
    """Read a cloud from the bytes of a PCD file.

    Fields may be in any order, mixed with other fields and padded; an organised cloud is read row
    by row. If POINTS and WIDTH x HEIGHT disagree, the number that fits the body is used.
    As in PCL, the viewpoint is not applied.

    Returns
    -------
    ndarray, shape (n, 3) or (n, 4)
        float32, or float64 if a field is a double or a long integer.

    Raises
    ------
    CloudFileError
        The file is malformed; the message names the line or byte.
    """
    header = read_header(data, name)
    body = memoryview(data)[header.body_start :]
    decode = {
        "ascii": _decode_ascii,
        "binary": _decode_binary,
        "binary_compressed": _decode_compressed,
    }
    return decode[header.encoding](body, header, name)


def encode_pcd(cloud: np.ndarray, encoding: str = "binary") -> bytes:
    """Encode a cloud as PCD.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4), float32 or float64
        Written with its own dtype.
    encoding : {"binary", "ascii", "binary_compressed"}

    Raises
    ------
    ValueError
        The encoding is unknown.
    """
    if encoding not in ENCODINGS:
        raise ValueError(f"encoding must be one of {', '.join(ENCODINGS)}, not {encoding!r}")
    columns = cloud.shape[1]
    kind = cloud.dtype.newbyteorder("<")
    header = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
        f"FIELDS {' '.join(('x', 'y', 'z', 'intensity')[:columns])}\n"
        f"SIZE{f' {kind.itemsize}' * columns}\nTYPE{' F' * columns}\nCOUNT{' 1' * columns}\n"
        f"WIDTH {len(cloud)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(cloud)}\n"
        f"DATA {encoding}\n"
    ).encode()
    if encoding == "ascii":
        return header + "".join(" ".join(row) + "\n" for row in shortest_digits(cloud)).encode()
    if encoding == "binary":
        return header + cloud.astype(kind).tobytes()
    by_field = cloud.astype(kind).T.tobytes()
    packed = lzf.compress(by_field)
    return header + struct.pack("<II", len(packed), len(by_field)) + packed


def _decode_ascii(body: memoryview, header: PcdHeader, name: str) -> np.ndarray:
    lines = bytes(body).decode("latin-1").replace("\r", "").split("\n")
    columns = sum(header.counts)
    if not any(map(str.strip, lines)):
        rows = np.empty((0, 0))
    else:
        try:
            rows = np.loadtxt(lines, comments=None, ndmin=2)
        except ValueError:
            raise _faulty_line_error(lines, columns, header.line_count, name) from None
        if rows.shape[1] != columns:
            raise _faulty_line_error(lines, columns, header.line_count, name)
    if len(rows) not in header.point_counts:
        raise file_error(
            name,
            f"line {header.line_count}",
            f"the header announces {_point_count_text(header)} points, but {len(rows)} lines "
            "follow",
            ADVICE,
        )
    if not len(rows):
        return np.empty((0, len(header.field_indices)), header.precision)
    offsets = [sum(header.counts[:field]) for field in header.field_indices]
    with np.errstate(over="ignore"):
        return rows[:, offsets].astype(header.precision)


def _faulty_line_error(
    lines: list[str], columns: int, lines_above: int, name: str
) -> CloudFileError:
    """Build the error for the first line that does not consist of `columns` numbers."""
    last = max(index for index, line in enumerate(lines) if line.strip())
    for index, line in enumerate(lines):
        fields = line.split()
        words = [field for field in fields if not _is_number(field)]
        if not words and len(fields) in (0, columns):
            continue
        if any(COMMA_IN_NUMBER.search(word) for word in words):
            advice = "Save the numbers with decimal points instead of commas."
        elif words:
            advice = "Correct or delete the line; write nan for a missing value."
        elif index == last and len(fields) < columns:
            advice = ADVICE
        else:
            advice = "Correct the line, or FIELDS and COUNT in the header."
        return file_error(
            name,
            f"line {index + lines_above + 1}",
            f"found {excerpt(line)}, expected {columns} numbers as the header says",
            advice,
        )
    return file_error(name, f"line {lines_above + 1}", "expected lines of numbers")


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return "_" not in field


def _decode_binary(body: memoryview, header: PcdHeader, name: str) -> np.ndarray:
    for points in header.point_counts:
        size = points * header.point_size
        if len(body) < size or not _is_padding(bytes(body[size:]), header):
            continue
        if points == 0:
            return np.empty((0, len(header.field_indices)), header.precision)
        if PRINTABLE.issuperset(body):
            raise file_error(
                name,
                f"line {header.line_count + 1}",
                f"found the text {excerpt(bytes(body[:80]).decode())}, expected binary points",
                "Write DATA ascii in the header.",
            )
        fields = zip(*_field_types_and_offsets(header), strict=True)
        return _combine_columns(
            [np.ndarray(points, kind, body, offset, header.point_size) for kind, offset in fields],
            header,
        )
    raise _wrong_size_error(header, f"{len(body)} bytes follow", name)


def _is_padding(rest: bytes, header: PcdHeader) -> bool:
    """Return whether the bytes after the last point can be ignored.

    PCL pads some files with zeros to a whole page, and other programs add a newline or a comment.
    Other bytes than zeros and newlines are not ignored if they could be whole points or if the
    header contradicts itself.
    """
    if not rest.strip(b"\0\r\n"):
        return True
    return len(set(header.point_counts)) == 1 and len(rest) % header.point_size != 0


def _decode_compressed(body: memoryview, header: PcdHeader, name: str) -> np.ndarray:
    if 0 in header.point_counts and len(body) <= 8:
        return np.empty((0, len(header.field_indices)), header.precision)
    if len(body) < 8:
        raise _wrong_size_error(header, f"{len(body)} bytes follow", name)
    packed, unpacked = struct.unpack_from("<II", body)
    if packed > len(body) - 8:
        raise file_error(
            name,
            f"byte {header.body_start}",
            f"expected {packed} compressed bytes, but {len(body) - 8} follow",
            ADVICE,
        )
    points = unpacked // header.point_size
    if (
        points not in header.point_counts
        or unpacked != points * header.point_size
        or (unpacked > packed * lzf.LARGEST_RATIO)
    ):
        raise _wrong_size_error(header, f"{packed} bytes would decompress to {unpacked}", name)
    try:
        raw = lzf.decompress(bytes(body[8 : 8 + packed]), unpacked)
    except ValueError as error:
        raise file_error(
            name,
            f"byte {header.body_start + 8}",
            f"the compressed data are damaged ({excerpt(error, 80)})",
            ADVICE,
        ) from None
    # The points are stored field by field, not point by point.
    fields = zip(*_field_types_and_offsets(header), strict=True)
    return _combine_columns(
        [np.frombuffer(raw, kind, points, offset * points) for kind, offset in fields], header
    )


def _field_types_and_offsets(header: PcdHeader) -> tuple[list[np.dtype], list[int]]:
    """Return the types of the wanted fields and their byte offsets within a point."""
    sizes = [kind.itemsize * count for kind, count in zip(header.kinds, header.counts, strict=True)]
    offsets = [sum(sizes[:field]) for field in header.field_indices]
    return [header.kinds[field] for field in header.field_indices], offsets


def _combine_columns(columns: list[np.ndarray], header: PcdHeader) -> np.ndarray:
    """Combine one array per field into a cloud."""
    cloud = np.empty((len(columns[0]), len(columns)), header.precision)
    for index, column in enumerate(columns):
        cloud[:, index] = column
    return cloud


def _wrong_size_error(header: PcdHeader, found_size: str, name: str) -> CloudFileError:
    return file_error(
        name,
        f"byte {header.body_start}",
        f"the header announces {_point_count_text(header)} points of {header.point_size} bytes, "
        f"but {found_size}",
        ADVICE,
    )


def _point_count_text(header: PcdHeader) -> str:
    """Return the announced number of points as text: ``"12"``, or ``"12 or 24"``."""
    return " or ".join(map(str, dict.fromkeys(header.point_counts)))
