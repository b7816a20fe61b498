"""Attempts to smuggle hidden input, markup or terminal commands into the feedback."""

import ast
import json
import math
import re

import numpy as np
import pytest

from grader.classroom.submissions import Submission
from grader.console import print_class, print_verdict
from grader.course.lessons import all_lessons, find_lesson
from grader.course.paths import PROJECT, Course
from grader.judging.messages import FEW_NUMBERS
from grader.lms.autograded_copy import score_output
from grader.lms.report import write_report
from grader.sandbox.error_descriptions import MAX_LINE_LENGTH, NAMED_EXCEPTIONS, SENTENCES
from grader.sandbox.failures import KNOWN_EXCEPTIONS, MAX_LINES, StudentError
from grader.sandbox.program import MAX_NOTEBOOK_LINES
from grader.sandbox.student import MAX_FAILED_CELLS
from tests.attacks.attack import attack, function, with_attacks
from tests.check_sources import FAILURES
from utils.checks import checks_of, tips
from utils.checks.diagnosis import known_mistakes
from utils.notebooks import edits

pytestmark = pytest.mark.slow

# A function that encodes a number from its input in letters and tries to publish them.
LEAKING_FUNCTION = """
def {name}(*arguments, **keywords):
    import numpy as np, os, sys, warnings
    numbers = np.asarray(arguments[0], dtype=float).ravel()
    word = "leak" + "".join(chr(97 + int(digit)) for digit in f"{{abs(numbers[0] * 1e6):.0f}}")
    {body}
"""
LEAK = re.compile("leak[a-j]{2,}|l.?e.?a.?k[a-j]{4}")


def hidden_messages(verdict):
    """Return the messages about hidden tests."""
    return [
        test.message
        for exercise in verdict.exercises
        for test in exercise.tests
        if not test.visible
    ]


@pytest.fixture
def collect_outputs(tmp_path, capsys):
    """Return a function that collects all the outputs that show a verdict to people."""

    def collect(verdict):
        lesson = find_lesson(verdict.lesson)
        submission = Submission("mallory", lesson, tmp_path / "x.ipynb")
        print_verdict(verdict)
        print_class([(submission, verdict)])
        page = write_report(Course(tmp_path), [(submission, verdict)]).read_text("utf-8")
        feedback = "".join(
            score_output(exercise)["data"]["text/html"] for exercise in verdict.exercises
        )
        output = "\n".join(capsys.readouterr())
        return [output, page, feedback, json.dumps(verdict.as_dict(), ensure_ascii=False)]

    return collect


@with_attacks(
    "body",
    {
        "in the message of an exception": "raise ValueError(word)",
        "in the name of an exception": "raise type(word, (Exception,), {})()",
        "in the name of an exception that is a ValueError": "raise type(word, (ValueError,), {})()",
        "in the name of a StopIteration": "raise type(word, (StopIteration,), {})()",
        "in a key that is missing": "return {}[word]",
        "in an attribute that is missing": "return getattr(np, word)",
        "in a module that is missing": "__import__(word)",
        "in a name that is missing": "return eval(word)",
        "in a file that is missing": "return open(word)",
        "in an assertion": "assert False, word",
        "in the argument of exit": "sys.exit(word)",
        "in a warning that is an error": 'warnings.simplefilter("error"); warnings.warn(word)',
        "in a warning": "warnings.warn(word); return None",
        "in a note on an exception": ("error = ValueError(); error.add_note(word); raise error"),
        "in the cause of an exception": "raise ValueError from KeyError(word)",
        "in a group of exceptions": "raise ExceptionGroup(word, [ValueError(word)])",
        "in a message that an exception generates": (
            "raise type('E', (Exception,), {'__str__': lambda self: word})"
        ),
        "in a repr": "return type('X', (), {'__repr__': lambda self: word})()",
        "in the name of a class": "return type(word, (), {})()",
        "in the name of a class in a list": "return [type(word, (), {})()]",
        "in the name of a list class": "return type(word, (list,), {})([1])",
        "in the name of a field": "return np.zeros(2, [(word, object)])",
        "in a string": "return word",
        "in a string with the marks of our numbers": "return '\\x0e' + word + '\\x0f'",
        "in a list of strings": "return [word]",
        "in a key": "return {word: 1}",
        "in a set": "return {word}",
        "in an array of strings": "return np.array([word] * 5)",
        "in terminal commands": (
            "raise type('\\x1b[31ml\\u202ee\\nak' + word[4:], (Exception,), {})('\\x1b]0;' + word)"
        ),
        "on standard output and error": (
            "os.write(1, word.encode()); os.write(2, word.encode()); print(word); return None"
        ),
        "in the syntax error of a cell": "exec(word + ' ' + word)",
        "in a file name of code": ("exec(compile('1/0', 'code cell 1, line 1, ' + word, 'exec'))"),
        "in a place in the notebook": "exec(compile('1/0', 'code cell ' + word, 'exec'))",
    },
)
def test_feedback_does_not_reveal_hidden_input(body, submit, filter_lesson, collect_outputs):
    """No output shows hidden input, wherever the answer puts it."""
    source = LEAKING_FUNCTION.format(name="filter_ground", body=body)
    verdict = submit({"filter_ground": source})
    assert verdict.status == "judged" and len(hidden_messages(verdict)) > 15
    assert [words for words in hidden_messages(verdict) if LEAK.search(words)] == []
    assert [problem for problem in verdict.problems if LEAK.search(problem)] == []
    # Messages about visible checks must not show hidden input either, because code could save it.
    for text in collect_outputs(verdict):
        assert not LEAK.search(text)
        assert not re.search("[\x1b\u202e\x07]", text)


LEAKING_CELL = """
import sys
number = 6763
word = "leak" + "".join(chr(97 + int(digit)) for digit in str(number))
def tell():
    {body}
f = tell()
"""


@with_attacks(
    "body",
    {
        "in the message of an exception": "raise ValueError(word)",
        "in the name of an exception": "raise type(word, (Exception,), {})()",
        "in the name of a well-known exception": "raise type('NameError', (NameError,), {})(word)",
        "in a name that is missing": "return eval(word)",
        "in an attribute that is missing": "return getattr(sys, word)",
        "in a module that is missing": "__import__(word)",
        "in a parameter that is missing": "print(**{word: 1})",
        "in a key that is missing": "return {}[number]",
        "in a module that is forbidden": (
            "raise ImportError(f'sklearn.cluster.{word} is not allowed in this lesson: it does "
            "the exercise for you')"
        ),
        "in a place": "exec(compile('1/0', f'code cell {number}', 'exec'))",
        "in a line": "exec(compile('\\n' * number + '1/0', 'code cell 1', 'exec'))",
    },
)
def test_a_failing_cell_does_not_reveal_another_notebooks_secret(body):
    """Messages about a failing cell cannot contain data that came from another notebook."""
    source = LEAKING_CELL.format(body=body) + "def f(): return 1\n"
    with attack(source, forbidden=("sklearn.cluster",)) as student:
        student.f()
        message = " ".join(student.problems)
    assert "failed: " in message and not LEAK.search(message) and "6763" not in message


def test_the_number_of_reported_failing_cells_is_limited():
    source = "def f(): return 1\n" + "".join(f"f.x{n} = 1 / 0\n" for n in range(100))
    with attack(source) as student:
        student.f()
        *reported, last = student.problems
    assert len(reported) == MAX_FAILED_CELLS and last == "Later cells failed as well."


@with_attacks(
    "name, body",
    {
        "in values": ("filter_ground", "return cloud + 6763.6763"),
        "in the number of rows": ("filter_ground", "return np.zeros((6763, cloud.shape[1]))"),
        "in the number of columns": ("filter_ground", "return np.zeros((1, 6763))"),
        "in the number of dimensions": ("filter_ground", "return np.zeros((6, 7, 6, 3, 1))"),
        "in whole numbers": ("voxel_grid", "return np.full_like(cloud, 6763)"),
        "in a number": ("voxel_grid", "return 6763.6763"),
        "in the type": ("voxel_grid", "return np.zeros(cloud.shape, 'S6763')"),
    },
)
def test_an_answer_does_not_reveal_another_notebooks_secret(name, body, submit):
    """Messages do not quote the answer, which could contain data from another notebook."""
    source = f"import numpy as np\ndef {name}(cloud, *arguments):\n    {body}\n"
    verdict = submit({name: source})
    text = [test.message for exercise in verdict.exercises for test in exercise.tests]
    text = "\n".join(re.sub("Hint: .*", "", words) for words in text)
    assert "shows your answer" in text and not re.search(r"67[\d.]*63|6, 7, 6, 3, 1", text)


def test_exit_codes_are_not_shown(submit):
    """Messages omit the exit code, which could reveal 8 bits of hidden input per test."""
    body = "os._exit(int(abs(numbers[0]) * 7) % 250 + 1)"
    verdict = submit({"filter_ground": LEAKING_FUNCTION.format(name="filter_ground", body=body)})
    messages = [test.message for exercise in verdict.exercises for test in exercise.tests]
    exit_messages = {words for words in messages if "ended" in words}
    assert exit_messages and not any(re.search(r"code \d|\d{2,}", words) for words in exit_messages)


@pytest.mark.parametrize(
    "name", ["01_point_clouds", "04_kd_tree", "08_bounding_boxes", "12_streaming_obstacles"]
)
def test_types_do_not_reveal_hidden_input(name, submit):
    """The names of returned and raised types do not reach messages about hidden tests."""
    lesson = find_lesson(name)
    for body in ("return type(word, (), {})()", "raise type(word, (Exception,), {})(word)"):
        answers = {
            exercise.name: LEAKING_FUNCTION.format(name=exercise.name, body=body).replace(
                "arguments[0]", "arguments[-1]"
            )
            for exercise in lesson.machine_graded
        }
        verdict = submit(answers, lesson=lesson, start_seconds=30.0, total_seconds=60.0)
        assert [words for words in hidden_messages(verdict) if LEAK.search(words)] == []


def test_messages_contain_no_numbers_from_hidden_input(submit):
    """Messages about the rows and values of nearly right answers contain no digits."""
    answers = {
        "filter_ground": "def filter_ground(cloud, level=-1.2): return cloud[cloud[:, 2] > 0.5]\n",
        "voxel_grid": "def voxel_grid(cloud, size=0.2): return cloud[::2] + 0.1\n",
    }
    verdict = submit(answers)
    text = "\n".join(re.sub("Hint: .*", "", words) for words in hidden_messages(verdict))
    assert text.strip() and not re.search(r"\d", text)


@with_attacks(
    "kind, place",
    {
        "a built-in type": ("ValueError", "code cell 1, line 2"),
        "a NumPy type": ("LinAlgError", "code cell 1, line 2"),
        "a custom type": ("leakabcd", "code cell 1, line 2"),
    },
)
def test_a_failure_is_described_only_by_type_and_place(kind, place):
    error = StudentError("f", kind, "leakabcd", place, in_short_exercise=True)
    assert "leak" not in error.safe_sentence and place in error.safe_sentence
    assert (kind in error.safe_sentence) == (kind in KNOWN_EXCEPTIONS)
    assert place not in StudentError("f", kind, "leakabcd", place).safe_sentence


def test_the_reported_calling_line_is_in_the_exercise_itself():
    """The line reported as leading to the failure is in the exercise's own function."""
    body = """
def nest(line, more):
    return compile("\\n" * (line - 1) + more, "code cell 1", "exec")
exec(nest(35, "exec(inner)"), {"inner": nest(30, "1 / 0")})
"""
    with attack(function(body) + "\n" * 40) as student, pytest.raises(StudentError) as error:
        student.exercise = "f"
        student.f()
    assert error.value.place == "code cell 1, line 30"
    assert error.value.call_place == "code cell 1, line 4"


@with_attacks(
    "name",
    {
        "a line beyond the end of its cell": "code cell 1",
        "a cell that does not exist": "code cell 77",
        "a line number in words": "code cell leak",
        "a cell before the first": "code cell 0",
    },
)
def test_places_outside_the_notebook_are_not_shown(name):
    """Invented cells and lines are not shown, because they could encode hidden input."""
    body = f"exec(compile('\\n' * 987654 + '1/0', {name!r}, 'exec'))"
    with attack(function(body), call_seconds=8.0) as student, pytest.raises(StudentError) as error:
        student.f(np.zeros(3))
    assert "987" not in error.value.safe_sentence and "77" not in error.value.safe_sentence
    assert "leak" not in error.value.safe_sentence


LEAKING_LINE = """
def {name}(cloud, *arguments, **keywords):
    line = 100 + int(abs(cloud[0][0]) * 1000) % 4000
    exec(compile("\\n" * line + "1 / 0", {where}, "exec"))
"""


@with_attacks(
    "where",
    {
        "a cell with blank lines": "next(f'code cell {n}' for n in range(1, 90) if n != here())",
        "the exercise's own cell": "f'code cell {here()}'",
    },
)
def test_only_lines_of_the_function_are_shown(where, submit):
    """A message names only lines of the function, because a cell may have thousands of lines."""
    here = "\ndef here(): return int(here.__code__.co_filename.split()[-1])\n" + "\n" * 3000
    source = LEAKING_LINE.format(name="filter_ground", where=where) + here
    verdict = submit({"filter_ground": source})
    messages = [words for words in hidden_messages(verdict) if words]
    lines = [int(line) for words in messages for line in re.findall(r"line (\d+)", words)]
    assert len(messages) > 15 and all(line < 100 for line in lines)


def test_lines_of_a_very_long_notebook_are_not_shown(submit):
    source = LEAKING_LINE.format(name="filter_ground", where="__file__") + "\n" * 5000
    verdict = submit({"filter_ground": source.replace("__file__", "'code cell 9'")})
    messages = [test.message for exercise in verdict.exercises for test in exercise.tests]
    assert any("ZeroDivisionError" in words for words in messages)
    assert not any(re.search(r"line \d", words) for words in messages)


def test_lines_of_a_very_long_function_are_not_shown(submit):
    """Line numbers in a long function are omitted, because they could reveal too much."""
    body = "    if row == {0}: return 1 / 0\n"
    head = "def filter_ground(cloud, *a, **k):\n    row = int(abs(cloud[0][0]) * 1000) % {0}\n"
    for count, is_shown in ((40, True), (400, False)):
        source = head.format(count) + "".join(body.format(n) for n in range(count))
        verdict = submit({"filter_ground": source})
        messages = [words for words in hidden_messages(verdict) if "ZeroDivisionError" in words]
        assert messages and any("line" in words for words in messages) == is_shown


WORDS, SMALL_NUMBERS = 16, 100


def variable_parts_of(lesson):
    """Return the number of variable parts in each message of a lesson's checks."""
    checks = PROJECT / "utils" / "checks"
    files = [path for path in checks.glob("*.py") if not path.name.startswith("lesson_")]
    files += [*checks.glob(f"lesson_{lesson.number}.py"), lesson.tests]
    files += checks.glob(f"lesson_{lesson.number}/*.py")
    return [
        variable_parts_in(node.args[0])
        for path in files
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in FAILURES and node.args
    ]


def variable_parts_in(message):
    """Return the number of variable parts in a message, or the maximum if it is unknown."""
    if isinstance(message, ast.Constant):
        return 0
    if isinstance(message, ast.Call) and getattr(message.func, "id", "") == "fixed":
        return 0
    if isinstance(message, ast.JoinedStr):
        blanks = (part.value for part in message.values if isinstance(part, ast.FormattedValue))
        return sum(getattr(getattr(blank, "func", None), "id", "") != "fixed" for blank in blanks)
    if isinstance(message, ast.BinOp):
        return variable_parts_in(message.left) + variable_parts_in(message.right)
    return FEW_NUMBERS


def test_the_threat_model_states_how_much_a_failure_can_leak():
    """Student code chooses the type, line and tip of an exception, or another failure."""
    tips_for = {kind: {""} for kind in (*KNOWN_EXCEPTIONS, "another")}
    for kinds, _, _, tip in tips._TIPS:
        for kind in kinds.split("|"):
            tips_for.setdefault(kind, {""}).add(tip)
    raised = sum(map(len, tips_for.values())) * (MAX_LINES + 1)
    # Messages about hidden tests omit numbers. The variable parts of each message together have at
    # most WORDS values.
    wrong = max(
        sum(WORDS ** (n > 0) for n in variable_parts_of(lesson)) for lesson in all_lessons()
    )
    # Otherwise, the check passes, fails with one of our messages, takes too long, or loses its
    # process.
    ends_otherwise = 1 + wrong + 10
    bits = math.ceil(math.log2(raised + ends_otherwise))
    threats = (PROJECT / "docs" / "security.md").read_text("utf-8")
    assert f"up to {bits} bits about its input" in threats
    assert f"at most {MAX_LINES} lines" in threats
    assert f"which of {len(KNOWN_EXCEPTIONS)} types" in threats


def test_the_threat_model_states_how_much_an_exercise_can_leak():
    """The searches for a known mistake and for an edit use hidden input, so they leak bits too."""
    exercises = [exercise.name for lesson in all_lessons() for exercise in lesson.machine_graded]
    mistakes = max(len([*checks_of(name)] and [*known_mistakes(name)]) for name in exercises)
    threats = (PROJECT / "docs" / "security.md").read_text("utf-8")
    for count, sentence in (
        (mistakes, "which of at most {} known mistakes explains an exercise ({} bits)"),
        (edits.MAX_EDITS, "which of at most {} edits repairs it ({} bits)."),
    ):
        assert sentence.format(count, math.ceil(math.log2(count + 1))) in threats


def test_the_threat_model_states_how_much_checks_and_cells_can_leak():
    """Messages about visible checks and cells may say more, as these do not see hidden input."""
    tips_for = {
        kind: {""} for kind in (*NAMED_EXCEPTIONS, "an exception that the line raises", "another")
    }
    for kinds, _, _, tip in tips._TIPS:
        for kind in kinds.split("|"):
            tips_for[kind].add(tip)
    names = (MAX_LINE_LENGTH + 1) // 2
    most_forbidden = max(len(lesson.header.forbidden) for lesson in all_lessons())
    words = sum(map(len, tips_for.values())) + most_forbidden
    for kinds, pattern, _ in SENTENCES:
        words += sum(len(tips_for[kind]) for kind in kinds.split("|")) * names ** ("(" in pattern)
    raised = words * (MAX_NOTEBOOK_LINES + 1)
    called = raised * (MAX_LINES + 1)  # and the exercise's line that led to the failure
    # Each variable part of a message is a number or a word.
    is_wrong = max(
        sum((SMALL_NUMBERS + 1) ** min(n, FEW_NUMBERS) for n in variable_parts_of(lesson))
        for lesson in all_lessons()
    )
    of_check, of_cell = (math.ceil(math.log2(n)) for n in (called + is_wrong, raised))
    threats = (PROJECT / "docs" / "security.md").read_text("utf-8")
    assert f"up to {of_check} bits through each visible check" in threats
    assert f"{of_cell} bits through each of the first {MAX_FAILED_CELLS} cells" in threats


INJECTION = (
    "</td><script>alert(1)</script>\\x1b]0;owned\\x07 ![x](http://evil/x.png) "
    "[bold]{{ 7 * 7 }}\\u202e\\udcff"
)


def test_markup_and_commands_in_messages_are_disarmed(submit, tmp_path, verdict_text):
    verdict = submit(
        {"filter_ground": f"def filter_ground(*a, **k):\n    raise Exception('{INJECTION}')\n"}
    )
    text = verdict_text(verdict)
    assert "\\u001b" not in text and "\x1b" not in text and "\u202e" not in text
    lesson = find_lesson(verdict.lesson)
    submission = Submission("<script>alert(2)</script>", lesson, tmp_path / "x.ipynb")
    page = write_report(Course(tmp_path), [(submission, verdict)]).read_text("utf-8")
    assert "<script>" not in page and "&lt;script&gt;alert(1)" in page and "{{ 7" in page
    for exercise in verdict.exercises:
        assert "<script>" not in score_output(exercise)["data"]["text/html"]


def test_markup_and_commands_in_type_names_are_disarmed(submit, collect_outputs):
    body = "return type('\\x1b]0;owned\\x07<script>[red]\\u202e\\n', (), {})()"
    verdict = submit({"filter_ground": f"def filter_ground(*a, **k): {body}\n"})
    for text in collect_outputs(verdict):
        assert not re.search("[\x1b\u202e\x07]|<script>.red|owned", text)
