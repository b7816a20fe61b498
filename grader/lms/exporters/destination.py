"""Writing of exported files without overwriting a different file."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from grader.course.atomic_files import write_atomically
from grader.lms.exporters.protocol import ExportError


def write_export(
    content: bytes, wish: Path | None, usual: Path, given: Path | None
) -> tuple[Path, Path | None]:
    """Write a file, completely or not at all.

    Parameters
    ----------
    content : bytes
    wish : Path or None
        Destination that the user named: a file, or a folder for a file of the usual name.
    usual : Path
        Default destination. A different file that exists there is renamed.
    given : Path or None
        File that was filled in, which is never overwritten.

    Returns
    -------
    (Path, Path or None)
        Path of the new file, and new path of the renamed older file.

    Raises
    ------
    ExportError
        If the destination exists and must be kept, or if it cannot be written.
    """
    path = wish / usual.name if wish and wish.is_dir() else wish or usual
    if given and path.exists() and path.samefile(given):
        raise ExportError(
            f"{path} is the file that is filled in, and stays as it is. Name another with --to."
        )
    try:
        before = None
        if path.exists() and path.read_bytes() != content:
            if path != usual:
                raise ExportError(f"{path} exists already. Name another file, or delete it.")
            before = _unused_path(path)
            path.rename(before)
        try:
            write_atomically(content, path)
        except BaseException:
            if before:
                before.rename(path)
            raise
    except OSError as error:
        raise ExportError(f"{path} cannot be written: {error.strerror}.") from error
    return path, before


def _unused_path(path: Path) -> Path:
    """Return an unused name that contains the file's modification time."""
    time = datetime.fromtimestamp(path.stat().st_mtime)
    aside = path.with_name(f"{path.stem}.until-{time:%Y%m%d-%H%M%S}{path.suffix}")
    number = 2
    while aside.exists():
        aside = aside.with_name(f"{path.stem}.until-{time:%Y%m%d-%H%M%S}-{number}{path.suffix}")
        number += 1
    return aside
