"""Pictures and scenes as separate files of the site. Equal content is stored only once."""

from __future__ import annotations

import hashlib
import io
from html import escape

FOLDER = "_static/shown"


class Pictures:
    """Collection of the files that pages show. `files` maps the path in the site to the content."""

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}

    def keep(self, content: bytes, suffix: str) -> str:
        """Store a file and return its path in the site, which is derived from the content."""
        place = f"{FOLDER}/{hashlib.sha256(content).hexdigest()[:20]}{suffix}"
        self.files[place] = content
        return place

    def tag(self, content: bytes, alt: str, up: str, width: int | None = None) -> str:
        """Store a picture and return its HTML tag, with lazy loading and a fixed size.

        Parameters
        ----------
        content : bytes
            Content of a PNG or GIF file.
        alt : str
        up : str
            Relative path from the page to the site's root, such as ``../``.
        width : int, optional
            Width on the page in pixels. Default: the width of the picture.
        """
        from PIL import Image

        with Image.open(io.BytesIO(content)) as picture:
            (full_width, full_height), suffix = picture.size, f".{picture.format.lower()}"
        shown = width or full_width
        return (
            f'<img src="{up}{self.keep(content, suffix)}" alt="{escape(alt)}" loading="lazy" '
            f'width="{shown}" height="{round(full_height * shown / full_width)}">'
        )
