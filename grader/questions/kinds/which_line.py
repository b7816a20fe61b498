"""Questions about which change causes a result, or which line does not run."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

from grader.questions.answer import Behaviour, Edit
from grader.questions.kinds.wording import quote_code
from grader.questions.question import CountClaim, OutcomeClaim, Question
from utils.questions.cases import Case, shown_code, value_phrase
from utils.questions.choices import MAX_CHOICES, MIN_CHOICES, arrange
from utils.questions.shown_values import is_selection
from utils.questions.texts import (
    ENDLESS,
    ERROR,
    TRIVIAL_ERRORS,
    adds_nan,
    is_easy,
    is_value,
    reversed_vector,
    same_answer,
    similarity,
)

MAX_SYMPTOMS = 4  # wrong results of a case to ask about


def which_line_questions(behaviour: Behaviour, random: Random) -> Iterator[Question]:
    """Ask which of several changes gives a result, and which line does not run."""
    for number, case in enumerate(behaviour.cases):
        if not case.run:
            yield from _idle_line_questions(behaviour, number, random)
            yield from _symptom_questions(behaviour, number, random)


def _symptom_questions(behaviour: Behaviour, number: int, random: Random) -> Iterator[Question]:
    case, own = behaviour.cases[number], behaviour.own[number].outcome
    if not is_value(own):
        return
    edits = {
        edit: runs[number].outcome
        for edit, runs in behaviour.edited.items()
        if number < len(runs)
        and runs[number].outcome not in ("", *TRIVIAL_ERRORS)
        and edit.can_be_shown
        and is_easy(runs[number].outcome)
    }
    symptoms = [
        text
        for text in dict.fromkeys(edits.values())
        if is_value(text) and not same_answer(text, own) and not _reveals_cause(text, own, case)
    ]
    # The sort is stable, so equally similar results stay in the order of the likeliest edits.
    symptoms.sort(key=lambda text: -similarity(own, text))
    for symptom in symptoms[:MAX_SYMPTOMS]:
        causes = [edit for edit, text in edits.items() if same_answer(text, symptom)]
        right = random.choice(causes[:3])
        others = [edit for edit, text in edits.items() if not same_answer(text, symptom)]
        wrong = _spread(right, others, edits, own)
        arranged = arrange(_choice(right), map(_choice, wrong), random)
        if arranged:
            outcomes = {edit: edits[edit] for edit in (right, *wrong)}
            yield Question(
                "which line",
                f"One line of your code was changed. Now {value_phrase(case.code)} is `{symptom}` "
                f"instead of `{own}`. Which change was made?",
                shown_code(case.code),
                *arranged,
                " ".join(
                    f"If {_choice(edit)}, {_effect(text)}."
                    for edit, text in outcomes.items()
                    if edit != right
                ),
                True,
                (
                    OutcomeClaim(case.executed, None, own),
                    *(
                        OutcomeClaim(case.executed, edit, symptom, edit == right)
                        for edit in outcomes
                    ),
                ),
            )


def _spread(right: Edit, others: list[Edit], outcomes: dict[Edit, str], own: str) -> list[Edit]:
    """Return wrong choices, preferably with different lines and different effects."""
    wrong, lines, effects = [], {right.first}, {outcomes[right]}
    ranked = sorted(
        others, key=lambda edit: (same_answer(outcomes[edit], own), not is_value(outcomes[edit]))
    )
    for wants_line, wants_effect in ((True, True), (True, False), (False, True), (False, False)):
        for edit in ranked:
            if len(wrong) == MAX_CHOICES - 1:
                return wrong
            is_new = edit not in wrong and _choice(edit) not in map(_choice, wrong)
            if (
                is_new
                and _choice(edit) != _choice(right)
                and (not wants_line or edit.first not in lines)
                and (not wants_effect or outcomes[edit] not in effects)
            ):
                wrong.append(edit)
                lines.add(edit.first)
                effects.add(outcomes[edit])
    return wrong


def _choice(edit: Edit) -> str:
    return f"line {edit.first} becomes {quote_code(edit.shown)}"


def _reveals_cause(symptom: str, own: str, case: Case) -> bool:
    """Return whether a wrong result alone shows which operation was changed, such as a sign."""
    is_changed = is_selection(own, case.code) and not is_selection(symptom, case.code)
    is_reversed = same_answer(symptom, reversed_vector(own)) or symptom == f"-{own}"
    return adds_nan(symptom, own) or is_changed or is_reversed


def _effect(outcome: str) -> str:
    if outcome == ENDLESS:
        return "the code never ends"
    if outcome.startswith(ERROR):
        return f"the code raises {quote_code(outcome.removeprefix(ERROR))}"
    return f"the result is {quote_code(outcome)}"


def _idle_line_questions(behaviour: Behaviour, number: int, random: Random) -> Iterator[Question]:
    case, counts = behaviour.cases[number], behaviour.own[number].counts
    lines = [statement.first for statement in behaviour.statements]
    idle = [line for line in lines if not counts.get(line)]
    busy = [line for line in lines if counts.get(line)]
    if not idle or len(busy) < MIN_CHOICES - 1 or not any(counts.values()):
        return
    right = random.choice(idle)
    wrong = random.sample(busy, min(len(busy), MAX_CHOICES - 1))
    arranged = arrange(f"line {right}", [f"line {line}" for line in wrong], random)
    yield Question(
        "which line",
        "Which of these lines of your code does not run when the code below runs?",
        shown_code(case.code),
        *arranged,
        "The other lines run at least once.",
        True,
        (
            CountClaim(case.executed, right, 0),
            *(CountClaim(case.executed, line, counts[line]) for line in wrong),
        ),
    )
