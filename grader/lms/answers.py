"""Which written answers were there when a submission was entered: a mark is for what was read."""

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
    """Digest of each written answer in an autograded copy, by ``grade_id``."""
    return {
        cell.metadata.nbgrader.grade_id: hashlib.sha256(cell.source.encode()).hexdigest()
        for cell in notebook.cells
        if "nbgrader" in cell.metadata and is_grade(cell) and is_solution(cell)
    }


def read_known(course: Course, student: str, stage: str) -> dict[str, dict[str, str]]:
    """Fingerprints at the last entering, by lesson; empty where none is known."""
    try:
        known = json.loads(_path(course, student, stage).read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return known if isinstance(known, dict) else {}


def write_known(course: Course, student: str, stage: str, known: dict[str, dict[str, str]]) -> None:
    """Keep fingerprints; only after the gradebook was written, so that in doubt somebody looks."""
    write_atomically(json.dumps(known), _path(course, student, stage))


def regrade(grade: Grade, auto_score: float | None, unchanged: bool) -> None:
    """Give a row of the gradebook a new automatic score, and keep what a person gave.

    Parameters
    ----------
    grade : nbgrader.api.Grade
    auto_score : float or None
        None where a person has to grade.
    unchanged : bool
        Whether a written answer is the one that was there before.
    """
    if auto_score is None:
        settled = unchanged and grade.manual_score is not None
    else:
        # Points of the machine that a person has overruled.
        settled = grade.manual_score is None or grade.auto_score == auto_score
        if grade.manual_score is None:
            grade.needs_manual_grade = False
    if not settled:
        grade.needs_manual_grade = True
    grade.auto_score = auto_score


def _path(course: Course, student: str, stage: str) -> Path:
    return course.verdicts / student / stage / ".answers"
