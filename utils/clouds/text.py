"""Clouds as text: one point per line, x y z and optionally intensity.

The reader accepts the usual variants: spaces, tabs, commas or semicolons, headers, comments, a
leading number of points, any line ending, UTF-8 or UTF-16. A header that names x, y and z selects
the columns; other columns are skipped. For any other text, the error gives the line number.
"""

import codecs
import re
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from utils.clouds.errors import CloudFileError, excerpt, file_error
from utils.clouds.pcd_header import INTENSITY_NAMES

EXPECTED = "three or four numbers: x y z in metres, then intensity if there is one"
COMMENT = re.compile(r"#|//|%")
SEPARATOR = re.compile(r"\s*[,;]\s*|\s+")
EMPTY_FIELD = re.compile(r"(?:^|[,;])[^\S\n]*[,;]", re.MULTILINE)
COMMAS_TO_BLANKS = str.maketrans(",;", "  ")
UNIT = re.compile(r"\[[^\]]*\]|\([^)]*\)")
COMMA_IN_NUMBER = re.compile(r"\d,\d")
OTHER_SEPARATOR = re.compile(r";|[^\s,;]\s+[^\s,;]")
NAMES = {
    **{f"points_m_xyz:{index}": axis for index, axis in enumerate("xyz")},  # VeloView
    **{f"points:{index}": axis for index, axis in enumerate("xyz")},  # ParaView
    "scalar_field": "intensity",  # CloudCompare
    "scalar_intensity": "intensity",
}
DEGREES = {"lat", "latitude", "lon", "lng", "longitude"}
LARGEST_INTENSITY = 1e6  # scanners give at most 65,535; times and packed colours are larger
PTS_COLUMNS = {7: [0, 1, 2, 3], 6: [0, 1, 2]}  # x y z, then intensity, then red green blue


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
    start, names = _skip_header(lines)
    announced = _announced_point_count(lines, start)
    if announced is not None:
        start += 1
    count = len(next(filter(None, map(split_fields, lines[start:])), names))
    columns = _named_columns(names, count, start, name)
    if columns is None and announced is None:
        start, columns = _skip_column_numbers(lines, start)
    if columns is None and (announced is not None or name.lower().endswith(".pts")):
        columns = PTS_COLUMNS.get(count)
    if not any(map(split_fields, lines[start:])):
        if announced or (announced is None and not {"x", "y", "z"} <= set(names)):
            raise _no_points_error(lines, name)
        return np.empty((0, len(columns) if columns else 4))
    rows = _parse_rows(lines, start, columns, name)
    if announced is not None and len(rows) != announced:
        raise file_error(
            name,
            f"line {start}",
            f"the line announces {announced} points, but {len(rows)} follow",
            "Was the file copied completely?",
        )
    if columns is None and _counts_lines(rows, lines[start:]):
        raise file_error(
            name,
            f"line {start + 1}",
            "the first column numbers the lines, expected x",
            "Save the file without an index column, or name the columns in a header line.",
        )
    if columns is None and (rows[:, 3:] > LARGEST_INTENSITY).sum() > len(rows) / 2:
        raise file_error(
            name,
            f"line {start + 1}",
            f"found {rows[0, 3]:.15g} in column 4, expected an intensity",
            "If the column contains times or colours, name the columns in a header line, for "
            "instance: x y z time",
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
            "Give the file the suffix of its format: .bin, .pcd or .npz. If it is text, save it as "
            "UTF-8.",
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
            names = split_fields(UNIT.sub("", line))
        elif line.strip():
            names = split_fields(COMMENT.sub(" ", UNIT.sub("", line)))
        names = [NAMES.get(field.lower(), field.lower()) for field in names]
    return len(lines), names


def _named_columns(names: list[str], count: int, start: int, name: str) -> list[int] | None:
    """Return the columns of x, y, z and the intensity, or None if the header does not name them.

    The header must have as many names as the lines have fields. Otherwise it is read as a comment
    such as ``# my cloud: x y z``, which announces the usual order.
    """
    if not {"x", "y", "z"} <= set(names):
        degrees = DEGREES & set(names)
        if len(names) == count and len(degrees) == 2:
            raise file_error(
                name,
                f"line {start}",
                f"the header names the columns {excerpt(' '.join(names))}, but "
                f"{' and '.join(sorted(degrees))} are in degrees, not in metres",
                "Convert the positions to metres, and name the columns x, y and z.",
            )
        return None
    if len(names) == count:
        intensity = [name for name in INTENSITY_NAMES if name in names][:1]
        return [names.index(name) for name in ("x", "y", "z", *intensity)]
    x = names.index("x")
    if names[x : x + 3] != ["x", "y", "z"]:
        raise file_error(
            name,
            f"line {start}",
            f"the header names the {len(names)} columns {excerpt(' '.join(names))}, but the next "
            f"line has {count} numbers",
            "Correct the header.",
        )
    return None


def _skip_column_numbers(lines: list[str], start: int) -> tuple[int, list[int] | None]:
    """Skip a header of column numbers, as pandas writes it; return the next line and the columns.

    The line 0,1,2 can also be a point. It is a header if the next line is not made of integers.
    """
    fields = split_fields(lines[start]) if start < len(lines) else []
    shift = int(fields[:1] == [""])  # pandas writes no name above the index column
    count = len(fields) - shift
    if count not in (3, 4) or fields[shift:] != [str(number) for number in range(count)]:
        return start, None
    following = next(filter(None, map(split_fields, lines[start + 1 :])), [])
    if not shift and all(re.fullmatch("[+-]?[0-9]+", field) for field in following):
        return start, None
    return start + 1, list(range(shift, shift + count))


def _announced_point_count(lines: list[str], first: int) -> int | None:
    """Return the number of points if the line above them gives it, as in .pts files."""
    fields = split_fields(lines[first]) if first < len(lines) else []
    if len(fields) == 1 and re.fullmatch("[0-9]{1,18}", fields[0]):
        return int(fields[0])
    return None


def _no_points_error(lines: list[str], name: str) -> CloudFileError:
    first = next((line.strip() for line in lines if line.strip()), "")
    advice = "Was it saved or copied completely?"
    if first[:1] in ("[", "("):
        advice = "Save the array with np.savetxt(path, cloud)."
    found = f", its first line is {excerpt(first)}" if first else ""
    return file_error(
        name, "", f"the file contains no points{found}, expected lines of {EXPECTED}", advice
    )


def _counts_lines(rows: np.ndarray, lines: list[str]) -> bool:
    """Return whether the first of four columns is 0, 1, 2 … or 1, 2, 3 … in whole numbers."""
    first_field = next(filter(None, map(split_fields, lines)))[0]
    return (
        len(rows) >= 3
        and rows.shape[1] == 4
        and first_field in ("0", "1")
        and np.array_equal(rows[:, 0], np.arange(len(rows)) + int(first_field))
        and bool((rows[:, 1:] % 1 != 0).any())
    )


def _parse_rows(
    lines: list[str], start: int, columns: Sequence[int] | None, name: str
) -> np.ndarray:
    """Convert the data lines: all at once if they are well formed, otherwise one by one."""
    body = "\n".join(lines[start:])
    if COMMA_IN_NUMBER.search(body) and OTHER_SEPARATOR.search(body):
        _refuse_decimal_commas(lines, start, name)
    if not (("," in body or ";" in body) and EMPTY_FIELD.search(body)):
        try:
            text = body.translate(COMMAS_TO_BLANKS).split("\n")
            rows = np.loadtxt(text, usecols=columns, ndmin=2)
            if rows.shape[1] in (3, 4):
                return rows
        except ValueError:
            pass  # the slower pass either names the faulty line or accepts the text
    return _parse_rows_one_by_one(lines, start, columns, name)


def _refuse_decimal_commas(lines: list[str], start: int, name: str) -> None:
    """Raise an error if a line has commas within its numbers, and another separator."""
    for index in range(start, len(lines)):
        line = COMMENT.split(lines[index], maxsplit=1)[0]
        if COMMA_IN_NUMBER.search(line) and OTHER_SEPARATOR.search(line):
            raise file_error(
                name,
                f"line {index + 1}",
                f"found {excerpt(line.strip())}, numbers with decimal commas",
                "Save them with decimal points.",
            )


def _parse_rows_one_by_one(
    lines: list[str], start: int, columns: Sequence[int] | None, name: str
) -> np.ndarray:
    """Convert the data lines one by one; the error gives the number of the first faulty line."""
    rows: list[list[float]] = []
    length = 0
    for index in range(start, len(lines)):
        fields = split_fields(lines[index])
        if not fields:
            continue
        place = f"line {index + 1}"
        wanted = [column for column in columns or range(len(fields)) if column < len(fields)]
        numbers = [_parse_number(fields[column]) for column in wanted]
        if None in numbers:
            column = wanted[numbers.index(None)]
            found = excerpt(fields[column]) if fields[column] else "nothing"
            raise file_error(
                name,
                place,
                f"found {found} in column {column + 1}, expected a number",
                "Correct or delete the line; write nan for a missing value.",
            )
        length = length or len(fields)
        if len(fields) != length:
            raise file_error(
                name,
                place,
                f"found {len(fields)} numbers, expected {length} as in the previous lines",
                "Correct the line; if it is the last one, the file was cut off.",
            )
        if len(numbers) not in (3, 4):
            raise file_error(
                name,
                place,
                f"found {length} column{'s' * (length != 1)}, expected {EXPECTED}",
                "Save only these columns, or name all columns in a header line: x y z intensity …"
                if length > 4
                else "Save these columns.",
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
