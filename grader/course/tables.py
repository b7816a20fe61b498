"""Read tables with any common separator, and escape cells that spreadsheets would execute."""

from __future__ import annotations

import codecs
import csv
import io

SEPARATORS = ",;\t"
# A spreadsheet treats a cell that begins with one of these as a formula, and may execute it.
FORMULA = ("=", "+", "-", "@", "\t", "\r")
csv.field_size_limit(2**24)  # for this process, because platforms export long texts


def decode_text(data: bytes, errors: str = "strict") -> str:
    """Decode a text file in UTF-8 or, as Windows writes it, with a byte order mark or in UTF-16.

    Raises
    ------
    UnicodeDecodeError
        Unless `errors` names another reaction; see `bytes.decode`.
    """
    is_utf_16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return data.decode("utf-16" if is_utf_16 else "utf-8-sig", errors)


def harmless_cell(text: str) -> str:
    """Escape a text, so that a spreadsheet does not treat it as a formula."""
    return f"'{text}" if text.startswith(FORMULA) else text


def read_table(text: str) -> tuple[str, list[list[str]]]:
    """Return the separator that fits a table best, and the non-empty rows.

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
    """Rate a separator by the share of rows as wide as the header, and by the number of columns."""
    rows = found[1]
    width = len(rows[0]) if rows else 0
    if width < 2:
        return 0.0, 0
    return sum(len(row) == width for row in rows) / len(rows), width
