"""Read the zip that *Download all submissions* creates for a Moodle assignment.

Each student has a folder ``{name}_{number}_assignsubmission_{plugin}`` with the submitted files and
subfolders. If the teacher chose a download without folders, ``_{file}`` follows each name. The
number is the participant's number in the grading worksheet. A team has the name
``{team}_{team number}``; students without a team have the name ``{default team}`` without a number.
Names do not contain ``_``.
"""

from __future__ import annotations

import re

from grader.classroom.collect.models import Archive, ArchiveEntry, Owner, SubmittedFile

_OWNER = re.compile(
    r"(?P<name>[^_/]+)(?:_(?P<number>\d+))?_assignsubmission_(?P<plugin>[a-z]+)(?:_(?P<file>.+))?",
    re.IGNORECASE,
)
_TYPED = "was typed into Moodle instead of uploaded. Ask for the .ipynb file"


def read_moodle(archive: Archive) -> list[SubmittedFile] | None:
    """Return the files of a Moodle download, or None for any other archive."""
    files = [file for entry in archive.entries for file in _submitted_files(entry)]
    return files if 2 * len(files) > len(archive.entries) else None


def _submitted_files(entry: ArchiveEntry) -> list[SubmittedFile]:
    for index, part in enumerate(entry.path):
        match = _OWNER.fullmatch(part)
        if match is None:
            continue
        inner = entry.path[index + 1 :] or (match["file"] or part,)
        number = match["number"] or ""
        label = f"{match['name']}_{number}" if number else match["name"]
        owner = Owner(label, label, (match["name"],), participant=number)
        remark = "" if match["plugin"].lower() == "file" else _TYPED
        return [SubmittedFile(owner, inner, entry, remark=remark)]
    return []
