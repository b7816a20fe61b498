"""What a stranger's reply says, read without belief: each function takes anything at all.

What is not of the kind that is asked for counts as nothing; what is long is cut.
"""

from __future__ import annotations

from collections.abc import Iterator

LONGEST_TEXT = 500
MOST_ITEMS = 20


def texts(values: object) -> list[str]:
    """A stranger's list of sentences, of which the first few are enough."""
    return [readable(value) for value in values[:MOST_ITEMS]] if isinstance(values, list) else []


def readable(value: object) -> str:
    """One line of text that is safe on a terminal: no colours, no commands, no turned lines."""
    text = value[:LONGEST_TEXT] if isinstance(value, str) else ""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def rows(columns: object, width: int) -> Iterator[tuple]:
    """Rows of a stranger's table that begin with a number and a name."""
    if not isinstance(columns, list) or [*map(type, columns)] != [list] * width:
        return
    for row in zip(*columns, strict=False):
        if type(row[0]) is int and type(row[1]) is str:
            yield row


def changes(values: object) -> tuple[tuple[int, int, int, str], ...]:
    """A stranger's table of changes: number of a cell, first and last line, and a text."""
    if not isinstance(values, list):
        return ()
    kinds = [int, int, int, str]
    return tuple(
        tuple(row) for row in values if isinstance(row, list) and [*map(type, row)] == kinds
    )


def positions(values: object) -> list[int]:
    """A stranger's list of whole numbers, of which the first few are enough."""
    if not isinstance(values, list):
        return []
    return [value for value in values[:MOST_ITEMS] if type(value) is int]


def names_a_number(reply: dict) -> bool:
    """Whether an object that a reply tells of comes under a number, if it tells of one."""
    return "object" not in reply or type(reply["object"]) is int
