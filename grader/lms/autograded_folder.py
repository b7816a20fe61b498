"""Write the folder that Formgrader shows: autograded copies and the other submitted files."""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path

import nbformat

from grader.classroom.lesson_recognition import is_notebook_name
from grader.course.paths import Course
from grader.intake.notebook import read_file
from grader.intake.submission import is_skipped_folder
from grader.lms.stage_entries import StageEntry
from utils.notebooks.reading import UnreadableNotebook


def write_draft(
    course: Course, entry: StageEntry, copies: dict, modules: dict[Path, bytes], draft: Path
) -> None:
    """Write the copies, the judged modules and all other submitted files to a draft folder."""
    shutil.rmtree(draft, ignore_errors=True)
    draft.mkdir(parents=True)
    for submitted in entry.folders(course):
        for path in _other_files(submitted):
            with contextlib.suppress(UnreadableNotebook):
                _write(read_file(path), draft / path.relative_to(submitted))
    for path, source in modules.items():
        _write(source, draft / path)
    for name, notebook in copies.items():
        # A name of a file may contain bytes that are not text.
        content = (nbformat.writes(notebook) + "\n").encode(errors="replace")
        _write(content, draft / f"{name}.ipynb")
    for path in draft.rglob("*"):
        if path.is_file():
            path.chmod(0o444)  # read-only, as nbgrader leaves them


def _write(content: bytes, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def _other_files(root: Path) -> Iterator[Path]:
    for folder, folders, files in os.walk(root):
        folders[:] = [name for name in folders if not is_skipped_folder(name)]
        for name in files:
            path = Path(folder) / name
            is_regular = stat.S_ISREG(path.lstat().st_mode)
            if is_regular and not is_notebook_name(name) and not name.startswith("."):
                yield path


def replace_folder(draft: Path, folder: Path) -> None:
    """Replace a folder with its complete draft."""
    old = folder.with_name(f".{folder.name}.old")
    shutil.rmtree(old, ignore_errors=True)
    with contextlib.suppress(FileNotFoundError):
        folder.rename(old)
    draft.rename(folder)
    shutil.rmtree(old, ignore_errors=True)
