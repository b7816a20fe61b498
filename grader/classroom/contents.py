"""What lesson a file is for: by its name, and by what stands in it."""

from __future__ import annotations

import functools
import os
import re
from dataclasses import dataclass
from pathlib import Path

from grader.course.lessons import Lesson, all_lessons, find_lesson
from grader.intake.notebook import read_file
from grader.intake.reader_process import ReadingFailed, apart
from utils.notebooks.reading import Notebook, UnreadableNotebook, decode_notebook


@dataclass(frozen=True)
class Content:
    """What a notebook holds.

    Attributes
    ----------
    lesson : str
        Name of the lesson that it says it is, or whose graded cells are in it; empty where
        neither is known.
    untouched : bool
        True where nothing stands in it but what the lesson was released with.
    """

    lesson: str = ""
    untouched: bool = False


def lesson_by_name(name: str) -> Lesson | None:
    """The lesson that the name of a file names, whatever browsers made of it."""
    return find_lesson(name.lower())


def copy_number(name: str) -> int:
    """Which copy a browser, an editor or a learning platform says that a file is; else 0."""
    stem = re.sub(r"(?:\.[A-Za-z]{1,6})+$", "", name)
    numbers = re.findall(r"(?:Copy|\(|[-_ ])\s*(\d{1,4})\)?$", stem)
    return int(numbers[-1]) if numbers else 0


def look_into(data: bytes, name: str) -> Content:
    """What a notebook holds, read in this process; see `lesson_inside`.

    Raises
    ------
    utils.notebooks.reading.UnreadableNotebook
    """
    notebook = decode_notebook(data, name)
    lesson = _lesson_of(notebook)
    if lesson is None:
        return Content()
    sources = {" ".join(cell.source.split()) for cell in notebook.cells}
    return Content(lesson.name, sources <= _released(lesson))


def remember_what_was_released() -> None:
    """Read what `look_into` compares with, so that the processes forked from this one know it."""
    for lesson in all_lessons():
        _released(lesson)
        _grade_ids(lesson)


def lesson_inside(path: Path) -> Lesson | None:
    """The lesson that a stranger's notebook says it is, read in a process of its own."""
    try:
        status = path.lstat()
    except OSError:
        return None
    return _lesson_inside(path, status.st_ino, status.st_size, status.st_mtime_ns)


@functools.lru_cache(10_000)
def _lesson_inside(path: Path, *state: int) -> Lesson | None:
    """Remembered as long as the file is the same."""

    def work() -> str:
        lesson = _lesson_of(decode_notebook(read_file(path), os.fspath(path.name)))
        return lesson.name if lesson else ""

    for lesson in all_lessons():
        _grade_ids(lesson)
    try:
        name = apart(path.name, work)
    except (UnreadableNotebook, ReadingFailed):
        return None
    return find_lesson(name) if name else None


def _lesson_of(notebook: Notebook) -> Lesson | None:
    named = find_lesson(notebook.lesson_name)
    if named:
        return named
    inside = {cell.grade_id for cell in notebook.cells} - {""}
    holding = [lesson for lesson in all_lessons() if inside & _grade_ids(lesson)]
    return holding[0] if len(holding) == 1 else None


@functools.cache
def _grade_ids(lesson: Lesson) -> frozenset[str]:
    names = (name for exercise in lesson.exercises for name in (exercise.name, exercise.cell))
    return frozenset(names)


@functools.cache
def _released(lesson: Lesson) -> frozenset[str]:
    notebook = decode_notebook(lesson.released.read_bytes(), lesson.released.name)
    return frozenset({"", *(" ".join(cell.source.split()) for cell in notebook.cells)})
