"""A wrong answer does not end the evening: a later cell that fails with it goes on, and says so."""

import json
import random

import pytest

from grader.course.kept_answers import answers_to
from grader.course.lessons import find_lesson
from tests.continuation_runs import evening, evenings, right_answers
from utils import lent
from utils.lent.rerun import key_of_cell, plan

SETUP = """\
from utils.checks.core import ChecksFailed
from utils.lent import hear, own

def check(function):
    function = own(function)
    good = function([1, 4, 2]) == 4
    hear(function.__name__, good)
    if not good:
        raise ChecksFailed("one check failed")
"""
STORY = {
    "data": "import numpy as np\nnumbers = [3, 1, 2]\n"
    "rng = np.random.default_rng(1)\nrng.integers(9)",
    "look": "top = largest(numbers)\nprint(f'largest: {top + 1}')",
    "check": "check(largest)",
    "stopped": "hear('largest', False, hangs=True)",
    "use": "print('use', top * 2)",
    "define": "def twice(values):\n    return 2 * largest(values)",
    "call": "print('call', 1 + twice(numbers))",
    "experiment": "print('found', 1 + found(4))",
    "draw": "some = rng.integers(9, size=3).tolist()\nprint('drawn', 1 + largest(some), some)",
    "loop": "for other in [numbers]:\n    print('loop', 1 + largest(other))",
    "first": "print('first', numbers[0])",
    "wrong": "print('wrong', largest(numbers))\nraise ValueError('of the lesson')",
    "second check": "check(found_by)",
    # As `interact` of ipywidgets does.
    "slider": "try:\n    print('shown', 1 + largest(numbers))\n"
    "except Exception:\n    get_ipython().showtraceback()",
}
EXPERIMENT = "def found(n):\n    return largest(list(range(n)))"
RIGHT = "def largest(values):\n    return max(values)"
NOTHING = "def largest(values):\n    max(values)"
SPOILS = "def largest(values):\n    values.clear()\n    return 0"
TWICE = "largest has not passed its check: this cell goes on with the course's answer."


def stored():
    """What the solved story answers."""
    space = {}
    exec(f"{RIGHT}\n{EXPERIMENT}", space)
    recorder = lent.Recorder(["largest"], ["found"], space)
    recorder.look_round()
    drawn = "np.random.default_rng(1)\nrng.integers(9)\n"
    exec(f"import numpy as np\nrng = {drawn}some = rng.integers(9, size=3).tolist()", space)
    for values in ([3, 1, 2], space["some"]):
        space["largest"](values)
    space["found"](4)
    answers = json.loads(recorder.text())
    assert answers.pop("faults") == []
    return answers


def told(monkeypatch, tmp_path, *sources):
    """Run cells of the story, by name, and others; see `evenings.evening`."""
    cells = [key_of_cell(source) for source in (SETUP, EXPERIMENT, *STORY.values())]
    (tmp_path / "lesson_99.json").write_text(json.dumps(stored()))
    (tmp_path / "cells.json").write_text(json.dumps({"99": cells}))
    monkeypatch.setattr(lent, "_HERE", tmp_path)
    monkeypatch.setattr(lent, "CELLS", tmp_path / "cells.json")
    monkeypatch.setattr(lent, "_LENDING", set())

    def begin(shell):
        from utils.tracebacks import show_no_frames_of_ours

        show_no_frames_of_ours()
        lent.lend_answers("99")

    ran = evening([SETUP, EXPERIMENT, *(STORY.get(one, one) for one in sources)], begin)[2:]
    assert not [text for cell in ran for text in cell.tracebacks if "/utils/" in text]
    return ran


@pytest.fixture
def tell(monkeypatch, tmp_path):
    return lambda *sources: told(monkeypatch, tmp_path, *sources)


def test_a_cell_below_a_failed_check_goes_on_and_says_so(tell):
    data, written, look, check, use = tell("data", NOTHING, "look", "check", "use")
    assert look.errors == ["TypeError: unsupported operand type(s) for +: 'NoneType' and 'int'"]
    assert not look.banners and check.errors == ["ChecksFailed: one check failed"]
    assert (use.succeeded, use.printed, use.errors) == (True, "use 6\n", [])
    assert use.said == [
        f"{TWICE} Yours is back when it passes, or when you run its own cell again."
    ]


def test_from_then_on_a_line_says_so_and_only_one(tell):
    ran = tell("data", NOTHING, "look", "check", "use", "define", "call", "experiment", "loop")
    assert [cell.printed for cell in ran[5:]] == ["", "call 7\n", "found 4\n", "loop 4\n"]
    assert [cell.said for cell in ran[5:]] == [[], [TWICE], [TWICE], [TWICE]]


def test_what_was_drawn_is_drawn_again(tell):
    drawn = tell("data", NOTHING, "check", "draw")[-1]
    right = tell("data", RIGHT, "check", "draw")[-1]
    assert drawn.printed == right.printed and drawn.succeeded
    assert drawn.banners and not right.banners


def test_nobody_is_told_to_go_on_without_a_check(tell):
    assert [cell.succeeded for cell in tell("data", NOTHING, "use", "call")][2:] == [False, False]
    ran = tell("data", NOTHING, "look", "check", NOTHING, "define", "call")
    assert ran[-1].errors and not ran[-1].banners


def test_a_cell_of_ones_own_has_ones_own_function(tell):
    mine = "print('mine', 1 + largest(numbers))"
    ran = tell("data", NOTHING, "look", "check", "use", mine, "look", "print(1 + top)")
    assert [cell.succeeded for cell in ran[4:]] == [True, False, False, False]
    assert "1 + largest(numbers)" in ran[5].tracebacks[0]


def test_a_name_of_the_courses_is_called_so_in_a_cell_of_ones_own(tell):
    ran = tell("data", NOTHING, "look", "check", "use", "mine = top + 1", "print(mine)")
    assert ran[-2].said == [
        "top was made with the course's answer for largest. Run the cell that makes it again, and "
        "it is made with yours."
    ]
    assert ran[-1].said[0].startswith("mine was made with the course's answer for largest.")


def test_a_passed_check_brings_ones_own_back(tell):
    right = "def largest(values):\n    print('mine')\n    return max(values)"
    ran = tell("data", NOTHING, "look", "check", "use", right, "check", "use", "call", "loop")
    assert ran[6].said == ["largest has passed: from here on, the cells have yours again."]
    assert [cell.printed for cell in ran[7:]] == ["use 6\n", "", "mine\nloop 4\n"]
    assert not [cell for cell in ran[7:] if cell.said]


def test_a_check_asks_ones_own_helper(tell):
    helped = "def found_by(values):\n    return largest(values)"
    ran = tell("data", NOTHING, "look", "check", "use", helped, "second check", "use")
    assert ran[-2].errors == ["ChecksFailed: one check failed"]
    assert ran[-1].banners


def test_what_a_function_has_spoilt_is_made_anew(tell):
    ran = tell("data", SPOILS, "look", "check", "first")
    assert ran[-1].printed == "first 3\n" and ran[-1].said == [
        "largest has not passed its check: this cell goes on with what it was given, made anew."
    ]


def test_a_cell_that_fails_anyway_shows_how(tell):
    ran = tell("data", NOTHING, "look", "check", "wrong", "largest(numbers)", "use")
    assert ran[4].errors == ["ValueError: of the lesson"] and not ran[4].banners
    assert ran[5].succeeded and not ran[5].banners


def test_ones_own_is_back_after_a_cell_that_fails_with_the_courses_answer(tell):
    mine = "print('mine', largest([5]))"
    ran = tell("data", NOTHING, "look", "check", "use", "wrong", mine, "check", "call")
    assert ran[5].errors == ["ValueError: of the lesson"]
    assert (ran[6].printed, ran[6].said, ran[6].errors) == ("mine None\n", [], [])
    assert ran[7].errors == ["ChecksFailed: one check failed"]  # of one that is written


def test_a_slider_that_fails_goes_on(tell):
    slider = tell("data", NOTHING, "look", "check", "slider")[-1]
    assert (slider.errors, slider.printed, len(slider.banners)) == ([], "shown 4\n", 1)


def test_a_right_answer_is_left_alone(tell):
    ran = tell("data", RIGHT, "look", "check", "use", "define", "call", "experiment", "draw")
    assert all(cell.succeeded and not cell.said for cell in ran)


def test_what_hangs_is_put_aside_before_the_next_cell(tell):
    loop = "def largest(values):\n    raise SystemExit('it would not come back')"
    use = tell("data", loop, "look", "stopped", "use")[-1]
    assert (use.printed, use.said) == ("use 6\n", [TWICE])


def test_frames_of_ours_are_left_out_and_those_of_the_notebook_stay(tell):
    mine = "def f(values):\n    return 1 / values[0]"
    asked = "from utils.checks.run_cache import answer_to\nanswer_to(f, 'a', np.zeros(1, int)[:0])"
    failed = tell("data", mine, asked)[-1]
    assert failed.errors == ["IndexError: index 0 is out of bounds for axis 0 with size 0"]
    assert "answer_to(f, 'a'" in failed.tracebacks[0] and "1 / values[0]" in failed.tracebacks[0]
    drawn = tell("data", "from utils import plots\nplots.boxes(numbers)")[-1]
    assert "plots.boxes(numbers)" in drawn.tracebacks[0]


def test_what_changes_a_kept_thing_finds_it_new():
    cells = ["found = []", "found.append(f(1))", "other = 2", "print(found)"]
    kept = plan(cells, {"f": ["f"]}, set()).statements
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
def test_what_a_loop_makes_anew_each_time_it_does_not_find(loop, again):
    cells = ["axes = f(0)", "panels = [1]\ntop = 2", loop]
    assert [statement.cell for statement in plan(cells, {"f": ["f"]}, set()).statements] == again


def test_a_cell_that_uses_none_of_it_rests_on_nothing():
    found = plan(["a = f(1)", "b = 2", "print(b)"], {"f": ["f"]}, set())
    assert not found.functions and not found.statements


FIRST = {"08_bounding_boxes": "get_bounding_boxes", "02_ransac_line": "line_through"}


@pytest.mark.slow
@pytest.mark.parametrize("name", FIRST)
def test_a_right_answer_to_a_lesson_shows_no_banner(name):
    lesson, exercise = find_lesson(name), FIRST[name]
    (cells,) = evenings(lesson, exercise, [right_answers(lesson)[exercise]])
    assert not [cell for cell in cells if cell.errors or cell.banners]


@pytest.mark.slow
def test_every_cell_below_a_wrong_answer_comes_to_its_end(lesson):
    """Some kept wrong answers, in their lesson: no line of the course's code, and every later cell.

    A fixed draw of them: each runs a whole notebook.
    """
    for exercise in lesson.machine_graded:
        wrong = [answer for answer in answers_to(exercise.name) if not answer.right]
        wrong = random.Random(exercise.name).sample(wrong, 2)
        for one, cells in zip(
            wrong, evenings(lesson, exercise.name, [one.source for one in wrong]), strict=True
        ):
            place = next(n for n, cell in enumerate(cells) if cell.grade_id.startswith("test_"))
            for cell in cells:
                assert not any("/utils/" in text for text in cell.tracebacks), (one.name, cell)
            for cell in cells[place + 1 :]:
                assert cell.checks or cell.succeeded, (one.name, cell)
