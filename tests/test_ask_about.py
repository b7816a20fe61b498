"""`ask_about` asks two questions about a student's function, and running it gives the answers."""

import ast
import contextlib
import io
import itertools
import linecache
import re
from random import Random

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest

from grader.course.build import secret_lines
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import every_lesson
from tests.course_lessons import COURSE
from utils import ask_about, check
from utils.checks.waiting_cells import record_result
from utils.notebooks import slicing
from utils.notebooks.reading import decode_notebook
from utils.questions import ask, versions
from utils.questions.cases import cases_of, exercises_with_cases
from utils.questions.changed_lines import as_written, is_plausible, is_readable
from utils.questions.choices import in_rounds
from utils.questions.texts import is_easy, value_text

GROUND = """def filter_ground(cloud, ground_level=-1.2):
    heights = cloud[:, 2]
    return cloud[heights >= ground_level]
"""
NUMBERS = itertools.count()


def run_cell(source, names=None):
    """Run a cell as a notebook does, so that the source of its functions is known."""
    file, names = f"<cell {next(NUMBERS)}>", {"np": np} if names is None else names
    linecache.cache[file] = (len(source), None, source.splitlines(True), file)
    exec(compile(source, file, "exec"), names)
    return names


def checked(source, name="filter_ground"):
    """Return the function of a cell, as if it had passed its checks."""
    function = run_cell(source)[name]
    record_result(name, function, True)
    return function


def cards_about(source, name="filter_ground", kinds=(ask.predict, ask.what_if)):
    return ask.make_cards(run_cell(source)[name], name, kinds)


def value_of_case(source, code):
    """Return the value of a case in a new namespace, as a text."""
    names = {"np": np, "rng": 5}
    exec(source, names)
    *statements, last = ast.parse(code).body
    exec(compile(ast.Module(statements, []), "case", "exec"), names)
    value = eval(compile(ast.Expression(last.value), "case", "eval"), names)
    return value_text(np.asarray(value).tolist())


@pytest.mark.parametrize("margin", range(8))
def test_running_the_code_gives_the_right_choices(margin):
    """Each margin results in a different function, and therefore in different questions."""
    source = GROUND.replace("ground_level]", f"ground_level + {margin} * 0.0]")
    first, second = cards_about(source)
    assert not first.after and first.choices[first.key] == value_of_case(source, first.code)
    assert source.count(second.before) == 1 and second.before != second.after
    line = int(re.search(r"change line (\d+)", second.text)[1])
    assert source.splitlines()[line - 1].strip() == second.before
    changed = source.replace(second.before, second.after)
    right = second.choices[second.key]
    assert right == value_of_case(changed, second.code)
    assert right != value_of_case(source, second.code)
    assert value_of_case(source, second.code) in second.choices
    assert first.code != second.code
    for card in (first, second):
        assert 3 <= len(set(card.choices)) == len(card.choices) == len(card.explanations) <= 4
        starts = [text.partition(".")[0] for text in card.explanations]
        assert starts.index("Right") == card.key and starts.count("No") == len(starts) - 1


def test_explanations_show_what_the_function_returned():
    _, card = cards_about(GROUND)
    right, own = card.choices[card.key], value_of_case(GROUND, card.code)
    texts = dict(zip(card.choices, card.explanations, strict=True))
    assert f"Without the change, it is `{own}`." in texts.pop(right)
    assert "without the change" in texts.pop(own)
    assert all(f"the value is `{right}`" in text for text in texts.values())


def test_the_same_code_gets_the_same_questions():
    assert cards_about(GROUND) == cards_about(GROUND)
    others = {cards_about(GROUND.replace("heights", name))[0].code for name in "abcdefgh"}
    assert len(others) > 1


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        (GROUND, "This cell waits until filter_ground passes its checks."),
        (
            "def filter_ground(cloud, ground_level=-1.2):\n    raise NotImplementedError\n",
            "This cell waits until filter_ground is written.",
        ),
    ],
)
def test_an_unchecked_function_gets_one_sentence_and_no_question(source, sentence, capsys):
    ask_about(run_cell(source)["filter_ground"])
    assert capsys.readouterr().out.strip() == sentence


def test_an_allowed_answer_with_a_note_gets_questions(capsys):
    names = run_cell(GROUND.replace(">=", ">"))
    check(names["filter_ground"])
    assert "[note]" in capsys.readouterr().out
    ask_about(names["filter_ground"])
    assert "waits until" not in capsys.readouterr().out


def test_a_function_that_changed_after_its_check_gets_no_questions_yet(capsys):
    checked(GROUND)
    ask_about(run_cell(GROUND)["filter_ground"])
    assert "waits until" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        ("while True:\n        pass", "did not return within 0 s on a few points. Is there"),
        ("return cloud[missing]", "No question about this version of filter_ground has one clear"),
        ("return lambda: 1", "No question about this version of filter_ground has one clear"),
    ],
)
def test_a_function_that_hangs_or_fails_gets_one_sentence(body, sentence, capsys, monkeypatch):
    monkeypatch.setattr(versions, "OWN_SECONDS", 0.3)
    monkeypatch.setattr(ask, "OWN_SECONDS", 0.3)
    ask_about(checked(f"def filter_ground(cloud, ground_level=-1.2):\n    {body}\n"))
    printed = capsys.readouterr().out
    assert sentence in " ".join(printed.split()) and "Question" not in printed


def test_a_function_without_source_gets_one_sentence(capsys):
    names = {}
    exec(GROUND, names)
    record_result("filter_ground", names["filter_ground"], True)
    ask_about(names["filter_ground"])
    assert "No question" in capsys.readouterr().out


def test_the_error_about_an_unknown_function_lists_the_known_ones():
    with pytest.raises(LookupError, match="only about horizontal_distance, drop_invalid, "):
        ask_about(sorted)


def test_output_of_the_function_is_discarded(capsys, recwarn):
    matplotlib.use("Agg")
    noisy = GROUND.replace(
        "    return",
        "    import warnings\n    import matplotlib.pyplot as plt\n    plt.figure()\n"
        "    print('noise')\n    warnings.warn('noise')\n    return",
    )
    mine = plt.figure()
    cards = cards_about(noisy)
    assert len(cards) == 2 and plt.get_fignums() == [mine.number]
    assert "noise" not in "".join(capsys.readouterr()) and not recwarn.list
    plt.close(mine)


def test_a_result_that_depends_on_the_seed_is_not_asked_about():
    source = (
        "def ransac_line(points, max_iterations, distance_tolerance, rng):\n"
        "    inliers = np.arange(len(points)) < {}\n"
        "    return None, inliers\n"
    )
    assert len(cards_about(source.format("2"), "ransac_line")) == 2
    assert cards_about(source.format("rng % 2"), "ransac_line") == []


def test_cards_are_escaped_and_can_be_printed_as_text(capsys):
    source = GROUND.replace("[:, 2]\n", '[:, 2]  # <b>"height"</b>\n')
    ask_about(checked(source))
    text = capsys.readouterr().out
    assert re.findall(r"Question (\d)\.", text) == ["1", "2"] and text.count("Answer: ") == 2
    edited = next(
        card
        for card in ask.what_if(
            versions.Versions(run_cell(source)["filter_ground"], "filter_ground",
                              cases_of("filter_ground")), Random(1)
        )
        if "<b>" in card.before
    )  # fmt: skip
    html = ask._as_html(1, edited)
    assert "&lt;b&gt;" in html and html.count("<b>") == 1
    assert html.count("<details>") == len(edited.choices)


def test_changes_and_values_in_questions_are_easy_to_read():
    assert is_readable("    x = a + b", "    x = a - b")
    assert not is_readable("x = a", "x = ~a")
    assert not is_readable("with np.errstate(all='ignore'):", "with np:")
    assert not is_readable("x = a", "x  =  a")
    assert not is_readable("x = a", "x = a\ny = b")
    assert is_easy("[0.25, 7]") and not is_easy("[0.333]") and not is_easy(f"{[0] * 27}")
    edits = [versions.Change(line, "", str(n), print, ()) for n, line in enumerate((4, 4, 7, 4))]
    lines = [type("Edit", (), {"first": edit.line, "n": edit.after}) for edit in edits]
    assert [edit.n for edit in in_rounds(lines)] == ["0", "2", "1", "3"]


@pytest.mark.parametrize(
    ("before", "after", "written"),
    [
        ("while queue:", "while (not queue):", "while not queue:"),
        ("    elif x:", "    elif (not x):", "    elif not x:"),
        ("for i in range(n):  # (all)", "for i in range((n) + 1):  # (all)",
         "for i in range(n + 1):  # (all)"),
        ("f(cloud, 0)", "f((-cloud), (-1))", "f(-cloud, -1)"),
        ("return x", "return (f(x))", "return f(x)"),
        ("x = (a - b) // 2", "x = (a - b)", "x = a - b"),
        # Necessary parentheses, a sign after a sign, and what the student wrote.
        ("return x * y", "return (x + 1) * y", "return (x + 1) * y"),
        ("x = a - b", "x = a - (-b)", "x = a - (-b)"),
        ("return (a) + f(b)", "return (a) + (f(-b))", "return (a) + f(-b)"),
        ("print('(a)')", "print('(b)')", "print('(b)')"),
        # One line of a longer statement.
        ("    for row in rows]", "    for row in cloud]", "    for row in cloud]"),
        ("    for row in rows]", "    for row in (-rows)]", ""),
    ],
)  # fmt: skip
def test_a_changed_line_has_no_parentheses_that_nobody_writes(before, after, written):
    assert as_written(before, after) == written
    if written and not before.startswith("  "):
        bodies = [f"{line}\n    pass" if ":" in line else line for line in (after, written)]
        first, second = (ast.dump(ast.parse(body)) for body in bodies)
        assert first == second


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("x = labels", "x = (labels ** 2)"),
        ("x = labels", "x = labels ** 0.5"),
        ("x = labels", "x = (abs(labels))"),
        ("print('a', n)", "return 'a', n"),
        ("kept = []", "cloud.kept = []"),
        ("return kept", "return np.isin(np.arange(len(cloud)), kept)"),
        ("for i in range(3):", "for i in range((3) + 1):"),
        ("x = a - 1", "x = (a - 1) + 1"),
        ("x = np.full(n, -1)", "x = np.full(n, -0)"),
    ],
)
def test_code_that_nobody_writes_is_not_a_change_to_ask_about(before, after):
    assert not is_plausible(before, after) and not is_readable(before, as_written(before, after))
    assert is_plausible(after, before) and is_plausible("x = y ** 2", "x = z ** 2")


# ---- the lessons ---------------------------------------------------------------------------------


def asked_in(lesson):
    """Return the call of `ask_about` in a lesson, as (function, exercise), and its position."""
    cells = decode_notebook(lesson.released.read_bytes(), lesson.name).code
    ((at, node),) = [
        (at, node)
        for at, cell in enumerate(cells)
        if "ask_about(" in cell
        for node in ast.walk(ast.parse(cell))
        if isinstance(node, ast.Call) and node.func.id == "ask_about"
    ]
    last_check = max(at for at, cell in enumerate(cells) if cell.startswith("check("))
    names = [node.args[0].id, *(keyword.value.value for keyword in node.keywords)]
    return names[0], names[-1], at > last_check


@pytest.mark.parametrize("about", every_lesson(), ids=lambda lesson: lesson.name)
def test_each_lesson_asks_about_one_of_its_exercises_after_its_checks(about):
    function, exercise, is_after_checks = asked_in(about)
    assert exercise in (*(graded.name for graded in about.machine_graded), *about.steps)
    assert cases_of(exercise) and exercise in exercises_with_cases() and is_after_checks
    assert function in (exercise, *about.header.given)


def function_in(notebook, function, exercise):
    """Return the function or class of a notebook that contains an answer."""
    parsed, _ = slicing.parse_notebook(decode_notebook(notebook, exercise).code)
    names = {"__name__": "__main__"}
    with contextlib.redirect_stdout(io.StringIO()):
        for statement in slicing.slice_for([function, exercise], parsed):
            run_cell(ast.unparse(statement.node), names)
    return names[function]


@pytest.mark.slow
@pytest.mark.parametrize("about", COURSE, ids=lambda lesson: lesson.name)
def test_the_courses_answer_gets_two_questions_that_do_not_show_it_on_the_site(about):
    function, exercise, _ = asked_in(about)
    answer = function_in(about.solved.read_bytes(), function, exercise)
    cards = ask.make_cards(answer, exercise, (ask.predict, ask.what_if))
    assert [bool(card.after) for card in cards] == [False, True]
    on_site = ask.make_cards(answer, exercise, (ask.predict, ask.predict))
    assert len(on_site) == 2 and on_site[0].case != on_site[1].case
    shown = "".join(ask._as_html(1, card) + ask._as_text(1, card) for card in on_site)
    assert not any(line in shown for line in secret_lines(about.solved.read_bytes()))


PROVEN = [pytest.param(lesson, marks=pytest.mark.proof, id=lesson.name) for lesson in COURSE]


@pytest.mark.parametrize("about", PROVEN)
def test_each_right_answer_gets_two_questions(about):
    function, exercise, _ = asked_in(about)
    for kept in answers_to(exercise):
        if kept.right:
            notebook = fill_in(about, {exercise: kept.source}).encode()
            answer = function_in(notebook, function, exercise)
            cards = ask.make_cards(answer, exercise, (ask.predict, ask.what_if))
            assert len(cards) == 2, kept.name
