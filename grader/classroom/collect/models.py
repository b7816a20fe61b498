"""The exceptions and data classes that the modules of ``collect`` share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from grader.errors import UserError


class CollectError(UserError):
    """Nothing can be collected; `str()` says why and what to do."""


class UnreadableFile(Exception):
    """One file cannot be read; the message follows the file's name in a sentence."""


@dataclass(frozen=True)
class ArchiveEntry:
    """A file in an archive, whose content is read on demand.

    Attributes
    ----------
    path : tuple of str
        Folders and file name, without parts such as ``..``.
    moment : datetime
        The time in the archive, without a time zone. Learning platforms store the time of the
        download; other programs store when the file was saved.
    read : callable
        Returns the bytes; raises `UnreadableFile`.
    """

    path: tuple[str, ...]
    moment: datetime
    read: Callable[[], bytes] = field(repr=False, compare=False)


@dataclass(frozen=True)
class Archive:
    """The files in a zip or folder, or a single file.

    Attributes
    ----------
    path : pathlib.Path
    entries : tuple of ArchiveEntry
        All files except hidden ones.
    checkouts : frozenset of (tuple of str)
        Folders that are git checkouts.
    """

    path: Path
    entries: tuple[ArchiveEntry, ...]
    checkouts: frozenset[tuple[str, ...]] = frozenset()


@dataclass(frozen=True)
class Owner:
    """The owner of a file, as named in an archive.

    Attributes
    ----------
    label : str
        Name of the owner in questions and answers.
    folder : str
        Name of the folder in ``submitted/`` if there is no roster.
    names : tuple of str
        Possible names on the roster, the most likely first.
    lms_id, participant, logins : str, str, tuple of str
        Canvas user ID, Moodle participant number, GitHub logins.
    guesses : tuple of str
        Possible logins and names, to be confirmed by the instructor.
    members : tuple of (tuple of str)
        Names of each member, if the archive lists the members of a team.
    is_folder : bool
        Whether the owner is only the name of a folder or archive, which may contain the work of
        several students.
    """

    label: str
    folder: str = ""
    names: tuple[str, ...] = ()
    lms_id: str = ""
    participant: str = ""
    logins: tuple[str, ...] = ()
    guesses: tuple[str, ...] = ()
    members: tuple[tuple[str, ...], ...] = ()
    is_folder: bool = False


@dataclass(frozen=True)
class SubmittedFile:
    """One submitted file.

    Attributes
    ----------
    owner : Owner
    path : tuple of str
        Folders and file name before a learning platform changed them.
    entry : ArchiveEntry
    order : int
        Sort key among archives of the same format: higher is newer, and 0 is unknown.
    saved_at : datetime or None
        When the student saved the file, if the archive contains that time.
    late : bool or None
        Whether the learning platform marked the file late; None if the platform has no such mark.
    remark : str
        Why a typed text or a link cannot be judged; empty for files.
    is_given : bool
        Whether every student received the repository, so the file may be unchanged.
    """

    owner: Owner
    path: tuple[str, ...]
    entry: ArchiveEntry
    order: int = 0
    saved_at: datetime | None = None
    late: bool | None = None
    remark: str = ""
    is_given: bool = False

    @property
    def name(self) -> str:
        """Name of the file in questions and answers."""
        return "/".join((self.owner.label, *self.path))


@dataclass(frozen=True)
class SubmittedArchive:
    """The submitted files in an archive.

    Attributes
    ----------
    path : pathlib.Path
    kind : str
        The format.
    files : tuple of SubmittedFile
    other_entries : tuple of ArchiveEntry
        Files that do not belong to a submission.
    levels : dict of int to (list of SubmittedFile)
        For each level of folders that may be the students', the outermost first, the files as read
        with these folders as owners; empty if only one level is possible.
    """

    path: Path
    kind: str
    files: tuple[SubmittedFile, ...]
    other_entries: tuple[ArchiveEntry, ...] = ()
    levels: dict[int, list[SubmittedFile]] = field(default_factory=dict)


ArchiveReader = Callable[[Archive], list[SubmittedFile] | None]
"""Reads the archives of one platform; returns None for any other archive."""
