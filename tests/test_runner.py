"""Running the checks of a lesson, tested with an artificial lesson and student."""

import dataclasses
import gc
import hashlib
import os
import signal
import threading
import time
import weakref
from types import SimpleNamespace

import numpy as np
import pytest

from grader.course.lessons import find_lesson
from grader.judging import collection, program_run, runner
from grader.judging.collection import JudgeFault
from grader.judging.runner import JudgeTimeout, run_checks
from grader.sandbox import Limits, SandboxUnavailable
from grader.sandbox.failures import StudentStopped
from grader.sandbox.time_budget import Budget
from utils.checks import Check, CheckFailed
from utils.checks.assertions import precondition
from utils.checks.diagnosis import Mistake
from utils.checks.failures import AnswerTooLarge, WrongForm
from utils.checks.outcomes import Outcome
from utils.checks.run_cache import answer_to, cached_run, once_per_run
from utils.checks.size_limits import MAX_NUMBERS

FILTER = find_lesson("06_filter_ground")
SEED = 20_170_405
FAILURE = CheckFailed("no")
OTHER = Check("test_first", "f", "", "")
CONTEXT = program_run.JudgingContext(FILTER, SEED, None)

HEAD = """
import os, time
import pytest
from grader.judging.hidden_tests import hidden
from utils.checks.failures import CheckFailed, AnswerTooLarge
about = dict(title="A title", hint="A hint")
"""


@pytest.fixture
def make_lesson(tmp_path, monkeypatch):
    """Return a function that creates a lesson with exercises f and g from the given checks."""

    def make(hidden="", shown=()):
        tests = tmp_path / "06_made_here" / "hidden_tests.py"
        tests.parent.mkdir(exist_ok=True)
        tests.write_text(HEAD + hidden)
        monkeypatch.setattr(
            runner, "checks_of", lambda name: [check for check in shown if check.exercise == name]
        )
        return SimpleNamespace(
            name="06_made_here",
            number="06",
            tests=tests,
            machine_graded=[SimpleNamespace(name=name) for name in "fg"],
        )

    return make


class RecordingStudent(SimpleNamespace):
    """A student whose functions record their calls."""

    def __init__(self):
        super().__init__(exercise="", calls=[], closed=0)

    def __getattr__(self, name):
        if name not in "fg":
            raise AttributeError(name)
        return lambda *arguments: self.calls.append((self.exercise, name, *arguments))

    def close(self):
        self.closed += 1


def visible_check(name, exercise, run):
    return Check(name, exercise, "a title", "a hint", run=run)


def failure_types(outcomes):
    return {outcome.check.name: type(outcome.failure) for outcome in outcomes if outcome.failure}


TWO_TESTS = """
@hidden("g", **about)
def test_second(student):
    student.g("second")

@hidden("f", weight=2.5, **about)
def test_first(student):
    student.f("first")
    raise CheckFailed("no")
"""


def test_visible_checks_run_first_and_each_on_its_own_exercise(make_lesson):
    student = RecordingStudent()
    checks = [
        visible_check("passes", "g", lambda function: function("shown")),
        visible_check("fails", "f", lambda function: 1 / 0),
    ]
    outcomes = run_checks(make_lesson(TWO_TESTS, checks), student, SEED)
    assert [outcome.check.name for outcome in outcomes] == [
        "fails",
        "passes",
        "test_second",
        "test_first",
    ]
    assert [outcome.check.is_shown for outcome in outcomes] == [True, True, False, False]
    assert [outcome.check.weight for outcome in outcomes] == [1.0, 1.0, 1.0, 2.5]
    assert failure_types(outcomes) == {"fails": ZeroDivisionError, "test_first": CheckFailed}
    assert student.calls == [("g", "g", "shown"), ("g", "g", "second"), ("f", "f", "first")]
    assert student.closed == 0


def test_folders_above_a_lesson_are_not_scanned(make_lesson, monkeypatch):
    """Otherwise, judging would be slower in a home directory with many folders."""
    lesson, listed, scandir = make_lesson(TWO_TESTS), [], os.scandir

    def noted(path="."):
        listed.append(os.fspath(path))
        return scandir(path)

    monkeypatch.setattr(os, "scandir", noted)
    assert len(run_checks(lesson, RecordingStudent(), SEED)) == 2
    above = {str(folder) for folder in lesson.tests.parent.parents}
    assert above.intersection(listed) == set()


def test_only_selected_checks_run(make_lesson):
    student = RecordingStudent()
    checks = [
        visible_check("one", "f", lambda function: function()),
        visible_check("other", "g", print),
    ]
    outcomes = run_checks(
        make_lesson(TWO_TESTS, checks), student, SEED, lambda check: check.exercise == "f"
    )
    assert [outcome.check.name for outcome in outcomes] == ["one", "test_first"]
    assert [exercise for exercise, *_ in student.calls] == ["f", "f"]
    assert run_checks(make_lesson(TWO_TESTS), student, SEED, lambda check: False) == []


def test_the_remaining_checks_are_skipped_if_one_failure_decides(make_lesson):
    """Skipping saves time, because each call of a slow answer may take seconds."""
    student, hidden = (
        RecordingStudent(),
        TWO_TESTS.replace('student.g("second")', 'student.g("second"); 1 / 0'),
    )
    checks = [visible_check("passes", "g", lambda function: function("shown"))]
    outcomes = run_checks(make_lesson(hidden, checks), student, SEED, keep_going=False)
    assert failure_types(outcomes) == {
        "test_second": ZeroDivisionError,
        "test_first": StudentStopped,
    }
    assert student.calls == [("g", "g", "shown"), ("g", "g", "second")]
    checks[:0] = [visible_check("fails", "f", lambda function: 1 / 0)]
    student.calls.clear()
    outcomes = run_checks(make_lesson(hidden, checks), student, SEED, keep_going=False)
    assert [outcome.check.name for outcome in outcomes if not outcome.failure] == []
    assert student.calls == []


def test_selected_checks_can_be_run_again_later(make_lesson):
    student, lesson = RecordingStudent(), make_lesson(TWO_TESTS)
    student.exercise = "an edit of f"
    checks = [
        visible_check("passes", "g", lambda function: function("shown")),
        *(Check(name, "f", "", "") for name in ("test_first", "test_of_another_lesson")),
    ]
    (hidden,) = runner.hidden_calls(lesson, student, SEED, checks)
    assert student.calls == []  # the calls have only been prepared
    for _ in range(2):
        with pytest.raises(CheckFailed):
            hidden()
    # An exercise's own time limits do not apply to its edits.
    assert student.calls == [("an edit of f", "f", "first")] * 2
    (question,) = runner.visible_calls(student, checks)
    question()
    assert student.calls[-1][1:] == ("g", "shown")
    assert runner.hidden_calls(None, student, SEED, checks[:1]) == ()  # no tests are collected
    assert runner.visible_calls(student, checks[1:]) == ()


@pytest.mark.parametrize(
    ("hidden", "message"),
    [
        ("", "pytest cannot collect the tests in 06_made_here/hidden_tests.py (exit code 5)"),
        ("import nothing_of_this_name", "No module named 'nothing_of_this_name'"),
        (TWO_TESTS + "\nopen('there is no such file')", "there is no such file"),
    ],
)
def test_a_broken_file_of_hidden_tests_is_a_judge_fault(make_lesson, hidden, message):
    before = dict(os.environ)
    with pytest.raises(JudgeFault) as fault:
        run_checks(make_lesson(hidden), RecordingStudent(), SEED)
    assert message in str(fault.value) and "Run pytest on this file" in str(fault.value)
    assert dict(os.environ) == before


def test_a_missing_file_of_hidden_tests_is_a_judge_fault(make_lesson):
    lesson = make_lesson()
    lesson.tests.unlink()
    with pytest.raises(JudgeFault, match="pytest cannot collect the tests"):
        run_checks(lesson, RecordingStudent(), SEED)


def test_a_skipped_test_fails(make_lesson):
    hidden = """
@hidden("f", **about)
def test_one(student):
    pytest.skip("not today")

@hidden("g", **about)
def test_other(student):
    with pytest.raises(OSError):
        pass
"""
    outcomes = run_checks(make_lesson(hidden), RecordingStudent(), SEED)
    assert [outcome.check.name for outcome in outcomes if outcome.failure] == [
        "test_one",
        "test_other",
    ]


SIZED = TWO_TESTS.replace("second(student)", "second(student, size)")
UNUSABLE = {
    "a fixture of pytest": (SIZED.replace("size", "tmp_path"), "test_second needs tmp_path."),
    "an unknown fixture": (SIZED, "test_second needs size."),
    "a fixture in place of the seed": (
        "@pytest.fixture\ndef seed(): return 5\n" + TWO_TESTS,
        "seed is a fixture.",
    ),
    "a fixture with parameters": (
        "@pytest.fixture(params=[1])\ndef size(request): return request.param\n" + SIZED,
        "size is a fixture.",
    ),
    "a function before all tests": (
        "def setup_module(): pass\n" + TWO_TESTS,
        "test_second needs setup_module.",
    ),
    "a mark that skips a test": (
        "@pytest.mark.skip" + TWO_TESTS,
        "test_second is marked with pytest.mark.skip, which has no effect here.",
    ),
    "a mark that requires a fixture": (
        '@pytest.mark.usefixtures("seed")' + TWO_TESTS,
        "test_second is marked with pytest.mark.usefixtures, which has no effect here.",
    ),
    "a class": (
        "class TestAll:" + TWO_TESTS.replace("(student", "(self, student").replace("\n", "\n    "),
        "test_second is in a class.",
    ),
    "a class that pytest omits": (
        TWO_TESTS + "\nclass TestMore:\n    def __init__(self): pass\n"
        '    @hidden("f", **about)\n    def test_more(self, student): pass\n',
        "TestMore is a class.",
    ),
    "a first test that is not marked": (
        "def test_helper(): pass\n" + TWO_TESTS,
        "test_helper is not marked with @hidden.",
    ),
    "a last test that is not marked": (
        TWO_TESTS + "\ndef test_helper(): pass",
        "test_helper is not marked with @hidden.",
    ),
    "a name that is not the name of a test": (
        TWO_TESTS.replace("test_second", "check_second"),
        "check_second is marked as a hidden test, but its name does not begin with test_.",
    ),
    "a name that is used twice": (TWO_TESTS * 2, "The file defines test_second 2 times"),
    "an async function": (
        TWO_TESTS.replace("def test_s", "async def test_s"),
        "test_second is an async function.",
    ),
    "no values for a parameter": (
        '@pytest.mark.parametrize("size", [])' + SIZED,
        "Empty parameter set in 'test_second'",
    ),
    "braces in a title": (
        '@pytest.mark.parametrize("size", [1])'
        + SIZED.replace('"g", **about', '"g", title="In {1, 2}", hint="A hint"'),
        "The title of test_second contains braces",
    ),
    "a random generator for all students": (
        "import random\nrng = random.Random(1)\n" + TWO_TESTS,
        "rng is a random generator that all students would share.",
    ),
}


@pytest.mark.parametrize(("hidden", "complaint"), UNUSABLE.values(), ids=UNUSABLE)
def test_a_test_that_pytest_would_change_or_leave_out_is_a_judge_fault(
    make_lesson, capfd, hidden, complaint
):
    """Otherwise, a test would give a mark that its author does not expect."""
    with pytest.raises(JudgeFault) as fault:
        run_checks(make_lesson(hidden), RecordingStudent(), SEED)
    assert complaint in str(fault.value) and len(str(fault.value).split("\n")) <= 3
    assert capfd.readouterr() == ("", "")


def test_an_error_in_collecting_hidden_tests_is_a_judge_fault(make_lesson, monkeypatch, capfd):
    monkeypatch.setattr(collection, "_names_to_fill", lambda item: 1 / 0)
    with pytest.raises(JudgeFault, match="ZeroDivisionError: division by zero"):
        run_checks(make_lesson(TWO_TESTS), RecordingStudent(), SEED)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("statement", ["pytest.fail('no')", "raise SystemExit", "return 1 == 2"])
def test_every_way_to_end_a_hidden_test_is_a_result(make_lesson, statement):
    """The search for a repair catches only ordinary exceptions."""
    lesson, student = make_lesson(TWO_TESTS.replace('student.g("second")', statement)), "anybody"
    first, *_ = run_checks(lesson, RecordingStudent(), SEED)
    assert isinstance(first.failure, AssertionError | TypeError)
    call, _ = runner.hidden_calls(lesson, student, SEED, [Check("test_second", "g", "", ""), OTHER])
    with pytest.raises((AssertionError, TypeError)):
        call()


def test_parameters_that_a_test_changes_are_new_in_each_run(make_lesson):
    hidden = """
import numpy as np

@pytest.mark.parametrize(("values", "rng"), [([1], np.random.default_rng(3))])
@pytest.mark.parametrize("module", [np])
@hidden("f", **about)
def test_changes_its_parameters(values, rng, module, student):
    values.append(rng.integers(1000))
    student.f(values)
"""
    lesson, students = make_lesson(hidden), [RecordingStudent(), RecordingStudent()]
    for student in students:
        assert failure_types(run_checks(lesson, student, SEED)) == {}
    assert students[0].calls == students[1].calls


def test_hidden_tests_are_collected_once_and_called_for_each_student(make_lesson, monkeypatch):
    hidden = """
@pytest.mark.parametrize("size", [1, 2])
@hidden("f", **about | {"title": "Size {}"})
def test_sizes(size, student, seed):
    student.f(size, seed)

@hidden("g", **about)
def test_nothing(*more, about=None, **others):
    pass
"""
    lesson, collections = make_lesson(hidden), []
    original = pytest.main
    monkeypatch.setattr(
        pytest,
        "main",
        lambda *about, **more: [collections.append(about), original(*about, **more)][1],
    )
    students = [RecordingStudent(), RecordingStudent()]
    titles = [
        [outcome.check.title for outcome in run_checks(lesson, student, SEED)]
        for student in students
    ]
    assert titles == [["Size 1", "Size 2", "A title"]] * 2
    assert students[0].calls == students[1].calls
    assert [size for _, _, size, _ in students[0].calls] == [1, 2]
    assert len(collections) == 1


@pytest.mark.parametrize("where", ["shown", "hidden"])
def test_a_lost_sandbox_is_reported(make_lesson, where):
    class LostStudent(RecordingStudent):
        def __getattr__(self, name):
            def ask(*arguments):
                raise SandboxUnavailable("it is gone")

            return ask if name in "fg" else super().__getattr__(name)

    if where == "hidden":
        lesson = make_lesson(TWO_TESTS)
    else:
        checks = [visible_check("one", "f", lambda function: function())]
        lesson = make_lesson('@hidden("g", **about)\ndef test_nothing(student): pass', checks)
    with pytest.raises(SandboxUnavailable, match="it is gone"):
        run_checks(lesson, LostStudent(), SEED)


def test_an_interrupt_in_a_hidden_test_ends_the_run(make_lesson):
    hidden = TWO_TESTS.replace('student.g("second")', "raise KeyboardInterrupt")
    with pytest.raises(KeyboardInterrupt):
        run_checks(make_lesson(hidden), RecordingStudent(), SEED)


# ---- time and size -------------------------------------------------------------------------------


def test_a_slow_comparison_is_interrupted_and_the_timer_restored(make_lesson, monkeypatch):
    monkeypatch.setattr(runner, "TEST_SECONDS", 0.05)
    # The loop would take seconds.
    hidden = TWO_TESTS.replace('student.g("second")', "for _ in range(10**8): pass")
    student, before = RecordingStudent(), signal.getsignal(signal.SIGPROF)
    outcomes = run_checks(make_lesson(hidden), student, SEED)
    assert failure_types(outcomes) == {"test_second": JudgeTimeout, "test_first": CheckFailed}
    assert student.closed == 1  # closed, because its process may have been sending a reply
    assert signal.getitimer(signal.ITIMER_PROF) == (0.0, 0.0)
    assert signal.getsignal(signal.SIGPROF) is before


@pytest.mark.filterwarnings("error")
def test_numbers_in_a_wrong_answer_cause_no_warnings(make_lesson):
    """Otherwise, they would be printed on the instructor's terminal."""
    overflow = "np.linalg.norm([1e300, 1e300]); np.sqrt(np.array(-1.0)); np.ones(1) / 0"
    hidden = TWO_TESTS.replace('student.g("second")', overflow)
    checks = [visible_check("shown", "g", lambda function: np.ones(1) / 0)]
    outcomes = run_checks(
        make_lesson(f"import numpy as np\n{hidden}", checks), RecordingStudent(), SEED
    )
    assert failure_types(outcomes) == {"test_first": CheckFailed}


def test_an_import_is_not_interrupted(make_lesson, monkeypatch, tmp_path):
    """A module whose import was interrupted would be unusable for all later students."""
    package = tmp_path / "slow_package"
    package.mkdir()
    (package / "part.py").write_text("VALUE = 7")
    slow = (
        "import slow_package.part\nfor _ in range(2 * 10**7): pass\nVALUE = slow_package.part.VALUE"
    )
    (package / "__init__.py").write_text(slow)
    monkeypatch.syspath_prepend(tmp_path)
    body = "import slow_package; student.g(slow_package.VALUE)"
    lesson = make_lesson(TWO_TESTS.replace('student.g("second")', body))
    with monkeypatch.context() as patch:
        patch.setattr(runner, "TEST_SECONDS", 0.05)
        run_checks(lesson, RecordingStudent(), SEED)
    student = RecordingStudent()
    assert "test_second" not in failure_types(run_checks(lesson, student, SEED))
    assert student.calls[0] == ("g", "g", 7)


def test_waiting_for_student_code_does_not_count_as_work_of_the_judge(make_lesson, monkeypatch):
    monkeypatch.setattr(runner, "TEST_SECONDS", 0.2)
    hidden = TWO_TESTS.replace('student.g("second")', "time.sleep(0.4)")
    assert "test_second" not in failure_types(
        run_checks(make_lesson(hidden), RecordingStudent(), SEED)
    )


def test_a_test_may_compute_for_seconds():
    assert 5 <= runner.TEST_SECONDS <= 60  # the slowest test of a right answer takes two seconds


def test_there_is_no_time_limit_in_another_thread(make_lesson):
    found = []
    lesson = make_lesson(TWO_TESTS)
    thread = threading.Thread(
        target=lambda: found.extend(run_checks(lesson, RecordingStudent(), SEED))
    )
    thread.start()
    thread.join()
    assert failure_types(found) == {"test_first": CheckFailed}


def test_checks_of_an_exercise_stop_after_five_huge_answers(make_lesson):
    def return_too_much(function):
        function()
        raise AnswerTooLarge("a million boxes")

    def wrong(function):
        raise WrongForm("no box")

    checks = [
        *(visible_check(f"wrong {number}", "f", wrong) for number in range(9)),
        *(visible_check(f"f{number}", "f", return_too_much) for number in range(7)),
        *(visible_check(f"g{number}", "g", return_too_much) for number in range(4)),
    ]
    student = RecordingStudent()
    found = failure_types(run_checks(make_lesson(TWO_TESTS, checks), student, SEED))
    tried = [name for name, failure in found.items() if failure is AnswerTooLarge]
    assert tried == ["f0", "f1", "f2", "f3", "f4", "g0", "g1", "g2", "g3"]
    assert [name for name, failure in found.items() if failure is StudentStopped] == [
        *("f5", "f6", "test_first"),
    ]
    assert "test_second" not in found  # test_second belongs to the other exercise
    assert len(student.calls) == 9 + 1


def test_a_failed_answer_of_too_many_bytes_counts_as_huge_in_any_form(make_lesson):
    student = RecordingStudent()

    def receive(size, right):
        student.calls.append(size)
        student.largest_reply = max(student.largest_reply, size)
        if not right:
            raise WrongForm("a text")

    def run(size, right):
        student.calls.clear()
        checks = [
            visible_check(f"{number}", "f", lambda _: receive(size, right)) for number in range(8)
        ]
        run_checks(make_lesson(TWO_TESTS, checks), student, SEED, lambda check: check.is_shown)
        return len(student.calls)

    assert run(runner.MAX_REPLY_BYTES + 1, right=False) == runner.MAX_TOO_LARGE
    assert run(runner.MAX_REPLY_BYTES, right=False) == 8
    assert run(runner.MAX_REPLY_BYTES + 1, right=True) == 8


def test_the_message_about_huge_answers_names_their_number(make_lesson):
    def return_too_much(function):
        raise AnswerTooLarge("a million boxes")

    checks = [visible_check(f"f{number}", "f", return_too_much) for number in range(6)]
    *_, last = run_checks(
        make_lesson(TWO_TESTS, checks), RecordingStudent(), SEED, lambda check: check.is_shown
    )
    assert str(last.failure).startswith("Not run: 5 answers to this exercise were far larger")


def test_slow_comparisons_of_wrong_answers_have_one_limit(make_lesson, monkeypatch):
    monkeypatch.setattr(runner, "TEST_SECONDS", 0.3)

    def pass_slowly(function):
        function()
        compute(0.12)

    def compute_and_fail(function):
        pass_slowly(function)
        raise CheckFailed("no")

    right = [visible_check(f"right {number}", "g", pass_slowly) for number in range(3)]
    wrong = [visible_check(f"wrong {number}", "f", compute_and_fail) for number in range(6)]
    student = RecordingStudent()
    outcomes = run_checks(
        make_lesson(TWO_TESTS, [*right, *wrong]), student, SEED, lambda check: check.is_shown
    )
    # The third comparison is interrupted when the limit for all of them is reached.
    assert [*failure_types(outcomes).values()] == [
        *2 * [CheckFailed],
        JudgeTimeout,
        *3 * [StudentStopped],
    ]
    (last,) = (outcome.failure for outcome in outcomes if outcome.check.name == "wrong 5")
    assert str(last).startswith("Not run: comparing earlier answers")


def compute(seconds):
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


def test_all_runs_with_one_budget_share_the_limit_on_failed_comparisons(make_lesson):
    """The last failed check may only use the rest of the time; other exercises are unaffected."""

    def wrong(function):
        compute(10)
        raise CheckFailed("no")

    checks = [
        visible_check("f0", "f", wrong),
        visible_check("f1", "f", wrong),
        visible_check("g", "g", lambda _: None),
    ]
    lesson, budget, start = make_lesson(TWO_TESTS, checks), Budget(Limits()), time.process_time()
    budget.judge_seconds["f"] = runner.TEST_SECONDS - 0.05
    run = (lesson, RecordingStudent(), SEED, lambda check: check.is_shown, True, budget)
    assert failure_types(run_checks(*run)) == {"f0": JudgeTimeout, "f1": StudentStopped}
    assert failure_types(run_checks(*run)) == {"f0": StudentStopped, "f1": StudentStopped}
    assert time.process_time() - start < 5
    assert budget.judge_seconds["g"] == 0


def test_only_failed_checks_use_up_the_time_for_failed_calls(make_lesson):
    """A correct function keeps its full time limit, even if it is slow."""
    budget = Budget(Limits())

    class SlowStudent(RecordingStudent):
        def __getattr__(self, name):
            def spend():
                budget.seconds -= 3

            return spend if name in "fg" else super().__getattr__(name)

    def fail(function):
        function()
        sum(range(10**6))  # takes longer than one tick of the kernel's clock
        raise CheckFailed("no")

    checks = [
        visible_check(f"{name} {number}", name, run)
        for number in range(4)
        for name, run in (("g", lambda function: function()), ("f", fail))
    ]
    run_checks(
        make_lesson(TWO_TESTS, checks),
        SlowStudent(),
        SEED,
        lambda check: check.is_shown,
        budget=budget,
    )
    assert budget.failed_seconds == {"f": 12}
    assert budget.judge_seconds["f"] > 0 == budget.judge_seconds["g"]


# ---- memory --------------------------------------------------------------------------------------


class Answer:
    """An answer that supports weak references."""


@pytest.mark.parametrize("how", ["CheckFailed('no')", "ZeroDivisionError", "WrongForm('no')"])
def test_no_answer_outlives_its_check(make_lesson, how):
    """Outcomes, cached preconditions and pytest keep neither frames nor drawings of a failure."""
    answers = weakref.WeakSet()

    def answer():
        made = Answer()
        answers.add(made)
        return made

    @once_per_run
    def require(function):
        with precondition("an answer"):
            kept = answer()
            function(kept is not None)
            raise CheckFailed("no", draw=lambda: kept)

    def check(function):
        kept = answer()
        try:
            raise KeyError(id(kept))
        except KeyError:
            raise CheckFailed("no", draw=lambda: kept)  # noqa: B904, the context is the KeyError

    checks = [
        visible_check("one", "f", require),
        visible_check("two", "f", require),
        visible_check("three", "f", check),
    ]
    hidden = f"""
from utils.checks.failures import WrongForm
@hidden("g", **about)
def test_second(student):
    kept = student.g()
    raise {how}
"""

    class AnsweringStudent(RecordingStudent):
        def __getattr__(self, name):
            return lambda *_: answer()

    student = AnsweringStudent()
    with cached_run():
        outcomes = run_checks(make_lesson(hidden, checks), student, SEED)
        gc.collect()
        assert len(failure_types(outcomes)) == 4 and len(answers) == 0


def test_the_traceback_of_a_fault_is_kept_as_text(make_lesson):
    (outcome,) = run_checks(
        make_lesson('@hidden("f", **about)\ndef test_first(student):\n    1 / 0\n'),
        RecordingStudent(),
        SEED,
    )
    assert outcome.failure.__traceback__ is None
    assert "in test_first\n    1 / 0" in outcome.failure.__notes__[0]


def test_an_answer_larger_than_any_right_one_is_not_cached():
    asked = []

    def function(cloud):
        asked.append(len(cloud))
        return np.zeros(MAX_NUMBERS + len(cloud) - 1)

    with cached_run():
        for rows in (1, 1, 2, 2):
            answer_to(function, rows, np.zeros(rows))
    assert asked == [1, 2, 2]


# ---- independence from the environment -----------------------------------------------------------


def test_each_lesson_has_its_own_seed_of_120_bits(make_lesson):
    hidden = """
@hidden("f", **about)
def test_seed(student, seed):
    student.f(seed)
"""
    student, lesson = RecordingStudent(), make_lesson(hidden)
    run_checks(lesson, student, SEED)
    run_checks(lesson, student, SEED + 1)
    run_checks(lesson, student, SEED)
    seeds = [seed for *_, seed in student.calls]
    digest = hashlib.sha256(f"{SEED} test_06_made_here.py".encode()).hexdigest()
    assert seeds[0] == seeds[2] == int(digest[:30], 16) != seeds[1]


def test_pytest_settings_and_neighbouring_files_have_no_effect(make_lesson, monkeypatch):
    settings = {
        "PYTEST_ADDOPTS": "-k nothing",
        "PYTEST_PLUGINS": "no_such_plugin",
        "PY_COLORS": "1",
    }
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    before = dict(os.environ)
    lesson = make_lesson(TWO_TESTS)
    (lesson.tests.parent / "conftest.py").write_text("raise SystemError('read')")
    assert len(run_checks(lesson, RecordingStudent(), SEED)) == 2
    assert dict(os.environ) == before
    assert "PYTEST_DISABLE_PLUGIN_AUTOLOAD" not in os.environ


# ---- running a program --------------------------------------------------------------------------


@pytest.fixture
def run_once(monkeypatch):
    """Return a function that calls `run_program` with given outcomes, and a record of the calls."""
    seen = SimpleNamespace(diagnosed=[], closed=[])

    class FakeStudent(SimpleNamespace):
        def __enter__(self):
            return self

        def __exit__(self, *error):
            seen.closed.append(error[0])

        def close(self):
            seen.closed.append("by the diagnosis")

        def __getattr__(self, name):
            return f"the student's {name}"

    def run_with(ended, explains=None, context=CONTEXT, **options):
        def run(*about):
            if isinstance(ended, Exception):
                raise ended
            return ended

        def diagnose(exercise, function):
            seen.diagnosed.append((exercise, function, fake_student.exercise))
            return explains() if callable(explains) else explains

        fake_student = FakeStudent(problems=["a cell"], uses={"f": ("g",)}, exercise="")
        monkeypatch.setattr(program_run, "StudentProxy", lambda *about: fake_student)
        monkeypatch.setattr(program_run, "run_checks", run)
        monkeypatch.setattr(program_run, "diagnose", diagnose)
        return program_run.run_program(context, None, **options)

    return run_with, seen


ENDED = [
    Outcome(Check("a", "f", "", ""), None),
    Outcome(Check("b", "f", "", ""), WrongForm("no")),
    Outcome(Check("c", "f", "", ""), FAILURE),
    Outcome(Check("d", "g", "", ""), StudentStopped("It did not answer.")),
    Outcome(Check("e", "h", "", ""), FAILURE),
]


def test_each_wrong_exercise_is_explained_once(run_once):
    run_with, seen = run_once
    mistake = Mistake("It is upside down.", predict=np.flip)
    results = run_with(ENDED, mistake, explain=True)
    assert results.outcomes == tuple(ENDED) and results.mistakes == {"f": mistake, "h": mistake}
    assert seen.diagnosed == [(name, f"the student's {name}", name) for name in "fh"]
    assert (results.problems, results.uses) == (("a cell",), {"f": ("g",)})
    assert results.fault == "" and seen.closed == [None, None]
    assert [outcome.check.name for outcome in results.outcomes_of("f")] == ["a", "b", "c"]
    assert [outcome.check.name for outcome in results.outcomes_of("g")] == ["d"]


def test_outcomes_of_an_exercise_are_found_by_an_equal_name():
    """Names are compared by value: a notebook's and a test's may be different objects."""
    outcomes = [Outcome(Check("a", "voxel_grid", "", ""), FAILURE)]
    results = program_run.RunResults(tuple(outcomes))
    assert results.outcomes_of("".join(("voxel", "_grid"))) == outcomes
    assert results.fault == ""


def test_an_unexplained_failure_is_diagnosed_once(run_once):
    run_with, seen = run_once
    assert run_with(ENDED, None, explain=True).mistakes == {}
    assert [name for name, *_ in seen.diagnosed] == ["f", "h"]


def test_diagnosis_is_only_on_request(run_once):
    run_with, seen = run_once
    assert run_with(ENDED, Mistake("It is upside down.", np.flip)).mistakes == {}
    assert seen.diagnosed == []


def test_a_diagnosis_may_use_the_rest_of_the_time_for_failed_comparisons(run_once):
    run_with, seen = run_once
    budget = Budget(Limits())
    budget.judge_seconds.update(f=runner.TEST_SECONDS, h=runner.TEST_SECONDS - 0.05)
    context = program_run.JudgingContext(FILTER, SEED, None, None, budget)
    results = run_with(ENDED, lambda: compute(10), context, explain=True)
    assert results.mistakes == {} and [name for name, *_ in seen.diagnosed] == ["h"]
    assert seen.closed == [None, "by the diagnosis", None]
    assert 0.02 < budget.judge_seconds["h"] - (runner.TEST_SECONDS - 0.05) < 5


def test_a_fault_is_recorded_and_the_process_stopped(run_once):
    run_with, seen = run_once
    results = run_with(JudgeFault("pytest ran 3 of 9 tests"), explain=True)
    assert (results.outcomes, results.fault) == ((), "pytest ran 3 of 9 tests")
    assert results.problems == ("a cell",) and seen.closed == [None]
    with pytest.raises(SandboxUnavailable):
        run_with(SandboxUnavailable("it is gone"))
    assert seen.closed[1] is SandboxUnavailable


def test_results_and_settings_are_immutable(run_once):
    run_with, _ = run_once
    for made in (run_with(ENDED), program_run.JudgingContext(FILTER, SEED, None)):
        with pytest.raises(dataclasses.FrozenInstanceError):
            made.budget = None


@pytest.mark.slow
def test_visible_checks_run_before_hidden_tests(lesson):
    """Otherwise, a function could store a hidden test's input and reveal it in a visible check."""

    def stub(*arguments, **keywords):
        raise NotImplementedError

    student = SimpleNamespace(**dict.fromkeys(lesson.names, stub), exercise="")
    visible = [outcome.check.is_shown for outcome in run_checks(lesson, student, SEED)]
    assert visible == sorted(visible, reverse=True) and set(visible) == {True, False}
