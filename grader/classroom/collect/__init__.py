"""Collect the submissions of a class: ``python -m grader collect ARCHIVE… --stage STAGE``.

`collection` runs these steps. An archive is opened (`sources`, `zips`), one of `KINDS` says which
owner each file belongs to, and `owners` finds the owners on the roster or in `answers`. For each
`student`, files are opened in a process of their own (`inspection`), `identification` finds the
lesson of a notebook, `selection` the newest file, and `storage` puts it into ``submitted/``. The
`outcome` has the result and the open questions.

To add a kind of archive, write a module with a function from `Archive` to submitted files, and add
a line to the table.
"""

from collections.abc import Iterable
from pathlib import Path

from grader.classroom.collect.canvas import canvas
from grader.classroom.collect.folder import folder
from grader.classroom.collect.github import github
from grader.classroom.collect.moodle import moodle
from grader.classroom.collect.protocol import CollectError, Kind, SubmittedFile
from grader.classroom.collect.sources import open_archive

__all__ = ["KINDS", "CollectError", "SubmittedFile", "open_all"]

KINDS: dict[str, Kind] = {
    "Moodle": moodle,
    "Canvas": canvas,
    "GitHub Classroom": github,
    "a folder for each student": folder,
}
"""By what people call them, in the order in which they are tried; the last takes everything."""


def open_all(paths: Iterable[Path]) -> list[tuple[Path, str, list[SubmittedFile]]]:
    """Open archives, and return the kind of each and the submitted files in it.

    Raises
    ------
    CollectError
    """
    found = []
    for path in paths:
        archive = open_archive(path)
        sorted_out = ((name, kind(archive)) for name, kind in KINDS.items())
        found.append((path, *next(pair for pair in sorted_out if pair[1] is not None)))
    return found
