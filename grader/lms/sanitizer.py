"""Text of a stranger that browsers show and never obey.

Formgrader, feedback and report turn Markdown into HTML, and leave in it what is HTML already. Here
everything that could become a tag, a script's address or a command of MathJax loses its meaning by
a space of no width: it looks as it was typed, in text, code and formulas alike. That needs no
parser of Markdown, of which each of those programs has another one.
"""

from __future__ import annotations

import base64
import binascii
import re

from grader.lms.formula_sanitizer import NO_WIDTH, harmless_formulas

PICTURES = ("image/png", "image/jpeg", "image/gif")
_TAG = re.compile(r"<(?=[A-Za-z/!?])")
# What may follow a bracket: one of these schemes, or an address in which a page ends, or a folder,
# before anything that could become the colon of another. What is longer is none.
_ADDRESS = re.compile(
    r"\](?=[(:])"
    r"(?![(:]\s*+<?(?i:https?|mailto|attachment):)"
    r"(?![(:]\s*+[^:&\\<>()/?#\s\x00-\x1f\u200b-\u200f]{0,200}+(?:[/?#)\s]|\Z))"
)
# A picture from anywhere else is fetched, with the cookies of whoever looks.
_FETCHED = re.compile(r"!(?=\[)(?!\[[^\[\]\n]{0,200}+\]\(attachment:)")
_DIAGRAM = re.compile(r"((?<!`)`{3,}+[^\S\n]*+|(?<!~)~{3,}+[^\S\n]*+)(?=mermaid)")
_FILE_NAME = re.compile(r"[\w .()+\-]{1,100}")


def harmless(markdown: str) -> str:
    """Markdown in which nothing is HTML, script or style, and no picture comes from elsewhere.

    Returns
    -------
    str
        Looks the same. What is harmless already stays as it is. The time that this takes grows
        with the length: no pattern looks twice at a letter.
    """
    text = harmless_formulas(markdown)
    text = _TAG.sub("<" + NO_WIDTH, text)
    text = _ADDRESS.sub("]" + NO_WIDTH, text)
    text = _FETCHED.sub("!" + NO_WIDTH, text)
    return _DIAGRAM.sub(r"\1text ", text)


def as_code(text: str) -> str:
    """Markdown that shows a text letter by letter."""
    longest = max((len(run) for run in re.findall(r"`+", text)), default=0)
    fence = "`" * max(3, longest + 1)
    return f"{fence}text\n{text}\n{fence}"


def harmless_pictures(attachments: dict) -> dict:
    """The attachments of a cell that are pictures, and nothing besides."""
    found = {}
    for name, forms in attachments.items():
        if not isinstance(forms, dict) or not _FILE_NAME.fullmatch(name):
            continue
        pictures = {form: data for form, data in forms.items() if _is_picture(form, data)}
        if pictures:
            found[name] = pictures
    return found


def _is_picture(form: str, data: object) -> bool:
    if form not in PICTURES or not isinstance(data, str):
        return False
    try:
        base64.b64decode("".join(data.split()), validate=True)
    except (binascii.Error, ValueError):
        return False
    return True
