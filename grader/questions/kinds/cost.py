"""Questions about how often a line runs, also with more input."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

from grader.questions.answer import Behaviour
from grader.questions.kinds.trace import _keeps_lines
from grader.questions.kinds.wording import format_times
from grader.questions.question import CountClaim, Question
from utils.questions.cases import shown_code
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
            second = len(behaviour.cases) + larger.index(case)
            yield from _counts(behaviour, second, case.larger, case.code, random, number)


def _counts(
    behaviour: Behaviour,
    number: int,
    code: str,
    smaller: str,
    random: Random,
    first: int | None = None,
) -> Iterator[Question]:
    run = behaviour.own[number]
    for line in sorted({statement.first for statement in behaviour.statements} & run.counts.keys()):
        right = run.counts[line]
        before = behaviour.own[first].counts.get(line, 0) if smaller else 0
        if not 1 < right <= MAX_COUNT or (smaller and before < 1):
            continue
        others = [
            runs[number].counts.get(line, 0)
            for edit, runs in behaviour.edited.items()
            if number < len(runs) and _keeps_lines(edit)
        ]
        others += run.counts.values()
        others += [before, 2 * before, 4 * before, right + 1] if smaller else [right - 1, right + 1]
        likely = [count for count in others if 0 < count <= MAX_RATIO * right]
        wrong = distractors(format_times(right), map(format_times, likely))
        arranged = arrange(format_times(right), wrong, random)
        if arranged:
            calls = shown_code(code)
            if smaller:
                calls = f"# part 1\n{shown_code(smaller)}\n\n# part 2\n{calls}"
            yield Question(
                "cost",
                f"While part 1 runs, line {line} runs {format_times(before)}. How many times does "
                "it run while part 2 runs?"
                if smaller
                else f"How many times does line {line} run while the code below runs?",
                calls,
                *arranged,
                f"The grader ran the code and counted how often line {line} ran.",
                True,
                (
                    CountClaim(code, line, right),
                    *([CountClaim(smaller, line, before)] if smaller else []),
                ),
            )
