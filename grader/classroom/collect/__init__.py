"""Collect what a class handed in: ``python -m grader collect ARCHIVE… --stage STAGE``.

An archive is opened (`opening`, `zips`), one of `KINDS` says who handed in what, and `owners` finds
them on the roster, or in `answers`: that is `collecting`. What one `student` handed in is opened in
a process of its own (`looking`), `recognising` says which lesson a notebook is for, `choosing`
finds the newest, and `placing` puts it into ``submitted/``. The `outcome` has what is left to ask.

Another kind of archive is a module with a function from `Archive` to what was handed in, and a line
in the table.
"""

from collections.abc import Iterable
from pathlib import Path

from grader.classroom.collect.canvas import canvas
from grader.classroom.collect.folder import folder
from grader.classroom.collect.github import github
from grader.classroom.collect.moodle import moodle
from grader.classroom.collect.protocol import CollectTrouble, Handed, Kind
from grader.classroom.collect.sources import open_archive

__all__ = ["KINDS", "CollectTrouble", "Handed", "open_all"]

KINDS: dict[str, Kind] = {
    "Moodle": moodle,
    "Canvas": canvas,
    "GitHub Classroom": github,
    "a folder for each student": folder,
}
"""By what people call them, in the order in which they are tried; the last takes everything."""


def open_all(paths: Iterable[Path]) -> list[tuple[Path, str, list[Handed]]]:
    """Open archives; of each, what kind it is, and what was handed in.

    Raises
    ------
    CollectTrouble
    """
    found = []
    for path in paths:
        archive = open_archive(path)
        sorted_out = ((name, kind(archive)) for name, kind in KINDS.items())
        found.append((path, *next(pair for pair in sorted_out if pair[1] is not None)))
    return found
