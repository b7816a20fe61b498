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

from collections.abc import Iterable
from pathlib import Path

from grader.classroom.collect.canvas import read_canvas
from grader.classroom.collect.folder import read_folder
from grader.classroom.collect.github import read_github
from grader.classroom.collect.models import ArchiveReader, CollectError, SubmittedFile
from grader.classroom.collect.moodle import read_moodle
from grader.classroom.collect.sources import open_archive

__all__ = ["ARCHIVE_READERS", "CollectError", "SubmittedFile", "open_archives"]

ARCHIVE_READERS: dict[str, ArchiveReader] = {
    "Moodle": read_moodle,
    "Canvas": read_canvas,
    "GitHub Classroom": read_github,
    "a folder for each student": read_folder,
}
"""Readers by format, in the order in which they are tried; the last one reads any archive."""


def open_archives(paths: Iterable[Path]) -> list[tuple[Path, str, list[SubmittedFile]]]:
    """Open archives, and return the path, format and submitted files of each.

    Raises
    ------
    CollectError
    """
    archives = []
    for path in paths:
        archive = open_archive(path)
        readings = ((name, read(archive)) for name, read in ARCHIVE_READERS.items())
        archives.append((path, *next(pair for pair in readings if pair[1] is not None)))
    return archives
