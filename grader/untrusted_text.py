"""Make text from a student safe to show, such as a file name or a notebook's metadata."""

from __future__ import annotations


def one_line(text: str) -> str:
    """Return a text as one line without control characters.

    On a terminal, a second line could look like a message from the grader. In Markdown, a blank
    line would end a block of HTML.
    """
    if not text.isprintable():
        text = "".join(c if c.isprintable() else " " for c in text)
    return " ".join(text.split())
