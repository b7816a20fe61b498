"""What every format is given, and what it gives back."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from grader.course.paths import Course
from grader.lms.results import ClassResults


class ExportTrouble(Exception):
    """Nothing can be exported so; `str()` is the sentence to show, with what to do."""


@dataclass(frozen=True)
class Order:
    """What is to be exported.

    Attributes
    ----------
    course : grader.course.paths.Course
    results : grader.lms.results.ClassResults
    assignment : str or None
        One assignment of a learning platform: a stage or a lesson.
    provisional : bool
        Whether work that waits for a person is exported with the points that it has so far.
    into : pathlib.Path or None
        The file of the platform's own that is to be filled in.
    column : str or None
        Title of its column for the marks, where it cannot be guessed.
    scale : bool
        Whether points are converted where the platform gives others.
    """

    course: Course
    results: ClassResults
    assignment: str | None = None
    provisional: bool = False
    into: Path | None = None
    column: str | None = None
    scale: bool = False


@dataclass(frozen=True)
class Exported:
    """A file, and what there is to say about it.

    Attributes
    ----------
    content : bytes
    placed : int
        Marks that are in it.
    lost : tuple of str
        A sentence on each mark that exists and is not in it.
    notes : tuple of str
        What else to know, a sentence each.
    """

    content: bytes
    placed: int
    lost: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
