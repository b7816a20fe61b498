"""Estimate how long each section of a lesson takes, from its words, code and tasks.

The rates were fitted to the times of readers who worked through all twelve lessons. They read
slowly, late at night, looked at each picture and wrote every answer. The mean error was eight
minutes per lesson. For lessons 08 and 10, the estimate is within three minutes of the time that a
later reader needed. Lessons 04, 06 and 07 need less thought than their length suggests, so they
state the minutes that readers named. A lesson's total excludes optional sections.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from grader.course import earlier_lessons
from grader.course.settings import minutes_of_calls

if TYPE_CHECKING:
    from nbformat import NotebookNode

# Placeholder for the minutes of a lesson: `(time)`, or `(time: 50)` if readers needed 50 minutes.
TIME_MARK = re.compile(r"\(time(?:: (\d+))?\)")
WORDS_PER_MINUTE = 100
LINES_PER_MINUTE = 8  # lines of code that students read
MINUTES_PER_EXERCISE, MINUTES_PER_LINE = 3, 1.8  # code that students write
MINUTES_PER_NOTEBOOK = 0.5  # finding the functions of an earlier notebook and pasting them
MINUTES_PER_REPORT = 15  # writing an answer that a person grades
MINUTES_FOR_QUESTIONS = 3  # answering the two questions about a function
MAX_MINUTES_WITHOUT_STOP = 90
# A comment on lines that students write or change, with their number if there are several.
OWN_LINES = re.compile(r"# (?:roughly (\d+) lines?|change this)", re.I)
UNREAD_TAGS = {"badge", "setup", "folded", "footer"}  # of cells that do not count as read
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
        if UNREAD_TAGS & set(cell.metadata.get("tags", ())):
            continue
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
    text = re.sub(r"### BEGIN SOLUTION.*?### END SOLUTION", "", cell.source, flags=re.S)
    lines = sum(1 for line in text.splitlines() if line.strip())
    own = OWN_LINES.search(text)
    writing = MINUTES_PER_EXERCISE + MINUTES_PER_LINE * int(own[1] or 1) if own else 0
    pasting = MINUTES_PER_NOTEBOOK * len(earlier_lessons.REFERENCE.findall(cell.source))
    answering = MINUTES_FOR_QUESTIONS * ("ask_about(" in text)
    waiting = sum(cost for name, cost in minutes_of_calls().items() if f"{name}(" in text)
    return lines / LINES_PER_MINUTE + writing + pasting + answering + waiting


def insert_durations(notebook: NotebookNode) -> None:
    """Replace `TIME_MARK` with the minutes of a lesson, and add a folded table by section.

    If the mark states the minutes, the sections are scaled to these minutes.

    Parameters
    ----------
    notebook : nbformat.NotebookNode
        With its common cells; changed in place.
    """
    minutes = section_minutes(notebook)
    for cell in notebook.cells:
        if cell.cell_type == "markdown" and (mark := TIME_MARK.search(cell.source)):
            total = int(mark[1] or total_minutes(notebook))
            scale = total / _required_minutes(minutes) if mark[1] else 1
            text = TIME_MARK.sub(_DURATION_TEXT.format(total), cell.source)
            table = _minutes_table({title: scale * part for title, part in minutes.items()})
            cell.source = f"{text}\n\n{table}"


def stated_minutes(notebook: NotebookNode) -> int:
    """Return the duration in minutes that a built notebook states, or else an estimate."""
    text = "".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")
    stated = _STATED_DURATION.search(text)
    return int(stated[1]) if stated else total_minutes(notebook)


def _minutes_table(minutes: dict[str, float]) -> str:
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
