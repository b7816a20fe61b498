"""Read CSV tables with any common separator, and escape cells that contain formulas."""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass

SEPARATORS = ",;\t"
# A spreadsheet executes a cell that begins with =, +, - or @. Any of the separators may begin a new
# cell, because the separator depends on the user's language.
FORMULA = re.compile(rf"""(^|[{SEPARATORS}\r\n])(?=[\s"]*[=+\-@])""")
csv.field_size_limit(2**24)  # LMSs export texts longer than the default limit


@dataclass(frozen=True)
class Table:
    """The non-empty rows of a table, and the format of its file.

    Attributes
    ----------
    rows : tuple of tuple of str
        Empty cells beyond the last title are removed.
    lines : tuple of int
        The line in which each row ends.
    separator, line_end : str
    encoding : {"utf-8", "utf-8-sig", "utf-16"}
    """

    rows: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]
    separator: str
    line_end: str
    encoding: str

    @property
    def titles(self) -> tuple[str, ...]:
        """The first row."""
        return self.rows[0] if self.rows else ()


class TableError(Exception):
    """A file is not a table; the message is the reason.

    Attributes
    ----------
    line : int
        The line with the error; 0 if the text cannot be decoded.
    """

    def __init__(self, reason: str, line: int = 0) -> None:
        super().__init__(reason)
        self.line = line


def decode_text(data: bytes, errors: str = "strict") -> str:
    """Decode a text file in UTF-8 or, as Windows writes it, with a byte order mark or in UTF-16.

    Raises
    ------
    UnicodeDecodeError
        Unless `errors` names another reaction; see `bytes.decode`.
    """
    is_utf_16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return data.decode("utf-16" if is_utf_16 else "utf-8-sig", errors)


def escape_cell(text: str) -> str:
    """Escape a text, so that no spreadsheet treats a part of it as a formula."""
    return FORMULA.sub(r"\1'", text)


def read_table(data: bytes, strict: bool = False) -> Table:
    """Read a table that a platform, a spreadsheet or a person wrote.

    Parameters
    ----------
    data : bytes
        Text in UTF-8, or in UTF-16 with a byte order mark, with any line ends. Commas, semicolons
        or tabs separate the columns.
    strict : bool, optional
        Whether a missing quotation mark is an error.

    Raises
    ------
    TableError
    """
    text, encoding = _decode(data)
    separator = max(SEPARATORS, key=lambda separator: _rate_separator(_rows(text, separator)))
    numbered = _rows(text, separator, strict)
    width = len(numbered[0][1]) if numbered else 0
    return Table(
        tuple(_strip_empty_end(row, width) for _, row in numbered),
        tuple(line for line, _ in numbered),
        separator,
        "\r\n" if "\r\n" in text else "\n",
        encoding,
    )


def _decode(data: bytes) -> tuple[str, str]:
    encoding = "utf-8"
    if data.startswith(codecs.BOM_UTF8):
        encoding = "utf-8-sig"
    elif data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encoding = "utf-16"
    try:
        return data.decode(encoding), encoding
    except UnicodeDecodeError:
        raise TableError("it is not in UTF-8") from None


def _rows(text: str, separator: str, strict: bool = False) -> list[tuple[int, list[str]]]:
    """Return the non-empty rows, each with the line in which it ends."""
    rows = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=strict)
    try:
        return [(rows.line_num, row) for row in rows if any(row)]
    except csv.Error as error:
        raise TableError(str(error), rows.line_num) from None


def _rate_separator(rows: Sequence[tuple[int, Sequence[str]]]) -> tuple[float, int]:
    """Rate a separator by the share of rows as wide as the header, then by that width."""
    width = len(rows[0][1]) if rows else 0
    if width < 2:
        return 0.0, 0
    return sum(len(row) == width for _, row in rows) / len(rows), width


def _strip_empty_end(row: Sequence[str], width: int) -> tuple[str, ...]:
    """Remove empty cells to the right of the table, which spreadsheets add."""
    end = len(row)
    while end > width and not row[end - 1]:
        end -= 1
    return tuple(row[:end])
