"""Quote text that a student chose, such as a file name or a notebook's metadata."""

from __future__ import annotations


def one_line(text: str) -> str:
    """Return a text as one line without control characters.

    A second line could pass for a sentence of the grader on a terminal, and a blank line would end
    a block of HTML in Markdown.
    """
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())
