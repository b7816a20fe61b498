"""Inspect a submitted file: a notebook, a module, or a zip of these.

A separate process with limits on time and memory unpacks and reads the file, so a harmful file
affects only its author.
"""

from __future__ import annotations

import base64
import dataclasses
import io
from dataclasses import dataclass
from datetime import datetime
from pathlib import PurePath

from grader.classroom import lesson_recognition
from grader.classroom.collect.models import ArchiveEntry, UnreadableFile
from grader.classroom.collect.zips import (
    MAX_BYTES_PER_STUDENT,
    MAX_FILES_PER_STUDENT,
    is_hidden,
    open_zip,
)
from grader.classroom.lesson_recognition import NotebookContent, lesson_by_name
from grader.intake.reader_process import ReadingFailed, TooCostly, run_in_child
from grader.intake.submission import MAX_MODULE_BYTES
from utils.notebooks.reading import UnreadableNotebook, is_lfs_pointer

MAX_ZIP_DEPTH = 3  # levels of nested zips
TOO_LARGE = f"more than {MAX_BYTES_PER_STUDENT // 2**20} MB of notebooks"
NOTEBOOK, MODULE, SUBSTITUTE, OTHER = "notebook", "module", "work", "other"

_LFS_POINTER = (
    "is a Git LFS pointer, because Git has not downloaded the notebook itself. Run `git lfs pull` "
    "in the checkout, and collect again"
)
_ASK_FOR_NOTEBOOK = "Inspect the file, and ask the student for the .ipynb file without a zip"

# File types that students submit instead of a notebook.
_SUBSTITUTES = (".html", ".pdf", ".docx", ".rar", ".7z", ".gz", ".tar", ".tgz", ".ipynb", ".zip")


@dataclass(frozen=True)
class UnpackedFile:
    """One file of a student, unpacked and inspected.

    Attributes
    ----------
    path : tuple of str
        Path below the submitted file; a zip counts as a folder.
    kind : {"notebook", "module", "work", "other"}
        "work" is a file that was submitted instead of a notebook, such as a PDF.
    data : bytes
        Only for notebooks and modules.
    saved_at : datetime or None
        The file's time in the zip that contains it.
    content : grader.classroom.lesson_recognition.NotebookContent
        Only for notebooks.
    complaint : str
        Why the file cannot be read: the rest of a sentence that begins with the file's name.
    """

    path: tuple[str, ...]
    kind: str
    data: bytes = b""
    saved_at: datetime | None = None
    content: NotebookContent = NotebookContent()
    complaint: str = ""


def unpack_file(entry: ArchiveEntry, name: str) -> list[UnpackedFile]:
    """Unpack one submitted file, given its original name."""
    if file_kind(name) == OTHER and not name.lower().endswith(".zip"):
        return [UnpackedFile((), OTHER)]
    lesson_recognition.cache_releases()
    try:
        data = entry.read()
        replies = run_in_child(
            name, lambda: [_to_json(unpacked) for unpacked in _unpack(data, name)]
        )
    except UnreadableFile as error:
        return [UnpackedFile((), SUBSTITUTE, complaint=str(error))]
    except TooCostly:
        return [
            UnpackedFile(
                (),
                SUBSTITUTE,
                complaint=f"takes too much time or memory to open. {_ASK_FOR_NOTEBOOK}",
            )
        ]
    except ReadingFailed:  # an error in the grader must not affect other files
        return [
            UnpackedFile(
                (),
                SUBSTITUTE,
                complaint=f"cannot be opened. {_ASK_FOR_NOTEBOOK}",
            )
        ]
    return [_from_json(*parts) for parts in replies]


def file_kind(name: str) -> str:
    """Return the kind of a file according to its name."""
    path = PurePath(name.lower())
    lesson = lesson_by_name(name)
    if ".ipynb" in path.suffixes or (lesson and path.suffix in ("", ".json", ".txt")):
        return NOTEBOOK
    if path.suffix == ".py" and lesson is None and PurePath(name).stem.isidentifier():
        return MODULE
    return SUBSTITUTE if lesson or path.suffix in _SUBSTITUTES else OTHER


def _unpack(
    data: bytes,
    name: str,
    path: tuple[str, ...] = (),
    saved_at: datetime | None = None,
    depth: int = 0,
) -> list[UnpackedFile]:
    """Do the work of `unpack_file` in the separate process."""
    kind = file_kind(name)
    if name.lower().endswith(".zip"):
        return _unpack_zip(data, path, depth + 1)
    if kind == NOTEBOOK and is_lfs_pointer(data):
        return [UnpackedFile(path, SUBSTITUTE, complaint=_LFS_POINTER)]
    if kind == NOTEBOOK:
        try:
            return [
                UnpackedFile(path, kind, data, saved_at, lesson_recognition.content_of(data, name))
            ]
        except UnreadableNotebook as error:
            complaint = str(error).partition(". ")[0].removeprefix(name).strip(" .")
            # A text file named after a lesson may contain anything.
            kind = NOTEBOOK if ".ipynb" in name.lower() else SUBSTITUTE
            return [UnpackedFile(path, kind, data, saved_at, complaint=complaint)]
    if kind == MODULE and len(data) <= MAX_MODULE_BYTES:
        return [UnpackedFile(path, kind, data, saved_at)]
    return [UnpackedFile(path, SUBSTITUTE if kind == SUBSTITUTE else OTHER)]


def _unpack_zip(data: bytes, path: tuple[str, ...], depth: int) -> list[UnpackedFile]:
    if depth > MAX_ZIP_DEPTH:
        return [
            UnpackedFile(
                path,
                SUBSTITUTE,
                complaint=f"is inside {MAX_ZIP_DEPTH} other zips, so it was not opened. "
                + _ASK_FOR_NOTEBOOK,
            )
        ]
    try:
        entries = open_zip(io.BytesIO(data), MAX_FILES_PER_STUDENT)
    except UnreadableFile as error:
        return [UnpackedFile(path, SUBSTITUTE, complaint=str(error))]
    files, size = [], 0
    for entry_path, entry in entries:
        inner = (*path, *entry_path)
        if is_hidden(entry_path):
            continue
        if file_kind(entry_path[-1]) == OTHER:
            files.append(UnpackedFile(inner, OTHER))
            continue
        try:
            content = entry.read()
        except UnreadableFile as error:
            files.append(UnpackedFile(inner, SUBSTITUTE, complaint=str(error)))
            continue
        inside = _unpack(content, entry_path[-1], inner, entry.moment, depth)
        size += sum(len(unpacked.data) for unpacked in inside)
        if size > MAX_BYTES_PER_STUDENT:
            return [UnpackedFile(path, SUBSTITUTE, complaint=f"unpacks to {TOO_LARGE}")]
        files += inside
    return files


def _to_json(unpacked: UnpackedFile) -> tuple:
    """Return an unpacked file as values that JSON can represent."""
    return (
        unpacked.path,
        unpacked.kind,
        base64.b64encode(unpacked.data).decode(),
        unpacked.saved_at.isoformat() if unpacked.saved_at else "",
        dataclasses.astuple(unpacked.content),
        unpacked.complaint,
    )


def _from_json(
    path: list[str],
    kind: str,
    data: str,
    saved_at: str,
    content: tuple[str, bool, list[str]],
    complaint: str,
) -> UnpackedFile:
    lesson, untouched, repairs = content
    return UnpackedFile(
        tuple(path),
        kind,
        base64.b64decode(data),
        datetime.fromisoformat(saved_at) if saved_at else None,
        NotebookContent(lesson, untouched, tuple(repairs)),
        complaint,
    )
