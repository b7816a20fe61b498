"""Read submission times from Moodle's grading worksheet or from the instructor's own table.

Moodle writes titles and dates in the language of the teacher who downloads the worksheet. The first
column has a word and the participant's number, and the second column has the full name. An
instructor's own table has IDs in the first column, and submission times under one of `TIME_TITLES`.
"""

from __future__ import annotations

import functools
import re
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, tzinfo
from pathlib import Path

from grader.classroom.collect.models import CollectError
from grader.course.tables import TableError, read_table
from grader.course.times import UnclearTime, read_time, to_utc

# Moodle's translations of "Last modified (submission)", each with the language of the dates.
TIME_TITLES = {
    "last modified (submission)": "en",
    "zuletzt geändert (abgabe)": "de",
    "dernière modification (travail remis)": "fr",
    "última modificación (entrega)": "es",
    "ultima modifica (consegna)": "it",
    "última modificação (envio)": "pt",
    "laatst gewijzigd (inzending)": "nl",
    "ostatnia modyfikacja (zadanie)": "pl",
    "последнее изменение (ответ)": "ru",
    "上次修改（作业）": "zh",
}
STATUS_TITLES = ("status", "statut", "estado", "stato", "статус", "состояние", "状态")
_NUMBER = re.compile(r"\D*[^\W\d]\D*(\d+)")  # a word and a number
_NO_TIME = ("", "-")  # Moodle writes - for students who did not submit


@dataclass(frozen=True)
class SubmissionRow:
    """The row of one person in the table.

    Attributes
    ----------
    identifiers : tuple of str
        Texts that identify the person, the most reliable first: e-mail, numbers, names.
    other_cells : tuple of str
        All other texts in the row, such as the name of a team.
    participant : str
        Moodle's participant number; empty in an instructor's own table.
    when : datetime or None
        Submission time in UTC; None if there is none, or if it cannot be read.
    time_text : str
        The submission time as written in the table; empty if there is none.
    time_problem : str
        Why the time cannot be read, as the rest of a sentence about the table; otherwise empty.
    """

    identifiers: tuple[str, ...]
    other_cells: tuple[str, ...] = ()
    participant: str = ""
    when: datetime | None = None
    time_text: str = ""
    time_problem: str = ""


@dataclass(frozen=True)
class SubmissionTable:
    """A table of submission times.

    In Moodle's worksheet each person has one row and a number. It also contains texts that students
    wrote. Moodle does not double a quotation mark after a backslash, so such a text can end its
    cell and forge rows about other students. A number that occurs twice is therefore ignored.
    """

    rows: tuple[SubmissionRow, ...] = ()

    @functools.cached_property
    def is_from_moodle(self) -> bool:
        """Whether the rows have Moodle's participant numbers."""
        return any(row.participant for row in self.rows)

    def row_of_participant(self, number: str) -> SubmissionRow | None:
        """Return the only row with a participant number, or None."""
        return self._by_number.get(number) if number else None

    def rows_with(self, text: str) -> list[SubmissionRow]:
        """Return the rows in which a text identifies the person."""
        return [row for row in self.rows if text in row.identifiers]

    @functools.cached_property
    def _by_number(self) -> dict[str, SubmissionRow]:
        times = Counter(row.participant for row in self.rows)
        return {row.participant: row for row in self.rows if times[row.participant] == 1}


def read_submission_table(path: Path, zone: tzinfo | None) -> SubmissionTable:
    """Read a table of submission times.

    Parameters
    ----------
    path : pathlib.Path
    zone : tzinfo or None
        Time zone of the times; None for this machine's zone.

    Raises
    ------
    CollectError
    """
    try:
        table = read_table(path.read_bytes())
    except OSError as error:
        raise CollectError(f"{path} cannot be read: {error.strerror}.") from None
    except TableError as error:
        raise CollectError(
            f"Line {error.line} of {path} is not valid CSV: {error}. Download it again."
            if error.line
            else f"{path} is not in UTF-8. Save it as CSV UTF-8."
        ) from None
    titles = [_fold_case(cell) for cell in table.titles]
    column = next((index for index, title in enumerate(titles) if title in TIME_TITLES), None)
    if column is None:
        raise CollectError(
            f"{path}: no column has a known title for submission times. The columns are: "
            f'{", ".join(table.titles) or "none"}. Rename the right one to "Last '
            'modified (submission)", and write times like 2026-10-12 23:59.'
        )
    language = TIME_TITLES[titles[column]]
    status = next((index for index, title in enumerate(titles) if title in STATUS_TITLES), 1)
    return SubmissionTable(
        tuple(_parse_row(cells, column, status, language, zone) for cells in table.rows[1:])
    )


def _parse_row(
    cells: Sequence[str], column: int, status: int, language: str, zone: tzinfo | None
) -> SubmissionRow:
    """Read one row; the columns after the status contain marks, which may look like IDs."""
    cells = [unicodedata.normalize("NFC", cell.strip()) for cell in cells]
    when, time_problem = None, ""
    time_text = cells[column] if column < len(cells) else ""
    if time_text in _NO_TIME:
        time_text = ""
    else:
        try:
            when = to_utc(read_time(time_text, language), zone)
        except UnclearTime as reason:
            time_problem = str(reason)
    number = _NUMBER.fullmatch(cells[0])
    identifying = [
        cell for index, cell in enumerate(cells) if cell and (index < status or "@" in cell)
    ]
    identifying.sort(key=lambda cell: ("@" not in cell, not _has_digit(cell)))
    return SubmissionRow(
        tuple(identifying),
        tuple(cells[status:]),
        number[1] if number else "",
        when,
        time_text,
        time_problem,
    )


def _fold_case(text: str) -> str:
    return " ".join(unicodedata.normalize("NFC", text).casefold().split())


def _has_digit(text: str) -> bool:
    return any(character.isdigit() for character in text)
