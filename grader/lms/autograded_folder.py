"""Write the folder that Formgrader shows: autograded copies and the other submitted files.

Formgrader serves every file in this folder from the grader's own server, and a written answer can
link to a file. A script in a web page would then act as the grader, so web pages are left out.
"""

from __future__ import annotations

import contextlib
import mimetypes
import os
import re
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
    """Write the copies, the judged modules and the other submitted files to a draft folder."""
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
            is_left_out = is_notebook_name(name) or name.startswith(".") or _can_run_scripts(path)
            if is_regular and not is_left_out:
                yield path


def _can_run_scripts(path: Path) -> bool:
    """Return whether a browser runs scripts in a file, by the type with which it is served."""
    kind, encoding = mimetypes.guess_type(path)
    return encoding is None and bool(re.search("html|xml", kind or ""))


def remove_web_pages(folder: Path) -> None:
    """Remove web pages, which nbgrader's own commands copy from a submission."""
    for path in folder.rglob("*"):
        if path.is_file() and _can_run_scripts(path):
            path.unlink()


def replace_folder(draft: Path, folder: Path) -> None:
    """Replace a folder with its complete draft."""
    old = folder.with_name(f".{folder.name}.old")
    shutil.rmtree(old, ignore_errors=True)
    with contextlib.suppress(FileNotFoundError):
        folder.rename(old)
    draft.rename(folder)
    shutil.rmtree(old, ignore_errors=True)
