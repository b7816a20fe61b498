"""Read the zip that *Download Submissions* creates for a Canvas assignment.

File names are ``{name}[_LATE]_{user id}_{attachment id}_{file}``, all in one folder; `name` has
only letters and digits. If names are hidden, they are
``[LATE_]anon_{anonymous id}_{attachment id}_{file}``. Typed texts and links have no attachment ID:
``…_{user id}_text.html``, ``…_link.html``. A group submits one file, with one member's user ID.
"""

from __future__ import annotations

import re

from grader.classroom.collect.models import Archive, ArchiveEntry, Owner, SubmittedFile
from grader.classroom.collect.name_patterns import match_paths

_OWNER = (
    r"(?:(?P<anonymous_late>LATE_)?anon_(?P<anonymous>[A-Za-z0-9]+)"
    r"|(?P<name>[^/\s@.,'+-]{1,255}?)(?P<late>_LATE)?_(?P<user>\d+))"
)
_FILE_NAME = re.compile(
    rf"{_OWNER}_(?:(?P<what>text|link)\.html|(?P<attachment>\d+)_(?P<file>[^/]+))", re.IGNORECASE
)
_RESUBMITTED = re.compile(r"([A-Za-z_]\w*)-\d+(\.py)")  # Canvas numbers resubmitted files
_REMARKS = {
    "text": "was typed into Canvas instead of uploaded. Ask for the .ipynb file",
    "link": "is a link, and its target may have changed. Ask for the .ipynb file",
}


def read_canvas(archive: Archive) -> list[SubmittedFile] | None:
    """Return the files of a Canvas download, or None for any other archive."""
    files = [_submitted_file(*match) for match in match_paths(archive, _FILE_NAME)]
    return files if 2 * len(files) > len(archive.entries) else None


def _submitted_file(entry: ArchiveEntry, parts: dict[str, str]) -> SubmittedFile:
    anonymous = parts["anonymous"]
    label = f"anon_{anonymous}" if anonymous else f"{parts['name']}_{parts['user']}"
    owner = Owner(
        label,
        label,
        () if anonymous else (parts["name"],),
        lms_id=parts["user"],
    )
    name = parts["file"] or entry.path[-1]
    return SubmittedFile(
        owner,
        (_RESUBMITTED.sub(r"\1\2", name),),
        entry,
        order=int(parts["attachment"] or 0),
        late=bool(parts["late"] or parts["anonymous_late"]),
        remark=_REMARKS.get(parts["what"].lower(), ""),
    )
