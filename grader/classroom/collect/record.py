"""The record of the files collected into a student's folder, with their origins and times.

It is stored next to the work, as ``.collected.json``, so that it is deleted with the folder.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
from collections.abc import Collection
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from grader.classroom.timestamp_file import read_timestamp
from grader.course.atomic_files import write_atomically
from grader.course.times import UnclearTime

RECORD_NAME = ".collected.json"


@dataclass(frozen=True)
class FileOrigin:
    """Where a file came from, and when it was submitted.

    Attributes
    ----------
    digest : str
        SHA-256 of the placed file.
    archive : str
        Names of the archive and of the file in it.
    moment : str
        The time in the archive, in ISO 8601.
    order : int
        Sort key among archives of the same format: higher is newer, and 0 is unknown.
    late : bool
        Whether the learning platform marked the file late.
    participant : str
        Moodle's number for the owner, which is a student or a team.
    beaten : tuple of str
        SHA-256 digests of this lesson's other files. The instructor chose this file instead.
    when : str
        Submission time in ISO 8601; empty if it is unknown.
    when_text : str
        How the table of submission times states it; empty if the time is from another source.
    undecided : str
        Why the submission time is unknown; empty if it is known or not needed.
    """

    digest: str
    archive: str
    moment: str
    order: int = 0
    late: bool = False
    participant: str = ""
    beaten: tuple[str, ...] = ()
    when: str = ""
    when_text: str = ""
    undecided: str = ""

    def is_newer_than(self, other: FileOrigin) -> bool | None:
        """Return whether this file was submitted after another one; None if that is unknown."""
        own_key, other_key = (self.order, self.moment), (other.order, other.moment)
        if not (self.order and other.order):
            own_key, other_key = own_key[1:], other_key[1:]
        return None if own_key == other_key else own_key > other_key


@dataclass(frozen=True)
class Record:
    """The files that were collected into one folder.

    Attributes
    ----------
    files : dict of str to FileOrigin
        Origins by the file's name in the folder.
    undecided : str
        Why the submission time is unknown; empty if it is known or not needed.
    others : str
        Submission time of files that were not collected, from a ``timestamp.txt``, in ISO 8601.
    written : str
        The time that collecting last wrote to ``timestamp.txt``, in ISO 8601. Any other time in
        that file was entered by hand.
    """

    files: dict[str, FileOrigin] = field(default_factory=dict)
    undecided: str = ""
    others: str = ""
    written: str = ""

    def submission_time(self, folder: Path) -> tuple[datetime | None, str]:
        """Return the submission time of the whole folder, or the reason why it is unknown."""
        present = {name: origin for name, origin in self.files.items() if (folder / name).is_file()}
        for origin in present.values():
            if origin.undecided:
                return None, origin.undecided
        times = [
            when for when in (self.others, *(origin.when for origin in present.values())) if when
        ]
        untimed = [name for name, origin in present.items() if not origin.when]
        if times and untimed:
            return None, f"the submission time of {min(untimed)} is unknown"
        return max(map(datetime.fromisoformat, times), default=None), ""


def read_record(folder: Path) -> Record:
    """Return the record of a folder; an empty record if the file is missing or unreadable."""
    with contextlib.suppress(OSError, ValueError, TypeError, KeyError, AttributeError):
        content = json.loads((folder / RECORD_NAME).read_text("utf-8"))
        files = {name: FileOrigin(**origin) for name, origin in content["files"].items()}
        return Record(**(content | {"files": files}))
    return Record()


def file_time(path: Path) -> datetime | None:
    """Return when a file was submitted, or None if only the time of its whole folder is known.

    A time that a person, or nbgrader's exchange, wrote into ``timestamp.txt`` applies to all files.
    """
    record = read_record(path.parent)
    origin = record.files.get(path.name)
    with contextlib.suppress(UnclearTime):
        timestamp = read_timestamp(path.parent)
        if origin and origin.when and timestamp and timestamp.when.isoformat() == record.written:
            return datetime.fromisoformat(origin.when).replace(microsecond=0)
    return None


def write_record(record: Record, folder: Path) -> None:
    """Write the record of a folder."""
    write_atomically(json.dumps(dataclasses.asdict(record), indent=1), folder / RECORD_NAME)


def remove_archives(record: Record, archives: Collection[str]) -> Record:
    """Return a record without the given archive names, which may contain a student's name."""
    files = {
        name: dataclasses.replace(origin, archive="") if origin.archive in archives else origin
        for name, origin in record.files.items()
    }
    return dataclasses.replace(record, files=files)


def unknown_time_reason(folder: Path) -> str:
    """Return why the submission time of a folder is unknown.

    The result is empty if a ``timestamp.txt`` states the time, or if the learning platform marked
    nothing late and no table of times was given.
    """
    if (folder / "timestamp.txt").is_file():
        return ""
    record = read_record(folder)
    late = any(origin.late and (folder / name).is_file() for name, origin in record.files.items())
    late_reason = "the learning platform marks the work as late, but gives no time"
    return record.undecided or (late_reason if late else "")
