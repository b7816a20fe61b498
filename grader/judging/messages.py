"""What a person reads about a failed test, and about an exercise as a whole.

About a visible test everything: it is in the notebook. About a hidden one nothing that holds a
part of its question, or a word that student code chose: what kind of thing is wrong, where in
the student's own code, and our hint.
"""

import re

from grader.judging.asking import JudgeTimeout
from grader.sandbox.failures import StudentError, StudentStopped
from utils.checks import CheckFailed
from utils.checks.diagnosis import Mistake
from utils.checks.failures import NotStarted, NotYet, Raised, Stopped, WrongForm
from utils.checks.outcomes import Outcome
from utils.checks.story import Story, hint_for
from utils.checks.tips import tip_for


def told(outcome: Outcome, open_to_all: bool) -> Outcome:
    """What came of a check, in words that may be told.

    Parameters
    ----------
    outcome : Outcome
        As the judge saw it.
    open_to_all : bool
        False where the student's code had company that no word may be told of: then the checks
        that students see are told like hidden ones.
    """
    if outcome.failure is None:
        return outcome
    visible = open_to_all and outcome.check.is_shown
    return Outcome(outcome.check, failure_of(outcome, visible))


def messages_of(story: Story) -> dict[Outcome, str]:
    """What to tell about each failed test; one cause is told once.

    A hint comes with the first failure alone, as in `check()`: what else failed may have another
    cause than the one that its own hint is about.
    """
    if story.first is None:
        return {}
    same = f"For the same reason as “{story.first.check.title}”."
    return {
        story.first: text_of(story.first, story.mistake),
        **dict.fromkeys(story.same, same),
        **{one: text_of(one, hinted=False) for one in (*story.others, *story.waiting)},
    }


def text_of(outcome: Outcome, mistake: Mistake | None = None, hinted: bool = True) -> str:
    """What to tell about a failure, line by line."""
    failure = outcome.failure
    hint = hint_for(outcome, mistake) if hinted else ""
    lines = [
        mistake.says if mistake else "",
        failure.message,
        failure.tip,
        _side_by_side(failure),
        hint and f"Hint: {hint}",
    ]
    return "\n".join(line for line in lines if line)


def failure_of(outcome: Outcome, visible: bool) -> CheckFailed:
    """Why a test failed, in words that may be told."""
    error, exercise = outcome.failure, outcome.check.exercise
    if isinstance(error, StudentStopped):
        return Stopped(str(error), error.reason)
    if isinstance(error, StudentError) and error.type_name == "NotImplementedError":
        return NotStarted(exercise, error.inside or exercise)
    if isinstance(error, StudentError):
        said = str(error) if visible else error.without_words
        tip = tip_for(error.type_name, error.message, error.line)
        kind, place = error.type_name, error.place
        if not visible:
            kind, place = error.told_type, error.told_place
        return Raised(said, kind=kind, place=place, tip=tip)
    if isinstance(error, NotYet) or (isinstance(error, CheckFailed) and visible):
        return error
    if isinstance(error, CheckFailed):
        kind = type(error) if isinstance(error, WrongForm) else CheckFailed
        return kind(without_numbers(error.message), hint=error.hint)
    if isinstance(error, JudgeTimeout):
        return WrongForm(
            "Comparing the answer took longer than any right answer needs: is it much larger "
            "than what was asked for?"
        )
    return WrongForm(
        "The answer could not be compared with the right one "
        f"({type(error).__name__}): is it what the docstring promises?"
    )


def without_numbers(message: str) -> str:
    """A message without what differs from cloud to cloud: what is left is the kind of mistake."""
    message = re.sub(r",? for example \([^)]*\)", "", message)
    message = re.sub(r"(?<!\w)-?\d+(\.\d+)?(e[+-]?\d+)?(?!\w)", "…", message)
    return re.sub(r"\(…(, …)*,?\)", "(…)", message).replace("… row ", "… rows ")


def _side_by_side(error: CheckFailed) -> str:
    given = f"Given: {error.given}; " if error.given is not None else ""
    if error.yours is None:
        return given.removesuffix("; ")
    expected = f"; expected: {error.expected}" if error.expected is not None else ""
    return f"{given}{'yours' if given else 'Yours'}: {error.yours}{expected}"
