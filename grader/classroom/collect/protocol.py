"""What the parts of ``collect`` hand to each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path


class CollectTrouble(Exception):
    """Nothing can be collected from what was named; `str()` is the sentence to show."""


class Unreadable(Exception):
    """One file cannot be read; `str()` is the sentence to show, without the file's name."""


@dataclass(frozen=True)
class ArchiveEntry:
    """A file in an archive, not read yet.

    Attributes
    ----------
    path : tuple of str
        Folders and name, with nothing in them that leads elsewhere.
    moment : datetime
        What the archive has for its time, naive. Learning platforms put there when it was
        downloaded, everybody else when it was saved.
    read : callable
        Returns its bytes; raises `Unreadable`.
    """

    path: tuple[str, ...]
    moment: datetime
    read: Callable[[], bytes] = field(repr=False, compare=False)


@dataclass(frozen=True)
class Archive:
    """All files of a zip, a folder, or one file.

    Attributes
    ----------
    path : pathlib.Path
    entries : tuple of ArchiveEntry
        But for hidden ones.
    checkouts : frozenset of (tuple of str)
        Folders that git manages.
    """

    path: Path
    entries: tuple[ArchiveEntry, ...]
    checkouts: frozenset[tuple[str, ...]] = frozenset()


@dataclass(frozen=True)
class Owner:
    """Who handed something in, as an archive calls them.

    Attributes
    ----------
    label : str
        What questions and answers call them.
    folder : str
        What their folder is called where there is no roster.
    names : tuple of str
        What they may be called on the roster, likeliest first.
    lms_id, participant, logins : str, str, tuple of str
        Canvas's number of a person, Moodle's of a participant, what is a GitHub login.
    guesses : tuple of str
        What may be a GitHub login, or the end of another one's.
    """

    label: str
    folder: str = ""
    names: tuple[str, ...] = ()
    lms_id: str = ""
    participant: str = ""
    logins: tuple[str, ...] = ()
    guesses: tuple[str, ...] = ()


@dataclass(frozen=True)
class Handed:
    """One thing that somebody handed in.

    Attributes
    ----------
    owner : Owner
    path : tuple of str
        Its folders and name as they were before a learning platform changed them.
    entry : ArchiveEntry
    order : int
        Higher is newer, in every archive of this kind; 0 where nothing is known.
    saved : datetime or None
        When the student saved it, as far as the archive knows.
    late : bool or None
        Whether the learning platform marked it so; None where it marks nothing.
    remark : str
        A sentence where it is no file but a text that was typed, or a link.
    given : bool
        That it may be there because everybody was given it.
    """

    owner: Owner
    path: tuple[str, ...]
    entry: ArchiveEntry
    order: int = 0
    saved: datetime | None = None
    late: bool | None = None
    remark: str = ""
    given: bool = False

    @property
    def name(self) -> str:
        """What questions and answers call it."""
        return "/".join((self.owner.label, *self.path))


Kind = Callable[[Archive], list[Handed] | None]
"""Reads an archive as one program writes it; None where that program did not write it."""
