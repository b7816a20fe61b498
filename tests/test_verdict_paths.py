"""The rules by which the judge reaches verdicts, tested with artificial outcomes of checks."""

import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pytest

from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.intake.reader_process import ReadingFailed
from grader.intake.submission import SubmittedFiles
from grader.judging import judge as judging
from grader.judging.error_carried_forward import CarriedForwardResult
from grader.judging.program_run import JudgingContext, RunResults
from grader.judging.results import result_of
from grader.judging.runner import JudgeTimeout, every_check
from grader.judging.verdict import (
    JUDGED,
    CheckResult,
    ExerciseResult,
    Verdict,
)
from grader.sandbox import Limits
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.program import INSTALLED_PACKAGES, GivenCode, Program
from utils.checks import Check
from utils.checks.diagnosis import Mistake
from utils.checks.failures import CheckFailed
from utils.checks.outcomes import Outcome

FILTER = find_lesson("06_filter_ground")
FAILURE = CheckFailed("no")
# One function is written, because the checks of an untouched notebook would not run at all.
WRITTEN = {"filter_ground": "def filter_ground(cloud, ground_level=-1.2):\n    return cloud"}
PROGRAM = Program(("pass",), ())
FEW = Limits(total_seconds=20.0)


def run_results(filter_ground=(None, None), voxel_grid=(None, None), **more):
    """Return results for lesson 06 with given outcomes of each exercise's checks."""
    about = {"filter_ground": filter_ground, "voxel_grid": voxel_grid}
    outcomes = [
        Outcome(Check(f"{name} {number}", name, f"title {number}", "a hint", run=print), failure)
        for name, failures in about.items()
        for number, failure in enumerate(failures)
    ]
    return RunResults(tuple(outcomes), **more)


@pytest.fixture
def judge_with(monkeypatch):
    """Return a function that judges lesson 06 with given results, and records the runs."""

    def judge(*tries, complaints=(), better=None, starved_in=(), text=None):
        waiting, runs = list(tries), []

        def step(name, context, result):
            context.budget.starved |= name in starved_in
            return result

        def run(context, program, wanted=every_check, explain=False):
            runs.append(
                SimpleNamespace(
                    context=context,
                    program=program,
                    explain=explain,
                    names=[
                        outcome.check.name for outcome in tries[0].outcomes if wanted(outcome.check)
                    ],
                )
            )
            again = waiting.pop(0)
            outcomes = tuple(outcome for outcome in again.outcomes if wanted(outcome.check))
            name = f"run {len(runs)}"
            return step(name, context, dataclasses.replace(again, outcomes=outcomes))

        monkeypatch.setattr(judging, "run_program", run)
        # Clear the cache of right submissions.
        monkeypatch.setattr(judging, "_full_mark_decisions", {})
        monkeypatch.setattr(judging, "reference_failures", lambda *about: complaints)
        monkeypatch.setattr(
            judging,
            "carry_forward",
            lambda context, *about: step("carry_forward", context, better or {}),
        )
        monkeypatch.setattr(
            judging, "find_slips", lambda context, *about: step("find_slips", context, {})
        )
        data = (text or fill_in(FILTER, WRITTEN)).encode()
        verdict = judging.judge_files(SubmittedFiles("x.ipynb", data), 7, None, FILTER, "ada", FEW)
        assert not waiting
        return verdict, runs

    return judge


def scores(verdict):
    return {exercise.name: exercise.score for exercise in verdict.exercises}


def test_a_right_notebook_runs_once_and_earns_everything(judge_with, monkeypatch):
    clock = iter([100.0, 103.25678])
    monkeypatch.setattr(judging.time, "perf_counter", lambda: next(clock))
    verdict, (runs,) = judge_with(run_results(problems=("A cell is broken.",)))
    assert scores(verdict) == {exercise.name: exercise.points for exercise in FILTER.machine_graded}
    assert (verdict.score, verdict.max_score, verdict.status) == (30.0, 30.0, JUDGED)
    assert (verdict.lesson, verdict.student) == (FILTER.name, "ada")
    assert verdict.problems == ("A cell is broken.",)
    assert (verdict.faults, verdict.starved, verdict.seconds) == ((), False, 3.257)
    assert runs.explain
    assert runs.context == JudgingContext(FILTER, 7, None, FEW, runs.context.budget)
    assert runs.context.budget.seconds == FEW.total_seconds
    assert len(runs.names) == 4


def test_the_program_has_the_rules_of_its_lesson():
    for lesson in (FILTER, find_lesson("05_euclidean_clustering")):
        program = judging.program_for(lesson, ("x = 1",), {"helper": "y = 2"})
        header = lesson.header
        given = GivenCode(header.given, lesson.source_of(header.given), header.given)
        assert program == Program(
            ("x = 1",),
            lesson.names,
            {"helper": "y = 2"},
            given,
            header.forbidden,
            INSTALLED_PACKAGES,
            lesson.steps,
        )
    tree = find_lesson("04_kd_tree")
    assert "class" in judging.given_code(tree) and judging.given_code(tree) is judging.given_code(
        tree
    )


ODD = OSError("once")


def test_only_suspicious_failures_are_retried(judge_with):
    verdict, runs = judge_with(run_results((FAILURE, ODD), (None, ODD)), run_results())
    assert [len(program.names) for program in runs] == [4, 2] and not runs[1].explain
    assert runs[1].names == ["filter_ground 1", "voxel_grid 1"]
    assert runs[0].program == runs[1].program
    points = {exercise.name: exercise.points for exercise in FILTER.machine_graded}
    assert scores(verdict) == points | {"filter_ground": points["filter_ground"] / 2}
    assert verdict.status == JUDGED and not verdict.starved


@pytest.mark.parametrize(
    "failure", [None, FAILURE, StudentError("f", "KeyError"), StudentStopped("no"), JudgeTimeout()]
)
def test_ordinary_failures_are_not_retried(judge_with, failure):
    verdict, runs = judge_with(run_results((failure, None)), complaints=("not used",))
    assert len(runs) == 1 and verdict.status == JUDGED
    assert (verdict.score == 30) == (failure is None)


@pytest.mark.parametrize(
    "tries",
    [
        (
            run_results((FAILURE, ODD), (None, ODD)),
            run_results((None, ODD), (None, ZeroDivisionError("oracle"))),
        ),
        (run_results((FAILURE, ODD), (None, ODD)), RunResults((), fault="pytest ran 0 of 2 tests")),
    ],
)
def test_a_repeated_failure_counts_if_the_solution_passes(judge_with, tries):
    verdict, _ = judge_with(*tries)
    assert (verdict.status, verdict.faults) == (JUDGED, ())
    points = {exercise.name: exercise.points for exercise in FILTER.machine_graded}
    assert scores(verdict) == {"filter_ground": 0.0, "voxel_grid": points["voxel_grid"] / 2}
    verdict, _ = judge_with(*tries, complaints=("voxel_grid, x",))
    assert (verdict.status, verdict.score, verdict.max_score) == ("judge_failed", 0.0, 30.0)
    assert len(verdict.faults) == 2 and "OSError: once" in verdict.faults[0]
    assert verdict.problems == (judging.JUDGE_FAILED_NOTE,)
    assert [(exercise.score, exercise.tests) for exercise in verdict.exercises] == [(0.0, ())] * 2


def test_an_incomplete_run_gives_no_score(judge_with):
    broken = RunResults((), fault="pytest ran 3 of 9 tests")
    verdict, runs = judge_with(broken, starved_in=["run 1"])
    assert (verdict.status, verdict.faults) == ("judge_failed", ("pytest ran 3 of 9 tests",))
    assert verdict.starved and len(runs) == 1


STEPS = ("run 1", "run 2", "carry_forward", "find_slips")


@pytest.mark.parametrize("starved_in", [[], *([step] for step in STEPS), STEPS])
def test_a_verdict_is_starved_if_any_step_was(judge_with, starved_in):
    verdict, _ = judge_with(run_results((ODD, FAILURE)), run_results(), starved_in=starved_in)
    assert verdict.starved == (judging.STARVED_NOTE in verdict.problems) == bool(starved_in)
    # The note stays if judging the notebook again alone gives no better result.
    assert verdict.without_starved_flag().problems == verdict.problems


def test_a_starved_run_without_losses_is_final(judge_with):
    verdict, _ = judge_with(run_results((ODD, None)), run_results(), starved_in=STEPS)
    assert (verdict.score, verdict.starved, verdict.problems) == (30, False, ())


def test_a_second_definition_is_reported_if_points_are_lost(judge_with):
    twice = json.loads(fill_in(FILTER, {}))
    for name in ("filter_ground", "voxel_grid"):
        for number in (1, 2):
            source = f"def {name}(cloud):\n    return {number}"
            twice["cells"].append({"cell_type": "code", "metadata": {}, "source": source})
    others = tuple(run_results().outcomes_of("voxel_grid"))
    better = {"voxel_grid": CarriedForwardResult(others, "A helper is wrong.", PROGRAM)}
    about = {"text": json.dumps(twice), "better": better}
    verdict, _ = judge_with(
        run_results((FAILURE, None), (FAILURE, None), problems=("A cell.",)), **about
    )
    *problems, last = verdict.problems
    assert problems == ["A cell.", "A helper is wrong."]
    assert last.startswith("filter_ground is defined 3 times")


@pytest.fixture
def reference(monkeypatch):
    """Return a function that returns the complaints about a solution with given results."""

    def complaints(*tries):
        waiting = list(tries)
        monkeypatch.setattr(judging, "run_program", lambda *about: waiting.pop(0))
        return judging.reference_failures.__wrapped__(FILTER, 7, None), len(waiting)

    return complaints


def test_a_faulty_test_fails_the_solution_twice(reference):
    broken = run_results((FAILURE, None), problems=("A cell.",))
    complaints = ("filter_ground, filter_ground 0: CheckFailed: no", "A cell.")
    assert reference(run_results()) == ((), 0)
    assert reference(broken, run_results()) == ((), 0)
    assert reference(broken, broken) == (complaints, 0)
    fault = RunResults((), fault="pytest ran 3 of 9 tests", problems=("A cell.",))
    assert reference(broken, fault) == (("pytest ran 3 of 9 tests",), 0)


def test_a_notebook_of_an_unknown_lesson_is_refused():
    nameless = b'{"cells": [], "metadata": {}}'
    for data, message in ((nameless, "cannot be matched with a lesson"), (b"", "is empty")):
        with pytest.raises(judging.UnknownLesson, match=message):
            judging.judge_files(SubmittedFiles("my homework.ipynb", data), 7, None)
    verdict = judging.judge_files(SubmittedFiles("06_filter_ground.ipynb", b""), 7, None)
    assert (verdict.status, verdict.score, verdict.max_score) == (JUDGED, 0.0, 30.0)
    assert "is empty" in verdict.problems[0] and not verdict.starved
    assert [exercise.tests for exercise in verdict.exercises] == [(), ()]


def test_a_failed_reader_process_is_a_judge_fault(monkeypatch):
    def fail(*about):
        raise ReadingFailed("There was no memory.")

    monkeypatch.setattr(judging, "prepare_to_judge", fail)
    verdict = judging.judge_files(SubmittedFiles("06_filter_ground.ipynb", b"{}"), 7, None)
    assert (verdict.status, verdict.faults) == ("judge_failed", ("There was no memory.",))
    assert verdict.problems == (judging.JUDGE_FAILED_NOTE,)


def test_results_of_judging_are_immutable():
    for kind in (
        CarriedForwardResult,
        judging._Decision,
        RunResults,
        JudgingContext,
        Verdict,
        CheckResult,
        ExerciseResult,
    ):
        assert kind.__dataclass_params__.frozen


# ---- messages about an exercise -------------------------------------------------------------


FLIPPED = Mistake("It is upside down.", predict=np.flip)


def test_a_verdict_has_the_outcome_of_each_check():
    runs = run_results((None, FAILURE), mistakes={"filter_ground": FLIPPED})
    exercise = FILTER.machine_graded[0]
    result = result_of(exercise, runs, None)
    half, message = exercise.points / 2, "It is upside down.\nno"
    more = f"{message}\nThe check in the notebook shows your answer next to the right one."
    assert result.tests == (
        CheckResult("filter_ground 0", "title 0", True, half, half, "", True),
        CheckResult("filter_ground 1", "title 1", False, 0.0, half, more, True),
    )
    assert (result.name, result.score, result.max_score) == ("filter_ground", half, 2 * half)
    assert (result.cause, result.first) == (message, "filter_ground 1")
    right = result_of(exercise, run_results(), None)
    assert (right.cause, right.first, right.score) == ("", "", 2 * half)


def test_a_stub_has_no_failed_check():
    stub = StudentError("filter_ground", "NotImplementedError")
    result = result_of(FILTER.machine_graded[0], run_results((stub, stub)), None)
    assert result.first == "" and "is not started" in result.cause


def test_messages_of_a_run_with_right_helpers_are_shortened():
    better = CarriedForwardResult(
        tuple(
            run_results((None, CheckFailed("4 of 9 rows", yours="9"))).outcomes_of("filter_ground")
        ),
        "A helper is wrong.",
        PROGRAM,
    )
    runs = run_results((FAILURE, FAILURE), mistakes={"filter_ground": FLIPPED})
    result = result_of(FILTER.machine_graded[0], runs, better)
    assert result.score == FILTER.machine_graded[0].points / 2
    assert result.cause == "A helper is wrong.\n… of … rows\nHint: a hint"
    assert result.tests[1].message.startswith("… of … rows\nHint: a hint\n")
