"""Read all other archives: ``{student}/…``, ``{student}.zip`` or ``{student}_06_….ipynb``.

If no student is named, all files belong to one student, named after the archive.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import PurePath

from grader.classroom.collect.models import Archive, ArchiveEntry, Owner, SubmittedFile
from grader.classroom.collect.name_patterns import may_be_notebook, shared_folders
from grader.classroom.lesson_recognition import lesson_by_name
from grader.course.lessons import all_lessons, stages


def read_folder(archive: Archive) -> list[SubmittedFile]:
    """Return the files of any archive, with owners named by folders or file names."""
    depth = _wrapper_depth(archive.entries)
    return [
        _submitted_file(archive, entry, entry.path[min(depth, len(entry.path) - 1) :])
        for entry in archive.entries
    ]


def _wrapper_depth(entries: Sequence[ArchiveEntry]) -> int:
    """Return the number of folders above the students' folders."""
    depth = len(shared_folders(entries))
    below_folders = [entry for entry in entries if len(entry.path) > depth + 1]
    loose = [entry for entry in entries if len(entry.path) == depth + 1]
    if below_folders and loose and not any(map(may_be_notebook, loose)):
        return _wrapper_depth(below_folders)  # a readme or a table is next to the folders
    names = {entry.path[depth] for entry in entries}
    return 0 if loose or any(map(is_course_folder, names)) else depth


def _submitted_file(archive: Archive, entry: ArchiveEntry, path: tuple[str, ...]) -> SubmittedFile:
    archive_name = archive.path.name if archive.path.is_dir() else archive.path.stem
    label, inner = archive_name, path
    if len(path) > 1 and not is_course_folder(path[0]):
        label, inner = path[0], path[1:]
    elif len(path) == 1:
        label = student_name_in(path[0]) or archive_name
    owner = Owner(label, label, (label,), is_folder=True)
    return SubmittedFile(owner, inner, entry, saved=entry.moment)


def student_name_in(name: str) -> str:
    """Return the student's name in a file name; empty if the file name contains only a lesson."""
    stem = PurePath(name).stem
    lessons = "|".join(re.escape(lesson.name) for lesson in all_lessons())
    match = re.search(lessons, stem, re.IGNORECASE)
    if match is None:
        return stem if name.lower().endswith(".zip") else ""
    rest = stem[: match.start()].strip(" _-.") or stem[match.end() :].strip(" _-.")
    return "" if re.fullmatch(r"(?:copy of|copy|kopie von|kopie|\W|\d)*", rest.lower()) else rest


def is_course_folder(name: str) -> bool:
    """Return whether a folder is named after a part of the course and not after a student."""
    return name in (*stages(), "notebooks") or lesson_by_name(name) is not None
