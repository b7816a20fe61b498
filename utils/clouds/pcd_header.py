"""The header of a PCD file: its fields, the number of points and the encoding of its body."""

from collections.abc import Container
from dataclasses import dataclass

import numpy as np

from utils.clouds.errors import excerpt, file_error

ENCODINGS = ("ascii", "binary", "binary_compressed")
KINDS = {f"{letter}{size}" for letter in "IU" for size in (1, 2, 4, 8)} | {"F4", "F8"}
INTENSITY_NAMES = ("intensity", "i", "reflectivity", "reflectance")
LONGEST_HEADER = 1 << 16  # bytes


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
        return [self.names.index(name) for name in cloud_fields(self.names)]

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
    position = line = 0
    while "DATA" not in entries and position < min(len(data), LONGEST_HEADER):
        end = data.find(b"\n", position, LONGEST_HEADER)
        end = min(len(data), LONGEST_HEADER) if end < 0 else end
        words = data[position:end].decode("latin-1").split()
        position, line = end + 1, line + 1
        if words:
            entries[words[0].upper()] = (line, words[1:])
    for key in ("FIELDS", "SIZE", "TYPE", "DATA"):
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
    if words[:1] not in ([encoding] for encoding in ENCODINGS):
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
    sizes = _parse_whole_numbers(entries, "SIZE", len(names), name)
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
    if min(counts) < 1 or any(counts[names.index(axis)] != 1 for axis in "xyz"):
        raise file_error(
            name,
            f"line {entries['COUNT'][0]}",
            "found COUNT "
            f"{excerpt(' '.join(map(str, counts)))}, expected 1 for x, y and z and "
            "at least 1 for the others",
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
        names, dtypes, counts, tuple(point_counts), entries["DATA"][1][0], start, entries["DATA"][0]
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
