"""Write marks into a Moodle assignment's offline grading worksheet, for upload.

Moodle finds its columns by titles in the site's language, so all columns are kept unchanged. It
skips blank cells. Without a message, it also skips marks that are above the maximum, locked or
changed since the download. The exporter reports the first two cases.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping

from grader.course.paths import Course
from grader.course.roster import Person, letters_and_digits
from grader.lms.collected_files import collected_files
from grader.lms.exporters.assignment_marks import collect_marks
from grader.lms.exporters.column_writer import (
    POINTS_TOLERANCE,
    Column,
    OwnedRow,
    fill_column,
    find_column,
    scale_factor,
)
from grader.lms.exporters.marks_file import MarksFile, read_marks_file, read_number
from grader.lms.exporters.protocol import ExportError, ExportOptions, ExportResult
from grader.lms.exporters.row_matching import PersonRow
from grader.lms.results import format_points

PARTICIPANT = re.compile(r"\D*\d+")  # "Participant 12" in the site's language
# Values of the column "Grade can be changed" for a locked grade, in various languages.
LOCKED_VALUES = frozenset(
    [
        "no",
        "nein",
        "non",
        "não",
        "nee",
        "nej",
        "nei",
        "ei",
        "nie",
        "ne",
        "nu",
        "nem",
        "hayır",
        "όχι",
        "нет",
        "ні",
        "не",
        "否",
        "いいえ",
        "아니요",
        "לא",
        "لا",
    ]
)
HOW_TO_DOWNLOAD = (
    "In Moodle: the assignment's Submissions, Actions, Download grading worksheet. This action "
    "appears only if the assignment's feedback types include the offline grading worksheet."
)


def export_moodle(options: ExportOptions) -> ExportResult:
    """Fill in the grades in a worksheet that Moodle wrote.

    Parameters
    ----------
    options : ExportOptions
        `column` is the title of the grade column.

    Raises
    ------
    ExportError
        If the file is not a grading worksheet, or if the points differ.
    """
    marks, sheet = collect_marks(options), read_marks_file(options.into)
    column = _grade_column(sheet, options.column)
    maximum = read_number(sheet.rows[0][column + 1])
    factor = scale_factor(marks, maximum, sheet.head[column], options.scale)
    decimal_mark = sheet.decimal_mark((column + 1, column))
    hidden = _hides_names(sheet)
    owners = _owners_of_labels(options.course, marks.people)
    owned_rows = [OwnedRow(row, _row(row, column, hidden, owners)) for row in sheet.rows]
    target = Column(column, factor, decimal_mark)
    filled = fill_column(marks, owned_rows, target, _refusal(column, maximum))
    text = sheet.text(range(len(sheet.head)), filled.rows)
    return ExportResult(text.encode(), filled.mark_count, filled.failures, filled.notes)


def _grade_column(sheet: MarksFile, requested_title: str | None) -> int:
    """Find the grade column; the column after it contains the same maximum in every row."""
    titles = {
        index: title for index, title in enumerate(sheet.head[:-1]) if _is_grade(sheet, index)
    }
    participants = all(PARTICIPANT.fullmatch(row[0].strip()) for row in sheet.rows)
    if not participants or not titles:
        raise ExportError(
            f"{sheet.name} is not an offline grading worksheet from Moodle, or its grades are "
            f"words instead of points. {HOW_TO_DOWNLOAD}"
        )
    if len(titles) == 1 and requested_title is None:
        return min(titles)
    return find_column(titles, "the grade", requested_title, sheet.name, str)


def _is_grade(sheet: MarksFile, index: int) -> bool:
    """Return whether a column and the next one may contain grades and their maximum."""
    (maximum, *others) = {row[index + 1] for row in sheet.rows}
    highest = read_number(maximum)
    if index == 0 or others or not highest:
        return False
    grades = [row[index].strip() for row in sheet.rows]
    numbers = [read_number(grade) for grade in grades if grade]
    return all(number is not None and number <= highest for number in numbers)


def _hides_names(sheet: MarksFile) -> bool:
    """Return whether the worksheet is anonymous and has a status in the column for the name."""
    return len({row[1] for row in sheet.rows}) <= len(sheet.rows) / 2


def _owners_of_labels(course: Course, people: Iterable[Person]) -> dict[str, str]:
    """Return the owner's ID for each label such as "Participant_501".

    If submissions are anonymous, the archive has these labels in place of names. Without other
    data, they are also the students' IDs. Labels are compared by their letters and digits, because
    the worksheet has a blank in place of the underscore.
    """
    ids: dict[str, set[str]] = {}
    for person in people:
        ids.setdefault(letters_and_digits(person.id), set()).add(person.id)
    for student, files in collected_files(course).items():
        for file in files.values():
            if file.participant:
                ids.setdefault(letters_and_digits(file.owner), set()).add(student)
    return {label: min(owners) for label, owners in ids.items() if len(owners) == 1}


def _row(row: tuple[str, ...], column: int, hidden: bool, owners: Mapping[str, str]) -> PersonRow:
    """Identify the owner of a row from its cells.

    The first cell contains a word and Moodle's participant number, and the second contains the
    name. The next cells are fields that the site has chosen, such as e-mail address and ID number.
    Without a roster, a student's ID consists of the name and the number, as in Moodle's archive.
    """
    fields = row[1:column]
    name = "" if hidden else row[1]
    certain = [(attribute, cell) for cell in fields for attribute in ("id", "email")]
    label = letters_and_digits(name + re.sub(r"\D", "", row[0])) if name else ""
    if letters_and_digits(owners.get(label, "")) == label:
        certain.append(("id", owners.get(label, "")))
    claims = (
        (*certain, ("id", owners.get(letters_and_digits(row[0]), "")), ("lms_id", row[0])),
        tuple(("lms_id", cell) for cell in fields),
    )
    return PersonRow(f"{row[0]} ({name})" if name else row[0], claims, name)


def _refusal(column: int, maximum: float) -> Callable[[tuple[str, ...], float], str]:
    def refuse(row: tuple[str, ...], points: float) -> str:
        if points > maximum + POINTS_TOLERANCE:
            return f"Moodle silently ignores marks above {format_points(maximum)}"
        if any(cell.strip().casefold() in LOCKED_VALUES for cell in row[column + 2 : column + 4]):
            return "the grade is locked in Moodle, which would silently ignore the mark"
        return ""

    return refuse
