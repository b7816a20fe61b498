"""Texts that try to slow down the grader's parsers, which run outside the sandbox.

Doubling the length of a text may double the time, but not quadruple it. Otherwise, a text cell of
200 KB would delay grading for the whole class.
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
from grader.lms.autograded_copy import build_copy, write_verdict
from grader.lms.report import write_report
from grader.lms.sanitizer import as_code, sanitize_markdown
from utils.notebooks.reading import UnreadableNotebook, decode_notebook

LESSON = find_lesson("12_streaming_obstacles")
LARGEST_RATIO = 2.5  # permitted ratio of processor times when the text doubles in length
TRIES = 3
SHORTEST_TIME = 0.04  # seconds; shorter times cannot be measured reliably
# A text of this many characters is fast enough if it takes less than SHORTEST_TIME.
LARGEST_SIZE = 400_000

ALPHABETS = {
    "brackets": "](",
    "brackets that never close": "[",
    "references": "[a]: ",
    "spaces in brackets": "](  ",
    "blank lines": "\n",
    "lines of white space": " \t\n",
    "fences": "`",
    "fences with spaces": "``` ",
    "tildes": "~",
    "quotes": "> ```\n",
    "tags": "<a",
    "entities": "&#106;",
    "backslashes": "\\",
    "commands": "\\href",
    "dollars": "$",
    "formulas": r"$\href$ ",
    "formulas without an end": r"$$a",
    "formula brackets": r"\[",
    "more formula brackets": r"\\( \) ",
    "environments": r"\begin{",
    "environment ends": r"\end{align}",
    "colours": r"$\color{ ",
    "entities of zeros": "&#000",
    "attachments": "attachment:",
    "pictures": "![a](attachment:b.png) ",
    "pictures without an end": "![a](data:image/png;base64,",
    "pictures in brackets": "![a](b(c) ",
    "nested pictures": "![[a]",
    "pictures as tags": '<img src=\'data:a" src="',
    "references to pictures": "![a][b]\n[b]: data:c\n",
    "imports": "import \n",
    "imports in one line": "import helper ",
    "definitions": "def match_boxes(",
    "incomplete definitions": "def\tmatch_boxes ",
    "assignments": "match_boxes \t= ",
    "zero-width spaces": "\u200b",
    "emoji": "\U0001f697",
    "lesson metadata": '"lidar_obstacle_lab" : { ',
    "quotation marks": '"',
    "letters": "mermaid",
}


def notebook_with(cells):
    """Return the bytes of the released notebook with additional cells, each (kind, source)."""
    notebook = json.loads(fill_in(LESSON, {}))
    for kind, source in cells:
        cell = {"cell_type": kind, "metadata": {}, "source": source}
        notebook["cells"].append(cell | ({"outputs": []} if kind == "code" else {}))
    return json.dumps(notebook).encode()


def submission_of(cells):
    return SubmittedFiles(f"{LESSON.name}.ipynb", notebook_with(cells), modules={"helper": "x = 1"})


def draft_of(cells):
    """Return the draft that the preflight steps work on."""
    submission = submission_of(cells)
    notebook = submission.notebook()
    return preflight._Draft(LESSON, submission, notebook, list(notebook.cells))


def processor_seconds(prepare, work, times=3):
    """Return the minimum processor time of `work` over several runs, excluding `prepare`."""
    found = []
    for _ in range(times):
        material = prepare()
        start = time.process_time()
        work(material)
        found.append(time.process_time() - start)
    return min(found)


def assert_linear(material, work, size=12_500):
    """Assert that the time of `work` grows linearly with its input, `material(length)`."""

    def seconds_for(length, times=3):
        return processor_seconds(lambda: material(length), work, times)

    seconds = seconds_for(size, 1)
    while seconds < SHORTEST_TIME and size < LARGEST_SIZE:
        size *= 2
        seconds = seconds_for(size, 1)
    if seconds >= SHORTEST_TIME:
        # A busy machine may spoil one measurement, but quadratic work fails every time.
        found = [(seconds_for(size), seconds_for(2 * size))]
        while found[-1][1] >= LARGEST_RATIO * found[-1][0] and len(found) < TRIES:
            found.append((seconds_for(size), seconds_for(2 * size)))
        once, twice = found[-1]
        assert twice < LARGEST_RATIO * once, (
            f"{once:.3f} s for {size}, {twice:.3f} s for twice that"
        )


def repeated(letters, size):
    return letters * (size // len(letters))


@pytest.mark.slow
@pytest.mark.parametrize("letters", ALPHABETS.values(), ids=ALPHABETS)
def test_markdown_is_read_in_linear_time(letters):
    assert_linear(lambda size: repeated(letters, size), sanitize_markdown)
    assert_linear(lambda size: repeated(letters, size), as_code)


@pytest.mark.slow
@pytest.mark.parametrize("letters", ALPHABETS.values(), ids=ALPHABETS)
def test_a_file_is_read_in_linear_time(letters):
    def read(data):
        with contextlib.suppress(UnreadableNotebook):
            decode_notebook(data, "file.ipynb")

    assert_linear(lambda size: repeated(letters, size).encode(), read)
    assert_linear(lambda size: b'{"cells": [' + repeated(letters, size).encode(), read)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["code", "markdown", "raw"])
@pytest.mark.parametrize("letters", ALPHABETS.values(), ids=ALPHABETS)
def test_a_cell_is_read_in_linear_time(letters, kind):
    """Preflight and the copy for Formgrader take linear time if one cell is long."""

    def show(draft):
        prepared = preflight.prepare(draft, LESSON)
        copy = build_copy(prepared)
        write_verdict(copy, VERDICT)

    assert_linear(lambda size: submission_of([(kind, repeated(letters, size))]), show)


@pytest.mark.slow
@pytest.mark.parametrize("letters", ALPHABETS.values(), ids=ALPHABETS)
def test_a_verdict_is_shown_in_linear_time(letters, tmp_path):
    """The class report and the copy for Formgrader take linear time if a message is long."""

    def verdict(size):
        message = repeated(letters, size)
        tests = (CheckResult("a check", message, False, 0.0, 1.0, message, True),)
        exercises = tuple(
            ExerciseResult(exercise.name, 0.0, exercise.points, tests, message, "a check")
            for exercise in LESSON.machine_graded
        )
        return dataclasses.replace(VERDICT, exercises=exercises, problems=(message,))

    def show(verdict):
        write_report(Course(tmp_path), [(SimpleNamespace(student="mallory"), verdict)])
        write_verdict(build_copy(preflight.prepare(submission_of([]), LESSON)), verdict)

    assert_linear(verdict, show)


@pytest.mark.slow
@pytest.mark.parametrize("step", preflight.STEPS, ids=lambda step: step.__name__)
@pytest.mark.parametrize("kinds", [("code",), ("markdown",), ("raw",), ("code", "markdown")])
def test_many_cells_are_prepared_in_linear_time(step, kinds):
    """Each preflight step takes linear time if many cells define or claim to be exercises."""
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
