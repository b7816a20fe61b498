"""What a person reads about a failed test, and about an exercise as a whole.

Nothing that holds a part of a question, or a word that student code chose: what kind of thing is
wrong, where in the student's own code, and our hint. Of a visible test the question is in the
notebook; but a neighbour's may be in the answer. There the student's own `check()` shows all.
"""

import dataclasses
import functools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from grader.judging.runner import JudgeTimeout
from grader.judging.verdict import Kind
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.quotation import sentence_on
from utils.checks import CheckFailed
from utils.checks.diagnosis import Mistake
from utils.checks.failures import (
    NotStarted,
    NotYet,
    Raised,
    Stopped,
    WrongForm,
    with_numbers,
)
from utils.checks.outcomes import Outcome
from utils.checks.summary import Story, hint_for
from utils.checks.tips import tip_for
from utils.remote_objects import ENDLESS

# Counts, as "2 of 5 rows", are told of what students see: so many, and below a hundred.
FEW_NUMBERS, SMALL_NUMBER = 4, r"\d{1,2}"
_EXAMPLE = re.compile(r",? for example \([^)]*\)")


def told(outcome: Outcome, open_to_all: bool) -> Outcome:
    """What came of a check, in words that may be told.

    Parameters
    ----------
    outcome : Outcome
        As the judge saw it.
    open_to_all : bool
        False where the student's code had company that no line may be told of: then the checks
        that students see are told like hidden ones.
    """
    if outcome.failure is None:
        return outcome
    visible = open_to_all and outcome.check.is_shown
    return Outcome(outcome.check, failure_of(outcome, visible))


@dataclass(frozen=True)
class Message:
    """What to tell about a failed check; the attributes are those of `CheckResult`."""

    text: str
    kind: Kind = Kind.OWN
    subject: str = ""
    hint: str = ""


def messages_of(story: Story) -> dict[Outcome, Message]:
    """What to tell about each failed test; one cause is told once.

    A hint comes with the first failure alone, as in `check()`: what else failed may have another
    cause than the one that its own hint is about.
    """
    if story.first is None:
        return {}
    in_full = {
        story.first: message_of(story.first, story.mistake),
        **{one: message_of(one, hinted=False) for one in (*story.others, *story.waiting)},
    }
    for one, message in in_full.items():
        if pointer := _where_to_see_more(one):
            in_full[one] = dataclasses.replace(message, text=f"{message.text}\n{pointer}")
            break
    title = story.first.check.title
    same = Message(f"For the same reason as “{title}”.", Kind.SAME_REASON, title)
    return in_full | dict.fromkeys(story.same, same)


def message_of(outcome: Outcome, mistake: Mistake | None = None, hinted: bool = True) -> Message:
    """What to tell about a failure, line by line."""
    failure = outcome.failure
    hint = hint_for(outcome, mistake) if hinted else ""
    hint = hint and f"Hint: {hint}"
    lines = [mistake.says if mistake else "", failure.message, failure.tip, hint]
    kind, subject = _kind_and_subject(failure)
    return Message("\n".join(line for line in lines if line), kind, subject, hint)


def _kind_and_subject(failure: CheckFailed) -> tuple[Kind, str]:
    match failure:
        case NotStarted():
            return Kind.NOT_STARTED, failure.stub
        case NotYet():
            return Kind.WAITING, failure.basic
        case Stopped(out_of_time=True):
            return Kind.OUT_OF_TIME, ""
    return Kind.OWN, ""


def failure_of(outcome: Outcome, visible: bool) -> CheckFailed:
    """Why a test failed, in words that may be told."""
    error, exercise = outcome.failure, outcome.check.exercise
    if isinstance(error, StudentStopped):
        question = outcome.check.slow or ENDLESS
        return Stopped(str(error).replace(ENDLESS, question), error.reason, error.out_of_time)
    if isinstance(error, StudentError) and error.type_name == "NotImplementedError":
        return NotStarted(exercise, error.inside or exercise)
    if isinstance(error, StudentError):
        said = sentence_on(error) if visible else error.without_words
        tip = tip_for(error.type_name, error.message, error.line)
        place = error.place if visible else error.told_place
        return Raised(said, kind=error.told_type, place=place, tip=tip)
    if isinstance(error, NotYet):
        return error
    if isinstance(error, CheckFailed):
        kind = type(error) if isinstance(error, WrongForm) else CheckFailed
        words = with_few_numbers if visible else without_numbers
        return kind(words(error.marked), hint=error.hint)
    if isinstance(error, JudgeTimeout):
        return WrongForm(
            "Comparing the answer took longer than any right answer needs: is it much larger "
            "than what was asked for?"
        )
    return WrongForm(
        "The answer could not be compared with the right one "
        f"({type(error).__name__}): is it what the docstring promises?"
    )


def without_numbers(message: str, few: int = 0) -> str:
    """A message without what differs from cloud to cloud: what is left is the kind of mistake.

    Numbers of the task itself stay (`utils.checks.failures.fixed`). Of small whole numbers a few
    may stay: an answer that is a secret says little by these.
    """
    whole = iter(range(few))

    def is_told(number: str) -> bool:
        return bool(re.fullmatch(SMALL_NUMBER, number)) and next(whole, None) is not None

    return _with_some_numbers(message, is_told)


def in_common(messages: Sequence[str]) -> str:
    """What messages say that are alike without their numbers: those stay in which they agree."""
    bare, numbers = zip(*map(_apart, messages), strict=True)
    if len({*bare}) > 1 or len({*map(len, numbers)}) > 1:  # nobody knows which belong together
        return without_numbers(messages[0])
    agree = iter([len({*column}) == 1 for column in zip(*numbers, strict=True)])
    return _with_some_numbers(messages[0], lambda number: next(agree))


def _apart(message: str) -> tuple[str, list[str]]:
    """A message less its numbers, and these."""
    numbers = []

    def take(number: str) -> str:
        numbers.append(number)
        return "…"

    bare = with_numbers(_EXAMPLE.sub("", message), take)
    return bare.replace("… row ", "… rows "), numbers


def _with_some_numbers(message: str, is_told: Callable[[str], bool]) -> str:
    message = _EXAMPLE.sub("", message)
    message = with_numbers(message, lambda number: number if is_told(number) else "…")
    return re.sub(r"\(…(, …)*,?\)", "(…)", message).replace("… row ", "… rows ")


with_few_numbers = functools.partial(without_numbers, few=FEW_NUMBERS)


def _where_to_see_more(outcome: Outcome) -> str:
    """What a student's own notebook shows of a failure beside this; empty where nothing."""
    if outcome.check.is_shown and outcome.failure.is_about_an_answer:
        return "The check in the notebook shows your answer beside the right one."
    if outcome.check.is_shown and isinstance(outcome.failure, Raised):
        return "The check in the notebook shows what Python says about it."
    return ""
