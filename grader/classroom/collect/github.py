"""Read GitHub Classroom's checkouts, named ``{assignment}-{login}`` or ``…-{team}``.

``classroom_roster.csv``, next to the checkouts or among them, maps logins to the teacher's
identifiers. Commit dates are not read, because students can set them. Every repository contains all
notebooks, so unchanged ones do not count as submitted.
"""

from __future__ import annotations

from collections.abc import Iterable

from grader.classroom.collect.models import (
    Archive,
    CollectError,
    Owner,
    SubmittedFile,
    UnreadableFile,
)
from grader.classroom.collect.name_patterns import common_prefix, suffixes, suffixes_after
from grader.course.tables import TableError, read_table

ROSTER = "classroom_roster.csv"


def read_github(archive: Archive) -> list[SubmittedFile] | None:
    """Return the files of a folder of checkouts, or None for any other archive."""
    repositories = _outermost(folder for folder in archive.checkouts if folder)
    if not repositories:
        return None
    identifiers = _identifiers(archive)
    names = [folder[-1] for folder in repositories]
    prefix = common_prefix(names, "-")
    owners = {folder: _owner(folder[-1], prefix, identifiers) for folder in repositories}
    files = []
    for entry in archive.entries:
        folder = next((path for path in repositories if entry.path[: len(path)] == path), None)
        if folder:
            path = entry.path[len(folder) :]
            files.append(
                SubmittedFile(owners[folder], path, entry, saved_at=entry.moment, is_given=True)
            )
    return files


def _outermost(folders: Iterable[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Return the folders that are not inside another folder of the list.

    A nested checkout is a submodule. The student chose its name, so it must not name an owner.
    """
    outermost: list[tuple[str, ...]] = []
    for folder in sorted(folders):
        if not outermost or folder[: len(outermost[-1])] != outermost[-1]:
            outermost.append(folder)
    return outermost


def _owner(repository: str, prefix: str, identifiers: dict[str, str]) -> Owner:
    """Return the owner of a repository, by the login at the end of its name.

    With a single repository, the prefix of the name is unknown, so logins are only guessed.
    """
    rest = repository.removeprefix(f"{prefix}-") if prefix else repository
    logins = suffixes_after(prefix, repository, "-") if prefix else ()
    guesses = () if prefix else suffixes(repository, "-")
    identified = [
        identifiers[end.casefold()] for end in logins or guesses if end.casefold() in identifiers
    ]
    return Owner(repository, rest, (*identified[:1], rest), logins=logins, guesses=guesses)


def _identifiers(archive: Archive) -> dict[str, str]:
    """Return the teacher's identifiers by login.

    Raises
    ------
    CollectError
        If a roster of GitHub Classroom cannot be read.
    """
    readers = [entry.read for entry in archive.entries if entry.path == (ROSTER,)]
    roster_path = archive.path.parent / ROSTER
    if roster_path.is_file():
        readers.append(roster_path.read_bytes)
    identifiers = {}
    for read in readers:
        try:
            table = read_table(read())
        except (UnreadableFile, OSError, TableError) as error:
            raise CollectError(
                f"{ROSTER} cannot be read: {error}. Download it again from GitHub Classroom."
            ) from None
        if not {"github_username", "identifier"} <= set(table.titles):
            raise CollectError(
                f"{ROSTER} must have the columns github_username and identifier. Download it again "
                "from GitHub Classroom."
            )
        for cells in table.rows[1:]:
            row = dict(zip(table.titles, cells, strict=False))
            login, identifier = row.get("github_username"), row.get("identifier")
            if login and identifier:
                identifiers[login.casefold()] = identifier
    return identifiers
