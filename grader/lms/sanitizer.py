"""Sanitize untrusted text, so that browsers show it without interpreting it.

Formgrader and feedback pages convert Markdown to HTML, and keep any HTML in it. A zero-width space
disarms everything that could become a tag, a script's address or a MathJax command. Text, code and
formulas still look as typed. No Markdown parser is used, because each of these programs has a
different one.
"""

from __future__ import annotations

import re

from grader.lms.formula_sanitizer import ZERO_WIDTH_SPACE, sanitize_formulas

_TAG = re.compile(r"<(?=[A-Za-z/!?])")
# After a bracket, only these schemes and relative addresses are allowed. A relative address has at
# most 200 characters, and no colon, before its first slash, `?`, `#`, `)`, space or its end.
_ADDRESS = re.compile(
    r"\](?=[(:])"
    r"(?![(:]\s*+<?(?i:https?|mailto|attachment):)"
    r"(?![(:]\s*+[^:&\\<>()/?#\s\x00-\x1f\u200b-\u200f]{0,200}+(?:[/?#)\s]|\Z))"
)
# A browser would fetch a picture from another address with the cookies of the page's reader.
_FETCHED_PICTURE = re.compile(r"!(?=\[)(?!\[[^\[\]\n]{0,200}+\]\(attachment:)")
_DIAGRAM = re.compile(r"((?<!`)`{3,}+[^\S\n]*+|(?<!~)~{3,}+[^\S\n]*+)(?=mermaid)")


def sanitize_markdown(markdown: str) -> str:
    """Sanitize Markdown, so that no HTML, script or style in it has an effect.

    Pictures are shown only if they are attachments.

    Returns
    -------
    str
        Text that looks the same; harmless text is returned unchanged. The running time is linear in
        the length, because no pattern examines a character twice.
    """
    text = sanitize_formulas(markdown)
    text = _TAG.sub("<" + ZERO_WIDTH_SPACE, text)
    text = _ADDRESS.sub("]" + ZERO_WIDTH_SPACE, text)
    text = _FETCHED_PICTURE.sub("!" + ZERO_WIDTH_SPACE, text)
    return _DIAGRAM.sub(r"\1text ", text)


def as_code(text: str) -> str:
    """Return Markdown that shows a text verbatim."""
    longest = max((len(run) for run in re.findall(r"`+", text)), default=0)
    fence = "`" * max(3, longest + 1)
    return f"{fence}text\n{text}\n{fence}"
