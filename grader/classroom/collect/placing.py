"""Put what was handed in into ``submitted/<student>/<stage>/``, and overwrite nothing in silence.

What gives way to something newer is kept in ``.older/`` beside it, which nobody judges.
"""

from __future__ import annotations

import dataclasses
import hashlib
import os
from collections.abc import Collection, Iterator
from datetime import UTC, datetime
from pathlib import Path

from grader.classroom.collect.record import Record, Source, read_record, write_record
from grader.classroom.submissions import Submission
from grader.course.writing import write_atomically
from grader.intake.notebook import read_file
from utils.notebooks.reading import UnreadableNotebook

NEW, NEWER, SAME, KEPT = "new", "newer", "same", "kept"
OLDER = ".older"
TIME = "timestamp.txt"


class Unsure(Exception):
    """Only a person can tell which of two files counts; `str()` says what to do."""


def digest_of(data: bytes) -> str:
    """SHA-256 of some bytes."""
    return hashlib.sha256(data).hexdigest()


class StageFolder:
    """A student's folder of one stage.

    Parameters
    ----------
    path : pathlib.Path
        ``submitted/<student>/<stage>``; made when something is placed there.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._record = read_record(path)
        self._changed = False
        self._placed: dict[str, str] = {}

    def place(self, name: str, data: bytes, source: Source, there: Submission | None = None) -> str:
        """Place a file, or leave what lies there.

        Parameters
        ----------
        name : str
        data : bytes
        source : Source
        there : Submission, optional
            What counts for the same lesson by now, under whatever name.

        Returns
        -------
        {"new", "newer", "same", "kept"}
            Whether nothing lay there, something older, the same, or something newer.

        Raises
        ------
        Unsure
        """
        if self._placed.setdefault(name, source.digest) != source.digest:
            raise Unsure(
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
            if lying.parent == self.path and (before is None or source.newer_than(before)):
                self._note(lying.name, source)
            return SAME
        if before is None or before.digest != lying_digest or lying.parent != self.path:
            how = "was changed since it was collected" if before else "was put there by hand"
            raise Unsure(f"{self._shown(lying)} {how} and differs. Delete one of the two")
        newer = source.newer_than(before)
        if newer is None:
            raise Unsure(
                f"differs from {self._shown(lying)}, and nothing tells which is newer. To take "
                "this one, delete that"
            )
        if not newer:
            return KEPT
        self._keep_older(lying)
        self._write(name, data, source)
        return NEWER

    def holds(self, name: str, digest: str) -> bool:
        """Whether a file was collected that was the same to the byte, and one still lies there."""
        source = self._record.files.get(name)
        return bool(source and source.digest == digest and (self.path / name).is_file())

    def beaten(self, name: str) -> Collection[str]:
        """SHA-256 of files that do not count beside what lies there: somebody said so."""
        source = self._record.files.get(name)
        return source.beaten if source else ()

    def note_time(self, when: datetime | None, undecided: str) -> str:
        """Write when the work was handed in, as nbgrader's ``timestamp.txt``.

        A time belongs to the files with which it came: it changes where they do.

        Parameters
        ----------
        when : datetime or None
        undecided : str
            Why there is none; empty where nobody gave times.

        Returns
        -------
        str
            Why there is none for what lies here now; empty where there is one.
        """
        path = self.path / TIME
        there = path.is_file()
        if not self.path.is_dir() or (there and not self._changed):
            return ""
        if there:
            self._keep_older(path)
            path.unlink()
        if when:
            text = when.astimezone(UTC).strftime("%Y-%m-%d %H:%M:%S UTC\n")
            write_atomically(text.encode(), path)
            undecided = ""
        elif there:
            undecided = undecided or "it was handed in again, and no time is known"
        elif not self._changed and not undecided:
            undecided = self._record.undecided
        self._record = dataclasses.replace(self._record, undecided=undecided)
        write_record(self._record, self.path)
        return undecided

    def is_late(self) -> bool:
        """Whether something that was collected is marked late."""
        return any(source.late for source in self._record.files.values())

    def _write(self, name: str, data: bytes, source: Source) -> None:
        write_atomically(data, self.path / name)
        self._changed = True
        self._note(name, source)

    def _note(self, name: str, source: Source) -> None:
        files = {**self._record.files, name: source}
        self._record = Record(files, self._record.undecided)
        write_record(self._record, self.path)

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
