"""Fill one column of an LMS file with marks, and report marks and rows without a counterpart.

This is the common part of the exporters for Canvas and Moodle. The rows of students without a mark
are omitted, so an import does not change the marks that the LMS has stored for them. Excused
students keep their rows if the LMS has a text for them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from grader.course.roster import letters_and_digits
from grader.lms.exporters.assignment_marks import Marks, list_sentence
from grader.lms.exporters.marks_file import read_number
from grader.lms.exporters.protocol import ExportError
from grader.lms.exporters.row_matching import PersonRow, match_rows
from grader.lms.instructor_notes import DEADLINES_FILE
from grader.lms.results import EXCUSED, format_points

POINTS_TOLERANCE = 0.005  # points are written with two decimal places


@dataclass(frozen=True)
class OwnedRow:
    """A row of the file, and the data that identifies its owner."""

    row: tuple[str, ...]
    owner: PersonRow


@dataclass(frozen=True)
class FilledColumn:
    """The result of filling a column; `failures` and `notes` are as in `ExportResult`."""

    rows: tuple[tuple[str, ...], ...]
    mark_count: int
    failures: tuple[str, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Column:
    """The column for the marks and its number format.

    Attributes
    ----------
    index : int
    factor : float
        Factor by which the course's points are multiplied.
    decimal_mark : str
    excused : str
        Text for an excused student; empty if the LMS has no such text. Like a mark, the text may
        be refused, and it is listed if it replaces another value.
    """

    index: int
    factor: float
    decimal_mark: str
    excused: str = ""


def fill_column(
    marks: Marks,
    owned_rows: Sequence[OwnedRow],
    column: Column,
    refusal: Callable[[tuple[str, ...], float], str],
) -> FilledColumn:
    """Write each mark into the row of its owner.

    Parameters
    ----------
    marks : Marks
    owned_rows : list of OwnedRow
    column : Column
    refusal : callable
        Accepts a row and its points. Returns why the LMS would reject the points; empty if it would
        accept them.
    """
    matches = match_rows([owned_row.owner for owned_row in owned_rows], marks.people)
    rows: dict[int, tuple[str, ...]] = {}
    failures, replaced = [], []
    for mark in marks.marks:
        points = mark.points * column.factor
        index = matches.rows.get(mark.person.id)
        reason = (
            matches.doubts.get(mark.person.id, "the file has no row for this student")
            if index is None
            else refusal(owned_rows[index].row, points)
        )
        if reason:
            failures.append(
                f"{mark.person.display_name}, {format_points(points)} "
                f"point{'s' * (points != 1)}: {reason}."
            )
        else:
            row, cell = owned_rows[index].row, format_points(points, column.decimal_mark)
            rows[index] = _with_cell(row, column, cell)
            if not _is_unchanged(row[column.index], points):
                old = row[column.index].strip()
                replaced.append(f"{mark.person.display_name} from {old} to {cell}")
    mark_count = len(rows)
    unexcused = []
    for person in marks.unmarked[EXCUSED] if column.excused else ():
        index = matches.rows.get(person.id)
        if index is None:
            continue
        row = owned_rows[index].row
        if reason := refusal(row, 0.0):
            unexcused.append(f"{person.display_name}: {reason}")
            continue
        rows[index] = _with_cell(row, column, column.excused)
        old = row[column.index].strip()
        if old not in ("", column.excused):
            replaced.append(f"{person.display_name} from {old} to {column.excused}")
    absent = {
        person.id: person.display_name
        for people in marks.unmarked.values()
        for person in people
        if person.id not in matches.rows
    }
    notes = (
        *marks.notes,
        list_sentence("Marks changed in the file", replaced),
        list_sentence("Excused, but not marked as excused in the file", unexcused),
        list_sentence("Matched only by name", matches.by_name),
        list_sentence("Under another name in the file", matches.renamed),
        list_sentence("In the file, but not among your students", matches.unknown_rows),
        list_sentence(
            "Among your students, but not in the file",
            [name for id, name in absent.items() if id not in matches.doubts],
        ),
        *(f"{name}: {matches.doubts[id]}." for id, name in absent.items() if id in matches.doubts),
    )
    in_order = tuple(rows[index] for index in sorted(rows))
    return FilledColumn(
        in_order, mark_count, (*marks.failures, *failures), tuple(filter(None, notes))
    )


def scale_factor(marks: Marks, platform_maximum: float | None, title: str, scale: bool) -> float:
    """Return the factor that converts the course's points into the LMS's points.

    Raises
    ------
    ExportError
        If the LMS has no maximum, or if its maximum differs and `scale` is False.
    """
    if not platform_maximum:
        raise ExportError(
            f"The platform has no maximum for {title!r}. Set {format_points(marks.max_points)}"
            " points there, and download the file again."
        )
    if abs(platform_maximum - marks.max_points) < POINTS_TOLERANCE:
        return 1.0
    if scale:
        return platform_maximum / marks.max_points
    lessons = ", ".join(
        f"{name} {format_points(points)}" for name, points in marks.lesson_points.items()
    )
    choice = (
        "If you have not assigned all of these lessons, list those that count below "
        f"[{marks.assignment}] in {DEADLINES_FILE}: "
        f'lessons = ["{min(marks.lesson_points)[:2]}", …]. '
        if len(marks.lesson_points) > 1
        else ""
    )
    names = ", ".join(marks.excluded)
    excluded = f"Exercises that do not count: {names}. " if names else ""
    raise ExportError(
        f"{marks.assignment} is worth {format_points(marks.max_points)} points in the course "
        f"({lessons}), but {title!r} is worth {format_points(platform_maximum)} on the platform. "
        f"{excluded}{choice}"
        "Change the points there and download the file again, or add --scale to convert each mark."
    )


def find_column(
    titles: dict[int, str], assignment: str, requested_title: str | None, file: str, plain: Callable
) -> int:
    """Find the column of an assignment by its title.

    `plain` removes the parts that the LMS adds to a title.

    Raises
    ------
    ExportError
        If no column or several columns match; the message lists all titles.
    """
    if requested_title is not None:
        indices = [
            index for index, title in titles.items() if requested_title in (title, plain(title))
        ]
        target = f"column {requested_title!r}"
    else:
        name = letters_and_digits(assignment)
        indices = [
            index for index, title in titles.items() if name in letters_and_digits(plain(title))
        ]
        target = f"column whose title contains {assignment}"
    if len(indices) == 1:
        return indices[0]
    available = ", ".join(repr(title) for title in titles.values()) or "none for marks"
    raise ExportError(
        f"{file} has {'no' if not indices else 'more than one'} {target}. Name the column "
        f"with --column; the columns are: {available}."
    )


def _is_unchanged(before: str, points: float) -> bool:
    """Return whether a cell is blank or already contains these points."""
    number = read_number(before)
    return not before.strip() or (number is not None and abs(number - points) < POINTS_TOLERANCE)


def _with_cell(row: tuple[str, ...], column: Column, cell: str) -> tuple[str, ...]:
    return (*row[: column.index], cell, *row[column.index + 1 :])
