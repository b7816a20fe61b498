"""The table of marks in the report: one row per student, one cell per lesson."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import timedelta

from grader.course.deadlines import TermRules
from grader.course.lessons import Lesson
from grader.course.roster import Person
from grader.judging.verdict import JUDGED, Verdict
from grader.lms.results import (
    AUDITOR,
    EXCUSED,
    MISSING,
    WAITING,
    ClassResults,
    NotebookResult,
    StageResult,
    rounded_points,
)
from grader.lms.term import TermResult, term_result

# For each status that does not count: the text of a cell without a score, and its meaning.
NOT_COUNTED = {
    EXCUSED: ("exc.", "excused: no submission needed"),
    AUDITOR: ("aud.", "auditor: no work counts"),
}


@dataclass(frozen=True)
class MarkCell:
    """The text of a cell, its explanation, and a number for sorting."""

    text: str
    meaning: str = ""
    order: float = -1.0


@dataclass(frozen=True)
class StudentRow:
    """The row of one student.

    Attributes
    ----------
    person : grader.course.roster.Person
    is_known : bool
        Whether the student is in the gradebook; False if the student only submitted.
    cells : tuple of MarkCell
    late : MarkCell
    total : MarkCell
    share : float or None
        Fraction of the possible points that the student earned; None without a mark.
    passed : MarkCell
        Whether the student reaches the pass mark; blank if there is none.
    """

    person: Person
    is_known: bool
    cells: tuple[MarkCell, ...]
    late: MarkCell
    total: MarkCell
    share: float | None = None
    passed: MarkCell = MarkCell("")


@dataclass(frozen=True)
class Section:
    """Summary of one section of the class.

    Attributes
    ----------
    name : str
        Empty for students without a section.
    student_count, marked_count : int
        The number of students in the section, and how many of them have a mark.
    mean : float or None
        Mean share of the possible points of students with a mark, from 0 to 1.
    """

    name: str
    student_count: int
    marked_count: int
    mean: float | None


@dataclass(frozen=True)
class MarksTable:
    """All rows of the table, and the possible points in each column.

    Attributes
    ----------
    lessons : tuple of Lesson
    max_points : tuple of str
        Possible points in each lesson.
    rows : tuple of StudentRow
    sections : tuple of Section
        Empty if no student has a section.
    has_late : bool
        Whether any student is late.
    has_pass_mark : bool
    from_gradebook : bool
        False if the scores come from the judge.
    """

    lessons: tuple[Lesson, ...]
    max_points: tuple[str, ...]
    rows: tuple[StudentRow, ...]
    sections: tuple[Section, ...]
    has_late: bool
    has_pass_mark: bool
    from_gradebook: bool


def marks_table(
    lessons: Sequence[Lesson],
    results: ClassResults,
    verdicts: Mapping[str, Mapping[str, Verdict]],
) -> MarksTable:
    """Build the table of marks for a class.

    Parameters
    ----------
    lessons : list of Lesson
        Columns of the table.
    results : ClassResults
        Marks from the gradebook.
    verdicts : dict of str to dict of str to Verdict
        Verdicts by student and lesson, which provide the scores of students without results.
    """
    max_scores = {
        verdict.lesson: verdict.max_score
        for by_lesson in verdicts.values()
        for verdict in by_lesson.values()
    }
    max_scores |= results.lessons
    rows = [_gradebook_row(person, lessons, results, verdicts) for person in results.people]
    known = {person.id for person in results.people}
    rows += [_judged_row(id, lessons, verdicts[id], results) for id in verdicts if id not in known]
    return MarksTable(
        tuple(lessons),
        tuple(rounded_points(max_scores[lesson.name]) for lesson in lessons),
        tuple(rows),
        tuple(_sections(rows)),
        any(row.late.text for row in rows),
        results.rules.pass_mark is not None,
        bool(results.people),
    )


def _gradebook_row(
    person: Person,
    lessons: Sequence[Lesson],
    results: ClassResults,
    verdicts: Mapping[str, Mapping[str, Verdict]],
) -> StudentRow:
    own = [results.notebook(person.id, lesson.name) for lesson in lessons]
    judged = verdicts.get(person.id, {})
    cells = tuple(
        _lesson_cell(result, judged.get(lesson.name))
        for result, lesson in zip(own, lessons, strict=True)
    )
    term = term_result([result for result in own if result], results.rules)
    stages = dict.fromkeys(lesson.stage for lesson in lessons)
    standings = [result for stage in stages if (result := results.stage(person.id, stage))]
    return StudentRow(
        person,
        True,
        cells,
        _late_cell(standings),
        _sum_cell([result for result in own if result], term),
        term.share,
        _passed_cell(term, results.rules),
    )


def _passed_cell(term: TermResult, rules: TermRules) -> MarkCell:
    if rules.pass_mark is None or not term.max_score:
        return MarkCell("")
    if term.passed is None:
        return MarkCell("…", "work is waiting for a grader", 0.5)
    return MarkCell("yes" if term.passed else "no", "", float(term.passed))


def _sections(rows: Sequence[StudentRow]) -> Iterator[Section]:
    if not any(row.person.section for row in rows):
        return
    counted = [row for row in rows if row.is_known and not row.person.is_auditor]
    for name in sorted({row.person.section for row in counted}):
        shares = [row.share for row in counted if row.person.section == name]
        marked = [share for share in shares if share is not None]
        yield Section(name, len(shares), len(marked), statistics.mean(marked) if marked else None)


def _lesson_cell(result: NotebookResult | None, verdict: Verdict | None) -> MarkCell:
    if verdict and verdict.status != JUDGED:
        return _unjudged_cell(verdict)
    if result is None or result.status == MISSING:
        return MarkCell("–", "missing: nothing was submitted")
    if not result.counts and result.score is None:
        return MarkCell(*NOT_COUNTED[result.status])
    if result.score is None:
        return MarkCell("…", "submitted, but not in the gradebook yet")
    text, notes = rounded_points(result.points), []
    if not result.counts:
        text, notes = f"({text})", [f"{result.status}: does not count"]
    elif result.status == WAITING:
        text, notes = f"{text} …", ["partly waiting for a grader"]
    if result.penalty:
        notes.append(
            f"{rounded_points(result.score)} minus {rounded_points(result.penalty)} for lateness"
        )
    return MarkCell(text, "; ".join(notes), result.points)


def _sum_cell(results: Sequence[NotebookResult], term: TermResult) -> MarkCell:
    """Build the cell with the total and the maximum of all lessons that count.

    The cell of a student without any mark contains no number, because missing work is not a 0.
    """
    counted = [result for result in results if result.counts]
    if not counted:
        return MarkCell(NOT_COUNTED[results[0].status][0] if results else "–")
    waiting = sum(result.status == WAITING for result in counted)
    missing = sum(result.status == MISSING for result in counted)
    kinds = {"waiting for a grader": waiting, "missing": missing}
    parts = [f"{number} {label}" for label, number in kinds.items() if number]
    if term.points is None:
        return MarkCell("…" if waiting else "–", ", ".join(parts))
    parts += [f"without {', '.join(name[:2] for name in term.dropped)}"] * bool(term.dropped)
    total = f"{rounded_points(term.points)} of {rounded_points(term.max_score)}"
    return MarkCell(f"{total}{' …' if waiting else ''}", ", ".join(parts), term.points)


def _late_cell(stages: Sequence[StageResult]) -> MarkCell:
    penalty = sum(stage.penalty for stage in stages)
    late = max((stage.late for stage in stages), default=timedelta())
    undecided = [stage for stage in stages if stage.undecided]
    parts = [format_duration(late)] if late else []
    parts += [f"−{rounded_points(penalty)}"] if penalty else []
    parts += ["time unknown"] if undecided else []
    explanation = "; ".join(
        f"{stage.stage}: {stage.undecided or f'{format_duration(stage.late)} late'}"
        for stage in stages
        if stage.late or stage.undecided
    )
    return MarkCell(", ".join(parts), explanation, late.total_seconds())


def format_duration(time: timedelta) -> str:
    """Format a time span in two units, such as ``1 d 3 h`` or ``5 h 20 min``; at least 1 min."""
    minutes = max(1, round(time.total_seconds() / 60))
    days, hours, remainder = minutes // 1440, minutes % 1440 // 60, minutes % 60
    parts = [(days, "d"), (hours, "h"), (0 if days else remainder, "min")]
    return " ".join(f"{number} {unit}" for number, unit in parts if number)


def _unjudged_cell(verdict: Verdict) -> MarkCell:
    return MarkCell("?", f"not judged: {verdict.reason}")


def _judged_row(
    id: str, lessons: Sequence[Lesson], verdicts: Mapping[str, Verdict], results: ClassResults
) -> StudentRow:
    cells = []
    for lesson in lessons:
        verdict = verdicts.get(lesson.name)
        if verdict is None:
            cells.append(MarkCell("–", "missing: nothing was submitted"))
        elif verdict.status != JUDGED:
            cells.append(_unjudged_cell(verdict))
        else:
            points = results.judged_points(verdict)
            cells.append(MarkCell(rounded_points(points), "", points))
    judged = [verdict for verdict in verdicts.values() if verdict.status == JUDGED]
    scores = list(map(results.judged_points, judged))
    total = MarkCell(rounded_points(sum(scores)), "points from the judge", sum(scores))
    return StudentRow(Person(id), not results.people, tuple(cells), MarkCell(""), total)
