"""Store files in ``submitted/<student>/<stage>/`` without overwriting anything silently.

Files that newer ones replace are kept in ``.older/`` in the same folder, and are not judged.

A time belongs to the files that it came with, so the record has a time for each file.
``timestamp.txt`` is made from these: it is removed before anything changes and written at the
end. After an interruption the record therefore says that the time is undecided.
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
OLDER = ".older"
TIME = "timestamp.txt"
_STOPPED = "collecting was stopped before its time was written: collect it again"
_AGAIN = "it was handed in again, and no time is known"
_UNREAD = "timestamp.txt did not say a time that could be read"


class UnclearVersion(Exception):
    """A person has to decide which of two files counts; `str()` says what to do."""


def digest_of(data: bytes) -> str:
    """Return the SHA-256 of some bytes."""
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
        Why that time is unknown; empty if no times were given.
    """

    def __init__(self, path: Path, when: datetime | None = None, undecided: str = "") -> None:
        self.path = path
        self._record = read_record(path)
        self._when, self._undecided = when.astimezone(UTC).isoformat() if when else "", undecided
        self._placed: dict[str, str] = {}

    def place(
        self, name: str, data: bytes, source: FileOrigin, there: Submission | None = None
    ) -> str:
        """Place a file, or keep the one that is there.

        Parameters
        ----------
        name : str
        data : bytes
        source : FileOrigin
        there : Submission, optional
            The submission that counts for the lesson now, under any name.

        Returns
        -------
        {"new", "newer", "same", "kept"}
            Whether there was no file, an older one, the same one, or a newer one.

        Raises
        ------
        UnclearVersion
        """
        if self._placed.setdefault(name, source.digest) != source.digest:
            raise UnclearVersion(
                f"differs from the {name} beside another notebook of theirs. Move each of the two "
                f"notebooks into a folder of its own in {self._shown(self.path)}, with its {name}"
            )
        lying = there.path if there else self.path / name
        if not os.path.lexists(lying):
            self._write(name, data, source)
            return NEW
        lying_digest = _digest_of_file(lying)
        before = self._record.files.get(lying.name)
        if lying_digest == source.digest:
            if lying.parent == self.path:
                self._note_same(lying.name, source, before)
            return SAME
        if before is None or before.digest != lying_digest or lying.parent != self.path:
            how = "was changed since it was collected" if before else "was put there by hand"
            raise UnclearVersion(f"{self._shown(lying)} {how} and differs. Delete one of the two")
        newer = source.newer_than(before)
        if newer is None:
            raise UnclearVersion(
                f"differs from {self._shown(lying)}, and nothing tells which is newer. To take "
                "this one, delete that"
            )
        if not newer:
            return KEPT
        self._write(name, data, source, lying)
        return NEWER

    def holds(self, name: str, digest: str) -> bool:
        """Return whether an identical file was collected earlier and is still there."""
        source = self._record.files.get(name)
        return bool(source and source.digest == digest and (self.path / name).is_file())

    def outdated(self, name: str) -> Collection[str]:
        """Return the SHA-256 of files that do not count, according to an answer."""
        source = self._record.files.get(name)
        return source.beaten if source else ()

    def note_time(self) -> str:
        """Write the submission time to nbgrader's ``timestamp.txt``.

        Returns
        -------
        str
            Why the time is unknown; empty if it is known or was not looked for.
        """
        path = self.path / TIME
        if not self.path.is_dir() or path.is_file():
            return ""
        when, undecided = self._record.time(self.path)
        if when:
            when = when.replace(microsecond=0)
            self._keep(dataclasses.replace(self._record, written=when.isoformat()))
            write_atomically(_line(when), path)
        if undecided != self._record.undecided:
            self._keep(dataclasses.replace(self._record, undecided=undecided))
        return undecided

    def is_late(self) -> bool:
        """Return whether a collected file is marked late."""
        return any(source.late for source in self._record.files.values())

    def _write(self, name: str, data: bytes, source: FileOrigin, older: Path | None = None) -> None:
        """Write a file whose recorded time cannot be mistaken for that of another file."""
        was_timed = (self.path / TIME).is_file() or any(
            file.when for file in self._record.files.values()
        )
        self._forget_time()
        undecided = self._undecided or (_AGAIN if was_timed and not self._when else "")
        if older:
            self._keep_older(older)
        write_atomically(data, self.path / name)
        self._note(name, dataclasses.replace(source, when=self._when, undecided=undecided))

    def _note_same(self, name: str, source: FileOrigin, before: FileOrigin | None) -> None:
        """Record a file that is already here, with its earlier or its new time."""
        known = before if before and before.digest == source.digest else None
        if (self.path / TIME).is_file() or (known and known.when):
            when, undecided = (known.when, known.undecided) if known else ("", "")
        else:
            when = self._when
            undecided = "" if when else self._undecided or (known.undecided if known else "")
        newer = known is None or source.newer_than(known)
        noted = dataclasses.replace(source if newer else known, when=when, undecided=undecided)
        if noted == before:
            return
        if not (self.path / TIME).is_file():
            self._forget_time()
        self._note(name, noted)

    def _forget_time(self) -> None:
        """Remove ``timestamp.txt`` before its time becomes wrong.

        A time that `note_time` did not write was written by a person, and belongs to all files.
        """
        path = self.path / TIME
        record = dataclasses.replace(self._record, undecided=_STOPPED)
        if path.is_file():
            stated_time = _time_in(path)
            if stated_time is None or stated_time.isoformat() != record.written:
                record = self._with_time_set_by_hand(record, stated_time)
            self._keep_older(path)
        if record != self._record:
            self._keep(record)
        path.unlink(missing_ok=True)

    def _with_time_set_by_hand(self, record: Record, stated_time: datetime | None) -> Record:
        when, undecided = (stated_time.isoformat(), "") if stated_time else ("", _UNREAD)
        files = {
            name: dataclasses.replace(one, when=when, undecided=undecided)
            for name, one in record.files.items()
        }
        lying = {path.relative_to(self.path) for path in self.path.rglob("*.ipynb")}
        not_ours = {
            path for path in lying if not is_hidden(path.parts) and path.as_posix() not in files
        }
        others = max(record.others, when) if not_ours else record.others
        return dataclasses.replace(record, files=files, others=others)

    def _note(self, name: str, source: FileOrigin) -> None:
        files = {**self._record.files, name: source}
        self._keep(dataclasses.replace(self._record, files=files))

    def _keep(self, record: Record) -> None:
        write_record(record, self.path)
        self._record = record

    def _keep_older(self, path: Path) -> None:
        data = path.read_bytes()
        if digest_of(data) not in map(_digest_of_file, (self.path / OLDER).glob("*")):
            write_atomically(data, next(self._free_names(path)))

    def _free_names(self, path: Path) -> Iterator[Path]:
        number = 1
        while True:
            free = self.path / OLDER / f"{path.stem}.{number}{path.suffix}"
            if not free.exists():
                yield free
            number += 1

    def _shown(self, path: Path) -> str:
        return path.relative_to(self.path.parents[2]).as_posix()


def _digest_of_file(path: Path) -> str:
    try:
        return digest_of(read_file(path))
    except UnreadableNotebook:
        return ""


def _line(when: datetime) -> str:
    return when.astimezone(UTC).strftime("%Y-%m-%d %H:%M:%S UTC\n")


def _time_in(path: Path) -> datetime | None:
    """Return the time in a ``timestamp.txt``, or None if it cannot be read."""
    try:
        time = read_time(read_file(path).decode("utf-8", "replace").strip(), "en", UTC)
        return time and time.astimezone(UTC)
    except (UnreadableNotebook, OverflowError):
        return None
