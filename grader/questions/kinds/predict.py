"""Questions about what the function returns in a small case."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

from grader.questions.answer import Behaviour
from grader.questions.question import OutcomeClaim, Question
from utils.questions.cases import shown_code, value_phrase
from utils.questions.choices import arrange, distractors
from utils.questions.texts import is_value


def prediction_questions(behaviour: Behaviour, random: Random) -> Iterator[Question]:
    """Ask for the value of each case, or ask the case's own question if it has one."""
    for number, case in enumerate(behaviour.cases):
        right = behaviour.own[number].outcome
        nearby = filter(is_value, behaviour.edited_outcomes(number))
        wrong = distractors(right, nearby, case.code)
        arranged = arrange(right, wrong, random)
        if is_value(right) and arranged:
            yield Question(
                case.kind if case.asked else "predict",
                case.asked or f"What is {value_phrase(case.code)}?",
                shown_code(case.code),
                *arranged,
                "The other choices are results of the same code with one small change.",
                not behaviour.matches_peers(number),
                (OutcomeClaim(case.executed, None, right),),
            )
