"""Find the pictures in text cells, and turn those that can be shown safely into attachments.

Programs write pictures in many ways: as attachments with encoded names, as ``data:`` addresses, as
references and as HTML tags. The pages for graders and students show only one of them,
``![text](attachment:name)`` with a plain name. A sentence replaces a picture that cannot be shown.
"""

from __future__ import annotations

import base64
import binascii
import functools
import hashlib
import html
import re
from collections.abc import Iterable
from dataclasses import dataclass
from urllib.parse import unquote, urlsplit

from grader.untrusted_text import one_line
from utils.notebooks.reading import Cell

MAX_PICTURE_BYTES = 5 * 2**20
"""Maximum size of a picture in bytes."""
MAX_NAME_LENGTH = 80
MAX_DESCRIPTION_LENGTH = 200
_SIGNATURES = (
    (re.compile(rb"\x89PNG"), "png"),
    (re.compile(rb"\xff\xd8\xff"), "jpeg"),
    (re.compile(rb"GIF8"), "gif"),
    (re.compile(rb"RIFF....WEBP", re.DOTALL), "webp"),
)
_MARKDOWN_SYNTAX = re.compile(r"[][\\\n]")
_PLAIN_NAME = re.compile(r"[\w.+\-]{1,100}", re.ASCII)  # nbconvert encodes other characters

# Each repetition is limited, or ends before the next match could begin. Matching therefore takes
# linear time.
_TEXT = r"(?:[^\[\]]|\[[^\[\]]{0,300}+\]){0,300}"
_IN_ANGLES = r"<[^<>\n]*+>"
_IN_BRACKETS = r"(?:[^()<>\"\n]++|\([^()<>\"\n]{0,300}+\))*"
_PICTURE = re.compile(
    rf"!\[(?P<text>{_TEXT})\]\(\s*+(?P<address>{_IN_ANGLES}|{_IN_BRACKETS})"
    r"(?:\"[^\"\n]{0,300}+\")?\s*+\)"
    rf"|!\[(?P<described>{_TEXT})\](?:\[(?P<label>[^\[\]\n]{{0,300}}+)\])?"
    r"|<img(?=[\s/])(?P<attributes>[^<>]*+)>",
    re.IGNORECASE,
)
_DEFINITION = re.compile(
    rf"^ {{0,3}}\[(?P<label>[^\[\]\n]{{1,300}}+)\]:[ \t]*+(?P<address>{_IN_ANGLES}|\S++)[^\n]*+",
    re.MULTILINE,
)
_TITLE = re.compile(r"\s'[^']{0,300}'\s*+\Z")
_VALUE = r"\s{0,9}=\s{0,9}(?:\"([^\"]*+)\"|'([^']*+)'|([^\s\"']++))"
_SOURCE = re.compile(rf"(?<![\w-])src{_VALUE}", re.IGNORECASE)
_DESCRIPTION = re.compile(rf"(?<![\w-])alt{_VALUE}", re.IGNORECASE)


@dataclass(frozen=True)
class IllustratedText:
    """A text with the pictures that can be shown.

    Attributes
    ----------
    text : str
        Markdown, which is still untrusted; its pictures are attachments with plain names.
    attachments : dict
        Valid pictures by name, in the format of the notebook file.
    not_shown : tuple of str
        For each picture that cannot be shown, its name and the reason.
    """

    text: str
    attachments: dict[str, dict[str, str]]
    not_shown: tuple[str, ...] = ()


class _PictureNotShown(Exception):
    """The reason why a picture cannot be shown."""


def illustrate(cells: Iterable[Cell]) -> IllustratedText:
    """Combine the texts and the pictures of text cells."""
    attachments: dict[str, dict[str, str]] = {}
    not_shown: list[str] = []
    texts = []
    for cell in cells:
        cell_attachments = {unquote(name): content for name, content in cell.attachments.items()}
        definitions = {
            _normalize_label(definition["label"]): definition["address"]
            for definition in _DEFINITION.finditer(cell.source)
        }
        replace = functools.partial(
            _replace_picture, cell_attachments, definitions, attachments, not_shown
        )
        texts.append(_DEFINITION.sub(_remove_data, _PICTURE.sub(replace, cell.source)))
    return IllustratedText("\n\n".join(texts), attachments, tuple(not_shown))


def _replace_picture(
    cell_attachments: dict[str, object],
    definitions: dict[str, str],
    attachments: dict[str, dict[str, str]],
    not_shown: list[str],
    match: re.Match,
) -> str:
    """Return the Markdown for a picture; add it to `attachments`, or the reason to `not_shown`."""
    description, address = _description_and_address(match, definitions)
    if not address:
        return match[0]
    name = _picture_name(description, address)
    try:
        mime_type, data = _find_picture(address, cell_attachments)
    except _PictureNotShown as reason:
        not_shown.append(f"{name} {reason}")
        return f"(Picture not shown: `{name}` {reason}.)"
    picture = {mime_type: data}
    if not _PLAIN_NAME.fullmatch(name) or attachments.get(name, picture) != picture:
        digest = hashlib.sha256(data.encode()).hexdigest()[:16]
        name = f"{digest}.{mime_type.removeprefix('image/')}"
    attachments[name] = picture
    words = _MARKDOWN_SYNTAX.sub(" ", description)[:MAX_DESCRIPTION_LENGTH]
    return f"![{words}](attachment:{name})"


def _description_and_address(match: re.Match, definitions: dict[str, str]) -> tuple[str, str]:
    """Return a picture's description and address; the address is empty if it is not a picture."""
    if match["attributes"] is not None:
        source = _SOURCE.search(match["attributes"])
        description = _DESCRIPTION.search(match["attributes"])
        return _attribute_value(description), _attribute_value(source)
    if match["address"] is not None:
        return match["text"], _TITLE.sub("", match["address"]).strip().strip("<>")
    label = _normalize_label(match["label"] or match["described"])
    return match["described"], definitions.get(label, "").strip("<>")


def _attribute_value(attribute: re.Match | None) -> str:
    return next(filter(None, attribute.groups()), "").strip() if attribute else ""


def _normalize_label(text: str) -> str:
    return " ".join(text.split()).casefold()


def _remove_data(definition: re.Match) -> str:
    """Remove a definition that contains a picture's data, because pages would show it as text."""
    return "" if definition["address"].strip("<>").lower().startswith("data:") else definition[0]


def _picture_name(description: str, address: str) -> str:
    """Return a name for a picture, which can be quoted in a sentence or in Markdown code."""
    scheme, _, rest = address.partition(":")
    if scheme.lower() == "data":
        name = description
    elif scheme.lower() == "attachment":
        name = _attachment_name(rest)
    else:
        name = address
    return one_line(name.replace("`", ""))[:MAX_NAME_LENGTH] or "picture"


def _attachment_name(address: str) -> str:
    return unquote(html.unescape(address))


def _find_picture(address: str, cell_attachments: dict[str, object]) -> tuple[str, str]:
    """Return the MIME type and the Base64 text of the picture at an address."""
    scheme, _, rest = address.partition(":")
    if scheme.lower() == "data":
        head, _, data = rest.partition(",")
        return _check_picture(unquote(data) if head.lower().endswith(";base64") else "")
    if scheme.lower() == "attachment":
        content = cell_attachments.get(_attachment_name(rest))
        if not isinstance(content, dict) or not content:
            raise _PictureNotShown("is missing from the notebook")
        return _first_picture(content)
    try:
        is_elsewhere = bool(urlsplit(address).netloc)
    except ValueError:
        is_elsewhere = True
    raise _PictureNotShown("is on another site" if is_elsewhere else "is not inside the notebook")


def _first_picture(content: dict) -> tuple[str, str]:
    """Return the first valid picture among the versions of an attachment."""
    reason = None
    for data in content.values():
        lines = data if isinstance(data, list) else [data]
        try:
            return _check_picture("".join(line for line in lines if isinstance(line, str)))
        except _PictureNotShown as error:
            reason = error
    raise reason


def _check_picture(data: str) -> tuple[str, str]:
    """Return the MIME type and the Base64 text of a picture; the type is found from its bytes."""
    data = "".join(data.split())
    if len(data) > MAX_PICTURE_BYTES * 4 / 3 + 4:
        raise _PictureNotShown(f"is larger than {MAX_PICTURE_BYTES // 2**20} MB")
    try:
        content = base64.b64decode(data, validate=True)
    except (binascii.Error, ValueError):
        content = b""
    for signature, kind in _SIGNATURES:
        if signature.match(content):
            return f"image/{kind}", data
    raise _PictureNotShown("is not a PNG, JPEG, GIF or WebP picture")
