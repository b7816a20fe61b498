"""Read all other archives: ``{student}/…``, ``{student}.zip`` or ``{student}_06_….ipynb``.

If no student is named, all files belong to one student, named after the archive.
"""

from __future__ import annotations

import re
from pathlib import PurePath

from grader.classroom.collect.models import Archive, ArchiveEntry, Owner, SubmittedFile
from grader.classroom.collect.name_patterns import shared_folders
from grader.classroom.lesson_recognition import lesson_by_name
from grader.course.lessons import all_lessons, stages


def read_folder(archive: Archive) -> list[SubmittedFile]:
    """Return the files of any archive, with owners named by folders or file names."""
    depth = _wrapper_depth(archive)
    return [_submitted_file(archive, entry, entry.path[depth:]) for entry in archive.entries]


def _wrapper_depth(archive: Archive) -> int:
    """Return the number of folders above the students' folders."""
    shared = shared_folders(archive.entries)
    depth = len(shared)
    below = {entry.path[depth] for entry in archive.entries}
    only_folders = all(len(entry.path) > depth + 1 for entry in archive.entries)
    has_course_folder = any(map(_is_course_folder, {*shared, *below}))
    return depth if only_folders and not has_course_folder else 0


def _submitted_file(archive: Archive, entry: ArchiveEntry, path: tuple[str, ...]) -> SubmittedFile:
    archive_name = archive.path.name if archive.path.is_dir() else archive.path.stem
    label, inner = archive_name, path
    if len(path) > 1 and not _is_course_folder(path[0]):
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


def _is_course_folder(name: str) -> bool:
    """Return whether a folder is named after a part of the course and not after a student."""
    return name in (*stages(), "notebooks") or lesson_by_name(name) is not None
