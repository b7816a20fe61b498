"""Questions about the effect of a change: the new value, or the calls that it affects."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from random import Random

from grader.questions.answer import Behaviour, Edit, Run
from grader.questions.kinds.wording import quote_code
from grader.questions.question import OutcomeClaim, Question
from utils.questions.cases import shown_code, shown_together, value_phrase
from utils.questions.choices import arrange, distractors, in_rounds, with_first
from utils.questions.texts import adds_nan, is_easy, is_value, reversed_vector, same_answer

MAX_EDITS = 6  # changes to ask about in each of the two ways
LETTERS = "ABC"


def what_if_questions(behaviour: Behaviour, random: Random) -> Iterator[Question]:
    """Ask what a change does in one case, and which of three cases it affects."""
    edits = [edit for edit in behaviour.edited if edit.can_be_shown]
    yield from itertools.islice(_values(behaviour, edits, random), MAX_EDITS)
    yield from itertools.islice(_affected_calls(behaviour, edits, random), MAX_EDITS)


def _values(behaviour: Behaviour, edits: list[Edit], random: Random) -> Iterator[Question]:
    for number, edit in itertools.product(range(len(behaviour.cases)), in_rounds(edits)):
        case, own = behaviour.cases[number], behaviour.own[number].outcome
        runs = behaviour.edited[edit]
        if case.run or number >= len(runs) or not is_value(own):
            continue
        right = runs[number].outcome
        if not is_value(right) or same_answer(right, own) or adds_nan(right, own):
            continue
        nearby = filter(is_value, behaviour.edited_outcomes(number))
        arranged = arrange(right, with_first(own, distractors(right, nearby, case.code)), random)
        if arranged:
            yield Question(
                "what if",
                f"Line {edit.first} becomes {quote_code(edit.shown)}. What is "
                f"{value_phrase(case.code)} now?",
                shown_code(case.code),
                *arranged,
                f"Without the change, the value is {quote_code(own)}.",
                True,
                (
                    OutcomeClaim(case.executed, edit, right),
                    OutcomeClaim(case.executed, None, own),
                ),
            )


def _affected_calls(behaviour: Behaviour, edits: list[Edit], random: Random) -> Iterator[Question]:
    numbers = [
        number
        for number, case in enumerate(behaviour.cases)
        if not case.run and is_value(behaviour.own[number].outcome)
    ]
    if len(numbers) < len(LETTERS):
        return
    for edit in in_rounds(edits):
        asked = sorted(random.sample(numbers, len(LETTERS)))
        right = _affected(behaviour.own, behaviour.edited[edit], asked)
        others = (_affected(behaviour.own, runs, asked) for runs in behaviour.edited.values())
        arranged = arrange(right, distractors(right, others), random)
        if right and arranged:
            yield Question(
                "what if",
                f"Line {edit.first} becomes {quote_code(edit.shown)}. For which of these calls "
                "does the result change?",
                shown_together(
                    {
                        f"call {letter}": behaviour.cases[number].code
                        for letter, number in zip(LETTERS, asked, strict=True)
                    }
                ),
                *arranged,
                _results_sentence(behaviour, edit, asked),
                True,
                tuple(
                    claim
                    for letter, number in zip(LETTERS, asked, strict=True)
                    for claim in _claims(behaviour, edit, number)
                ),
            )


def _affected(own: Sequence[Run], runs: Sequence[Run], numbers: list[int]) -> str:
    """Return the letters of the calls whose value an edit changes; empty without a fair question.

    A question is too easy if all values change or none does. It is too hard if a value is an error,
    cannot be computed on paper or is the reversed vector.
    """
    if any(
        number >= len(runs) or not _is_clear(own[number].outcome, runs[number].outcome)
        for number in numbers
    ):
        return ""
    letters = [
        letter
        for letter, number in zip(LETTERS, numbers, strict=True)
        if not same_answer(runs[number].outcome, own[number].outcome)
    ]
    if len(letters) in (0, len(LETTERS)):
        return ""
    return " and ".join(letters) if len(letters) > 1 else f"only {letters[0]}"


def _is_clear(before: str, after: str) -> bool:
    if not is_value(after) or adds_nan(after, before):
        return False
    is_reversed = not same_answer(after, before) and same_answer(after, reversed_vector(before))
    return is_easy(before) and is_easy(after) and not is_reversed


def _claims(behaviour: Behaviour, edit: Edit, number: int) -> tuple[OutcomeClaim, OutcomeClaim]:
    case, own = behaviour.cases[number], behaviour.own[number].outcome
    after = behaviour.edited[edit][number].outcome
    return (
        OutcomeClaim(case.executed, None, own),
        OutcomeClaim(case.executed, edit, own, same_answer(after, own)),
    )


def _results_sentence(behaviour: Behaviour, edit: Edit, numbers: list[int]) -> str:
    runs = behaviour.edited[edit]
    return " ".join(
        f"{letter}: {quote_code(behaviour.own[number].outcome)} before, "
        f"{quote_code(runs[number].outcome)} now."
        for letter, number in zip(LETTERS, numbers, strict=True)
    )
