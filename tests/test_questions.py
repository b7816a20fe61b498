"""Questions about students' own code have one right answer, which running the code confirms."""

import ast
import collections
import dataclasses
import inspect
import io
import itertools
import json
import re
import time
import xml.etree.ElementTree as ET
import zipfile
from random import Random

import numpy as np
import pytest

from grader import cli, commands
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import all_lessons, lesson_of
from grader.course.paths import Course
from grader.judging.verdict import JUDGED, ExerciseResult, Verdict, write_verdict
from grader.questions.answer import MAX_CPU_SECONDS, Answer, Edit, ListedLine, observe
from grader.questions.kinds import KINDS
from grader.questions.pages import write_pages
from grader.questions.question import DEPTHS, OutcomeClaim, Question
from grader.questions.quizzes import moodle_quiz, qti_quiz, write_quizzes
from grader.questions.remarks import remarks_on
from grader.questions.selection import candidates, choose_questions, peer_outcomes
from grader.questions.verification import Verifier
from grader.questions.viva import Sheet
from grader.sandbox.student import StudentProxy
from tests.course_lessons import COURSE
from utils.notebooks.reading import decode_notebook
from utils.questions.cases import cases_of
from utils.questions.choices import arrange, distractors
from utils.questions.texts import outcome_text, same_answer, similarity, value_text

EXERCISES = [exercise.name for lesson in COURSE for exercise in lesson.machine_graded]
HOSTILE = "</pre></code><script>alert(1)</script>]]>&amp;\x00\"'`"
SECONDS = 20.0  # an answer takes less than 5 on a quiet machine


def answer_with(exercise, source):
    """Return the answer of a notebook that contains only one answer."""
    lesson = lesson_of(exercise)
    text = fill_in(lesson, {exercise: source})
    return Answer(lesson, exercise, decode_notebook(text.encode(), lesson.name).code, {})


def right_answers(exercise):
    return [answer for answer in answers_to(exercise) if answer.right]


# ---- texts of values -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ([1.0, 2, True, None], "[1, 2, True, None]"),
        ([-0.0, 0.12349, 1 / 3], "[0, 0.123, 0.333]"),
        (float("inf"), "inf"),
        ({"set": [2, 3]}, "{2, 3}"),
        ({"dict": [[1, [2]]]}, "{1: [2]}"),
        ({"other": None}, ""),
        ({"set": 3}, ""),
        (object(), ""),
        (b"bytes", ""),
        ([0] * 200, ""),
        (10**12, ""),
    ],
)
def test_only_values_with_short_texts_are_shown(value, text):
    assert value_text(value) == text


def test_a_deeply_nested_value_is_not_asked_about():
    value = []
    for _ in range(100_000):
        value = [value]
    assert value_text(value) == ""


@pytest.mark.parametrize(
    "outcome",
    [None, [], ["value"], ["error", "no name!"], ["error", 3], ["varies"], "value", {"value": 1}],
)
def test_an_unknown_outcome_has_no_text(outcome):
    assert outcome_text(outcome) == ""


def test_equal_answers_of_different_types_are_one_choice():
    assert same_answer("[True, False]", "[1, 0]") and same_answer("{1, 2}", "[1, 2]")
    assert distractors("[1, 0]", ["[True, False]", "[0, 0]", "[False, 0]", "", "[1, 1]"]) == [
        "[0, 0]",
        "[1, 1]",
    ]


def test_the_reversed_vector_of_a_plane_is_not_a_wrong_choice():
    plane = "[0.6, 0, -0.8, 2]"
    assert distractors(plane, ["[-0.6, 0, 0.8, -2]", "[0.6, 0, 0.8, 2]"]) == ["[0.6, 0, 0.8, 2]"]
    assert distractors("3", ["-3"]) == ["-3"], "the sign of a number is not free"
    assert distractors("['1.2.3', 0]", ["[1.2.3.4, 0]"]) == ["[1.2.3.4, 0]"]
    assert distractors("[True, False]", ["[1, 1]", "[0, 1]"]) == ["[1, 1]", "[0, 1]"]


def test_distractors_look_like_the_right_choice():
    candidates = ["an error: TypeError", "None", "[0.5, 1]", "[3, 3]", "[2, 2]", "[2, 2]"]
    assert distractors("[1, 2]", candidates) == ["[2, 2]", "[3, 3]", "None"]
    assert similarity("[1, 2]", "[3, 3]") > similarity("[1, 2]", "an error: TypeError")


def test_choices_are_shuffled_and_a_question_with_two_choices_is_dropped():
    assert arrange("1", ["2"], Random(1)) is None
    keys = {arrange("1", ["2", "3", "4"], Random(seed))[1] for seed in range(50)}
    assert keys == {0, 1, 2, 3}


# ---- cases ---------------------------------------------------------------------------------------


def test_each_exercise_has_small_cases():
    for lesson in COURSE:
        for exercise in (exercise.name for exercise in lesson.machine_graded):
            own = cases_of(exercise)
            assert len(own) >= 4 and len(set(own)) == len(own), exercise
            for case in own:
                for code in filter(None, (case.code, case.larger, case.run)):
                    assert isinstance(ast.parse(code).body[-1], ast.Expr), code
                    assert max(map(len, code.split("\n"))) <= 100, code


def test_cases_share_no_array_with_hidden_tests():
    for lesson in COURSE:
        hidden = {
            ast.dump(node)
            for node in ast.walk(ast.parse(lesson.tests.read_text("utf-8")))
            if isinstance(node, (ast.List, ast.Tuple)) and len(list(ast.walk(node))) > 12
        }
        for exercise in lesson.machine_graded:
            for case in cases_of(exercise.name):
                nodes = ast.walk(ast.parse(case.code))
                assert not hidden & set(map(ast.dump, nodes)), case.code


# ---- questions -----------------------------------------------------------------------------------


def exec_outcome(cells, claim):
    """Return the value of a case in this process, with an edit in a cell of a trusted answer."""
    cells = [cell.split("\n") for cell in cells]
    if claim.edit:
        cell, first, last, text = claim.edit.row
        cells[cell - 1][first - 1 : last] = text.split("\n")
    space = {"np": np, "rng": 5}
    own = {number for number, cell in enumerate(cells) if any("filter_clusters" in x for x in cell)}
    for number in sorted(own):
        source = "\n".join(line for line in cells[number] if not line.startswith("check("))
        if "def filter_clusters" in source:
            exec(source, space)
    *statements, last = ast.parse(claim.code).body
    exec(compile(ast.Module(statements, []), "case", "exec"), space)
    value = eval(compile(ast.Expression(last.value), "case", "eval"), space)
    return value_text(np.asarray(value).tolist())


@pytest.mark.slow
def test_keys_agree_with_code_that_runs_outside_the_grader(sandbox):
    """The answer is trusted, so it can run in this process, without the observer."""
    answer = answer_with("filter_clusters", right_answers("filter_clusters")[0].source)
    behaviour = observe(answer, sandbox)
    compared = 0
    for question in candidates(behaviour, Random(1)):
        for claim in question.claims:
            if isinstance(claim, OutcomeClaim) and "error" not in claim.text:
                try:
                    value = exec_outcome(answer.cells, claim)
                except Exception:
                    assert not claim.holds, (question, claim)
                else:
                    assert same_answer(value, claim.text) == claim.holds, (question, claim)
                    compared += 1
    assert compared > 50


@pytest.mark.slow
def test_a_wrong_key_is_not_confirmed(sandbox):
    answer = answer_with("filter_clusters", right_answers("filter_clusters")[1].source)
    behaviour = observe(answer, sandbox)
    questions = candidates(behaviour, Random(1))
    by_kind = {question.kind: question for question in questions}
    assert {"predict", "trace", "cost", "what if", "which line"} <= by_kind.keys()
    with Verifier(behaviour, sandbox) as verifier:
        for question in by_kind.values():
            assert verifier.confirms(question), question
            for claim in question.claims:
                wrong = {
                    "OutcomeClaim": {"text": "[7, 7]", "holds": True},
                    "CountClaim": {"count": 39},
                    "ValueClaim": {"text": "39"},
                }[type(claim).__name__]
                changed = dataclasses.replace(claim, **wrong)
                assert not verifier.confirms(dataclasses.replace(question, claims=(changed,)))


@pytest.mark.slow
def test_chosen_questions_are_reproducible_and_get_deeper(sandbox):
    answer = answer_with("euclidean_clustering", right_answers("euclidean_clustering")[0].source)
    behaviour = observe(answer, sandbox)
    chosen = [choose_questions(behaviour, sandbox, 4, Random("a seed")) for _ in range(2)]
    assert chosen[0] == chosen[1] and len(chosen[0]) == 4
    depths = [DEPTHS[question.kind] for question in chosen[0]]
    assert depths == sorted(depths) and len(set(depths)) == 4
    for first, second in itertools.combinations(chosen[0], 2):
        if {first.kind, second.kind} in ({"predict", "which line"}, {"trace", "cost"}):
            shared = {c.code for c in first.claims} & {c.code for c in second.claims}
            assert not shared, "one question may reveal the answer to another"
    others = {choose_questions(behaviour, sandbox, 3, Random(seed))[0] for seed in range(3)}
    assert len(others) > 1


@pytest.mark.slow
def test_a_question_says_if_all_right_answers_have_the_same_result(sandbox):
    """Labels may be numbered in any order, so a label follows from the code, not from the task."""
    by_name = {answer.name: answer.source for answer in right_answers("euclidean_clustering")}
    backwards = by_name["SciPy's neighbours, clusters numbered from the last point"]
    lesson = lesson_of("euclidean_clustering")
    peers = peer_outcomes(lesson, "euclidean_clustering", sandbox)
    behaviour = observe(answer_with("euclidean_clustering", backwards), sandbox, peers)
    predictions = {q.code: q for q in candidates(behaviour, Random(1)) if q.kind == "predict"}
    assert {question.is_about_code for question in predictions.values()} == {True, False}
    one_cluster = next(code for code in predictions if "[0.0, 3.0, 2.0, 1.0]" in code)
    assert not predictions[one_cluster].is_about_code
    plain = answer_with("filter_clusters", right_answers("filter_clusters")[0].source)
    peers = peer_outcomes(lesson_of("filter_clusters"), "filter_clusters", sandbox)
    behaviour = observe(plain, sandbox, peers)
    predictions = [q for q in candidates(behaviour, Random(1)) if q.kind == "predict"]
    assert predictions and not any(question.is_about_code for question in predictions)


@pytest.mark.slow
def test_remarks_name_syntax_and_functions_that_lessons_have_not_shown(sandbox):
    source = (
        "import itertools\n\n\ndef filter_ground(cloud, ground_level=-1.2):\n"
        "    keep = [(z := row[2]) >= ground_level for row in cloud]\n"
        "    return np.array(list(itertools.compress(cloud, keep))).reshape(-1, cloud.shape[1])\n"
    )
    behaviour = observe(answer_with("filter_ground", source), sandbox)
    remarks = {remark.text: remark.lines for remark in remarks_on(behaviour)}
    assert remarks["the operator :="] == (3,) and remarks["`compress`"] == (4,)
    assert "`array`" not in remarks and "`shape`" not in remarks
    hints = next(answer for answer in right_answers("filter_ground") if answer.follows_hints)
    assert not remarks_on(observe(answer_with("filter_ground", hints.source), sandbox))


PROVEN = [pytest.param(exercise, marks=pytest.mark.proof) for exercise in EXERCISES]


@pytest.mark.parametrize("exercise", PROVEN)
def test_each_right_answer_has_five_verified_questions_of_three_kinds(
    exercise, sandbox, monkeypatch
):
    processor_seconds = collections.Counter()
    close = StudentProxy.close

    def close_and_count(proxy):
        processor_seconds["sandbox"] += proxy.cpu_seconds
        close(proxy)

    monkeypatch.setattr(StudentProxy, "close", close_and_count)
    for kept in right_answers(exercise):
        processor_seconds.clear()
        start = time.process_time()
        behaviour = observe(answer_with(exercise, kept.source), sandbox)
        chosen = choose_questions(behaviour, sandbox, 5, Random(kept.name))
        seconds = time.process_time() - start + processor_seconds["sandbox"]
        assert len(chosen) == 5, kept.name
        assert len({question.kind for question in chosen}) >= 3, kept.name
        assert seconds < SECONDS, kept.name
        for question in chosen:
            assert 3 <= len(question.choices) <= 4 and 0 <= question.key < len(question.choices)
            pairs = [(a, b) for a in question.choices for b in question.choices if a is not b]
            assert not any(same_answer(a, b) for a, b in pairs), question


@pytest.mark.slow
def test_fewer_edits_of_an_answer_that_makes_many_calls_are_tried(sandbox):
    source = (
        "def horizontal_distance(cloud):\n"
        "    squares = [row[0] ** 2 + row[1] ** 2 for row in cloud]\n"
        "    delay = sum(abs(number) for number in range({}))\n"
        "    return [square**0.5 + 0 * delay for square in squares]\n"
    )
    edits = [
        len(observe(answer_with("horizontal_distance", source.format(calls)), sandbox).edited)
        for calls in (10, 20_000)
    ]
    assert 10 < 2 * edits[1] < edits[0]


def test_the_time_limit_of_an_answer_is_below_the_promised_time():
    assert MAX_CPU_SECONDS < SECONDS


# ---- hostile code --------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    "attack",
    [
        "answer_observer.read_answer = lambda *a: {'places': [[1, -5, 10**9], 'x', [0, 0, 0]], "
        "'statements': 7, 'edits': [[1, 1, 1, '<script>']], 'words': [[1, 1, 'name', 3]]}",
        "answer_observer.run_cases = lambda *a: [[{'outcome': ['value', '<script>'], "
        "'counts': [[1, 1, 'x']], 'notes': [[1, 1], 3]}]] * 999",
        "answer_observer.run_cases = lambda *a: 'nothing'",
        "answer_observer.evaluate = lambda *a: 3; answer_observer.trace_case = lambda *a: [[1]]",
    ],
)
def test_code_that_changes_the_observer_cannot_inject_markup(attack, sandbox, tmp_path):
    right = right_answers("filter_ground")[0].source
    # The import runs when the answer is first called, after the observer was loaded.
    source = f"import sys\n{right.rstrip()}\n"
    source = source.replace(
        "):\n",
        "):\n    import answer_observer, sys\n"
        f"    {attack}\n"
        "    for name in ('read_answer', 'run_cases', 'evaluate', 'trace_case'):\n"
        "        setattr(sys.modules['__main__'], name, getattr(answer_observer, name))\n",
        1,
    )
    behaviour = observe(answer_with("filter_ground", source), sandbox)
    chosen = choose_questions(behaviour, sandbox, 3, Random(1))
    sheet = Sheet("x", "x", "filter_ground", behaviour.lines, tuple(chosen), remarks_on(behaviour))
    for path in write_pages(Course(tmp_path), "stage3_obstacles", [sheet]):
        assert "<script" not in path.read_text("utf-8")


def hostile_sheet():
    edit = Edit(1, 1, HOSTILE, HOSTILE, (1, 1, 1, HOSTILE))
    question = Question(
        "what if",
        f"Line 1 becomes `{HOSTILE.replace('`', '')}`.",
        HOSTILE,
        (HOSTILE, f"line 1 becomes `{HOSTILE}`", "[1]"),
        2,
        HOSTILE,
        True,
        (OutcomeClaim("x", edit, HOSTILE),),
    )
    line = ListedLine(1, 1, 1, HOSTILE)
    return Sheet("ada", HOSTILE, HOSTILE, (line,), (question,), (), HOSTILE)


def test_pages_are_escaped(tmp_path):
    stage = HOSTILE.translate({ord("/"): "_", 0: "_"})
    for path in write_pages(Course(tmp_path), stage, [hostile_sheet()]):
        page = path.read_text("utf-8")
        assert "<script" not in page and "alert(1)" in page
        assert page.count("</pre>") == page.count("<pre>")


def test_quizzes_are_valid_xml_with_escaped_code():
    sheet = hostile_sheet()
    quiz = ET.fromstring(moodle_quiz(sheet, HOSTILE))
    _, question = quiz.findall("question")
    fractions = [answer.get("fraction") for answer in question.findall("answer")]
    assert fractions == ["0", "0", "100"] and question.find("defaultgrade").text == "0"
    html = question.find("questiontext/text").text
    assert "<script" not in html and "alert(1)" in html
    archive = zipfile.ZipFile(io.BytesIO(qti_quiz(sheet, HOSTILE)))
    assert sorted(archive.namelist()) == ["imsmanifest.xml", "quiz.xml"]
    ET.fromstring(archive.read("imsmanifest.xml"))
    space = {"q": "http://www.imsglobal.org/xsd/ims_qtiasiv1p2"}
    item = ET.fromstring(archive.read("quiz.xml")).find(".//q:item", space)
    assert item.find(".//q:varequal", space).text == "C"
    assert [label.get("ident") for label in item.iterfind(".//q:response_label", space)] == [*"ABC"]
    assert not any("<script" in (text.text or "") for text in item.iterfind(".//q:mattext", space))


# ---- classes -------------------------------------------------------------------------------------

STAGE = "stage3_obstacles"


def make_class(root, count):
    """Write the submissions of a class with right answers, and verdicts with full points."""
    course = Course(root)
    for number in range(count):
        for lesson in (candidate for candidate in all_lessons() if candidate.stage == STAGE):
            answers = {
                exercise.name: right_answers(exercise.name)[number % 5].source
                for exercise in lesson.machine_graded
            }
            path = course.submitted / f"student{number:02}" / STAGE / f"{lesson.name}.ipynb"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(fill_in(lesson, answers), "utf-8")
            give_full_points(course, f"student{number:02}", lesson)
    return course


def give_full_points(course, student, lesson):
    from grader.classroom.submissions import find_submissions

    (submission,) = [
        submission
        for submission in find_submissions(course, [lesson.stage])
        if (submission.student, submission.lesson) == (student, lesson)
    ]
    results = tuple(
        ExerciseResult(exercise.name, exercise.points, exercise.points, ())
        for exercise in lesson.machine_graded
    )
    fingerprint = submission.read(course).fingerprint()
    verdict = Verdict(
        lesson.name, student, JUDGED, 0, 0, results, (), 0.1, "", fingerprint=fingerprint
    )
    path = submission.verdict_path(course)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_verdict(verdict, path)


@pytest.fixture
def course(tmp_path, monkeypatch):
    course = Course(tmp_path)
    monkeypatch.setattr(commands, "Course", lambda: course)
    return course


@pytest.mark.slow
def test_one_command_writes_the_sheets_of_a_class(course, sandbox, monkeypatch, capsys):
    monkeypatch.setattr(commands, "choose_sandbox", lambda *_: sandbox)
    make_class(course.root, 5)
    (course.submitted / "late" / STAGE).mkdir(parents=True)
    (course.submitted / "late" / STAGE / "06_filter_ground.ipynb").write_text(
        fill_in(lesson_of("filter_ground"), {}), "utf-8"
    )
    verdicts = {path: path.read_bytes() for path in course.verdicts.rglob("*.json")}
    call = ["viva", STAGE, "--seed", str(2**70), "--workers", "2"]
    assert cli.main(call) == 0
    printed = capsys.readouterr()
    assert "06_filter_ground has not been graded. Run: python -m grader grade" in printed.err
    folder = course.root / "viva" / STAGE
    sheets, key = ((folder / name).read_text("utf-8") for name in ("sheets.html", "key.html"))
    assert sheets.count("<section>") == 5 and sheets.count('class="question"') == 15
    assert 'class="right"' not in sheets and key.count('class="right"') == 15
    assert len(list((folder / "quizzes").iterdir())) == 10
    assert len(set(re.findall(r"<code>(\w+)</code></p>\n<p class=\"name\">", sheets))) > 2
    assert {path: path.read_bytes() for path in course.verdicts.rglob("*.json")} == verdicts

    assert cli.main([*call, "--student", "student04"]) == 0
    own = (folder / "student04" / "sheets.html").read_text("utf-8")
    (section,) = re.findall(r"<section>.*?</section>", own, re.S)
    assert section in sheets, "the same seed gives the same questions"


def test_a_changed_submission_is_not_asked_about(course, sandbox, monkeypatch, capsys):
    monkeypatch.setattr(commands, "choose_sandbox", lambda *_: sandbox)
    lesson = lesson_of("filter_clusters")
    path = course.submitted / "ada" / STAGE / f"{lesson.name}.ipynb"
    path.parent.mkdir(parents=True)
    path.write_text(fill_in(lesson, {}), "utf-8")
    give_full_points(course, "ada", lesson)
    path.write_text(json.dumps({**json.loads(path.read_text()), "nbformat_minor": 4}), "utf-8")
    assert cli.main(["viva", STAGE, "--seed", str(2**70), "--workers", "1"]) == 0
    assert "was replaced after it was judged" in " ".join(capsys.readouterr().err.split())
    assert not list((course.root / "viva" / STAGE).glob("quizzes/*"))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("viva stage9", "There is no stage stage9. The stages are:"),
        (f"viva {STAGE} --student nobody", "'nobody'"),
        (f"viva {STAGE} --seed 5", "The seed 5 is so small"),
        (f"viva {STAGE} --seed {2**70}", "Run: python -m grader collect ARCHIVE"),
    ],
)
def test_usage_errors_say_what_to_do(call, message, course, sandbox, monkeypatch, capsys):
    monkeypatch.setattr(commands, "choose_sandbox", lambda *_: sandbox)
    assert cli.main(call.split()) == 2
    assert message in capsys.readouterr().err
    assert not (course.root / "viva").exists()


def test_the_error_about_a_stage_without_cases_suggests_a_fix(course, monkeypatch, capsys):
    monkeypatch.setattr("utils.questions.cases.cases_of", lambda exercise: ())
    assert cli.main(["viva", STAGE]) == 2
    assert "Write them in utils/questions/" in capsys.readouterr().err


def test_every_kind_of_question_has_a_depth():
    for questions, kind in zip(KINDS, DEPTHS, strict=True):
        assert f'"{kind}",' in inspect.getsource(inspect.getmodule(questions))


def test_quizzes_are_written_only_for_students_with_questions(tmp_path):
    folder = write_quizzes(Course(tmp_path), STAGE, [hostile_sheet(), Sheet("bob", "Bob")])
    assert sorted(path.name for path in folder.iterdir()) == ["ada.moodle.xml", "ada.qti.zip"]
