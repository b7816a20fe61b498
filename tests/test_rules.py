"""The judge's own rules, each by itself: no notebook is judged here."""

import dataclasses
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from grader.classroom import grade
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.course.variants import fill_in
from grader.intake.handed_in import HandedIn
from grader.intake.preflight import prepare
from grader.judging import followed
from grader.judging.trial import Asked, Setting
from grader.judging.verdict import JUDGED, Verdict, write_verdict
from grader.lms import gradebook
from grader.sandbox.program import Program
from utils.checks import Check
from utils.checks.failures import CheckFailed
from utils.checks.outcomes import Outcome
from utils.simulator.ground import Ground
from utils.simulator.pose import Pose

LINE = find_lesson("02_ransac_line")
FILTER = find_lesson("06_filter_ground")
WRITTEN = find_lesson("12_streaming_obstacles")
NO = CheckFailed("no")


# ---- right helpers -----------------------------------------------------------------------------


def outcomes_of(exercise, *held):
    return [
        Outcome(Check(f"check {number}", exercise, "a title", "a hint"), None if holds else NO)
        for number, holds in enumerate(held)
    ]


def follow(monkeypatch, uses, outcomes, again):
    """What comes of `follow_through`; and the programs that were asked a second time."""
    programs = []

    def ask(setting, program, wanted):
        programs.append(program)
        return Asked(tuple(outcome for outcome in again if wanted(outcome.check)))

    monkeypatch.setattr(followed, "ask", ask)
    program = Program(("pass",), LINE.names)
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
