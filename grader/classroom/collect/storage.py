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
from datetime import datetime
from pathlib import Path

from grader.classroom.collect.record import FileOrigin, Record, read_record, write_record
from grader.classroom.collect.stated_time import NOTHING_STATED, StatedTime
from grader.classroom.collect.zips import is_hidden
from grader.classroom.submissions import Submission
from grader.classroom.timestamp_file import TIMESTAMP_FILE, format_timestamp, read_timestamp
from grader.course.atomic_files import write_atomically
from grader.course.times import UnclearTime
from grader.intake.notebook import read_file
from utils.notebooks.reading import UnreadableNotebook

NEW, NEWER, SAME, KEPT = "new", "newer", "same", "kept"
OLDER_FOLDER = ".older"
_INTERRUPTED_REASON = (
    "collecting was interrupted before the submission time was written; collect again"
)
_RESUBMITTED_REASON = "the work was submitted again, and the time is unknown"


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
    stated_time : StatedTime, optional
    """

    def __init__(self, path: Path, stated_time: StatedTime = NOTHING_STATED) -> None:
        self.path = path
        self._record = read_record(path)
        self._stated = stated_time
        self._time_before, _ = _read_time(path)
        self._placed: dict[str, str] = {}
        self._is_new = self._is_unchanged = False
        self._keeps_time_by_hand = False

    def place(
        self,
        name: str,
        data: bytes,
        origin: FileOrigin,
        current_submission: Submission | None = None,
    ) -> str:
        """Place a file, or keep the existing one.

        Parameters
        ----------
        name : str
        data : bytes
        origin : FileOrigin
        current_submission : Submission, optional
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
                f"differs from the {name} next to another of this student's notebooks. In "
                f"{self._relative_path(self.path)}, create one folder per notebook, and move each "
                f"notebook into its folder together with its {name}"
            )
        existing = current_submission.path if current_submission else self.path / name
        if not os.path.lexists(existing):
            self._write(name, data, origin)
            return NEW
        existing_digest = _digest_of_file(existing)
        recorded_origin = self._record.files.get(existing.name)
        if existing_digest == origin.digest:
            if existing.parent == self.path:
                self._record_unchanged(existing.name, origin, recorded_origin)
            return SAME
        if (
            recorded_origin is None
            or recorded_origin.digest != existing_digest
            or existing.parent != self.path
        ):
            reason = (
                "was changed after it was collected" if recorded_origin else "was added by hand"
            )
            raise UnclearVersion(
                f"differs from {self._relative_path(existing)}, which {reason}. Delete one of the "
                "two"
            )
        # The instructor's answer takes precedence over the times in the archive.
        newer = existing_digest in origin.beaten or origin.is_newer_than(recorded_origin)
        if newer is None:
            raise UnclearVersion(
                f"differs from {self._relative_path(existing)}, and it is unknown which of the "
                "two is newer. To collect this file, delete the other"
            )
        if not newer:
            return KEPT
        self._write(name, data, origin, existing)
        return NEWER

    def has_collected(self, name: str, digest: str) -> bool:
        """Return whether an identical file was collected earlier and is still there."""
        origin = self._record.files.get(name)
        return bool(origin and origin.digest == digest and (self.path / name).is_file())

    def rejected_digests(self, name: str) -> Collection[str]:
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
            return _read_time(self.path)[1]
        when, undecided = self._record.submission_time(self.path)
        if when:
            when = when.replace(microsecond=0)
            self._save_record(dataclasses.replace(self._record, written=when.isoformat()))
            write_atomically(f"{format_timestamp(when)}\n", path)
        if undecided != self._record.undecided:
            self._save_record(dataclasses.replace(self._record, undecided=undecided))
        return undecided

    def time_remark(self) -> str:
        """Explain whether a time in the table replaced an earlier time.

        Returns
        -------
        str
            A sentence without a full stop. It is empty if files were new, or if the times agree.
        """
        now, _ = _read_time(self.path)
        is_about_same_files = self._is_unchanged or not self._stated.when
        if now is None or self._is_new or not is_about_same_files:
            return ""
        file = self._relative_path(self.path / TIMESTAMP_FILE)
        return self._stated.remark(self._time_before, now, file, self._keeps_time_by_hand)

    def is_late(self) -> bool:
        """Return whether the learning platform marked a collected file late."""
        return any(origin.late for origin in self._record.files.values())

    def _write(
        self, name: str, data: bytes, origin: FileOrigin, backup: Path | None = None
    ) -> None:
        """Write a file, and record the submission time of this file alone."""
        was_timed = (self.path / TIMESTAMP_FILE).is_file() or any(
            file.when for file in self._record.files.values()
        )
        self._remove_time()
        self._is_new = True
        reason = self._stated.undecided or (
            _RESUBMITTED_REASON if was_timed and not self._stated.when else ""
        )
        if backup:
            self._back_up(backup)
        write_atomically(data, self.path / name)
        self._record_file(name, self._stated.apply_to(origin, reason))

    def _record_unchanged(self, name: str, origin: FileOrigin, recorded: FileOrigin | None) -> None:
        """Record a file that is already in place, and decide which submission time counts."""
        self._is_unchanged = True
        known_origin = recorded if recorded and recorded.digest == origin.digest else None
        newer = known_origin is None or origin.is_newer_than(known_origin)
        updated_origin = origin if newer else known_origin
        is_by_hand = self._is_time_by_hand()
        if is_by_hand or (
            known_origin and known_origin.when and not self._stated.corrects(known_origin)
        ):
            self._keeps_time_by_hand |= is_by_hand or not known_origin.when_text
            updated_origin = dataclasses.replace(updated_origin, **_time_fields(known_origin))
        else:
            reason = self._stated.undecided or (known_origin.undecided if known_origin else "")
            updated_origin = self._stated.apply_to(updated_origin, reason)
        if updated_origin == recorded:
            return
        if not is_by_hand and _time_fields(known_origin) != _time_fields(updated_origin):
            self._remove_time()
        self._record_file(name, updated_origin)

    def _is_time_by_hand(self) -> bool:
        """Return whether ``timestamp.txt`` has a time that `write_time` did not write."""
        if not (self.path / TIMESTAMP_FILE).is_file():
            return False
        time, _ = _read_time(self.path)
        return time is None or time.isoformat() != self._record.written

    def _remove_time(self) -> None:
        """Remove ``timestamp.txt`` before its time becomes wrong.

        A time that `write_time` did not write was entered by hand and applies to all files.
        """
        path = self.path / TIMESTAMP_FILE
        record = dataclasses.replace(self._record, undecided=_INTERRUPTED_REASON)
        if self._is_time_by_hand():
            record = self._adopt_time_set_by_hand(record)
        if path.is_file():
            self._back_up(path)
        if record != self._record:
            self._save_record(record)
        path.unlink(missing_ok=True)

    def _adopt_time_set_by_hand(self, record: Record) -> Record:
        time, undecided = _read_time(self.path)
        when = time.isoformat() if time else ""
        files = {
            name: dataclasses.replace(origin, when=when, when_text="", undecided=undecided)
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
            write_atomically(data, next(self._unused_paths(path)))

    def _unused_paths(self, path: Path) -> Iterator[Path]:
        number = 1
        while True:
            candidate = self.path / OLDER_FOLDER / f"{path.stem}.{number}{path.suffix}"
            if not candidate.exists():
                yield candidate
            number += 1

    def _relative_path(self, path: Path) -> str:
        return path.relative_to(self.path.parents[2]).as_posix()


def _digest_of_file(path: Path) -> str:
    try:
        return digest_of(read_file(path))
    except UnreadableNotebook:
        return ""


def _time_fields(origin: FileOrigin | None) -> dict[str, str]:
    """Return the fields of an origin that state the submission time."""
    names = ("when", "when_text", "undecided")
    return {name: getattr(origin, name) if origin else "" for name in names}


def _read_time(folder: Path) -> tuple[datetime | None, str]:
    """Return the time in a folder's ``timestamp.txt``, and why it cannot be read."""
    try:
        timestamp = read_timestamp(folder)
    except UnclearTime as reason:
        return None, str(reason)
    return timestamp and timestamp.when, ""
