"""A submission for one lesson.

Its files are read only once, so that the fingerprint belongs to the bytes that were judged.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from grader.intake.notebook import read_file
from utils.notebooks.reading import Notebook, UnreadableNotebook, decode_notebook

MAX_MODULES = 20
MAX_MODULE_BYTES = 2**20
MAX_FOLDER_DEPTH = 50
PACKAGE_FOLDERS = ("site-packages", "node_modules")
"""Folders of installed packages, such as those in a virtual environment."""


@dataclass(frozen=True)
class SubmittedFiles:
    """A submitted notebook, and the Python modules next to it.

    Attributes
    ----------
    name : str
        Name of the notebook file.
    data : bytes
        Content of the file; empty if it could not be read.
    complaint : str
        Why the file could not be read; empty if there was no problem.
    modules : dict of str to str
        Source of each ``.py`` file next to the notebook, by the name of the module.
    notes : tuple of str
        One sentence for each problem with the file itself.
    """

    name: str
    data: bytes
    complaint: str = ""
    modules: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def notebook(self) -> Notebook:
        """Parse the notebook.

        Raises
        ------
        utils.notebooks.reading.UnreadableNotebook
            If the file could not be read, or is not a notebook.
        """
        if self.complaint:
            raise UnreadableNotebook(self.complaint)
        return decode_notebook(self.data, self.name)

    def fingerprint(self) -> str:
        """Return a digest of the whole submission.

        Each part is preceded by its length, so two different submissions are never hashed as the
        same bytes.
        """
        modules = [text for module in sorted(self.modules.items()) for text in module]
        texts = (self.name, self.complaint, *self.notes, *modules)
        # A file name may contain bytes that are not valid UTF-8.
        parts = (self.data, *(text.encode(errors="surrogatepass") for text in texts))
        digest = hashlib.sha256(b"%d notes, %d modules: " % (len(self.notes), len(self.modules)))
        for part in parts:
            digest.update(b"%d " % len(part))
            digest.update(part)
        return digest.hexdigest()


def is_skipped_folder(name: str) -> bool:
    """Return whether a folder is hidden, made by a program or full of installed packages."""
    return name.startswith((".", "__")) or name in PACKAGE_FOLDERS


def walk_submitted(root: Path) -> Iterator[tuple[Path, list[str], list[str]]]:
    """Walk through submitted folders like `os.walk`, but at most `MAX_FOLDER_DEPTH` levels deep.

    Before Python 3.12, `os.walk` is recursive, so a very deep folder would raise `RecursionError`.
    """
    for folder, folders, files in os.walk(root):
        path = Path(folder)
        if len(path.relative_to(root).parts) >= MAX_FOLDER_DEPTH:
            folders.clear()
        yield path, folders, files


def read_submitted_files(path: Path) -> SubmittedFiles:
    """Read a notebook and the modules in its folder. Do not raise if a file is unreadable."""
    try:
        data, complaint = read_file(path), ""
    except UnreadableNotebook as error:
        data, complaint = b"", str(error)
    return SubmittedFiles(path.name, data, complaint, _modules_next_to(path))


def _modules_next_to(path: Path) -> dict[str, str]:
    modules = {}
    for file in sorted(path.parent.glob("*.py"))[:MAX_MODULES]:
        if not file.stem.isidentifier():
            continue  # Python cannot import it
        try:
            source = read_file(file)
        except UnreadableNotebook:
            continue
        if len(source) <= MAX_MODULE_BYTES:
            modules[file.stem] = source.decode("utf-8", "replace")
    return modules
