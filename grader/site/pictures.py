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
        path = f"{FOLDER}/{hashlib.sha256(content).hexdigest()[:20]}{suffix}"
        self.files[path] = content
        return path

    def tag(self, content: bytes, alt: str, path_to_root: str, width: int | None = None) -> str:
        """Store a picture and return its HTML tag, with lazy loading and a fixed size.

        Parameters
        ----------
        content : bytes
            Content of a PNG or GIF file.
        alt : str
        path_to_root : str
            Relative path from the page to the site's root, such as ``../``.
        width : int, optional
            Width on the page in pixels. Default: the width of the picture.
        """
        from PIL import Image

        with Image.open(io.BytesIO(content)) as picture:
            (full_width, full_height), suffix = picture.size, f".{picture.format.lower()}"
        shown_width = width or full_width
        return (
            f'<img src="{path_to_root}{self.keep(content, suffix)}" alt="{escape(alt)}" '
            'loading="lazy" '
            f'width="{shown_width}" height="{round(full_height * shown_width / full_width)}">'
        )
