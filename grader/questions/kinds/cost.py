"""Questions about how often a line runs, also with more input."""

from __future__ import annotations

import re
from collections.abc import Iterator
from random import Random

from grader.questions.answer import Behaviour
from grader.questions.kinds.trace import keeps_lines
from grader.questions.kinds.wording import format_times
from grader.questions.question import CountClaim, Question
from utils.questions.cases import shown_code, shown_together
from utils.questions.choices import arrange, distractors

MAX_COUNT = 40
# Wrong counts are at most this many times the right one, because students could exclude larger ones
# without reading the code.
MAX_RATIO = 4


def cost_questions(behaviour: Behaviour, random: Random) -> Iterator[Question]:
    """Ask how often a line in a loop runs."""
    larger = [case for case in behaviour.cases if case.larger]
    for number, case in enumerate(behaviour.cases):
        if case.run:
            continue
        yield from _counts(behaviour, number, case.code, "", random)
        if case.larger:
            larger_number = len(behaviour.cases) + larger.index(case)
            yield from _counts(behaviour, larger_number, case.larger, case.code, random, number)


def _counts(
    behaviour: Behaviour,
    number: int,
    code: str,
    smaller: str,
    random: Random,
    smaller_number: int | None = None,
) -> Iterator[Question]:
    """Ask how often lines run in a case; with `smaller`, also show the smaller case's count."""
    run = behaviour.own[number]
    # The count of a line with a comprehension would be ambiguous, because parts of the line may run
    # more often than the line itself.
    lines = {
        statement.first for statement in behaviour.statements if not behaviour.loops(statement)
    }
    for line in sorted(lines & run.counts.keys()):
        right = run.counts[line]
        before = behaviour.own[smaller_number].counts.get(line, 0) if smaller else 0
        is_call_count = right == _calls(behaviour, run.counts)
        if not 1 < right <= MAX_COUNT or is_call_count or (smaller and before < 1):
            continue
        others = [
            runs[number].counts.get(line, 0)
            for edit, runs in behaviour.edited.items()
            if number < len(runs) and keeps_lines(edit)
        ]
        others += run.counts.values()
        others += [before, 2 * before, 4 * before, right + 1] if smaller else [right - 1, right + 1]
        likely = [count for count in others if 0 < count <= MAX_RATIO * right]
        wrong = distractors(format_times(right), map(format_times, likely))
        arranged = arrange(format_times(right), wrong, random)
        if arranged:
            yield Question(
                "cost",
                f"Part 1 runs line {line} of your code {format_times(before)}. How many times does "
                f"part 2 run line {line}?"
                if smaller
                else f"How many times does the code below run line {line} of your code?",
                shown_together({"part 1": smaller, "part 2": _with_difference(code, smaller)})
                if smaller
                else shown_code(code),
                *arranged,
                "",
                True,
                (
                    CountClaim(code, line, right),
                    *([CountClaim(smaller, line, before)] if smaller else []),
                ),
            )


def _calls(behaviour: Behaviour, counts: dict[int, int]) -> int:
    """Return how often the exercise is called: as often as its first statement runs."""
    definition = re.compile(rf"\s*def {behaviour.answer.exercise}\(")
    def_line = next((line.number for line in behaviour.lines if definition.match(line.text)), 0)
    starts = (statement.first for statement in behaviour.statements)
    return counts.get(min((start for start in starts if start > def_line), default=0), 0)


def _with_difference(code: str, smaller: str) -> str:
    """Return a larger case; if only one of its lines is new, add a comment to that line."""
    lines, others = code.split("\n"), smaller.split("\n")
    different = [number for number, line in enumerate(lines) if line not in others]
    if len(lines) > len(different) == 1:
        lines[different[0]] += "  # differs from part 1"
    return "\n".join(lines)
