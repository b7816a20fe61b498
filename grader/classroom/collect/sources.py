"""Open an archive from the command line: a zip, a folder or a single file."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path

from grader.classroom.collect.models import Archive, ArchiveEntry, CollectError, UnreadableFile
from grader.classroom.collect.zips import MAX_FILES, clean_path, is_hidden, open_zip
from grader.intake.notebook import read_file
from grader.intake.submission import walk_submitted
from utils.notebooks.reading import UnreadableNotebook


def open_archive(path: Path) -> Archive:
    """Open a zip, a folder or a single file as an archive.

    Raises
    ------
    CollectError
    """
    if path.is_dir():
        files = list(_files_below(path))
    elif not path.exists():
        raise CollectError(f"{path} does not exist. Correct the path.")
    elif zipfile.is_zipfile(path):
        try:
            files = open_zip(str(path), MAX_FILES)
        except UnreadableFile as error:
            raise CollectError(f"{path} {error}. Download it again.") from None
    elif path.suffix.lower() == ".zip":
        raise CollectError(f"{path} is not a complete zip. Download it again.")
    else:
        files = [((path.name,), _entry(path, (path.name,)))]
    entries = tuple(entry for parts, entry in files if not is_hidden(parts))
    if not entries:
        raise CollectError(f"{path} is empty. Name another archive or folder.")
    checkouts = {parts[: parts.index(".git")] for parts, _ in files if ".git" in parts}
    return Archive(path, entries, frozenset(checkouts))


def _files_below(root: Path) -> Iterator[tuple[tuple[str, ...], ArchiveEntry]]:
    """Yield the files in a folder without following links, and one entry for each .git folder."""
    for folder, folders, files in walk_submitted(root):
        folders[:] = sorted(name for name in folders if name == ".git" or not is_hidden((name,)))
        for name in sorted(files):
            path = folder / name
            path_parts = clean_path(path.relative_to(root).as_posix())
            yield path_parts, _entry(path, path_parts)
        if ".git" in folders:
            folders.remove(".git")
            path_parts = (*clean_path(folder.relative_to(root).as_posix()), ".git")
            yield path_parts, ArchiveEntry(path_parts, datetime.min, bytes)


def _entry(path: Path, parts: tuple[str, ...]) -> ArchiveEntry:
    moment = datetime.fromtimestamp(path.lstat().st_mtime)
    return ArchiveEntry(parts, moment, _reader(path))


def _reader(path: Path) -> Callable[[], bytes]:
    def read() -> bytes:
        try:
            return read_file(path)
        except UnreadableNotebook as error:
            raise UnreadableFile(str(error).removeprefix(path.name).strip(" .")) from None

    return read
