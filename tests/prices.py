"""Judge the likely slips in every exercise, and write the points they keep to `docs/prices.md`.

``python -m tests.prices`` writes the page, which takes about ten minutes on two cores. Each slip in
`slips.py` is put into the lesson's solution, and the whole notebook is judged with seed 1,
including the search for an edit. `tests/test_prices.py` compares the page with new verdicts.
"""

import ast
import json
import re
import statistics
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from grader.course.lessons import Lesson, find_lesson, lesson_of
from grader.course.paths import PROJECT
from grader.course.rules import MISSED_TASK_KEEPS, ONE_SLIP_KEEPS
from grader.documentation import lesson_title
from grader.judging.judge import STARVED_NOTE, judge
from grader.sandbox import choose_sandbox
from tests.slip_tables import TABLES, solution_of
from tests.slips import MISSING, NAIVE, PARTLY, SMALL, USELESS, Slip

PAGE = PROJECT / "docs" / "prices.md"
SEED, WORKERS = 1, 2
PIPE = r"\|"  # a vertical bar within a table cell
_ROW = re.compile(r"^\| (.+?) \| (\d+)\s% \| (\d+)\s% \|", re.M)
_TOP = """\
# Cost of likely slips

A slip is one small change to the lesson's own solution. This page lists {slips} likely slips, and
shows what share of the exercise's points an answer with each slip keeps.
{at_least} of these answers ({share} %) keep at least {one_slip} of the points.

- If the judge proves that an answer has a single slip, the answer keeps at least {one_slip}, or at
  least {missed_task} if the slip misses the point of the exercise. See
  [grading a class](grading.md#what-happens-to-a-submission).
- If the judge does not prove a single slip, or if the change leaves out the lesson's method, the
  answer keeps only the points for the checks that it passes.

## By effect

The last three columns show the smallest, the median and the largest share of the points that an
answer keeps.

| effect | slips | least | median | most |
|---|---:|---:|---:|---:|
{effects}

## By exercise

The table counts slips by the share of the points that an answer keeps. Each link leads to the list
of an exercise's slips, with the slips that cost the most points first.

{exercises}
"""
_UNIT = "\N{NO-BREAK SPACE}%"
_MEANINGS = {
    USELESS: "a caller cannot use the result",
    PARTLY: "the result is right for some common inputs and wrong for others",
    SMALL: "the fault is easy to correct, or rarely matters",
    MISSING: "the answer does not use the lesson's method",
    NAIVE: "the code ignores its input, or follows an idea that fails in the lesson",
}
_FOOT = """
## How this page is made

`python -m tests.prices` puts each slip into the solution and judges the notebook with seed 1, which
takes about ten minutes on two cores. *By the checks* is the share that an answer would keep
without the rule about slips.
"""


@dataclass(frozen=True)
class Price:
    """The fractions of an exercise's points that a slip keeps."""

    checks: float
    kept: float

    @property
    def percent_kept(self) -> int:
        """The whole number on the page."""
        return round(100 * self.kept)


def all_slips() -> Iterator[tuple[str, Slip]]:
    """Yield each slip with the name of its exercise, in the order of the lessons."""
    for table in TABLES.values():
        for exercise, slips in table.items():
            yield from ((exercise, slip) for slip in slips)


def notebook_with(lesson: Lesson, exercise: str, source: str) -> str:
    """Return the JSON of a lesson's solved notebook with one function replaced."""
    notebook, replaced = json.loads(lesson.solved.read_text("utf-8")), 0
    for cell in notebook["cells"]:
        text = "".join(cell["source"])
        if cell["cell_type"] == "code" and f"def {exercise}(" in text and "%" not in text[:1]:
            for node in ast.parse(text).body:
                if isinstance(node, ast.FunctionDef) and node.name == exercise:
                    lines = text.split("\n")
                    lines[node.lineno - 1 : node.end_lineno] = source.split("\n")
                    cell["source"], replaced = "\n".join(lines), replaced + 1
    if replaced != 1:
        raise LookupError(f"{exercise} is defined {replaced} times in {lesson.solved}")
    return json.dumps(notebook)


def price_of(case: tuple[str, Slip]) -> Price:
    """Judge the lesson's solution with a slip."""
    exercise, slip = case
    lesson = lesson_of(exercise)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / lesson.released.name
        text = notebook_with(lesson, exercise, slip.applied_to(solution_of(exercise)))
        path.write_text(text, "utf-8")
        verdict = judge(path, SEED, choose_sandbox(), lesson=lesson)
    if verdict.starved:
        raise TimeoutError(f"{exercise}, {slip.title}: {STARVED_NOTE}")
    [result] = [each for each in verdict.exercises if each.name == exercise]
    added = result.slip.score if result.slip else 0
    return Price((result.score - added) / result.max_score, result.score / result.max_score)


def read_page() -> dict[str, dict[str, Price]]:
    """Return the prices on the page by exercise and title."""
    prices = {}
    for part in PAGE.read_text("utf-8").split("\n### ")[1:]:
        exercise = part.split("`")[1]
        prices[exercise] = {
            title.replace(PIPE, "|"): Price(int(checks) / 100, int(kept) / 100)
            for title, kept, checks in _ROW.findall(part)
        }
    return prices


def page(prices: dict[str, dict[str, Price]]) -> str:
    """Return the text of the page.

    Parameters
    ----------
    prices : dict
        Prices by exercise and title of the slip.
    """
    percents = [price.percent_kept for row in prices.values() for price in row.values()]
    at_least = sum(percent >= 100 * ONE_SLIP_KEEPS for percent in percents)
    top = _TOP.format(
        slips=len(percents),
        at_least=at_least,
        share=round(100 * at_least / len(percents)),
        one_slip=_percent(ONE_SLIP_KEEPS),
        missed_task=_percent(MISSED_TASK_KEEPS),
        effects="\n".join(_effect_rows(prices)),
        exercises="\n".join(_exercise_rows(prices)),
    )
    parts = [top]
    for name, table in TABLES.items():
        parts.append(f"\n## {name[:2]} · {lesson_title(find_lesson(name))}\n")
        for exercise, slips in table.items():
            dearest_first = sorted(
                slips, key=lambda slip: prices[exercise][slip.title].percent_kept
            )
            rows = [_slip_row(slip, prices[exercise][slip.title]) for slip in dearest_first]
            head = ["| slip | keeps | by the checks | effect |", "|---|---:|---:|---|"]
            parts.append("\n".join([f"\n### `{exercise}`\n", *head, *rows, ""]))
    return "".join([*parts, _FOOT])


def _effect_rows(prices: dict[str, dict[str, Price]]) -> Iterator[str]:
    for harm, meaning in _MEANINGS.items():
        percents = [
            prices[exercise][slip.title].percent_kept
            for exercise, slip in all_slips()
            if slip.harm is harm
        ]
        numbers = min(percents), statistics.median_low(percents), max(percents)
        columns = " | ".join(f"{number}{_UNIT}" for number in numbers)
        yield f"| **{harm.word}**: {meaning} | {len(percents)} | {columns} |"


def _exercise_rows(prices: dict[str, dict[str, Price]]) -> Iterator[str]:
    low, high = round(100 * MISSED_TASK_KEEPS), round(100 * ONE_SLIP_KEEPS)
    bands = f"below {low} % | {low} to {high - 1} % | {high} % | above {high} %"
    yield f"| lesson | exercise | {bands} |"
    yield "|---|---|---:|---:|---:|---:|"
    for name, table in TABLES.items():
        for exercise in table:
            percents = [price.percent_kept for price in prices[exercise].values()]
            counts = (
                sum(percent < low for percent in percents),
                sum(low <= percent < high for percent in percents),
                sum(percent == high for percent in percents),
                sum(percent > high for percent in percents),
            )
            columns = " | ".join(map(str, counts))
            yield f"| {name[:2]} | [`{exercise}`](#{exercise}) | {columns} |"


def _slip_row(slip: Slip, price: Price) -> str:
    title = slip.title.replace("|", PIPE)
    return f"| {title} | {_percent(price.kept)} | {_percent(price.checks)} | {slip.harm.word} |"


def _percent(share: float) -> str:
    return f"{round(100 * share)}{_UNIT}"


def main() -> None:
    """Judge all slips and write the page."""
    cases = list(all_slips())
    prices: dict[str, dict[str, Price]] = {exercise: {} for exercise, _ in cases}
    with ProcessPoolExecutor(WORKERS) as pool:
        judged = zip(cases, pool.map(price_of, cases), strict=True)
        for number, ((exercise, slip), price) in enumerate(judged):
            prices[exercise][slip.title] = price
            print(f"\r{number + 1} of {len(cases)} slips", end="", file=sys.stderr, flush=True)
    PAGE.write_text(page(prices), "utf-8")
    print(f"\nwrote {PAGE.relative_to(PROJECT)}", file=sys.stderr)


if __name__ == "__main__":
    main()
