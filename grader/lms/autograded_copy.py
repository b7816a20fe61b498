"""Build the autograded copy of a submission, which nbgrader stores and Formgrader shows.

The copy is built from scratch; the submitted file is not repaired. The copy contains the graded
cells as they were released, with the student's work filled in. The student's own cells are placed
around them, and only their type and text are kept.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import re
from html import escape

import nbformat
from nbconvert.exporters import HTMLExporter
from nbformat import NotebookNode
from nbgrader.utils import is_grade, is_solution

from grader.course.lessons import Lesson
from grader.course.paths import Course
from grader.course.standalone import TITLE, is_setup_cell
from grader.intake.pictures import illustrate
from grader.intake.preflight import (
    PreparedNotebook,
    WrittenAnswer,
    prepare_substitute,
    prepare_to_show,
)
from grader.intake.reader_process import TooCostly, run_in_child
from grader.intake.submission import SubmittedFiles
from grader.judging.verdict import ExerciseResult, Verdict
from grader.lms.check_summary import summarise_checks
from grader.lms.sanitizer import ZERO_WIDTH_SPACE, as_code, sanitize_markdown
from grader.untrusted_text import one_line
from utils.notebooks.reading import Cell

_PICTURE = re.compile(r"(?<!\u200b)attachment:([^\s)>\"']*)")
MIN_LONG_COPY = 40_000
"""Shorter copies, in characters, are rendered within a few seconds whatever they contain."""
MISSING_ANSWER_NOTE = (
    "*This cell was missing. Text elsewhere in the notebook may be the answer. Please look for it.*"
)


def build_judged_copy(
    submitted_files: SubmittedFiles, lesson: Lesson, verdict: Verdict
) -> tuple[NotebookNode, str]:
    """Build the autograded copy of a judged submission, with its scores and messages.

    Returns
    -------
    (nbformat.NotebookNode, str)
        The copy, and the reason why it does not contain the student's work. The reason is empty if
        the copy contains the work, or if the verdict already states the reason.
    """
    copy, complaint = build_copy_in_process(submitted_files, lesson)
    if complaint in verdict.problems:
        complaint = ""
    problems = (*verdict.problems, complaint) if complaint else verdict.problems
    write_verdict(copy, dataclasses.replace(verdict, problems=problems))
    return copy, complaint


def build_copy_in_process(
    submitted_files: SubmittedFiles, lesson: Lesson
) -> tuple[NotebookNode, str]:
    """Build the autograded copy of a submission in a separate process.

    Returns
    -------
    (nbformat.NotebookNode, str)
        The copy, and a message that explains why it does not contain the student's work. The
        message is empty unless the submission takes too much time or memory to show.

    Raises
    ------
    grader.intake.reader_process.ReadingFailed
        If the process fails for a reason that is not the student's fault.
    """

    def work() -> NotebookNode:
        copy = build_copy(prepare_to_show(submitted_files, lesson))
        _render_if_long(copy, lesson)
        return copy

    _released_notebook(lesson)  # fill the cache in this process for the next copies
    try:
        copy = run_in_child(submitted_files.name, work)
    except TooCostly as error:
        return build_copy(prepare_substitute(submitted_files, lesson, error)), str(error)
    return nbformat.from_dict(copy), ""


def _render_if_long(copy: NotebookNode, lesson: Lesson) -> None:
    """Render a long copy once, because feedback pages and Formgrader will render it later.

    A copy that takes too long to render fails here, within the limits of the separate process.
    """
    released = {cell.source for cell in _released_notebook(lesson).cells}
    if sum(len(cell.source) for cell in copy.cells if cell.source not in released) > MIN_LONG_COPY:
        HTMLExporter(template_name="classic").from_notebook_node(copy)


def build_copy(prepared: PreparedNotebook) -> NotebookNode:
    """Build the autograded copy of a prepared notebook, without scores.

    Returns
    -------
    nbformat.NotebookNode
        A valid notebook for any submission. It contains each graded cell of the release exactly
        once.
    """
    released = _released_notebook(prepared.lesson)
    copy = nbformat.from_dict({**released, "cells": []})
    by_id = {cell.metadata.nbgrader.grade_id: cell for cell in graded_cells(released)}
    grade_ids = {index: name for name, index in prepared.graded.items()}
    by_source = {cell.source: cell for cell in released.cells}
    positions = {}
    for index, cell in enumerate(prepared.cells):
        name = grade_ids.get(index)
        should_show = name is None and cell.source.strip() != ""
        if (
            name is None
            and cell.grade_id in prepared.lesson.steps
            and cell.grade_id not in positions
        ):
            name, should_show = cell.grade_id, False
        if name is None and cell.grade_id in by_id and not is_solution(by_id[cell.grade_id]):
            # A locked cell is shown as released. If the student changed the cell, the changed text
            # was judged, so it is kept next to the released text.
            should_show = cell.source.split() != by_id[cell.grade_id].source.split()
            name = cell.grade_id if cell.grade_id not in positions else None
        if name is not None:
            positions[name] = len(copy.cells)
            copy.cells.append(_fill_cell(by_id[name], cell, prepared.answers.get(name)))
        if should_show:
            copy.cells.append(_student_cell(cell, by_source.get(cell.source), prepared.lesson))
    _add_missing_cells(copy, by_id, positions, prepared)
    for number, cell in enumerate(copy.cells):
        cell.id = cell.id if "nbgrader" in cell.metadata else f"handed-in-{number}"
    return copy


def graded_cells(notebook: NotebookNode) -> list[NotebookNode]:
    """Return the cells that carry nbgrader metadata."""
    return [cell for cell in notebook.cells if "nbgrader" in cell.metadata]


def write_verdict(notebook: NotebookNode, verdict: Verdict) -> None:
    """Write a verdict below the graded cells of a copy and remove all other outputs."""
    results = {exercise.name: exercise for exercise in verdict.exercises}
    for cell in notebook.cells:
        if cell.cell_type != "code":
            continue
        cell.outputs, cell.execution_count = [], None
        if is_grade(cell) and not is_solution(cell):
            cell.execution_count = 1
            cell.outputs = [
                score_output(results[cell.metadata.nbgrader["grade_id"].removeprefix("test_")])
            ]
    if verdict.problems:
        # Markdown is not rendered inside an HTML block. A blank line would end the block, so each
        # problem is one line.
        sentences = (escape(sanitize_markdown(one_line(text))) for text in verdict.problems)
        listed = "".join(f"<li>{sentence}</li>" for sentence in sentences)
        note = _build_cell(f"<div><b>About this notebook</b><ul>{listed}</ul></div>")
        notebook.cells.insert(0, note)
    notebook.metadata["verdict_key"] = verdict.key


def verdict_key_of_copy(course: Course, student: str, stage: str, lesson_name: str) -> str | None:
    """Return the key of the verdict shown by an autograded copy; None if it has none."""
    path = course.autograded / student / stage / f"{lesson_name}.ipynb"
    try:
        return json.loads(path.read_text("utf-8"))["metadata"]["verdict_key"]
    except (OSError, ValueError, KeyError, TypeError):
        return None


def score_output(exercise: ExerciseResult) -> NotebookNode:
    """Build a cell output with the score for nbgrader and an explanation for readers."""
    summary = summarise_checks(exercise)
    failures = [test for test in (summary.first, *summary.others) if test]
    rows = [_table_row("✗ failed", test.title, test.message) for test in failures]
    rows += [
        _table_row("✗ failed", group.text, "; ".join(group.titles)) for group in summary.groups
    ]
    if exercise.slip:
        credit = f"+{exercise.slip.score:g}" if exercise.slip.score else ""
        rows.append(_table_row(credit, exercise.slip.sentence, ""))
    rows += [_table_row("✓ passed", test.title, test.message) for test in summary.passed]
    return nbformat.v4.new_output(
        "execute_result",
        execution_count=1,
        data={
            "text/plain": json.dumps(exercise.score),
            "text/html": f"<p><b>{escape(exercise.name)}: {exercise.score:g} of "
            f"{exercise.max_score:g} points</b>; {summary.description}</p>"
            f"<table>{''.join(rows)}</table>",
        },
    )


def _table_row(mark: str, title: str, message: str) -> str:
    """Format one row of the table below an exercise."""
    lines = "".join(f"<br>{escape(line)}" for line in message.splitlines())
    return (
        f"<tr><td style='text-align:left;vertical-align:top;white-space:nowrap;"
        f"padding-right:1em'>{mark} </td>"
        f"<td style='text-align:left'><b>{escape(title)}</b>{lines} </td></tr>"
    )


@functools.cache
def _released_notebook(lesson: Lesson) -> NotebookNode:
    return nbformat.reads(lesson.released.read_text("utf-8"), as_version=4)


def _student_cell(cell: Cell, released: NotebookNode | None, lesson: Lesson) -> NotebookNode:
    """Build the copy of a student's ungraded cell; an unchanged cell is shown as released."""
    if is_setup_cell(cell.source, lesson.name):
        return _build_cell(f"{TITLE}\n# (The packed tools of the course.)", kind="code")
    if released is not None and released.cell_type == "markdown" and cell.kind == "markdown":
        new_cell = _build_cell(released.source)
        if "attachments" in released:
            new_cell.attachments = released.attachments
        return new_cell
    if cell.kind == "code":
        return _build_cell(cell.source, kind="code")
    if cell.kind == "raw":  # some programs treat raw text as HTML
        return _build_cell(sanitize_markdown(as_code(cell.source)))
    shown = illustrate([cell])
    return _attach_pictures(_build_cell(sanitize_markdown(shown.text)), shown.attachments)


def _build_cell(source: str, kind: str = "markdown") -> NotebookNode:
    """Build a cell without nbformat's constructors, which validate each cell against the schema."""
    code_fields = {"outputs": [], "execution_count": None} if kind == "code" else {}
    cell = {"cell_type": kind, "id": "about", "metadata": {}, "source": source, **code_fields}
    return nbformat.from_dict(cell)


def _attach_pictures(cell: NotebookNode, pictures: dict) -> NotebookNode:
    """Attach valid pictures and disable other references, which nbconvert cannot handle."""
    if pictures:
        cell.attachments = pictures
    cell.source = _PICTURE.sub(
        lambda match: match[0] if match[1] in pictures else f"{ZERO_WIDTH_SPACE}{match[0]}",
        cell.source,
    )
    return cell


def _fill_cell(
    released: NotebookNode, cell: Cell | None, answer: WrittenAnswer | None
) -> NotebookNode:
    """Build a released cell with the student's work in it; locked cells stay as released."""
    filled = nbformat.from_dict(released)
    if answer is not None:
        if answer.text:
            filled.source = sanitize_markdown(answer.text)
        elif not answer.is_certain:
            filled.source = f"{released.source}\n\n{MISSING_ANSWER_NOTE}"
        filled = _attach_pictures(filled, answer.attachments)
    elif is_solution(filled) and cell is not None:
        filled.source = cell.source
    return filled


def _add_missing_cells(
    copy: NotebookNode, by_id: dict, positions: dict, prepared: PreparedNotebook
) -> None:
    """Insert each missing graded cell after the graded cell that preceded it in the release."""
    previous_index = -1
    for name, cell in by_id.items():
        if name not in positions:
            filled = _fill_cell(cell, None, prepared.answers.get(name))
            if name in prepared.graded:  # the answer is in a cell with another exercise
                filled.source = f"# {name} is in the cell of another exercise."
            copy.cells.insert(previous_index + 1, filled)
            positions.update(
                {later: place + 1 for later, place in positions.items() if place > previous_index}
            )
            positions[name] = previous_index + 1
        previous_index = positions[name]
