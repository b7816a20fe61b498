"""Write marks into a gradebook file that Canvas exported and can import.

An import writes every column that Canvas recognises, and a blank cell deletes a mark. The output
therefore contains only the columns that identify a student, the assignment's column, and the rows
of students who have a mark or are excused. Other marks that were entered in the meantime do not
change.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from grader.course.roster import letters_and_digits
from grader.lms.exporters.assignment_marks import collect_marks
from grader.lms.exporters.column_writer import (
    Column,
    OwnedRow,
    fill_column,
    find_column,
    scale_factor,
)
from grader.lms.exporters.marks_file import MarksFile, read_marks_file, read_number
from grader.lms.exporters.protocol import ExportError, ExportOptions, ExportResult
from grader.lms.exporters.row_matching import PersonRow

NAMES = (("Student",), ("LastName", "FirstName"))
LAST_PEOPLE_COLUMN = "Section"  # the last column that identifies a student
# Canvas computes these columns and never imports them.
COMPUTED_COLUMN = re.compile("(Current|Final) (Score|Points|Grade)|Override (Score|Grade|Status)")
POINTS_POSSIBLE = "Points Possible"
EXCUSED, NOT_ASSIGNED = "EX", "N/A"
TEST_STUDENT = "Student, Test"
CLAIM_COLUMNS = (
    {"ID": ("lms_id",), "SIS User ID": ("id", "email"), "SIS Login ID": ("id", "email")},
    {"ID": ("id",), "SIS User ID": ("lms_id",), "SIS Login ID": ("lms_id",)},
)


def export_canvas(options: ExportOptions) -> ExportResult:
    """Fill in the assignment's column in a gradebook that Canvas exported.

    Raises
    ------
    ExportError
        If the file is not a gradebook from Canvas, or if the points differ.
    """
    marks, sheet = collect_marks(options), read_marks_file(options.into)
    people = _people_columns(sheet)
    column = _column(sheet, len(people), marks.assignment, options.column)
    possible = [row for row in sheet.rows if POINTS_POSSIBLE in row[0]]
    if not possible:
        raise ExportError(
            f"{sheet.name} has no row {POINTS_POSSIBLE!r}, so the points cannot be "
            "compared. Export the gradebook again."
        )
    maximum = read_number(possible[0][column])
    factor = scale_factor(marks, maximum, sheet.head[column], options.scale)
    owned_rows = []
    for row in sheet.rows:
        name = _name(row, people)
        if POINTS_POSSIBLE not in row[0] and name not in ("", TEST_STUDENT):
            owned_rows.append(OwnedRow(row, _person_row(sheet, row, name)))
    decimal_mark = sheet.decimal_mark((column, *range(len(people), len(sheet.head))))
    target = Column(column, factor, decimal_mark, EXCUSED)
    filled = fill_column(marks, owned_rows, target, _refusal(column))
    text = sheet.text([*range(len(people)), column], [*possible[:1], *filled.rows])
    return ExportResult(text.encode(), filled.mark_count, filled.failures, filled.notes)


def _people_columns(sheet: MarksFile) -> tuple[str, ...]:
    """Return the titles of the columns that identify a student."""
    if (
        any(sheet.head[: len(names)] == names for names in NAMES)
        and LAST_PEOPLE_COLUMN in sheet.head
    ):
        return sheet.head[: sheet.head.index(LAST_PEOPLE_COLUMN) + 1]
    raise ExportError(
        f"{sheet.name} is not a gradebook from Canvas, which begins with Student or "
        "LastName and has a column Section. In Canvas: Grades, Export, Export Entire "
        "Gradebook."
    )


def _column(sheet: MarksFile, first: int, assignment: str, requested_title: str | None) -> int:
    titles = {
        index: title
        for index, title in enumerate(sheet.head)
        if index >= first and not COMPUTED_COLUMN.search(title)
    }
    if requested_title is None:
        titles = {index: title for index, title in titles.items() if _title(title) != title}
    try:
        return find_column(titles, assignment, requested_title, sheet.name, _title)
    except ExportError as error:
        ignored = [
            title
            for title in sheet.head[first:]
            if COMPUTED_COLUMN.search(title) and _title(title) != title
        ]
        if not ignored:
            raise
        raise ExportError(
            f"{error} Canvas never imports {' or '.join(map(repr, ignored))}, because the "
            f"title contains {COMPUTED_COLUMN.search(ignored[0])[0]!r}. Rename the assignment in "
            "Canvas, and export the gradebook again."
        ) from error


def _title(title: str) -> str:
    """Return the title of an assignment without the number that Canvas adds."""
    return re.sub(r"\s\(\d+\)$", "", title)


def _name(row: tuple[str, ...], people: tuple[str, ...]) -> str:
    """Return a student's name without the quotes that Canvas adds to possible formulas."""
    cells = [re.sub(r'^="(.*)"$', r"\1", cell.strip()) for cell in row]
    return ", ".join(cells[:2]).strip(", ") if people[0] == "LastName" else cells[0]


def _person_row(sheet: MarksFile, row: tuple[str, ...], name: str) -> PersonRow:
    """Identify the owner of a row.

    Without a roster, a student's ID is the beginning of the names in Canvas's archive, which
    consists of the name and the number.
    """
    certain, *others = (
        tuple(
            (attribute, row[sheet.head.index(title)])
            for title, attributes in rank.items()
            if title in sheet.head
            for attribute in attributes
        )
        for rank in CLAIM_COLUMNS
    )
    number = row[sheet.head.index("ID")].strip() if "ID" in sheet.head else ""
    in_archive = f"{letters_and_digits(name)}_{number}"
    return PersonRow(name, ((*certain, ("id", in_archive)), *others), name, number)


def _refusal(column: int) -> Callable[[tuple[str, ...], float], str]:
    def refuse(row: tuple[str, ...], points: float) -> str:
        if row[column].strip() == NOT_ASSIGNED:
            return (
                "Canvas would ignore the mark, because the assignment is not assigned to this "
                "student (N/A)"
            )
        return ""

    return refuse
