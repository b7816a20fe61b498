"""Messages about failed checks and about an exercise as a whole.

Messages never contain test input or text that student code computes. They name the kind of mistake
and its line, and include the lesson's hint. They never show the student's answer, not even for
visible checks, because the answer might contain the input of another check. In the notebook,
`check()` shows everything.
"""

import dataclasses
import functools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from grader.judging.runner import JudgeTimeout
from grader.judging.verdict import MessageKind
from grader.sandbox.error_descriptions import describe_error
from grader.sandbox.failures import CellSkipped, StudentError, StudentStopped
from utils.checks import CheckFailed
from utils.checks.diagnosis import Mistake
from utils.checks.failures import (
    CallStopped,
    ExceptionRaised,
    FunctionSkipped,
    NotStarted,
    NotYet,
    WrongForm,
    with_numbers,
)
from utils.checks.outcomes import Outcome
from utils.checks.summary import Summary, hint_for
from utils.checks.tips import tip_for
from utils.remote_objects import ENDLESS_LOOP_HINT

# Messages about visible checks may show a few small counts, as in "2 of 5 rows".
FEW_NUMBERS, SMALL_NUMBER = 4, r"\d{1,2}"
_EXAMPLE = re.compile(r",? for example \([^)]*\)")


def shareable_outcome(outcome: Outcome, is_public: bool) -> Outcome:
    """Return an outcome with its failure replaced by one that may be shown to the student.

    Parameters
    ----------
    outcome : Outcome
        The original outcome.
    is_public : bool
        False if the student's code ran together with code that messages must not reveal. In this
        case, visible checks are treated like hidden tests.
    """
    if outcome.failure is None:
        return outcome
    visible = is_public and outcome.check.is_shown
    return Outcome(outcome.check, shareable_failure(outcome, visible))


@dataclass(frozen=True)
class Message:
    """The message about a failed check. `CheckResult` describes the attributes."""

    text: str
    kind: MessageKind = MessageKind.OWN
    subject: str = ""
    hint: str = ""


def messages_of(summary: Summary) -> dict[Outcome, Message]:
    """Return the message about each failed check, explaining a shared cause only once.

    Only the message about the first failure includes a hint, as in `check()`. Hints of the other
    checks may not match the cause of their failures.
    """
    if summary.first is None:
        return {}
    full_messages = {
        summary.first: message_of(summary.first, summary.mistake),
        **{
            outcome: message_of(outcome, has_hint=False)
            for outcome in (*summary.others, *summary.waiting)
        },
    }
    for outcome, message in full_messages.items():
        if pointer := _notebook_pointer(outcome):
            full_messages[outcome] = dataclasses.replace(message, text=f"{message.text}\n{pointer}")
            break
    title = summary.first.check.title
    same = Message(f"Fails for the same reason as “{title}”.", MessageKind.SAME_REASON, title)
    return full_messages | dict.fromkeys(summary.same, same)


def message_of(outcome: Outcome, mistake: Mistake | None = None, has_hint: bool = True) -> Message:
    """Return the message about a failed check, with each part on its own line."""
    failure = outcome.failure
    hint = hint_for(outcome, mistake) if has_hint else ""
    hint = hint and f"Hint: {hint}"
    lines = [mistake.description if mistake else "", failure.message, failure.tip, hint]
    kind, subject = _kind_and_subject(failure)
    return Message("\n".join(line for line in lines if line), kind, subject, hint)


def _kind_and_subject(failure: CheckFailed) -> tuple[MessageKind, str]:
    match failure:
        case NotStarted():
            return MessageKind.NOT_STARTED, failure.stub
        case NotYet():
            return MessageKind.WAITING, failure.requirement
        case CallStopped(out_of_time=True):
            return MessageKind.OUT_OF_TIME, ""
    return MessageKind.OWN, ""


def shareable_failure(outcome: Outcome, is_visible: bool) -> CheckFailed:
    """Return a failure whose message may be shown, in place of the original one."""
    error, exercise = outcome.failure, outcome.check.exercise
    if isinstance(error, StudentStopped):
        question = outcome.check.slow or ENDLESS_LOOP_HINT
        return CallStopped(
            str(error).replace(ENDLESS_LOOP_HINT, question), error.reason, error.out_of_time
        )
    if isinstance(error, CellSkipped):
        return FunctionSkipped(error.sentence)
    if isinstance(error, StudentError) and error.type_name == "NotImplementedError":
        return NotStarted(exercise, error.inside or exercise)
    if isinstance(error, StudentError):
        sentence = describe_error(error) if is_visible else error.safe_sentence
        tip = tip_for(error.type_name, error.message, error.line)
        place = error.place if is_visible else error.shown_place
        return ExceptionRaised(sentence, kind=error.shown_type, place=place, tip=tip)
    if isinstance(error, NotYet):
        return NotYet(error.requirement)
    if isinstance(error, CheckFailed):
        kind = type(error) if isinstance(error, WrongForm) else CheckFailed
        number_filter = remove_most_numbers if is_visible else remove_numbers
        return kind(number_filter(error.marked), hint=error.hint)
    if isinstance(error, JudgeTimeout):
        return WrongForm(
            "Comparing the answer took longer than it does for any right answer. Is the answer "
            "much larger than it should be?"
        )
    return WrongForm(
        "The answer could not be compared with the right one "
        f"({type(error).__name__}). Is it what the docstring describes?"
    )


def remove_numbers(message: str, max_kept: int = 0) -> str:
    """Return a message without numbers and examples, which might reveal a secret answer.

    Numbers that belong to the task stay (see `utils.checks.failures.fixed`). The first `max_kept`
    small whole numbers stay as well, because they reveal little about the answer.
    """
    whole = iter(range(max_kept))

    def is_kept(number: str) -> bool:
        return bool(re.fullmatch(SMALL_NUMBER, number)) and next(whole, None) is not None

    return _filter_numbers(message, is_kept)


def common_text(messages: Sequence[str]) -> str:
    """Combine messages that differ only in numbers into one; numbers that differ are left out."""
    bare, numbers = zip(*map(_split_numbers, messages), strict=True)
    if len({*bare}) > 1 or len({*map(len, numbers)}) > 1:  # the numbers cannot be matched
        return remove_numbers(messages[0])
    are_equal = iter([len({*column}) == 1 for column in zip(*numbers, strict=True)])
    return _filter_numbers(messages[0], lambda number: next(are_equal))


def _split_numbers(message: str) -> tuple[str, list[str]]:
    """Return a message without its numbers, and the numbers."""
    numbers = []

    def remove_number(number: str) -> str:
        numbers.append(number)
        return "…"

    bare = with_numbers(_EXAMPLE.sub("", message), remove_number)
    return bare.replace("… row ", "… rows "), numbers


def _filter_numbers(message: str, is_kept: Callable[[str], bool]) -> str:
    message = _EXAMPLE.sub("", message)
    message = with_numbers(message, lambda number: number if is_kept(number) else "…")
    return re.sub(r"\(…(, …)*,?\)", "(…)", message).replace("… row ", "… rows ")


remove_most_numbers = functools.partial(remove_numbers, max_kept=FEW_NUMBERS)


def _notebook_pointer(outcome: Outcome) -> str:
    """Return a sentence that points to more information in the notebook, or an empty text."""
    if outcome.check.is_shown and outcome.failure.is_about_an_answer:
        return "The check in the notebook shows your answer next to the right one."
    if outcome.check.is_shown and isinstance(outcome.failure, ExceptionRaised):
        return "The check in the notebook shows Python's full error message."
    return ""
