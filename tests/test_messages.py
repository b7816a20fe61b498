"""Messages about failures name the kind of failure, and quote only the notebook."""

import ast

import pytest

from grader.judging.messages import (
    Message,
    common_text,
    message_of,
    messages_of,
    remove_numbers,
    shareable_failure,
    shareable_outcome,
)
from grader.judging.runner import JudgeTimeout
from grader.judging.verdict import MessageKind
from grader.sandbox.error_descriptions import MAX_LINE_LENGTH, describe_error, describe_failed_cell
from grader.sandbox.failures import StudentError, StudentStopped
from tests.check_sources import FAILURES, calls_of
from utils.checks import Check, CheckFailed
from utils.checks.diagnosis import Mistake
from utils.checks.failures import (
    NUMBER,
    AnswerTooLarge,
    CallStopped,
    ExceptionRaised,
    NotStarted,
    NotYet,
    WrongForm,
    fixed,
)
from utils.checks.outcomes import Outcome
from utils.checks.summary import summarise
from utils.in_sandbox import ABSENT

SHOWN = Check("shown", "f", "It works", "Look at it.", run=print)
HIDDEN = Check("test_hidden", "f", "It works elsewhere", "Look there.")
UPSIDE_DOWN = Mistake("It is upside down.", predict=print, hint="Turn it round.")


def message_lines(check, failure, open_to_all=True):
    """Return the lines of the message about a failure."""
    return message_of(shareable_outcome(Outcome(check, failure), open_to_all)).text.split("\n")


def test_a_passed_check_has_no_message():
    outcome = Outcome(SHOWN, None)
    assert (
        shareable_outcome(outcome, True) is outcome
        and shareable_outcome(Outcome(HIDDEN, None), False).failure is None
    )
    assert messages_of(summarise([outcome])) == {}


WRONG = CheckFailed(
    "3 of 17 rows are wrong, for example (1.5, -2): row 4",
    input_text="(1, 2)",
    yours="3",
    expected="4",
    tip="A tip.",
)


@pytest.mark.parametrize("check, open_to_all", [(HIDDEN, True), (HIDDEN, False), (SHOWN, False)])
def test_messages_about_hidden_tests_have_no_numbers_and_no_answer(check, open_to_all):
    assert message_lines(check, WRONG, open_to_all) == [
        "… of … rows are wrong: row …",
        f"Hint: {check.hint}",
    ]


def test_messages_about_visible_checks_have_counts_but_no_answer():
    """Messages omit the answer, because it may contain the input of a hidden test."""
    assert message_lines(SHOWN, WRONG) == ["3 of 17 rows are wrong: row 4", "Hint: Look at it."]
    secret = CheckFailed("2 of 5 are wrong, by 0.6763 and 67, 8; then 6, 7 and 63", yours="6763")
    shown = "2 of 5 are wrong, by … and 67, 8; then …, … and …"
    assert message_lines(SHOWN, secret) == [shown, "Hint: Look at it."]
    assert message_lines(SHOWN, CheckFailed("676 of -3 are 1e5"))[0] == "… of … are …"


SEE_ANSWER = "The check in the notebook shows your answer next to the right one."
SEE_PYTHON = "The check in the notebook shows Python's full error message."


@pytest.mark.parametrize(
    ("failure", "expected_message"),
    [
        (CheckFailed("no"), SEE_ANSWER),
        (WrongForm("no array"), SEE_ANSWER),
        (AnswerTooLarge("too much"), SEE_ANSWER),
        (ExceptionRaised("no", kind="ValueError", place=None), SEE_PYTHON),
        (CallStopped("no"), None),
        (NotStarted("f", "f"), None),
        (NotYet("First"), None),
    ],
)
def test_the_reference_to_the_notebook_occurs_once(failure, expected_message):
    others = [CheckFailed("another"), CheckFailed("a third")]
    outcomes = [Outcome(SHOWN, failed) for failed in (failure, *others)]
    messages = messages_of(summarise(outcomes))
    ends = [message.text.rsplit("\n", 1)[-1] for message in messages.values()]
    assert [end for end in ends if end in (SEE_ANSWER, SEE_PYTHON)] == [
        expected_message or SEE_ANSWER
    ]
    hidden = messages_of(summarise([Outcome(HIDDEN, failure)]))
    assert "in the notebook" not in "".join(message.text for message in hidden.values())


def test_the_kind_and_the_hint_of_a_failure_are_kept():
    form = shareable_failure(Outcome(HIDDEN, WrongForm("shape (3, 4)", hint="Return rows.")), False)
    assert (type(form), form.message, form.hint) == (WrongForm, "shape (…)", "Return rows.")
    plain = shareable_failure(Outcome(HIDDEN, CheckFailed("7 are wrong")), False)
    assert type(plain) is CheckFailed
    large = shareable_failure(Outcome(HIDDEN, AnswerTooLarge("too much")), False)
    assert type(large) is AnswerTooLarge, "the judge treats answers of this type differently"
    waits = NotYet("It is sorted")
    shared = shareable_failure(Outcome(HIDDEN, waits), False)
    assert (type(shared), shared.message) == (NotYet, waits.message)
    assert shareable_failure(Outcome(SHOWN, WRONG), True).yours is None


def raised(kind="ValueError", message="a secret 17", **more):
    fields = {"place": "code cell 3, line 2", "line": "x = y[0]", "in_short_exercise": True} | more
    return StudentError("f", kind, message, **fields)


def test_the_message_about_an_exception_quotes_only_the_notebook():
    shown = shareable_failure(Outcome(SHOWN, raised()), True)
    assert isinstance(shown, ExceptionRaised)
    assert shown.message == "f raised ValueError (code cell 3, line 2: `x = y[0]`)."
    assert (shown.kind, shown.place) == ("ValueError", "code cell 3, line 2")
    hidden = shareable_failure(Outcome(HIDDEN, raised()), False)
    assert hidden.message == "f raised ValueError (code cell 3, line 2)."
    assert (hidden.kind, hidden.place) == ("ValueError", "code cell 3, line 2")
    own = shareable_failure(Outcome(HIDDEN, raised("Secret17", in_short_exercise=False)), False)
    assert own.message == "f raised another exception."
    assert (own.kind, own.place) == ("another exception", None)


MISSING = "name 'clod' is not defined"
REFUSED = "is not allowed in this lesson: it does the exercise for you"


@pytest.mark.parametrize(
    ("kind", "message", "line", "expected_message"),
    [
        ("NameError", MISSING, "return clod[mask]", f"NameError: {MISSING}"),
        ("NameError", MISSING, "return cloddy[mask]", "NameError"),
        ("NameError", f"{MISSING} 17", "return clod", f"NameError: {MISSING}"),
        ("KeyError", MISSING, "return clod", "KeyError"),
        (
            "UnboundLocalError",
            "cannot access local variable 'best' where it is not associated with a value",
            "return best",
            "UnboundLocalError: variable 'best' has no value yet",
        ),
        (
            "AttributeError",
            "'numpy.ndarray' object has no attribute 'append'",
            "rows.append(row)",
            "AttributeError: no attribute 'append'",
        ),
        (
            "AttributeError",
            "'numpy.ndarray' object has no attribute 'secret17'",
            "getattr(rows, word)",
            "AttributeError",
        ),
        (
            "TypeError",
            "f() got an unexpected keyword argument 'size'",
            "f(cloud, size=2)",
            "TypeError: no parameter 'size'",
        ),
        (
            "ModuleNotFoundError",
            "No module named 'open3d'",
            "import open3d as o3d",
            f"ModuleNotFoundError: no module named 'open3d': {ABSENT}",
        ),
        (
            "ModuleNotFoundError",
            "No module named 'secret17'",
            "import_(x)",
            f"ModuleNotFoundError: a module is missing: {ABSENT}",
        ),
        (
            "ImportError",
            f"scipy.cluster {REFUSED}",
            "DBSCAN()",
            f"ImportError: scipy.cluster {REFUSED}",
        ),
        (
            "ImportError",
            f"scipy.cluster.x17 {REFUSED}",
            "",
            f"ImportError: scipy.cluster {REFUSED}",
        ),
        ("ImportError", f"secret17 {REFUSED}", "", "ImportError"),
        ("ImportError", f"scipy.cluster {REFUSED} 17", "", "ImportError"),
        ("ValueError", "give me rows", 'raise ValueError("give me rows")', "ValueError"),
        ("EmptyCloud", "17", "raise lab.EmptyCloud(17)", "EmptyCloud"),
        ("EmptyCloud", "17", "check_cloud(EmptyCloud)", "another exception"),
        ("Secret17", "17", "raise kind()", "another exception"),
        ("SystemExit", "17", "exit(17)", "SystemExit"),
        ("StopIteration", "17", "next(rows)", "StopIteration"),
    ],
)
def test_a_word_is_quoted_only_if_it_is_in_the_line(kind, message, line, expected_message):
    error = raised(kind, message, line=line, forbidden=("sklearn.cluster", "scipy.cluster"))
    quoted = f": `{line}`" if line else ""
    assert describe_error(error) == f"f raised {expected_message} (code cell 3, line 2{quoted})."


def test_long_lines_are_cut():
    line = "x = " + "1 + " * 100 + "clod"
    sentence = describe_error(raised("NameError", MISSING, line=line))
    assert sentence == f"f raised NameError (code cell 3, line 2: `{line[:MAX_LINE_LENGTH]}…`)."


def test_a_message_without_a_place_is_complete():
    error = raised("NameError", MISSING, line="", place=None)
    assert describe_error(error) == "f raised NameError."
    assert describe_failed_cell(error) == "A cell failed: NameError."
    error = raised("NameError", MISSING, line="x = clod")
    assert (
        describe_failed_cell(error)
        == f"Code cell 3, line 2, failed: NameError: {MISSING} (`x = clod`)."
    )


@pytest.mark.parametrize("visible", [True, False])
def test_a_known_exception_is_explained(visible):
    error = raised("IndexError", "boolean index did not match indexed array along axis 0")
    failure = shareable_failure(Outcome(SHOWN, error), visible)
    assert failure.tip and "17" not in failure.tip


@pytest.mark.parametrize(
    ("inside", "message"), [("", "f is not started"), ("g", "f calls g, which is not written yet")]
)
@pytest.mark.parametrize("visible", [True, False])
def test_a_stub_is_not_started(inside, message, visible):
    # `join` creates a new string, because a text from a pipe is not identical to a literal.
    error = raised("".join(("NotImplemented", "Error")), inside=inside)
    failure = shareable_failure(Outcome(HIDDEN, error), visible)
    assert isinstance(failure, NotStarted) and failure.message.startswith(message)


@pytest.mark.parametrize("visible", [True, False])
@pytest.mark.parametrize(
    ("error", "kind", "message"),
    [
        (StudentStopped("It did not answer."), CallStopped, "It did not answer."),
        (JudgeTimeout(), WrongForm, "Comparing the answer took longer"),
        (KeyError(17), WrongForm, "could not be compared with the right one (KeyError)"),
    ],
)
def test_other_errors_have_fixed_messages(error, kind, message, visible):
    failure = shareable_failure(Outcome(HIDDEN, error), visible)
    assert type(failure) is kind and message in failure.message and "17" not in failure.message


def test_a_shared_cause_is_shown_once_and_other_failures_in_full():
    outcomes = [
        Outcome(SHOWN, None),
        Outcome(Check("1", "f", "First", "One."), WrongForm("no array")),
        Outcome(Check("2", "f", "Second", "Two."), CheckFailed("another")),
        Outcome(Check("3", "f", "Third", "Three."), WrongForm("no array")),
        Outcome(Check("4", "f", "Fourth", "Four."), NotYet("First")),
    ]
    messages = messages_of(summarise(outcomes, mistake=UPSIDE_DOWN))
    assert {outcome.check.name: message for outcome, message in messages.items()} == {
        "1": Message(
            "It is upside down.\nno array\nHint: Turn it round.", hint="Hint: Turn it round."
        ),
        "2": Message("another"),
        "3": Message("Fails for the same reason as “First”.", MessageKind.SAME_REASON, "First"),
        "4": Message("This check waits until First.", MessageKind.WAITING, "First"),
    }


@pytest.mark.parametrize(
    ("failure", "kind", "subject"),
    [
        (CheckFailed("no"), MessageKind.OWN, ""),
        (ExceptionRaised("no", kind="ValueError", place=None), MessageKind.OWN, ""),
        (NotStarted("f", "f"), MessageKind.NOT_STARTED, "f"),
        (NotStarted("f", "g"), MessageKind.NOT_STARTED, "g"),
        (NotYet("it is sorted"), MessageKind.WAITING, "it is sorted"),
        (CallStopped("no"), MessageKind.OWN, ""),
        (CallStopped("no", out_of_time=True), MessageKind.OUT_OF_TIME, ""),
    ],
)
def test_a_message_has_a_kind_and_a_subject(failure, kind, subject):
    message = message_of(Outcome(SHOWN, failure), has_hint=False)
    assert (message.kind, message.subject, message.hint) == (kind, subject, "")


def test_a_failure_records_whether_the_call_took_too_long():
    for out_of_time in (False, True):
        error = StudentStopped("f did not come back.", "slow", out_of_time)
        assert shareable_failure(Outcome(HIDDEN, error), False).out_of_time is out_of_time


@pytest.mark.parametrize(
    ("message", "kind"),
    [
        ("12 rows", "… rows"),
        ("60,000 rows of 1,234.5 m", "… rows of … m"),
        ("-1.5e-07 m, 2e+3 m", "… m, … m"),
        ("shape (3, 4), not (7,)", "shape (…), not (…)"),
        ("at (1.5, 2, -3)", "at (…)"),
        ("x1 and 3D stay, voxel_2 too", "x1 and 3D stay, voxel_2 too"),
        ("it is 3 row too many", "it is … rows too many"),
        ("wrong, for example (1, 2), and more", "wrong, and more"),
        ("wrong for example (1, 2).", "wrong."),
        ("nothing to hide (at all)", "nothing to hide (at all)"),
    ],
)
def test_numbers_that_depend_on_the_cloud_are_removed(message, kind):
    assert remove_numbers(message) == kind


def test_fixed_numbers_stay_in_messages_about_hidden_tests():
    text = fixed("Each of 0 to n - 1, -1.5 or (0, 0, 0), must occur") + f" {17} times, not 1."
    failure = CheckFailed(text)
    plain = "Each of 0 to n - 1, -1.5 or (0, 0, 0), must occur 17 times, not 1."
    assert (failure.message, str(failure)) == (plain, plain)
    assert message_lines(HIDDEN, failure)[0] == (
        "Each of 0 to n - 1, -1.5 or (0, 0, 0), must occur … times, not …."
    )
    # A visible check's message may contain only a few numbers; fixed numbers do not count.
    assert message_lines(SHOWN, CheckFailed(fixed("1, 2, 3, 4: ") + "5, 6, 7, 8 and 9"))[0] == (
        "1, 2, 3, 4: 5, 6, 7, 8 and …"
    )


def literal_parts(message):
    """Return the literal parts of a message in the code, except the fixed parts."""
    if isinstance(message, ast.JoinedStr):
        return [part for value in message.values for part in literal_parts(value)]
    if isinstance(message, ast.BinOp):
        return [*literal_parts(message.left), *literal_parts(message.right)]
    return [message.value] if isinstance(message, ast.Constant) else []


def test_every_argument_of_fixed_is_a_literal():
    calls = dict(calls_of(("fixed",)))
    assert len(calls) > 30
    assert [
        place
        for place, arguments in calls.items()
        if not (len(arguments) == 1 and isinstance(arguments[0], ast.Constant))
    ] == []


def test_every_number_in_a_literal_message_is_marked_as_fixed():
    calls = [*calls_of(FAILURES)]
    assert len(calls) > 150
    assert [
        (place, part)
        for place, arguments in calls
        for part in (literal_parts(arguments[0]) if arguments else [])
        if NUMBER.search(part)
    ] == []


def test_similar_messages_keep_the_numbers_that_agree():
    both = ["3 of 17 rows, for example (1, 2)", "4 of 17 rows, for example (3, 4)"]
    assert common_text(both) == "… of 17 rows"
    assert common_text(both[:1]) == "3 of 17 rows"
    assert common_text(["from 0 to n - 1; row 3", "from 0 to n - 1; row 5"]) == (
        "from 0 to n - 1; row …"
    )
    assert common_text(["one of … rows"] * 2) == "one of … rows"
    assert common_text(["shape (3, 4)", "shape (3,)"]) == "shape (…)"
    assert common_text(["(3, 4), not (5,)", "(3,), not (4, 5)"]) == "(…), not (…)"
    assert common_text(["1 row of 17 lost", "3 rows of 17 lost"]) == "… rows of 17 lost"
    assert common_text(["3 of 17 rows", "3 of 17 rows", "… of … rows"]) == "… of … rows"
