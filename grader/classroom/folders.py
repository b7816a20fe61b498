"""Match the folders in ``submitted/`` with the roster, and suggest what to do about the rest."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

from grader.course.lessons import stages
from grader.course.paths import Course
from grader.course.roster import Person, Roster, read_roster, roster_path


class UnknownStudent(Exception):
    """A text fits no student or several; `str()` is the sentence to show."""


def find_student(course: Course, text: str) -> str:
    """Return the id of the student that a text names.

    Parameters
    ----------
    course : grader.course.paths.Course
    text : str
        An id, a name, an e-mail, a login, or a folder in ``submitted/``.

    Raises
    ------
    UnknownStudent
    """
    roster = read_roster(course)
    people = roster.find_people(text) if roster else ()
    if len(people) > 1:
        names = " or ".join(person.display_name for person in people)
        raise UnknownStudent(f"{text!r} may be {names}: name the id.")
    if people:
        return people[0].id
    if text in _folders(course):
        return text
    nobody = "is not on the roster, and " if roster else ""
    raise UnknownStudent(f"{text!r} {nobody}has no folder in {course.submitted.name}/.")


def unmatched_folders(course: Course, roster: Roster) -> dict[str, str]:
    """Return the folders that match no student on the roster, each with a sentence on what to do.

    Their notebooks are judged but not entered into the gradebook: the folder may belong to a
    student under another name, or to a person who does not take the course.
    """
    return {
        folder: _question(course, roster, folder)
        for folder in _folders(course)
        if roster.owner_of(folder) is None
    }


def respelt_folders(course: Course, roster: Roster) -> Iterator[str]:
    """Return a sentence on each folder whose name is a student's id in another spelling."""
    folders = _folders(course)
    for folder in folders:
        owner = roster.owner_of(folder)
        if owner and owner.id != folder:
            addition = " in addition to the folder of that name" if owner.id in folders else ""
            yield (
                f"{folder!r} in {course.submitted.name}/ belongs to {owner.display_name}{addition}."
            )


def _folders(course: Course) -> list[str]:
    """Return the folders in ``submitted/`` that contain a stage."""
    found = {path.parent.name for stage in stages() for path in course.submitted.glob(f"*/{stage}")}
    return sorted(found)


def _question(course: Course, roster: Roster, folder: str) -> str:
    add = f"add a line for {folder!r} to {roster_path(course).name}"
    beginning = f"{folder!r} is not on the roster, so its scores are not entered."
    people = roster.find_people(folder)
    if not people:
        return f"{beginning} Either {add}, or rename the folder to the student's id."
    if len(people) > 1:
        names = " or ".join(person.display_name for person in people)
        return f"{beginning} It may be of {names}: rename the folder to the right id, or {add}."
    commands = " && ".join(_moves(course, folder, people[0]))
    return f"{beginning} If it belongs to {people[0].display_name}: {commands}; otherwise {add}."


def _moves(course: Course, folder: str, person: Person) -> Iterator[str]:
    """Return commands that move a folder to a student and overwrite nothing."""
    source, destination = course.submitted / folder, course.submitted / person.id
    if not destination.exists():
        yield _move(course, source, destination)
        return
    for path in sorted(source.iterdir()):
        target = destination / path.name
        if target.is_dir():  # files in subfolders are found as well, and the newest counts
            target /= f"from {folder}"
        yield _move(course, path, target)


def _move(course: Course, source: Path, destination: Path) -> str:
    return shlex.join(
        ["mv", "-n", *(str(path.relative_to(course.root)) for path in (source, destination))]
    )
