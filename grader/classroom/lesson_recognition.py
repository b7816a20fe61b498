"""Find the lesson of a file from its name or its content."""

from __future__ import annotations

import functools
import os
import re
from dataclasses import dataclass
from pathlib import Path

from grader.course.lessons import Lesson, all_lessons, find_lesson
from grader.intake.notebook import read_file
from grader.intake.reader_process import ReadingFailed, run_in_child
from utils.notebooks.reading import Notebook, UnreadableNotebook, decode_notebook


@dataclass(frozen=True)
class NotebookContent:
    """The lesson of a notebook, and whether a student has changed the notebook.

    Attributes
    ----------
    lesson : str
        Name of the lesson in the metadata or, without one, of the lesson whose graded cells are in
        the notebook; empty if the lesson is unknown.
    untouched : bool
        Whether every cell is a cell of the released notebook, and the whole file was read.
    repairs : tuple of str
        One sentence for each repair of a damaged file; the damage may have destroyed work.
    """

    lesson: str = ""
    untouched: bool = False
    repairs: tuple[str, ...] = ()


def lesson_by_name(name: str) -> Lesson | None:
    """Return the lesson that a file name contains, even if a browser has changed the name."""
    return find_lesson(name.lower())


def is_notebook_name(name: str) -> bool:
    """Return whether a file is a notebook according to its name.

    Browsers and mail programs add ``.txt`` or ``.json`` to names.
    """
    return re.search(r"\.ipynb(\.txt|\.json)?$", name, re.IGNORECASE) is not None


def copy_number(name: str) -> int:
    """Return the number that a browser or platform added to a file's name; 0 if there is none."""
    stem = re.sub(r"(?:\.[A-Za-z]{1,6})+$", "", name)
    numbers = re.findall(r"(?:Copy|\(|[-_ ])\s*(\d{1,4})\)?$", stem)
    return int(numbers[-1]) if numbers else 0


def content_of(data: bytes, name: str) -> NotebookContent:
    """Read a notebook in this process and return its `NotebookContent`.

    Raises
    ------
    utils.notebooks.reading.UnreadableNotebook
    """
    notebook = decode_notebook(data, name)
    lesson = _lesson_of(notebook)
    if lesson is None:
        return NotebookContent(repairs=notebook.repairs)
    sources = {" ".join(cell.source.split()) for cell in notebook.cells}
    # A part of the student's work may be missing from a notebook that had to be repaired.
    untouched = not notebook.repairs and sources <= _released(lesson)
    return NotebookContent(lesson.name, untouched, notebook.repairs)


def contains_work(path: Path) -> bool:
    """Return whether a submitted notebook is readable and differs from its release.

    The notebook is read in a separate process. If this machine cannot read it, it may contain work.
    """
    cache_releases()

    def work() -> bool:
        return not content_of(read_file(path), path.name).untouched

    try:
        return run_in_child(path.name, work)
    except UnreadableNotebook:
        return False
    except ReadingFailed:
        return True


def cache_releases() -> None:
    """Fill the caches of `content_of`, so that forked processes inherit them."""
    for lesson in all_lessons():
        _released(lesson)
        _grade_ids(lesson)


def lesson_by_content(path: Path) -> Lesson | None:
    """Return the lesson of a submitted notebook, read in a separate process."""
    try:
        status = path.lstat()
    except OSError:
        return None
    return _lesson_by_content(path, status.st_ino, status.st_size, status.st_mtime_ns)


@functools.lru_cache(10_000)
def _lesson_by_content(path: Path, *file_state: int) -> Lesson | None:
    """Return the lesson of a notebook; the result is cached until `file_state` changes."""

    def work() -> str:
        lesson = _lesson_of(decode_notebook(read_file(path), os.fspath(path.name)))
        return lesson.name if lesson else ""

    for lesson in all_lessons():
        _grade_ids(lesson)
    try:
        name = run_in_child(path.name, work)
    except (UnreadableNotebook, ReadingFailed):
        return None
    return find_lesson(name) if name else None


def _lesson_of(notebook: Notebook) -> Lesson | None:
    named = find_lesson(notebook.lesson_name)
    if named:
        return named
    inside = {cell.grade_id for cell in notebook.cells} - {""}
    matching = [lesson for lesson in all_lessons() if inside & _grade_ids(lesson)]
    return matching[0] if len(matching) == 1 else None


@functools.cache
def _grade_ids(lesson: Lesson) -> frozenset[str]:
    names = (name for exercise in lesson.exercises for name in (exercise.name, exercise.cell))
    return frozenset(names)


@functools.cache
def _released(lesson: Lesson) -> frozenset[str]:
    notebook = decode_notebook(lesson.released.read_bytes(), lesson.released.name)
    return frozenset({"", *(" ".join(cell.source.split()) for cell in notebook.cells)})
