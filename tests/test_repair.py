"""One slip costs one slip: where one edit makes an answer right, most of its points stay."""

import json

import pytest

from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.intake.submission import SubmittedFiles
from grader.judging import repair, results
from grader.judging.judge import judge_files
from grader.judging.verdict import read_verdict, write_verdict
from grader.lms.autograded import score_output
from grader.sandbox import Limits
from tests.test_slips import solution_of

pytestmark = pytest.mark.slow

SEED = 23
LINE = find_lesson("02_ransac_line")

WITH_A_WRONG_SIGN = """
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    a, b = -dy / length, dx / length
    return a, b, a * p[0] + b * p[1]
"""
IN_TWO_PLACES = WITH_A_WRONG_SIGN.replace("length == 0", "length == 1").replace(
    "dx / length", "dx * length"
)
IN_A_HELPER = """
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
EITHER_WAY = """
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
ENDLESS = WITH_A_WRONG_SIGN.replace(
    "    length = np.hypot(dx, dy)\n",
    "    length = np.hypot(dx, dy)\n    while length >= 0:\n        pass\n",
)


def judged(sandbox, lesson=LINE, limits=None, **answers):
    """The results of a notebook of right answers but for some."""
    right = {exercise.name: solution_of(exercise.name) for exercise in lesson.machine_graded}
    text = fill_in(lesson, right | {name: text.strip() for name, text in answers.items()})
    handed_in = SubmittedFiles(f"{lesson.name}.ipynb", text.encode())
    verdict = judge_files(handed_in, SEED, sandbox, lesson, limits=limits)
    return verdict, {exercise.name: exercise for exercise in verdict.exercises}


def test_a_slip_keeps_three_fifths_and_is_shown_by_its_line(sandbox, tmp_path):
    verdict, exercises = judged(sandbox, line_through=WITH_A_WRONG_SIGN)
    line = exercises["line_through"]
    assert (line.score, line.max_score) == (3.0, 5.0)
    assert exercises["ransac_line"].score == exercises["ransac_line"].max_score
    assert line.slip.before == "    return a, b, a * p[0] + b * p[1]"
    assert line.slip.after != line.slip.before
    assert f"line {line.slip.line} " in line.slip.sentence
    write_verdict(verdict, tmp_path / "verdict.json")
    assert read_verdict(tmp_path / "verdict.json") == verdict
    # Whoever is graded reads where, and not what.
    published = verdict.as_dict()["exercises"][0]["slip"]
    assert published == {"cell": line.slip.cell, "line": line.slip.line, "score": 3.0}
    assert line.slip.sentence in score_output(line)["data"]["text/html"]
    assert line.slip.after.strip() not in score_output(line)["data"]["text/html"]
    assert json.loads(score_output(line)["data"]["text/plain"]) == 3.0


def test_what_is_wrong_in_more_than_one_place_keeps_what_its_checks_earn(sandbox):
    _, exercises = judged(sandbox, line_through=IN_TWO_PLACES)
    line = exercises["line_through"]
    assert line.slip is None
    assert line.score == sum(test.score for test in line.tests) < 3


def test_a_slip_in_a_helper_of_ones_own_is_a_slip(sandbox):
    _, exercises = judged(sandbox, line_through=IN_A_HELPER)
    assert exercises["line_through"].score == 3.0
    # Turned by the one quarter or by the other.
    assert exercises["line_through"].slip.before in IN_A_HELPER[: IN_A_HELPER.index("def line")]


def test_an_endless_loop_costs_no_process_for_each_edit(sandbox, monkeypatch):
    """What hangs is interrupted where it is."""
    started, tried = [], []
    start, hold_with = type(sandbox).start, repair._Questions.hold_with

    def noted_start(*about, **more):
        started.append(about)
        return start(*about, **more)

    def noted_edit(questions, number):
        tried.append(number)
        return hold_with(questions, number)

    monkeypatch.setattr(type(sandbox), "start", noted_start)
    monkeypatch.setattr(repair._Questions, "hold_with", noted_edit)
    limits = Limits(call_seconds=0.4, restarts=1)
    _, exercises = judged(sandbox, limits=limits, line_through=ENDLESS)
    assert exercises["line_through"].score == 0 and exercises["line_through"].slip is None
    assert len(tried) > 10 and len(started) < 10 + len(tried) / 4


def test_an_edit_is_looked_for_in_what_calls_a_wrong_function(sandbox):
    """With a right helper in the place of the wrong one."""
    wrong = solution_of("ransac_line").replace("max_iterations)", "max_iterations - 1)", 1)
    assert wrong != solution_of("ransac_line")
    _, exercises = judged(sandbox, line_through=IN_TWO_PLACES, ransac_line=wrong)
    assert exercises["line_through"].slip is None
    assert "max_iterations - 1" in exercises["ransac_line"].slip.before


LOST_ROWS_STAY = """
def drop_invalid(cloud):
    finite = np.isfinite(cloud)
    rows = finite[:, 0] & finite[:, 1] & finite[:, 2]
    return cloud[rows]
"""
# The same, and a row is lost where several are alike.
AND_MORE = LOST_ROWS_STAY.replace("return cloud[rows]", "return np.unique(cloud[rows], axis=0)")
NOTHING_IS_DROPPED = "def drop_invalid(cloud):\n    return cloud.copy()"


def test_a_named_mistake_that_explains_every_answer_is_one_slip(sandbox):
    """Half of the rule is missing, which no edit adds."""
    lesson = find_lesson("01_point_clouds")
    _, exercises = judged(sandbox, lesson, drop_invalid=LOST_ROWS_STAY)
    drop = exercises["drop_invalid"]
    assert drop.cause.startswith("Returns at (0, 0, 0) stay.")
    assert drop.slip.cell == 0 and drop.score >= 3.0
    assert drop.slip.sentence.startswith("The mistake that is named here explains every answer.")
    assert drop.slip.sentence in score_output(drop)["data"]["text/html"]
    for answer in (AND_MORE, NOTHING_IS_DROPPED):
        _, exercises = judged(sandbox, lesson, drop_invalid=answer)
        assert exercises["drop_invalid"].slip is None


@pytest.mark.parametrize("otherwise", ["a, b, a * p[0] + b * p[1]", "None", "b, a, 0"])
def test_a_coin_earns_no_more_than_whoever_writes_its_wrong_side_down(sandbox, otherwise):
    """Whatever edit makes a coin right makes that right, too; and the coin may still fall wrong."""
    earned = []
    for heads in ("np.random.default_rng().random() < 0.5", "False", "True"):
        text = EITHER_WAY.format(heads=heads, otherwise=otherwise)
        _, exercises = judged(sandbox, line_through=text)
        earned.append(exercises["line_through"].score)
    coin, wrong, right = earned
    assert coin <= wrong <= 3.0 < right == 5.0


def test_nothing_is_looked_for_in_a_stub(sandbox, monkeypatch):
    asked = []
    monkeypatch.setattr(repair, "repair_of", lambda *about: asked.append(about[2]))
    text = LINE.released.read_bytes()
    judge_files(SubmittedFiles(f"{LINE.name}.ipynb", text), SEED, sandbox, LINE)
    assert asked == []


def test_a_course_may_do_without(sandbox, monkeypatch):
    for module in (repair, results):
        monkeypatch.setattr(module, "ONE_SLIP_KEEPS", 0)
    _, exercises = judged(sandbox, line_through=WITH_A_WRONG_SIGN)
    assert exercises["line_through"].slip is None
    assert exercises["line_through"].score < 1
