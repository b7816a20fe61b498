"""A cell that the judge skips is named; if a newer Python could run it, no points are lost."""

import json

import pytest

from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import judge_files
from grader.judging.verdict import FAILED, JUDGED, MessageKind
from grader.sandbox import Limits
from utils.notebooks.skipped_cells import hidden_cell

LESSON = find_lesson("06_filter_ground")
BODY = "    return cloud[cloud[:, 2] >= ground_level]"
RIGHT = f"def filter_ground(cloud, ground_level=-1.2):\n{BODY}\n"
# Python 3.14 accepts this; the oldest and the newest Python of the course do not.
NEWER = f"def keep(cloud, ground_level):\n    try:\n    {BODY}\n    except IndexError, TypeError:\n"
NEWER += "        return cloud\n"
CALLS_NEWER = "def filter_ground(cloud, ground_level=-1.2):\n    return keep(cloud, ground_level)\n"


def judge_cells(sandbox, *cells, python=None, modules=None, filled=None, limits=None):
    """Return the verdict on a notebook with some cells at its end, and its first message."""
    notebook = json.loads(fill_in(LESSON, filled or {}))
    notebook["cells"] += [
        {"cell_type": "code", "metadata": {}, "outputs": [], "source": cell} for cell in cells
    ]
    if python:
        notebook["metadata"]["language_info"] = {"name": "python", "version": python}
    data = json.dumps(notebook).encode()
    files = SubmittedFiles(f"{LESSON.name}.ipynb", data, modules=modules or {})
    verdict = judge_files(files, 1, sandbox, LESSON, limits=limits)
    tests = verdict.exercises[0].tests
    return verdict, tests[0] if tests else None


@pytest.mark.parametrize("python", [None, "3.14.2"])
def test_code_for_a_newer_python_gets_no_mark(sandbox, python):
    verdict, _ = judge_cells(sandbox, NEWER, CALLS_NEWER, python=python)
    assert verdict.status == FAILED and verdict.score == 0
    assert "needs Python 3.14 or later, and this judge has Python 3." in verdict.reason
    assert verdict.reason.endswith("No points were given or taken away.")
    assert [exercise.max_score for exercise in verdict.exercises] == [10, 20]


def test_a_submitted_module_for_a_newer_python_gets_no_mark(sandbox):
    cell = f"from helpers import keep\n{CALLS_NEWER}"
    verdict, _ = judge_cells(sandbox, cell, modules={"helpers": NEWER, "unused": "x = = 3"})
    assert verdict.status == FAILED and verdict.reason.startswith("helpers.py needs Python 3.14")


# Python 3.14 has this function; the oldest and the newest Python of the course do not.
LIBRARY = "from operator import is_not_none\n" + RIGHT.replace(
    BODY, f"    if is_not_none(cloud):\n    {BODY}"
)


@pytest.mark.parametrize("python", [None, "3.14.2"])
def test_a_function_that_only_a_newer_library_has_gets_no_mark(sandbox, python):
    verdict, _ = judge_cells(sandbox, LIBRARY, python=python)
    assert verdict.status == FAILED and verdict.score == 0
    assert (
        " uses operator.is_not_none, which needs Python 3.14 or later, and this" in verdict.reason
    )


def test_a_module_that_needs_a_newer_library_gets_no_mark(sandbox):
    cell = "from helpers import filter_ground"
    verdict, _ = judge_cells(sandbox, cell, modules={"helpers": LIBRARY})
    assert verdict.status == FAILED and verdict.reason.startswith("helpers.py uses operator.is_not")


def test_a_newer_library_does_not_matter_if_the_code_works_without_it(sandbox):
    guarded = "try:\n    from operator import is_not_none\nexcept ImportError:\n    pass\n" + RIGHT
    verdict, _ = judge_cells(sandbox, guarded.replace(">=", "<"))
    assert verdict.status == JUDGED and verdict.exercises[0].score < 10
    verdict, _ = judge_cells(sandbox, LIBRARY.replace("filter_ground", "other"), RIGHT)
    assert verdict.status == JUDGED and verdict.exercises[0].score == 10


def test_a_name_that_the_students_own_python_lacked_is_judged(sandbox):
    verdict, check = judge_cells(sandbox, LIBRARY, python="3.12.1")
    assert verdict.status == JUDGED and not check.passed


def test_invalid_code_of_a_version_with_unknown_syntax_gets_no_mark(sandbox):
    verdict, _ = judge_cells(sandbox, RIGHT.replace("return", "return = ="), python="3.99.0")
    assert verdict.status == FAILED and "needs Python 3.99 or later" in verdict.reason


def test_unused_code_for_a_newer_python_does_not_matter(sandbox):
    verdict, _ = judge_cells(sandbox, NEWER, RIGHT)
    assert verdict.status == JUDGED and verdict.exercises[0].score == 10


def test_code_that_the_students_own_python_refused_is_judged(sandbox):
    verdict, check = judge_cells(sandbox, NEWER.replace("keep", "filter_ground"), python="3.12.1")
    assert verdict.status == JUDGED and not check.passed
    assert "filter_ground is in code cell" in check.message


@pytest.mark.parametrize(
    "source, reason",
    [
        (RIGHT.replace("    return", "\u00a0   return"), "U+00A0"),
        (RIGHT.replace("):", ")"), "expected ':'"),
        (f"%%cython\ncp{RIGHT}", "begins with %%cython. Delete that line"),
        (f"%%timeit\n{RIGHT}", "begins with %%timeit. Delete that line"),
    ],
)
def test_a_function_in_a_skipped_cell_is_neither_missing_nor_a_stub(sandbox, source, reason):
    """The stub of the exercise is still above."""
    verdict, check = judge_cells(sandbox, source)
    assert verdict.status == JUDGED and verdict.exercises[0].score == 0
    assert check.kind == MessageKind.OWN
    assert reason in check.message and "which was skipped" in check.message
    hidden = [test for test in verdict.exercises[0].tests if not test.visible]
    assert {test.kind for test in hidden} == {MessageKind.SAME_REASON}
    filled, check = judge_cells(sandbox, filled={"filter_ground": source})
    assert filled.exercises[0].score == 0 and reason in check.message


@pytest.mark.parametrize(
    ("line", "is_defined"),
    [
        ("cpdef filter_ground(cloud):", True),
        ("cpdef np.ndarray[double, ndim=2] filter_ground(double[:, :] cloud):", True),
        ("cdef inline double *filter_ground(double x):", True),
        ("cdef class filter_ground:", True),
        ("cpdef filter(filter_ground):", False),
        ("cpdef filter_ground_2(cloud):", False),
    ],
)
def test_functions_in_cython_are_found(line, is_defined):
    cell = hidden_cell(3, f"%%cython\n{line}\n    pass")
    assert cell.defines("filter_ground") == is_defined


def test_the_message_about_a_zero_names_too_many_cells_to_read_in_time(sandbox):
    """The limit is a millisecond, which reading so many cells exceeds on every machine."""
    cells = [f"x{number} = {number}\n" * 30 for number in range(3000)]
    limits = Limits(start_seconds=0.001)
    verdict, check = judge_cells(sandbox, *cells, RIGHT, limits=limits)
    assert verdict.score == 0
    assert "could not read the notebook's 3,0" in check.message
    assert "Delete the cells that the exercises do not need." in check.message
