"""When it is proven that one thing alone is wrong, with a student made of nothing."""

import functools
import itertools
import operator
import time
from types import SimpleNamespace

import numpy as np
import pytest

from grader.course import rules
from grader.course.lessons import find_lesson, lesson_of, load_reference
from grader.intake.preflight import given_cells
from grader.judging import mistake_diagnosis, repair, results
from grader.judging.error_carried_forward import CarriedForward
from grader.judging.program_run import RunResults, Setting
from grader.judging.runner import run_checks
from grader.judging.verdict import Slip
from grader.sandbox import Limits
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.program import Program
from grader.sandbox.student import TOOK_TOO_LONG
from grader.sandbox.time_budget import Budget
from tests.students import student_with
from utils.checks import Check, checks_of
from utils.checks.diagnosis import Mistake, known_mistakes, player_of
from utils.checks.failures import CheckFailed, WrongForm
from utils.checks.outcomes import Outcome
from utils.checks.run_cache import once

LINE = find_lesson("02_ransac_line")
NO = CheckFailed("no")
HANGS = StudentError("line_through", TOOK_TOO_LONG)
HANDED_IN, MENDED = Program(("a",), ()), Program(("b",), ())
SETTING = Setting(LINE, 1, None)
PLACES = ("1, line 3", "2")
RAISED = [StudentError("f", "ValueError", place=f"code cell {place}") for place in PLACES]


def outcomes_of(exercise, *failures):
    return tuple(
        Outcome(Check(f"{exercise} {number}", exercise, "a title", "a hint"), failure)
        for number, failure in enumerate(failures)
    )


FAILED = outcomes_of("line_through", NO)


# ---- whose answers are tried --------------------------------------------------------------------


@pytest.fixture
def tried(monkeypatch):
    """What `repair_of` was asked for; it finds nothing."""
    found = []

    def repair_of(setting, program, exercise, failed):
        assert all(outcome.failure for outcome in failed)
        found.append((program, exercise, [outcome.check.name for outcome in failed]))

    monkeypatch.setattr(repair, "repair_of", repair_of)
    monkeypatch.setattr(repair, "explains", lambda *about: False)
    return found


def test_what_lost_something_is_tried_with_what_it_lost(tried):
    asked = RunResults(
        (*outcomes_of("line_through", None, NO, NO), *outcomes_of("ransac_line", None))
    )
    assert repair.slips_in(SETTING, HANDED_IN, asked, {}) == {}
    assert tried == [(HANDED_IN, "line_through", ["line_through 1", "line_through 2"])]


def test_what_calls_a_wrong_function_is_tried_with_a_right_one(tried):
    asked = RunResults(outcomes_of("ransac_line", NO, NO, NO))
    better = {"ransac_line": CarriedForward(outcomes_of("ransac_line", None, NO, None), "", MENDED)}
    repair.slips_in(SETTING, HANDED_IN, asked, better)
    assert tried == [(MENDED, "ransac_line", ["ransac_line 1"])]
    right = {
        "ransac_line": CarriedForward(outcomes_of("ransac_line", None, None, None), "", MENDED)
    }
    repair.slips_in(SETTING, HANDED_IN, asked, right)
    assert len(tried) == 1


@pytest.mark.parametrize("name", ["NotImplementedError", "ImportError", "ModuleNotFoundError"])
def test_neither_a_stub_is_tried_nor_what_is_not_allowed(tried, name):
    stub = StudentError("line_through", name)
    repair.slips_in(SETTING, HANDED_IN, RunResults(outcomes_of("line_through", None, stub, NO)), {})
    assert tried == []
    wrong = StudentError("line_through", "KeyError")
    repair.slips_in(SETTING, HANDED_IN, RunResults(outcomes_of("line_through", wrong, NO)), {})
    assert len(tried) == 1


def slip(*about, **more):
    return Mistake("This is a slip.", print, *about, **more)


def test_the_task_itself_is_not_tried(tried):
    asked = RunResults(
        (*outcomes_of("line_through", NO), *outcomes_of("ransac_line", NO)),
        mistakes={"line_through": slip(is_the_task=True), "ransac_line": slip()},
    )
    repair.slips_in(SETTING, HANDED_IN, asked, {})
    assert [exercise for _, exercise, _ in tried] == ["ransac_line"]


def test_a_cheap_mistake_is_a_slip_by_an_edit_and_not_by_its_name(tried, monkeypatch):
    monkeypatch.setattr(repair, "explains", lambda *about: True)
    named, cheap = slip(), slip(is_cheap=True)
    outcomes = (*outcomes_of("line_through", NO), *outcomes_of("ransac_line", NO))
    asked = RunResults(outcomes, mistakes={"line_through": cheap, "ransac_line": named})
    assert repair.slips_in(SETTING, HANDED_IN, asked, {}) == {"ransac_line": named}
    assert [exercise for _, exercise, _ in tried] == ["line_through", "ransac_line"]


def test_a_course_may_do_without(tried, monkeypatch):
    monkeypatch.setattr(repair, "ONE_SLIP_KEEPS", 0)
    repair.slips_in(SETTING, HANDED_IN, RunResults(outcomes_of("line_through", NO)), {})
    assert tried == []


def test_what_no_edit_mends_a_named_mistake_may_explain(tried, monkeypatch):
    asked_for = []

    def explains(setting, program, exercise, mistake, lost):
        asked_for.append((setting, program, exercise, {check.name for check in lost}))
        return mistake is named

    monkeypatch.setattr(repair, "explains", explains)
    named, other = slip(), slip()
    outcomes = (*outcomes_of("line_through", NO, None, NO), *outcomes_of("ransac_line", NO))
    asked = RunResults(outcomes, mistakes={"line_through": named, "ransac_line": other})
    assert repair.slips_in(SETTING, HANDED_IN, asked, {}) == {"line_through": named}
    assert asked_for == [
        (SETTING, HANDED_IN, "line_through", {"line_through 0", "line_through 2"}),
        (SETTING, HANDED_IN, "ransac_line", {"ransac_line 0"}),
    ]
    # What was answered with a wrong helper explains nothing about answers with a right one.
    better = {"line_through": CarriedForward(outcomes_of("line_through", NO), "", MENDED)}
    assert repair.slips_in(SETTING, HANDED_IN, asked, better) == {}


def test_an_edit_goes_before_a_named_mistake(monkeypatch):
    found = repair.Repair(1, 2, "a", "b")
    monkeypatch.setattr(repair, "repair_of", lambda *about: found)
    asked = RunResults(outcomes_of("line_through", NO), mistakes={"line_through": slip()})
    assert repair.slips_in(SETTING, HANDED_IN, asked, {}) == {"line_through": found}
    assert repair.Repair.__dataclass_params__.frozen


# ---- which edits pass what an answer failed -----------------------------------------------------


class Edited:
    """A student of whom it is said what fails: before any edit, and with each.

    Parameters
    ----------
    fails : list of str
        Letters of what fails before any edit, and with edit 0, 1, …: "e" the edit itself, "a" and
        "b" two shown questions, "x" and "y" two hidden ones; a capital letter hangs.
    seconds : float
        Of the processor, for each edit that is tried.
    slept : float
        Seconds that each takes of the notebook's own, without a processor.
    """

    def __init__(self, fails, seconds=0.0, stops=False, slept=0.0):
        self.fails, self.seconds, self.stops = fails, seconds, stops
        self.now, self.tried, self.hidden_made = fails[0], 0, 0
        self.lost, self.slept, self.given = [], slept, []
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
        self.now = self.fails[number + 1]
        self.budget.seconds -= self.slept
        self.answer("e")

    def answer(self, letter):
        self.given.append((letter, self.interrupts_after))
        if letter.upper() in self.now:
            raise HANGS
        if letter in self.now:
            self.budget.note_lost(self.exercise, 0.3)
            raise NO

    def questions(self, letters):
        return tuple(functools.partial(self.answer, letter) for letter in letters)

    def hidden(self, lesson, student, seed, failed):
        assert (lesson, student, seed) == (LINE, self, 1)
        self.lost.append(self.budget.lost.get(self.exercise, 0.0))
        self.hidden_made += 1
        return self.questions("xy")


@pytest.fixture
def passing(monkeypatch):
    """A function that gives the numbers of the edits of a student that pass."""

    def passing(
        student,
        shown="ab",
        limits=None,
        failed=FAILED,
        clock=lambda: 100.0,
        budget=None,
        meanwhile=lambda: None,
    ):
        monkeypatch.setattr(repair, "StudentProxy", student)
        monkeypatch.setattr(repair, "visible_calls", lambda *about: student.questions(shown))
        monkeypatch.setattr(repair, "hidden_calls", student.hidden)
        # Half of the time goes by out here.
        monkeypatch.setattr(repair.time, "process_time", lambda: 50.0 + student.cpu_seconds)
        monkeypatch.setattr(repair.time, "monotonic", clock)
        setting = Setting(LINE, 1, None, limits, budget)
        found = []
        for edit in repair._passing(setting, HANDED_IN, "line_through", failed):
            found.append(edit)
            meanwhile()
        assert student.closed and all(edit == student.edits[edit[1]] for edit in found)
        return [number for _, number, _, _ in found]

    return passing


def test_an_edit_passes_what_was_failed_shown_and_hidden(passing):
    student = Edited(["abxy", "e", "a", "b", "x", "y", "", "abxy"])
    assert passing(student) == [5]
    assert student.hidden_made == 1 and student.tried == 7
    assert (student.program, student.counted_as) == (HANDED_IN, "line_through")
    # What hangs with an edit did not hang without.
    assert student.exercise not in ("line_through", "")
    assert passing(Edited(["xy", "x", ""]), shown="") == [1]


def test_hidden_questions_are_made_where_shown_ones_are_passed(passing):
    student = Edited(["abxy", "a", "b", "e"])
    assert passing(student) == [] and student.hidden_made == 0


def test_what_comes_to_no_end_where_clouds_are_large_is_judged(passing):
    student = Edited(["abxy", "B", "x", "X", "y", "Y", ""])
    assert passing(student) == [2, 4, 5]


def test_who_answers_otherwise_when_asked_again_gets_no_more_throws(passing):
    student = Edited(["bxy", "", ""])
    assert passing(student) == [] and student.tried == 0
    assert passing(Edited(["axy", ""])) == [0]  # not all are asked again


def test_nor_where_nothing_failed_but_what_nobody_sees(passing):
    student = Edited(["y", "", ""])
    assert passing(student, shown="") == [] and student.tried == 0


def test_once_one_has_hung_at_the_first_question_the_others_have_less_time_there(passing):
    student = Edited(["abxy", "a", "bx", "A", "b", "A", ""])
    assert passing(student) == [5]
    some, few = repair.SECONDS_OF_A_CALL, repair.SECONDS_OF_A_FIRST_CALL
    assert few < some / 5
    firsts = [seconds for letter, seconds in student.given if letter == "a"]
    assert firsts == [some, some, some, some, few, few, few]  # before any edit, and with each
    assert {seconds for letter, seconds in student.given if letter in "bxy"} == {some}
    # Of an answer that hangs itself most edits hang.
    student = Edited(["Abxy", "A", ""])
    assert passing(student) == [1]
    assert [seconds for letter, seconds in student.given if letter == "a"] == [some, few, few]


def test_what_one_edit_answered_is_not_remembered_for_the_next(passing, monkeypatch):
    student = Edited(["abxy", "a", "b", "b", ""])

    @once
    def stands(function):
        if "b" in student.now:
            raise NO

    monkeypatch.setattr(student, "questions", lambda letters: [lambda: stands(student)])
    student.__name__ = "line_through"
    assert passing(student) == [0, 3]


def test_who_is_interrupted_hangs_and_who_raises_does_not():
    name = (TOOK_TOO_LONG + " ").strip()  # as it comes out of another process
    assert repair._hangs(StudentError("f", name)) and repair._hangs(StudentStopped("It is gone."))
    others = (None, NO, StudentError("f", "IndexError"), StudentError("f", "ZeroDivisionError"))
    assert not any(map(repair._hangs, others))


def test_who_is_told_so_by_a_check_hangs():
    failures = []
    for error in (StudentStopped("It did not answer."), StudentError("f", "IndexError")):
        try:
            try:
                raise error
            except Exception as first:
                raise CheckFailed(f"60,000 points. {first}") from None
        except CheckFailed as failure:
            failures.append(failure)
    assert list(map(repair._hangs, failures)) == [True, False]


def test_of_edits_that_pass_three_are_judged(passing):
    student = Edited(["abxy", "", "a", "", "", "", ""])
    assert passing(student) == [0, 2, 3] and student.tried == 4


def test_a_cell_as_it_was_handed_out_is_not_edited(passing, monkeypatch):
    given = next(cell for cell in given_cells(LINE) if cell.kind == "code")
    monkeypatch.setitem(globals(), "HANDED_IN", Program((given.source, "x = 1"), ()))
    student = Edited(["abxy", "", "", ""])
    student.edits = [(cell, number, number, "") for number, cell in enumerate((1, 2, 1))]
    assert passing(student) == [1] and student.tried == 1


def test_an_edit_of_a_line_that_raised_is_tried_first(passing):
    student = Edited(["abxy", "", "", "", "", ""])
    assert passing(student, failed=outcomes_of("line_through", *RAISED)) == [3, 0, 1]


def test_a_line_raised_where_it_says_or_where_it_calls():
    inside = StudentError("f", "ValueError", place="code cell 3, line 12")
    called = StudentError(
        "f", "ValueError", place="code cell 1, line 2", calling="code cell 3, line 5"
    )
    nowhere = StudentError("f", "ValueError")
    outcomes = outcomes_of("line_through", inside, called, nowhere, NO, None)
    assert repair._raised_at(outcomes) == {(3, 12), (1, 2), (3, 5)}


def test_edits_of_an_exercise_have_a_second_between_them(passing):
    student = Edited(["abxy"] * 200, 0.02)  # and as much out here
    assert passing(student) == [] and student.tried == 2 * repair.LOOK_AFTER
    student = Edited(["abxy"] * 100, 0.001)
    assert passing(student) == [] and student.tried == 99


def test_the_clock_is_looked_at_after_each_edit_that_takes_long(passing):
    seconds = itertools.count(100.0)
    student = Edited(["abxy"] * 200, 0.3)  # and as much out here
    assert passing(student, clock=lambda: next(seconds)) == [] and student.tried == 2


def test_each_call_has_the_time_of_a_right_answer(passing):
    student = Edited(["abxy", ""])
    passing(student)
    limits = Limits(call_seconds=2 * repair.SECONDS_OF_A_CALL, restarts=repair.MOST_THAT_HANG)
    assert student.limits == limits and 0.1 < limits.call_seconds < 1
    passing(student, limits=Limits(call_seconds=0.1, memory=7))
    assert (student.limits.call_seconds, student.limits.memory) == (0.1, 7)


def test_edits_take_their_time_of_what_the_notebook_has_left(passing):
    budget = Budget(Limits())
    student = Edited(["abxy"] * 100, slept=0.07)  # more than a second between the first two looks
    assert passing(student, budget=budget) == [] and student.tried == repair.LOOK_AFTER
    assert student.budget is budget
    assert budget.seconds == pytest.approx(180 - 0.07 * repair.LOOK_AFTER)
    # What others take meanwhile, as when an edit is judged as a whole, is not theirs.
    student = Edited(["abxy", *["", "a"] * 40], slept=0.01)

    def judge_it():
        budget.seconds -= 5

    passes = passing(student, clock=itertools.count(1).__next__, budget=budget, meanwhile=judge_it)
    assert passes == [0, 2, 4]


def test_the_clock_on_the_wall_ends_it_in_any_case(passing):
    clock = itertools.count(100.0)
    student = Edited(["abxy"] * 200)
    assert passing(student, clock=lambda: next(clock)) == []
    assert 10 < student.tried < repair.MOST_SECONDS


def test_what_one_edit_lost_is_not_the_next_ones(passing):
    student = Edited(["abxy", "x", "e", "x", "a", ""])
    assert passing(student) == [4] and student.lost == [0.0]


def test_a_notebook_whose_cells_never_end_is_not_started_again(tried):
    asked = RunResults(outcomes_of("line_through", NO))
    budget = Budget(Limits())
    setting = Setting(LINE, 1, None, None, budget)
    repair.slips_in(setting, HANDED_IN, asked, {})
    assert len(tried) == 1
    budget.begins = False
    assert repair.slips_in(setting, HANDED_IN, asked, {}) == {} and len(tried) == 1


def test_a_notebook_that_does_not_start_has_no_edits(passing):
    assert passing(Edited(["abxy", ""], stops=True)) == []


def test_what_ends_a_loop_is_tried_first_where_one_had_no_end():
    texts = ("x = 1", "x = 1\n        return", "pass", "break", "return x", "return")
    edits = [(1, 1, 1, text) for text in texts]
    hangs = outcomes_of("line_through", NO, StudentStopped("It did not answer."))
    assert [number for number, _ in repair._in_order(edits, hangs)] == [1, 3, 5, 0, 2, 4]
    fails = outcomes_of("line_through", NO)
    assert [number for number, _ in repair._in_order(edits, fails)] == [0, 1, 2, 3, 4, 5]


def test_what_returns_something_is_tried_first_where_nothing_came():
    texts = ("x = 1", "    return x", "return", "y = 1\nreturn y", "return y")
    edits = [(1, 1, 1, text) for text in texts]
    nothing = outcomes_of("line_through", NO, WrongForm("It returned None.", yours="None"))
    assert [number for number, _ in repair._in_order(edits, nothing)] == [1, 4, 0, 2, 3]
    something = outcomes_of("line_through", NO, WrongForm("It is a list.", yours="[None]"))
    assert [number for number, _ in repair._in_order(edits, something)] == [0, 1, 2, 3, 4]


def test_what_changes_the_line_that_raised_is_tried_first():
    beside = [(1, 3, 3), (2, 1, 2), (2, 4, 4), (3, 3, 3)]
    there = [(2, 3, 3), (2, 2, 4), (2, 3, 5), (2, 1, 3)]
    edits = [(*place, "text") for pair in zip(beside, there, strict=True) for place in pair]
    errors = (StudentError("f", "E", place=f"code cell {place}") for place in ("2, line 3", "7"))
    ordered = repair._in_order(edits, outcomes_of("line_through", NO, *errors))
    assert [number for number, _ in ordered] == [1, 3, 5, 7, 0, 2, 4, 6]
    assert all(edits[number] == edit for number, edit in ordered)


# ---- which edit makes an answer right -----------------------------------------------------------

CELL = "first\nsecond\nthird\nfourth"
PROGRAM = Program(("import numpy", CELL, "fifth\nsixth"), ("line_through",))


@pytest.fixture
def judged_as(monkeypatch):
    """A function that looks for a repair where edits are judged so; what was asked."""

    def judged_as(*tries):
        asked, waiting = [], list(tries)

        def ask(setting, program, wanted, to_the_end):
            assert not to_the_end  # an edit is right, or it is not
            names = ("line", "line_through", "ransac_line")
            checks = [Check("a", "".join(name), "a title", "a hint") for name in names]
            asked.append((program.cells, [check.exercise for check in checks if wanted(check)]))
            return waiting.pop(0)

        edits = [(2, 2, 3, "mended"), (2, 1, 1, "1st\nhalf"), (2, 4, 4, "4th"), (3, 2, 2, "6th")]
        monkeypatch.setattr(repair, "ask", ask)
        monkeypatch.setattr(repair, "_passing", lambda *about: iter(edits))
        return repair.repair_of(SETTING, PROGRAM, "".join(["line_", "through"]), ()), asked

    return judged_as


RIGHT, WRONG = (RunResults(outcomes_of("line_through", None, failure)) for failure in (None, NO))


def test_the_edit_that_loses_nothing_is_the_one(judged_as):
    found, asked = judged_as(RIGHT)
    assert found == repair.Repair(2, 2, "second\nthird", "mended")
    mended = ("import numpy", "first\nmended\nfourth", "fifth\nsixth")
    assert asked == [(mended, ["line_through"])]
    found, asked = judged_as(WRONG, RIGHT)
    assert found == repair.Repair(2, 1, "first", "1st\nhalf")
    assert [cells[1] for cells, _ in asked] == [mended[1], CELL.replace("first", "1st\nhalf")]
    assert judged_as(WRONG, WRONG, RIGHT)[0] == repair.Repair(2, 4, "fourth", "4th")
    assert judged_as(WRONG, WRONG, WRONG, RIGHT)[0] == repair.Repair(3, 2, "sixth", "6th")


def test_what_could_not_be_asked_proves_nothing(judged_as):
    found, _ = judged_as(RunResults((), fault="pytest ran 0 of 9 tests"), *[WRONG] * 3)
    assert found is None


# ---- what a named mistake explains --------------------------------------------------------------


class Answering:
    """A student whose `line_through` is this function, beside others."""

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
    """Whether a mistake explains what a function answers; the right answer is the number."""

    def explains(function, mistaken, lost, played=True, same=operator.eq):
        def run_checks(lesson, student, seed, wanted):
            assert (lesson, seed, student.helper, student.plane) == (LINE, 1, print, len)
            assert [check for check in OTHERS if wanted(check)] == []
            assert [check for check in CHECKS if wanted(check)] == CHECKS
            student.exercise = "line_through"
            for _ in range(100):  # as each check asks often
                answers = [student.line_through(question, scale=1) for question in QUESTIONS]
            student.close()
            return [
                Outcome(check, None if answer == one else NO)
                for check, answer, one in zip(CHECKS, answers, QUESTIONS, strict=True)
            ]

        def player_of(exercise, mistake, right):
            assert (exercise, right) == ("line_through", "the solution")
            player = SimpleNamespace(plays=mistaken, same=same)
            return player if played else None

        student = Answering(function)
        monkeypatch.setattr(mistake_diagnosis, "StudentProxy", lambda *about: student)
        monkeypatch.setattr(mistake_diagnosis, "run_checks", run_checks)
        monkeypatch.setattr(mistake_diagnosis, "player_of", player_of)
        monkeypatch.setattr(mistake_diagnosis, "_solution", lambda *about: "the solution")
        checks = frozenset(CHECKS[number] for number in lost)
        name = "".join(["line", "_through"])
        found = mistake_diagnosis.explains(SETTING, HANDED_IN, name, slip(), checks)
        assert type(found) is bool
        return found

    return explains


def without_sign(number, scale):
    return abs(number) * scale


def doubled(number, scale):
    return 2 * number * scale


def half_without_sign(number, scale):
    """Wrong at the same question, and with another answer."""
    return abs(number) + (number < 0)


def test_a_mistake_explains_who_answers_as_it_does(explains):
    assert explains(without_sign, without_sign, lost=[2])
    assert explains(doubled, doubled, lost=[0, 1, 2])


def test_who_answers_otherwise_is_not_explained(explains):
    assert not explains(half_without_sign, without_sign, lost=[2])


@pytest.mark.parametrize("lost", [[], [1], [1, 2], [0, 1, 2]])
def test_nor_is_who_lost_other_checks_than_the_mistake_loses(explains, lost):
    assert not explains(without_sign, without_sign, lost)


def right(number, scale):
    return number * scale


def nearly(one, other):
    """Whether answers are taken for the same that a check tells apart."""
    return abs(one - other) < 20


@pytest.mark.parametrize("function", [right, doubled])
def test_nor_is_who_loses_others_when_asked_again(explains, function):
    assert not explains(function, without_sign, lost=[2])
    assert not explains(function, without_sign, lost=[2], same=nearly)


@pytest.mark.parametrize("mistaken", [right, doubled])
def test_nor_is_who_loses_others_than_the_mistake_alone(explains, mistaken):
    assert explains(without_sign, without_sign, lost=[2], same=nearly)
    assert not explains(without_sign, mistaken, lost=[2], same=nearly)


def test_what_is_no_function_of_its_arguments_explains_nothing(explains):
    assert not explains(without_sign, without_sign, lost=[2], played=False)


@pytest.mark.slow
@pytest.mark.xdist_group("10_accelerated_clustering")  # whose scenes take seconds to make
@pytest.mark.parametrize("step", [4, 1], ids=["some", "all"])
def test_whoever_makes_a_mistake_is_no_slower_than_any_answer_may_be(step):
    """It is asked here, in the judge: on heaps of 20 000 points, too."""
    exercise = "euclidean_clustering_accelerated"
    lesson = lesson_of(exercise)
    right = vars(load_reference(lesson.name))
    assert checks_of(exercise)
    assert len(known_mistakes(exercise)) > 10
    for mistake in known_mistakes(exercise)[::step]:
        player = player_of(exercise, mistake, right[exercise])
        begin = time.process_time()
        student = student_with(lesson, {**right, exercise: player.plays})
        run_checks(lesson, student, 1, lambda check: check.exercise == exercise)
        assert time.process_time() - begin < 20, mistake.says  # of which all had taken 45 and more


def test_the_solution_is_the_lessons_own_and_made_once():
    line_through = mistake_diagnosis._solution(LINE, "line_through")
    a, b, c = line_through(np.array([1.0, 2.0]), np.array([4.0, 6.0]))
    np.testing.assert_allclose([a + 2 * b + c, 4 * a + 6 * b + c], 0, atol=1e-12)
    assert mistake_diagnosis._solution(LINE, "line_through") is line_through


# ---- what a slip keeps --------------------------------------------------------------------------


@pytest.mark.parametrize("earned", [0.0, 2.99, 3.0, 3.01, 4.87])
def test_a_slip_never_takes(earned):
    found = results._slip(repair.Repair(1, 2, "a", "b"), 5.0, earned)
    assert found.score == pytest.approx(max(rules.ONE_SLIP_KEEPS * 5 - earned, 0))


@pytest.mark.parametrize(
    ("proven", "kept"),
    [
        (repair.Repair(3, 14, "before", "after"), Slip(3, 14, "before", "after", 0.5)),
        (slip(), Slip(0, 0, "", "", 0.5)),
    ],
)
def test_a_verdict_says_that_one_thing_alone_is_wrong(proven, kept):
    """It keeps three of five points, and every check was lost for the same reason."""
    exercise = next(one for one in LINE.machine_graded if one.name == "line_through")
    asked = RunResults(outcomes_of("line_through", None, None, NO, CheckFailed("nor here")))
    result = results.result_of(exercise, asked, None, proven)
    assert (result.score, result.slip) == (3.0, kept)
    same = "For the same reason as “a title”."
    assert [test.message for test in result.tests] == ["", "", "no\nHint: a hint", same]
    alone = results.result_of(exercise, asked, None)
    assert (alone.score, alone.slip, alone.tests[3].message) == (2.5, None, "nor here")
