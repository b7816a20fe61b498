"""The students of the course, from the optional file ``roster.csv``, one line per student."""

from __future__ import annotations

import dataclasses
import functools
import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from grader.course.paths import Course
from grader.course.tables import Table, TableError, read_table
from grader.errors import UserError

MAX_CHARACTERS = 128  # the limit of nbgrader's gradebook
COLUMN_ALIASES = {"lms_user_id": "lms_id"}  # the name that `nbgrader db student import` uses


class RosterError(UserError):
    """The roster is invalid; `str()` says where the error is and how to fix it."""


@dataclass(frozen=True)
class Person:
    """A student of the course.

    Attributes
    ----------
    id : str
        Name of the student's folder in ``submitted/``, and ID in the gradebook.
    first_name, last_name, email, section : str
    lms_id : str
        Number of the student in the LMS, which exports of marks need.
    github : str
        GitHub login.
    role : str
        "auditor" for a person whose work is judged but does not count; other roles are ignored.
    additional_cells : tuple of (str, str)
        Titles and values of all other columns, which only pass through to tables of marks.
    """

    id: str
    first_name: str = ""
    last_name: str = ""
    email: str = ""
    section: str = ""
    lms_id: str = ""
    github: str = ""
    role: str = ""
    additional_cells: tuple[tuple[str, str], ...] = ()

    @property
    def is_auditor(self) -> bool:
        """Whether the person takes the course without earning marks."""
        return normalized_text(self.role) == "auditor"

    @property
    def name(self) -> str:
        """First and last name, or the ID if both are empty."""
        return f"{self.first_name} {self.last_name}".strip() or self.id

    @property
    def display_name(self) -> str:
        """The ID, followed by the name in brackets if there is one."""
        return self.id if self.name == self.id else f"{self.id} ({self.name})"


COLUMNS = tuple(
    field.name for field in dataclasses.fields(Person) if field.name != "additional_cells"
)
# If two students shared one of these, marks could go to the wrong student.
UNIQUE = ("id", "email", "lms_id", "github")


@dataclass(frozen=True)
class Roster:
    """All students of the course, in the order of the file."""

    people: tuple[Person, ...]

    def person(self, id: str) -> Person | None:
        """Return the student with exactly this ID, or None."""
        return self._by_id.get(id)

    def owner_of(self, folder: str) -> Person | None:
        """Return the student whose ID is the name of a folder, or None.

        Case, surrounding blanks and Unicode forms are ignored. Unlike `find_people`, this method
        compares only IDs, because one student's number in the LMS may be another student's ID.
        """
        same = self._by_folded_id.get(normalized_text(folder), ())
        return self.person(folder) or (same[0] if len(same) == 1 else None)

    def people_in_section(self, name: str) -> tuple[Person, ...]:
        """Return the students of a section; case and blanks are ignored."""
        normalized_name = normalized_text(name)
        return tuple(
            person
            for person in self.people
            if normalized_name and normalized_text(person.section) == normalized_name
        )

    def find_people(self, text: str) -> tuple[Person, ...]:
        """Return the students that an ID, login, LMS number, e-mail or name may refer to.

        Parameters
        ----------
        text : str
            For example ``Yan``, ``yan@x.edu``, ``Yan Yip``, ``Yip, Yan`` or Canvas's ``yipyan``.

        Returns
        -------
        tuple of Person
            Several students if the text is ambiguous. IDs take precedence over other matches.
        """
        exact = self.person(text)
        if exact:
            return (exact,)
        same = self._by_folded_id.get(normalized_text(text), ())
        return tuple(same) or tuple(person for person in self.people if _is_name_of(text, person))

    def people_with_leading_zeros(self, text: str) -> tuple[Person, ...]:
        """Return the students whose ID equals a number except for leading zeros.

        Spreadsheets remove leading zeros.
        """
        number = text.strip().lstrip("0")
        return tuple(
            person
            for person in self.people
            if number.isdigit() and person.id.lstrip("0") == number and person.id != text
        )

    @functools.cached_property
    def _by_id(self) -> dict[str, Person]:
        return {person.id: person for person in self.people}

    @functools.cached_property
    def _by_folded_id(self) -> dict[str, list[Person]]:
        people_by_id = {}
        for person in self.people:
            people_by_id.setdefault(normalized_text(person.id), []).append(person)
        return people_by_id


def roster_path(course: Course) -> Path:
    """Return the path of the roster, which may not exist."""
    return course.root / "roster.csv"


def read_roster(course: Course) -> Roster | None:
    """Read the roster of a course.

    Columns may be in any order, and only ``id`` is required. The separator may be a comma, a
    semicolon or a tab.

    Returns
    -------
    Roster or None
        None if there is no file.

    Raises
    ------
    RosterError
        If the file is invalid.
    """
    path = roster_path(course)
    if not path.is_file():
        return None
    try:
        table = read_table(path.read_bytes(), strict=True)
    except TableError as error:
        raise RosterError(
            f"{path.name}, line {error.line}: {error}. Is a quotation mark missing?"
            if error.line
            else f"{path.name} is not encoded in UTF-8. Save it again from your spreadsheet "
            "program as CSV UTF-8."
        ) from error
    return Roster(tuple(_parse_people(path.name, table)))


def _parse_people(file: str, table: Table) -> Iterator[Person]:
    """Yield the students in a file; raise `RosterError` for an invalid line."""
    columns = [_column_name(cell) for cell in table.titles]
    if columns.count("id") != 1 or any(columns.count(name) > 1 for name in COLUMNS):
        raise RosterError(
            f"{file}: the first line must name the columns, each once, such as "
            f"{','.join(COLUMNS)}. Only id is required."
        )
    seen_values = {}
    for line, row in zip(table.lines[1:], table.rows[1:], strict=True):
        cells = [unicodedata.normalize("NFC", cell.strip()) for cell in row]
        if not any(cells):
            continue
        if len(cells) > len(columns):
            raise RosterError(
                f"{file}, line {line}: there are {len(cells)} values for {len(columns)} columns. "
                "If a value contains a separator, put it in quotation marks."
            )
        cells += [""] * (len(columns) - len(cells))
        values = dict(zip(columns, cells, strict=True))
        additional_cells = tuple(
            (title.strip(), cell)
            for title, name, cell in zip(table.titles, columns, cells, strict=True)
            if title.strip() and name not in COLUMNS
        )
        person = Person(
            **{name: values.get(name, "") for name in COLUMNS}, additional_cells=additional_cells
        )
        _check_person(person, f"{file}, line {line}")
        for name in UNIQUE:
            value = getattr(person, name)
            before = seen_values.setdefault(
                (name, value.casefold() if name != "id" else value), line
            )
            if value and before != line:
                raise RosterError(
                    f"{file}, line {line}: line {before} has the same {name}, {value}. Correct or "
                    f"remove one of the two, because marks could go to the wrong student."
                )
        yield person


def _column_name(cell: str) -> str:
    name = "_".join(cell.casefold().replace("-", " ").replace("_", " ").split())
    return COLUMN_ALIASES.get(name, name)


def _check_person(person: Person, location: str) -> None:
    if not person.id:
        raise RosterError(
            f"{location}: the id is missing. Add the name of the folder in submitted/."
        )
    if person.id.startswith(".") or "/" in person.id or not person.id.isprintable():
        raise RosterError(
            f"{location}: {person.id!r} cannot be the name of a folder. Use an id that contains no "
            f"slash and does not begin with a dot."
        )
    for name in COLUMNS:
        if len(getattr(person, name)) > MAX_CHARACTERS:
            raise RosterError(
                f"{location}: {name} is longer than {MAX_CHARACTERS} characters, the limit of the "
                f"gradebook. Shorten it."
            )


def _is_name_of(text: str, person: Person) -> bool:
    """Return whether a text is a person's name, e-mail, GitHub login or LMS number."""
    handles = {normalized_text(handle) for handle in (person.email, person.github, person.lms_id)}
    first, last = person.first_name, person.last_name
    names = {letters_and_digits(first + last), letters_and_digits(last + first)}
    return normalized_text(text) in handles - {""} or letters_and_digits(text) in names - {""}


def has_other_lms_id(person: Person, lms_id: str) -> bool:
    """Return whether an LMS's number for a student proves that a person is not this student.

    If either ID contains anything except digits, the two may be IDs of different kinds, which
    proves nothing.
    """
    return lms_id.isdigit() and person.lms_id.isdigit() and lms_id != person.lms_id


def normalized_text(text: str) -> str:
    """Normalize a text, so that comparisons ignore case, repeated blanks and Unicode forms."""
    return " ".join(unicodedata.normalize("NFKC", text).casefold().split())


def section_slug(section: str) -> str:
    """Replace the unusual characters in the name of a section, for use in a file name."""
    return re.sub(r"[^\w-]+", "_", section)


def letters_and_digits(text: str) -> str:
    """Return the letters and digits of a name in lower case, as in Canvas's file names."""
    return "".join(character for character in normalized_text(text) if character.isalnum())
