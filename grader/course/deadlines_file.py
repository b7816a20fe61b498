"""Read ``deadlines.toml``, the optional file with the lecturer's settings for a term.

::

    timezone = "Europe/Berlin"              # default: the time zone of this machine
    drop_lowest = 1                         # lessons that each student's total leaves out
    pass_mark = 50                          # percentage of the possible points
    [stage1_ransac]
    due = 2026-10-12T23:59:00
    lessons = ["01", "02"]                  # the lessons that count; default: all of the stage
    without = ["drop_invalid"]              # exercises that do not count
    [stage1_ransac.sections]                # sections as written in the roster
    B = 2026-10-13T23:59:00
    [stage1_ransac.students]                # also for students without a submission
    anna = 2026-10-19T23:59:00
    noshow = "excused"
    [01_first_lesson]                       # a lesson with its own dates
    due = 2026-10-05T23:59:00

Seconds may be left out, and a date may be in quotation marks if it has only one meaning.
"""

from __future__ import annotations

import contextlib
import re
import tomllib
import unicodedata
import zoneinfo
from collections.abc import Iterable, Sequence
from dataclasses import replace
from datetime import date, datetime, tzinfo
from pathlib import Path

from grader.course import lessons
from grader.course.deadlines import Deadlines, DueDates, TermRules
from grader.course.lessons import Lesson
from grader.course.paths import Course
from grader.course.roster import Roster, read_roster
from grader.course.times import YEARS, UnclearTime, read_time, to_utc
from grader.errors import UserError

EXCUSED = "excused"
# TOML 1.1 allows dates without seconds, which Python's reader of TOML 1.0 refuses.
_WITHOUT_SECONDS = re.compile(r"(=\s*\d{4}-\d\d-\d\d[Tt ]\d\d:\d\d)(?![:\d])")
_EXAMPLE = "2026-10-12T23:59:00"
_SETTINGS = ("timezone", "drop_lowest", "pass_mark")
_LESSON_ENTRIES = ("due", "sections", "students")
_STAGE_ENTRIES = ("due", "lessons", "without", "sections", "students")
_PLACES = {
    **dict.fromkeys(_SETTINGS, "above the first heading"),
    **dict.fromkeys(_STAGE_ENTRIES, "below the heading of its stage"),
}


class DeadlinesError(UserError):
    """``deadlines.toml`` is invalid; `str()` says where the error is and how to fix it."""


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
            f"{_error_location(error, path.name, text)}. Write dates as {_EXAMPLE}. Put names that "
            "contain anything except plain letters, digits, - and _ in quotation marks, such as "
            '"mary jane".'
        ) from error
    zone = _parse_zone(path.name, table.pop("timezone", None))
    settings = {name: table.pop(name, None) for name in _SETTINGS[1:]}
    lessons_by_name = {lesson.name: lesson for lesson in lessons.all_lessons()}
    _check_keys(
        path.name,
        table,
        (*lessons.stages(), *_SETTINGS, *lessons_by_name),
        "stage, lesson or setting",
    )
    roster = read_roster(course)
    dates = {
        name: _parse_dates(f"{path.name}, [{name}", value, zone, lessons_by_name.get(name))
        for name, value in table.items()
    }
    for name in dates:
        _check_names(f"{path.name}, [{name}", dates[name], roster)
    stages = {
        name: replace(
            dates[name],
            lessons=_parse_assigned_lessons(f"{path.name}, [{name}]", table[name], name),
        )
        for name in table
        if name not in lessons_by_name
    }
    counted_lessons = [
        lesson
        for lesson in lessons.all_lessons()
        if (listed := stages.get(lesson.stage, DueDates()).lessons) is None or lesson.name in listed
    ]
    for name in table.keys() & {
        lesson.name for lesson in lessons_by_name.values() if lesson not in counted_lessons
    }:
        raise DeadlinesError(
            f"{path.name}, [{name}]: this lesson has a date but does not count. Add "
            f'"{lessons_by_name[name].number}" to lessons below [{lessons_by_name[name].stage}], '
            "or delete this "
            "heading."
        )
    excluded_exercises = {
        name
        for stage in stages
        for name in _parse_excluded_exercises(
            f"{path.name}, [{stage}]",
            table[stage],
            [lesson for lesson in counted_lessons if lesson.stage == stage],
        )
    }
    rules = TermRules(
        frozenset(excluded_exercises),
        _parse_drop_lowest(path.name, settings["drop_lowest"], len(counted_lessons)),
        _parse_pass_mark(path.name, settings["pass_mark"]),
    )
    own_dates = {name: dates[name] for name in lessons_by_name if name in dates}
    return Deadlines(stages, roster, zone, own_dates, rules)


def _error_location(error: tomllib.TOMLDecodeError, file: str, text: str) -> str:
    """Return the file, the line and the reader's complaint."""
    line = re.search(r" \(at line (\d+), column \d+\)$", str(error))
    if not line:
        return f"{file}: {error}"
    content = text.split("\n")[int(line[1]) - 1].strip()
    return f"{file}, line {line[1]}, {content}: {str(error)[: line.start()]}"


def _parse_zone(file: str, name: object) -> tzinfo | None:
    if name is None:
        return None
    try:
        return zoneinfo.ZoneInfo(name)
    except (zoneinfo.ZoneInfoNotFoundError, ValueError, TypeError, OSError) as error:
        raise DeadlinesError(
            f"{file}: the time zone {name!r} is unknown on this machine. Write one such as "
            f'"Europe/Berlin" or "UTC". Without this line, this machine\'s time zone is used.'
        ) from error


def _parse_dates(
    location: str, table: object, zone: tzinfo | None, lesson: Lesson | None
) -> DueDates:
    """Return the dates of a lesson, or of a stage if `lesson` is None.

    Error messages begin with `location`, such as "FILE, [STAGE".
    """
    if not isinstance(table, dict):
        raise DeadlinesError(
            f"{location}]: make this a heading, and write due = {_EXAMPLE} below it."
        )
    entries = _LESSON_ENTRIES if lesson else _STAGE_ENTRIES
    _check_keys(f"{location}]", table, entries, "entry")
    groups = {heading: table.get(heading, {}) for heading in ("sections", "students")}
    for heading, group in groups.items():
        if not isinstance(group, dict):
            raise DeadlinesError(
                f"{location}]: make {heading} a separate heading, "
                f"{location.partition(', ')[2]}.{heading}], with one line below it for each date."
            )
    excused = frozenset(id for id, value in groups["students"].items() if value == EXCUSED)
    if lesson and excused:
        raise DeadlinesError(
            f"{location}.students], {min(excused)}: a student can be excused only from a whole "
            f"stage. Move this line below [{lesson.stage}.students], or write a later date here."
        )
    due = table.get("due")
    due_dates = DueDates(
        None if due is None else _parse_date(f"{location}], due", due, zone),
        {
            name: _parse_date(f"{location}.sections], {name}", value, zone)
            for name, value in groups["sections"].items()
        },
        {
            id: _parse_date(f"{location}.students], {id}", value, zone, may_be_excused=True)
            for id, value in groups["students"].items()
            if id not in excused
        },
        excused,
    )
    if due_dates.due is None and (lesson or due_dates.sections or due_dates.students):
        some_have = due_dates.sections or due_dates.students
        reason = "only some students have a date" if some_have else "there is no date"
        raise DeadlinesError(
            f"{location}]: {reason}. Add a line due = {_EXAMPLE} below this heading."
        )
    return due_dates


def _parse_assigned_lessons(location: str, table: dict, stage: str) -> tuple[str, ...] | None:
    """Return the names of the lessons that count, or None if the table does not list them."""
    numbers = table.get("lessons")
    names_by_number = {
        lesson.number: lesson.name for lesson in lessons.all_lessons() if lesson.stage == stage
    }
    if numbers is None:
        return None
    if not isinstance(numbers, list) or not all(
        number in names_by_number for number in map(str, numbers)
    ):
        raise DeadlinesError(
            f"{location}, lessons: list the numbers of the lessons that count, in quotation marks, "
            f'such as lessons = ["{min(names_by_number)}"]. The lessons of this stage are: '
            f"{', '.join(names_by_number)}."
        )
    return tuple(sorted({names_by_number[number] for number in map(str, numbers)}))


def _parse_excluded_exercises(
    location: str, table: dict, counted_lessons: Sequence[Lesson]
) -> list[str]:
    """Return the exercises of a stage that are switched off; `counted_lessons` are its lessons."""
    names = table.get("without", [])
    exercises = {
        exercise.name: lesson for lesson in counted_lessons for exercise in lesson.exercises
    }
    if not isinstance(names, list) or not all(name in exercises for name in map(str, names)):
        raise DeadlinesError(
            f"{location}, without: list exercises in quotation marks, such as "
            f'without = ["{next(iter(exercises), "NAME")}"]. The exercises that count are: '
            f"{', '.join(exercises) or 'none'}."
        )
    for lesson in counted_lessons:
        if {exercise.name for exercise in lesson.exercises} <= set(names):
            raise DeadlinesError(
                f"{location}: `without` switches off all exercises of {lesson.name}. To leave out "
                "the whole lesson, write lessons = [...] with the numbers of the other lessons."
            )
    return names


def _parse_drop_lowest(file: str, value: object, count: int) -> int:
    """Return how many lessons are left out of each total; `count` lessons can count."""
    if value is None:
        return 0
    if type(value) is not int or not 0 <= value < count:
        raise DeadlinesError(
            f"{file}, drop_lowest: {value!s} is not a number of lessons that can be left out of "
            f"{count}. Write a whole number below {count}, such as drop_lowest = 1."
        )
    return value


def _parse_pass_mark(file: str, value: object) -> float | None:
    if value is not None and (type(value) not in (int, float) or not 0 < value <= 100):
        raise DeadlinesError(
            f"{file}, pass_mark: {value!s} is not a percentage of the points. Write a number from "
            "1 to 100, such as pass_mark = 50."
        )
    return value


def _parse_date(
    location: str, value: object, zone: tzinfo | None, may_be_excused: bool = False
) -> datetime:
    """Return a date from the file, in UTC."""
    when = value
    if isinstance(value, str):
        with contextlib.suppress(UnclearTime):
            when = read_time(value)
    if not isinstance(when, datetime):
        # A date alone could mean the start or the end of the day.
        example = f"{value}T23:59:00" if isinstance(value, date) else _EXAMPLE
        other = f', or "{EXCUSED}"' if may_be_excused else ""
        raise DeadlinesError(
            f"{location}: {value!s} is not a date with a time. Write it as {example}{other}."
        )
    if when.year not in YEARS:
        raise DeadlinesError(
            f"{location}: {value!s} is out of range. Write a date such as {_EXAMPLE}."
        )
    return to_utc(when, zone)


def _check_keys(
    location: str, table: dict, allowed_keys: Iterable[str], key_description: str
) -> None:
    for name in table:
        if name not in allowed_keys and name in _PLACES:
            raise DeadlinesError(f"{location}: move {name} {_PLACES[name]}.")
        if name not in allowed_keys:
            raise DeadlinesError(
                f"{location}: there is no {key_description} {name}. Choose from: "
                f"{', '.join(allowed_keys)}."
            )


def _check_names(location: str, dates: DueDates, roster: Roster | None) -> None:
    """Raise `DeadlinesError` if a name is not on the roster, because its date would be ignored."""
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
