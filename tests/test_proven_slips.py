"""The strict rules by which the judge proves a single slip, tested with stand-ins."""

import copy
import functools
import itertools
import operator
import time
from types import SimpleNamespace

import numpy as np
import pytest

from grader.course import rules
from grader.course.lessons import all_lessons, find_lesson, lesson_of, load_reference
from grader.intake.preflight import cells_as_released
from grader.judging import mistake_diagnosis, repair, results
from grader.judging.error_carried_forward import CarriedForwardResult
from grader.judging.program_run import JudgingContext, RunResults
from grader.judging.runner import run_checks
from grader.judging.verdict import Slip
from grader.sandbox import Limits, time_budget
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.program import Program
from grader.sandbox.student import CALL_TIMEOUT
from grader.sandbox.time_budget import Budget
from tests.students import student_with
from utils.checks import Check, checks_of, diagnosis
from utils.checks.diagnosis import Mistake, imitation_of, known_mistakes
from utils.checks.failures import CheckFailed, WrongForm
from utils.checks.outcomes import Outcome
from utils.checks.run_cache import once_per_run

LINE = find_lesson("02_ransac_line")
FAIL = CheckFailed("no")
HANGS = StudentError("line_through", CALL_TIMEOUT)
SUBMITTED, REPAIRED = Program(("a",), ()), Program(("b",), ())
SETTING = JudgingContext(LINE, 1, None)
PLACES = ("1, line 3", "2")
RAISED = [StudentError("f", "ValueError", place=f"code cell {place}") for place in PLACES]


def outcomes_of(exercise, *failures):
    return tuple(
        Outcome(Check(f"{exercise} {number}", exercise, "a title", "a hint"), failure)
        for number, failure in enumerate(failures)
    )


FAILED = outcomes_of("line_through", FAIL)


# ---- which answers are tried --------------------------------------------------------------------


@pytest.fixture
def repair_calls(monkeypatch):
    """Replace `find_repair` with a function that finds nothing; return a list of its calls."""
    found = []

    def find_repair(setting, program, exercise, failed, search_limits):
        assert all(outcome.failure for outcome in failed)
        assert search_limits in (repair.SEARCH_WITHOUT_POINTS, repair.FULL_SEARCH)
        found.append((program, exercise, [outcome.check.name for outcome in failed]))

    monkeypatch.setattr(repair, "find_repair", find_repair)
    monkeypatch.setattr(repair, "mistake_explains", lambda *about: False)
    return found


def test_an_exercise_that_lost_points_is_tried_with_its_failed_checks(repair_calls):
    run = RunResults(
        (*outcomes_of("line_through", None, FAIL, FAIL), *outcomes_of("ransac_line", None))
    )
    assert repair.find_slips(SETTING, SUBMITTED, run, {}) == {}
    assert repair_calls == [(SUBMITTED, "line_through", ["line_through 1", "line_through 2"])]


def test_a_function_that_calls_a_wrong_one_is_tried_with_a_right_one(repair_calls):
    run = RunResults(outcomes_of("ransac_line", FAIL, FAIL, FAIL))
    carried = {
        "ransac_line": CarriedForwardResult(
            outcomes_of("ransac_line", None, FAIL, None), "", REPAIRED
        )
    }
    repair.find_slips(SETTING, SUBMITTED, run, carried)
    assert repair_calls == [(REPAIRED, "ransac_line", ["ransac_line 1"])]
    right = {
        "ransac_line": CarriedForwardResult(
            outcomes_of("ransac_line", None, None, None), "", REPAIRED
        )
    }
    repair.find_slips(SETTING, SUBMITTED, run, right)
    assert len(repair_calls) == 1


@pytest.mark.parametrize("name", ["NotImplementedError", "ImportError"])
def test_stubs_and_forbidden_imports_are_not_tried(repair_calls, name):
    stub = StudentError("line_through", name)
    repair.find_slips(
        SETTING, SUBMITTED, RunResults(outcomes_of("line_through", None, stub, FAIL)), {}
    )
    assert repair_calls == []
    wrong = StudentError("line_through", "KeyError")
    repair.find_slips(SETTING, SUBMITTED, RunResults(outcomes_of("line_through", wrong, FAIL)), {})
    assert len(repair_calls) == 1


def slip(*about, **more):
    return Mistake("This is a slip.", print, *about, **more)


@pytest.mark.parametrize("kind", ["is_cheap", "is_the_task"])
def test_some_mistakes_are_slips_only_if_an_edit_proves_them(repair_calls, monkeypatch, kind):
    monkeypatch.setattr(repair, "mistake_explains", lambda *about: True)
    named, cheap = slip(), slip(**{kind: True})
    outcomes = (*outcomes_of("line_through", FAIL), *outcomes_of("ransac_line", FAIL))
    run = RunResults(outcomes, mistakes={"line_through": cheap, "ransac_line": named})
    assert repair.find_slips(SETTING, SUBMITTED, run, {}) == {"ransac_line": named}
    assert [exercise for _, exercise, _ in repair_calls] == ["line_through", "ransac_line"]


def test_a_course_may_switch_slips_off(repair_calls, monkeypatch):
    monkeypatch.setattr(repair, "ONE_SLIP_KEEPS", 0)
    repair.find_slips(SETTING, SUBMITTED, RunResults(outcomes_of("line_through", FAIL)), {})
    assert repair_calls == []


def test_a_named_mistake_may_explain_an_answer_that_no_edit_repairs(repair_calls, monkeypatch):
    calls = []

    def explains(setting, program, exercise, mistake, lost):
        calls.append((setting, program, exercise, {check.name for check in lost}))
        return mistake is named

    monkeypatch.setattr(repair, "mistake_explains", explains)
    named, other = slip(), slip()
    outcomes = (*outcomes_of("line_through", FAIL, None, FAIL), *outcomes_of("ransac_line", FAIL))
    run = RunResults(outcomes, mistakes={"line_through": named, "ransac_line": other})
    assert repair.find_slips(SETTING, SUBMITTED, run, {}) == {"line_through": named}
    assert calls == [
        (SETTING, SUBMITTED, "line_through", {"line_through 0", "line_through 2"}),
        (SETTING, SUBMITTED, "ransac_line", {"ransac_line 0"}),
    ]
    # A mistake found with a wrong helper does not explain the answers with a right helper.
    carried = {
        "line_through": CarriedForwardResult(outcomes_of("line_through", FAIL), "", REPAIRED)
    }
    assert repair.find_slips(SETTING, SUBMITTED, run, carried) == {}


def test_an_edit_is_preferred_to_a_named_mistake(monkeypatch):
    found = repair.Repair(1, 2, "a", "b")
    monkeypatch.setattr(repair, "find_repair", lambda *about: found)
    run = RunResults(outcomes_of("line_through", FAIL), mistakes={"line_through": slip()})
    assert repair.find_slips(SETTING, SUBMITTED, run, {}) == {"line_through": found}
    assert repair.Repair.__dataclass_params__.frozen


# ---- which edits pass the failed checks ---------------------------------------------------------


class EditedStudent:
    """A stand-in for a student; its failures without and with each edit are predefined.

    Parameters
    ----------
    fails : list of str
        The failures without an edit, then with edits 0, 1, and so on. Letters stand for failures:
        "e" for the edit itself, "a" and "b" for two visible checks, "x" and "y" for two hidden
        tests. A capital letter means that the call hangs.
    seconds : float
        Processor seconds for each edit that is tried.
    stops : bool
        Whether the notebook's process stops before it has started.
    slept : float
        Seconds of the notebook's time budget that each edit spends without using a processor.
    judge_seconds : float, optional
        Processor seconds of the judge for each edit; by default the same as the student's.
    """

    def __init__(self, fails, seconds=0.0, stops=False, slept=0.0, judge_seconds=None):
        self.judge_seconds = seconds if judge_seconds is None else judge_seconds
        self.judged_seconds = 50.0
        self.fails, self.seconds, self.stops = fails, seconds, stops
        self.now, self.tried, self.hidden_made = fails[0], 0, 0
        self.failed_seconds, self.slept, self.given = [], slept, []
        self.edits = [(1, number, number, f"edit {number}") for number in range(len(fails) - 1)]

    def __call__(self, program, sandbox, limits, budget, counted_as):
        self.program, self.limits, self.budget, self.counted_as = (
            program,
            limits,
            budget,
            counted_as,
        )
        return self

    def __enter__(self):
        return self

    def __exit__(self, *about):
        self.closed = True

    def start(self):
        if self.stops:
            raise StudentStopped("It takes too long.")

    @property
    def cpu_seconds(self):
        return self.seconds * self.tried

    def edit(self, number):
        self.tried += 1
        self.now, self.edit_failed = self.fails[number + 1], False
        self.budget.seconds -= self.slept

    def answer(self, letter):
        self.given.append((letter, self.interrupts_after))
        if "e" in self.now:  # even a check that expects an error does not pass
            self.edit_failed = True
        if letter.upper() in self.now:
            raise HANGS
        if letter in self.now:
            self.budget.add_failed_seconds(self.exercise, 0.3)
            raise FAIL

    def calls(self, letters):
        return tuple(functools.partial(self.answer, letter) for letter in letters)

    def hidden(self, lesson, student, seed, failed):
        assert (lesson, student, seed) == (LINE, self, 1)
        self.failed_seconds.append(self.budget.failed_seconds.get(self.exercise, 0.0))
        self.hidden_made += 1
        return self.calls("xy")


@pytest.fixture
def passing_edits(monkeypatch):
    """Return a function that returns the numbers of the edits after which a student passes."""

    def passing(
        student,
        visible_checks="ab",
        limits=None,
        failed=FAILED,
        clock=lambda: 100.0,
        budget=None,
        meanwhile=lambda: None,
        search_limits=repair.FULL_SEARCH,
    ):
        monkeypatch.setattr(repair, "StudentProxy", student)
        monkeypatch.setattr(repair, "visible_calls", lambda *about: student.calls(visible_checks))
        monkeypatch.setattr(repair, "hidden_calls", student.hidden)
        monkeypatch.setattr(
            repair.time,
            "process_time",
            lambda: student.judged_seconds + student.judge_seconds * student.tried,
        )
        monkeypatch.setattr(repair.time, "monotonic", clock)
        setting = JudgingContext(LINE, 1, None, limits, budget)
        found = []
        edits = repair._passing_edits(setting, SUBMITTED, "line_through", failed, search_limits)
        for edit in edits:
            found.append(edit)
            meanwhile()
        assert student.closed and all(edit == student.edits[edit[1]] for edit in found)
        return [number for _, number, _, _ in found]

    return passing


def test_an_edit_passes_if_all_failed_visible_and_hidden_checks_pass(passing_edits):
    student = EditedStudent(["abxy", "e", "a", "b", "x", "y", "", "abxy"])
    assert passing_edits(student) == [5]
    assert student.hidden_made == 1 and student.tried == 7
    assert (student.program, student.counted_as) == (SUBMITTED, "line_through")
    # Hanging calls of an edited answer must not shorten the limits of the unedited answer.
    assert student.exercise not in ("line_through", "")
    assert passing_edits(EditedStudent(["xy", "x", ""]), visible_checks="") == [1]


def test_hidden_tests_are_made_only_if_visible_checks_pass(passing_edits):
    student = EditedStudent(["abxy", "a", "b", "e"])
    assert passing_edits(student) == [] and student.hidden_made == 0


def test_an_edit_that_hangs_in_a_hidden_test_is_judged(passing_edits):
    student = EditedStudent(["abxy", "B", "x", "X", "y", "Y", ""])
    assert passing_edits(student) == [2, 4, 5]


def test_an_answer_that_passes_when_repeated_gets_no_edits(passing_edits):
    student = EditedStudent(["bxy", "", ""])
    assert passing_edits(student) == [] and student.tried == 0
    # Only the first check is repeated.
    assert passing_edits(EditedStudent(["axy", ""])) == [0]


def test_an_answer_gets_no_edits_if_its_first_hidden_test_passes_when_repeated(passing_edits):
    student = EditedStudent(["y", "", ""])
    assert passing_edits(student, visible_checks="") == [] and student.tried == 0


def test_other_edits_get_less_time_for_the_first_check_after_a_hang(passing_edits):
    student = EditedStudent(["abxy", "a", "bx", "A", "b", "A", ""])
    assert passing_edits(student) == [5]
    long, short = repair.CALL_SECONDS, repair.SHORT_CALL_SECONDS
    assert repair.SHORTEST_CALL_SECONDS < short < long / 3
    first_times = [seconds for letter, seconds in student.given if letter == "a"]
    # The first limit applied to the answer without an edit.
    assert first_times == [long, long, long, long, short, short, short]
    assert {seconds for letter, seconds in student.given if letter in "bxy"} == {long}
    # If the answer itself hangs, so do most of its edits, so all edits have short limits.
    student = EditedStudent(["Abxy", "A", ""])
    assert passing_edits(student) == [1]
    shortest = repair.SHORTEST_CALL_SECONDS
    given = [seconds for letter, seconds in student.given if letter == "a"]
    assert given == [long, shortest, shortest]


def test_cached_results_of_one_edit_are_not_used_for_the_next(passing_edits, monkeypatch):
    student = EditedStudent(["abxy", "a", "b", "b", ""])

    @once_per_run
    def passes_b(function):
        if "b" in student.now:
            raise FAIL

    monkeypatch.setattr(student, "calls", lambda letters: [lambda: passes_b(student)])
    student.__name__ = "line_through"
    assert passing_edits(student) == [0, 3]


def test_interrupted_calls_count_as_hanging_and_raised_exceptions_do_not():
    name = (CALL_TIMEOUT + " ").strip()  # equal but not identical, as if from another process
    assert repair._was_stopped(StudentError("f", name))
    assert repair._was_stopped(StudentStopped("It is gone."))
    others = (None, FAIL, StudentError("f", "IndexError"), StudentError("f", "ZeroDivisionError"))
    assert not any(map(repair._was_stopped, others))


def test_a_hang_is_recognised_inside_a_checks_own_failure():
    failures = []
    for error in (StudentStopped("It did not answer."), StudentError("f", "IndexError")):
        try:
            try:
                raise error
            except Exception as original:
                raise CheckFailed(f"60,000 points. {original}") from None
        except CheckFailed as failure:
            failures.append(failure)
    assert list(map(repair._was_stopped, failures)) == [True, False]


def test_only_three_passing_edits_are_judged(passing_edits):
    student = EditedStudent(["abxy", "", "a", "", "", "", ""])
    assert passing_edits(student) == [0, 2, 3] and student.tried == 4


def test_an_unchanged_released_cell_is_not_edited(passing_edits, monkeypatch):
    given = next(cell for cell in cells_as_released(LINE) if cell.kind == "code")
    monkeypatch.setitem(globals(), "SUBMITTED", Program((given.source, "x = 1"), ()))
    student = EditedStudent(["abxy", "", "", ""])
    student.edits = [(cell, number, number, "") for number, cell in enumerate((1, 2, 1))]
    assert passing_edits(student) == [1] and student.tried == 1


def test_an_edit_of_a_line_that_raised_is_tried_first(passing_edits):
    student = EditedStudent(["abxy", "", "", "", "", ""])
    assert passing_edits(student, failed=outcomes_of("line_through", *RAISED)) == [3, 0, 1]


def test_raising_lines_include_the_line_of_the_call():
    inside = StudentError("f", "ValueError", place="code cell 3, line 12")
    called = StudentError(
        "f", "ValueError", place="code cell 1, line 2", call_place="code cell 3, line 5"
    )
    without_place = StudentError("f", "ValueError")
    outcomes = outcomes_of("line_through", inside, called, without_place, FAIL, None)
    assert repair._raising_lines(outcomes) == {(3, 12), (1, 2), (3, 5)}


@pytest.mark.parametrize(
    "seconds, tried",
    [
        (0.0, 400),
        (0.002, 400),  # 1.6 s
        (0.01, 320),  # 6.4 s
        (0.05, 176),  # 160 edits take 16 s; the time is checked after 16 more
    ],
)
def test_edits_are_tried_until_the_time_is_over(passing_edits, seconds, tried):
    student = EditedStudent(["abxy"] * 401, seconds)  # the judge takes as long again
    assert passing_edits(student) == [] and student.tried == tried


def test_the_search_is_shorter_if_the_mark_cannot_change(passing_edits, monkeypatch):
    student = EditedStudent(["abxy"] * 401, 0.01)
    passing_edits(student, search_limits=repair.SEARCH_WITHOUT_POINTS)
    assert student.tried == 112  # 100 edits take 2 s; the time is checked after 12 more
    given = []
    monkeypatch.setattr(repair, "find_repair", lambda *about: given.append(about[-1]))
    for passed in (1, 2):
        outcomes = outcomes_of("line_through", *[None] * passed, FAIL)
        repair.find_slips(SETTING, SUBMITTED, RunResults(outcomes), {})
    assert given == [repair.FULL_SEARCH, repair.SEARCH_WITHOUT_POINTS]


@pytest.mark.parametrize("seconds", ["failed_seconds", "judge_seconds"])
def test_the_search_is_shorter_if_the_answer_has_used_up_its_time(monkeypatch, seconds):
    given, budget = [], Budget(Limits())
    monkeypatch.setattr(repair, "find_repair", lambda *about: given.append(about[-1]))
    for used in (9.9, 10.0):
        getattr(budget, seconds).update(line_through=used)
        context = JudgingContext(LINE, 1, None, None, budget)
        repair.find_slips(context, SUBMITTED, RunResults(FAILED), {})
        getattr(budget, seconds).clear()
    assert given == [repair.FULL_SEARCH, repair.SEARCH_IN_SLOW_CODE]


def test_a_fixed_number_of_edits_of_slow_code_is_tried(passing_edits):
    """Each edit is interrupted after the shortest time, so a busy machine changes nothing."""
    slow = repair.SEARCH_IN_SLOW_CODE
    for seconds in (repair.SHORTEST_CALL_SECONDS, 0.0165):
        student = EditedStudent(["Abxy", *["A"] * 400], seconds, judge_seconds=0.0)
        assert passing_edits(student, search_limits=slow) == [] and student.tried == 128
    student = EditedStudent(["Abxy", *["A"] * 400], 0.2, judge_seconds=0.0)
    assert passing_edits(student, search_limits=slow) == [] and student.tried == 32


def test_judging_an_edit_does_not_shorten_the_search(passing_edits):
    student = EditedStudent(["abxy", "", *["a"] * 100, ""], judge_seconds=0.0)

    def judge_it():
        student.judged_seconds += 100.0

    assert passing_edits(student, meanwhile=judge_it) == [0, 101]


def test_the_judges_time_does_not_decide_about_further_edits(passing_edits):
    student = EditedStudent(["abxy"] * 401, 0.002, judge_seconds=0.02)
    assert passing_edits(student) == [] and student.tried == 400


def test_waiting_for_a_processor_does_not_end_the_search(passing_edits, monkeypatch):
    """Each edit waits for a minute, so all edits together exceed the limits on elapsed time."""
    monkeypatch.setattr(time_budget, "own_seconds", lambda: 0.0)
    now, budget = [100.0], Budget(Limits())
    student = EditedStudent(["abxy", *["a"] * 300, ""])
    try_edit = student.edit

    def wait(number):
        now[0] += 60.0
        budget.postpone_deadline(60.0)
        try_edit(number)

    student.edit = wait
    assert passing_edits(student, clock=lambda: now[0], budget=budget) == [300]
    assert not budget.starved


def test_the_time_is_checked_after_each_slow_edit(passing_edits):
    seconds = itertools.count(100.0)
    student = EditedStudent(["abxy"] * 200, 1.3)  # the judge takes as long again
    assert passing_edits(student, clock=lambda: next(seconds)) == [] and student.tried == 7


def test_calls_are_limited_to_the_time_of_a_right_answer(passing_edits):
    student = EditedStudent(["abxy", ""])
    passing_edits(student)
    limits = Limits(call_seconds=2 * repair.CALL_SECONDS, restarts=repair.MAX_RESTARTS)
    assert student.limits == limits and 0.1 < limits.call_seconds < 1
    passing_edits(student, limits=Limits(call_seconds=0.1, memory=7))
    assert (student.limits.call_seconds, student.limits.memory) == (0.1, 7)


def test_edits_use_the_notebooks_remaining_time(passing_edits):
    budget = Budget(Limits())
    student = EditedStudent(["abxy"] * 100, slept=0.56)  # nine seconds pass between two time checks
    assert (
        passing_edits(student, budget=budget) == [] and student.tried == 2 * repair.EDITS_PER_POLL
    )
    assert student.budget is budget
    assert budget.seconds == pytest.approx(180 - 0.56 * 2 * repair.EDITS_PER_POLL)
    # Time between edits does not count, for example the time for judging an edit completely.
    student = EditedStudent(["abxy", *["", "a"] * 40], slept=0.01)

    def judge_it():
        budget.seconds -= 5

    passes = passing_edits(
        student, clock=itertools.count(1).__next__, budget=budget, meanwhile=judge_it
    )
    assert passes == [0, 2, 4]


def test_wall_clock_time_ends_the_search_in_any_case(passing_edits):
    clock = itertools.count(100.0)
    student, budget = EditedStudent(["abxy"] * 500), Budget(Limits())
    assert passing_edits(student, clock=lambda: next(clock), budget=budget) == []
    assert 10 < student.tried < repair.MAX_SECONDS
    assert budget.starved, "the machine was busy, so the notebook deserves another try"


def test_time_lost_by_one_edit_does_not_count_for_the_next(passing_edits):
    student = EditedStudent(["abxy", "x", "e", "x", "a", ""])
    assert passing_edits(student) == [4] and student.failed_seconds == [0.0]


def test_a_notebook_whose_cells_never_end_is_not_started_again(repair_calls):
    run = RunResults(outcomes_of("line_through", FAIL))
    budget = Budget(Limits())
    setting = JudgingContext(LINE, 1, None, None, budget)
    repair.find_slips(setting, SUBMITTED, run, {})
    assert len(repair_calls) == 1
    budget.cells_finish = False
    assert repair.find_slips(setting, SUBMITTED, run, {}) == {} and len(repair_calls) == 1


def test_a_notebook_that_does_not_start_has_no_edits(passing_edits):
    assert passing_edits(EditedStudent(["abxy", ""], stops=True)) == []


def test_edits_that_end_a_loop_come_first_after_a_hang():
    texts = ("x = 1", "x = 1\n        return", "pass", "break", "return x", "return")
    edits = [(1, 1, 1, text) for text in texts]
    hangs = outcomes_of("line_through", FAIL, StudentStopped("It did not answer."))
    assert [number for number, _ in repair._sort_by_likelihood(edits, hangs)] == [1, 3, 5, 0, 2, 4]
    fails = outcomes_of("line_through", FAIL)
    assert [number for number, _ in repair._sort_by_likelihood(edits, fails)] == [0, 1, 2, 3, 4, 5]


def test_edits_that_return_a_value_come_first_after_none_was_returned():
    texts = ("x = 1", "    return x", "return", "y = 1\nreturn y", "return y")
    edits = [(1, 1, 1, text) for text in texts]
    nothing = outcomes_of("line_through", FAIL, WrongForm("It returned None.", yours="None"))
    assert [number for number, _ in repair._sort_by_likelihood(edits, nothing)] == [1, 4, 0, 2, 3]
    something = outcomes_of("line_through", FAIL, WrongForm("It is a list.", yours="[None]"))
    assert [number for number, _ in repair._sort_by_likelihood(edits, something)] == [0, 1, 2, 3, 4]


def test_edits_of_a_line_that_raised_come_first():
    elsewhere = [(1, 3, 3), (2, 1, 2), (2, 4, 4), (3, 3, 3)]
    raising = [(2, 3, 3), (2, 2, 4), (2, 3, 5), (2, 1, 3)]
    edits = [(*lines, "text") for pair in zip(elsewhere, raising, strict=True) for lines in pair]
    errors = (StudentError("f", "E", place=f"code cell {lines}") for lines in ("2, line 3", "7"))
    ordered = repair._sort_by_likelihood(edits, outcomes_of("line_through", FAIL, *errors))
    assert [number for number, _ in ordered] == [1, 3, 5, 7, 0, 2, 4, 6]
    assert all(edits[number] == edit for number, edit in ordered)


# ---- which edit makes an answer right -----------------------------------------------------------

CELL = "first\nsecond\nthird\nfourth"
PROGRAM = Program(("import numpy", CELL, "fifth\nsixth"), ("line_through",))


@pytest.fixture
def find_repair_with(monkeypatch):
    """Return a function that searches for a repair; each run with an edit has a given result.

    The function returns the repair and a list of the runs.
    """

    def judged_as(*tries):
        runs, waiting = [], list(tries)

        def run(setting, program, wanted, keep_going):
            assert not keep_going  # because one failure disproves an edit
            names = ("line", "line_through", "ransac_line")
            checks = [Check("a", "".join(name), "a title", "a hint") for name in names]
            runs.append((program.cells, [check.exercise for check in checks if wanted(check)]))
            return waiting.pop(0)

        edits = [(2, 2, 3, "fixed"), (2, 1, 1, "1st\nhalf"), (2, 4, 4, "4th"), (3, 2, 2, "6th")]
        monkeypatch.setattr(repair, "run_program", run)
        monkeypatch.setattr(repair, "_passing_edits", lambda *about: iter(edits))
        return repair.find_repair(SETTING, PROGRAM, "".join(["line_", "through"]), ()), runs

    return judged_as


RIGHT, WRONG = (RunResults(outcomes_of("line_through", None, failure)) for failure in (None, FAIL))


def test_the_first_edit_that_loses_nothing_is_the_repair(find_repair_with):
    found, runs = find_repair_with(RIGHT)
    assert found == repair.Repair(2, 2, "second\nthird", "fixed")
    cells_after = ("import numpy", "first\nfixed\nfourth", "fifth\nsixth")
    assert runs == [(cells_after, ["line_through"])]
    found, runs = find_repair_with(WRONG, RIGHT)
    assert found == repair.Repair(2, 1, "first", "1st\nhalf")
    assert [cells[1] for cells, _ in runs] == [cells_after[1], CELL.replace("first", "1st\nhalf")]
    assert find_repair_with(WRONG, WRONG, RIGHT)[0] == repair.Repair(2, 4, "fourth", "4th")
    assert find_repair_with(WRONG, WRONG, WRONG, RIGHT)[0] == repair.Repair(3, 2, "sixth", "6th")


def test_a_run_with_a_fault_proves_nothing(find_repair_with):
    found, _ = find_repair_with(RunResults((), fault="pytest ran 0 of 9 tests"), *[WRONG] * 3)
    assert found is None


# ---- answers that a named mistake explains ------------------------------------------------------


class FakeStudent:
    """A stand-in for a student with a given `line_through` and two other functions."""

    def __init__(self, function):
        self.line_through, self.helper, self.plane = function, print, len

    def __enter__(self):
        return self

    def __exit__(self, *about):
        pass


QUESTIONS = (3, 4, -5)
CHECKS = [Check(f"check {question}", "line_through", "a title", "a hint") for question in QUESTIONS]
OTHERS = [Check("check", name, "a title", "a hint") for name in ("line", "ransac_line")]


@pytest.fixture
def explains(monkeypatch):
    """Return a function that returns whether a mistake explains the answers of a function.

    The right answer to a call is the number itself.
    """

    def explains(function, mistaken, lost, can_be_imitated=True, same=operator.eq):
        def run_checks(lesson, student, seed, wanted):
            assert (lesson, seed, student.helper, student.plane) == (LINE, 1, print, len)
            assert [check for check in OTHERS if wanted(check)] == []
            assert [check for check in CHECKS if wanted(check)] == CHECKS
            student.exercise = "line_through"
            for _ in range(100):  # a check may call the function many times
                answers = [student.line_through(question, scale=1) for question in QUESTIONS]
            student.close()
            return [
                Outcome(check, None if answer == right else FAIL)
                for check, answer, right in zip(CHECKS, answers, QUESTIONS, strict=True)
            ]

        def imitation_of(exercise, mistake, right):
            assert (exercise, right) == ("line_through", "the solution")
            imitation = SimpleNamespace(call=mistaken, same=same)
            return imitation if can_be_imitated else None

        student = FakeStudent(function)
        monkeypatch.setattr(mistake_diagnosis, "StudentProxy", lambda *about: student)
        monkeypatch.setattr(mistake_diagnosis, "run_checks", run_checks)
        monkeypatch.setattr(mistake_diagnosis, "imitation_of", imitation_of)
        monkeypatch.setattr(mistake_diagnosis, "_load_solution", lambda *about: "the solution")
        checks = frozenset(CHECKS[number] for number in lost)
        name = "".join(["line", "_through"])
        found = mistake_diagnosis.mistake_explains(SETTING, SUBMITTED, name, slip(), checks)
        assert type(found) is bool
        return found

    return explains


def without_sign(number, scale):
    return abs(number) * scale


def doubled(number, scale):
    return 2 * number * scale


def half_without_sign(number, scale):
    """Return a wrong answer to the same call as `without_sign`, but a different answer."""
    return abs(number) + (number < 0)


def test_a_mistake_explains_a_function_with_the_same_answers(explains):
    assert explains(without_sign, without_sign, lost=[2])
    assert explains(doubled, doubled, lost=[0, 1, 2])


def test_a_mistake_does_not_explain_different_answers(explains):
    assert not explains(half_without_sign, without_sign, lost=[2])


@pytest.mark.parametrize("lost", [[], [1], [1, 2], [0, 1, 2]])
def test_a_mistake_must_lose_exactly_the_checks_that_the_answer_lost(explains, lost):
    assert not explains(without_sign, without_sign, lost)


def right(number, scale):
    return number * scale


def is_close(first, second):
    """Return whether two numbers are close, even if a check would distinguish them."""
    return abs(first - second) < 20


@pytest.mark.parametrize("function", [right, doubled])
def test_the_answer_must_lose_the_same_checks_when_repeated(explains, function):
    assert not explains(function, without_sign, lost=[2])
    assert not explains(function, without_sign, lost=[2], same=is_close)


@pytest.mark.parametrize("mistaken", [right, doubled])
def test_the_mistake_alone_must_lose_the_same_checks(explains, mistaken):
    assert explains(without_sign, without_sign, lost=[2], same=is_close)
    assert not explains(without_sign, mistaken, lost=[2], same=is_close)


def test_a_mistake_that_cannot_be_imitated_explains_nothing(explains):
    assert not explains(without_sign, without_sign, lost=[2], can_be_imitated=False)


EXERCISES = [graded.name for lesson in all_lessons() for graded in lesson.machine_graded]


@pytest.mark.proof
@pytest.mark.parametrize("exercise", EXERCISES)
def test_every_imitation_runs_within_seconds(exercise):
    """The judge itself runs imitations, also on dense clouds and on tens of thousands of labels.

    A slower imitation exceeds the judge's own time limit, and the mistake is never proven.
    """
    lesson = lesson_of(exercise)
    right = vars(load_reference(lesson.name))
    assert checks_of(exercise)
    for mistake in known_mistakes(exercise):
        imitation = imitation_of(exercise, mistake, right.get(exercise, print))
        if imitation is None:  # for methods of a tree
            continue
        start = time.process_time()
        student = student_with(lesson, {**right, exercise: imitation.call})
        run_checks(lesson, student, 1, lambda check: check.exercise == exercise)
        # In seconds; the slowest takes 4, and faulty ones have taken 45 or more.
        assert time.process_time() - start < 20, mistake.description


@pytest.mark.parametrize("exercise", EXERCISES)
def test_an_imitation_gives_the_answers_that_its_mistake_predicts(exercise):
    """The solution may return a tuple, although predictions compute with arrays."""
    assert checks_of(exercise)
    solution = mistake_diagnosis._load_solution(lesson_of(exercise), exercise)
    known = diagnosis._KNOWN.get(exercise)
    for mistake in known.mistakes if known else ():
        if (imitation := imitation_of(exercise, mistake, solution)) is None:
            continue
        for case in known.cases:
            expected = mistake.predict(known.right(*copy.deepcopy(case)), *copy.deepcopy(case))
            assert imitation.same(imitation.call(*case), expected), mistake.description


def test_an_imitation_returns_none_if_the_solution_returns_none():
    checks_of("line_through")
    solution = mistake_diagnosis._load_solution(LINE, "line_through")
    imitation = imitation_of("line_through", known_mistakes("line_through")[0], solution)
    answer = imitation.call((1.0, 2.0), (1.0, 2.0))
    assert answer is None and imitation.same(None, answer)
    assert not imitation.same((1.0, 0.0, -1.0), answer)


def test_a_lessons_solution_is_loaded_once():
    line_through = mistake_diagnosis._load_solution(LINE, "line_through")
    a, b, c = line_through(np.array([1.0, 2.0]), np.array([4.0, 6.0]))
    np.testing.assert_allclose([a + 2 * b + c, 4 * a + 6 * b + c], 0, atol=1e-12)
    assert mistake_diagnosis._load_solution(LINE, "line_through") is line_through


# ---- points that a slip keeps -------------------------------------------------------------------


@pytest.mark.parametrize("earned", [0.0, 2.99, 3.0, 3.01, 4.87])
def test_a_slip_never_reduces_the_score(earned):
    found = results._build_slip(repair.Repair(1, 2, "a", "b"), 5.0, earned, rules.ONE_SLIP_KEEPS)
    assert found.score == pytest.approx(max(rules.ONE_SLIP_KEEPS * 5 - earned, 0))


@pytest.mark.parametrize(
    ("proven", "kept"),
    [
        (repair.Repair(3, 14, "before", "after"), Slip(3, 14, "before", "after", 0.5)),
        (slip(), Slip(0, 0, "", "", 0.5)),
    ],
)
def test_a_verdict_reports_a_proven_slip(proven, kept):
    """The slip keeps three of five points, and all failed checks have the same reason."""
    exercise = next(graded for graded in LINE.machine_graded if graded.name == "line_through")
    run = RunResults(outcomes_of("line_through", None, None, FAIL, CheckFailed("nor here")))
    result = results.result_of(exercise, run, None, proven)
    assert (result.score, result.slip) == (3.0, kept)
    same_reason = "Fails for the same reason as “a title”."
    assert [test.message for test in result.tests] == ["", "", "no\nHint: a hint", same_reason]
    plain = results.result_of(exercise, run, None)
    assert (plain.score, plain.slip, plain.tests[3].message) == (2.5, None, "nor here")


def test_a_slip_that_misses_the_task_keeps_fewer_points():
    exercise = next(graded for graded in LINE.machine_graded if graded.name == "line_through")
    outcomes = outcomes_of("line_through", None, FAIL, FAIL, FAIL)
    run = RunResults(outcomes, mistakes={"line_through": slip(is_the_task=True)})
    result = results.result_of(exercise, run, None, repair.Repair(3, 14, "before", "after"))
    assert result.score == pytest.approx(rules.MISSED_TASK_KEEPS * exercise.points)
    assert 0 < rules.MISSED_TASK_KEEPS < rules.ONE_SLIP_KEEPS
