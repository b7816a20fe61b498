"""Collect the submissions of a class: ``python -m grader collect ARCHIVE… --stage STAGE``.

`collection` runs these steps:

1. `sources` and `zips` open an archive.
2. One of `ARCHIVE_READERS` determines the owner of each file.
3. `owners` looks up each owner in `instructor_answers`, on the roster or in Moodle's worksheet.
4. `student_collector` collects the files of one student. `inspection` opens them in a separate
   process, `identification` finds the lesson of each notebook, `selection` picks the newest file,
   and `storage` copies it to ``submitted/``.
5. `collection_report` contains the results and the open questions.

To support another archive format, write a module with a function that turns an `Archive` into
submitted files, and add it to `ARCHIVE_READERS`.
"""

import dataclasses
from collections.abc import Iterable, Iterator
from pathlib import Path

from grader.classroom.collect.canvas import read_canvas
from grader.classroom.collect.folder import possible_levels, read_folder
from grader.classroom.collect.github import ROSTER, read_github
from grader.classroom.collect.gradescope import METADATA, read_gradescope
from grader.classroom.collect.models import (
    Archive,
    ArchiveReader,
    CollectError,
    SubmittedArchive,
    SubmittedFile,
)
from grader.classroom.collect.moodle import read_moodle
from grader.classroom.collect.name_patterns import may_be_notebook, shared_folders
from grader.classroom.collect.platforms import (
    read_blackboard,
    read_brightspace,
    read_ilias,
    read_prairielearn,
    read_sakai,
)
from grader.classroom.collect.sources import open_archive

__all__ = ["ARCHIVE_READERS", "CollectError", "SubmittedFile", "open_archives"]

ARCHIVE_READERS: dict[str, ArchiveReader] = {
    "Gradescope": read_gradescope,
    "Moodle": read_moodle,
    "Blackboard": read_blackboard,
    "Brightspace": read_brightspace,
    "Sakai": read_sakai,
    "PrairieLearn": read_prairielearn,
    "Canvas": read_canvas,
    "ILIAS": read_ilias,
    "GitHub Classroom": read_github,
}
"""Readers by format, preferred in this order if several recognise equally many files.

`folder` reads any archive that no reader recognises.
"""

LISTS_OF_STUDENTS = (ROSTER, METADATA)  # files of a platform that the readers use


def open_archives(paths: Iterable[Path], folder_level: int = 0) -> Iterator[SubmittedArchive]:
    """Open archives, and yield the submitted files of each.

    Notebooks whose names do not have the format of the other files are yielded as a second archive.

    Parameters
    ----------
    paths : iterable of pathlib.Path
    folder_level : int, optional
        Level of the students' folders in archives of an unknown format: 1 for the outermost. By
        default, it is recognised.

    Raises
    ------
    CollectError
    """
    for path in paths:
        archive = open_archive(path)
        submitted = _read(archive, folder_level)
        read_entries = {file.entry for file in submitted.files}
        others = [entry for entry in archive.entries if entry not in read_entries]
        unneeded = tuple(
            entry
            for entry in others
            if not may_be_notebook(entry) and entry.path[-1] not in LISTS_OF_STUDENTS
        )
        yield dataclasses.replace(submitted, other_entries=unneeded)
        depth = len(shared_folders(archive.entries))
        notebooks = tuple(
            dataclasses.replace(entry, path=entry.path[depth:])
            for entry in filter(may_be_notebook, others)
        )
        if notebooks:
            kind = f"not named as in {submitted.kind}"
            yield _read_folders(Archive(path, notebooks), kind, folder_level)


def _read(archive: Archive, folder_level: int) -> SubmittedArchive:
    """Read an archive with the reader that recognises the most files.

    A student can imitate the names of another platform, and so name another student as the owner.
    Such names are few, because the real platform wrote the beginning of every file name.
    """
    readings_by_platform, errors = [], []
    for platform, read in ARCHIVE_READERS.items():
        try:
            files = read(archive)
        except CollectError as error:
            errors.append(error)
            continue
        if files:
            readings_by_platform.append((platform, files))
    if readings_by_platform:
        platform, files = max(readings_by_platform, key=lambda reading: len(reading[1]))
        return SubmittedArchive(archive.path, platform, tuple(files))
    if errors:
        raise errors[0]
    return _read_folders(archive, "a folder for each student", folder_level)


def _read_folders(archive: Archive, kind: str, level: int) -> SubmittedArchive:
    levels = {} if level else possible_levels(archive)
    return SubmittedArchive(archive.path, kind, tuple(read_folder(archive, level)), levels=levels)
