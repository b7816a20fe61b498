"""Write exported files without overwriting other files."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from grader.course.atomic_files import write_atomically
from grader.lms.exporters.protocol import ExportError


def write_export(
    content: bytes, destination: Path | None, default: Path, filled_in: Path | None
) -> tuple[Path, Path | None]:
    """Write a file, completely or not at all.

    Parameters
    ----------
    content : bytes
    destination : Path or None
        Destination that the user chose: a file, or a folder for a file with the default name.
    default : Path
        Default destination. A different file that exists there is renamed.
    filled_in : Path or None
        The LMS's file that was filled in, which is never overwritten.

    Returns
    -------
    (Path, Path or None)
        Path of the new file, and new path of the renamed older file.

    Raises
    ------
    ExportError
        If the destination exists and must be kept, or if it cannot be written.
    """
    path = destination or default
    if destination and destination.is_dir():
        path /= default.name
    if filled_in and path.exists() and path.samefile(filled_in):
        raise ExportError(
            f"{path} is the file named by --into, which is never overwritten. Name another file "
            "with --to."
        )
    try:
        renamed_path = None
        if path.exists() and path.read_bytes() != content:
            if path != default:
                raise ExportError(f"{path} already exists. Delete it, or change --to.")
            renamed_path = _unused_path(path)
            path.rename(renamed_path)
        try:
            write_atomically(content, path)
        except BaseException:
            if renamed_path:
                renamed_path.rename(path)
            raise
    except OSError as error:
        raise ExportError(f"{path} cannot be written: {error.strerror}.") from error
    return path, renamed_path


def _unused_path(path: Path) -> Path:
    """Return an unused name that contains the file's modification time."""
    time = datetime.fromtimestamp(path.stat().st_mtime)
    unused = path.with_name(f"{path.stem}.until-{time:%Y%m%d-%H%M%S}{path.suffix}")
    number = 2
    while unused.exists():
        unused = path.with_name(f"{path.stem}.until-{time:%Y%m%d-%H%M%S}-{number}{path.suffix}")
        number += 1
    return unused
