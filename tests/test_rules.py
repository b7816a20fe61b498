"""The judge's own rules, each by itself: no notebook is judged here."""

import dataclasses
import itertools
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from grader.classroom import grade
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.course.variants import fill_in
from grader.intake.apart import ReadingFailed
from grader.intake.handed_in import HandedIn
from grader.intake.preflight import prepare
from grader.judging import followed
from grader.judging import judge as judging
from grader.judging import verdict as verdict_file
from grader.judging.asking import JudgeTimeout, everything
from grader.judging.followed import Followed
from grader.judging.results import result_of
from grader.judging.trial import Asked, Setting
from grader.judging.verdict import (
    JUDGED,
    CheckResult,
    ExerciseResult,
    Verdict,
    read_verdict,
    write_atomically,
    write_verdict,
)
from grader.lms import gradebook
from grader.sandbox import Limits
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.program import PACKAGES, Given, Program
from utils.checks import Check
from utils.checks.diagnosis import Mistake
from utils.checks.failures import CheckFailed
from utils.checks.outcomes import Outcome
from utils.simulator.ground import Ground
from utils.simulator.pose import Pose

LINE = find_lesson("02_ransac_line")
FILTER = find_lesson("06_filter_ground")
WRITTEN = find_lesson("12_streaming_obstacles")
NO = CheckFailed("no")
FEW = Limits(total_seconds=20.0)


# ---- right helpers -----------------------------------------------------------------------------


def outcomes_of(exercise, *held):
    return [
        Outcome(Check(f"check {number}", exercise, "a title", "a hint"), None if holds else NO)
        for number, holds in enumerate(held)
    ]


def follow(monkeypatch, uses, outcomes, again):
    """What comes of `follow_through`; and the programs that were asked a second time."""
    programs = []

    program = Program(("pass",), LINE.names)

    def ask(setting, code, wanted):
        programs.extend([code] * (code != program))
        ended = outcomes if code == program else again
        return Asked(tuple(outcome for outcome in ended if wanted(outcome.check)))

    monkeypatch.setattr(followed, "ask", ask)
    asked = Asked(tuple(outcomes), uses=uses)
    better, _ = followed.follow_through(Setting(LINE, 1, None), program, asked)
    return better, programs


BOTH_WRONG = [*outcomes_of("line_through", False, True), *outcomes_of("ransac_line", False, True)]
ALL_HOLD = [*outcomes_of("line_through", True, True), *outcomes_of("ransac_line", True, True)]


def test_what_comes_later_is_never_put_right(monkeypatch):
    """Else `line_through`, asked beside a right `ransac_line`, could read its answer there."""
    uses = {"ransac_line": ("line_through",), "line_through": ("ransac_line",)}
    better, asked = follow(monkeypatch, uses, BOTH_WRONG, ALL_HOLD)
    assert set(better) == {"ransac_line"} and len(asked) == 1
    assert "line_through" in asked[0].given.names
    assert "ransac_line" not in asked[0].given.names
    assert "def ransac_line" not in asked[0].given.source


def test_nobody_is_followed_whose_helper_is_right(monkeypatch):
    outcomes = [*outcomes_of("line_through", True, True), *outcomes_of("ransac_line", False, True)]
    uses = {"ransac_line": ("line_through",)}
    assert follow(monkeypatch, uses, outcomes, ALL_HOLD) == ({}, [])
    assert follow(monkeypatch, {}, BOTH_WRONG, ALL_HOLD) == ({}, [])


@pytest.mark.parametrize("held", [(False, False), (False, True)])
def test_a_second_score_counts_only_if_it_is_higher(monkeypatch, held):
    again = [*outcomes_of("line_through", True, True), *outcomes_of("ransac_line", *held)]
    better, asked = follow(monkeypatch, {"ransac_line": ("line_through",)}, BOTH_WRONG, again)
    assert asked and not better


STOP = StudentStopped("it did not answer")


@pytest.mark.parametrize(
    ("first", "once_more", "with_right", "counts"),
    [
        (None, None, NO, None),
        (None, NO, None, NO),
        (NO, None, None, NO),
        (NO, NO, None, None),
        (NO, NO, NO, NO),
        (None, STOP, NO, None),  # a process that was stopped has not answered
        (NO, STOP, None, NO),
        (STOP, NO, None, STOP),
        (STOP, STOP, None, None),
    ],
)
def test_what_counts_of_three_tries(first, once_more, with_right, counts):
    (check,) = (one.check for one in outcomes_of("ransac_line", True))
    tries = (Outcome(check, failure) for failure in (first, once_more, with_right))
    assert followed.settled(*tries).failure is counts


@pytest.mark.parametrize("stops", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("chance", np.linspace(0.0, 1.0, 11))
def test_a_coin_gains_nothing_by_a_wrong_helper(chance, stops):
    """Nor one that stops its process now and then, at whichever of the tries it likes."""
    (check,) = (one.check for one in outcomes_of("ransac_line", True))
    for where in itertools.product([False, True], repeat=3):
        expected = 0.0
        for tries in itertools.product([None, NO, STOP], repeat=3):
            likely = 1.0
            for failure, may_stop in zip(tries, where, strict=True):
                stop = stops if may_stop else 0.0
                answer = chance if failure is None else 1 - chance
                likely *= stop if failure is STOP else (1 - stop) * answer
            settled = followed.settled(*(Outcome(check, failure) for failure in tries))
            expected += likely * (settled.failure is None)
        assert expected <= chance + 1e-12


def test_what_held_by_chance_is_taken_back(monkeypatch):
    program, uses = Program(("pass",), LINE.names), {"ransac_line": ("line_through",)}
    first = [*outcomes_of("line_through", False), *outcomes_of("ransac_line", True, False)]
    tries = iter([outcomes_of("ransac_line", False, True), outcomes_of("ransac_line", True, True)])
    monkeypatch.setattr(followed, "ask", lambda *about: Asked(tuple(next(tries))))
    better, _ = followed.follow_through(
        Setting(LINE, 1, None), program, Asked(tuple(first), uses=uses)
    )
    assert all(outcome.failure for outcome in better["ransac_line"].outcomes)
    assert "Does it answer by chance?" in better["ransac_line"].sentence


@pytest.mark.parametrize("fault", ["", "pytest ran 3 of 9 tests"])
@pytest.mark.parametrize("starved", [False, True])
def test_of_a_second_time_that_failed_nothing_counts(monkeypatch, fault, starved):
    uses = {"ransac_line": ("line_through",)}
    ended = dataclasses.replace(Asked(tuple(ALL_HOLD)), fault=fault, starved=starved)
    asked, own = Asked(tuple(BOTH_WRONG), uses=uses), Program((), LINE.names)
    monkeypatch.setattr(
        followed, "ask", lambda setting, code, wanted: asked if code == own else ended
    )
    better, late = followed.follow_through(Setting(LINE, 1, None), own, asked)
    assert (set(better), late) == ((set(), False) if fault else ({"ransac_line"}, starved))


def test_who_comes_after_one_that_is_not_followed_is(monkeypatch):
    """And of two who are, each is asked about itself alone."""
    plane = find_lesson("03_ransac_plane")
    names = [one.name for one in plane.machine_graded]
    lost = [outcome for name in names for outcome in outcomes_of(name, False, name == names[3])]
    hold = [outcome for name in names for outcome in outcomes_of(name, True, True)]
    given = Given(("KdTree",), "class KdTree: pass", ("KdTree",))
    own, programs = Program(("pass",), plane.names, given=given), []

    def ask(setting, program, wanted):
        if program == own:
            return Asked(tuple(one for one in lost if wanted(one.check)))
        programs.append(program)
        again = Asked(tuple(one for one in hold if wanted(one.check)), starved=len(programs) == 1)
        return dataclasses.replace(again, fault="" if len(programs) != 2 else "it broke")

    monkeypatch.setattr(followed, "ask", ask)
    uses = {name: tuple(names) for name in names[1:]}
    better, late = followed.follow_through(
        Setting(plane, 1, None), own, Asked(tuple(lost), uses=uses)
    )
    assert late and list(better) == [names[1], *names[3:]]  # the second of the four broke
    assert [one.check.exercise for one in better[names[3]].outcomes] == [names[3]] * 2
    for number, program in enumerate(programs, start=1):
        assert program.names == (names[number], "KdTree")
        assert program.given.names == ("KdTree", *names[:number])
        assert program.given.source.startswith("class KdTree: pass\n")
        assert program.given.open == ("KdTree",)
        for name in names:
            assert (f"def {name}(" in program.given.source) == (name in names[:number])
    assert better[names[1]].sentence == (
        "plane_through, which point_plane_distance calls, is wrong. Judged with a right one "
        "instead, point_plane_distance earns 10 of 10 points, not 0."
    )
    assert better[names[3]].sentence == (
        "plane_through and point_plane_distance and ransac_plane, which fit_plane calls, are "
        "wrong. Judged with right ones instead, fit_plane earns 5 of 5 points, not 2.5."
    )


# ---- one notebook -------------------------------------------------------------------------------


def ended(filter_ground=(None, None), voxel_grid=(None, None), **more):
    """What came of asking lesson 06: how each check of an exercise ended."""
    about = {"filter_ground": filter_ground, "voxel_grid": voxel_grid}
    outcomes = [
        Outcome(Check(f"{name} {number}", name, f"title {number}", "a hint", run=print), failure)
        for name, failures in about.items()
        for number, failure in enumerate(failures)
    ]
    return Asked(tuple(outcomes), **more)


@pytest.fixture
def judge_made_of(monkeypatch):
    """A function that judges lesson 06 where asking ends so and so; what was asked."""

    def judge(*tries, complaints=(), better=None, late=False, text=None):
        waiting, asked = list(tries), []

        def ask(setting, program, wanted=everything, explain=False):
            asked.append(
                SimpleNamespace(
                    setting=setting,
                    program=program,
                    explain=explain,
                    names=[one.check.name for one in tries[0].outcomes if wanted(one.check)],
                )
            )
            again = waiting.pop(0)
            outcomes = tuple(one for one in again.outcomes if wanted(one.check))
            return dataclasses.replace(again, outcomes=outcomes)

        monkeypatch.setattr(judging, "ask", ask)
        monkeypatch.setattr(judging, "complaints_about_reference", lambda *about: complaints)
        monkeypatch.setattr(judging, "follow_through", lambda *about: (better or {}, late))
        data = (text or fill_in(FILTER, {})).encode()
        verdict = judging.judge_handed_in(HandedIn("x.ipynb", data), 7, None, FILTER, "ada", FEW)
        assert not waiting
        return verdict, asked

    return judge


def scores(verdict):
    return {one.name: one.score for one in verdict.exercises}


def test_what_is_right_is_asked_once_and_earns_everything(judge_made_of, monkeypatch):
    clock = iter([100.0, 103.25678])
    monkeypatch.setattr(judging.time, "perf_counter", lambda: next(clock))
    verdict, (asked,) = judge_made_of(ended(problems=("A cell is broken.",)))
    assert scores(verdict) == {one.name: one.points for one in FILTER.machine_graded}
    assert (verdict.score, verdict.max_score, verdict.status) == (30.0, 30.0, JUDGED)
    assert (verdict.lesson, verdict.student) == (FILTER.name, "ada")
    assert verdict.problems == ("A cell is broken.",)
    assert (verdict.faults, verdict.starved, verdict.seconds) == ((), False, 3.257)
    assert asked.explain
    assert asked.setting == Setting(FILTER, 7, None, FEW, asked.setting.budget)
    assert asked.setting.budget.seconds == FEW.total_seconds
    assert len(asked.names) == 4


def test_what_a_notebook_may_use_is_what_its_lesson_says():
    for lesson in (FILTER, find_lesson("05_euclidean_clustering")):
        program = judging.program_for(lesson, ("x = 1",), {"helper": "y = 2"})
        header = lesson.header
        given = Given(header.given, lesson.source_of(header.given), header.given)
        assert program == Program(
            ("x = 1",),
            lesson.names,
            {"helper": "y = 2"},
            given,
            header.forbidden,
            (*PACKAGES, *header.packages),
            lesson.steps,
        )
    tree = find_lesson("04_kd_tree")
    assert "class" in judging.given_code(tree) and judging.given_code(tree) is judging.given_code(
        tree
    )


ODD = OSError("once")


def test_what_is_odd_is_asked_once_more_and_nothing_else(judge_made_of):
    verdict, asked = judge_made_of(ended((NO, ODD), (None, ODD)), ended())
    assert [len(one.names) for one in asked] == [4, 2] and not asked[1].explain
    assert asked[1].names == ["filter_ground 1", "voxel_grid 1"]
    assert asked[0].program == asked[1].program
    points = {one.name: one.points for one in FILTER.machine_graded}
    assert scores(verdict) == points | {"filter_ground": points["filter_ground"] / 2}
    assert verdict.status == JUDGED and not verdict.starved


@pytest.mark.parametrize(
    "failure", [None, NO, StudentError("f", "KeyError"), StudentStopped("no"), JudgeTimeout()]
)
def test_what_a_wrong_answer_may_do_is_not_odd(judge_made_of, failure):
    verdict, asked = judge_made_of(ended((failure, None)), complaints=("never asked",))
    assert len(asked) == 1 and verdict.status == JUDGED
    assert (verdict.score == 30) == (failure is None)


@pytest.mark.parametrize(
    "tries",
    [
        (ended((NO, ODD), (None, ODD)), ended((None, ODD), (None, ZeroDivisionError("oracle")))),
        (ended((NO, ODD), (None, ODD)), Asked((), fault="pytest ran 0 of 2 tests")),
    ],
)
def test_what_stays_odd_is_a_wrong_answer_if_the_solution_passes(judge_made_of, tries):
    verdict, _ = judge_made_of(*tries)
    assert (verdict.status, verdict.faults) == (JUDGED, ())
    points = {one.name: one.points for one in FILTER.machine_graded}
    assert scores(verdict) == {"filter_ground": 0.0, "voxel_grid": points["voxel_grid"] / 2}
    verdict, _ = judge_made_of(*tries, complaints=("voxel_grid, x",))
    assert (verdict.status, verdict.score, verdict.max_score) == ("judge_failed", 0.0, 30.0)
    assert len(verdict.faults) == 2 and "OSError: once" in verdict.faults[0]
    assert verdict.problems == (judging.UNFAIR,)
    assert [(one.score, one.tests) for one in verdict.exercises] == [(0.0, ())] * 2


def test_where_not_every_check_could_be_asked_nobody_is_judged(judge_made_of):
    verdict, asked = judge_made_of(Asked((), fault="pytest ran 3 of 9 tests", starved=True))
    assert (verdict.status, verdict.faults) == ("judge_failed", ("pytest ran 3 of 9 tests",))
    assert verdict.starved and len(asked) == 1


@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize("second", [False, True])
@pytest.mark.parametrize("late", [False, True])
def test_who_lacked_a_processor_at_any_time_is_called_starved(judge_made_of, first, second, late):
    tries = (ended((ODD, None), starved=first), ended(starved=second))
    verdict, _ = judge_made_of(*tries, late=late)
    assert verdict.starved == (first or second or late)


def test_who_writes_an_exercise_twice_is_told_if_it_loses_points(judge_made_of):
    twice = json.loads(fill_in(FILTER, {}))
    for name in ("filter_ground", "voxel_grid"):
        for number in (1, 2):
            source = f"def {name}(cloud):\n    return {number}"
            twice["cells"].append({"cell_type": "code", "metadata": {}, "source": source})
    better = {"voxel_grid": Followed(tuple(ended().about("voxel_grid")), "A helper is wrong.")}
    about = {"text": json.dumps(twice), "better": better}
    verdict, _ = judge_made_of(ended((NO, None), (NO, None), problems=("A cell.",)), **about)
    *problems, last = verdict.problems
    assert problems == ["A cell.", "A helper is wrong."]
    assert last.startswith("filter_ground is written 3 times")


@pytest.fixture
def reference(monkeypatch):
    """A function that says what is found wrong with a solution that fares so, time by time."""

    def complaints(*tries):
        waiting = list(tries)
        monkeypatch.setattr(judging, "ask", lambda *about: waiting.pop(0))
        return judging.complaints_about_reference.__wrapped__(FILTER, 7, None), len(waiting)

    return complaints


def test_a_fault_of_a_test_is_there_each_time(reference):
    broken = ended((NO, None), problems=("A cell.",))
    said = ("filter_ground, filter_ground 0: CheckFailed: no", "A cell.")
    assert reference(ended()) == ((), 0)
    assert reference(broken, ended()) == ((), 0)
    assert reference(broken, broken) == (said, 0)
    fault = Asked((), fault="pytest ran 3 of 9 tests", problems=("A cell.",))
    assert reference(broken, fault) == (("pytest ran 3 of 9 tests",), 0)


def test_a_notebook_of_no_lesson_is_no_notebook_of_ours():
    nameless = b'{"cells": [], "metadata": {}}'
    for data, says in ((nameless, "cannot tell which lesson"), (b"", "is empty")):
        with pytest.raises(judging.UnknownLesson, match=says):
            judging.judge_handed_in(HandedIn("my homework.ipynb", data), 7, None)
    verdict = judging.judge_handed_in(HandedIn("06_filter_ground.ipynb", b""), 7, None)
    assert (verdict.status, verdict.score, verdict.max_score) == (JUDGED, 0.0, 30.0)
    assert "is empty" in verdict.problems[0] and not verdict.starved
    assert [one.tests for one in verdict.exercises] == [(), ()]


def test_who_could_not_be_read_by_a_fault_of_ours_is_not_judged(monkeypatch):
    def fail(*about):
        raise ReadingFailed("There was no memory.")

    monkeypatch.setattr(judging, "prepare_to_judge", fail)
    verdict = judging.judge_handed_in(HandedIn("06_filter_ground.ipynb", b"{}"), 7, None)
    assert (verdict.status, verdict.faults) == ("judge_failed", ("There was no memory.",))
    assert verdict.problems == (judging.UNFAIR,)


def test_what_was_decided_stays_as_it_is():
    for kind in (Followed, judging._Reached, Asked, Setting, Verdict, CheckResult, ExerciseResult):
        assert kind.__dataclass_params__.frozen


# ---- what is said about an exercise -------------------------------------------------------------


FLIPPED = Mistake("It is upside down.", predicts=np.flip)


def test_a_verdict_says_of_each_check_what_came_of_it():
    asked = ended((None, NO), mistakes={"filter_ground": FLIPPED})
    exercise = FILTER.machine_graded[0]
    result = result_of(exercise, asked, None)
    half, said = exercise.points / 2, "It is upside down.\nno"
    assert result.tests == (
        CheckResult("filter_ground 0", "title 0", True, half, half, "", True),
        CheckResult("filter_ground 1", "title 1", False, 0.0, half, said, True),
    )
    assert (result.name, result.score, result.max_score) == ("filter_ground", half, 2 * half)
    assert (result.cause, result.first) == (said, "filter_ground 1")
    right = result_of(exercise, ended(), None)
    assert (right.cause, right.first, right.score) == ("", "", 2 * half)


def test_of_a_stub_no_check_is_named():
    stub = StudentError("filter_ground", "NotImplementedError")
    result = result_of(FILTER.machine_graded[0], ended((stub, stub)), None)
    assert result.first == "" and "is not started" in result.cause


def test_what_was_said_beside_a_right_helper_is_not_told():
    better = Followed(
        tuple(ended((None, CheckFailed("4 of 9 rows", yours="9"))).about("filter_ground")),
        "A helper is wrong.",
    )
    asked = ended((NO, NO), mistakes={"filter_ground": FLIPPED})
    result = result_of(FILTER.machine_graded[0], asked, better)
    assert result.score == FILTER.machine_graded[0].points / 2
    assert result.cause == "A helper is wrong.\n… of … rows\nHint: a hint"
    assert result.tests[1].message == "… of … rows\nHint: a hint"


# ---- verdicts on disk ---------------------------------------------------------------------------


@pytest.fixture
def handed_in(tmp_path):
    """A course and its one submission, with a verdict that can be believed."""
    course = Course(tmp_path)
    path = course.submitted / "ada" / FILTER.stage / f"{FILTER.name}.ipynb"
    path.parent.mkdir(parents=True)
    path.write_text(fill_in(FILTER, {}), "utf-8")
    (submission,) = grade.find_submissions(course)
    handed_in = submission.read(course)
    key = grade.verdict_key(handed_in, FILTER, 1, "ada")
    about = {"key": key, "fingerprint": handed_in.fingerprint()}
    verdict = Verdict(FILTER.name, "ada", JUDGED, 0.0, 30.0, (), (), 0.0, **about)
    return course, submission, verdict


@pytest.mark.parametrize(
    ("change", "believed"),
    [
        ({}, True),
        ({"starved": True}, False),
        ({"status": "judge_failed"}, False),
        ({"key": "of other rules"}, False),
        ({"fingerprint": ""}, False),
    ],
)
def test_which_verdicts_on_disk_are_believed(handed_in, change, believed):
    course, submission, verdict = handed_in
    write_verdict(dataclasses.replace(verdict, **change), submission.verdict_path(course))
    assert (grade.stored_verdict(course, submission, 1) is not None) == believed


def full_verdict():
    """A verdict with something in every place."""
    tests = (
        CheckResult("a", "Holds", True, 1.25, 1.25, "", True),
        CheckResult("test_b", "Fails", False, 0.0, 8.75, "For “größer”.", False),
    )
    exercises = (ExerciseResult("filter_ground", 1.25, 10.0, tests, "It fails.", "test_b"),)
    about = {"key": "of rules", "faults": ("no",), "starved": True, "fingerprint": "of a file"}
    return Verdict("06", "ada", JUDGED, 1.25, 10.0, exercises, ("A cell.",), 3.25, **about)


def test_a_verdict_comes_back_from_the_disk_as_it_was(tmp_path):
    path = tmp_path / "new" / "folder" / "verdict.json"
    for verdict in (full_verdict(), dataclasses.replace(full_verdict(), exercises=(), faults=())):
        write_verdict(verdict, str(path))
        assert read_verdict(str(path)) == verdict
        assert [file.name for file in path.parent.iterdir()] == ["verdict.json"]


def test_what_is_published_is_a_part_of_it():
    verdict = full_verdict()
    published = json.loads(json.dumps(verdict.as_dict()))
    assert published == {
        "lesson": "06",
        "student": "ada",
        "status": "judged",
        "score": 1.25,
        "max_score": 10.0,
        "exercises": [
            {
                "name": "filter_ground",
                "score": 1.25,
                "max_score": 10.0,
                "tests": [dataclasses.asdict(test) for test in verdict.exercises[0].tests],
            }
        ],
        "problems": ["A cell."],
        "seconds": 3.25,
    }
    assert verdict == full_verdict()


def test_what_verdicts_have_in_common_is_there_once():
    one, other = full_verdict().compact(), full_verdict().compact()
    assert one == other == full_verdict() and one.exercises[0] is other.exercises[0]
    another = dataclasses.replace(full_verdict().exercises[0], score=0.0)
    another = dataclasses.replace(full_verdict(), exercises=(another,)).compact()
    assert another.exercises[0].tests[1] is one.exercises[0].tests[1]
    assert another.exercises[0].score == 0.0


def test_a_verdict_is_believed_when_nothing_else_was_at_work():
    verdict = full_verdict()
    assert verdict.believed() == dataclasses.replace(verdict, starved=False) != verdict
    plain = Verdict("06", "ada", JUDGED, 0.0, 30.0, (), (), 0.0, "")
    assert (plain.faults, plain.starved, plain.fingerprint) == ((), False, "")
    exercise = ExerciseResult("f", 0.0, 1.0, ())
    assert (exercise.cause, exercise.first) == ("", "")
    for made in (verdict, *verdict.exercises, *verdict.exercises[0].tests):
        with pytest.raises(dataclasses.FrozenInstanceError):
            made.score = 100.0


def change_of(*way, to):
    """A change of one place in what a file holds; a place that is no more if `to` is None."""

    def change(content):
        *before, last = way
        for step in before:
            content = content[step]
        if to is None:
            del content[last]
        else:
            content[last] = to

    return change


@pytest.mark.parametrize(
    "change",
    [
        change_of("exercises", to=7),  # TypeError
        change_of("exercises", to=None),  # KeyError
        change_of("faults", to=None),
        change_of("score", to=None),
        change_of("more", to=1),
        change_of("exercises", 0, "tests", 0, "name", to=None),
        change_of("exercises", 0, "tests", 0, "name", to=[]),  # cannot be compared
    ],
)
def test_a_file_that_is_no_verdict_is_none(tmp_path, change):
    path = tmp_path / "verdict.json"
    write_verdict(full_verdict(), path)
    content = json.loads(path.read_text("utf-8"))
    change(content)
    path.write_text(json.dumps(content), "utf-8")
    assert read_verdict(path) is None
    path.write_bytes(b"\xff" + path.read_bytes())
    assert read_verdict(path) is read_verdict(tmp_path / "none.json") is None


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_of_a_file_that_could_not_be_written_nothing_stays(tmp_path, monkeypatch, error):
    path = tmp_path / "verdict.json"
    path.write_text("before")

    def fail(*about):
        raise error

    monkeypatch.setattr(verdict_file.os, "replace", fail)
    with pytest.raises(type(error)):
        write_atomically("after", path)
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [
        ("verdict.json", "before")
    ]


def test_fellow_graders_may_read_what_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr(verdict_file, "_UMASK", 0o027)
    write_atomically("a \ud800 word", tmp_path / "a" / "b.json")  # what is no text does no harm
    write_atomically("a word", tmp_path / "a" / "b.json")
    assert (tmp_path / "a" / "b.json").stat().st_mode & 0o777 == 0o640


# ---- the gradebook ------------------------------------------------------------------------------


@pytest.mark.parametrize("hour", [12, 13])
def test_another_time_of_submission_is_a_difference(handed_in, hour):
    course, submission, _ = handed_in
    when = course.submitted / "ada" / FILTER.stage / "timestamp.txt"
    when.write_text("2026-03-01 12:00:00 UTC")
    entry = gradebook.Entry("ada", FILTER.stage, ())
    known = gradebook._timestamp(course, entry).replace(hour=hour)
    book = SimpleNamespace(
        find_submission=lambda stage, student: SimpleNamespace(timestamp=known, notebooks=[])
    )
    found = gradebook.differences(course, book, entry, None)
    assert bool(found) == (hour != 12) and all("time of submission" in one for one in found)


def test_of_a_notebook_that_nobody_handed_in_nothing_waits_for_a_person():
    waiting = SimpleNamespace(auto_score=4.0, needs_manual_grade=True)
    gradebook._nothing_handed_in(SimpleNamespace(grades=[waiting]))
    assert (waiting.auto_score, waiting.needs_manual_grade) == (0.0, False)


# ---- preflight ----------------------------------------------------------------------------------


def notebook(*cells):
    """A notebook of lesson 06, or of 12, as somebody's editor left it: without metadata."""
    made = [
        {"cell_type": kind, "metadata": {}, "source": source}
        | ({"outputs": [], "execution_count": None} if kind == "code" else {})
        for kind, source in cells
    ]
    return {"cells": made, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}


def prepared(lesson, *cells):
    text = json.dumps(notebook(*cells))
    return prepare(HandedIn(f"{lesson.name}.ipynb", text.encode()), lesson)


def test_of_several_cells_that_define_an_exercise_the_last_is_graded():
    made = prepared(
        FILTER,
        ("code", "def filter_ground(cloud):\n    return 1"),
        ("markdown", "Some text."),
        ("code", "def filter_ground(cloud):\n    return 2"),
        ("code", "print(filter_ground)"),
    )
    assert made.cells[made.graded["filter_ground"]].source.endswith("return 2")


def test_a_written_answer_is_looked_for_below_the_last_copy_of_its_question():
    """Who copies the question to the top of the notebook, and answers below the other."""
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


# ---- what the questions are made of -------------------------------------------------------------


@pytest.mark.parametrize("yaw", [0.0, 0.4])
def test_a_kerb_is_lit_by_the_angle_that_a_ray_meets_it_at(yaw):
    road = Ground(pose=Pose(0.0, 0.0, 0.0, yaw), width=7.0, kerb=0.5)
    normal = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
    along = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    target = 3.5 * normal + 6.0 * along + [0.0, 0.0, 0.25]  # on the kerb's face, half way up
    eye = np.array([0.0, 0.0, 1.7])
    ray = (target - eye) / np.linalg.norm(target - eye)
    distance, cosine = road.crossings(ray[:, None], tuple(eye))
    assert distance[0] == pytest.approx(np.linalg.norm(target - eye))
    assert cosine[0] == pytest.approx(abs(ray @ normal))
