"""Files that are too costly to read: the student gets a message, and the class is still graded."""

import itertools
import json
import os

import nbformat
import pytest

from grader import commands, grading
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.intake import preflight, reader_process
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import judge_files
from grader.judging.verdict import FAILED, JUDGED, read_verdict
from grader.lms import autograded_copy
from grader.lms.autograded_copy import graded_cells
from grader.lms.results import WAITING
from grader.lms.results_reader import class_results
from tests.executors import InlineExecutor
from tests.graded_courses import record_rehearsal

SEED = 20_170_405
LESSON = find_lesson("12_streaming_obstacles")
HOSTILE = "This delays the class."
RIGHT = {
    exercise.name: next(answer.source for answer in answers_to(exercise.name) if answer.right)
    for exercise in LESSON.machine_graded
}


def notebook(text="", **answers):
    content = json.loads(fill_in(LESSON, {**RIGHT, **answers}))
    content["cells"].append({"cell_type": "markdown", "metadata": {}, "source": text})
    return json.dumps(content).encode()


def submission_of(text="", **answers):
    return SubmittedFiles(f"{LESSON.name}.ipynb", notebook(text, **answers))


def loop_forever():
    for _ in itertools.count():
        pass


def fail():
    raise RuntimeError("a fault in the grader")


@pytest.fixture
def small_limits(monkeypatch):
    """Set small limits, so that the tests reach them quickly."""
    monkeypatch.setattr(reader_process, "CPU_SECONDS", 1)
    monkeypatch.setattr(reader_process, "MEGABYTES", 128)
    monkeypatch.setattr(reader_process, "MAX_REPLY_BYTES", 2**22)


def test_reading_in_another_process_gives_the_same_result():
    submission = submission_of("$a$ \udcff \U0001f697")
    here, there = (
        preflight.prepare(submission, LESSON),
        preflight.prepare_to_judge(submission, LESSON),
    )
    assert (there.code, there.notes, there.versions) == (here.code, here.notes, here.versions)
    copy, complaint = autograded_copy.build_copy_in_process(submission, LESSON)
    assert (copy, complaint) == (autograded_copy.build_copy(here), "")


def make_vulnerable(monkeypatch, module, name, work=loop_forever):
    """Replace a function of the grader with one that calls `work` on the hostile text."""
    right = getattr(module, name)

    def vulnerable(given, *others):
        if HOSTILE in str(given):
            return work()
        return right(given, *others)

    monkeypatch.setattr(module, name, vulnerable)


def test_a_file_that_preflight_cannot_finish_gets_a_verdict(small_limits, sandbox, monkeypatch):
    make_vulnerable(monkeypatch, preflight, "_defines")
    verdict = judge_files(submission_of(HOSTILE), SEED, sandbox)
    assert (verdict.status, verdict.score) == (JUDGED, 0.0)
    (problem,) = verdict.problems
    assert "more than 1 sec" in problem


def test_a_fault_of_the_grader_costs_no_points(small_limits, sandbox, monkeypatch):
    make_vulnerable(monkeypatch, preflight, "_defines", fail)
    verdict = judge_files(submission_of(HOSTILE), SEED, sandbox)
    assert verdict.status == FAILED
    assert "a fault in the grader" in verdict.faults[0]


@pytest.mark.slow
def test_text_that_is_too_slow_to_render_is_left_out(small_limits):
    """Text that would keep the Markdown renderer busy for minutes is left out of the copy."""
    submission = submission_of("\\\\( \\) " * 60_000)
    assert preflight.prepare_to_judge(submission, LESSON).code
    copy, complaint = autograded_copy.build_copy_in_process(submission, LESSON)
    assert "takes more than 1 seconds" in complaint
    assert len(str(copy)) < 100_000


@pytest.mark.slow
def test_a_long_text_is_shown():
    essay = "I looked at $a_n$, and at `b`.\n\n" * 3000
    copy, complaint = autograded_copy.build_copy_in_process(submission_of(essay), LESSON)
    assert not complaint
    assert essay in [cell.source for cell in copy.cells]


@pytest.fixture
def course(tmp_path):
    """Return a course with two students, the first of whom submits a hostile file."""
    course_ = Course(tmp_path / "course")
    for student in ("mallory", "zoe"):
        path = course_.submitted / student / LESSON.stage / f"{LESSON.name}.ipynb"
        path.parent.mkdir(parents=True)
        hostile = HOSTILE if student == "mallory" else ""
        path.write_bytes(notebook(hostile, write_up="It runs in real time." + hostile))
    return course_


def grade(course, sandbox, monkeypatch):
    monkeypatch.setitem(commands.__dict__, "stages", lambda: [LESSON.stage])
    monkeypatch.setattr("grader.classroom.executors.EXECUTORS", {"processes": InlineExecutor})
    record_rehearsal(course, LESSON, SEED)
    return grading.grade_course(course, [LESSON.stage], SEED, sandbox, 1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "name", "score"),
    [(preflight, "_defines", 0.0), (autograded_copy, "sanitize_markdown", 25.0)],
)
def test_the_class_is_graded_despite_a_costly_file(
    module, name, score, small_limits, course, sandbox, monkeypatch, capsys
):
    """A file that is too slow for preflight earns 0; one that is too slow to copy is not shown."""
    make_vulnerable(monkeypatch, module, name)
    status = grade(course, sandbox, monkeypatch)
    output = " ".join((lambda seen: seen.out + seen.err)(capsys.readouterr()).split())
    results = {result.student: result for result in class_results(course).notebooks}
    assert [results[student].score for student in ("mallory", "zoe")] == [score, 25]
    assert results["mallory"].status == WAITING, "a person looks for the written answer"
    path = course.autograded / "mallory" / LESSON.stage / f"{LESSON.name}.ipynb"
    copy = nbformat.read(path, as_version=4)
    nbformat.validate(copy)
    assert HOSTILE not in str(copy)
    assert "Reading 12_streaming_obstacles.ipynb takes more than 1 seconds" in copy.cells[0].source
    written = next(c for c in graded_cells(copy) if c.metadata.nbgrader.grade_id == "write_up")
    assert "Look for the answer in the file" in written.source
    verdict = read_verdict(course.verdicts / "mallory" / LESSON.stage / f"{LESSON.name}.json")
    assert (verdict.status, verdict.score) == (JUDGED, score)
    if score:
        assert status == commands.FAULT
        assert "mallory, stage4_realtime: the points were entered, but the copy" in output
    else:
        assert status == commands.SUCCESS


@pytest.mark.slow
@pytest.mark.parametrize(
    "fill",
    [
        lambda size: b"{" + b",".join(b'"%07x":1' % n for n in range(size // 11)) + b"}",
        lambda size: b'"' + "\U0001f697".encode() + b"abcd" * (size // 4) + b'"',
    ],
)
def test_the_largest_file_needs_little_memory(fill):
    data = b'{"nbformat": 4, "metadata": {}, "cells": [{"cell_type": "code", "source": "x = 1", '
    data += b'"outputs": [' + fill(60 * 2**20) + b"]}]}"
    submission = SubmittedFiles(f"{LESSON.name}.ipynb", data)
    before = resident_memory()
    try:
        assert preflight.prepare_to_judge(submission, LESSON).code == ("x = 1",)
    except reader_process.TooCostly as error:  # a slow machine may reach the other limit first
        assert "memory" in str(error) or "seconds" in str(error)
    assert resident_memory() - before < 2**23, "memory for reading is freed afterwards"


def resident_memory():
    """Return the resident memory of this process in bytes."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
