"""Match the names in an archive with the pattern of a learning platform.

Students choose the names of the files and folders that they submit. A student could therefore use a
platform's pattern to submit a file in another student's name. A match counts only in the part of a
path that the platform wrote.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Sequence

from grader.classroom.collect.models import Archive, ArchiveEntry

MAX_FOLDERS = 6  # levels of folders at which the names that a platform wrote may begin
Match = tuple[ArchiveEntry, dict[str, str]]
"""A file and the groups of the pattern; a group that does not occur is an empty string."""


def match_paths(archive: Archive, pattern: re.Pattern) -> list[Match]:
    """Return the files whose paths match a pattern.

    The match begins below the folders that contain the whole archive. It may begin deeper only if
    the paths of all notebooks match, for example because a teacher put several downloads into one
    folder.
    """
    depth = len(shared_folders(archive.entries))
    matches = _match_below(archive.entries, pattern, range(depth, depth + 1))
    if matches:
        return matches
    matches = _match_below(archive.entries, pattern, range(MAX_FOLDERS))
    matched = {entry for entry, _ in matches}
    return matches if matched.issuperset(filter(may_be_notebook, archive.entries)) else []


def may_be_notebook(entry: ArchiveEntry) -> bool:
    """Return whether a file is a notebook or a zip according to its name."""
    name = entry.path[-1].lower()
    return ".ipynb" in name or name.endswith(".zip")


def shared_folders(entries: Sequence[ArchiveEntry]) -> tuple[str, ...]:
    """Return the folders that contain all files."""
    return tuple(os.path.commonprefix([entry.path[:-1] for entry in entries]))


def suffixes(name: str, separator: str) -> tuple[str, ...]:
    """Return a name and the rest of it after each separator, the longest first."""
    parts = name.split(separator)
    return tuple(separator.join(parts[number:]) for number in range(len(parts)))


def common_prefix(names: Collection[str], separator: str) -> str:
    """Return the prefix that all names share, up to a separator; empty if there is only one."""
    return os.path.commonprefix(list(names)).rpartition(separator)[0] if len(names) > 1 else ""


def suffixes_after(prefix: str, name: str, separator: str) -> tuple[str, ...]:
    """Return the suffixes of a name that include everything after the names' common prefix.

    A login may contain separators, so it may start inside the common prefix.
    """
    rest = name.removeprefix(f"{prefix}{separator}") if prefix else ""
    return tuple(end for end in suffixes(name, separator) if len(end) >= len(rest))


def _match_below(
    entries: Sequence[ArchiveEntry], pattern: re.Pattern, depths: Collection[int]
) -> list[Match]:
    """Return the files whose paths match after as many outer folders as one of `depths`."""
    matches = []
    for entry in entries:
        paths = ("/".join(entry.path[depth:]) for depth in depths)
        match = next((match for path in paths if (match := pattern.fullmatch(path))), None)
        if match:
            matches.append((entry, match.groupdict("")))
    return matches
