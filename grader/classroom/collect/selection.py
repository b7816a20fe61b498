"""Select the file that counts for a lesson: the newest file, if the order is known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from grader.classroom.collect.inspection import UnpackedFile
from grader.classroom.collect.models import SubmittedFile
from grader.classroom.collect.record import FileOrigin
from grader.classroom.collect.storage import digest_of
from grader.classroom.lesson_recognition import copy_number


@dataclass(frozen=True)
class StudentFile:
    """A file of a student, with the submission that contained it."""

    archive: Path
    submitted: SubmittedFile
    unpacked: UnpackedFile

    @property
    def path(self) -> tuple[str, ...]:
        """Folders and file name on the student's machine; a zip counts as a folder."""
        return (*self.submitted.path, *self.unpacked.path)

    @property
    def name(self) -> str:
        """Name of the file in questions and answers."""
        return "/".join((self.submitted.owner.label, *self.path))

    @property
    def saved_at(self) -> datetime | None:
        """When the file was saved, if the archive or a zip in it contains that time."""
        return self.unpacked.saved_at or self.submitted.saved_at

    def is_next_to(self, other: StudentFile) -> bool:
        """Return whether two files are in the same folder."""
        folders = [(file.archive, file.submitted.owner, file.path[:-1]) for file in (self, other)]
        return folders[0] == folders[1]

    @property
    def digest(self) -> str:
        """SHA-256 of the content."""
        return digest_of(self.unpacked.data)

    @property
    def origin(self) -> FileOrigin:
        """The origin to record when the file is placed."""
        submitted = self.submitted
        return FileOrigin(
            self.digest,
            f"{self.archive.name}: {self.name}",
            submitted.entry.moment.isoformat(),
            submitted.order,
            bool(submitted.late),
            submitted.owner.participant,
        )


# Each function returns a larger value for a newer file, or None if the age is unknown. The most
# reliable function is first.
EVIDENCE: tuple[Callable[[StudentFile], object], ...] = (
    lambda file: file.submitted.order or None,
    lambda file: file.saved_at,
    lambda file: copy_number(file.path[-1]),
)


def find_newest(
    files: Sequence[StudentFile], evidence: Sequence[Callable[[StudentFile], object]] = EVIDENCE
) -> list[StudentFile]:
    """Return the newest of some files for one lesson; several if the order is unknown.

    A changed notebook takes precedence over an unchanged one, and a readable file over an
    unreadable one. A second download of the released notebook must not replace a student's work.
    """
    candidates = list({file.digest: file for file in files}.values())
    for newer_candidates in (
        [file for file in candidates if not file.unpacked.complaint],
        [
            file
            for file in candidates
            if not file.unpacked.complaint and not file.unpacked.content.untouched
        ],
    ):
        candidates = newer_candidates or candidates
    for age_of in evidence:
        values = [age_of(file) for file in candidates]
        if None not in values:
            candidates = [file for file in candidates if age_of(file) == max(values)]
    return candidates


def rivals_by_copy_number(files: Sequence[StudentFile], newest: StudentFile) -> list[StudentFile]:
    """Return the files that lost to the newest only because of the copy numbers in their names.

    The numbers are weak evidence: a numbered copy may be a backup from before the last change.
    """
    return [file for file in find_newest(files, EVIDENCE[:-1]) if file.digest != newest.digest]
