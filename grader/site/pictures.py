"""Files beside the pages: pictures and scenes, each once, by what is in it."""

from __future__ import annotations

import hashlib
import io
from html import escape

PLACE = "_static/shown"


class Pictures:
    """Collects what pages show; `files` has the content by its place in the site."""

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}

    def keep(self, content: bytes, suffix: str) -> str:
        """The place of some content in the site, the same for the same bytes."""
        place = f"{PLACE}/{hashlib.sha256(content).hexdigest()[:20]}{suffix}"
        self.files[place] = content
        return place

    def tag(self, content: bytes, alt: str, up: str, width: int | None = None) -> str:
        """A picture as HTML, which a page fetches when it comes near and keeps room for.

        Parameters
        ----------
        content : bytes
            Of a PNG or GIF file.
        alt : str
        up : str
            Way from the page to the site's root, such as ``../``.
        width : int, optional
            In which it is shown, in pixels; by default its own.
        """
        from PIL import Image

        with Image.open(io.BytesIO(content)) as picture:
            (across, down), suffix = picture.size, f".{picture.format.lower()}"
        shown = width or across
        return (
            f'<img src="{up}{self.keep(content, suffix)}" alt="{escape(alt)}" loading="lazy" '
            f'width="{shown}" height="{round(down * shown / across)}">'
        )
