"""Estimate how long each section of a lesson takes, from its words, code and exercises.

The rates were fitted to the times of readers who worked through all twelve lessons. They read
slowly, late at night, looked at each picture and wrote every answer. The mean error is eight
minutes per lesson. For lesson 07, which needs little thought, the estimate is 15 minutes too long.
For lesson 10, which needs a lot of thought, it is 26 minutes too short. A lesson's total excludes
optional sections.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from grader.course import earlier_lessons

if TYPE_CHECKING:
    from nbformat import NotebookNode

TIME_MARK = "(time)"
WORDS_PER_MINUTE = 100
LINES_PER_MINUTE = 8  # lines of code that students read
MINUTES_PER_EXERCISE, MINUTES_PER_LINE = 3, 1.8  # code that students write
MINUTES_PER_NOTEBOOK = 0.5  # finding the functions of an earlier notebook and pasting them
MINUTES_PER_REPORT = 15  # writing an answer that a person grades
MAX_MINUTES_WITHOUT_STOP = 90
# Text that does not count as read: folded hints, pictures, and addresses of links.
UNREAD_TEXT = re.compile(r"<details>.*?</details>|!\[[^\]]*\]\([^)]*\)|(?<=\])\([^)]*\)", re.S)
STOP_MARK = "**A good place to stop.**"
OPTIONAL_TITLE = "If you want more"
_DURATION_TEXT = "about {} minutes"
_STATED_DURATION = re.compile(_DURATION_TEXT.format(r"(\d+)"))


def section_minutes(notebook: NotebookNode) -> dict[str, float]:
    """Estimate the minutes for each section of a solved notebook, by the section's title.

    Returns
    -------
    dict of str to float
        Text before the first heading counts as "Before you start".
    """
    minutes, title = {}, "Before you start"
    for cell in notebook.cells:
        if cell.metadata.get("nbgrader", {}).get("grade") and cell.cell_type == "markdown":
            # The words are not counted, because they are the model answer.
            minutes[title] = minutes.get(title, 0) + MINUTES_PER_REPORT
        elif cell.cell_type == "markdown":
            text = UNREAD_TEXT.sub("", cell.source)
            for part in re.split(r"^(?=## )", text, flags=re.M):
                if part.startswith("## "):
                    title = part.partition("\n")[0].removeprefix("## ").strip()
                words = len(re.findall(r"\w+", part))
                minutes[title] = minutes.get(title, 0) + words / WORDS_PER_MINUTE
        else:
            minutes[title] = minutes.get(title, 0) + _minutes_of_code(cell)
    return minutes


def _minutes_of_code(cell: NotebookNode) -> float:
    if {"setup", "folded"} & set(cell.metadata.get("tags", ())):
        return 0
    text = re.sub(r"### BEGIN SOLUTION.*?### END SOLUTION", "", cell.source, flags=re.S)
    lines = sum(1 for line in text.splitlines() if line.strip())
    own = re.search(r"# roughly (\d+) lines?", text)
    writing = MINUTES_PER_EXERCISE + MINUTES_PER_LINE * int(own[1]) if own else 0
    pasting = MINUTES_PER_NOTEBOOK * len(earlier_lessons.REFERENCE.findall(cell.source))
    return lines / LINES_PER_MINUTE + writing + pasting


def insert_durations(notebook: NotebookNode) -> None:
    """Replace `TIME_MARK` with the minutes of a lesson, and add a folded table by section.

    Parameters
    ----------
    notebook : nbformat.NotebookNode
        Changed in place.
    """
    total, by_section = _DURATION_TEXT.format(total_minutes(notebook)), _minutes_table(notebook)
    for cell in notebook.cells:
        if cell.cell_type == "markdown" and TIME_MARK in cell.source:
            cell.source = f"{cell.source.replace(TIME_MARK, total)}\n\n{by_section}"


def stated_minutes(notebook: NotebookNode) -> int:
    """Return the duration in minutes that a built notebook states, or else an estimate."""
    text = "".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")
    stated = _STATED_DURATION.search(text)
    return int(stated[1]) if stated else total_minutes(notebook)


def _minutes_table(notebook: NotebookNode) -> str:
    minutes = section_minutes(notebook)
    rows = "".join(
        f"<tr><td>{title}</td><td>{round(part)}</td></tr>"
        for title, part in minutes.items()
        if round(part) > 0 and title != OPTIONAL_TITLE
    )
    return f"<details><summary>Minutes of each section</summary><table>{rows}</table></details>"


def total_minutes(notebook: NotebookNode) -> int:
    """Estimate the minutes for a lesson, without optional sections, to the nearest five."""
    return 5 * round(_required_minutes(section_minutes(notebook)) / 5)


def _required_minutes(minutes: dict[str, float]) -> float:
    return sum(part for title, part in minutes.items() if title != OPTIONAL_TITLE)


def sitting_minutes(notebook: NotebookNode) -> list[float]:
    """Estimate the minutes of each sitting. A sitting ends at a good place to stop."""
    from nbformat.v4 import new_notebook

    sittings: list[list] = [[]]
    for cell in notebook.cells:
        sittings[-1].append(cell)
        if cell.cell_type == "markdown" and STOP_MARK in cell.source:
            sittings.append([])
    return [_required_minutes(section_minutes(new_notebook(cells=cells))) for cells in sittings]
