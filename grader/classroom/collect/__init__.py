"""Collect the submissions of a class: ``python -m grader collect ARCHIVE… --stage STAGE``.

`collection` runs these steps. An archive is opened (`sources`, `zips`), one of `ARCHIVE_READERS`
says which owner each file belongs to, and `owners` finds the owners on the roster or in `answers`.
For each `student`, files are opened in a process of their own (`inspection`), `identification`
finds the lesson of a notebook, `selection` the newest file, and `storage` puts it into
``submitted/``. The `outcome` has the result and the open questions.

To add a kind of archive, write a module with a function from `Archive` to submitted files, and add
a line to the table.
"""

from collections.abc import Iterable
from pathlib import Path

from grader.classroom.collect.canvas import read_canvas
from grader.classroom.collect.folder import read_folder
from grader.classroom.collect.github import read_github
from grader.classroom.collect.moodle import read_moodle
from grader.classroom.collect.protocol import ArchiveReader, CollectError, SubmittedFile
from grader.classroom.collect.sources import open_archive

__all__ = ["ARCHIVE_READERS", "CollectError", "SubmittedFile", "open_archives"]

ARCHIVE_READERS: dict[str, ArchiveReader] = {
    "Moodle": read_moodle,
    "Canvas": read_canvas,
    "GitHub Classroom": read_github,
    "a folder for each student": read_folder,
}
"""By what people call them, in the order in which they are tried; the last takes everything."""


def open_archives(paths: Iterable[Path]) -> list[tuple[Path, str, list[SubmittedFile]]]:
    """Open archives, and return the kind of each and the submitted files in it.

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
