"""Read CSV tables with any common separator, and escape cells that contain formulas."""

from __future__ import annotations

import csv
import io

SEPARATORS = ",;\t"
# Spreadsheets execute a cell that begins with one of these characters as a formula.
FORMULA = ("=", "+", "-", "@", "\t", "\r")
csv.field_size_limit(2**24)  # LMSs export texts longer than the default limit


def harmless_cell(text: str) -> str:
    """Escape a text, so that a spreadsheet does not treat it as a formula."""
    return f"'{text}" if text.startswith(FORMULA) else text


def read_table(text: str) -> tuple[str, list[list[str]]]:
    """Return the separator that fits a CSV table best, and the non-empty rows.

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
    """Rate a separator by the share of rows that are as wide as the header, then by the width."""
    rows = found[1]
    width = len(rows[0]) if rows else 0
    if width < 2:
        return 0.0, 0
    return sum(len(row) == width for row in rows) / len(rows), width
