"""Texts that are made to be looked at for ever, outside the walls, where a stranger's text is read.

Twice the text may take twice the time, not four times: else a text cell of 200 KB holds the class.
"""

import contextlib
import dataclasses
import json
import time
from types import SimpleNamespace

import pytest

from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.intake import preflight
from grader.intake.submission import SubmittedFiles
from grader.judging.verdict import JUDGED, CheckResult, ExerciseResult, Verdict
from grader.lms.autograded import build_copy, write_verdict
from grader.lms.report import write_report
from grader.lms.sanitizer import as_code, sanitize_markdown
from utils.notebooks.reading import UnreadableNotebook, decode_notebook

LESSON = find_lesson("12_streaming_obstacles")
MOST = 2.5  # times the processor's time for twice the text
TRIES = 3
SHORTEST = 0.04  # seconds, below which nothing is measured
LARGEST = 400_000  # characters, that take no longer than that: fast enough

ALPHABETS = {
    "brackets": "](",
    "brackets that never close": "[",
    "references": "[a]: ",
    "spaces in brackets": "](  ",
    "blank lines": "\n",
    "lines of blanks": " \t\n",
    "fences": "`",
    "fences with blanks": "``` ",
    "waves": "~",
    "quotes": "> ```\n",
    "tags": "<a",
    "entities": "&#106;",
    "backslashes": "\\",
    "commands": "\\href",
    "dollars": "$",
    "formulas": r"$\href$ ",
    "formulas that never end": r"$$a",
    "brackets of formulas": r"\[",
    "more brackets of formulas": r"\\( \) ",
    "environments": r"\begin{",
    "environments that end": r"\end{align}",
    "colours": r"$\color{ ",
    "noughts": "&#000",
    "attachments": "attachment:",
    "pictures": "![a](attachment:b.png) ",
    "imports": "import \n",
    "imports in one line": "import helper ",
    "definitions": "def match_boxes(",
    "definitions that are none": "def\tmatch_boxes ",
    "values": "match_boxes \t= ",
    "no width": "\u200b",
    "emoji": "\U0001f697",
    "the name of a lesson": '"lidar_obstacle_lab" : { ',
    "quotation marks": '"',
    "letters": "mermaid",
}


def notebook_with(cells):
    """A released notebook with more cells in it, as (kind, source)."""
    notebook = json.loads(fill_in(LESSON, {}))
    for kind, source in cells:
        cell = {"cell_type": kind, "metadata": {}, "source": source}
        notebook["cells"].append(cell | ({"outputs": []} if kind == "code" else {}))
    return json.dumps(notebook).encode()


def handed_in(cells):
    return SubmittedFiles(f"{LESSON.name}.ipynb", notebook_with(cells), modules={"helper": "x = 1"})


def draft_of(cells):
    """What the steps of preflight work on."""
    given = handed_in(cells)
    notebook = given.notebook()
    return preflight._Draft(LESSON, given, notebook, list(notebook.cells))


def taken(prepare, work, times=3):
    """Processor seconds of some work, the best of some; what it works on is prepared before."""
    found = []
    for _ in range(times):
        material = prepare()
        begin = time.process_time()
        work(material)
        found.append(time.process_time() - begin)
    return min(found)


def assert_linear(material, work, size=12_500):
    """Twice as much takes twice as long; `material` takes a length."""

    def seconds_for(length, times=3):
        return taken(lambda: material(length), work, times)

    seconds = seconds_for(size, 1)
    while seconds < SHORTEST and size < LARGEST:
        size *= 2
        seconds = seconds_for(size, 1)
    if seconds >= SHORTEST:
        # A busy machine spoils one measurement, but not all: a square stays a square.
        found = [(seconds_for(size), seconds_for(2 * size))]
        while found[-1][1] >= MOST * found[-1][0] and len(found) < TRIES:
            found.append((seconds_for(size), seconds_for(2 * size)))
        once, twice = found[-1]
        assert twice < MOST * once, f"{once:.3f} s for {size}, {twice:.3f} s for twice that"


def text(letters, size):
    return letters * (size // len(letters))


@pytest.mark.slow
@pytest.mark.parametrize("letters", ALPHABETS.values(), ids=ALPHABETS)
def test_markdown_is_looked_at_once(letters):
    assert_linear(lambda size: text(letters, size), sanitize_markdown)
    assert_linear(lambda size: text(letters, size), as_code)


@pytest.mark.slow
@pytest.mark.parametrize("letters", ALPHABETS.values(), ids=ALPHABETS)
def test_a_file_is_looked_at_once(letters):
    def read(data):
        with contextlib.suppress(UnreadableNotebook):
            decode_notebook(data, "file.ipynb")

    assert_linear(lambda size: text(letters, size).encode(), read)
    assert_linear(lambda size: b'{"cells": [' + text(letters, size).encode(), read)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["code", "markdown", "raw"])
@pytest.mark.parametrize("letters", ALPHABETS.values(), ids=ALPHABETS)
def test_a_cell_is_looked_at_once(letters, kind):
    """In all steps of preflight and in the copy that is made of it."""

    def show(draft):
        made = preflight.prepare(draft, LESSON)
        copy = build_copy(made)
        write_verdict(copy, VERDICT)

    assert_linear(lambda size: handed_in([(kind, text(letters, size))]), show)


@pytest.mark.slow
@pytest.mark.parametrize("letters", ALPHABETS.values(), ids=ALPHABETS)
def test_a_verdict_is_looked_at_once(letters, tmp_path):
    """In the report on a class, and under the cells of a copy."""

    def verdict(size):
        said = text(letters, size)
        tests = (CheckResult("a check", said, False, 0.0, 1.0, said, True),)
        exercises = tuple(
            ExerciseResult(exercise.name, 0.0, exercise.points, tests, said, "a check")
            for exercise in LESSON.machine_graded
        )
        return dataclasses.replace(VERDICT, exercises=exercises, problems=(said,))

    def show(said):
        write_report(Course(tmp_path), [(SimpleNamespace(student="mallory"), said)])
        write_verdict(build_copy(preflight.prepare(handed_in([]), LESSON)), said)

    assert_linear(verdict, show)


@pytest.mark.slow
@pytest.mark.parametrize("step", preflight.STEPS, ids=lambda step: step.__name__)
@pytest.mark.parametrize("kinds", [("code",), ("markdown",), ("raw",), ("code", "markdown")])
def test_many_cells_are_looked_at_once(step, kinds):
    """Each of which defines an exercise, is marked as graded, or looks like a written answer."""
    sources = ["def match_boxes(a): return 1", "match_boxes = 1\nimport helper", "An answer.", ""]

    def material(size):
        draft = draft_of(
            [(kinds[n % len(kinds)], f"{sources[n % 4]}\n# {n}") for n in range(size // 100)]
        )
        for n, cell in enumerate(draft.cells):
            if n % 3 == 0:
                name = ("match_boxes", "write_up", "detect_obstacles")[n % 9 // 3]
                draft.cells[n] = dataclasses.replace(cell, grade_id=name)
        for earlier in preflight.STEPS[: preflight.STEPS.index(step)]:
            list(earlier(draft))
        return draft

    assert_linear(material, lambda draft: list(step(draft)), size=100_000)


VERDICT = Verdict(
    LESSON.name,
    "mallory",
    JUDGED,
    0.0,
    25.0,
    tuple(
        ExerciseResult(exercise.name, 0.0, exercise.points, ())
        for exercise in LESSON.machine_graded
    ),
    ("](" * 1000,),
    0.0,
    "",
)
