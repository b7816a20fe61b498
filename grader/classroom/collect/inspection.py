"""Inspect a submitted file: a notebook, a module, or a zip of these.

It is unpacked and read in a process of its own, with limits on time and memory, so that a harmful
file affects only its author.
"""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass
from datetime import datetime
from pathlib import PurePath

from grader.classroom import contents
from grader.classroom.collect.protocol import ArchiveEntry, Unreadable
from grader.classroom.collect.zips import (
    MOST_BYTES_OF_A_STUDENT,
    MOST_FILES_OF_A_STUDENT,
    is_hidden,
    open_zip,
)
from grader.classroom.contents import Content, lesson_by_name
from grader.intake.reader_process import ReadingFailed, TooCostly, run_in_child
from grader.intake.submission import LARGEST_MODULE
from utils.notebooks.reading import UnreadableNotebook

DEEPEST = 3  # zips in zips
TOO_MUCH_OF_A_STUDENT = f"more than {MOST_BYTES_OF_A_STUDENT // 2**20} MB of notebooks"
NOTEBOOK, MODULE, WORK, OTHER = "notebook", "module", "work", "other"

# Kinds of files that students submit in place of a notebook.
_WORK = (".html", ".pdf", ".docx", ".rar", ".7z", ".gz", ".tar", ".tgz", ".ipynb", ".zip")


@dataclass(frozen=True)
class Piece:
    """One file of a student.

    Attributes
    ----------
    path : tuple of str
        Path below that of the submitted file; a zip counts as a folder.
    kind : {"notebook", "module", "work", "other"}
        "work" is a file in place of a notebook, such as a PDF.
    data : bytes
        Only for notebooks and modules.
    saved : datetime or None
        The time in the zip that contains the file.
    content : grader.classroom.contents.Content
        Only for notebooks.
    complaint : str
        Why the file cannot be read: a sentence without the file's name.
    """

    path: tuple[str, ...]
    kind: str
    data: bytes = b""
    saved: datetime | None = None
    content: Content = Content()
    complaint: str = ""


def look_at(entry: ArchiveEntry, name: str) -> list[Piece]:
    """Open one submitted file with its name."""
    if kind_of(name) == OTHER and not name.lower().endswith(".zip"):
        return [Piece((), OTHER)]
    contents.remember_what_was_released()
    try:
        data = entry.read()
        found = run_in_child(name, lambda: [_plain(piece) for piece in _look(data, name)])
    except Unreadable as error:
        return [Piece((), WORK, complaint=str(error))]
    except TooCostly:
        return [Piece((), WORK, complaint="takes too long, or too much memory, to be opened")]
    except ReadingFailed:  # a fault of the grader, which must not affect other files
        return [Piece((), WORK, complaint="cannot be opened: look at it, and ask for it unpacked")]
    return [_piece(*parts) for parts in found]


def kind_of(name: str) -> str:
    """Return the kind of a file, by its name."""
    path = PurePath(name.lower())
    lesson = lesson_by_name(name)
    if ".ipynb" in path.suffixes or (lesson and path.suffix in ("", ".json", ".txt")):
        return NOTEBOOK
    if path.suffix == ".py" and lesson is None and PurePath(name).stem.isidentifier():
        return MODULE
    return WORK if lesson or path.suffix in _WORK else OTHER


def _look(
    data: bytes,
    name: str,
    path: tuple[str, ...] = (),
    saved: datetime | None = None,
    depth: int = 0,
) -> list[Piece]:
    """Do the work of `look_at`, in the other process."""
    kind = kind_of(name)
    if name.lower().endswith(".zip"):
        return _look_in_zip(data, path, depth + 1)
    if kind == NOTEBOOK:
        try:
            return [Piece(path, kind, data, saved, contents.content_of(data, name))]
        except UnreadableNotebook as error:
            complaint = str(error).partition(". ")[0].removeprefix(name).strip(" .")
            # A text file with the name of a lesson may contain anything.
            kind = NOTEBOOK if ".ipynb" in name.lower() else WORK
            return [Piece(path, kind, data, saved, complaint=complaint)]
    if kind == MODULE and len(data) <= LARGEST_MODULE:
        return [Piece(path, kind, data, saved)]
    return [Piece(path, WORK if kind == WORK else OTHER)]


def _look_in_zip(data: bytes, path: tuple[str, ...], depth: int) -> list[Piece]:
    if depth > DEEPEST:
        return [Piece(path, WORK, complaint=f"lies {DEEPEST} zips deep, and is not opened")]
    try:
        entries = open_zip(io.BytesIO(data), MOST_FILES_OF_A_STUDENT)
    except Unreadable as error:
        return [Piece(path, WORK, complaint=str(error))]
    found, size = [], 0
    for parts, entry in entries:
        inner = (*path, *parts)
        if is_hidden(parts):
            continue
        if kind_of(parts[-1]) == OTHER:
            found.append(Piece(inner, OTHER))
            continue
        try:
            content = entry.read()
        except Unreadable as error:
            found.append(Piece(inner, WORK, complaint=str(error)))
            continue
        inside = _look(content, parts[-1], inner, entry.moment, depth)
        size += sum(len(piece.data) for piece in inside)
        if size > MOST_BYTES_OF_A_STUDENT:
            return [Piece(path, WORK, complaint=f"unpacks to {TOO_MUCH_OF_A_STUDENT}")]
        found += inside
    return found


def _plain(piece: Piece) -> tuple:
    """Return a piece in a form that JSON can represent."""
    return (
        piece.path,
        piece.kind,
        base64.b64encode(piece.data).decode(),
        piece.saved.isoformat() if piece.saved else "",
        (piece.content.lesson, piece.content.untouched),
        piece.complaint,
    )


def _piece(
    path: list[str], kind: str, data: str, saved: str, content: tuple[str, bool], complaint: str
) -> Piece:
    return Piece(
        tuple(path),
        kind,
        base64.b64decode(data),
        datetime.fromisoformat(saved) if saved else None,
        Content(*content),
        complaint,
    )
