"""Due dates, from the optional file ``deadlines.toml`` in the course's folder.

::

    timezone = "Europe/Berlin"              # default: the time zone of this machine
    [stage1_ransac]
    due = 2026-10-12T23:59:00
    lessons = ["01", "02"]                  # the lessons that count; default: all of the stage
    [stage1_ransac.sections]                # sections as written in the roster
    B = 2026-10-13T23:59:00
    [stage1_ransac.students]                # also for students without a submission
    anna = 2026-10-19T23:59:00
    noshow = "excused"

Seconds may be left out, and a date may be in quotation marks if it has only one meaning.
"""

from __future__ import annotations

import contextlib
import re
import tomllib
import unicodedata
import zoneinfo
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from datetime import date, datetime, tzinfo
from pathlib import Path

from grader.course import lessons
from grader.course.paths import Course
from grader.course.roster import Person, Roster, read_roster
from grader.course.times import YEARS, UnclearTime, read_time, to_utc

EXCUSED = "excused"
# TOML 1.1 allows dates without seconds, which Python's reader of TOML 1.0 refuses.
_WITHOUT_SECONDS = re.compile(r"(=\s*\d{4}-\d\d-\d\d[Tt ]\d\d:\d\d)(?![:\d])")
_EXAMPLE = "2026-10-12T23:59:00"
_PLACES = {
    "timezone": "above the first heading",
    **dict.fromkeys(("due", "sections", "students"), "below the heading of its stage"),
}


class DeadlinesError(Exception):
    """``deadlines.toml`` is invalid; `str()` says where the error is and how to fix it."""


@dataclass(frozen=True)
class StageDates:
    """The due dates of one stage.

    All dates are in UTC, because Python ignores daylight saving when it subtracts two times in
    the same zone.

    Attributes
    ----------
    due : datetime or None
        Due date of students who are not in `sections` or `students`.
    sections : dict of str to datetime
    students : dict of str to datetime
    excused : frozenset of str
        Students who do not have to submit.
    lessons : tuple of str or None
        Names of the lessons that count; None if the file does not say.
    """

    due: datetime | None = None
    sections: dict[str, datetime] = field(default_factory=dict)
    students: dict[str, datetime] = field(default_factory=dict)
    excused: frozenset[str] = frozenset()
    lessons: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Deadlines:
    """The due dates of all stages, including the dates of sections and of single students.

    Attributes
    ----------
    stages : dict of str to StageDates
    roster : grader.course.roster.Roster or None
        Contains the section of each student.
    zone : tzinfo or None
        Zone of times that do not state one; None for the zone of this machine.
    """

    stages: dict[str, StageDates]
    roster: Roster | None = None
    zone: tzinfo | None = None

    def due(self, person: Person | str, stage: str) -> datetime | None:
        """Return the due date of a stage for a student, in UTC, or None if there is none."""
        dates = self.stages.get(stage, StageDates())
        id = person if isinstance(person, str) else person.id
        return dates.students.get(id, self._due_without_extension(id, dates))

    def to_local_time(self, time: datetime) -> datetime:
        """Convert a time to the time zone of the course."""
        return time.astimezone(self.zone)

    def is_excused(self, id: str, stage: str) -> bool:
        """Return whether a student is excused from a stage."""
        return id in self.stages.get(stage, StageDates()).excused

    def assigned(self, stage: str) -> tuple[str, ...] | None:
        """Return the names of a stage's lessons that count, or None if the file does not say."""
        return self.stages.get(stage, StageDates()).lessons

    def extensions(self, stage: str) -> dict[str, datetime]:
        """Return the due dates of students who have an extension, by student ID."""
        dates = self.stages.get(stage, StageDates())
        return {
            id: due
            for id, due in dates.students.items()
            if due > self._due_without_extension(id, dates)
        }

    def _due_without_extension(self, id: str, dates: StageDates) -> datetime | None:
        person = self.roster.person(id) if self.roster else None
        return dates.sections.get(person.section, dates.due) if person else dates.due


def deadlines_path(course: Course) -> Path:
    """Return the path of ``deadlines.toml``, which may not exist."""
    return course.root / "deadlines.toml"


def read_deadlines(course: Course) -> Deadlines | None:
    """Read the due dates of a course.

    Returns
    -------
    Deadlines or None
        None if there is no file.

    Raises
    ------
    DeadlinesError
        If the file is invalid.
    grader.course.roster.RosterError
        If the roster cannot be read.
    """
    path = deadlines_path(course)
    if not path.is_file():
        return None
    try:
        # Normalized like the names on the roster, because Unicode has two forms of letters like ö.
        text = unicodedata.normalize("NFC", path.read_text("utf-8-sig"))
        table = tomllib.loads(_WITHOUT_SECONDS.sub(r"\1:00", text))
    except UnicodeDecodeError as error:
        raise DeadlinesError(f"{path.name} is not in UTF-8. Save it as UTF-8.") from error
    except tomllib.TOMLDecodeError as error:
        raise DeadlinesError(
            f"{_place_of(error, path.name, text)}. Write dates as {_EXAMPLE}. Put names that "
            "contain anything except plain letters, digits, - and _ in quotation marks, such as "
            '"mary jane".'
        ) from error
    zone = _zone(path.name, table.pop("timezone", None))
    _check_keys(path.name, table, (*lessons.stages(), "timezone"), "stage or setting")
    roster = read_roster(course)
    all_dates = {
        stage: replace(
            _dates(f"{path.name}, [{stage}", value, zone),
            lessons=_assigned(f"{path.name}, [{stage}]", value, stage),
        )
        for stage, value in table.items()
    }
    for stage, dates in all_dates.items():
        _check_names(f"{path.name}, [{stage}", dates, roster)
    return Deadlines(all_dates, roster, zone)


def _place_of(error: tomllib.TOMLDecodeError, file: str, text: str) -> str:
    """Return the file, the line and the reader's complaint."""
    line = re.search(r" \(at line (\d+), column \d+\)$", str(error))
    if not line:
        return f"{file}: {error}"
    content = text.split("\n")[int(line[1]) - 1].strip()
    return f"{file}, line {line[1]}, {content}: {str(error)[: line.start()]}"


def _zone(file: str, name: object) -> tzinfo | None:
    if name is None:
        return None
    try:
        return zoneinfo.ZoneInfo(name)
    except (zoneinfo.ZoneInfoNotFoundError, ValueError, TypeError, OSError) as error:
        raise DeadlinesError(
            f"{file}: the timezone {name!r} is unknown on this machine. Write one such as "
            f'"Europe/Berlin" or "UTC". Without this line, the timezone of this machine is used.'
        ) from error


def _dates(location: str, table: object, zone: tzinfo | None) -> StageDates:
    """Return the dates of a stage. Error messages begin with `location`, such as "FILE, [STAGE"."""
    if not isinstance(table, dict):
        raise DeadlinesError(
            f"{location}]: make this a heading, and write due = {_EXAMPLE} below it."
        )
    _check_keys(f"{location}]", table, ("due", "lessons", "sections", "students"), "entry")
    groups = {kind: table.get(kind, {}) for kind in ("sections", "students")}
    for kind, group in groups.items():
        if not isinstance(group, dict):
            raise DeadlinesError(
                f"{location}]: make {kind} a separate heading, "
                f"{location.partition(', ')[2]}.{kind}], with one line below it for each date."
            )
    excused = frozenset(id for id, value in groups["students"].items() if value == EXCUSED)
    due = table.get("due")
    read = StageDates(
        None if due is None else _date(f"{location}], due", due, zone),
        {
            name: _date(f"{location}.sections], {name}", value, zone)
            for name, value in groups["sections"].items()
        },
        {
            id: _date(f"{location}.students], {id}", value, zone, or_excused=True)
            for id, value in groups["students"].items()
            if id not in excused
        },
        excused,
    )
    if read.due is None and (read.sections or read.students):
        raise DeadlinesError(
            f"{location}]: only some students have a date. Add a line due = {_EXAMPLE} below this "
            "heading for all others."
        )
    return read


def _assigned(location: str, table: dict, stage: str) -> tuple[str, ...] | None:
    """Return the names of the lessons that count, or None if the table does not list them."""
    numbers = table.get("lessons")
    known = {
        lesson.number: lesson.name for lesson in lessons.all_lessons() if lesson.stage == stage
    }
    if numbers is None:
        return None
    if not isinstance(numbers, list) or not all(number in known for number in map(str, numbers)):
        raise DeadlinesError(
            f"{location}, lessons: list the numbers of the lessons that count, in quotation marks, "
            f'such as lessons = ["{min(known)}"]. The lessons of this stage are: '
            f"{', '.join(known)}."
        )
    return tuple(sorted({known[number] for number in map(str, numbers)}))


def _date(location: str, value: object, zone: tzinfo | None, or_excused: bool = False) -> datetime:
    """Return a date from the file, in UTC."""
    when = value
    if isinstance(value, str):
        with contextlib.suppress(UnclearTime):
            when = read_time(value)
    if not isinstance(when, datetime):
        # A date alone could mean the start or the end of the day.
        example = f"{value}T23:59:00" if isinstance(value, date) else _EXAMPLE
        other = f', or "{EXCUSED}"' if or_excused else ""
        raise DeadlinesError(
            f"{location}: {value!s} is not a date with a time. Write it as {example}{other}."
        )
    if when.year not in YEARS:
        raise DeadlinesError(
            f"{location}: {value!s} is out of range. Write a date such as {_EXAMPLE}."
        )
    return to_utc(when, zone)


def _check_keys(location: str, table: dict, known: Iterable[str], what: str) -> None:
    for name in table:
        if name not in known and name in _PLACES:
            raise DeadlinesError(f"{location}: move {name} {_PLACES[name]}.")
        if name not in known:
            raise DeadlinesError(
                f"{location}: there is no {what} {name}. Choose from: {', '.join(known)}."
            )


def _check_names(location: str, dates: StageDates, roster: Roster | None) -> None:
    """Raise `DeadlinesError` if a name is not on the roster, because its date has no effect."""
    if dates.sections and roster is None:
        raise DeadlinesError(
            f"{location}.sections]: the sections are unknown, because there is no roster.csv. "
            f"Write one with the columns id and section, or set dates for individual students."
        )
    if roster is None:
        return
    sections = {person.section for person in roster.people}
    for name in dates.sections:
        if name not in sections:
            raise DeadlinesError(
                f"{location}.sections], {name}: no student on the roster is in this section. "
                f"The sections are: {', '.join(sorted(sections - {''})) or 'none'}."
            )
    for id in (*dates.students, *dates.excused):
        if roster.person(id) is None:
            suggestions = " or ".join(person.id for person in roster.find_people(id))
            raise DeadlinesError(
                f"{location}.students], {id}: no student on the roster has this id. "
                + (
                    f"Write {suggestions}."
                    if suggestions
                    else "Correct it, or add a line to roster.csv."
                )
            )
