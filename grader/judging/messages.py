"""What a person reads about a failed test.

About a visible test everything: it is in the notebook. About a hidden one nothing that holds a
part of its question, or a word that student code chose: what kind of thing is wrong, where in
the student's own code, and our hint.
"""

import re

from grader.judging.asking import JudgeTimeout, Outcome
from grader.sandbox.student import StudentError, StudentStopped
from utils.checks import CheckFailed
from utils.checks.tips import tip_for


def message_of(outcome: Outcome) -> str:
    """What to tell a student about a failed test, line by line."""
    error, visible = outcome.error, outcome.mark["visible"]
    exercise, hint = outcome.mark["exercise"], f"Hint: {outcome.mark['hint']}"
    if isinstance(error, StudentStopped):
        return str(error)
    if isinstance(error, StudentError) and error.type_name == "NotImplementedError":
        return (
            f"{exercise} still raises NotImplementedError: it was not written, "
            "or its cell was lost."
        )
    if isinstance(error, StudentError):
        said = str(error) if visible else error.without_words
        return _lines(said, tip_for(error.type_name, error.message), hint)
    if isinstance(error, CheckFailed) and visible:
        return _lines(error.message, _side_by_side(error), hint)
    if isinstance(error, CheckFailed):
        return _lines(without_numbers(error.message), hint)
    if isinstance(error, JudgeTimeout):
        return _lines(
            "Comparing the answer took longer than any right answer needs: is it much larger "
            "than what was asked for?",
            hint,
        )
    return _lines(
        "The answer could not be compared with the right one "
        f"({type(error).__name__}): is it what the docstring promises?",
        hint,
    )


def without_numbers(message: str) -> str:
    """A message without what differs from cloud to cloud: what is left is the kind of mistake."""
    message = re.sub(r",? for example \([^)]*\)", "", message)
    message = re.sub(r"(?<!\w)-?\d+(\.\d+)?(e[+-]?\d+)?(?!\w)", "…", message)
    return re.sub(r"\(…(, …)*,?\)", "(…)", message).replace("… row ", "… rows ")


def _side_by_side(error: CheckFailed) -> str:
    if error.yours is None:
        return ""
    expected = f"; expected: {error.expected}" if error.expected is not None else ""
    return f"Yours: {error.yours}{expected}"


def _lines(*lines: str) -> str:
    return "\n".join(line for line in lines if line)
