"""Print changed lines of code as a person might write them, and leave out unusual ones."""

from __future__ import annotations

import ast
import functools
import re
import warnings
from itertools import takewhile

MAX_LINE_LENGTH = 110
# Code that edits insert but few people write.
_UNUSUAL = tuple(
    map(
        re.compile,
        (
            "~",
            r"[-+] ?1\)? ?[-+] ?1\b",  # n - 1 + 1
            r"(?<![\w.])\d+\)? ?[-+] ?1\b",  # 3 + 1
            r"\b1 - ",  # 1 - x
            r"-0\b(?!\.)",
            r"\*\* ?0\.5",  # the root and the square of any value
            r"\*\* ?2\b",
            r"np\.isin\(np\.arange\(",
            r"with \w+:",
            r"\babs\(",  # the absolute value of any value
            r"\breturn\b",  # print("x") becomes return "x"
            r"^ *\w+\.\w+ = ",  # x = 0 becomes cloud.x = 0
        ),
    )
)


def is_plausible(before: str, after: str) -> bool:
    """Return whether an edit inserts only code that a person might write."""
    return not any(
        len(unusual.findall(after)) > len(unusual.findall(before)) for unusual in _UNUSUAL
    )


def is_readable(before: str, after: str) -> bool:
    """Return whether an edit replaces one line with one other line that a person might write."""
    return (
        "\n" not in before + after
        and after.split() != before.split()
        and 0 < len(after.strip()) <= MAX_LINE_LENGTH
        and is_plausible(before, after)
    )


def as_written(before: str, after: str) -> str:
    """Return a changed line without parentheses that it no longer needs.

    Parentheses that were already unnecessary before the change are kept. The result is empty if the
    line is part of a longer statement and the change added parentheses, because only the whole
    statement shows whether they are necessary.
    """
    if "\n" in after or len(after.strip()) > MAX_LINE_LENGTH:
        return after
    if not _meaning(after):
        return after if after.count("(") <= before.count("(") else ""
    is_tidy = _without_parentheses(before, 0, len(before)) == before
    start, end = (0, len(after)) if is_tidy else _changed_part(before, after)
    return _without_parentheses(after, start, end)


@functools.cache
def _without_parentheses(line: str, start: int, end: int) -> str:
    """Return a line without the unnecessary parentheses that open in a part of it."""
    meaning, at = _meaning(line), start
    while meaning and (at := line.find("(", at, end)) >= 0:
        close = _closing(line, at)
        shorter = line[:at] + line[at + 1 : close] + line[close + 1 :]
        if close > at and not _is_signed_operand(line, at) and _meaning(shorter) == meaning:
            line, end = shorter, end - 2
        else:
            at += 1
    return line


def _changed_part(before: str, after: str) -> tuple[int, int]:
    """Return the start and end of the part of `after` that differs from `before`."""
    start = len([*takewhile(lambda pair: pair[0] == pair[1], zip(before, after, strict=False))])
    rest = before[start:][::-1], after[start:][::-1]
    same = len([*takewhile(lambda pair: pair[0] == pair[1], zip(*rest, strict=False))])
    return start, len(after) - same


def _meaning(line: str) -> str:
    """Return the syntax tree of a line as a text; empty if the line is not a whole statement."""
    text = re.sub(r"^elif\b", "if", line.strip())
    for statement in (text, f"{text}\n    pass"):
        try:
            with warnings.catch_warnings(action="ignore"):
                return ast.dump(ast.parse(statement))
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            continue
    return ""


def _closing(text: str, at: int) -> int:
    """Return the position of the parenthesis that closes the one at a position; -1 if none does."""
    depth = 0
    for position in range(at, len(text)):
        depth += (text[position] == "(") - (text[position] == ")")
        if not depth:
            return position
    return -1


def _is_signed_operand(text: str, at: int) -> bool:
    """Return whether a sign is before a parenthesis and after it, as in `x - (-1)`."""
    return text[:at].rstrip().endswith(("+", "-")) and text[at + 1 : at + 2] in ("+", "-")
