"""Where an exported file goes: never over a file that is another."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from grader.course.atomic_files import write_atomically
from grader.lms.exporters.protocol import ExportTrouble


def place(
    content: bytes, wish: Path | None, usual: Path, given: Path | None
) -> tuple[Path, Path | None]:
    """Write a file, whole or not at all.

    Parameters
    ----------
    content : bytes
    wish : Path or None
        Where it was said to go: a file, or a folder for the usual name.
    usual : Path
        Where it goes otherwise. What lies there already is put aside.
    given : Path or None
        The file that was filled in. It stays as it is.

    Returns
    -------
    (Path, Path or None)
        Where it is now, and where what lay there before.

    Raises
    ------
    ExportTrouble
    """
    path = wish / usual.name if wish and wish.is_dir() else wish or usual
    if given and path.exists() and path.samefile(given):
        raise ExportTrouble(
            f"{path} is the file that is filled in, and stays as it is. Name another with --to."
        )
    try:
        before = None
        if path.exists() and path.read_bytes() != content:
            if path != usual:
                raise ExportTrouble(f"{path} is there already. Name another file, or remove it.")
            before = _aside(path)
            path.rename(before)
        try:
            write_atomically(content, path)
        except BaseException:
            if before:
                before.rename(path)
            raise
    except OSError as error:
        raise ExportTrouble(f"{path} cannot be written: {error.strerror}.") from error
    return path, before


def _aside(path: Path) -> Path:
    """A name that is free, with the time of the file in it."""
    time = datetime.fromtimestamp(path.stat().st_mtime)
    aside = path.with_name(f"{path.stem}.until-{time:%Y%m%d-%H%M%S}{path.suffix}")
    number = 2
    while aside.exists():
        aside = aside.with_name(f"{path.stem}.until-{time:%Y%m%d-%H%M%S}-{number}{path.suffix}")
        number += 1
    return aside
