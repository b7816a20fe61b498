"""Who takes the course: ``roster.csv`` beside it, one line a person. It need not be there."""

from __future__ import annotations

import csv
import dataclasses
import functools
import io
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from grader.course.paths import Course

MOST_CHARACTERS = 128  # of a text, in nbgrader's gradebook
OTHER_NAMES = {"lms_user_id": "lms_id"}  # what `nbgrader db student import` calls it
SEPARATORS = ",;\t"


class RosterTrouble(Exception):
    """The roster cannot be read; `str()` is the sentence to show, with file, line and remedy."""


@dataclass(frozen=True)
class Person:
    """One who takes the course.

    Attributes
    ----------
    id : str
        Name of the folder in ``submitted/``, and of the student in the gradebook.
    first_name, last_name, email, section : str
    lms_id : str
        Number in the learning platform, by which marks find their way back.
    github : str
        Login.
    """

    id: str
    first_name: str = ""
    last_name: str = ""
    email: str = ""
    section: str = ""
    lms_id: str = ""
    github: str = ""

    @property
    def name(self) -> str:
        """First and last name; the id of who has none."""
        return f"{self.first_name} {self.last_name}".strip() or self.id

    @property
    def called(self) -> str:
        """What sentences call somebody: the id, and the name where there is one."""
        return self.id if self.name == self.id else f"{self.id} ({self.name})"


COLUMNS = tuple(field.name for field in dataclasses.fields(Person))
UNIQUE = ("id", "email", "lms_id", "github")  # a mark that two may get goes to the wrong one


@dataclass(frozen=True)
class Roster:
    """All who take the course, in the order of the file."""

    people: tuple[Person, ...]

    def person(self, id: str) -> Person | None:
        """The one who has exactly this id."""
        return self._by_id.get(id)

    def owner(self, folder: str) -> Person | None:
        """Whose folder it is: case, blanks and the form of Unicode aside, an id and nothing else.

        Somebody else's number in the learning platform may be this one's id, so that only a person
        can tell; see `like`.
        """
        same = self._by_folded_id.get(folded(folder), ())
        return self.person(folder) or (same[0] if len(same) == 1 else None)

    def like(self, text: str) -> tuple[Person, ...]:
        """Whom a folder, login, number, e-mail or name may mean.

        Parameters
        ----------
        text : str
            Such as ``Yan``, ``yan@x.edu``, ``Yan Yip``, ``Yip, Yan`` or Canvas's ``yipyan``.

        Returns
        -------
        tuple of Person
            More than one where it fits several; an id goes before all else.
        """
        exact = self.person(text)
        if exact:
            return (exact,)
        same = self._by_folded_id.get(folded(text), ())
        return tuple(same) or tuple(person for person in self.people if _means(text, person))

    @functools.cached_property
    def _by_id(self) -> dict[str, Person]:
        return {person.id: person for person in self.people}

    @functools.cached_property
    def _by_folded_id(self) -> dict[str, list[Person]]:
        found = {}
        for person in self.people:
            found.setdefault(folded(person.id), []).append(person)
        return found


def roster_path(course: Course) -> Path:
    """Where the roster lies, if there is one."""
    return course.root / "roster.csv"


def read_roster(course: Course) -> Roster | None:
    """Read the roster of a course.

    Columns stand in any order, and only ``id`` has to be there; others than those of `Person` are
    left alone. Commas, semicolons or tabs separate them.

    Returns
    -------
    Roster or None
        None where there is no file.

    Raises
    ------
    RosterTrouble
    """
    path = roster_path(course)
    if not path.is_file():
        return None
    try:
        text = path.read_text("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RosterTrouble(
            f"{path.name} is not in UTF-8. Save it again as CSV UTF-8, which spreadsheets offer."
        ) from error
    head = text.partition("\n")[0]
    separator = max(SEPARATORS, key=head.count)
    rows = csv.reader(io.StringIO(text), delimiter=separator, strict=True)
    try:
        people = tuple(_people(path.name, rows))
    except csv.Error as error:
        raise RosterTrouble(
            f"{path.name}, line {rows.line_num}: {error}. Is a quotation mark missing?"
        ) from error
    return Roster(people)


def _people(file: str, rows: Iterator[list[str]]) -> Iterator[Person]:
    """Each person of a file, with a line that says why where one cannot be read."""
    columns = [_column(cell) for cell in next(rows, [])]
    if columns.count("id") != 1 or any(columns.count(name) > 1 for name in COLUMNS):
        raise RosterTrouble(
            f"{file}: its first line should name the columns, each once, such as "
            f"{','.join(COLUMNS)}. Only id has to be there."
        )
    seen = {}
    for row in rows:
        line = rows.line_num
        cells = [unicodedata.normalize("NFC", cell.strip()) for cell in row]
        if not any(cells):
            continue
        if len(cells) > len(columns):
            raise RosterTrouble(
                f"{file}, line {line}: {len(cells)} values for {len(columns)} columns. Put a value "
                f"that holds a separator between quotation marks."
            )
        about = dict(zip(columns, cells, strict=False))
        person = Person(**{name: about.get(name, "") for name in COLUMNS})
        _check(person, f"{file}, line {line}")
        for name in UNIQUE:
            value = getattr(person, name)
            before = seen.setdefault((name, value.casefold() if name != "id" else value), line)
            if value and before != line:
                raise RosterTrouble(
                    f"{file}, line {line}: line {before} has the same {name}, {value}. Marks could "
                    f"reach the wrong one: correct or remove one of the two."
                )
        yield person


def _column(cell: str) -> str:
    name = "_".join(cell.casefold().replace("-", " ").replace("_", " ").split())
    return OTHER_NAMES.get(name, name)


def _check(person: Person, where: str) -> None:
    if not person.id:
        raise RosterTrouble(f"{where}: it has no id. It names the folder in submitted/.")
    if person.id.startswith(".") or "/" in person.id or not person.id.isprintable():
        raise RosterTrouble(
            f"{where}: {person.id!r} cannot be the name of a folder. Give an id without slashes "
            f"that begins with no dot."
        )
    for name in COLUMNS:
        if len(getattr(person, name)) > MOST_CHARACTERS:
            raise RosterTrouble(
                f"{where}: {name} is longer than {MOST_CHARACTERS} characters, which is all that "
                f"the gradebook takes."
            )


def _means(text: str, person: Person) -> bool:
    """Whether a text is one of a person's other names."""
    handles = {folded(handle) for handle in (person.email, person.github, person.lms_id)}
    first, last = person.first_name, person.last_name
    names = {letters(first + last), letters(last + first)}
    return folded(text) in handles - {""} or letters(text) in names - {""}


def has_another_number(person: Person, lms_id: str) -> bool:
    """Whether a learning platform's number is surely not a person's.

    The roster may have a number of another kind; those of platforms have nothing but digits.
    """
    return lms_id.isdigit() and person.lms_id.isdigit() and lms_id != person.lms_id


def folded(text: str) -> str:
    """A text without what nobody means by it: case, blanks around it, forms of Unicode."""
    return " ".join(unicodedata.normalize("NFKC", text).casefold().split())


def letters(text: str) -> str:
    """Letters and digits of a name, as Canvas writes it."""
    return "".join(character for character in folded(text) if character.isalnum())
