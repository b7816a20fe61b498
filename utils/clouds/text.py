"""Clouds as text: one point per line, x y z and optionally intensity.

The reader accepts the usual variants: spaces, tabs, commas or semicolons, headers, comments, a
leading number of points, any line ending, UTF-8 or UTF-16. For any other text, the error gives
the line number.
"""

import codecs
import re
from collections.abc import Iterable, Iterator

import numpy as np

from utils.clouds.errors import excerpt, file_error

EXPECTED = "three or four numbers: x y z in metres, then intensity if there is one"
COMMENT = re.compile(r"#|//|%")
SEPARATOR = re.compile(r"\s*[,;]\s*|\s+")
EMPTY_FIELD = re.compile(r"(?:^|[,;])[^\S\n]*[,;]", re.MULTILINE)
COMMAS_TO_BLANKS = str.maketrans(",;", "  ")


def decode_text(data: bytes, name: str = "cloud.txt") -> np.ndarray:
    """Read a cloud from the bytes of a text file.

    Parameters
    ----------
    data : bytes
        The file's content.
    name : str
        The file name to show in messages.

    Returns
    -------
    ndarray, shape (n, 3) or (n, 4), float64
        NaN and infinite values are kept. A file without points must have a header that names the
        columns ``x y z [intensity]``.

    Raises
    ------
    CloudFileError
        The text is not a cloud; the message names the first line that does not match `EXPECTED`.
    """
    lines = _decode_characters(data, name).split("\n")
    first, names = _skip_header(lines)
    if {"x", "y", "z"} <= set(names) and names[:3] != ["x", "y", "z"]:
        raise file_error(
            name,
            f"line {first}",
            f"the header names the columns {' '.join(names)!r}, expected "
            "x y z [intensity] in this order",
            "Save only these columns, without an index column.",
        )
    announced = _announced_point_count(lines, first)
    start = first if announced is None else first + 1
    if not any(map(split_fields, lines[start:])):
        if announced or (announced is None and names[:3] != ["x", "y", "z"]):
            raise file_error(
                name,
                "",
                f"the file contains no points, expected lines of {EXPECTED}",
                "Was it saved or copied completely?",
            )
        return np.empty((0, 3 if len(names) == 3 else 4))
    rows = _parse_rows(lines, start, name)
    if announced is not None and len(rows) != announced:
        raise file_error(
            name,
            f"line {first + 1}",
            f"the line announces {announced} points, but {len(rows)} follow",
            "Was the file copied completely?",
        )
    return rows


def encode_text(cloud: np.ndarray, separator: str = " ", decimals: int | None = None) -> bytes:
    """Encode a cloud as text.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        A header line is written only if n = 0, to keep the number of columns.
    separator : str
        Text between two numbers.
    decimals : int, optional
        Digits after the decimal point (3 for millimetres). By default, the fewest digits that
        read back as the same number.
    """
    columns = ("x", "y", "z", "intensity")[: cloud.shape[1]]
    if not len(cloud):
        return ("# " + " ".join(columns) + "\n").encode()
    if decimals is None:
        return "".join(separator.join(row) + "\n" for row in shortest_digits(cloud)).encode()
    line = separator.join([f"%.{decimals}f"] * len(columns)) + "\n"
    return ((line * len(cloud)) % tuple(cloud.ravel().tolist())).encode()


def shortest_digits(cloud: np.ndarray) -> Iterator[Iterable[str]]:
    """Iterate over the rows as strings with the fewest digits that read back unchanged."""
    if cloud.dtype == np.float32:
        return iter(cloud.astype(str).tolist())
    return (map(repr, row) for row in cloud.tolist())


def _decode_characters(data: bytes, name: str) -> str:
    """Decode the file and normalise its newlines; refuse binary data and web pages."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        text = data.decode("utf-16", errors="replace")
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:  # an accent in an old Latin-1 header
            text = data.decode("latin-1")
    if (position := text.find("\0")) >= 0:
        raise file_error(
            name,
            f"character {position}",
            "found binary data, expected text",
            "Give the file the suffix of its format: .bin, .pcd or .npz.",
        )
    if text.lstrip()[:1] == "<":
        raise file_error(
            name,
            "line 1",
            f"found {excerpt(text.split(chr(10))[0])}, a web page or XML, expected numbers",
            "Download the raw file instead.",
        )
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _skip_header(lines: list[str]) -> tuple[int, list[str]]:
    """Return the index of the first line of data, and the column names above it."""
    names: list[str] = []
    for index, line in enumerate(lines):
        if fields := split_fields(line):
            start = (fields[0] or fields[-1])[:1]
            if _parse_number(fields[0]) is not None or start in "+-.0123456789":
                return index, names
            names = [field.lower() for field in fields]
        elif line.strip():
            names = [field.lower() for field in split_fields(COMMENT.sub(" ", line))]
    return len(lines), names


def _announced_point_count(lines: list[str], first: int) -> int | None:
    """Return the number of points if the line above them gives it, as in .pts files."""
    fields = split_fields(lines[first]) if first < len(lines) else []
    if len(fields) == 1 and re.fullmatch("[0-9]{1,18}", fields[0]):
        return int(fields[0])
    return None


def _parse_rows(lines: list[str], start: int, name: str) -> np.ndarray:
    """Convert the data lines: all at once if they are well formed, otherwise one by one."""
    body = "\n".join(lines[start:])
    if not (("," in body or ";" in body) and EMPTY_FIELD.search(body)):
        try:
            rows = np.loadtxt(body.translate(COMMAS_TO_BLANKS).split("\n"), ndmin=2)
            if rows.shape[1] in (3, 4):
                return rows
        except ValueError:
            pass  # the slower pass either names the faulty line or accepts the text
    return _parse_rows_one_by_one(lines, start, name)


def _parse_rows_one_by_one(lines: list[str], start: int, name: str) -> np.ndarray:
    """Convert the data lines one by one; the error gives the number of the first faulty line."""
    rows: list[list[float]] = []
    for index in range(start, len(lines)):
        fields = split_fields(lines[index])
        if not fields:
            continue
        place = f"line {index + 1}"
        numbers = [_parse_number(field) for field in fields]
        if len(fields) > 4 and ";" in lines[index] and "," in lines[index]:
            raise file_error(
                name,
                place,
                f"found {excerpt(lines[index])}, expected {EXPECTED}",
                "If these are decimal commas, save with decimal points.",
            )
        if None in numbers:
            column = numbers.index(None)
            found = excerpt(fields[column]) if fields[column] else "nothing"
            raise file_error(
                name,
                place,
                f"found {found} in column {column + 1}, expected a number",
                "Correct or delete the line; write nan for a missing value.",
            )
        if rows and len(numbers) != len(rows[0]):
            raise file_error(
                name,
                place,
                f"found {len(numbers)} numbers, expected {len(rows[0])} as in the previous lines",
                "Correct the line; if it is the last one, the file was cut off.",
            )
        if len(numbers) not in (3, 4):
            raise file_error(
                name,
                place,
                f"found {len(numbers)} column{'s' * (len(numbers) != 1)}, expected {EXPECTED}",
                "Save only these columns.",
            )
        rows.append(numbers)
    return np.array(rows)


def split_fields(line: str) -> list[str]:
    """Split a line into fields, without its comment; an empty field becomes ``""``."""
    line = COMMENT.split(line, maxsplit=1)[0].replace('"', "").strip()
    fields = SEPARATOR.split(line) if line else []
    return fields[:-1] if fields and not fields[-1] else fields


def _parse_number(field: str) -> float | None:
    """Convert a field, or return None if it is not a number; ``1_000`` is not accepted."""
    try:
        return float(field) if "_" not in field else None
    except ValueError:
        return None
