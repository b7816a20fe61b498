"""Read tables with any common separator, and write cells that spreadsheets do not execute."""

from __future__ import annotations

import csv
import io

SEPARATORS = ",;\t"
# A spreadsheet treats a cell that begins with one of these as a formula, and may execute it.
FORMULA = ("=", "+", "-", "@", "\t", "\r")
csv.field_size_limit(2**24)  # per process; platforms export long texts


def harmless_cell(text: str) -> str:
    """Return a text in a form that a spreadsheet treats as text."""
    return f"'{text}" if text.startswith(FORMULA) else text


def read_table(text: str) -> tuple[str, list[list[str]]]:
    """Return the separator that fits a table best, and the rows that are not empty.

    Raises
    ------
    csv.Error
    """
    return max(
        ((separator, _rows(text, separator)) for separator in SEPARATORS), key=_separator_fit
    )


def _rows(text: str, separator: str) -> list[list[str]]:
    rows = csv.reader(io.StringIO(text, newline=""), delimiter=separator)
    return [row for row in rows if any(row)]


def _separator_fit(found: tuple[str, list[list[str]]]) -> tuple[float, int]:
    """Rate a separator: the rows with as many cells as the head, and the number of cells."""
    rows = found[1]
    width = len(rows[0]) if rows else 0
    if width < 2:
        return 0.0, 0
    return sum(len(row) == width for row in rows) / len(rows), width
