"""Questions about the value of a variable after a line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from random import Random

from grader.questions.answer import Behaviour, Edit
from grader.questions.kinds.wording import format_times
from grader.questions.question import Question, ValueClaim
from utils.questions.cases import shown_code
from utils.questions.choices import arrange, distractors
from utils.questions.shown_values import shown_values
from utils.questions.texts import is_alike

MAX_TURNS = 6  # runs of a line that a student can trace on paper in reasonable time
# Lines that only index or slice an array with constants, or take its length.
READS = re.compile(r"= (?:len\(\w+\)|\w+\[[\d:, -]*\])$")
ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth")


def trace_questions(behaviour: Behaviour, random: Random) -> Iterator[Question]:
    """Ask for values of variables that cannot be read directly from the source."""
    statements = {statement.first: statement for statement in behaviour.statements}
    for number, case in enumerate(behaviour.cases):
        run = behaviour.own[number]
        pairs = dict.fromkeys((line, name) for line, name, text in run.notes if text)
        for line, name in pairs:
            values = run.values(line, name)
            turns = run.counts.get(line, 0)
            if line not in statements or not len(values) == turns <= MAX_TURNS:
                continue
            if case.run or name == "_":
                continue
            turn = random.randrange(turns)
            right = values[turn]
            is_readable = right in behaviour.text_of(line) or right in shown_values(case.code)
            is_computed = not (READS.search(behaviour.text_of(line)) or is_readable)
            if not right or not is_computed or behaviour.decomposes(statements[line]):
                continue
            nearby = _values_in_edited_versions(behaviour, number, line, name, turn)
            likely = (text for text in [*nearby, *values] if is_alike(text, right))
            wrong = distractors(right, likely, case.code)
            arranged = arrange(right, wrong, random)
            if arranged:
                yield Question(
                    "trace",
                    _sentence(statements[line].last, name, turn, turns),
                    shown_code(case.code),
                    *arranged,
                    "The other choices are values of this variable at other times, or after one "
                    "small change to the code.",
                    True,
                    (ValueClaim(case.executed, line, name, turn, right),),
                )


def _sentence(line: int, name: str, turn: int, turns: int) -> str:
    if turns == 1:
        return f"What is the value of `{name}` after line {line} of your code has run?"
    return (
        f"The code below runs line {line} of your code {format_times(turns)}. What is the value of "
        f"`{name}` after the {ORDINALS[turn]} time?"
    )


def _values_in_edited_versions(
    behaviour: Behaviour, case: int, line: int, name: str, turn: int
) -> Iterator[str]:
    for edit, runs in behaviour.edited.items():
        if case < len(runs) and keeps_lines(edit):
            values = runs[case].values(line, name)
            if turn < len(values):
                yield values[turn]


def keeps_lines(edit: Edit) -> bool:
    """Return whether the lines below an edit keep their numbers."""
    return edit.after.count("\n") == edit.last - edit.first
