"""Read files downloaded from an LMS, and write them back in the same format."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.course.tables import TableError, read_table
from grader.lms.exporters.protocol import ExportError

NUMBER = re.compile(r"-?[0-9][0-9.,]*")
FRACTION = re.compile(r"[0-9]+([.,])[0-9]{1,2}")


@dataclass(frozen=True)
class MarksFile:
    """A table and the format of its file.

    Attributes
    ----------
    name : str
        Name of the file.
    head : tuple of str
    rows : tuple of tuple of str
        Each row is as long as `head`.
    separator, line_end : str
    has_byte_order_mark : bool
        Whether the file begins with a byte order mark.
    """

    name: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    separator: str
    line_end: str
    has_byte_order_mark: bool

    def decimal_mark(self, columns: Iterable[int]) -> str:
        """Return the decimal mark used by the numbers in some columns.

        If no number has a fraction, the result is a point, because every site accepts a point.
        """
        for column in columns:
            for row in self.rows:
                match = FRACTION.fullmatch(row[column].strip())
                if match:
                    return match[1]
        return "."

    def text(self, columns: Sequence[int], rows: Iterable[Sequence[str]]) -> str:
        """Format the file with only the given columns and rows."""
        file = io.StringIO()
        table = csv.writer(file, delimiter=self.separator, lineterminator=self.line_end)
        for row in (self.head, *rows):
            table.writerow([row[column] for column in columns])
        return ("\ufeff" if self.has_byte_order_mark else "") + file.getvalue()


def read_marks_file(path: Path) -> MarksFile:
    """Read a file that was downloaded from an LMS.

    Raises
    ------
    ExportError
        If the file cannot be read as a table of students.
    """
    try:
        table = read_table(path.read_bytes())
    except OSError as error:
        raise ExportError(f"{path} cannot be read: {error.strerror}.") from error
    except TableError as error:
        raise ExportError(
            f"Line {error.line} of {path.name} is not valid CSV: {error}. Download it again."
            if error.line
            else _not_utf8(path)
        ) from error
    if table.encoding == "utf-16":  # no platform can import the result
        raise ExportError(_not_utf8(path))
    if len(table.rows) < 2 or len(table.titles) < 2:
        raise ExportError(
            f"{path.name} does not contain a table of students. Download the file again."
        )
    width = len(table.titles)
    for row in table.rows:
        if len(row) > width:
            raise ExportError(
                f"{path.name}: the row that begins with {row[0]!r} has {len(row)} cells, but the "
                f"header has {width}. Download the file again."
            )
    head, *others = (tuple([*row, *[""] * width][:width]) for row in table.rows)
    has_byte_order_mark = table.encoding == "utf-8-sig"
    return MarksFile(
        path.name, head, tuple(others), table.separator, table.line_end, has_byte_order_mark
    )


def _not_utf8(path: Path) -> str:
    return (
        f"{path.name} is not a CSV file in UTF-8. Use the file exactly as you downloaded it, or "
        "save it in the spreadsheet as CSV UTF-8."
    )


def read_number(text: str) -> float | None:
    """Parse a number whose last point or comma is the decimal mark; return None for other text."""
    text = text.strip()
    if not NUMBER.fullmatch(text):
        return None
    *whole, last = re.split("[.,]", text)
    return float(f"{''.join(whole)}.{last}" if whole else last)
