"""The first lines of the report: the mean, missing work, and items that need attention."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from grader.course.deadlines import Deadlines
from grader.lms.instructor_notes import assignment_notes, counted_lesson_notes, excessive_mark_notes
from grader.lms.marks_table import MarksTable
from grader.lms.results import AUDITOR, EXCUSED, MISSING, WAITING, ClassResults

# For each kind of entry: the section of the report, and the wording for one entry and for several.
SECTIONS = {
    "waiting": ("marks", "notebook to grade by hand", "notebooks to grade by hand"),
    "failed": ("marks", "notebook could not be judged", "notebooks could not be judged"),
    "undecided": ("undecided", "submission time is unknown", "submission times are unknown"),
    "same": (
        "same",
        "file was submitted by several students",
        "files were submitted by several students",
    ),
    "stopped": ("stopped", "notebook ran out of time", "notebooks ran out of time"),
    "repaired": ("repaired", "repaired or unusual file", "repaired or unusual files"),
    "left": ("left", "file was not judged", "files were not judged"),
}


@dataclass(frozen=True)
class AttentionItem:
    """An item that needs the instructor's attention, and the section of the report about it."""

    text: str
    anchor: str


@dataclass(frozen=True)
class Overview:
    """The first lines of the report.

    Attributes
    ----------
    counted : tuple of str
        Sentences about the lessons that count, about those that may not be assigned, and about
        marks above the maximum of their exercise.
    settings : str
        The settings in deadlines.toml; empty without a file.
    passed : str
        How many students reach the pass mark; empty if there is none.
    mean, missing : str
        Sentences about the mean and about missing work.
    attention : tuple of AttentionItem
        Empty if nothing needs the instructor's attention.
    """

    counted: tuple[str, ...]
    settings: str
    passed: str
    mean: str
    missing: str
    attention: tuple[AttentionItem, ...]


def overview_of(
    results: ClassResults,
    deadlines: Deadlines | None,
    table: MarksTable,
    sections: Mapping[str, int],
) -> Overview | None:
    """Return the overview of a class, or None if the gradebook has no results yet.

    Parameters
    ----------
    results : grader.lms.results.ClassResults
    deadlines : grader.course.deadlines.Deadlines or None
    table : grader.lms.marks_table.MarksTable
    sections : mapping of str to int
        Number of entries in each section of `SECTIONS`.
    """
    if not results.people:
        return None
    waiting = sum(
        result.status == WAITING and result.score is not None for result in results.notebooks
    )
    counts = {"waiting": waiting, **sections}
    return Overview(
        (
            *counted_lesson_notes(results).values(),
            *assignment_notes(results, deadlines),
            *excessive_mark_notes(results),
        ),
        "; ".join(deadlines.descriptions()) if deadlines else "",
        _passed(table, results),
        _mean([row.share for row in table.rows]) + _auditors(results),
        _missing(results),
        tuple(
            AttentionItem(f"{counts[name]} {words[counts[name] > 1]}", f"report-{anchor}")
            for name, (anchor, *words) in SECTIONS.items()
            if counts.get(name)
        ),
    )


def _mean(shares: Sequence[float | None]) -> str:
    marked = [share for share in shares if share is not None]
    if not marked:
        return "none, because no student has a mark yet."
    percent = f"{100 * statistics.mean(marked):.0f} % of the possible points"
    if len(marked) == 1:
        return f"{percent}, for the only student with a mark."
    return f"{percent}, for {len(marked)} students with a mark."


def _auditors(results: ClassResults) -> str:
    count = sum(person.is_auditor for person in results.people)
    if not count:
        return ""
    return f" {count} auditor{'s do' if count > 1 else ' does'} not count."


def _passed(table: MarksTable, results: ClassResults) -> str:
    if not table.has_pass_mark:
        return ""
    counts = Counter(row.passed.text for row in table.rows)
    total = counts["yes"] + counts["no"] + counts["…"]
    parts = [f"reached by {counts['yes']} of {_format_student_count(total)}"]
    parts += [f"not decided yet for {counts['…']}"] * bool(counts["…"])
    return f"{results.rules.pass_mark:g} % of the possible points; {', '.join(parts)}."


def _missing(results: ClassResults) -> str:
    statuses: dict[str, set[str]] = {}
    for result in results.notebooks:
        statuses.setdefault(result.student, set()).add(result.status)
    nothing = sum(
        MISSING in kinds and kinds <= {MISSING, EXCUSED, AUDITOR} for kinds in statuses.values()
    )
    some = sum(MISSING in kinds for kinds in statuses.values()) - nothing
    parts = [f"{_format_student_count(nothing)} submitted nothing"] * bool(nothing)
    parts += [f"{_format_student_count(some)} submitted only some lessons"] * bool(some)
    return f"{'; '.join(parts) or 'nothing'}."


def _format_student_count(count: int) -> str:
    return f"{count} student{'s' * (count != 1)}"
