"""Match the folders in ``submitted/`` with the roster, and suggest a fix for the other folders."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

from grader.course.lessons import stages
from grader.course.paths import Course
from grader.course.roster import Person, Roster, letters_and_digits, read_roster, roster_path
from grader.errors import UserError

MAX_SUGGESTIONS = 3


class UnknownStudent(UserError):
    """A text matches no student or several students; `str()` says what to do."""


def find_student(course: Course, text: str) -> str:
    """Return the ID of the student with a given ID, name, e-mail address, login or folder.

    Parameters
    ----------
    course : grader.course.paths.Course
    text : str
        An ID, a name, an e-mail address, a login, or a folder in ``submitted/``.

    Raises
    ------
    UnknownStudent
    """
    roster = read_roster(course)
    people = roster.find_people(text) if roster else ()
    if len(people) > 1:
        names = " or ".join(person.display_name for person in people)
        raise UnknownStudent(f"{text!r} may be {names}. Use the student's id instead.")
    if people:
        return people[0].id
    if text in _student_folders(course):
        return text
    prefix = "is not on the roster, and " if roster else ""
    name_part = letters_and_digits(text)
    similar = [
        person.display_name
        for person in (roster.people if roster else ())
        if name_part and name_part in letters_and_digits(f"{person.first_name} {person.last_name}")
    ]
    remedy = "Correct the name"
    if 0 < len(similar) <= MAX_SUGGESTIONS:
        remedy = f"Did you mean {' or '.join(similar)}? Use the student's id"
    raise UnknownStudent(f"{text!r} {prefix}has no folder in {course.submitted.name}/. {remedy}.")


def find_section(course: Course, name: str) -> tuple[Person, ...]:
    """Return the students of a section.

    Raises
    ------
    UnknownStudent
        If no student on the roster is in this section.
    """
    roster = read_roster(course)
    people = roster.people_in_section(name) if roster else ()
    if not people:
        sections = {person.section for person in roster.people} - {""} if roster else ()
        raise UnknownStudent(
            f"No student on the roster is in section {name!r}. "
            + (
                f"The sections are: {', '.join(sorted(sections))}."
                if sections
                else f"Add a column section to {roster_path(course).name}."
            )
        )
    return people


def unmatched_folders(course: Course, roster: Roster) -> dict[str, str]:
    """Return the folders that match no student on the roster, each with a suggested fix.

    Their notebooks are judged, but the scores are not entered into the gradebook, because the
    folder may be misnamed or belong to a person who does not take the course.
    """
    return {
        folder: _suggested_fix(course, roster, folder)
        for folder in _student_folders(course)
        if roster.owner_of(folder) is None
    }


def misspelt_folders(course: Course, roster: Roster) -> Iterator[str]:
    """Yield a sentence about each folder that spells a student's ID differently."""
    folders = _student_folders(course)
    for folder in folders:
        owner = roster.owner_of(folder)
        if owner and owner.id != folder:
            addition = f", and so does {owner.id!r}" if owner.id in folders else ""
            yield (
                f"{folder!r} in {course.submitted.name}/ belongs to {owner.display_name}{addition}."
            )


def _student_folders(course: Course) -> list[str]:
    """Return the folders in ``submitted/`` that contain a stage."""
    found = {path.parent.name for stage in stages() for path in course.submitted.glob(f"*/{stage}")}
    return sorted(found)


def _suggested_fix(course: Course, roster: Roster, folder: str) -> str:
    add = f"add a line for {folder!r} to {roster_path(course).name}"
    beginning = f"{folder!r} is not on the roster, so its scores are not entered."
    people = roster.find_people(folder) or roster.people_with_leading_zeros(folder)
    if not people:
        return f"{beginning} Either {add}, or rename the folder to the student's id."
    if len(people) > 1:
        names = " or ".join(person.display_name for person in people)
        return f"{beginning} It may belong to {names}. Rename the folder to the right id, or {add}."
    commands = " && ".join(_move_commands(course, folder, people[0]))
    return (
        f"{beginning} If it belongs to {people[0].display_name}, run: {commands}; otherwise {add}."
    )


def _move_commands(course: Course, folder: str, person: Person) -> Iterator[str]:
    """Yield commands that move a folder into a student's folder without overwriting anything."""
    source, destination = course.submitted / folder, course.submitted / person.id
    if not destination.exists():
        yield _move_command(course, source, destination)
        return
    for path in sorted(source.iterdir()):
        target = destination / path.name
        # Do not merge two folders: the grader also looks in subfolders, and uses the newest file.
        if target.is_dir():
            target /= f"from {folder}"
        yield _move_command(course, path, target)


def _move_command(course: Course, source: Path, destination: Path) -> str:
    return shlex.join(
        ["mv", "-n", *(str(path.relative_to(course.root)) for path in (source, destination))]
    )
