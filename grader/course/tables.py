"""Tables: those that somebody else has written, with this separator or that, and our own."""

from __future__ import annotations

import csv
import io

SEPARATORS = ",;\t"
# A cell that begins with one of these is a formula to a spreadsheet, and a command to some.
FORMULA = ("=", "+", "-", "@", "\t", "\r")
csv.field_size_limit(2**24)  # for the process: platforms' tables hold whole texts of students


def harmless_cell(text: str) -> str:
    """A text that a spreadsheet takes for text."""
    return f"'{text}" if text.startswith(FORMULA) else text


def separated(text: str) -> tuple[str, list[list[str]]]:
    """The separator of a table that fits best, and the rows that are not empty.

    Raises
    ------
    csv.Error
    """
    return max(((separator, _rows(text, separator)) for separator in SEPARATORS), key=_fit)


def _rows(text: str, separator: str) -> list[list[str]]:
    rows = csv.reader(io.StringIO(text, newline=""), delimiter=separator)
    return [row for row in rows if any(row)]


def _fit(found: tuple[str, list[list[str]]]) -> tuple[float, int]:
    """How well a separator fits: for how many rows it makes cells as for the head; how many."""
    rows = found[1]
    width = len(rows[0]) if rows else 0
    if width < 2:
        return 0.0, 0
    return sum(len(row) == width for row in rows) / len(rows), width
