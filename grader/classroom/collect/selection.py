"""Which of the files that somebody handed in for a lesson counts: the newest, if that is known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from grader.classroom.collect.inspection import Piece
from grader.classroom.collect.protocol import Handed
from grader.classroom.collect.record import FileOrigin
from grader.classroom.collect.storage import digest_of
from grader.classroom.contents import copy_number


@dataclass(frozen=True)
class File:
    """A piece of what somebody handed in, and how it came."""

    archive: Path
    handed: Handed
    piece: Piece

    @property
    def path(self) -> tuple[str, ...]:
        """Its folders and name, as whoever handed it in had them; a zip is a folder."""
        return (*self.handed.path, *self.piece.path)

    @property
    def name(self) -> str:
        """What questions and answers call it."""
        return "/".join((self.handed.owner.label, *self.path))

    @property
    def saved(self) -> datetime | None:
        """When it was saved, as far as its archives know."""
        return self.piece.saved or self.handed.saved

    def lies_beside(self, other: File) -> bool:
        """Whether it came in the same folder as another."""
        places = [(one.archive, one.handed.owner, one.path[:-1]) for one in (self, other)]
        return places[0] == places[1]

    @property
    def digest(self) -> str:
        """SHA-256 of its content."""
        return digest_of(self.piece.data)

    @property
    def source(self) -> FileOrigin:
        """What is remembered of it where it is placed."""
        handed = self.handed
        return FileOrigin(
            self.digest,
            f"{self.archive.name}: {self.name}",
            handed.entry.moment.isoformat(),
            handed.order,
            bool(handed.late),
            handed.owner.participant,
        )


# What tells which of two files is newer, the surest first; None where it tells nothing.
EVIDENCE: tuple[Callable[[File], object], ...] = (
    lambda file: file.handed.order or None,
    lambda file: file.saved,
    lambda file: copy_number(file.path[-1]),
)


def newest(files: Sequence[File]) -> list[File]:
    """The newest of some files for one lesson; more than one where nothing tells.

    One in which something was written goes before one as it was released, and one that can be
    read before one that cannot: a browser's second download of the same notebook is no answer.
    """
    found = list({file.digest: file for file in files}.values())
    for better in (
        [file for file in found if not file.piece.complaint],
        [file for file in found if not file.piece.complaint and not file.piece.content.untouched],
    ):
        found = better or found
    for evidence in EVIDENCE:
        values = [evidence(file) for file in found]
        if None not in values:
            found = [file for file in found if evidence(file) == max(values)]
    return found
