"""Questions about code are fair: students can find the one right choice on paper, from the code."""

import dataclasses
from random import Random

import numpy as np
import pytest

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import lesson_of
from grader.course.paths import Course
from grader.questions.answer import Answer, Behaviour, Edit, ListedLine, Run, Statement, observe
from grader.questions.helpers import called_helpers, sentence_about
from grader.questions.inside import answer_observer
from grader.questions.kinds.cost import cost_questions
from grader.questions.kinds.deletion import deletion_questions
from grader.questions.kinds.predict import prediction_questions
from grader.questions.kinds.trace import trace_questions
from grader.questions.kinds.what_if import what_if_questions
from grader.questions.kinds.which_line import which_line_questions
from grader.questions.pages import write_pages
from grader.questions.question import OutcomeClaim, Question, ValueClaim
from grader.questions.quizzes import moodle_quiz
from grader.questions.selection import FREE_SIGNS, candidates, choose_questions
from grader.questions.verification import Verifier
from grader.questions.viva import Sheet
from utils.notebooks import slicing
from utils.notebooks.reading import decode_notebook
from utils.questions.cases import Case, cases_of, shown_together
from utils.questions.choices import distractors
from utils.questions.shown_values import is_selection, shown_values
from utils.questions.texts import is_alike

CLOUD = "cloud = np.array([[1.0, 2.0, 0.5], [3.0, -4.0, 0.0], [np.nan, 0.0, 0.0]])\nselect(cloud)"
CASES = (Case("f(1)"),)
LINES = ("def select(cloud):", "    kept = cloud[:, :3]", "    return kept")


def edit(line, after, lines=LINES):
    return Edit(line, line, lines[line - 1], after, (1, line, line, after))


def behaviour(outcomes, own="5", lines=LINES, cases=CASES, **facts):
    """Return what is known about an answer whose edits have some outcomes, one per case."""

    def runs(table):
        return {edit(*key, lines): tuple(map(Run, texts)) for key, texts in table.items()}

    facts = {"words": (), "notes": (), "counts": {}, "deleted": {}, **facts}
    return Behaviour(
        Answer(None, "select", (), {}),
        tuple(ListedLine(number, 1, number, text) for number, text in enumerate(lines, start=1)),
        tuple(Statement(n, n, ()) for n in range(2, len(lines) + 1)),
        facts["words"],
        cases,
        tuple(Run(own, facts["counts"], facts["notes"]) for _ in cases),
        runs(outcomes),
        runs(facts["deleted"]),
    )


OTHERS = {(2, f"    kept = {n}"): (str(n),) for n in range(6, 9)}


# ---- values that the case shows ------------------------------------------------------------------


def test_the_values_of_a_case_are_its_literals_and_arrays():
    shown = shown_values(
        "plane = (0.6, -0.8)\ncloud = np.zeros((2, 4))\ncloud[0] = 7.0\nf(cloud, 3)"
    )
    assert {"0.6", "-0.8", "[0.6, -0.8]", "3", "[[7, 7, 7, 7], [0, 0, 0, 0]]"} <= shown
    assert "[[7, 7, 7], [0, 0, 0]]" in shown, "the first three columns can be read as well"
    assert "[[0, 0], [0, 0]]" not in shown


def test_a_selection_has_only_rows_of_the_cloud():
    assert is_selection("[[3, -4, 0], [1, 2, 0.5]]", CLOUD) and is_selection("[]", CLOUD)
    assert not is_selection("[[3, 4, 0]]", CLOUD) and not is_selection("[3, -4, 0]", CLOUD)
    assert not is_selection("[]", "median_order(3)"), "the case has no rows"


def test_rows_of_the_cloud_do_not_reveal_the_right_choice():
    values = ["[[3, 4, 0]]", "[[1, 2, 0.5]]", "[]", "[[9, 16, 0]]", "None"]
    assert distractors("[[3, -4, 0]]", values, CLOUD) == ["[[1, 2, 0.5]]", "[]"]
    assert distractors("[[3, -5, 0]]", values, CLOUD)[0] == "[[3, 4, 0]]"


def test_nan_is_a_wrong_choice_only_if_the_case_may_have_it():
    assert distractors("[1, 2]", ["[nan, nan]", "[2, 2]"], "f(1)") == ["[2, 2]"]
    assert "[nan, 1]" in distractors("[1, 2]", ["[nan, 1]"], CLOUD)
    assert "[nan, 1]" in distractors("None", ["[nan, 1]"], "f(1)"), "points without a plane"


@pytest.mark.parametrize("value", ["[[1, 2, 0.5], [3, -4, 0], [nan, 0, 0]]", "0.5"])
def test_a_trace_does_not_ask_for_a_value_that_the_case_shows(value):
    def traced(text):
        notes = [(2, "kept", text)]
        counts = {2: 1}
        edits = {(2, f"    kept = {n}"): ("",) for n in range(4)}
        lines = (LINES[0], "    kept = moved(cloud)", LINES[2])
        known = behaviour(edits, "5", lines, (Case(CLOUD),), notes=notes, counts=counts)
        for number, runs in enumerate(known.edited.values()):
            object.__setattr__(runs[0], "notes", ((2, "kept", f"[[{number}, 2, 0.5]]"),))
        return [question.right_choice for question in trace_questions(known, Random(1))]

    assert traced(value) == [] and traced("[[7, 2, 0.5]]") == ["[[7, 2, 0.5]]"]


@pytest.mark.parametrize(
    "value",
    ["np.linalg.svd(cloud)", "eigh(cloud)", "np.linalg.eig(a)[1]", "len(cloud)", "cloud[:, 2]"],
)
def test_a_trace_does_not_ask_for_a_decomposition_or_a_slice(value):
    def traced(line):
        lines = (LINES[0], line, LINES[2])
        known = behaviour(OTHERS, lines=lines, notes=[(2, "kept", "9")], counts={2: 1})
        for number, runs in enumerate(known.edited.values()):
            object.__setattr__(runs[0], "notes", ((2, "kept", str(number + 2)),))
        return len(list(trace_questions(known, Random(1))))

    assert traced(f"    kept = {value}") == 0
    assert traced("    kept = solved(cloud)") == traced("    kept = cloud[order]") == 1


def test_a_trace_offers_values_of_one_type():
    alike = [("[False]", "[True, False]"), ("[1]", "[]"), ("3", "-0.5"), ("{1: 2}", "{}")]
    assert all(is_alike(*pair) for pair in alike)
    different = [("[False]", "[1]"), ("3", "True"), ("3", "[3]"), ("[3]", "[[3]]"), ("3", "None")]
    assert not any(is_alike(*pair) for pair in different)

    def traced(*values):
        notes = [(2, "kept", "[9]")]
        lines = (LINES[0], "    kept = moved(cloud)", LINES[2])
        edits = {(2, f"    kept = {value}"): ("",) for value in values}
        known = behaviour(edits, "5", lines, notes=notes, counts={2: 1})
        for value, runs in zip(values, known.edited.values(), strict=True):
            object.__setattr__(runs[0], "notes", ((2, "kept", value),))
        return [set(question.choices) for question in trace_questions(known, Random(1))]

    assert traced("[8]", "True", "None", "[7]") == [{"[9]", "[8]", "[7]"}]
    assert traced("[8]", "True", "None", "[[7]]") == []


# ---- choices and results -------------------------------------------------------------------------


def test_wrong_choices_are_as_easy_as_the_right_one_and_of_its_type():
    values = ["[0.176, 0.975]", "[0.176, 0.975]", "[True, False]", "[True, False]"]
    assert distractors("[0.6, 0.8]", [*values, "[0.8, 0.6]"])[0] == "[0.8, 0.6]"
    assert distractors("[2, 0]", [*values, "[0, 2]"])[0] == "[0, 2]"


def test_wrong_choices_come_from_changes_that_a_person_might_write(sandbox):
    answer = "def filter_clusters(cluster_labels, min_num_points=100):\n    kept = cluster_labels\n"
    answer += "    return np.array([label if (kept == label).sum() >= min_num_points else 0 "
    answer += "for label in kept])\n"
    known = observed("filter_clusters", answer, sandbox)
    assert all(edit.is_plausible for edit in known.edited) and len(known.edited) > 20
    assert not any("** 2" in edit.after or "** 0.5" in edit.after for edit in known.edited)
    texts = {choice for q in prediction_questions(known, Random(1)) for choice in q.choices}
    assert "[2, 9, 2, 9]" in texts and "[4, 81, 4, 81]" not in texts


@pytest.mark.parametrize(("symptom", "is_asked"), [("9", True), ("nan", False), ("0.333", False)])
def test_which_line_is_not_asked_if_the_result_reveals_it_or_is_hard(symptom, is_asked):
    known = behaviour({(3, "    return -kept"): (symptom,), **OTHERS})
    texts = [question.text for question in which_line_questions(known, Random(1))]
    assert any(f"is `{symptom}`" in text for text in texts) == is_asked and texts


def test_which_line_asks_for_other_rows_and_not_for_other_numbers():
    results = ["[[1, 2, 0.5]]", "[[9, 16, 0]]", "[]", "[[1, 2, 0.5], [3, -4, 0]]"]
    outcomes = {(2, f"    kept = {n}"): (text,) for n, text in enumerate(results)}
    known = behaviour(outcomes, own="[[3, -4, 0]]", cases=(Case(CLOUD),))
    texts = " ".join(question.text for question in which_line_questions(known, Random(1)))
    assert "[[1, 2, 0.5]]" in texts and "[[9, 16, 0]]" not in texts


def test_which_line_is_not_asked_if_all_signs_are_reversed():
    outcomes = {(2, f"    kept = {n}"): (f"[{n}, 2]",) for n in (-1, 5, 6, 7)}
    outcomes[3, "    return -kept"] = ("[-1, -2]",)
    known = behaviour(outcomes, own="[1, 2]")
    texts = " ".join(question.text for question in which_line_questions(known, Random(1)))
    assert "is `[-1, 2]`" in texts and "is `[-1, -2]`" not in texts
    known = behaviour({(3, "    return -kept"): ("-5",), **OTHERS})
    texts = " ".join(question.text for question in which_line_questions(known, Random(1)))
    assert "is `6`" in texts and "is `-5`" not in texts


def test_the_key_says_what_each_wrong_change_does():
    errors = {(2, "    kept = x[9]"): ("an error: IndexError",), (2, "    a"): ("it never ends",)}
    known = behaviour({(3, "    return 9"): ("9",), **errors})
    (question,) = which_line_questions(known, Random(1))
    assert "If line 2 becomes `kept = x[9]`, the code raises `IndexError`." in question.reason
    assert "If line 2 becomes `a`, the code never ends." in question.reason


@pytest.mark.parametrize(
    ("own", "after", "is_asked"),
    [
        ("[0, 1]", "[0, 2]", True),
        ("[0, 0.333]", "[0, 2]", False),
        ("[0, 1]", "[0, 0.333]", False),
        ("[0, 1]", "[0, -1]", False),
        ("[0, 1]", "[0, nan]", False),
    ],
)
def test_the_affected_calls_have_easy_results_that_clearly_differ(own, after, is_asked):
    outcomes = {
        (2, "    kept = a"): (after, own, own),
        (2, "    kept = b"): (own, "[0, 3]", "[0, 3]"),
        (2, "    kept = c"): (own, own, "[0, 3]"),
        (2, "    kept = d"): ("[0, 3]", "[0, 3]", own),
        (2, "    kept = all"): ("[0, 3]", "[0, 3]", "[0, 3]"),
        (2, "    kept = none"): (own, own, own),
    }
    known = behaviour(outcomes, own=own, cases=tuple(Case(f"f({n})") for n in range(3)))
    texts = [q.text for q in what_if_questions(known, Random(1)) if "For which" in q.text]
    assert any("`kept = a`" in text for text in texts) == is_asked
    assert not any("`kept = all`" in text or "`kept = none`" in text for text in texts)


@pytest.mark.parametrize(
    ("text", "outcome", "is_asked"),
    [
        ("    return kept", "an error: TypeError", False),
        ("    return kept", "7", True),
        ("    kept = cloud", "an error: TypeError", True),
        ("    kept = cloud", "an error: NameError", False),
    ],
)
def test_a_deleted_result_is_not_asked_about_if_only_its_caller_fails(text, outcome, is_asked):
    lines = (LINES[0], text, "    return 1")
    known = behaviour(OTHERS, lines=lines, deleted={(2, "    pass"): (outcome,)})
    assert len(list(deletion_questions(known, Random(1)))) == is_asked


def test_a_name_keeps_a_value_if_a_line_is_deleted():
    """Another cell of the notebook may define the name, and the sheet does not show that cell."""
    source = (
        "def f(points):\n"
        "    p, q = points\n"
        "    points = p + q\n"
        "    total = 0\n"
        "    total += 1\n"
        "    print(points)\n"
        "    return total\n"
    )
    (statement,), _ = slicing.parse_notebook([source])
    deleted = [first for _, first, _, _ in answer_observer._deletions(statement)]
    assert deleted == [3, 4, 5, 6], "and the last return leaves nothing to ask about"


@pytest.mark.parametrize(
    ("construct", "is_asked"),
    [("a lambda function", False), ("a generator expression", False), ("try", True)],
)
def test_lines_with_an_inner_loop_are_not_counted(construct, is_asked):
    known = behaviour({}, words=((3, "construct", construct),), counts={2: 1, 3: 3})
    assert len(list(cost_questions(known, Random(1)))) == is_asked


def test_a_line_that_runs_once_per_call_is_not_counted():
    known = behaviour({}, counts={2: 3, 3: 3})
    assert not list(cost_questions(known, Random(1)))


def test_the_only_line_that_differs_is_marked():
    part = "points = np.zeros(3)\nf(points, {})"
    known = behaviour({}, cases=(Case(part.format(3), larger=part.format(6)),))
    known = dataclasses.replace(known, own=(Run("5", {3: 3}), Run("5", {3: 6})))
    (question,) = [q for q in cost_questions(known, Random(1)) if "part 2" in q.text]
    assert question.text == (
        "Part 1 runs line 3 of your code 3 times. How many times does part 2 run line 3?"
    )
    assert "f(points, 6)  # differs from part 1" in question.code
    assert question.code.count("differs") == 1 and question.right_choice == "6 times"


def test_definitions_that_all_calls_share_are_printed_once():
    define = "def shape(node):\n    return node\n\n\n"
    codes = {f"call {n}": f"{define}tree = KdTree()\ntree.insert({n})" for n in range(3)}
    shown = shown_together(codes)
    assert shown.startswith(define.rstrip()) and shown.count("def shape") == 1
    assert shown.count("tree = KdTree()") == 3, "each call makes its own tree"
    for number in range(3):
        assert f"# call {number}\ntree = KdTree()\ntree.insert({number})" in shown
    assert shown_together({"a": f"{define}f(1)", "b": "f(2)"}).count("def shape") == 1
    (case, *_) = cases_of("match_boxes")
    assert shown_together({"a": case.code, "b": case.code}).count("cube = ") == 1


# ---- singular vectors and eigenvectors -----------------------------------------------------------


def decompositions(name, matrix):
    matrix = np.array(matrix, dtype=float)
    return answer_observer._with_each_decomposition(lambda: getattr(np.linalg, name)(matrix))


@pytest.mark.parametrize("name", ["eig", "eigh"])
def test_other_eigenvectors_are_as_valid_and_differ(name):
    original = getattr(np.linalg, name)
    matrix = np.array([[4.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0, 0.0, 1.0]])
    first, *others = decompositions(name, matrix)
    assert len(others) == 2 and getattr(np.linalg, name) is original
    for values, vectors in (first, *others):
        assert np.allclose(matrix @ vectors, vectors * values)
        assert np.allclose(vectors.T @ vectors, np.eye(3))
    for column in range(3):
        signs = [np.sign(first[1][:, column] @ vectors[:, column]) for _, vectors in others]
        assert -1 in signs, "in one of them, this vector is reversed"


def test_vectors_for_equal_values_differ():
    matrix = np.array([[0.0, 2.0, 0.0], [0.0, 0.0, 2.0]])
    first, *others = decompositions("svd", matrix)
    for left, values, right in (first, *others):
        assert np.allclose(left * values @ right[:2], matrix)
        assert np.allclose(np.abs(right[2]), [1, 0, 0])
    assert not any(np.allclose(np.abs(first[2]), np.abs(right)) for _, _, right in others)


def test_code_without_decompositions_runs_once():
    assert answer_observer._with_each_decomposition(lambda: 7) == [7]


def observed(exercise, source, sandbox):
    lesson = lesson_of(exercise)
    cells = decode_notebook(fill_in(lesson, {exercise: source}).encode(), lesson.name).code
    return observe(Answer(lesson, exercise, cells, {}), sandbox)


def right_source(exercise):
    return next(answer.source for answer in answers_to(exercise) if answer.right)


def kept_source(exercise, words):
    (source,) = [answer.source for answer in answers_to(exercise) if answer.name == words]
    return source


@pytest.mark.slow
def test_a_key_does_not_depend_on_the_choice_of_singular_vectors(sandbox):
    known = observed(
        "plane_through", kept_source("plane_through", "the null space by SVD"), sandbox
    )
    code = cases_of("plane_through")[2].code
    line = next(line.number for line in known.lines if "svd" in line.text)
    values = known.own[2].values(line, "directions")
    vectors = ValueClaim(code, line, "directions", 0, values[0])
    rows = ValueClaim(code, line - 1, "rows", 0, known.own[2].values(line - 1, "rows")[0])
    normal = OutcomeClaim(code, None, known.own[2].outcome)
    choices = ("[0, 1, 0, 0]", known.own[2].outcome, "[0, 0, 1, 0]")

    def question(*claims, choices=choices):
        return Question("predict", "What?", code, choices, 1, "", True, claims)

    opposite = "[-1, 0, 0, 1]" if known.own[2].outcome == "[1, 0, 0, -1]" else "[1, 0, 0, -1]"
    with Verifier(known, sandbox) as verifier:
        assert not verifier.confirms(question(vectors)), "two singular values are equal"
        assert verifier.confirms(question(rows)) and not verifier.has_free_signs(question(rows))
        assert verifier.confirms(question(normal)) and verifier.has_free_signs(question(normal))
        both = (opposite, *choices[1:])
        assert not verifier.confirms(question(normal, choices=both)), "both normals are right"


@pytest.mark.slow
def test_signs_are_not_free_without_a_decomposition(sandbox):
    known = observed("plane_through", right_source("plane_through"), sandbox)
    code, own = cases_of("plane_through")[0].code, known.own[0].outcome
    assert own == "[0, 0, 1, 0]"
    claims = (OutcomeClaim(code, None, own),)
    question = Question("what if", "?", code, ("[0, 0, -1, 0]", own, "1"), 0, "", True, claims)
    with Verifier(known, sandbox) as verifier:
        assert verifier.confirms(question) and not verifier.has_free_signs(question)


@pytest.mark.slow
def test_a_question_says_if_all_signs_may_be_reversed(sandbox):
    names = ("SVD of the centred points", "the null space by SVD")
    for exercise, name in zip(("fit_plane", "plane_through"), names, strict=True):
        known = observed(exercise, kept_source(exercise, name), sandbox)
        texts = [q.text for q in choose_questions(known, sandbox, 5, Random(1))]
        assert any(text.endswith(FREE_SIGNS) for text in texts), exercise
    known = observed("plane_through", kept_source("plane_through", names[1]), sandbox)
    assert not any(FREE_SIGNS in question.text for question in candidates(known, Random(1)))


# ---- the page ------------------------------------------------------------------------------------


def test_the_sheet_names_functions_of_the_lesson_that_it_does_not_print(tmp_path):
    lesson = lesson_of("get_oriented_boxes")
    texts = ("def get_oriented_boxes(cloud, labels):", "    return own(turned(cloud, np.max(1)))")
    texts += ("def own(boxes):", "    return boxes")
    lines = tuple(ListedLine(number, 1, number, text) for number, text in enumerate(texts, start=1))
    code = "get_oriented_boxes(block(1.0), x.askew(2))"
    question = Question("predict", "What?", code, ("1", "2", "3"), 0, "", True, ())
    helpers = called_helpers(lesson, "get_oriented_boxes", lines, [question])
    assert helpers == ("turned", "block")
    sheet = Sheet("ada", "Ada", "get_oriented_boxes", lines, (question,), helpers=helpers)
    sheets, _ = write_pages(Course(tmp_path), lesson.stage, [sheet])
    sentence = "The code also calls <code>turned</code> and <code>block</code> from the lesson."
    assert sentence in sheets.read_text("utf-8")
    assert "The code also calls" in moodle_quiz(sheet, lesson.stage).decode()
    assert sentence_about(()) == "" and sentence_about("abc").count("`") == 6


@pytest.mark.parametrize(
    ("exercise", "code", "helpers"),
    [
        ("search", "tree = KdTree()\ntree.root = Node([1.0], 0)", ("KdTree", "Node")),
        ("ransac_plane", "candidate = plane_through(*points)", ("plane_through",)),
        ("plane_through", "normal = plane_through(p, q, r)", ()),
    ],
)
def test_helpers_include_classes_and_other_exercises(exercise, code, helpers):
    line = ListedLine(1, 1, 1, code)
    assert called_helpers(lesson_of(exercise), exercise, [line], []) == helpers


def test_questions_print_a_change_without_unnecessary_parentheses():
    known = behaviour({(3, "    return (-kept)"): ("9",), **OTHERS})
    texts = [question.text for question in what_if_questions(known, Random(1))]
    choices = {c for q in which_line_questions(known, Random(1)) for c in q.choices}
    assert any("Line 3 becomes `return -kept`" in text for text in texts)
    assert "line 3 becomes `return -kept`" in choices
