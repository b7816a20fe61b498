"""Tests of the optional lesson's checks, with plain and with compiled answers."""

import contextlib
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from grader.course.kept_answers import answers_to
from grader.course.lessons import load_reference, optional_lessons
from tests.prerequisites import NUMBA
from tests.ungraded_steps import assert_mistakes_have_answers
from utils.checks import check, checks_of, core
from utils.checks.compiled import as_python
from utils.checks.core import ChecksFailed, notes_of, run_check
from utils.checks.diagnosis import diagnose
from utils.checks.waiting_cells import ready

(LESSON,) = (lesson for lesson in optional_lessons() if lesson.number == "13")
ANSWERS = [(name, variant) for name in LESSON.steps for variant in answers_to(name)]
RIGHT = [(name, variant) for name, variant in ANSWERS if variant.right]


def parameters_of(answers):
    return [pytest.param(*answer, id=f"{answer[0]}: {answer[1].name}") for answer in answers]


def namespace_of(decorator=lambda function: function):
    """Return the names that an answer can use, with `decorator` in place of `njit`."""
    turns = np.radians(np.arange(90))
    names = {"np": np, "njit": decorator, "cosines": np.cos(turns), "sines": np.sin(turns)}
    (right_answer,) = (answer for answer in answers_to("root_of") if answer.follows_hints)
    exec(f"@njit\n{right_answer.source}", names)
    return names


def function_of(name, variant, decorator=lambda function: function):
    names = namespace_of(decorator)
    exec(f"@njit\n{variant.source}", names)
    return names[name]


def failures_of(name, function):
    outcomes = [run_check(check, as_python(function)) for check in checks_of(name)]
    return {outcome.check.name: outcome for outcome in outcomes if outcome.failure}


def test_each_step_has_checks_and_gives_no_points():
    text = LESSON.source.read_text("utf-8")
    assert len(LESSON.steps) == 5 and LESSON.exercises == ()
    for name in LESSON.steps:
        assert text.count(f"\ncheck({name})\n") == 1 and len(notes_of(name)) == 1
        assert {check.lesson for check in checks_of(name)} == {"lesson_13"}
        right = [variant.right for variant in answers_to(name)]
        assert sum(right) >= 5 and len(right) - sum(right) >= 8


@pytest.mark.parametrize("name", LESSON.steps)
def test_the_solution_passes(name):
    function = getattr(load_reference(LESSON.name, *LESSON.steps), name)
    assert not failures_of(name, function) and diagnose(name, as_python(function)) is None
    assert not run_check(notes_of(name)[0], as_python(function)).failure


@pytest.mark.parametrize(("name", "variant"), parameters_of(ANSWERS))
def test_kept_answers_pass_or_fail_as_claimed(name, variant, monkeypatch):
    monkeypatch.setattr(core, "SECONDS", 1)
    function = function_of(name, variant)
    failed = failures_of(name, function)
    if variant.right:
        assert not failed and diagnose(name, function) is None
        return
    if "did not return within" in variant.says:
        # `check` stops after a timeout, so a student sees only the first failed check.
        failed = dict([*failed.items()][:1])
    assert set(variant.loses) <= set(failed), sorted(failed)
    assert not variant.loses_only or set(failed) <= set(variant.loses), sorted(failed)
    messages = " ".join(f"{one.check.title} {one.failure.message} {one.failure.input_text} "
                    f"{one.failure.hint} {one.check.hint}" for one in failed.values())  # fmt: skip
    assert variant.says in messages, messages
    mistake = None if "did not return within" in variant.says else diagnose(name, function)
    assert bool(mistake) == bool(variant.told), mistake
    assert variant.told in (mistake.description if mistake else "")


@pytest.mark.parametrize("name", LESSON.steps)
def test_every_known_mistake_has_a_kept_answer(name):
    assert_mistakes_have_answers(name, answers_to(name))


class Compiled:
    """Fake compiled function, with the attributes of Numba's functions that `check` uses."""

    def __init__(self, py_func, answer=None):
        self.py_func, self.__wrapped__, self.__code__ = py_func, py_func, py_func.__code__
        self.__name__, self.answer = py_func.__name__, answer or py_func

    def __call__(self, *arguments):
        return self.answer(*arguments)


@pytest.fixture
def numba(monkeypatch):
    """Fake Numba module, which compiles nothing."""
    module = ModuleType("numba")
    module.njit = module.jit = Compiled
    monkeypatch.setitem(sys.modules, "numba", module)
    return module


def must_not_be_called(*arguments):
    raise AssertionError("the compiled function must not be called")


def test_compiled_functions_are_checked_as_python(numba, monkeypatch, capsys):
    monkeypatch.setattr(core, "SECONDS", 0.2)
    (hangs,) = (
        answer for answer in answers_to("root_of") if "did not return within" in answer.says
    )
    function = function_of("root_of", hangs, lambda made: Compiled(made, must_not_be_called))
    with pytest.raises(ChecksFailed):
        check(function)
    shown = capsys.readouterr().out
    assert "did not return within 0.2 s: does each round of the loop move" in shown
    assert not ready(function) and "until root_of passes its checks" in capsys.readouterr().out


def test_compiled_helpers_are_checked_as_python(numba):
    (right,) = (answer for answer in answers_to("unite") if answer.follows_hints)
    function = function_of("unite", right, lambda made: Compiled(made, must_not_be_called))
    assert not failures_of("unite", function)


def test_a_wrong_helper_is_named(numba, capsys):
    names = namespace_of(Compiled)
    for name, answer_name in (
        ("root_of", "returns the parent"),
        ("unite", "the hints followed to the letter"),
    ):
        (variant,) = (answer for answer in answers_to(name) if answer.name == answer_name)
        exec(f"@njit\n{variant.source}", names)
    with pytest.raises(ChecksFailed):
        check(names["unite"])
    assert "root_of, which this function calls, fails its own checks" in capsys.readouterr().out


def raises_like_numba(*arguments):
    raise TypeError(
        "Failed in nopython mode pipeline\nCannot unify x at 0xf00 and y, defined at /b.py (2)\n\n"
        f'File "a.py", line {raises_like_numba.line}:\n'
    )


raises_like_numba.line = 2


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (raises_like_numba, "Its message about line 2, ``, is: Cannot unify x and y."),
        (lambda *arguments: 7, "The compiled function returns 7, but the Python code returns 5"),
    ],
)
def test_a_note_reports_compiler_errors_and_different_results(numba, capsys, answer, words):
    (right,) = (stored for stored in answers_to("count_near") if stored.follows_hints)
    function = function_of("count_near", right, lambda made: Compiled(made, answer))
    check(function)
    shown = capsys.readouterr().out
    assert "[note]" in shown and words in shown
    assert not ready(function)
    check(right_one := function_of("count_near", right, Compiled))
    assert "[note]" not in capsys.readouterr().out and ready(right_one)


def test_a_missing_decorator_gets_a_note_if_numba_is_installed(numba, capsys):
    (right,) = (answer for answer in answers_to("any_close") if answer.follows_hints)
    function = function_of("any_close", right)
    check(function)
    assert "`@njit` above its first line" in capsys.readouterr().out
    del sys.modules["numba"]
    check(function)
    assert "[note]" not in capsys.readouterr().out and ready(function)


def test_a_cell_waits_until_its_function_has_passed(capsys, monkeypatch):
    # If Numba has been imported, functions that are not compiled get a note.
    monkeypatch.delitem(sys.modules, "numba", raising=False)

    def stub(points):
        raise NotImplementedError

    (right,) = (stored for stored in answers_to("snuggest_turn") if stored.follows_hints)
    stub.__name__ = "snuggest_turn"
    with pytest.raises(ChecksFailed):
        check(stub)
    capsys.readouterr()
    assert not ready(stub)
    message = "This cell waits until snuggest_turn is written."
    assert message in capsys.readouterr().out
    for function in (function_of("snuggest_turn", right), function_of("snuggest_turn", right)):
        assert not ready(function)
        assert (
            "This cell waits until snuggest_turn passes its checks without a note."
            in capsys.readouterr().out
        )
        check(function)
        capsys.readouterr()
        assert ready(function) and not capsys.readouterr().out
    wrong = next(answer for answer in answers_to("snuggest_turn") if not answer.right)
    with contextlib.suppress(ChecksFailed):
        check(function_of("snuggest_turn", wrong))
    assert not ready(function), "a later wrong answer must block the cell"


@pytest.mark.slow
@pytest.mark.parametrize(("name", "variant"), parameters_of(RIGHT))
def test_right_answers_give_the_same_results_with_numba(name, variant):
    numba = pytest.importorskip("numba", reason=NUMBA)
    function = as_python(function_of(name, variant, numba.njit))
    assert function.compiled.py_func and not failures_of(name, function)
    outcome = run_check(notes_of(name)[0], function)
    assert not outcome.failure, outcome.failure
    assert function.compiled.signatures, "Numba must have compiled it"


@pytest.mark.slow
def test_a_note_quotes_the_error_of_numba(tmp_path):
    numba = pytest.importorskip("numba", reason=NUMBA)
    file = tmp_path / "cell.py"
    file.write_text("@njit\ndef any_close(points, a, a_end, b, b_end, limit):\n"
                    "    rows = [*zip(points[a:a_end], points[b:b_end], strict=True)]\n"
                    "    return len(rows)\n")  # fmt: skip
    names = {"njit": numba.njit}
    exec(compile(file.read_text(), file, "exec"), names)
    notes = SimpleNamespace(python=as_python(names["any_close"]))
    outcome = run_check(notes_of("any_close")[0], notes.python)
    assert "Numba cannot compile this function. Its message" in outcome.failure.message
