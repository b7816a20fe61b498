"""Write the sheets for students, and the examiner's page with the right choices."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from grader.classroom.pages import format_code, render
from grader.course.atomic_files import write_atomically
from grader.course.paths import Course
from grader.questions.helpers import sentence_about
from grader.questions.question import Question
from grader.questions.viva import Sheet, viva_folder
from utils.questions.texts import NOTATION

LETTERS = "ABCD"
SHEETS, KEY = "sheets.html", "key.html"
MINUTES_PER_STUDENT = 2


def write_pages(
    course: Course, stage: str, sheets: Sequence[Sheet], student: str = ""
) -> tuple[Path, Path]:
    """Write the sheets and the key of a stage, and return their paths.

    The pages of a single student are in a folder of their own.
    """
    folder = viva_folder(course, stage) / student
    shown = [sheet for sheet in sheets if sheet.questions]
    paths = folder / SHEETS, folder / KEY
    write_atomically(_render("viva_sheets.html", stage, shown), paths[0])
    write_atomically(_render("viva_key.html", stage, sheets), paths[1])
    return paths


def _render(template: str, stage: str, sheets: Sequence[Sheet]) -> str:
    return render(
        template,
        stage=stage,
        sheets=sheets,
        letters=LETTERS,
        minutes=MINUTES_PER_STUDENT,
        format_code=format_code,
        format_lines=format_lines,
        subject=key_basis,
        sentence_about=sentence_about,
        notation=NOTATION,
    )


def format_lines(lines: Sequence[int]) -> str:
    """Format line numbers in words, such as "line 4" or "lines 4 and 7"."""
    *first, last = map(str, lines)
    return f"lines {', '.join(first)} and {last}" if first else f"line {last}"


def key_basis(question: Question) -> str:
    """Tell the examiner whether a question's key depends on this student's code."""
    if question.is_about_code:
        return f"{question.kind}; the answer follows from this student's code."
    return (
        f"{question.kind}; every correct solution has this result, so ask how the code gets there."
    )
