"""Store files in ``submitted/<student>/<stage>/`` without overwriting anything silently.

When a newer file replaces a file, the old one is kept in ``.older/`` in the same folder and is not
judged.

A submission time applies only to the files collected with it, so the record has a time for each
file. ``timestamp.txt`` is computed from these times. It is removed before anything changes and
written at the end, so after an interruption the record says that the time is unknown.
"""

from __future__ import annotations

import dataclasses
import hashlib
import os
from collections.abc import Collection, Iterator
from datetime import UTC, datetime
from pathlib import Path

from grader.classroom.collect.record import FileOrigin, Record, read_record, write_record
from grader.classroom.collect.worksheet import read_time
from grader.classroom.collect.zips import is_hidden
from grader.classroom.submissions import Submission
from grader.course.atomic_files import write_atomically
from grader.intake.notebook import read_file
from utils.notebooks.reading import UnreadableNotebook

NEW, NEWER, SAME, KEPT = "new", "newer", "same", "kept"
OLDER_FOLDER = ".older"
TIMESTAMP_FILE = "timestamp.txt"
_INTERRUPTED = "collecting was interrupted before the submission time was written; collect again"
_RESUBMITTED = "it was submitted again, and the time is unknown"
_UNREADABLE_TIME = "timestamp.txt does not contain a valid time"


class UnclearVersion(Exception):
    """A person has to decide which of two files counts; the message explains what to do."""


def digest_of(data: bytes) -> str:
    """Return the SHA-256 of `data` in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


class StageFolder:
    """A student's folder of one stage.

    Parameters
    ----------
    path : pathlib.Path
        ``submitted/<student>/<stage>``; created when a file is placed there.
    when : datetime, optional
        Submission time of the files that are placed now.
    undecided : str, optional
        Why that time is unknown; empty if it is known or no times were given.
    """

    def __init__(self, path: Path, when: datetime | None = None, undecided: str = "") -> None:
        self.path = path
        self._record = read_record(path)
        self._when, self._undecided = when.astimezone(UTC).isoformat() if when else "", undecided
        self._placed: dict[str, str] = {}

    def place(
        self, name: str, data: bytes, origin: FileOrigin, current: Submission | None = None
    ) -> str:
        """Place a file, or keep the existing one.

        Parameters
        ----------
        name : str
        data : bytes
        origin : FileOrigin
        current : Submission, optional
            The submission that counts for the lesson now, under any name.

        Returns
        -------
        {"new", "newer", "same", "kept"}
            Whether there was no file before, an older one, the same one, or a newer one.

        Raises
        ------
        UnclearVersion
        """
        if self._placed.setdefault(name, origin.digest) != origin.digest:
            raise UnclearVersion(
                f"differs from the {name} next to another notebook of this student. In "
                f"{self._relative(self.path)}, create one folder per notebook, and move each "
                f"notebook there with its {name}"
            )
        existing = current.path if current else self.path / name
        if not os.path.lexists(existing):
            self._write(name, data, origin)
            return NEW
        existing_digest = _digest_of_file(existing)
        recorded = self._record.files.get(existing.name)
        if existing_digest == origin.digest:
            if existing.parent == self.path:
                self._record_unchanged(existing.name, origin, recorded)
            return SAME
        if recorded is None or recorded.digest != existing_digest or existing.parent != self.path:
            reason = "was changed after it was collected" if recorded else "was added by hand"
            raise UnclearVersion(
                f"differs from {self._relative(existing)}, which {reason}. Delete one of the two"
            )
        newer = origin.newer_than(recorded)
        if newer is None:
            raise UnclearVersion(
                f"differs from {self._relative(existing)}, and it is unknown which one is "
                "newer. To collect this one, delete the other"
            )
        if not newer:
            return KEPT
        self._write(name, data, origin, existing)
        return NEWER

    def has_collected(self, name: str, digest: str) -> bool:
        """Return whether an identical file was collected earlier and is still there."""
        origin = self._record.files.get(name)
        return bool(origin and origin.digest == digest and (self.path / name).is_file())

    def outdated_digests(self, name: str) -> Collection[str]:
        """Return the SHA-256 digests of files that the instructor passed over for this one."""
        origin = self._record.files.get(name)
        return origin.beaten if origin else ()

    def write_time(self) -> str:
        """Write the submission time to nbgrader's ``timestamp.txt``.

        Returns
        -------
        str
            Why the time is unknown; empty if it is known or not needed.
        """
        path = self.path / TIMESTAMP_FILE
        if not self.path.is_dir() or path.is_file():
            return ""
        when, undecided = self._record.submission_time(self.path)
        if when:
            when = when.replace(microsecond=0)
            self._save_record(dataclasses.replace(self._record, written=when.isoformat()))
            write_atomically(_timestamp_line(when), path)
        if undecided != self._record.undecided:
            self._save_record(dataclasses.replace(self._record, undecided=undecided))
        return undecided

    def is_late(self) -> bool:
        """Return whether the learning platform marked a collected file late."""
        return any(origin.late for origin in self._record.files.values())

    def _write(self, name: str, data: bytes, origin: FileOrigin, older: Path | None = None) -> None:
        """Write a file and record its own submission time, never the time of another file."""
        was_timed = (self.path / TIMESTAMP_FILE).is_file() or any(
            file.when for file in self._record.files.values()
        )
        self._remove_time()
        undecided = self._undecided or (_RESUBMITTED if was_timed and not self._when else "")
        if older:
            self._back_up(older)
        write_atomically(data, self.path / name)
        self._record_file(name, dataclasses.replace(origin, when=self._when, undecided=undecided))

    def _record_unchanged(self, name: str, origin: FileOrigin, recorded: FileOrigin | None) -> None:
        """Record a file that is already in place, with its earlier or its new time."""
        known = recorded if recorded and recorded.digest == origin.digest else None
        if (self.path / TIMESTAMP_FILE).is_file() or (known and known.when):
            when, undecided = (known.when, known.undecided) if known else ("", "")
        else:
            when = self._when
            undecided = "" if when else self._undecided or (known.undecided if known else "")
        newer = known is None or origin.newer_than(known)
        updated = dataclasses.replace(origin if newer else known, when=when, undecided=undecided)
        if updated == recorded:
            return
        if not (self.path / TIMESTAMP_FILE).is_file():
            self._remove_time()
        self._record_file(name, updated)

    def _remove_time(self) -> None:
        """Remove ``timestamp.txt`` before its time becomes wrong.

        A time that `write_time` did not write was entered by hand and applies to all files.
        """
        path = self.path / TIMESTAMP_FILE
        record = dataclasses.replace(self._record, undecided=_INTERRUPTED)
        if path.is_file():
            stated_time = _read_timestamp(path)
            if stated_time is None or stated_time.isoformat() != record.written:
                record = self._with_time_set_by_hand(record, stated_time)
            self._back_up(path)
        if record != self._record:
            self._save_record(record)
        path.unlink(missing_ok=True)

    def _with_time_set_by_hand(self, record: Record, stated_time: datetime | None) -> Record:
        when, undecided = (stated_time.isoformat(), "") if stated_time else ("", _UNREADABLE_TIME)
        files = {
            name: dataclasses.replace(origin, when=when, undecided=undecided)
            for name, origin in record.files.items()
        }
        present = {path.relative_to(self.path) for path in self.path.rglob("*.ipynb")}
        uncollected = {
            path for path in present if not is_hidden(path.parts) and path.as_posix() not in files
        }
        others = max(record.others, when) if uncollected else record.others
        return dataclasses.replace(record, files=files, others=others)

    def _record_file(self, name: str, origin: FileOrigin) -> None:
        files = {**self._record.files, name: origin}
        self._save_record(dataclasses.replace(self._record, files=files))

    def _save_record(self, record: Record) -> None:
        write_record(record, self.path)
        self._record = record

    def _back_up(self, path: Path) -> None:
        data = path.read_bytes()
        if digest_of(data) not in map(_digest_of_file, (self.path / OLDER_FOLDER).glob("*")):
            write_atomically(data, next(self._free_names(path)))

    def _free_names(self, path: Path) -> Iterator[Path]:
        number = 1
        while True:
            free = self.path / OLDER_FOLDER / f"{path.stem}.{number}{path.suffix}"
            if not free.exists():
                yield free
            number += 1

    def _relative(self, path: Path) -> str:
        return path.relative_to(self.path.parents[2]).as_posix()


def _digest_of_file(path: Path) -> str:
    try:
        return digest_of(read_file(path))
    except UnreadableNotebook:
        return ""


def _timestamp_line(when: datetime) -> str:
    return when.astimezone(UTC).strftime("%Y-%m-%d %H:%M:%S UTC\n")


def _read_timestamp(path: Path) -> datetime | None:
    """Return the time in a ``timestamp.txt``, or None if it cannot be read."""
    try:
        time = read_time(read_file(path).decode("utf-8", "replace").strip(), "en", UTC)
        return time and time.astimezone(UTC)
    except (UnreadableNotebook, OverflowError):
        return None
