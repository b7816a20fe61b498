"""Phrases that several kinds of questions share."""

from __future__ import annotations

from grader.questions.answer import Edit


def lines_with_verb(edit: Edit) -> str:
    """Return the subject and verb for the lines of an edit, such as "Lines 4 and 5 are"."""
    if edit.first == edit.last:
        return f"Line {edit.first} is"
    joint = "and" if edit.last == edit.first + 1 else "to"
    return f"Lines {edit.first} {joint} {edit.last} are"


def format_times(count: int) -> str:
    """Return a count as a word with its unit, such as "4 times"."""
    return "once" if count == 1 else f"{count} times"


def quote_code(text: str) -> str:
    """Return a line of code between backticks, without its indentation."""
    return f"`{text.strip().replace('`', chr(0x2BB))}`"
