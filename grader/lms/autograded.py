"""The autograded copy of a submission: what nbgrader keeps, and people open in Formgrader.

It is built, not mended: the graded cells as they were released, the student's work in them, and
around them the student's own cells, of which only kind and text are taken.
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
from grader.intake.preflight import Prepared, WrittenAnswer, prepare_to_show, prepare_without
from grader.intake.reader_process import TooCostly, apart
from grader.intake.submission import HandedIn
from grader.judging.verdict import ExerciseResult, Verdict
from grader.lms.check_summary import fold
from grader.lms.sanitizer import NO_WIDTH, as_code, harmless, harmless_pictures
from utils.notebooks.reading import Cell

_PICTURE = re.compile(r"(?<!\u200b)attachment:([^\s)>\"']*)")
MUCH_TEXT = 40_000
"""Characters, of which every page is made in a few seconds."""
LOOK_FOR_IT = (
    "*This cell was missing. There is text elsewhere in the notebook that may be the answer: "
    "please look for it.*"
)


def judged_copy(handed_in: HandedIn, lesson: Lesson, verdict: Verdict) -> tuple[NotebookNode, str]:
    """The autograded copy of what was judged, with its scores and messages.

    Returns
    -------
    (nbformat.NotebookNode, str)
        The copy; and why nothing of the student's is in it, where the verdict does not say it.
    """
    copy, complaint = copy_apart(handed_in, lesson)
    if complaint in verdict.problems:
        complaint = ""
    problems = (*verdict.problems, complaint) if complaint else verdict.problems
    write_into(copy, dataclasses.replace(verdict, problems=problems))
    return copy, complaint


def copy_apart(handed_in: HandedIn, lesson: Lesson) -> tuple[NotebookNode, str]:
    """Build the copy of what was handed in, in a process of its own.

    Returns
    -------
    (nbformat.NotebookNode, str)
        The copy; and why nothing of the student's is in it, where that is too much to show.

    Raises
    ------
    grader.intake.reader_process.ReadingFailed
    """

    def work() -> NotebookNode:
        copy = build_copy(prepare_to_show(handed_in, lesson))
        _try_to_show(copy, lesson)
        return copy

    _released(lesson)  # read here, and remembered for the next
    try:
        copy = apart(handed_in.name, work)
    except TooCostly as error:
        return build_copy(prepare_without(handed_in, lesson, error)), str(error)
    return nbformat.from_dict(copy), ""


def _try_to_show(copy: NotebookNode, lesson: Lesson) -> None:
    """Make a page of much text, as feedback and Formgrader will, which look at some of it twice."""
    released = {cell.source for cell in _released(lesson).cells}
    if sum(len(cell.source) for cell in copy.cells if cell.source not in released) > MUCH_TEXT:
        HTMLExporter(template_name="classic").from_notebook_node(copy)


def build_copy(prepared: Prepared) -> NotebookNode:
    """Build the autograded copy, without scores.

    Returns
    -------
    nbformat.NotebookNode
        Valid, whatever was handed in, and with each graded cell of the release once.
    """
    released = _released(prepared.lesson)
    copy = nbformat.from_dict({**released, "cells": []})
    given = {cell.metadata.nbgrader.grade_id: cell for cell in graded_cells(released)}
    names = {place: name for name, place in prepared.graded.items()}
    ours = {cell.source: cell for cell in released.cells}
    where = {}
    for place, cell in enumerate(prepared.cells):
        name = names.get(place)
        shown = name is None and cell.source.strip() != ""
        if name is None and cell.grade_id in prepared.lesson.steps and cell.grade_id not in where:
            name, shown = cell.grade_id, False
        if name is None and cell.grade_id in given and not is_solution(given[cell.grade_id]):
            # Ours, and shown as released; what a student changed in it was judged, and stays.
            shown = cell.source.split() != given[cell.grade_id].source.split()
            name = cell.grade_id if cell.grade_id not in where else None
        if name is not None:
            where[name] = len(copy.cells)
            copy.cells.append(_filled(given[name], cell, prepared.answers.get(name)))
        if shown:
            copy.cells.append(_shown(cell, ours.get(cell.source), prepared.lesson))
    _add_missing(copy, given, where, prepared)
    for number, cell in enumerate(copy.cells):
        cell.id = cell.id if "nbgrader" in cell.metadata else f"handed-in-{number}"
    return copy


def graded_cells(notebook: NotebookNode) -> list[NotebookNode]:
    """The cells that nbgrader knows."""
    return [cell for cell in notebook.cells if "nbgrader" in cell.metadata]


def write_into(notebook: NotebookNode, verdict: Verdict) -> None:
    """Write a verdict under the graded cells of a copy, in place of all outputs."""
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
        # A block of HTML, in which nobody's Markdown is at work.
        listed = "".join(f"<li>{escape(sentence)}</li>" for sentence in verdict.problems)
        about = _cell(f"<div><b>About this notebook</b><ul>{listed}</ul></div>")
        notebook.cells.insert(0, about)
    notebook.metadata["verdict_key"] = verdict.key


def key_of_copy(course: Course, student: str, stage: str, lesson_name: str) -> str | None:
    """Key of the verdict that a copy in ``autograded/`` shows; None where there is none."""
    path = course.autograded / student / stage / f"{lesson_name}.ipynb"
    try:
        return json.loads(path.read_text("utf-8"))["metadata"]["verdict_key"]
    except (OSError, ValueError, KeyError, TypeError):
        return None


def score_output(exercise: ExerciseResult) -> NotebookNode:
    """An output from which nbgrader reads the score and people read the reasons."""
    folded = fold(exercise)
    told = [test for test in (folded.first, *folded.others) if test]
    rows = [_row("✗ failed", test.title, test.message) for test in told]
    rows += [_row("✗ failed", one.says, "; ".join(one.titles)) for one in folded.folds]
    if exercise.slip:
        kept = f"+{exercise.slip.score:g}" if exercise.slip.score else ""
        rows.append(_row(kept, exercise.slip.sentence, ""))
    rows += [_row("✓ passed", test.title, test.message) for test in folded.passed]
    return nbformat.v4.new_output(
        "execute_result",
        execution_count=1,
        data={
            "text/plain": json.dumps(exercise.score),
            "text/html": f"<p><b>{escape(exercise.name)}: {exercise.score:g} of "
            f"{exercise.max_score:g} points</b>; {folded.in_words}</p>"
            f"<table>{''.join(rows)}</table>",
        },
    )


def _row(mark: str, title: str, message: str) -> str:
    """A line of the table under an exercise. Points are those of the whole."""
    lines = "".join(f"<br>{escape(line)}" for line in message.splitlines())
    return (
        f"<tr><td style='text-align:left;vertical-align:top;white-space:nowrap;"
        f"padding-right:1em'>{mark} </td>"
        f"<td style='text-align:left'><b>{escape(title)}</b>{lines} </td></tr>"
    )


@functools.cache
def _released(lesson: Lesson) -> NotebookNode:
    return nbformat.reads(lesson.released.read_text("utf-8"), as_version=4)


def _shown(cell: Cell, ours: NotebookNode | None, lesson: Lesson) -> NotebookNode:
    """A cell around the graded ones; as it was released where it says the same."""
    if is_setup_cell(cell.source, lesson.name):
        return _cell(f"{TITLE}\n# (The tools of the course, packed.)", kind="code")
    if ours is not None and ours.cell_type == "markdown" and cell.kind == "markdown":
        made = _cell(ours.source)
        if "attachments" in ours:
            made.attachments = ours.attachments
        return made
    if cell.kind == "code":
        return _cell(cell.source, kind="code")
    if cell.kind == "raw":  # some programs take raw text for HTML
        return _cell(harmless(as_code(cell.source)))
    return _with_pictures(_cell(harmless(cell.source)), cell.attachments)


def _cell(source: str, kind: str = "markdown") -> NotebookNode:
    """A new cell. nbformat's own functions look through the format's schema for each."""
    run = {"outputs": [], "execution_count": None} if kind == "code" else {}
    cell = {"cell_type": kind, "id": "about", "metadata": {}, "source": source, **run}
    return nbformat.from_dict(cell)


def _with_pictures(made: NotebookNode, attachments: dict) -> NotebookNode:
    """Attach pictures. nbconvert gives up where one is named that is not there."""
    pictures = harmless_pictures(attachments)
    if pictures:
        made.attachments = pictures
    made.source = _PICTURE.sub(
        lambda found: found[0] if found[1] in pictures else f"{NO_WIDTH}{found[0]}",
        made.source,
    )
    return made


def _filled(given: NotebookNode, cell: Cell | None, answer: WrittenAnswer | None) -> NotebookNode:
    """A released cell with the student's work in it; as it was released where it is locked."""
    made = nbformat.from_dict(given)
    if answer is not None:
        if answer.text:
            made.source = harmless(answer.text)
        elif not answer.certain:
            made.source = f"{given.source}\n\n{LOOK_FOR_IT}"
        made = _with_pictures(made, answer.attachments)
    elif is_solution(made) and cell is not None:
        made.source = cell.source
    return made


def _add_missing(copy: NotebookNode, given: dict, where: dict, prepared: Prepared) -> None:
    """Put the graded cells that are not there behind the one that they were released behind."""
    before = -1
    for name, cell in given.items():
        if name not in where:
            made = _filled(cell, None, prepared.answers.get(name))
            if name in prepared.graded:  # it shares a cell with another one
                made.source = f"# {name} stands in the cell of another exercise."
            copy.cells.insert(before + 1, made)
            where.update({other: at + 1 for other, at in where.items() if at > before})
            where[name] = before + 1
        before = where[name]
