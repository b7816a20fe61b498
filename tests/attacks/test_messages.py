"""What a student may try to have shown: the questions of hidden tests, markup, commands."""

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
from grader.lms.autograded import score_output
from grader.lms.report import write_report
from grader.sandbox.failures import KNOWN_EXCEPTIONS, MOST_LINES, StudentError
from grader.sandbox.program import MOST_LINES_OF_ALL
from grader.sandbox.quotation import LONGEST_LINE, NAMED_EXCEPTIONS, SENTENCES
from grader.sandbox.student import MOST_FAILED_CELLS
from tests.attacks.attack import attack, function, tried
from tests.test_messages import FAILURES
from utils.checks import checks_of, tips
from utils.checks.diagnosis import known_mistakes
from utils.notebooks import edits

pytestmark = pytest.mark.slow

# A function that learns a question and wants to tell it: letters stand for its digits.
TELLS = """
def {name}(*arguments, **keywords):
    import numpy as np, os, sys, warnings
    numbers = np.asarray(arguments[0], dtype=float).ravel()
    word = "leak" + "".join(chr(97 + int(digit)) for digit in f"{{abs(numbers[0] * 1e6):.0f}}")
    {body}
"""
LEAK = re.compile("leak[a-j]{2,}|l.?e.?a.?k[a-j]{4}")


def hidden_words(verdict):
    """All that is said about hidden tests."""
    return [
        test.message
        for exercise in verdict.exercises
        for test in exercise.tests
        if not test.visible
    ]


@pytest.fixture
def shown(tmp_path, capsys):
    """Everything that people see of a verdict."""

    def shown(verdict):
        lesson = find_lesson(verdict.lesson)
        submission = Submission("mallory", lesson, tmp_path / "x.ipynb")
        print_verdict(verdict)
        print_class([(submission, verdict)])
        page = write_report(Course(tmp_path), [(submission, verdict)]).read_text("utf-8")
        feedback = "".join(
            score_output(exercise)["data"]["text/html"] for exercise in verdict.exercises
        )
        said = "\n".join(capsys.readouterr())
        return [said, page, feedback, json.dumps(verdict.as_dict(), ensure_ascii=False)]

    return shown


@tried(
    "body",
    {
        "in the words of an exception": "raise ValueError(word)",
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
        "in the text of an exception that makes it up": (
            "raise type('E', (Exception,), {'__str__': lambda self: word})"
        ),
        "in a repr": "return type('X', (), {'__repr__': lambda self: word})()",
        "in the name of a class": "return type(word, (), {})()",
        "in the name of a class in a list": "return [type(word, (), {})()]",
        "in the name of a list": "return type(word, (list,), {})([1])",
        "in the name of a field": "return np.zeros(2, [(word, object)])",
        "in a text": "return word",
        "in a text with the marks of our own numbers": "return '\\x0e' + word + '\\x0f'",
        "in a list of texts": "return [word]",
        "in a key": "return {word: 1}",
        "in a set": "return {word}",
        "in an array of texts": "return np.array([word] * 5)",
        "with commands to the terminal": (
            "raise type('\\x1b[31ml\\u202ee\\nak' + word[4:], (Exception,), {})('\\x1b]0;' + word)"
        ),
        "on standard output and error": (
            "os.write(1, word.encode()); os.write(2, word.encode()); print(word); return None"
        ),
        "in the syntax error of a cell": "exec(word + ' ' + word)",
        "in a file name of code": ("exec(compile('1/0', 'code cell 1, line 1, ' + word, 'exec'))"),
        "in a place of the notebook": "exec(compile('1/0', 'code cell ' + word, 'exec'))",
    },
)
def test_tells_a_hidden_question(body, hand_in, filtering, shown, tmp_path):
    """In words of its own, by one function of the lesson."""
    source = TELLS.format(name="filter_ground", body=body)
    verdict = hand_in({"filter_ground": source})
    assert verdict.status == "judged" and len(hidden_words(verdict)) > 15
    assert [words for words in hidden_words(verdict) if LEAK.search(words)] == []
    assert [problem for problem in verdict.problems if LEAK.search(problem)] == []
    # Nor are they told about visible checks: a neighbour could have told them.
    for text in shown(verdict):
        assert not LEAK.search(text)
        assert not re.search("[\x1b\u202e\x07]", text)


CELL_THAT_TELLS = """
import sys
number = 6763
word = "leak" + "".join(chr(97 + int(digit)) for digit in str(number))
def tell():
    {body}
f = tell()
"""


@tried(
    "body",
    {
        "in the words of an exception": "raise ValueError(word)",
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
def test_tells_a_neighbours_secret_by_a_cell_that_fails(body):
    """It has met no hidden question, and may have heard of one."""
    source = CELL_THAT_TELLS.format(body=body) + "def f(): return 1\n"
    with attack(source, forbidden=("sklearn.cluster",)) as student:
        student.f()
        said = " ".join(student.problems)
    assert "failed: " in said and not LEAK.search(said) and "6763" not in said


def test_tells_a_neighbours_secret_by_many_cells_that_fail():
    source = "def f(): return 1\n" + "".join(f"f.x{n} = 1 / 0\n" for n in range(100))
    with attack(source) as student:
        student.f()
        *told, last = student.problems
    assert len(told) == MOST_FAILED_CELLS and last == "More of the notebook failed after that."


@tried(
    "name, body",
    {
        "in values": ("filter_ground", "return cloud + 6763.6763"),
        "in a number of rows": ("filter_ground", "return np.zeros((6763, cloud.shape[1]))"),
        "in a number of columns": ("filter_ground", "return np.zeros((1, 6763))"),
        "in dimensions": ("filter_ground", "return np.zeros((6, 7, 6, 3, 1))"),
        "in whole numbers": ("voxel_grid", "return np.full_like(cloud, 6763)"),
        "in a number": ("voxel_grid", "return 6763.6763"),
        "in a type": ("voxel_grid", "return np.zeros(cloud.shape, 'S6763')"),
    },
)
def test_tells_a_neighbours_secret_by_an_answer(name, body, hand_in):
    """Whoever wrote it sees it at home, where nobody else's is near."""
    source = f"import numpy as np\ndef {name}(cloud, *arguments):\n    {body}\n"
    verdict = hand_in({name: source})
    said = [test.message for exercise in verdict.exercises for test in exercise.tests]
    said = "\n".join(re.sub("Hint: .*", "", words) for words in said)
    assert "shows your answer" in said and not re.search(r"67[\d.]*63|6, 7, 6, 3, 1", said)


def test_tells_by_its_exit_code(hand_in):
    """256 values for each test, if it were shown."""
    body = "os._exit(int(abs(numbers[0]) * 7) % 250 + 1)"
    verdict = hand_in({"filter_ground": TELLS.format(name="filter_ground", body=body)})
    messages = [test.message for exercise in verdict.exercises for test in exercise.tests]
    said = {words for words in messages if "ended" in words}
    assert said and not any(re.search(r"code \d|\d{2,}", words) for words in said)


@pytest.mark.parametrize(
    "name", ["01_point_clouds", "04_kd_tree", "08_bounding_boxes", "12_streaming_obstacles"]
)
def test_tells_in_other_lessons(name, hand_in):
    """By every function of a lesson: in the name of what it returns, then of what it raises."""
    lesson = find_lesson(name)
    for body in ("return type(word, (), {})()", "raise type(word, (Exception,), {})(word)"):
        answers = {
            exercise.name: TELLS.format(name=exercise.name, body=body).replace(
                "arguments[0]", "arguments[-1]"
            )
            for exercise in lesson.machine_graded
        }
        verdict = hand_in(answers, lesson=lesson, start_seconds=30.0, total_seconds=60.0)
        assert [words for words in hidden_words(verdict) if LEAK.search(words)] == []


def test_no_number_of_a_hidden_question_is_in_a_message(hand_in):
    """Answers that are nearly right make the judge talk about rows and values."""
    answers = {
        "filter_ground": "def filter_ground(cloud, level=-1.2): return cloud[cloud[:, 2] > 0.5]\n",
        "voxel_grid": "def voxel_grid(cloud, size=0.2): return cloud[::2] + 0.1\n",
    }
    verdict = hand_in(answers)
    said = "\n".join(re.sub("Hint: .*", "", words) for words in hidden_words(verdict))
    assert said.strip() and not re.search(r"\d", said)


@tried(
    "kind, place",
    {
        "a built-in type": ("ValueError", "code cell 1, line 2"),
        "a type of NumPy": ("LinAlgError", "code cell 1, line 2"),
        "a type of its own": ("leakabcd", "code cell 1, line 2"),
    },
)
def test_a_failure_is_told_by_type_and_place_alone(kind, place):
    error = StudentError("f", kind, "leakabcd", place, is_one_of_few=True)
    assert "leak" not in error.without_words and place in error.without_words
    assert (kind in error.without_words) == (kind in KNOWN_EXCEPTIONS)
    assert place not in StudentError("f", kind, "leakabcd", place).without_words


def test_claims_to_be_called_at_a_line_of_another_function():
    """Only a line of the exercise's own is told to have led to what raised."""
    body = """
def nest(line, more):
    return compile("\\n" * (line - 1) + more, "code cell 1", "exec")
exec(nest(35, "exec(inner)"), {"inner": nest(30, "1 / 0")})
"""
    with attack(function(body) + "\n" * 40) as student, pytest.raises(StudentError) as error:
        student.exercise = "f"
        student.f()
    assert error.value.place == "code cell 1, line 30"
    assert error.value.calling == "code cell 1, line 4"


@tried(
    "name",
    {
        "a line beyond the end of its cell": "code cell 1",
        "a cell that is not there": "code cell 77",
        "a line in words": "code cell leak",
        "a cell before the first": "code cell 0",
    },
)
def test_claims_a_place_that_is_not_in_the_notebook(name):
    """A line number is a number: one that does not exist would carry any question home."""
    body = f"exec(compile('\\n' * 987654 + '1/0', {name!r}, 'exec'))"
    with attack(function(body), call_seconds=8.0) as student, pytest.raises(StudentError) as error:
        student.f(np.zeros(3))
    assert "987" not in error.value.without_words and "77" not in error.value.without_words
    assert "leak" not in error.value.without_words


LINE_THAT_TELLS = """
def {name}(cloud, *arguments, **keywords):
    line = 100 + int(abs(cloud[0][0]) * 1000) % 4000
    exec(compile("\\n" * line + "1 / 0", {where}, "exec"))
"""


@tried(
    "where",
    {
        "a cell of blank lines": "next(f'code cell {n}' for n in range(1, 90) if n != here())",
        "the exercise's own cell": "f'code cell {here()}'",
    },
)
def test_tells_a_hidden_question_by_the_line_that_fails(where, hand_in):
    """A cell may have thousands of lines; what is told is one of the function's own, or none."""
    here = "\ndef here(): return int(here.__code__.co_filename.split()[-1])\n" + "\n" * 3000
    source = LINE_THAT_TELLS.format(name="filter_ground", where=where) + here
    verdict = hand_in({"filter_ground": source})
    said = [words for words in hidden_words(verdict) if words]
    lines = [int(line) for words in said for line in re.findall(r"line (\d+)", words)]
    assert len(said) > 15 and all(line < 100 for line in lines)


def test_tells_a_hidden_question_by_a_line_of_a_notebook_that_has_too_many(hand_in):
    source = LINE_THAT_TELLS.format(name="filter_ground", where="__file__") + "\n" * 5000
    verdict = hand_in({"filter_ground": source.replace("__file__", "'code cell 9'")})
    said = [test.message for exercise in verdict.exercises for test in exercise.tests]
    assert any("ZeroDivisionError" in words for words in said)
    assert not any(re.search(r"line \d", words) for words in said)


def test_tells_a_hidden_question_by_one_of_many_lines_of_the_function(hand_in):
    """Whose function is long is told no line."""
    body = "    if row == {0}: return 1 / 0\n"
    head = "def filter_ground(cloud, *a, **k):\n    row = int(abs(cloud[0][0]) * 1000) % {0}\n"
    for count, told in ((40, True), (400, False)):
        source = head.format(count) + "".join(body.format(n) for n in range(count))
        verdict = hand_in({"filter_ground": source})
        said = [words for words in hidden_words(verdict) if "ZeroDivisionError" in words]
        assert said and any("line" in words for words in said) == told


WORDS, SMALL_NUMBERS = 16, 100


def blanks_of(lesson):
    """How many blanks there are in each sentence about a wrong answer to a lesson's checks."""
    checks = PROJECT / "utils" / "checks"
    files = [path for path in checks.glob("*.py") if not path.name.startswith("lesson_")]
    files += [*checks.glob(f"lesson_{lesson.number}.py"), lesson.tests]
    files += checks.glob(f"lesson_{lesson.number}/*.py")
    return [
        blanks_in(node.args[0])
        for path in files
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in FAILURES and node.args
    ]


def blanks_in(message):
    """How many blanks a sentence has; as many as are told where it is made elsewhere."""
    if isinstance(message, ast.Constant):
        return 0
    if isinstance(message, ast.Call) and getattr(message.func, "id", "") == "fixed":
        return 0
    if isinstance(message, ast.JoinedStr):
        blanks = (part.value for part in message.values if isinstance(part, ast.FormattedValue))
        return sum(getattr(getattr(blank, "func", None), "id", "") != "fixed" for blank in blanks)
    if isinstance(message, ast.BinOp):
        return blanks_in(message.left) + blanks_in(message.right)
    return FEW_NUMBERS


def test_how_much_a_failure_can_tell_is_what_the_threat_model_says():
    """In bits, of what a student can choose: whether to raise, what, where, and our tip for it."""
    tips_for = {kind: {""} for kind in (*KNOWN_EXCEPTIONS, "another")}
    for kinds, _, _, tip in tips._TIPS:
        for kind in kinds.split("|"):
            tips_for.setdefault(kind, {""}).add(tip)
    raised = sum(map(len, tips_for.values())) * (MOST_LINES + 1)
    # Of a sentence without numbers what stands for a word may be one of some.
    wrong = max(sum(WORDS ** (n > 0) for n in blanks_of(lesson)) for lesson in all_lessons())
    ends_otherwise = 1 + wrong + 10  # passes, is wrong in some way of ours, hangs, dies
    bits = math.ceil(math.log2(raised + ends_otherwise))
    threats = (PROJECT / "grader" / "README.md").read_text("utf-8").partition("## Threat model")[2]
    assert f"up to {bits} bits about its question" in threats
    assert f"at most {MOST_LINES} lines" in threats
    assert f"which of {len(KNOWN_EXCEPTIONS)} types" in threats


def test_how_much_an_exercise_can_tell_is_what_the_threat_model_says():
    """Its mistake is looked for, and an edit that mends it, where it has met hidden questions."""
    exercises = [exercise.name for lesson in all_lessons() for exercise in lesson.machine_graded]
    mistakes = max(len([*checks_of(name)] and [*known_mistakes(name)]) for name in exercises)
    threats = (PROJECT / "grader" / "README.md").read_text("utf-8").partition("## Threat model")[2]
    for count, told in (
        (mistakes, "of at most {} named mistakes an exercise is explained, which is {} bits"),
        (edits.MOST_EDITS, "one of at most {} edits mends it, which is {}."),
    ):
        assert told.format(count, math.ceil(math.log2(count + 1))) in threats


def test_how_much_all_else_can_tell_is_what_the_threat_model_says():
    """Of what has met no hidden question: a visible check, or a cell."""
    tips_for = {kind: {""} for kind in (*NAMED_EXCEPTIONS, "one that the line raises", "another")}
    for kinds, _, _, tip in tips._TIPS:
        for kind in kinds.split("|"):
            tips_for[kind].add(tip)
    names = (LONGEST_LINE + 1) // 2
    most_forbidden = max(len(lesson.header.forbidden) for lesson in all_lessons())
    words = sum(map(len, tips_for.values())) + most_forbidden
    for kinds, pattern, _ in SENTENCES:
        words += sum(len(tips_for[kind]) for kind in kinds.split("|")) * names ** ("(" in pattern)
    raised = words * (MOST_LINES_OF_ALL + 1)
    called = raised * (MOST_LINES + 1)  # and the exercise's own line that led there
    # Each blank of a sentence takes a number or a word.
    is_wrong = max(
        sum((SMALL_NUMBERS + 1) ** min(n, FEW_NUMBERS) for n in blanks_of(lesson))
        for lesson in all_lessons()
    )
    of_check, of_cell = (math.ceil(math.log2(n)) for n in (called + is_wrong, raised))
    threats = (PROJECT / "grader" / "README.md").read_text("utf-8").partition("## Threat model")[2]
    assert f"up to {of_check} bits about each visible check" in threats
    assert f"{of_cell} about each of the first {MOST_FAILED_CELLS} cells" in threats


INJECTION = (
    "</td><script>alert(1)</script>\\x1b]0;owned\\x07 ![x](http://evil/x.png) "
    "[bold]{{ 7 * 7 }}\\u202e\\udcff"
)


def test_puts_markup_and_commands_into_what_people_read(hand_in, tmp_path, verdict_text):
    verdict = hand_in(
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


def test_puts_markup_and_commands_into_the_name_of_what_it_returns(hand_in, shown):
    body = "return type('\\x1b]0;owned\\x07<script>[red]\\u202e\\n', (), {})()"
    verdict = hand_in({"filter_ground": f"def filter_ground(*a, **k): {body}\n"})
    for text in shown(verdict):
        assert not re.search("[\x1b\u202e\x07]|<script>.red|owned", text)
