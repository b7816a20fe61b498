"""Questions about the effect of deleting a statement."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

from grader.questions.answer import Behaviour, Edit
from grader.questions.kinds.wording import lines_with_verb
from grader.questions.question import OutcomeClaim, Question
from utils.questions.cases import shown_code, value_phrase
from utils.questions.choices import arrange, distractors, with_first
from utils.questions.texts import ERROR, TRIVIAL_ERRORS, is_value, same_answer

# Outcomes that are easy to guess, because the deleted statement is a `return` or defines a name.
TRIVIAL = ("None", *TRIVIAL_ERRORS)


def deletion_questions(behaviour: Behaviour, random: Random) -> Iterator[Question]:
    """Ask for the value of a case after a statement has been deleted."""
    for number, case in enumerate(behaviour.cases):
        own = behaviour.own[number].outcome
        if case.run or not is_value(own):
            continue
        outcomes = {
            edit: runs[number].outcome
            for edit, runs in behaviour.deleted.items()
            if number < len(runs)
        }
        for edit, right in outcomes.items():
            if not right or same_answer(right, own) or _is_trivial(edit, right):
                continue
            others = [text for other, text in outcomes.items() if not _is_trivial(other, text)]
            nearby = distractors(right, [*others, *behaviour.edited_outcomes(number)], case.code)
            arranged = arrange(right, with_first(own, nearby), random)
            if arranged:
                yield Question(
                    "necessary",
                    f"{lines_with_verb(edit)} deleted. What is {value_phrase(case.code)} now?",
                    shown_code(case.code),
                    *arranged,
                    f"Without the deletion, the value is `{own}`.",
                    True,
                    (
                        OutcomeClaim(case.executed, edit, right),
                        OutcomeClaim(case.executed, None, own),
                    ),
                )


def _is_trivial(edit: Edit, outcome: str) -> bool:
    """Return whether an outcome is None, a missing name, or an error due to a deleted `return`."""
    deletes_result = edit.before.lstrip().startswith("return")
    return outcome in TRIVIAL or (deletes_result and outcome.startswith(ERROR))
