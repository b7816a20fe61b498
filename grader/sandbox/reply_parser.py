"""Parse the untrusted replies of a worker; each function accepts any value.

A value of the wrong type counts as empty, and long texts and lists are cut off.
"""

from __future__ import annotations

from collections.abc import Iterator

from grader.untrusted_text import one_line

MAX_TEXT_LENGTH = 500
MAX_ITEMS = 20


def parse_texts(values: object) -> list[str]:
    """Return the first few texts of an untrusted list, each as one line."""
    return [parse_text(value) for value in values[:MAX_ITEMS]] if isinstance(values, list) else []


def parse_text(value: object) -> str:
    """Return one line of text without control characters, safe to print on a terminal."""
    return one_line(value[:MAX_TEXT_LENGTH]) if isinstance(value, str) else ""


def parse_rows(columns: object, width: int) -> Iterator[tuple]:
    """Yield the rows that begin with a number and a name, from an untrusted list of columns.

    If there are not exactly `width` columns, nothing is yielded.
    """
    if not isinstance(columns, list) or [*map(type, columns)] != [list] * width:
        return
    for row in zip(*columns, strict=False):
        if type(row[0]) is int and type(row[1]) is str:
            yield row


def parse_edits(values: object) -> tuple[tuple[int, int, int, str], ...]:
    """Return the valid edits in an untrusted table.

    An edit consists of a cell, a first line, a last line, and the text that replaces these lines.
    """
    if not isinstance(values, list):
        return ()
    kinds = [int, int, int, str]
    return tuple(
        tuple(row) for row in values if isinstance(row, list) and [*map(type, row)] == kinds
    )


def parse_positions(values: object) -> list[int]:
    """Return the whole numbers among the first few items of an untrusted list."""
    if not isinstance(values, list):
        return []
    return [value for value in values[:MAX_ITEMS] if type(value) is int]


def has_valid_object(reply: dict) -> bool:
    """Return False if a reply identifies an object by anything other than a whole number."""
    return "object" not in reply or type(reply["object"]) is int
