"""The rules of the judge and the gradebook, each tested without judging a notebook."""

import dataclasses
import itertools
import json
from types import SimpleNamespace

import numpy as np
import pytest

from grader.classroom import grade
from grader.course.deadlines import Deadlines
from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.intake.preflight import prepare
from grader.intake.submission import SubmittedFiles
from grader.judging import error_carried_forward
from grader.judging.program_run import JudgingContext, RunResults
from grader.judging.verdict import (
    JUDGED,
    Verdict,
    write_verdict,
)
from grader.lms import gradebook_writer
from grader.lms.differences import differences
from grader.lms.stage_entries import StageEntry
from grader.lms.submission_times import naive_submission_time
from grader.sandbox.failures import StudentStopped
from grader.sandbox.program import GivenCode, Program
from utils.checks import Check
from utils.checks.failures import CheckFailed
from utils.checks.outcomes import Outcome

LINE = find_lesson("02_ransac_line")
FILTER = find_lesson("06_filter_ground")
WRITTEN = find_lesson("12_streaming_obstacles")
FAILURE = CheckFailed("no")


# ---- error carried forward -----------------------------------------------------------------------


def outcomes_of(exercise, *passes):
    return [
        Outcome(Check(f"check {number}", exercise, "a title", "a hint"), None if good else FAILURE)
        for number, good in enumerate(passes)
    ]


def carry_forward_on(monkeypatch, uses, outcomes, again):
    """Run `carry_forward` on given outcomes; return its results and the corrected programs."""
    programs = []

    program = Program(("pass",), LINE.names)

    def run(setting, code, wanted):
        programs.extend([code] * (code != program))
        ended = outcomes if code == program else again
        return RunResults(tuple(outcome for outcome in ended if wanted(outcome.check)))

    monkeypatch.setattr(error_carried_forward, "run_program", run)
    results = RunResults(tuple(outcomes), uses=uses)
    better = error_carried_forward.carry_forward(JudgingContext(LINE, 1, None), program, results)
    return better, programs


BOTH_WRONG = [*outcomes_of("line_through", False, True), *outcomes_of("ransac_line", False, True)]
ALL_PASS = [*outcomes_of("line_through", True, True), *outcomes_of("ransac_line", True, True)]


def test_later_exercises_are_never_replaced_by_right_ones(monkeypatch):
    """Otherwise, `line_through` could take its answer from a right `ransac_line`."""
    uses = {"ransac_line": ("line_through",), "line_through": ("ransac_line",)}
    better, programs = carry_forward_on(monkeypatch, uses, BOTH_WRONG, ALL_PASS)
    assert set(better) == {"ransac_line"} and len(programs) == 1
    assert "line_through" in programs[0].given.names
    assert "ransac_line" not in programs[0].given.names
    assert "def ransac_line" not in programs[0].given.source


def test_a_right_helper_does_not_excuse_a_later_error(monkeypatch):
    outcomes = [*outcomes_of("line_through", True, True), *outcomes_of("ransac_line", False, True)]
    uses = {"ransac_line": ("line_through",)}
    assert carry_forward_on(monkeypatch, uses, outcomes, ALL_PASS) == ({}, [])
    assert carry_forward_on(monkeypatch, {}, BOTH_WRONG, ALL_PASS) == ({}, [])


@pytest.mark.parametrize("passes", [(False, False), (False, True)])
def test_a_second_score_counts_only_if_it_is_higher(monkeypatch, passes):
    again = [*outcomes_of("line_through", True, True), *outcomes_of("ransac_line", *passes)]
    better, programs = carry_forward_on(
        monkeypatch, {"ransac_line": ("line_through",)}, BOTH_WRONG, again
    )
    assert programs and not better


def test_a_right_helper_with_a_note_is_also_replaced(monkeypatch):
    """A random answer must not gain from this, so a perfect exercise also runs again."""
    passed = outcomes_of("point_line_distance", True, True)
    again, uses = outcomes_of("ransac_line", True, True), {"ransac_line": ("point_line_distance",)}
    own, programs, noted = Program(("pass",), LINE.names), [], frozenset(["point_line_distance"])

    def run(setting, code, wanted):
        programs.append(code)
        return RunResults(tuple(outcomes_of("ransac_line", False, True) if code == own else again))

    monkeypatch.setattr(error_carried_forward, "run_program", run)
    for passes in ((False, True), (True, True)):
        first = RunResults((*passed, *outcomes_of("ransac_line", *passes)), uses=uses, noted=noted)
        context = JudgingContext(LINE, 1, None)
        [better] = error_carried_forward.carry_forward(context, own, first).values()
        if not all(passes):
            assert [code == own for code in programs] == [True, False]
            assert "def point_line_distance" in programs[-1].given.source
            assert better.sentence == (
                "point_line_distance, which ransac_line calls, is right, but ransac_line needs its "
                "result in another form. With the lesson's point_line_distance instead, the checks "
                "of ransac_line earn 25 of 25 points, not 12.5."
            )
        else:
            assert programs == [own]
            assert "use random numbers?" in better.sentence
        programs.clear()


def test_a_carried_forward_result_is_immutable():
    assert error_carried_forward.CarriedForwardResult.__dataclass_params__.frozen


STOP = StudentStopped("it did not answer")


@pytest.mark.parametrize(
    ("first", "once_more", "with_right", "counts"),
    [
        (None, None, FAILURE, None),
        (None, FAILURE, None, FAILURE),
        (FAILURE, None, None, FAILURE),
        (FAILURE, FAILURE, None, None),
        (FAILURE, FAILURE, FAILURE, FAILURE),
        (None, STOP, FAILURE, None),  # a stopped process does not count as an answer
        (FAILURE, STOP, None, FAILURE),
        (STOP, FAILURE, None, STOP),
        (STOP, STOP, None, None),
    ],
)
def test_a_check_with_inconsistent_tries_fails(first, once_more, with_right, counts):
    (check,) = (outcome.check for outcome in outcomes_of("ransac_line", True))
    tries = (Outcome(check, failure) for failure in (first, once_more, with_right))
    assert error_carried_forward.decisive_outcome(*tries).failure is counts


@pytest.mark.parametrize("stops", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("chance", np.linspace(0.0, 1.0, 11))
def test_a_random_answer_gains_nothing_from_a_wrong_helper(chance, stops):
    """An answer that stops its process in some of the tries also gains nothing."""
    (check,) = (outcome.check for outcome in outcomes_of("ransac_line", True))
    for where in itertools.product([False, True], repeat=3):
        expected = 0.0
        for tries in itertools.product([None, FAILURE, STOP], repeat=3):
            likely = 1.0
            for failure, may_stop in zip(tries, where, strict=True):
                stop = stops if may_stop else 0.0
                answer = chance if failure is None else 1 - chance
                likely *= stop if failure is STOP else (1 - stop) * answer
            decisive_outcome = error_carried_forward.decisive_outcome(
                *(Outcome(check, failure) for failure in tries)
            )
            expected += likely * (decisive_outcome.failure is None)
        assert expected <= chance + 1e-12


def test_a_perfect_exercise_is_also_run_again(monkeypatch):
    """Otherwise, a random answer would run again only after a failure, and could only gain."""
    uses = {"ransac_line": ("line_through",)}
    first = [*outcomes_of("line_through", False), *outcomes_of("ransac_line", True, True)]
    for again, passes in (((True, True), None), ((False, False), [False, False])):
        programs = []

        def run(setting, code, wanted, again=again, programs=programs):
            programs.append(code)
            return RunResults(tuple(outcomes_of("ransac_line", *again)))

        monkeypatch.setattr(error_carried_forward, "run_program", run)
        program = Program(("pass",), LINE.names)
        better = error_carried_forward.carry_forward(
            JudgingContext(LINE, 1, None), program, RunResults(tuple(first), uses=uses)
        )
        assert programs == [program], "without right helpers"
        found = better.get("ransac_line")
        assert (found and [not outcome.failure for outcome in found.outcomes]) == passes


def test_a_check_passed_by_chance_is_revoked(monkeypatch):
    program, uses = Program(("pass",), LINE.names), {"ransac_line": ("line_through",)}
    first = [*outcomes_of("line_through", False), *outcomes_of("ransac_line", True, False)]
    tries = iter([outcomes_of("ransac_line", False, True), outcomes_of("ransac_line", True, True)])
    monkeypatch.setattr(
        error_carried_forward, "run_program", lambda *about: RunResults(tuple(next(tries)))
    )
    better = error_carried_forward.carry_forward(
        JudgingContext(LINE, 1, None), program, RunResults(tuple(first), uses=uses)
    )
    assert all(outcome.failure for outcome in better["ransac_line"].outcomes)
    assert "use random numbers?" in better["ransac_line"].sentence


@pytest.mark.parametrize("fault", ["", "pytest ran 3 of 9 tests"])
def test_a_failed_second_run_does_not_count(monkeypatch, fault):
    uses = {"ransac_line": ("line_through",)}
    ended = RunResults(tuple(ALL_PASS), fault=fault)
    first, own = RunResults(tuple(BOTH_WRONG), uses=uses), Program((), LINE.names)
    monkeypatch.setattr(
        error_carried_forward,
        "run_program",
        lambda context, code, wanted: first if code == own else ended,
    )
    better = error_carried_forward.carry_forward(JudgingContext(LINE, 1, None), own, first)
    assert set(better) == (set() if fault else {"ransac_line"})


def test_each_exercise_is_run_again_separately(monkeypatch):
    """If the run for one exercise fails, later exercises are still run again."""
    plane = find_lesson("03_ransac_plane")
    names = [exercise.name for exercise in plane.machine_graded]
    lost = [outcome for name in names for outcome in outcomes_of(name, False, name == names[3])]
    hold = [outcome for name in names for outcome in outcomes_of(name, True, True)]
    given = GivenCode(("KdTree",), "class KdTree: pass", ("KdTree",))
    own, programs, about = Program(("pass",), plane.names, given=given), [], []

    def run(setting, program, wanted):
        about.append({outcome.check.exercise for outcome in hold if wanted(outcome.check)})
        if program == own:
            return RunResults(tuple(outcome for outcome in lost if wanted(outcome.check)))
        programs.append(program)
        outcomes = tuple(outcome for outcome in hold if wanted(outcome.check))
        return RunResults(outcomes, fault="" if len(programs) != 2 else "it broke")

    monkeypatch.setattr(error_carried_forward, "run_program", run)
    uses = {name: tuple(names) for name in names[1:]}
    better = error_carried_forward.carry_forward(
        JudgingContext(plane, 1, None), own, RunResults(tuple(lost), uses=uses)
    )
    assert list(better) == [names[1], *names[3:]]  # the second of the four runs failed
    assert [outcome.check.exercise for outcome in better[names[3]].outcomes] == [names[3]] * 2
    assert about == [{name} for name in names[1:] for _ in range(2)]
    assert [rerun.program for rerun in better.values()] == [programs[0], *programs[2:]]
    for number, program in enumerate(programs, start=1):
        assert program.names == (names[number], "KdTree")
        assert program.given.names == ("KdTree", *names[:number])
        assert program.given.source.startswith("class KdTree: pass\n")
        assert program.given.open_names == ("KdTree",)
        for name in names:
            assert (f"def {name}(" in program.given.source) == (name in names[:number])
    assert better[names[1]].sentence == (
        "plane_through, which point_plane_distance calls, is wrong. With the lesson's "
        "plane_through instead, the checks of point_plane_distance earn 10 of 10 points, not 0."
    )
    assert better[names[3]].sentence == (
        "plane_through and point_plane_distance and ransac_plane, which fit_plane calls, are "
        "wrong. With the lesson's plane_through and point_plane_distance and ransac_plane instead, "
        "the checks of fit_plane earn 5 of 5 points, not 2.5."
    )


# ---- verdicts on disk ---------------------------------------------------------------------------


@pytest.fixture
def judged_submission(tmp_path):
    """Return a course, its only submission, and a valid verdict on that submission."""
    course = Course(tmp_path)
    path = course.submitted / "ada" / FILTER.stage / f"{FILTER.name}.ipynb"
    path.parent.mkdir(parents=True)
    path.write_text(fill_in(FILTER, {}), "utf-8")
    (submission,) = grade.find_submissions(course)
    submitted_files = submission.read(course)
    key = grade.verdict_key(submitted_files, FILTER, 1, "ada")
    about = {"key": key, "fingerprint": submitted_files.fingerprint()}
    verdict = Verdict(FILTER.name, "ada", JUDGED, 0.0, 30.0, (), (), 0.0, **about)
    return course, submission, verdict


@pytest.mark.parametrize(
    ("change", "is_valid"),
    [
        ({}, True),
        ({"starved": True}, False),
        ({"status": "judge_failed"}, False),
        ({"key": "of other rules"}, False),
        ({"fingerprint": ""}, False),
    ],
)
def test_only_matching_and_reliable_verdicts_on_disk_are_valid(judged_submission, change, is_valid):
    course, submission, verdict = judged_submission
    write_verdict(dataclasses.replace(verdict, **change), submission.verdict_path(course))
    assert (grade.stored_verdict(course, submission, 1) is not None) == is_valid


# ---- the gradebook ------------------------------------------------------------------------------


@pytest.mark.parametrize("hour", [12, 13])
def test_a_different_submission_time_is_a_difference(judged_submission, hour):
    course, submission, verdict = judged_submission
    when = course.submitted / "ada" / FILTER.stage / "timestamp.txt"
    when.write_text("2026-03-01 12:00:00 UTC")
    entry = StageEntry("ada", FILTER.stage, ((submission, verdict),))
    known = naive_submission_time(entry.folders(course)).replace(hour=hour)
    book = SimpleNamespace(
        find_submission=lambda stage, student: SimpleNamespace(
            timestamp=known,
            notebooks=[],
            extension=None,
            student=SimpleNamespace(id=student),
            assignment=SimpleNamespace(name=stage),
        )
    )
    *found, last = differences(course, book, entry, None, Deadlines({}))
    assert last.endswith(": not in the gradebook")
    assert bool(found) == (hour != 12) and all("submission time" in text for text in found)


def test_a_missing_notebook_needs_no_manual_grading():
    waiting = SimpleNamespace(auto_score=4.0, needs_manual_grade=True)
    gradebook_writer._enter_as_missing(SimpleNamespace(grades=[waiting]))
    assert (waiting.auto_score, waiting.needs_manual_grade) == (0.0, False)


# ---- preflight ----------------------------------------------------------------------------------


def notebook(*cells):
    """Return a notebook without metadata, as some editors save it."""
    made = [
        {"cell_type": kind, "metadata": {}, "source": source}
        | ({"outputs": [], "execution_count": None} if kind == "code" else {})
        for kind, source in cells
    ]
    return {"cells": made, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}


def prepared(lesson, *cells):
    text = json.dumps(notebook(*cells))
    return prepare(SubmittedFiles(f"{lesson.name}.ipynb", text.encode()), lesson)


def test_the_last_of_several_cells_that_define_an_exercise_is_graded():
    made = prepared(
        FILTER,
        ("code", "def filter_ground(cloud):\n    return 1"),
        ("markdown", "Some text."),
        ("code", "def filter_ground(cloud):\n    return 2"),
        ("code", "print(filter_ground)"),
    )
    assert made.cells[made.graded["filter_ground"]].source.endswith("return 2")


def test_a_written_answer_is_found_below_the_last_copy_of_its_question():
    """A student may copy the question to the top but answer below the original."""
    cells = json.loads(WRITTEN.released.read_text("utf-8"))["cells"]
    names = [cell["metadata"].get("nbgrader", {}).get("grade_id") for cell in cells]
    question = "".join(cells[names.index("write_up") - 1]["source"])
    made = prepared(
        WRITTEN,
        ("markdown", question),
        ("code", "x = 1"),
        ("markdown", "A plan, long before."),
        ("markdown", question),
        ("markdown", "It finds 14 of 17 cars."),
    )
    assert made.answers["write_up"].text == "It finds 14 of 17 cars."
