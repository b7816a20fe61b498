"""An answer that is one edit away from a right one keeps most of its points."""

import itertools
import json
import os
import signal
import statistics

import pytest

from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.intake.submission import SubmittedFiles
from grader.judging import program_run, repair, results
from grader.judging.judge import judge_files
from grader.judging.verdict import read_verdict, write_verdict
from grader.lms.autograded_copy import score_output
from grader.sandbox import Limits, launcher
from tests.slip_tables import solution_of

pytestmark = pytest.mark.slow

SEED = 23
LINE = find_lesson("02_ransac_line")

WRONG_SIGN = """
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    a, b = -dy / length, dx / length
    return a, b, a * p[0] + b * p[1]
"""
TWO_MISTAKES = WRONG_SIGN.replace("length == 0", "length == 1").replace(
    "dx / length", "dx * length"
)
BAD_HELPER = """
def normal_of(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    return dy, dx

def line_through(p, q):
    normal = np.array(normal_of(p, q))
    length = np.hypot(*normal)
    if length == 0:
        return None
    a, b = normal / length
    return a, b, -a * p[0] - b * p[1]
"""
RANDOM_ANSWER = """
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    a, b = -dy / length, dx / length
    if {heads}:
        return a, b, -(a * p[0] + b * p[1])
    return {otherwise}
"""
ENDLESS = WRONG_SIGN.replace(
    "    length = np.hypot(dx, dy)\n",
    "    length = np.hypot(dx, dy)\n    while length >= 0:\n        pass\n",
)


def judge_with(sandbox, lesson=LINE, limits=None, **answers):
    """Judge a notebook of right answers, some of which are replaced.

    Returns
    -------
    tuple
        The verdict, and the result of each exercise by name.
    """
    right = {exercise.name: solution_of(exercise.name) for exercise in lesson.machine_graded}
    text = fill_in(lesson, right | {name: text.strip() for name, text in answers.items()})
    submission = SubmittedFiles(f"{lesson.name}.ipynb", text.encode())
    verdict = judge_files(submission, SEED, sandbox, lesson, limits=limits)
    return verdict, {exercise.name: exercise for exercise in verdict.exercises}


def test_a_slip_keeps_three_fifths_of_the_points_and_names_its_line(sandbox, tmp_path):
    verdict, exercises = judge_with(sandbox, line_through=WRONG_SIGN)
    line = exercises["line_through"]
    assert (line.score, line.max_score) == (3.0, 5.0)
    assert exercises["ransac_line"].score == exercises["ransac_line"].max_score
    assert line.slip.before == "    return a, b, a * p[0] + b * p[1]"
    assert line.slip.after != line.slip.before
    assert f"line {line.slip.line} " in line.slip.sentence
    write_verdict(verdict, tmp_path / "verdict.json")
    assert read_verdict(tmp_path / "verdict.json") == verdict
    # Students see where the slip is, but not the correction.
    published = verdict.as_dict()["exercises"][0]["slip"]
    assert published == {"cell": line.slip.cell, "line": line.slip.line, "score": 3.0}
    assert line.slip.sentence in score_output(line)["data"]["text/html"]
    assert line.slip.after.strip() not in score_output(line)["data"]["text/html"]
    assert json.loads(score_output(line)["data"]["text/plain"]) == 3.0


def test_an_answer_with_two_errors_keeps_only_the_points_of_its_checks(sandbox):
    _, exercises = judge_with(sandbox, line_through=TWO_MISTAKES)
    line = exercises["line_through"]
    assert line.slip is None
    assert line.score == sum(test.score for test in line.tests) < 3


def test_a_slip_in_the_students_own_helper_is_a_slip(sandbox):
    _, exercises = judge_with(sandbox, line_through=BAD_HELPER)
    assert exercises["line_through"].score == 3.0
    # A quarter turn in either direction repairs the helper.
    assert exercises["line_through"].slip.before in BAD_HELPER[: BAD_HELPER.index("def line")]


def test_an_endless_loop_does_not_need_a_process_for_each_edit(sandbox, monkeypatch):
    """Hanging calls are interrupted, so that the same process can try the next edit."""
    started, tried = [], []
    start, pass_with = type(sandbox).start, repair._FailedChecks.pass_with

    def noted_start(*about, **more):
        started.append(about)
        return start(*about, **more)

    def noted_edit(questions, number):
        tried.append(number)
        return pass_with(questions, number)

    monkeypatch.setattr(type(sandbox), "start", noted_start)
    monkeypatch.setattr(repair._FailedChecks, "pass_with", noted_edit)
    limits = Limits(call_seconds=0.4, restarts=1)
    _, exercises = judge_with(sandbox, limits=limits, line_through=ENDLESS)
    assert exercises["line_through"].score == 0 and exercises["line_through"].slip is None
    assert len(tried) > 10 and len(started) < 10 + len(tried) / 4


def test_the_caller_of_a_wrong_function_can_also_be_repaired(sandbox):
    """The search for the caller's slip uses a right helper instead of the wrong one."""
    wrong = solution_of("ransac_line").replace("max_iterations)", "max_iterations - 1)", 1)
    assert wrong != solution_of("ransac_line")
    _, exercises = judge_with(sandbox, line_through=TWO_MISTAKES, ransac_line=wrong)
    assert exercises["line_through"].slip is None
    assert "max_iterations - 1" in exercises["ransac_line"].slip.before


MATH_FOR_A_COLUMN = """
import math

def filter_by_distance(cloud, distance=10.0):
    return cloud[math.sqrt(cloud[:, 0] ** 2 + cloud[:, 1] ** 2) <= distance]
"""


def test_an_edit_can_use_numpy_even_if_the_answers_do_not(sandbox):
    lesson = find_lesson("07_filter_by_distance")
    _, exercises = judge_with(sandbox, lesson, filter_by_distance=MATH_FOR_A_COLUMN)
    slip = exercises["filter_by_distance"].slip
    assert slip.after.strip().startswith("return cloud[np.sqrt(")


KEEPS_LOST = """
def drop_invalid(cloud):
    finite = np.isfinite(cloud)
    rows = finite[:, 0] & finite[:, 1] & finite[:, 2]
    return cloud[rows]
"""
# Like KEEPS_LOST, but also drops duplicate rows.
ALSO_UNIQUE = KEEPS_LOST.replace("return cloud[rows]", "return np.unique(cloud[rows], axis=0)")
DROPS_NOTHING = "def drop_invalid(cloud):\n    return cloud.copy()"


def test_a_named_mistake_that_explains_every_answer_is_one_slip(sandbox):
    """The answer applies half of the rule. No edit fixes it, but a named mistake explains it."""
    lesson = find_lesson("01_point_clouds")
    _, exercises = judge_with(sandbox, lesson, drop_invalid=KEEPS_LOST)
    drop = exercises["drop_invalid"]
    assert drop.cause.startswith("The function keeps returns at (0, 0, 0).")
    assert drop.slip.cell == 0 and drop.score >= 3.0
    assert drop.slip.sentence.startswith("The mistake named above explains every wrong answer.")
    assert drop.slip.sentence in score_output(drop)["data"]["text/html"]
    for answer in (ALSO_UNIQUE, DROPS_NOTHING):
        _, exercises = judge_with(sandbox, lesson, drop_invalid=answer)
        assert exercises["drop_invalid"].slip is None


@pytest.mark.parametrize("otherwise", ["a, b, a * p[0] + b * p[1]", "None", "b, a, 0"])
def test_a_random_answer_earns_no_more_than_its_wrong_version(sandbox, otherwise):
    """An answer that is right or wrong at random earns no more than its wrong half alone.

    Each edit that repairs the random answer also repairs the wrong half.
    """
    earned = []
    # A single random answer may earn more by luck, so the median of five counts.
    for heads in (*["np.random.default_rng().random() < 0.5"] * 5, "False", "True"):
        text = RANDOM_ANSWER.format(heads=heads, otherwise=otherwise)
        _, exercises = judge_with(sandbox, line_through=text)
        earned.append(exercises["line_through"].score)
    *random, wrong, right = earned
    coin = statistics.median(random)
    assert coin <= wrong <= 3.0 < right == 5.0


def test_stubs_are_not_repaired(sandbox, monkeypatch):
    searched = []
    monkeypatch.setattr(repair, "find_repair", lambda *about: searched.append(about[2]))
    text = LINE.released.read_bytes()
    judge_files(SubmittedFiles(f"{LINE.name}.ipynb", text), SEED, sandbox, LINE)
    assert searched == []


def test_a_course_may_switch_slips_off(sandbox, monkeypatch):
    for module in (repair, results):
        monkeypatch.setattr(module, "ONE_SLIP_KEEPS", 0)
    _, exercises = judge_with(sandbox, line_through=WRONG_SIGN)
    assert exercises["line_through"].slip is None
    assert exercises["line_through"].score < 1


@pytest.mark.parametrize("step", ["the search for an edit", "diagnosis"])
def test_a_process_killed_for_lack_of_memory_during_a_search_is_starved(sandbox, monkeypatch, step):
    """The answer is judged again alone. Otherwise, it would lose three fifths of its points."""
    kills = itertools.count()
    monkeypatch.setattr(launcher, "oom_kill_count", lambda: next(kills))

    def kill(student):
        student.start()
        os.kill(student._worker.pids[-1], signal.SIGKILL)

    first_check_fails, diagnose = repair._FailedChecks.first_check_fails, program_run.diagnose

    searches = itertools.count()

    def search(checks):
        if next(searches) >= 10:  # far fewer than `MAX_RESTARTS`
            return first_check_fails(checks)
        kill(checks._student)
        return first_check_fails(checks) and first_check_fails(checks)

    def explain(exercise, function):
        kill(function._student)
        return diagnose(exercise, function)

    if step == "diagnosis":
        monkeypatch.setattr(program_run, "diagnose", explain)
    else:
        monkeypatch.setattr(repair._FailedChecks, "first_check_fails", search)
    verdict, _ = judge_with(sandbox, line_through=WRONG_SIGN)
    assert verdict.starved
