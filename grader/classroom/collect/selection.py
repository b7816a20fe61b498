"""Select the file that counts for a lesson: the newest, if that is known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from grader.classroom.collect.inspection import Piece
from grader.classroom.collect.protocol import SubmittedFile
from grader.classroom.collect.record import FileOrigin
from grader.classroom.collect.storage import digest_of
from grader.classroom.contents import copy_number


@dataclass(frozen=True)
class File:
    """A file of a student, with the submission that contained it."""

    archive: Path
    handed: SubmittedFile
    piece: Piece

    @property
    def path(self) -> tuple[str, ...]:
        """Folders and name on the student's machine; a zip counts as a folder."""
        return (*self.handed.path, *self.piece.path)

    @property
    def name(self) -> str:
        """The name in questions and answers."""
        return "/".join((self.handed.owner.label, *self.path))

    @property
    def saved(self) -> datetime | None:
        """When the file was saved, as far as the archives know."""
        return self.piece.saved or self.handed.saved

    def lies_beside(self, other: File) -> bool:
        """Return whether it is in the same folder as another file."""
        places = [(one.archive, one.handed.owner, one.path[:-1]) for one in (self, other)]
        return places[0] == places[1]

    @property
    def digest(self) -> str:
        """SHA-256 of the content."""
        return digest_of(self.piece.data)

    @property
    def source(self) -> FileOrigin:
        """The origin to record when the file is placed."""
        handed = self.handed
        return FileOrigin(
            self.digest,
            f"{self.archive.name}: {self.name}",
            handed.entry.moment.isoformat(),
            handed.order,
            bool(handed.late),
            handed.owner.participant,
        )


# Rules that say which of two files is newer, the most reliable first; None if a rule cannot say.
EVIDENCE: tuple[Callable[[File], object], ...] = (
    lambda file: file.handed.order or None,
    lambda file: file.saved,
    lambda file: copy_number(file.path[-1]),
)


def newest(files: Sequence[File]) -> list[File]:
    """Return the newest of some files for one lesson; several if the order is unknown.

    A changed notebook takes precedence over an unchanged one, and a readable file over an
    unreadable one: a second download of the released notebook is not an answer.
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
