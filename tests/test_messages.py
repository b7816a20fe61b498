"""What may be told of a failure: of a shown check everything, of a hidden one its kind."""

import pytest

from grader.judging.asking import JudgeTimeout
from grader.judging.messages import (
    failure_of,
    messages_of,
    text_of,
    told,
    without_numbers,
)
from grader.sandbox.failures import StudentError, StudentStopped
from utils.checks import Check, CheckFailed
from utils.checks.diagnosis import Mistake
from utils.checks.failures import (
    FarTooMuch,
    NotStarted,
    NotYet,
    Raised,
    Stopped,
    WrongForm,
)
from utils.checks.outcomes import Outcome
from utils.checks.story import resolve

SHOWN = Check("shown", "f", "It holds", "Look at it.", run=print)
HIDDEN = Check("test_hidden", "f", "It holds elsewhere", "Look there.")
UPSIDE_DOWN = Mistake("It is upside down.", predicts=print, hint="Turn it round.")


def words(check, failure, open_to_all=True):
    """What is told about a failure, line by line."""
    return text_of(told(Outcome(check, failure), open_to_all)).split("\n")


def test_of_what_holds_nothing_is_told():
    outcome = Outcome(SHOWN, None)
    assert told(outcome, True) is outcome and told(Outcome(HIDDEN, None), False).failure is None
    assert messages_of(resolve([outcome])) == {}


WRONG = CheckFailed(
    "3 of 17 rows are wrong, for example (1.5, -2): row 4",
    given="(1, 2)",
    yours="3",
    expected="4",
    tip="A tip.",
)


def test_of_a_shown_check_everything_is_told():
    assert words(SHOWN, WRONG) == [
        "3 of 17 rows are wrong, for example (1.5, -2): row 4",
        "A tip.",
        "Given: (1, 2); yours: 3; expected: 4",
        "Hint: Look at it.",
    ]


@pytest.mark.parametrize("check, open_to_all", [(HIDDEN, True), (HIDDEN, False), (SHOWN, False)])
def test_of_a_hidden_one_and_where_it_had_company_no_number_and_no_answer(check, open_to_all):
    assert words(check, WRONG, open_to_all) == [
        "… of … rows are wrong: row …",
        f"Hint: {check.hint}",
    ]


@pytest.mark.parametrize(
    ("given", "yours", "expected", "line"),
    [
        (None, None, None, None),
        ("1", None, None, "Given: 1"),
        ("1", None, "3", "Given: 1"),
        (None, "2", None, "Yours: 2"),
        (None, "2", "3", "Yours: 2; expected: 3"),
        ("1", "2", None, "Given: 1; yours: 2"),
        ("", "", "", "Given: ; yours: ; expected: "),
    ],
)
def test_what_stands_side_by_side(given, yours, expected, line):
    failure = CheckFailed("It is wrong.", given=given, yours=yours, expected=expected)
    said = words(SHOWN, failure)
    assert said == ["It is wrong.", *([line] if line else []), "Hint: Look at it."]


def test_the_kind_of_a_failure_is_told_and_its_own_hint():
    form = failure_of(Outcome(HIDDEN, WrongForm("shape (3, 4)", hint="Return rows.")), False)
    assert (type(form), form.message, form.hint) == (WrongForm, "shape (…)", "Return rows.")
    plain = failure_of(Outcome(HIDDEN, CheckFailed("7 are wrong")), False)
    assert type(plain) is CheckFailed
    # How much it was is told to nobody but the judge.
    assert type(failure_of(Outcome(HIDDEN, FarTooMuch("too much")), False)) is FarTooMuch
    waits = NotYet("It is sorted")
    assert failure_of(Outcome(HIDDEN, waits), False) is waits
    assert failure_of(Outcome(SHOWN, WRONG), True) is WRONG


def raised(kind="ValueError", message="a secret 17", **more):
    about = {"place": "code cell 3, line 2", "line": "x = y[0]", "is_one_of_few": True} | more
    return StudentError("f", kind, message, **about)


def test_of_an_exception_a_hidden_question_shows_no_word_of_the_student():
    shown = failure_of(Outcome(SHOWN, raised()), True)
    assert isinstance(shown, Raised) and "a secret 17" in shown.message
    assert (shown.kind, shown.place) == ("ValueError", "code cell 3, line 2")
    hidden = failure_of(Outcome(HIDDEN, raised()), False)
    assert hidden.message == "f raised ValueError (code cell 3, line 2)."
    assert (hidden.kind, hidden.place) == ("ValueError", "code cell 3, line 2")
    own = failure_of(Outcome(HIDDEN, raised("Secret17", is_one_of_few=False)), False)
    assert own.message == "f raised another exception."
    assert (own.kind, own.place) == ("another exception", None)


@pytest.mark.parametrize("visible", [True, False])
def test_a_known_exception_is_explained(visible):
    error = raised("IndexError", "boolean index did not match indexed array along axis 0")
    failure = failure_of(Outcome(SHOWN, error), visible)
    assert failure.tip and "17" not in failure.tip


@pytest.mark.parametrize(
    ("inside", "says"), [("", "f is not started"), ("g", "f calls g, which is not written yet")]
)
@pytest.mark.parametrize("visible", [True, False])
def test_a_stub_is_no_mistake(inside, says, visible):
    # As it comes through a pipe: another object than the text in our program.
    error = raised("".join(("NotImplemented", "Error")), inside=inside)
    failure = failure_of(Outcome(HIDDEN, error), visible)
    assert isinstance(failure, NotStarted) and failure.message.startswith(says)


@pytest.mark.parametrize("visible", [True, False])
@pytest.mark.parametrize(
    ("error", "kind", "says"),
    [
        (StudentStopped("It did not answer."), Stopped, "It did not answer."),
        (JudgeTimeout(), WrongForm, "Comparing the answer took longer"),
        (KeyError(17), WrongForm, "could not be compared with the right one (KeyError)"),
    ],
)
def test_how_else_a_check_may_end(error, kind, says, visible):
    failure = failure_of(Outcome(HIDDEN, error), visible)
    assert type(failure) is kind and says in failure.message and "17" not in failure.message


def test_one_cause_is_told_once_and_every_other_in_full():
    outcomes = [
        Outcome(SHOWN, None),
        Outcome(Check("1", "f", "First", "One."), WrongForm("no array")),
        Outcome(Check("2", "f", "Second", "Two."), CheckFailed("another")),
        Outcome(Check("3", "f", "Third", "Three."), WrongForm("no array")),
        Outcome(Check("4", "f", "Fourth", "Four."), NotYet("First")),
    ]
    messages = messages_of(resolve(outcomes, mistake=UPSIDE_DOWN))
    assert {one.check.name: message for one, message in messages.items()} == {
        "1": "It is upside down.\nno array\nHint: Turn it round.",
        "2": "another\nHint: Two.",
        "3": "For the same reason as “First”.",
        "4": "Cannot be judged yet. First: First.",
    }


@pytest.mark.parametrize(
    ("message", "kind"),
    [
        ("12 rows", "… rows"),
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
def test_what_differs_from_cloud_to_cloud_is_left_out(message, kind):
    assert without_numbers(message) == kind
