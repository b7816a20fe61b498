"""Collect the submissions of a class: ``python -m grader collect ARCHIVE… --stage STAGE``.

`collection` runs these steps:

1. `sources` and `zips` open an archive.
2. One of `ARCHIVE_READERS` determines the owner of each file.
3. `owners` looks up each owner on the roster, in Moodle's worksheet or in `answers`.
4. `student` collects the files of one student. `inspection` opens them in a separate process,
   `identification` finds the lesson of each notebook, `selection` picks the newest file, and
   `storage` copies it to ``submitted/``.
5. `outcome` contains the results and the open questions.

To support another archive format, write a module with a function that turns an `Archive` into
submitted files, and add it to `ARCHIVE_READERS`.
"""

import dataclasses
from collections.abc import Iterable, Iterator
from pathlib import Path

from grader.classroom.collect.canvas import read_canvas
from grader.classroom.collect.folder import read_folder
from grader.classroom.collect.github import read_github
from grader.classroom.collect.gradescope import read_gradescope
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
    "a folder for each student": read_folder,
}
"""Readers by format, preferred in this order if several recognise equally many files.

The last one reads any archive that no other reader recognises.
"""


def open_archives(paths: Iterable[Path]) -> Iterator[SubmittedArchive]:
    """Open archives, and yield the submitted files of each.

    Notebooks whose names do not have the format of the other files are yielded as a second archive.

    Raises
    ------
    CollectError
    """
    for path in paths:
        archive = open_archive(path)
        kind, files = _read(archive)
        submitted = {file.entry for file in files}
        others = [entry for entry in archive.entries if entry not in submitted]
        unneeded = tuple(entry for entry in others if not may_be_notebook(entry))
        yield SubmittedArchive(path, kind, tuple(files), unneeded)
        depth = len(shared_folders(archive.entries))
        notebooks = tuple(
            dataclasses.replace(entry, path=entry.path[depth:])
            for entry in filter(may_be_notebook, others)
        )
        if notebooks:
            files = read_folder(Archive(path, notebooks))
            yield SubmittedArchive(path, f"not named as in {kind}", tuple(files))


def _read(archive: Archive) -> tuple[str, list[SubmittedFile]]:
    """Return the format of an archive and its submitted files.

    A student may choose a file name in the format of another platform, which would name another
    student as the owner. The reader that recognises the most files is therefore the right one,
    because the platform wrote the beginning of every name.
    """
    *platforms, (fallback, read_any) = ARCHIVE_READERS.items()
    readings_by_platform, errors = [], []
    for platform, read in platforms:
        try:
            files = read(archive)
        except CollectError as error:
            errors.append(error)
            continue
        if files:
            readings_by_platform.append((platform, files))
    if readings_by_platform:
        return max(readings_by_platform, key=lambda reading: len(reading[1]))
    if errors:
        raise errors[0]
    return fallback, read_any(archive)
