"""Read downloads from Blackboard, Brightspace, ILIAS, PrairieLearn and Sakai.

- **Blackboard**: ``{title}_{login}_attempt_{time}_{file}``. ``{title}_{login}_attempt_{time}.txt``
  describes the attempt.
- **Brightspace**: ``{number}-{number} - {name} - {time}/{file}``, or `` - `` instead of the slash.
  Some institutions write an ID before the name.
- **ILIAS**: ``{last name}_{first name}_{login}_{number}/{file}``. A team has a folder
  ``Team {number}``, with a folder of the member who submitted.
- **PrairieLearn**: ``{login}_{number}_{question and numbers}_{file}``. Logins are e-mail addresses.
- **Sakai**: ``{last name}, {first name}({login})/Submission attachment(s)/{file}``, or ``_``
  instead of the slashes.
"""

from __future__ import annotations

import re

from grader.classroom.collect.models import Archive, Owner, SubmittedFile
from grader.classroom.collect.name_patterns import common_prefix, match_paths, suffixes_after
from grader.course.times import UnclearTime, read_time

# Repetitions have a maximum length, so a name that a student chose cannot make a match slow.
_BLACKBOARD = re.compile(
    r"(?P<owner>[^/]{1,255}?)_attempt_(?P<time>\d{4}(?:-\d\d){5})(?:_(?P<file>[^/]+)|\.txt)"
)
_BRIGHTSPACE = re.compile(
    r"(?P<number>\d+)-\d+ - (?P<name>[^/]{1,255}?) - "
    r"(?P<time>[^/]{1,40}? \d{4} \d{3,4}(?: ?[AP]M)?)"
    r"(?:/| - )(?P<file>.+)"
)
_ILIAS = re.compile(
    r"(?P<last>[^/_]+)_(?P<first>[^/_]+)_(?P<login>[^/]+)_(?P<number>\d+)/(?P<file>.+)"
)
_ILIAS_TEAM = re.compile(r"Team \d+")
_PRAIRIELEARN = re.compile(r"(?P<login>[^/\s@]+@[^/_@]+)_\d+_(?P<file>[^/]+)")
_SAKAI = re.compile(
    r"(?P<name>[^/]{1,255}?)\((?P<login>[^/()]+)\)[/_]Submission attachment\(s\)[/_](?P<file>.+)"
)


def read_blackboard(archive: Archive) -> list[SubmittedFile] | None:
    """Return the files of a download from Blackboard, or None for any other archive."""
    matches = match_paths(archive, _BLACKBOARD)
    prefix = common_prefix({parts["owner"] for _, parts in matches}, "_")
    files = []
    for entry, parts in matches:
        label = parts["owner"]
        logins = suffixes_after(prefix, label, "_")
        owner = (
            Owner(label, logins[-1], logins) if prefix else Owner(label, logins[-1], guesses=logins)
        )
        if parts["file"]:
            order = int(parts["time"].replace("-", ""))
            files.append(SubmittedFile(owner, (parts["file"],), entry, order))
    return files or None


def read_brightspace(archive: Archive) -> list[SubmittedFile] | None:
    """Return the files of a download from Brightspace, or None for any other archive."""
    files = []
    for entry, parts in match_paths(archive, _BRIGHTSPACE):
        name = parts["name"]
        id, _, rest = name.partition(" ")
        names = (id, rest) if rest and any(map(str.isdigit, id)) else (name,)
        label = f"{name}_{parts['number']}"
        files.append(
            SubmittedFile(
                Owner(label, label, names), _path(parts["file"]), entry, _order_key(parts["time"])
            )
        )
    return files or None


def read_ilias(archive: Archive) -> list[SubmittedFile] | None:
    """Return the files of a download from ILIAS, or None for any other archive."""
    files = []
    for entry, parts in match_paths(archive, _ILIAS):
        path = _path(parts["file"])
        parent, folder = ("", *entry.path)[-len(path) - 2 : -len(path)]
        login, name = parts["login"], f"{parts['first']} {parts['last']}"
        # An archive that is not from ILIAS may match as well. Its folders may be named after IDs.
        owner = Owner(f"{login}_{parts['number']}", login, (folder, login, name))
        if _ILIAS_TEAM.fullmatch(parent):
            owner = Owner(parent, parent, guesses=(login, name))
        files.append(SubmittedFile(owner, path, entry))
    return files if 2 * len(files) > len(archive.entries) else None


def read_prairielearn(archive: Archive) -> list[SubmittedFile] | None:
    """Return the files of a download from PrairieLearn, or None for any other archive."""
    files = [
        SubmittedFile(
            Owner(parts["login"], parts["login"], (parts["login"],)), (parts["file"],), entry
        )
        for entry, parts in match_paths(archive, _PRAIRIELEARN)
    ]
    return files if 2 * len(files) > len(archive.entries) else None


def read_sakai(archive: Archive) -> list[SubmittedFile] | None:
    """Return the files of a download from Sakai, or None for any other archive."""
    files = [
        SubmittedFile(
            Owner(parts["login"], parts["login"], (parts["login"], parts["name"])),
            _path(parts["file"]),
            entry,
        )
        for entry, parts in match_paths(archive, _SAKAI)
    ]
    return files or None


def _path(text: str) -> tuple[str, ...]:
    return tuple(text.split("/"))


def _order_key(time: str) -> int:
    """Return a sort key for a time such as ``12 October, 2026 1110 PM``; 0 if it is unreadable.

    Names cannot contain the colon of a time.
    """
    try:
        when = read_time(re.sub(r"(\d\d)( ?[AP]M)?$", r":\1\2", time))
    except UnclearTime:
        return 0
    return int(when.strftime("%Y%m%d%H%M%S"))
