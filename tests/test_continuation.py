"""After a wrong answer, later cells that fail because of it run with stored answers and say so."""

import json
import random

import pytest

from grader.course.kept_answers import answers_to
from grader.course.lessons import find_lesson
from tests.lesson_runs import right_answers, run_cells, runs_with_answers
from utils import lent
from utils.lent.rerun_plan import key_of_cell, plan_rerun

SETUP = """\
from utils.checks.core import ChecksFailed
from utils.lent import report_check, own

def check(function):
    function = own(function)
    good = function([1, 4, 2]) == 4
    report_check(function.__name__, good)
    if not good:
        raise ChecksFailed("one check failed")
"""
CELLS = {
    "data": "import numpy as np\nnumbers = [3, 1, 2]\n"
    "rng = np.random.default_rng(1)\nrng.integers(9)",
    "look": "top = largest(numbers)\nprint(f'largest: {top + 1}')",
    "check": "check(largest)",
    "stopped": "report_check('largest', False, hangs=True)",
    "use": "print('use', top * 2)",
    "define": "def twice(values):\n    return 2 * largest(values)",
    "call": "print('call', 1 + twice(numbers))",
    "experiment": "print('found', 1 + found(4))",
    "draw": "some = rng.integers(9, size=3).tolist()\nprint('drawn', 1 + largest(some), some)",
    "loop": "for other in [numbers]:\n    print('loop', 1 + largest(other))",
    "first": "print('first', numbers[0])",
    "wrong": "print('wrong', largest(numbers))\nraise ValueError('of the lesson')",
    "second check": "check(found_by)",
    # This is how `interact` of ipywidgets shows tracebacks.
    "slider": "try:\n    print('shown', 1 + largest(numbers))\n"
    "except Exception:\n    get_ipython().showtraceback()",
}
DEFINE_FOUND = "def found(n):\n    return largest(list(range(n)))"
RIGHT = "def largest(values):\n    return max(values)"
RETURNS_NOTHING = "def largest(values):\n    max(values)"
CLEARS_INPUT = "def largest(values):\n    values.clear()\n    return 0"
BANNER = "largest has not passed its check, so this cell continues with the course's answer."


def stored_answers():
    """Return stored answers, recorded while the solved functions ran."""
    namespace = {}
    exec(f"{RIGHT}\n{DEFINE_FOUND}", namespace)
    recorder = lent.Recorder(["largest"], ["found"], namespace)
    recorder.wrap_stubs()
    generator = "np.random.default_rng(1)\nrng.integers(9)\n"
    exec(f"import numpy as np\nrng = {generator}some = rng.integers(9, size=3).tolist()", namespace)
    for values in ([3, 1, 2], namespace["some"]):
        namespace["largest"](values)
    namespace["found"](4)
    answers = json.loads(recorder.text())
    assert answers.pop("faults") == []
    return answers


def run_story(monkeypatch, tmp_path, *sources):
    """Run cells, given by their name in CELLS or as code; return each with its results."""
    cells = [key_of_cell(code) for code in (SETUP, DEFINE_FOUND, *CELLS.values())]
    (tmp_path / "lesson_99.json").write_text(json.dumps(stored_answers()))
    (tmp_path / "cells.json").write_text(json.dumps({"99": cells}))
    monkeypatch.setattr(lent, "_HERE", tmp_path)
    monkeypatch.setattr(lent, "CELLS", tmp_path / "cells.json")
    monkeypatch.setattr(lent, "_LENDING", set())

    def prepare(shell):
        from utils.tracebacks import hide_course_frames

        hide_course_frames()
        lent.lend_answers("99")

    sources = [SETUP, DEFINE_FOUND, *(CELLS.get(code, code) for code in sources)]
    ran = run_cells(sources, prepare)[2:]
    assert not [text for cell in ran for text in cell.tracebacks if "/utils/" in text]
    return ran


@pytest.fixture
def run(monkeypatch, tmp_path):
    return lambda *sources: run_story(monkeypatch, tmp_path, *sources)


def test_a_cell_below_a_failed_check_runs_with_the_courses_answer(run):
    data, written, look, check, use = run("data", RETURNS_NOTHING, "look", "check", "use")
    assert look.errors == ["TypeError: unsupported operand type(s) for +: 'NoneType' and 'int'"]
    assert not look.banners and check.errors == ["ChecksFailed: one check failed"]
    assert (use.succeeded, use.printed, use.errors) == (True, "use 6\n", [])
    assert use.displayed == [
        f"{BANNER} Yours is used again when it passes, or when you run its cell again."
    ]


def test_later_cells_show_one_short_line(run):
    ran = run(
        "data", RETURNS_NOTHING, "look", "check", "use", "define", "call", "experiment", "loop"
    )
    assert [cell.printed for cell in ran[5:]] == ["", "call 7\n", "found 4\n", "loop 4\n"]
    assert [cell.displayed for cell in ran[5:]] == [[], [BANNER], [BANNER], [BANNER]]


def test_random_numbers_are_repeated(run):
    drawn = run("data", RETURNS_NOTHING, "check", "draw")[-1]
    right = run("data", RIGHT, "check", "draw")[-1]
    assert drawn.printed == right.printed and drawn.succeeded
    assert drawn.banners and not right.banners


def test_no_cell_is_repeated_without_a_failed_check(run):
    assert [cell.succeeded for cell in run("data", RETURNS_NOTHING, "use", "call")][2:] == [
        False,
        False,
    ]
    ran = run("data", RETURNS_NOTHING, "look", "check", RETURNS_NOTHING, "define", "call")
    assert ran[-1].errors and not ran[-1].banners


def test_a_students_cell_uses_the_students_function(run):
    own_cell = "print('mine', 1 + largest(numbers))"
    ran = run("data", RETURNS_NOTHING, "look", "check", "use", own_cell, "look", "print(1 + top)")
    assert [cell.succeeded for cell in ran[4:]] == [True, False, False, False]
    assert "1 + largest(numbers)" in ran[5].tracebacks[0]


def test_a_students_cell_lists_the_names_that_come_from_the_course(run):
    ran = run("data", RETURNS_NOTHING, "look", "check", "use", "mine = top + 1", "print(mine)")
    assert ran[-2].displayed == [
        "top was computed with the course's answer for largest. To use yours, rerun the cell that "
        "computes it."
    ]
    assert (
        ran[-1].displayed[0].startswith("mine was computed with the course's answer for largest.")
    )


def test_a_passed_check_restores_the_students_function(run):
    right = "def largest(values):\n    print('mine')\n    return max(values)"
    ran = run(
        "data", RETURNS_NOTHING, "look", "check", "use", right, "check", "use", "call", "loop"
    )
    assert ran[6].displayed == ["largest has passed, so the following cells use yours again."]
    assert [cell.printed for cell in ran[7:]] == ["use 6\n", "", "mine\nloop 4\n"]
    assert not [cell for cell in ran[7:] if cell.displayed]


def test_a_check_uses_the_students_helper(run):
    caller = "def found_by(values):\n    return largest(values)"
    ran = run("data", RETURNS_NOTHING, "look", "check", "use", caller, "second check", "use")
    assert ran[-2].errors == ["ChecksFailed: one check failed"]
    assert ran[-1].banners


def test_data_that_a_function_changed_is_restored(run):
    ran = run("data", CLEARS_INPUT, "look", "check", "first")
    assert ran[-1].printed == "first 3\n" and ran[-1].displayed == [
        "largest has not passed its check, so this cell continues with its original input, "
        "which was computed again."
    ]


def test_a_cell_that_fails_anyway_shows_its_error(run):
    ran = run("data", RETURNS_NOTHING, "look", "check", "wrong", "largest(numbers)", "use")
    assert ran[4].errors == ["ValueError: of the lesson"] and not ran[4].banners
    assert ran[5].succeeded and not ran[5].banners


def test_the_students_function_is_restored_after_a_cell_that_fails_anyway(run):
    own_cell = "print('mine', largest([5]))"
    ran = run("data", RETURNS_NOTHING, "look", "check", "use", "wrong", own_cell, "check", "call")
    assert ran[5].errors == ["ValueError: of the lesson"]
    assert (ran[6].printed, ran[6].displayed, ran[6].errors) == ("mine None\n", [], [])
    assert ran[7].errors == ["ChecksFailed: one check failed"]  # `largest` is written but wrong


def test_a_slider_that_fails_runs_with_the_courses_answer(run):
    slider = run("data", RETURNS_NOTHING, "look", "check", "slider")[-1]
    assert (slider.errors, slider.printed, len(slider.banners)) == ([], "shown 4\n", 1)


def test_a_right_answer_is_not_replaced(run):
    ran = run("data", RIGHT, "look", "check", "use", "define", "call", "experiment", "draw")
    assert all(cell.succeeded and not cell.displayed for cell in ran)


def test_a_hanging_function_is_replaced_before_the_next_cell(run):
    loop = "def largest(values):\n    raise SystemExit('it would not come back')"
    use = run("data", loop, "look", "stopped", "use")[-1]
    assert (use.printed, use.displayed) == ("use 6\n", [BANNER])


def test_tracebacks_have_frames_of_the_notebook_only(run):
    own_function = "def f(values):\n    return 1 / values[0]"
    call = "from utils.checks.run_cache import answer_to\nanswer_to(f, 'a', np.zeros(1, int)[:0])"
    failed = run("data", own_function, call)[-1]
    assert failed.errors == ["IndexError: index 0 is out of bounds for axis 0 with size 0"]
    assert "answer_to(f, 'a'" in failed.tracebacks[0] and "1 / values[0]" in failed.tracebacks[0]
    drawn = run("data", "from utils import plots\nplots.boxes(numbers)")[-1]
    assert "plots.boxes(numbers)" in drawn.tracebacks[0]


def test_an_object_is_recreated_for_a_statement_that_changes_it():
    cells = ["found = []", "found.append(f(1))", "other = 2", "print(found)"]
    kept = plan_rerun(cells, {"f": ["f"]}, set()).statements
    assert [statement.cell for statement in kept] == [1, 2]


@pytest.mark.parametrize(
    ("loop", "again"),
    [
        ("for axes in panels:\n    axes.plot(top)", []),
        ("for panel in panels:\n    axes = panel\n    axes.plot(top)", []),
        ("for axes in axes:\n    axes.plot(top)", [1]),
        ("for panel in panels:\n    axes.plot(top)\n    axes = panel", [1]),
        ("for panel in panels:\n    axes = axes or panel\n    axes.plot(top)", [1]),
        ("for panel in panels:\n    axes[panel] = top", [1]),
    ],
)
def test_names_that_a_loop_assigns_are_not_recreated(loop, again):
    cells = ["axes = f(0)", "panels = [1]\ntop = 2", loop]
    assert [
        statement.cell for statement in plan_rerun(cells, {"f": ["f"]}, set()).statements
    ] == again


@pytest.mark.parametrize(
    ("last", "again"),
    [
        ("axes = draw(free)\naxes.plot()", [2]),
        ("axes = draw(axes, free)\naxes.plot()", [1, 2]),
        ("axes.plot()\naxes = draw(free)", [1, 2]),
        ("if free:\n    axes = draw(free)\naxes.plot()", [1, 2]),
    ],
)
def test_a_name_that_the_cell_assigns_before_use_is_not_recreated(last, again):
    """An earlier cell may have used the name, such as `axes`, for a call without stored answer."""
    kept = plan_rerun(["axes = f(0)", "free = f(1)", last], {"f": ["f"]}, set()).statements
    assert [statement.cell for statement in kept] == again


def test_nothing_is_run_again_for_a_cell_that_uses_no_course_names():
    found = plan_rerun(["a = f(1)", "b = 2", "print(b)"], {"f": ["f"]}, set())
    assert not found.functions and not found.statements


FIRST = {"08_bounding_boxes": "get_bounding_boxes", "02_ransac_line": "line_through"}


@pytest.mark.slow
@pytest.mark.parametrize("name", FIRST)
def test_a_right_answer_to_a_lesson_shows_no_banner(name):
    lesson, exercise = find_lesson(name), FIRST[name]
    (cells,) = runs_with_answers(lesson, exercise, [right_answers(lesson)[exercise]])
    assert not [cell for cell in cells if cell.errors or cell.banners]


@pytest.mark.slow
def test_every_cell_below_a_wrong_answer_runs_to_the_end(lesson):
    """After a wrong answer, no traceback shows course code, and every later cell runs to the end.

    Two answers are drawn for each exercise, because each answer takes a run of the notebook.
    """
    for exercise in lesson.machine_graded:
        wrong = [answer for answer in answers_to(exercise.name) if not answer.right]
        wrong = random.Random(exercise.name).sample(wrong, 2)
        for answer, cells in zip(
            wrong,
            runs_with_answers(lesson, exercise.name, [answer.source for answer in wrong]),
            strict=True,
        ):
            first = next(n for n, cell in enumerate(cells) if cell.grade_id.startswith("test_"))
            for cell in cells:
                assert not any("/utils/" in text for text in cell.tracebacks), (answer.name, cell)
            for cell in cells[first + 1 :]:
                assert cell.checks or cell.succeeded, (answer.name, cell)
