"""Judge the likely slips in every exercise, and write the points they keep to `docs/prices.md`.

``python -m tests.prices`` writes the page, which takes about ten minutes on two cores. Each slip in
`slips.py` is put into the lesson's solution, and the whole notebook is judged with seed 1,
including the search for an edit. `tests/test_prices.py` compares the page with new verdicts.
"""

import ast
import json
import re
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from grader.course.lessons import Lesson, find_lesson, lesson_of
from grader.course.paths import PROJECT
from grader.documentation import lesson_title
from grader.judging.judge import judge
from grader.sandbox import choose_sandbox
from tests.slips import Slip
from tests.test_slips import TABLES, solution_of

PAGE = PROJECT / "docs" / "prices.md"
SEED, WORKERS = 1, 2
PIPE = r"\|"  # a vertical bar within a table cell
_ROW = re.compile(r"^\| (.+?) \| (\d+)\s% \| (\d+)\s% \|", re.M)
_TOP = """\
# Cost of likely slips

This page lists the points that likely slips cost in each exercise. A slip is one small change to
the lesson's own solution.

- *By the checks* is the share of the exercise's points that its checks earn.
- *Kept* is the share of the points that the student gets. If the judge proves that an answer has
  a single slip, the answer keeps 60 %, or 40 % if the slip misses the point of the exercise. See
  [grading a class](grading.md#what-happens-to-a-submission).
- If the change leaves out the method of the lesson, or no single edit corrects it, the answer
  keeps only what its checks earn.
- *Effect* describes the result. A *partly wrong* result is right for some common inputs and wrong
  for others. A *small* fault is easy to correct, or rarely matters. *Method missing* means that
  the answer does not use the method of the lesson. *Naive* code ignores its input, or follows an
  idea that the lesson shows to fail.

`python -m tests.prices` writes this page. It puts each slip into the solution and judges the
notebook with seed 1, which takes about ten minutes on two cores.
"""


@dataclass(frozen=True)
class Price:
    """The fractions of an exercise's points that a slip keeps."""

    checks: float
    kept: float


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
            for title, checks, kept in _ROW.findall(part)
        }
    return prices


def page(prices: dict[tuple[str, str], Price]) -> str:
    """Return the text of the page.

    Parameters
    ----------
    prices : dict
        Prices by exercise and title of the slip.
    """
    parts = [_TOP]
    for name, table in TABLES.items():
        parts.append(f"\n## {name[:2]} · {lesson_title(find_lesson(name))}\n")
        for exercise, slips in table.items():
            rows = [
                f"| {title} | {_percent(price.checks)} | {_percent(price.kept)} "
                f"| {slip.harm.word} |"
                for slip in slips
                for title in [slip.title.replace("|", PIPE)]
                for price in [prices[exercise, slip.title]]
            ]
            head = ["| slip | by the checks | kept | effect |", "|---|---:|---:|---|"]
            parts.append("\n".join([f"\n### `{exercise}`\n", *head, *rows, ""]))
    return "".join(parts)


def _percent(share: float) -> str:
    return f"{100 * share:.0f}\N{NO-BREAK SPACE}%"


def main() -> None:
    """Judge all slips and write the page."""
    cases, prices = list(all_slips()), {}
    with ProcessPoolExecutor(WORKERS) as pool:
        for number, (case, price) in enumerate(zip(cases, pool.map(price_of, cases), strict=True)):
            prices[case[0], case[1].title] = price
            print(f"\r{number + 1} of {len(cases)} slips", end="", file=sys.stderr, flush=True)
    PAGE.write_text(page(prices), "utf-8")
    print(f"\nwrote {PAGE.relative_to(PROJECT)}", file=sys.stderr)


if __name__ == "__main__":
    main()
