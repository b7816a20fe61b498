"""Attempts to steal the correct helper that replaces a student's wrong one."""

import ast

import pytest

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.judging.judge import judge
from tests.attacks.attack import SANDBOX

pytestmark = pytest.mark.slow

LINE = find_lesson("02_ransac_line")
SIGNATURE = "def ransac_line(points, max_iterations=100, distance_tolerance=0.1, rng=None):\n"
WRONG_LINE = "def line_through(first, second):\n    return 1.0, 0.0, 0.0\n"
# A function that fails exactly one check. Two equal points do not define a line, so it should
# return None.
ONE_WRONG = (
    "def line_through(first, second):\n"
    "    (x, y), (u, v) = first[:2], second[:2]\n"
    "    length = np.hypot(u - x, v - y)\n"
    "    if length == 0: return 1.0, 0.0, 0.0\n"
    "    a, b = (y - v) / length, (u - x) / length\n"
    "    return a, b, -(a * x + b * y)\n"
)

RANSAC = (
    SIGNATURE
    + """\
    rng, best = np.random.default_rng(rng), (None, np.zeros(len(points), dtype=bool))
    for _ in range(max_iterations if len(points) >= 2 else 0):
        first, second = rng.choice(len(points), 2, replace=False)
        line = line_through(points[first], points[second])
        if line is not None:
            inside = point_line_distance(points, line) <= distance_tolerance
            if inside.sum() > best[1].sum():
                best = line, inside
    return best
"""
)


def judged(lesson, tmp_path, **answers):
    path = tmp_path / f"{lesson.name}.ipynb"
    path.write_text(fill_in(lesson, answers), "utf-8")
    verdict = judge(path, 3, SANDBOX)
    return {exercise.name: exercise for exercise in verdict.exercises}, verdict


def test_feedback_does_not_reveal_the_correct_helper(tmp_path):
    """Feedback does not quote an answer that returns the code of its helper."""
    thief = RANSAC.replace("def ransac_line", "def honest") + (
        "\n" + SIGNATURE + "    if isinstance(rng, int):\n"
        "        code = line_through.__code__\n"
        "        return ' '.join(['stolen', *code.co_names, *code.co_varnames])\n"
        "    return honest(points, max_iterations, distance_tolerance, rng)\n"
    )
    results, verdict = judged(LINE, tmp_path, line_through=WRONG_LINE, ransac_line=thief)
    result = results["ransac_line"]
    assert 0.5 * result.max_score < result.score < result.max_score, (
        "it was judged with a right helper"
    )
    messages = "\n".join(test.message for test in result.tests)
    assert "must return two values" in messages
    assert "stolen" not in "\n".join([messages, result.cause, *verdict.problems])


def test_a_correct_helper_earns_no_points_for_a_wrong_one(tmp_path):
    """The wrong helper keeps its low score when a correct one replaces it for a later exercise."""
    results, _ = judged(LINE, tmp_path, line_through=WRONG_LINE, ransac_line=RANSAC)
    assert results["ransac_line"].score == results["ransac_line"].max_score
    assert results["line_through"].score < results["line_through"].max_score / 2


def test_later_exercises_are_not_replaced_for_earlier_ones(tmp_path):
    """An early exercise cannot call the correct version of a later one to obtain its answer."""
    early = "def line_through(first, second):\n    return ransac_line([first, second])[0]\n"
    results, _ = judged(LINE, tmp_path, line_through=early, ransac_line=SIGNATURE + "    return 1")
    assert results["line_through"].score < results["line_through"].max_score / 5


def test_an_unwritten_helper_is_also_replaced(tmp_path):
    answers = {"ransac_line": RANSAC}
    results, verdict = judged(LINE, tmp_path, **answers)
    assert results["line_through"].score == 0 == results["point_line_distance"].score
    assert results["ransac_line"].score == results["ransac_line"].max_score
    assert any(
        " instead, the checks of ransac_line earn " in problem for problem in verdict.problems
    )


def test_the_judge_never_parses_student_code(tmp_path, monkeypatch):
    """Student code is parsed only in the sandbox, so it cannot break the judge's parser."""
    parsed, parse = [], ast.parse
    monkeypatch.setattr(
        ast,
        "parse",
        lambda text, *more, **options: [parsed.append(str(text)), parse(text, *more, **options)][1],
    )
    marked = RANSAC + "    # a text of the student\n"
    results, verdict = judged(LINE, tmp_path, line_through=WRONG_LINE, ransac_line=marked)
    assert any("which ransac_line calls" in problem for problem in verdict.problems)
    assert parsed, "the lesson's own source is read here"
    assert not [text for text in parsed if "a text of the student" in text]


def test_a_different_answer_in_the_second_run_gains_nothing(tmp_path):
    """An answer that fails deliberately, to get a second run with correct helpers, earns little."""
    counts = ONE_WRONG.replace("    (x, y)", "    ASKED.append(1)\n    (x, y)", 1)
    turn = (
        "\n" + SIGNATURE + "    if ASKED and not MINE: return None\n"
        "    MINE.append(1)\n"
        "    return honest(points, max_iterations, distance_tolerance, rng)\n"
    )
    two_tries = "ASKED, MINE = [], []\n" + RANSAC.replace("def ransac_line", "def honest") + turn
    answers = {"line_through": counts, "ransac_line": two_tries}
    right = next(answer.source for answer in answers_to("point_line_distance") if answer.right)
    results, _ = judged(LINE, tmp_path, point_line_distance=right, **answers)
    assert results["line_through"].score < results["line_through"].max_score
    result = results["ransac_line"]
    assert result.score < result.max_score / 4
    assert "the checks of ransac_line earn" not in result.cause
