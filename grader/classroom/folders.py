"""Whose the folders in ``submitted/`` are, by the roster; and what to do where it does not say."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

from grader.course.lessons import stages
from grader.course.paths import Course
from grader.course.roster import Person, Roster, read_roster, roster_path


class UnknownStudent(Exception):
    """Nobody, or more than one, is meant; `str()` is the sentence to show."""


def who_is_meant(course: Course, text: str) -> str:
    """Id of the student whom somebody has named.

    Parameters
    ----------
    course : grader.course.paths.Course
    text : str
        An id, a name, an e-mail, a login; or a folder in ``submitted/``.

    Raises
    ------
    UnknownStudent
    """
    roster = read_roster(course)
    meant = roster.like(text) if roster else ()
    if len(meant) > 1:
        whom = " or ".join(person.called for person in meant)
        raise UnknownStudent(f"{text!r} may be {whom}: name the id.")
    if meant:
        return meant[0].id
    if text in _folders(course):
        return text
    nobody = "is not on the roster, and " if roster else ""
    raise UnknownStudent(f"{text!r} {nobody}has no folder in {course.submitted.name}/.")


def strangers(course: Course, roster: Roster) -> dict[str, str]:
    """The folders of nobody on the roster, each with a sentence that says what would settle it.

    What lies there is judged, and not entered into the gradebook: it may be somebody's who is in
    there under another name, or of nobody who takes the course.
    """
    return {
        folder: _question(course, roster, folder)
        for folder in _folders(course)
        if roster.owner(folder) is None
    }


def spelt_otherwise(course: Course, roster: Roster) -> Iterator[str]:
    """A sentence on each folder whose name is somebody's id in another spelling."""
    folders = _folders(course)
    for folder in folders:
        owner = roster.owner(folder)
        if owner and owner.id != folder:
            beside = " beside what lies in the folder of that name" if owner.id in folders else ""
            yield f"{folder!r} in {course.submitted.name}/ is taken for {owner.called}{beside}."


def _folders(course: Course) -> list[str]:
    """The folders in which somebody has handed in a stage."""
    found = {
        place.parent.name for stage in stages() for place in course.submitted.glob(f"*/{stage}")
    }
    return sorted(found)


def _question(course: Course, roster: Roster, folder: str) -> str:
    add = f"add a line for {folder!r} to {roster_path(course).name}"
    begins = f"{folder!r} is not on the roster, so that its marks are not entered."
    meant = roster.like(folder)
    if not meant:
        return f"{begins} Either {add}, or rename the folder to the id of whoever it is."
    if len(meant) > 1:
        whom = " or ".join(person.called for person in meant)
        return f"{begins} It may be of {whom}: rename the folder to the right id, or {add}."
    commands = " && ".join(_moves(course, folder, meant[0]))
    return f"{begins} If it is of {meant[0].called}: {commands}; else {add}."


def _moves(course: Course, folder: str, person: Person) -> Iterator[str]:
    """The commands that give a folder to somebody, and write over nothing that is there."""
    here, there = course.submitted / folder, course.submitted / person.id
    if not there.exists():
        yield _move(course, here, there)
        return
    for place in sorted(here.iterdir()):
        target = there / place.name
        if target.is_dir():  # files in folders of their own are found, too, and the newest counts
            target /= f"from {folder}"
        yield _move(course, place, target)


def _move(course: Course, here: Path, there: Path) -> str:
    return shlex.join(["mv", "-n", *(str(path.relative_to(course.root)) for path in (here, there))])
