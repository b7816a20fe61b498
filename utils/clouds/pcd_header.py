"""The header of a PCD file: its fields, the number of points and the encoding of its body."""

from collections.abc import Container
from dataclasses import dataclass

import numpy as np

from utils.clouds.errors import excerpt, file_error

ENCODINGS = ("ascii", "binary", "binary_compressed")
KINDS = {f"{letter}{size}" for letter in "IU" for size in (1, 2, 4, 8)} | {"F4", "F8"}
INTENSITY_NAMES = ("intensity", "i", "reflectivity", "reflectance", "remission")
LONGEST_HEADER = 1 << 16  # bytes
BYTE_ORDER_MARK = b"\xef\xbb\xbf"


@dataclass(frozen=True)
class PcdHeader:
    """Description of the body of a PCD file."""

    names: tuple[str, ...]
    kinds: tuple[np.dtype, ...]
    counts: tuple[int, ...]
    point_counts: tuple[int, ...]  # POINTS and WIDTH x HEIGHT, which may disagree
    encoding: str
    body_start: int  # byte where the body begins
    line_count: int  # lines above the body

    @property
    def point_size(self) -> int:
        """Size of one point in bytes."""
        return sum(
            kind.itemsize * count for kind, count in zip(self.kinds, self.counts, strict=True)
        )

    @property
    def field_indices(self) -> list[int]:
        """Indices of the fields x, y, z and, if there is one, intensity."""
        stored = [name for name, count in zip(self.names, self.counts, strict=True) if count]
        return [self.names.index(name) for name in cloud_fields(stored)]

    @property
    def precision(self) -> np.dtype:
        """float32, or float64 if one of the wanted fields needs it."""
        return np.result_type(np.float32, *(self.kinds[field] for field in self.field_indices))


def cloud_fields(names: Container[str]) -> list[str]:
    """Return the names of a cloud's fields: x, y, z and, if `names` contains it, the intensity."""
    return ["x", "y", "z", *[name for name in INTENSITY_NAMES if name in names][:1]]


def read_header(data: bytes, name: str) -> PcdHeader:
    """Read the header of the file, up to and including the line DATA.

    Raises
    ------
    CloudFileError
        A line is missing or invalid.
    """
    entries: dict[str, tuple[int, list[str]]] = {}
    position, line = len(BYTE_ORDER_MARK) * data.startswith(BYTE_ORDER_MARK), 0
    while "DATA" not in entries and position < min(len(data), LONGEST_HEADER):
        end = data.find(b"\n", position, LONGEST_HEADER)
        end = min(len(data), LONGEST_HEADER) if end < 0 else end
        words = data[position:end].decode("latin-1").split()
        position, line = end + 1, line + 1
        if words:
            key = words[0].upper()
            entries["FIELDS" if key == "COLUMNS" else key] = (line, words[1:])  # COLUMNS before 0.6
    for key in ("FIELDS", "DATA"):
        if key not in entries:
            raise file_error(
                name,
                "header",
                f"there is no line {key}, expected a PCD file of version 0.7",
                "Is it a PCD file, and was it copied completely?",
            )
    return _check_header(entries, position, name)


def _check_header(entries: dict[str, tuple[int, list[str]]], start: int, name: str) -> PcdHeader:
    """Turn the words of the header into a `PcdHeader`, or raise an error that names the line."""
    line, words = entries["DATA"]
    encoding = words[0].lower() if words else ""
    if encoding not in ENCODINGS:
        raise file_error(
            name,
            f"line {line}",
            f"found DATA {excerpt(' '.join(words))}, expected one of {', '.join(ENCODINGS)}",
            "Save the cloud in one of these encodings.",
        )
    names = tuple(word.lower() for word in entries["FIELDS"][1])
    for axis in "xyz":
        if axis not in names:
            raise file_error(
                name,
                f"line {entries['FIELDS'][0]}",
                f"there is no field {axis!r} in {excerpt(' '.join(names))}, expected x, y and z",
            )
    # Old files lack SIZE and TYPE. PCL's defaults are four bytes and floating-point numbers.
    entries.setdefault("SIZE", (line, ["4"] * len(names)))
    sizes = _parse_whole_numbers(entries, "SIZE", len(names), name)
    entries.setdefault("TYPE", (line, ["F" if size >= 4 else "U" for size in sizes]))
    counts = (
        _parse_whole_numbers(entries, "COUNT", len(names), name)
        if "COUNT" in entries
        else ((1,) * len(names))
    )
    line, types = entries["TYPE"]
    kinds = [f"{letter.upper()}{size}" for letter, size in zip(types, sizes, strict=False)]
    if len(types) != len(names) or not KINDS.issuperset(kinds):
        raise file_error(
            name,
            f"line {line}",
            f"found TYPE {excerpt(' '.join(types))} with SIZE "
            f"{excerpt(' '.join(map(str, sizes)))}, expected one type and size for each of "
            f"{len(names)} fields: I or U with 1, 2, 4 or 8 bytes, or F with 4 or 8",
        )
    if any(counts[names.index(axis)] != 1 for axis in "xyz"):  # 0 is padding without bytes
        raise file_error(
            name,
            f"line {entries['COUNT'][0]}",
            f"found COUNT {excerpt(' '.join(map(str, counts)))}, expected 1 for x, y and z",
        )
    point_counts = (
        [_parse_whole_numbers(entries, "POINTS", 1, name)[0]] if "POINTS" in entries else []
    )
    if "WIDTH" in entries:
        height = _parse_whole_numbers(entries, "HEIGHT", 1, name)[0] if "HEIGHT" in entries else 1
        point_counts.append(_parse_whole_numbers(entries, "WIDTH", 1, name)[0] * height)
    if not point_counts:
        raise file_error(
            name, "header", "POINTS and WIDTH are missing, expected the number of points"
        )
    dtypes = tuple(np.dtype(kind.lower()).newbyteorder("<") for kind in kinds)
    return PcdHeader(
        names, dtypes, counts, tuple(point_counts), encoding, start, entries["DATA"][0]
    )


def _parse_whole_numbers(
    entries: dict[str, tuple[int, list[str]]], key: str, length: int, name: str
) -> tuple[int, ...]:
    """Return the `length` whole numbers in a line of the header."""
    line, words = entries[key]
    if len(words) != length or not all(
        w.isascii() and w.isdecimal() and len(w) < 19 for w in words
    ):
        raise file_error(
            name,
            f"line {line}",
            f"found {key} {excerpt(' '.join(words))}, expected "
            f"{length} whole number{'s' * (length != 1)}",
        )
    return tuple(map(int, words))
