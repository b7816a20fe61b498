"""Text of a stranger that browsers show and never obey.

Formgrader, feedback and report turn Markdown into HTML, and leave in it what is HTML already. Here
everything that could become a tag, a script's address or a command of MathJax loses its meaning by
a space of no width: it looks as it was typed, in text, code and formulas alike. That needs no
parser of Markdown, of which each of those programs has another one.
"""

from __future__ import annotations

import base64
import binascii
import html
import re

NO_WIDTH = "\u200b"
SCHEMES = ("http", "https", "mailto", "attachment")
PICTURES = ("image/png", "image/jpeg", "image/gif")
_TAG = re.compile(r"<(?=[A-Za-z/!?])")
_ADDRESS = re.compile(r"\](?=(?:\(|:)\s*<?\s*([^\s)>]*))")
_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.\-]*):")
# These make links and styles, or load more that does.
_FORMULA = re.compile(r"\\(?=(?:href|url|style|class|cssId|data|html[A-Z]\w*|require|Extension)\b)")
_DIAGRAM = re.compile(r"^(\W*(?:```+|~~~+)\s*)(?=mermaid)", re.MULTILINE)
_FILE_NAME = re.compile(r"[\w .()+\-]{1,100}")


def harmless(markdown: str) -> str:
    """Markdown in which nothing is HTML, script or style.

    Parameters
    ----------
    markdown : str

    Returns
    -------
    str
        Looks the same. What is harmless already stays as it is.
    """
    text = _TAG.sub("<" + NO_WIDTH, markdown)
    text = _ADDRESS.sub(lambda found: "]" + _gap(found[1]), text)
    text = _DIAGRAM.sub(r"\1text ", text)
    return _FORMULA.sub(lambda found: "\\" + NO_WIDTH, text)


def _gap(address: str) -> str:
    """What parts a link from its address where the address is none of a page."""
    plain = html.unescape(address).replace("\\", "")
    scheme = _SCHEME.match("".join(c for c in plain if c.isprintable() and not c.isspace()))
    return NO_WIDTH if scheme and scheme[1].lower() not in SCHEMES else ""


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
