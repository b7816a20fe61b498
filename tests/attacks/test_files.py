"""Hostile submissions: malformed notebooks, links, modules, and strange folder names."""

import functools
import json
import os
import time

import pytest

from grader.classroom.grade import judge_and_store, stored_verdict
from grader.classroom.submissions import Submission, find_submissions
from grader.course.kept_answers import answers_to, fill_in
from grader.course.paths import Course
from grader.intake.notebook import read_notebook
from grader.intake.submission import read_submitted_files
from grader.judging.judge import judge_files
from grader.sandbox import Limits
from grader.sandbox.failures import StudentError
from grader.sandbox.program import Program
from grader.sandbox.student import StudentProxy
from tests.attacks.attack import SANDBOX, SEED, SHORT, attack, outcome_of, with_attacks
from tests.prerequisites import PATIENCE
from utils.notebooks.reading import UnreadableNotebook

pytestmark = pytest.mark.slow


def notebook_of(*sources, **metadata):
    return {
        "nbformat": 4,
        "nbformat_minor": 5,
        "metadata": metadata,
        "cells": [
            {
                "cell_type": "code",
                "metadata": {},
                "source": source,
                "outputs": [],
                "execution_count": None,
            }
            for source in sources
        ],
    }


@with_attacks(
    "content",
    {
        "a list": [],
        "a number": 3,
        "nothing": None,
        "a string": "cells",
        "a number of cells": {"cells": 3},
        "a worksheet without cells": {"worksheets": [{}]},
    },
)
def test_json_that_is_not_a_notebook_is_refused(content, tmp_path):
    path = tmp_path / "06_filter_ground.ipynb"
    path.write_text(json.dumps(content))
    with pytest.raises(UnreadableNotebook):
        read_notebook(path)


@with_attacks(
    "content",
    {
        "a cell that is a number": {"cells": [3]},
        "a cell that is a list": {"cells": [[]]},
        "a cell without a type": {"cells": [{}]},
        "a cell without source": {"cells": [{"cell_type": "code"}]},
        "source in nested lists": {"cells": [{"cell_type": "code", "source": [[["deep"]]]}]},
        "source that is a number": {"cells": [{"cell_type": "code", "source": 5}]},
        "metadata in a list": {"cells": [], "metadata": []},
        "a format version in words": {"nbformat": "four", "cells": []},
        "source nested 900 levels deep": {
            "cells": [
                {"cell_type": "code", "source": functools.reduce(lambda a, _: [a], range(900))}
            ]
        },
    },
)
def test_malformed_cells_count_as_empty(content, tmp_path):
    path = tmp_path / "06_filter_ground.ipynb"
    path.write_text(json.dumps(content))
    assert "".join(read_notebook(path).code) == ""


@with_attacks(
    "text",
    {
        "half a million brackets": "[" * 500_000,
        "half a million nested objects": '{"a":' * 500_000,
        "two million small lists": '{"cells":[],"metadata":{"a":[' + "[]," * 2_100_000 + "[]]}}",
        "an integer with 100,000 digits": "1" * 100_000,
        "NaN": '{"cells": [NaN',
        "zeros": "\0" * 100,
    },
)
def test_a_file_made_to_break_the_reader_is_refused(text, tmp_path):
    path = tmp_path / "06_filter_ground.ipynb"
    path.write_text(text)
    with pytest.raises(UnreadableNotebook):
        read_notebook(path)


@with_attacks(
    "make",
    {
        "a link to another student's work": lambda path, other: path.symlink_to(other),
        "a link to an endless device": lambda path, other: path.symlink_to("/dev/zero"),
        "a pipe": lambda path, other: os.mkfifo(path),
        "a folder": lambda path, other: path.mkdir(),
    },
)
def test_links_pipes_and_folders_are_refused(make, tmp_path):
    other = tmp_path / "other.ipynb"
    other.write_text(json.dumps(notebook_of("x = 1")))
    path = tmp_path / "06_filter_ground.ipynb"
    make(path, other)
    with pytest.raises(UnreadableNotebook, match="cannot be opened|not an ordinary file"):
        read_notebook(path)


def test_a_file_that_is_too_large_is_refused(tmp_path):
    path = tmp_path / "06_filter_ground.ipynb"
    with path.open("wb") as file:
        file.truncate(2**40)
    with pytest.raises(UnreadableNotebook, match="larger than"):
        read_notebook(path)


@with_attacks(
    "number, shown",
    {
        "in format 3, worksheets are shown": (3, "worksheets"),
        "in format 4, cells are shown": (4, "cells"),
        "in format 4.5, cells are shown": (4.5, "cells"),
    },
)
def test_the_judge_reads_the_code_that_the_instructor_sees(number, shown, tmp_path):
    """The notebook's format number decides whether `cells` or `worksheets` are judged."""
    cell = {"cell_type": "code", "source": "cells source", "input": "cells input"}
    old = {"cell_type": "code", "source": "worksheets source", "input": "worksheets input"}
    content = {"nbformat": number, "metadata": {}, "cells": [cell]}
    content["worksheets"] = [{"cells": [old]}]
    path = tmp_path / "x.ipynb"
    path.write_text(json.dumps(content))
    (read,) = read_notebook(path).code
    assert read == f"{shown} {'input' if shown == 'worksheets' else 'source'}"


@with_attacks(
    "cell",
    {
        "a hundred thousand parentheses": "(" * 100_000,
        "a hundred thousand minus signs": "x = " + "-" * 100_000 + "1",
        "ninety nested lists": "x = " + "[" * 90 + "]" * 90,
        "five thousand nested calls": "f(" * 5000 + ")" * 5000,
        "a string without an end": "x = '" + "a" * 10**6,
        "a null character": "\0",
        "two thousand magics": "%%time\n" * 2000,
        "ten thousand percent signs": "%" * 10_000,
        "ten thousand question marks": "?" * 10_000,
        "ten thousand continued lines": "\\\n" * 10_000,
        "150 levels of indentation": "if x:\n" * 150,
        "three thousand conditions": "1 if 1 else " * 3000 + "1",
        "twenty thousand attributes": "x" + ".y" * 20_000,
        "twenty thousand plus signs": "x = 1" + " + 1" * 20_000,
        "a lone surrogate": "\udcff = 1",
        "an f-string with five thousand parts": "x = f'" + "{x!r:>{y}}" * 5000 + "'",
        "nested f-strings": "x = " + "f'{" * 140 + "1" + "}'" * 140,
        "an integer with a million digits": "x = " + "9" * 10**6,
        "an integer with a million hexadecimal digits": "x = 0x" + "f" * 10**6,
        "an enormous power": "x = 9 ** 9 ** 9 if False else 1",
        "an enormous repeated string": "x = ('a' * 10**9) * 10**9 if False else 1",
        "a million decorators": "@x\n" * 100_000 + "def g(): pass",
        "a thousand unpackings": "*" * 1000 + "x = 1",
        "patterns that slow down a tokenizer": "!" + "'\\" * 50_000,
        "a name with a million letters": "x" * 10**6 + " = 1",
        "unusual white space": "x\u2028=\u00a01\u3000",
        "right-to-left text": "x = 1 # \u202e\u2066",
        "a misplaced keyword": "async with",
        "an invalid global statement": "global f",
        "a return outside a function": "return 1",
        "an unknown future import": "from __future__ import braces",
        "a valid future import": "from __future__ import annotations",
        "a main block": "__name__ = '__main__'; __builtins__ = {}",
        "SystemExit": "raise SystemExit",
        "a closed pipe": "import os; os.close(1)",
        "a class that claims to be every exception": "Exception = BaseException = KeyError = None",
        "an encoding declaration": "# -*- coding: utf-7 -*-\n+AGY-",
    },
)
def test_a_cell_that_breaks_parsers_does_not_affect_other_cells(cell):
    """The function in the second cell works, whatever the first cell contains."""
    program = Program((cell, "def f(): return 1"), ("f",))
    with StudentProxy(program, SANDBOX, Limits(**{**SHORT, "start_seconds": 20.0})) as student:
        assert student.f() == 1


@pytest.mark.slow
def test_hundreds_of_shell_commands_are_read():
    program = Program(("x = !ls\n" * 501, "def f(): return 1"), ("f",))
    with StudentProxy(program, SANDBOX, Limits(**SHORT)) as student:
        assert student.f() == 1


def test_hundreds_of_thousands_of_cells_are_refused(submit):
    cells = ['{"cell_type":"code","source":"x=1"}'] * 700_000
    verdict = submit(
        text=f'{{"metadata":{{}},"cells":[{",".join(cells)}]}}',
        start_seconds=1.0,
        total_seconds=2.0,
    )
    assert verdict.score == 0 and verdict.seconds < PATIENCE
    assert "700,000 cells" in verdict.problems[0]


@pytest.mark.slow
def test_twenty_thousand_cells_that_define_the_exercise_get_a_verdict(submit):
    source = "def filter_ground(cloud): pass"
    cells = [
        json.dumps({"cell_type": "code", "source": source + "#" * (n % 99)}) for n in range(20_000)
    ]
    verdict = submit(
        text=f'{{"metadata":{{}},"cells":[{",".join(cells)}]}}',
        start_seconds=1.0,
        total_seconds=2.0,
    )
    assert verdict.score == 0 and verdict.seconds < PATIENCE


def test_deeply_nested_metadata_gets_a_verdict(submit, filter_lesson):
    """Metadata nested 620 levels deep may cost points, but there is still a verdict."""
    notebook = json.loads(fill_in(filter_lesson, {}))
    text = json.dumps({**notebook, "metadata": "HERE"})
    verdict = submit(text=text.replace('"HERE"', '{"a":' * 620 + "1" + "}" * 620))
    assert verdict.status == "judged" and verdict.score == 0


# ---- Modules next to the notebook -----------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        *("numpy", "utils", "slicing", "sitecustomize", "usercustomize", "wire", "worker"),
        *("importing", "syscalls", "os", "json", "__main__", "encodings", "Numpy", "NUMPY"),
    ],
)
def test_a_submitted_module_does_not_hide_other_modules(name):
    """A submitted module does not replace a worker's or lesson's module of the same name."""
    body = "import numpy, utils, os, json\ndef f():\n    return numpy.arange(3) + 1\n"
    with attack(body, modules={name: "raise SystemExit('in the way')"}) as student:
        assert student.f().tolist() == [1, 2, 3]
        assert student.problems == []


def test_a_submitted_module_is_found_unless_its_name_is_forbidden():
    assert outcome_of("import help\ndef f(): return help.x", modules={"help": "x = 5"}) == 5
    program = Program(
        ("from scipy.cluster import x\ndef f(): return x",),
        ("f",),
        modules={"scipy.cluster": "x = 5"},
        forbidden=("scipy.cluster",),
    )
    with StudentProxy(program, SANDBOX, Limits(**SHORT)) as student, pytest.raises(StudentError):
        student.f()


@with_attacks(
    "make",
    {
        "a link to the solutions": lambda path, other: path.symlink_to(other),
        "a pipe": lambda path, other: os.mkfifo(path),
        "a folder": lambda path, other: path.mkdir(),
        "a file of one terabyte": lambda path, other: os.truncate(os.open(path, 0o102), 2**40),
        "a file that is not text": lambda path, other: path.write_bytes(b"\xff\0" * 99),
    },
)
def test_an_unusual_file_in_place_of_a_module_is_harmless(make, tmp_path):
    other = tmp_path / "other.txt"
    other.write_text("SECRET = 1")
    (tmp_path / "x").mkdir()
    notebook = tmp_path / "x" / "06_filter_ground.ipynb"
    notebook.write_text(json.dumps(notebook_of("x = 1")))
    make(tmp_path / "x" / "helper.py", other)
    start = time.monotonic()
    submitted = read_submitted_files(notebook)
    assert time.monotonic() - start < PATIENCE
    assert "SECRET" not in "".join(submitted.modules.values())
    assert submitted.notebook().code == ("x = 1",)


def test_the_number_of_submitted_modules_is_limited(tmp_path):
    for number in range(10_000):
        (tmp_path / f"m{number}.py").touch()
    path = tmp_path / "06_filter_ground.ipynb"
    path.write_text(json.dumps(notebook_of("x = 1")))
    assert len(read_submitted_files(path).modules) <= 20


# ---- Student folders -------------------------------------------------------------------------


@pytest.fixture
def course(tmp_path, filter_lesson):
    """Return a course with one student, whose submission is right."""
    course = Course(tmp_path)
    stage = course.submitted / "good" / filter_lesson.stage
    stage.mkdir(parents=True)
    right = {
        exercise: next(variant.source for variant in answers_to(exercise) if variant.right)
        for exercise in ("filter_ground", "voxel_grid")
    }
    (stage / f"{filter_lesson.name}.ipynb").write_text(fill_in(filter_lesson, right))
    return course


@with_attacks(
    "link",
    {
        "a link to the notebook": lambda mine, good, stage, name: (
            (mine / stage).mkdir(parents=True),
            (mine / stage / name).symlink_to(good / stage / name),
        ),
        "a link to the stage folder": lambda mine, good, stage, name: (
            mine.mkdir(),
            (mine / stage).symlink_to(good / stage),
        ),
        "a link to the student folder": lambda mine, good, stage, name: mine.symlink_to(good),
    },
)
def test_a_link_to_another_submission_earns_no_points(link, course, filter_lesson):
    good, mine = course.submitted / "good", course.submitted / "mallory"
    link(mine, good, filter_lesson.stage, f"{filter_lesson.name}.ipynb")
    by_student = {submission.student: submission for submission in find_submissions(course)}
    assert "good" in by_student
    if "mallory" in by_student:  # linked folders may be skipped
        submitted = by_student["mallory"].read(course)
        assert submitted.data == b"" and "link" in submitted.complaint
        verdict = judge_and_store(course, by_student["mallory"], SEED, SANDBOX)
        assert verdict.score == 0 and "link" in verdict.problems[0]


def test_swapping_the_file_while_it_is_judged_gains_nothing(course, filter_lesson):
    """The file is read only once, so the verdict's key belongs to the judged bytes."""
    submission = find_submissions(course)[0]
    submitted = submission.read(course)
    submission.path.write_text(json.dumps(notebook_of("x = 1")))
    verdict = judge_files(submitted, SEED, SANDBOX, filter_lesson, "good")
    assert verdict.score == verdict.max_score
    from grader.judging.verdict import write_verdict

    write_verdict(verdict, submission.verdict_path(course))
    assert stored_verdict(course, submission, SEED) is None, (
        "the verdict does not belong to the new file"
    )


NAMES = {
    "a name that is not UTF-8": b"J\xfcrgen",
    "console markup": b"[red]",
    "a glob pattern": b"s*",
    "a glob pattern with letters": b"[a-z]",
    "a parent folder": b"..x",
    "a terminal command": b"\x1b[2J\x07",
    "two lines": b"a\nb",
    "a command-line option": b"--help",
    "HTML": b"<script>",
    "spaces": b"  ",
    "right-to-left text": "\u202egnp.exe".encode(),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES.values(), ids=NAMES)
def test_strange_student_names_are_harmless(name, course, filter_lesson, capsys):
    from grader.console import print_class
    from grader.lms.report import write_report

    student = os.fsdecode(name)
    folder = course.submitted / student / filter_lesson.stage
    folder.mkdir(parents=True)
    (folder / f"{filter_lesson.name}.ipynb").write_bytes(filter_lesson.released.read_bytes())
    found = {submission.student: submission for submission in find_submissions(course)}
    assert set(found) == {"good", student}
    judged = [
        (submission, judge_and_store(course, submission, SEED, SANDBOX, is_alone=True))
        for submission in found.values()
    ]
    by_student = {submission.student: verdict for submission, verdict in judged}
    assert by_student["good"].score == 30 and by_student[student].score == 0
    assert by_student[student].status == "judged"
    assert stored_verdict(course, found[student], SEED) == by_student[student]
    print_class(judged)
    page = write_report(course, judged).read_text("utf-8")
    assert "\x1b[2J" not in capsys.readouterr().out and "<script>" + filter_lesson.stage not in page


def test_a_path_as_a_student_name_is_refused(course, filter_lesson):
    """Submissions outside `submitted` are not found, and `read` refuses their paths."""
    outside = course.root / "x" / filter_lesson.stage
    outside.mkdir(parents=True)
    (outside / f"{filter_lesson.name}.ipynb").write_bytes(filter_lesson.released.read_bytes())
    assert [submission.student for submission in find_submissions(course)] == ["good"]
    submitted = Submission("../x", filter_lesson, outside / f"{filter_lesson.name}.ipynb").read(
        course
    )
    assert not submitted.data and "a linked folder" in submitted.complaint


def test_pipes_next_to_the_notebook_are_ignored(course, filter_lesson):
    folder = course.submitted / "good" / filter_lesson.stage
    os.mkfifo(folder / "notes.txt")
    os.mkfifo(folder / "helper.py")
    verdict = judge_and_store(course, find_submissions(course)[0], SEED, SANDBOX, is_alone=True)
    assert verdict.score == verdict.max_score
