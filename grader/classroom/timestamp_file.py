"""Read and write ``timestamp.txt``, in which nbgrader stores the submission time of a stage."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from grader.course.tables import decode_text
from grader.course.times import UnclearTime, read_time, to_utc
from grader.intake.notebook import read_file
from utils.notebooks.reading import UnreadableNotebook

TIMESTAMP_FILE = "timestamp.txt"


@dataclass(frozen=True)
class Timestamp:
    """The time in a ``timestamp.txt``.

    Attributes
    ----------
    when : datetime
        In UTC.
    has_zone : bool
        Whether the file states a time zone. nbgrader writes and reads times without one in UTC.
    """

    when: datetime
    has_zone: bool


def read_timestamp(folder: Path) -> Timestamp | None:
    """Read the submission time in a folder; None if the folder has no ``timestamp.txt``.

    Raises
    ------
    UnclearTime
        The message is a sentence without a full stop.
    """
    path = folder / TIMESTAMP_FILE
    if not path.is_file():
        return None
    try:
        text = decode_text(read_file(path), "replace").strip()
    except UnreadableNotebook as error:
        raise UnclearTime(str(error).partition(". ")[0].removesuffix(".")) from None
    if not text:  # nbgrader leaves an empty file if the disk is full
        raise UnclearTime(f"{TIMESTAMP_FILE} is empty")
    try:
        time = read_time(text)
    except UnclearTime as reason:
        raise UnclearTime(f"{TIMESTAMP_FILE} {reason}") from None
    return Timestamp(to_utc(time, UTC), time.tzinfo is not None)


def format_timestamp(when: datetime) -> str:
    """Return a time as nbgrader writes it, to the second."""
    return when.astimezone(UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
