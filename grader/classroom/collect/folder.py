"""Read archives of unknown format: ``{student}/…``, ``{student}.zip``, ``{student}_06_….ipynb``.

If no student is named, all files belong to one student, named after the archive. Folders that are
named after parts of the course never name a student.
"""

from __future__ import annotations

import functools
import os
import re
from collections import Counter
from collections.abc import Collection, Sequence
from pathlib import PurePath

from grader.classroom.collect.models import Archive, ArchiveEntry, Owner, SubmittedFile
from grader.classroom.collect.name_patterns import may_be_notebook
from grader.classroom.lesson_recognition import lesson_by_name
from grader.course.lessons import Lesson, all_lessons, stages

_WORD_OF_A_PROGRAM = re.compile(
    r"\d{0,2}|(?:untitled|copy|kopie)\d*|of|von|ipynb|txt|json|zip", re.IGNORECASE
)


def read_folder(archive: Archive, level: int = 0) -> list[SubmittedFile]:
    """Return the files of any archive, with owners named by folders or file names.

    Parameters
    ----------
    archive : Archive
    level : int, optional
        Level of the students' folders: 1 for the outermost. By default, it is recognised. Folders
        that are named after parts of the course do not count.
    """
    depth = level - 1 if level else _recognised_depth(archive.entries)
    paths = [entry.path for entry in _notebooks_in(archive.entries)]
    positions = {_position(path, depth) for path in paths}
    if None in positions and not level:
        # If some notebooks are not in a folder, only outermost folders can be students' folders.
        positions &= {0}
    shared_depth = len(
        os.path.commonprefix([path[: _position(path, depth) or 0] for path in paths])
    )
    name = archive.path.name if archive.path.is_dir() else archive.path.stem
    files = []
    for entry in archive.entries:
        label, inner = name, entry.path
        position = _position(entry.path, depth)
        if position is not None and position in positions:
            label = entry.path[position]
            inner = entry.path[shared_depth:position] + entry.path[position + 1 :]
        elif len(entry.path) == 1:
            label = student_name_in(entry.path[0]) or name
        owner = Owner(label, label, (label,), is_folder=not level)
        files.append(SubmittedFile(owner, inner, entry, saved_at=entry.moment))
    return files


def possible_levels(archive: Archive) -> dict[int, list[SubmittedFile]]:
    """Read the archive once for each level of folders that may be the students' folders.

    The outermost level is first. The result is empty if only one level is possible.
    """
    chains = [named_folders(entry.path) for entry in _notebooks_in(archive.entries)]
    depths = range(_recognised_depth(archive.entries), min(map(len, chains)))
    levels = {depth + 1: read_folder(archive, depth + 1) for depth in depths}
    return levels if len(levels) > 1 else {}


def folders_of_lessons(entries: Sequence[ArchiveEntry]) -> frozenset[str]:
    """Return the names of folders that belong to a lesson or an attempt, and not to a student.

    Such a name occurs within several folders, each time with the same lesson, as in ``ada/hw6/…``
    and ``bo/hw6/…``. Two students may also share a name, so more than half of the names at a level
    must occur repeatedly.

    If a folder contains a lesson several times, as in ``ada/try/…`` and ``ada/new/…``, the folders
    above may be attempts with students inside them. A class has more students than attempts, so
    there must then be more folders above than names inside them.
    """
    levels: dict[int, set[tuple[tuple[str, ...], str, Lesson]]] = {}
    for entry in _notebooks_in(entries):
        lesson = lesson_by_name(entry.path[-1])
        folders = named_folders(entry.path)
        for depth, name in enumerate(folders if lesson else ()):
            levels.setdefault(depth, set()).add((folders[:depth], name, lesson))
    found = set()
    for level in levels.values():
        parents = {parent for parent, _, _ in level}
        names = {name for _, name, _ in level}
        counts = Counter((name, lesson) for _, name, lesson in level)
        repeated = {name for (name, _), count in counts.items() if count > 1}
        has_attempts = max(Counter((parent, lesson) for parent, _, lesson in level).values()) > 1
        if 2 * len(repeated) > len(names) and (len(parents) > len(names) or not has_attempts):
            found |= repeated
    return frozenset(found)


def named_folders(path: Sequence[str], others: Collection[str] = ()) -> tuple[str, ...]:
    """Return the folders of a path, without folders of the course and without `others`."""
    return tuple(name for name in path[:-1] if not is_course_folder(name) and name not in others)


def student_name_in(name: str, *, only_before: bool = False) -> str:
    """Return the student's name in a file name; empty if the file name contains only a lesson.

    With `only_before`, the student's name must precede the lesson's name, as platforms write it.
    """
    stem = PurePath(name).stem
    lessons = "|".join(re.escape(lesson.name) for lesson in all_lessons())
    match = re.search(lessons, stem, re.IGNORECASE)
    if match is None:
        return stem if name.lower().endswith(".zip") else ""
    before, after = stem[: match.start()].strip(" _-."), stem[match.end() :].strip(" _-.")
    rest = before if only_before else before or after
    return "" if re.fullmatch(r"(?:copy of|copy|kopie von|kopie|\W|\d)*", rest.lower()) else rest


def extra_words(name: str) -> str:
    """Return the words in a file name that do not name its lesson; they may name a student.

    Short numbers and the words that programs add to names, such as *copy*, do not count.
    """
    lesson = lesson_by_name(name)
    ignored = lesson.name.split("_") if lesson else ()
    words = re.split(r"[\W_]+", name.lower())
    return " ".join(
        word for word in words if word not in ignored and not _WORD_OF_A_PROGRAM.fullmatch(word)
    )


@functools.lru_cache(10_000)
def is_course_folder(name: str) -> bool:
    """Return whether a folder is named after a part of the course and not after a student."""
    return name in (*stages(), "notebooks") or lesson_by_name(name) is not None


def _notebooks_in(entries: Sequence[ArchiveEntry]) -> Sequence[ArchiveEntry]:
    """Return the notebooks and zips among some files; all files if there are none."""
    return list(filter(may_be_notebook, entries)) or entries


def _recognised_depth(entries: Sequence[ArchiveEntry]) -> int:
    """Return the number of folders above the students' folders, without folders of the course.

    Other files, such as a table above the students' folders, do not belong to a student.
    """
    chains = [named_folders(entry.path) for entry in _notebooks_in(entries)]
    common = tuple(os.path.commonprefix(chains))
    others = [named_folders(entry.path) for entry in entries]
    others = [chain for chain in others if common[: len(chain)] != chain]
    depth = len(os.path.commonprefix(chains + others))
    return depth if all(len(chain) > depth for chain in chains) else 0


def _position(path: Sequence[str], depth: int) -> int | None:
    """Return the index in a path of the folder at a depth, ignoring folders of the course.

    The outermost folder has depth 0. Return None if the path has no folder at this depth.
    """
    indices = [index for index, name in enumerate(path[:-1]) if not is_course_folder(name)]
    return indices[depth] if depth < len(indices) else None
