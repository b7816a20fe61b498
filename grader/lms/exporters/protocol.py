"""The input and output of every export format."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from grader.errors import UserError

if TYPE_CHECKING:
    from pathlib import Path

    from grader.course.paths import Course
    from grader.course.roster import Person
    from grader.lms.results import ClassResults


class ExportError(UserError):
    """The export is not possible; `str()` says why and what to do."""


@dataclass(frozen=True)
class ExportOptions:
    """The options for an export.

    Attributes
    ----------
    course : grader.course.paths.Course
    results : grader.lms.results.ClassResults
    assignment : str or None
        The stage or lesson that corresponds to the assignment in the LMS.
    provisional : bool
        Whether to export the current points of work that a person still has to grade.
    into : pathlib.Path or None
        The file from the LMS to fill in.
    column : str or None
        Title of the column for the marks; None to find the column automatically.
    scale : bool
        Whether to convert points if the LMS has a different maximum.
    other_people : tuple of grader.course.roster.Person
        Students who are not in `results`, because only one section is exported. Their rows in the
        file are recognised, but not changed.
    """

    course: Course
    results: ClassResults
    assignment: str | None = None
    provisional: bool = False
    into: Path | None = None
    column: str | None = None
    scale: bool = False
    other_people: tuple[Person, ...] = ()


@dataclass(frozen=True)
class ExportResult:
    """An exported file, and messages about it.

    Attributes
    ----------
    content : bytes
    mark_count : int
        Number of marks in the file.
    failures : tuple of str
        One sentence for each existing mark that is not in the file.
    notes : tuple of str
        Other messages, one sentence each.
    """

    content: bytes
    mark_count: int
    failures: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
