"""Read the zip that *Download all submissions* creates for a Moodle assignment.

Each student has a folder ``{name}_{number}_assignsubmission_{plugin}`` with the submitted files and
subfolders. If the teacher chose a download without folders, each file is named
``{name}_{number}_assignsubmission_{plugin}_{file}`` instead. The number is the participant's number
in the grading worksheet. A team has the name ``{team}_{team number}``; students without a team have
the name ``{default team}`` without a number. Names do not contain ``_``.

In versions before 2022, folders end with ``_``. Each member of a team has a folder, named
``{team}-{name}_{number}``; the default team also has a name.
"""

from __future__ import annotations

import re

from grader.classroom.collect.models import Archive, Owner, SubmittedFile
from grader.classroom.collect.name_patterns import match_paths, suffixes

_PATH = re.compile(
    r"(?P<name>[^_/]+)(?:_(?P<number>\d+))?_assignsubmission_(?P<plugin>[a-z]+)"
    r"(?:_?/(?P<path>.+)|_(?P<file>[^/]+)|)",
    re.IGNORECASE,
)
_TYPED_REMARK = "was typed into Moodle instead of uploaded. Ask for the .ipynb file"


def read_moodle(archive: Archive) -> list[SubmittedFile] | None:
    """Return the files of a Moodle download, or None for any other archive."""
    matches = match_paths(archive, _PATH)
    owners = {(parts["name"], parts["number"]) for _, parts in matches}
    # With a single team, a hyphen may also be part of the person's name.
    may_have_teams = len(owners) > 1 and all("-" in name for name, _ in owners)
    files = []
    for entry, parts in matches:
        name, number = parts["name"], parts["number"]
        label = f"{name}_{number}" if number else name
        names = suffixes(name, "-") if may_have_teams else (name,)
        owner = Owner(
            label, label, tuple(name for name in names if not name.isdigit()), participant=number
        )
        path = tuple((parts["path"] or parts["file"] or entry.path[-1]).split("/"))
        remark = "" if parts["plugin"].lower() == "file" else _TYPED_REMARK
        files.append(SubmittedFile(owner, path, entry, remark=remark))
    return files or None
