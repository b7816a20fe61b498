"""Read the zip that *Export Submissions* creates for a Gradescope assignment.

Each submission has a folder ``submission_{number}``, and ``submission_metadata.yml`` names its
submitters, which are several for a group. A resubmission has another number.
"""

from __future__ import annotations

import re

import yaml

from grader.classroom.collect.models import (
    Archive,
    ArchiveEntry,
    CollectError,
    Owner,
    SubmittedFile,
    UnreadableFile,
)
from grader.classroom.collect.name_patterns import shared_folders

METADATA = "submission_metadata.yml"


def read_gradescope(archive: Archive) -> list[SubmittedFile] | None:
    """Return the files of an export from Gradescope, or None for any other archive.

    Raises
    ------
    CollectError
        If the list of submitters cannot be read.
    """
    # Only this folder is trusted: a student could submit a forged list in a deeper folder.
    root = shared_folders(archive.entries)
    metadata = [entry for entry in archive.entries if entry.path == (*root, METADATA)]
    if not metadata:
        return None
    submissions = _submissions(metadata[0])
    files = []
    for entry in archive.entries:
        folder, *inner = entry.path[len(root) :]
        if inner and folder in submissions:
            owner, order = submissions[folder]
            files.append(SubmittedFile(owner, tuple(inner), entry, order))
    return files


def _submissions(metadata: ArchiveEntry) -> dict[str, tuple[Owner, int]]:
    """Return the owner and the order of each submission, by folder."""
    try:
        # The base loader keeps the zeros at the beginning of a student's number.
        content = yaml.load(metadata.read(), getattr(yaml, "CBaseLoader", yaml.BaseLoader))
        return {
            folder: (_owner(details[":submitters"]), _order_key(details.get(":created_at", "")))
            for folder, details in content.items()
        }
    except (UnreadableFile, yaml.YAMLError, AttributeError, KeyError, TypeError, ValueError):
        raise CollectError(
            f"{METADATA} does not list the submitters. Download the export from Gradescope again."
        ) from None


def _owner(submitters: list[dict[str, str]]) -> Owner:
    members = tuple(
        tuple(text for key in (":email", ":sid", ":name") if (text := submitter.get(key)))
        for submitter in submitters
    )
    label = "+".join(texts[0] for texts in members if texts)
    if len(members) == 1:
        return Owner(label, label, members[0])
    return Owner(label, label, members=members)


def _order_key(time: str) -> int:
    """Return a sort key for a time such as ``2026-10-12 21:10:00.000000000 Z``."""
    match = re.match(r"(\d{4})-(\d\d)-(\d\d) (\d\d):(\d\d):(\d\d)", time)
    return int("".join(match.groups())) if match else 0
