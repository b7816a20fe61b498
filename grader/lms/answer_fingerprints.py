"""Store fingerprints of written answers, because a mark given by hand applies to one version."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from nbformat import NotebookNode
from nbgrader.api import Grade
from nbgrader.utils import is_grade, is_solution

from grader.course.atomic_files import write_atomically
from grader.course.paths import Course


def fingerprints(notebook: NotebookNode) -> dict[str, str]:
    """Return the digest of each written answer in an autograded copy, by ``grade_id``."""
    return {
        cell.metadata.nbgrader.grade_id: hashlib.sha256(_content(cell).encode()).hexdigest()
        for cell in notebook.cells
        if "nbgrader" in cell.metadata and is_grade(cell) and is_solution(cell)
    }


def _content(cell: NotebookNode) -> str:
    pictures = cell.get("attachments")
    return cell.source + json.dumps(pictures, sort_keys=True) if pictures else cell.source


def read_fingerprints(course: Course, student: str, stage: str) -> dict[str, dict[str, str]]:
    """Return the fingerprints that were last stored, by lesson; empty if there are none."""
    try:
        known = json.loads(_path(course, student, stage).read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return known if isinstance(known, dict) else {}


def write_fingerprints(
    course: Course, student: str, stage: str, fingerprints_by_lesson: dict[str, dict[str, str]]
) -> None:
    """Store the fingerprints of written answers.

    Call this only after the gradebook is written. If a run is interrupted in between, the answers
    count as changed, and a person must grade them again.
    """
    write_atomically(json.dumps(fingerprints_by_lesson), _path(course, student, stage))


def regrade(grade: Grade, auto_score: float | None, is_unchanged: bool) -> None:
    """Set the automatic score of a grade, and keep the points that a person gave.

    Parameters
    ----------
    grade : nbgrader.api.Grade
    auto_score : float or None
        None if a person has to grade the cell.
    is_unchanged : bool
        Whether the written answer has not changed since it was last entered.
    """
    if auto_score is None:
        settled = is_unchanged and grade.manual_score is not None
    else:
        # Points given by hand count only while the automatic score that they replace is unchanged.
        settled = grade.manual_score is None or grade.auto_score == auto_score
        if grade.manual_score is None:
            grade.needs_manual_grade = False
    if not settled:
        grade.needs_manual_grade = True
    grade.auto_score = auto_score


def _path(course: Course, student: str, stage: str) -> Path:
    return course.verdicts / student / stage / ".answers"
