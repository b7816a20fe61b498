"""The table of marks in the report: a row a student, a cell a lesson."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import timedelta

from grader.course.lessons import Lesson
from grader.course.roster import Person
from grader.judging.verdict import JUDGED, Verdict
from grader.lms.results import (
    EXCUSED,
    MISSING,
    WAITING,
    ClassResults,
    NotebookResult,
    StageResult,
    write_number,
)

JUDGE_FAILED = "the judge failed: grade again"


@dataclass(frozen=True)
class MarkCell:
    """What stands in a cell, what it means, and the number to sort by."""

    text: str
    means: str = ""
    order: float = -1.0


@dataclass(frozen=True)
class StudentRow:
    """One student.

    Attributes
    ----------
    person : grader.course.roster.Person
    is_known : bool
        False for who handed in and is not in the gradebook.
    cells : tuple of MarkCell
    late : MarkCell
    sum : MarkCell
    share : float or None
        What that is of what it could be; None for who has no mark.
    """

    person: Person
    is_known: bool
    cells: tuple[MarkCell, ...]
    late: MarkCell
    sum: MarkCell
    share: float | None = None


@dataclass(frozen=True)
class Section:
    """How a section did.

    Attributes
    ----------
    name : str
        Empty for those who are in none.
    people, marked : int
        How many are in it, and how many of them have a mark.
    mean : float or None
        Of what these have of what they could have, from 0 to 1.
    """

    name: str
    people: int
    marked: int
    mean: float | None


@dataclass(frozen=True)
class MarksTable:
    """All rows, and what a column is worth.

    Attributes
    ----------
    lessons : tuple of Lesson
    most : tuple of str
        Points of each lesson.
    rows : tuple of StudentRow
    sections : tuple of Section
        Empty where nobody is in one.
    has_late : bool
        Whether anybody is late.
    from_gradebook : bool
        False where the scores are the judge's.
    """

    lessons: tuple[Lesson, ...]
    most: tuple[str, ...]
    rows: tuple[StudentRow, ...]
    sections: tuple[Section, ...]
    has_late: bool
    from_gradebook: bool


def marks_table(
    lessons: Sequence[Lesson],
    results: ClassResults,
    verdicts: Mapping[str, Mapping[str, Verdict]],
) -> MarksTable:
    """Make the table of a class.

    Parameters
    ----------
    lessons : list of Lesson
        The columns.
    results : ClassResults
        The marks.
    verdicts : dict of str to dict of str to Verdict
        By student and lesson: of who is not in the results, the scores are these.
    """
    worth = {v.lesson: v.max_score for mine in verdicts.values() for v in mine.values()}
    worth |= results.lessons
    rows = [_known(person, lessons, results, verdicts) for person in results.people]
    known = {person.id for person in results.people}
    rows += [
        _unknown(id, lessons, verdicts[id], bool(results.people))
        for id in verdicts
        if id not in known
    ]
    return MarksTable(
        tuple(lessons),
        tuple(write_number(worth[lesson.name]) for lesson in lessons),
        tuple(rows),
        tuple(_sections(rows)),
        any(row.late.text for row in rows),
        bool(results.people),
    )


def _known(
    person: Person,
    lessons: Sequence[Lesson],
    results: ClassResults,
    verdicts: Mapping[str, Mapping[str, Verdict]],
) -> StudentRow:
    mine = [results.notebook(person.id, lesson.name) for lesson in lessons]
    judged = verdicts.get(person.id, {})
    cells = tuple(
        _cell(result, judged.get(lesson.name)) for result, lesson in zip(mine, lessons, strict=True)
    )
    found = [result for result in mine if result]
    stages = dict.fromkeys(lesson.stage for lesson in lessons)
    standings = [one for stage in stages if (one := results.stage(person.id, stage))]
    counted = [one for one in found if one.standing != EXCUSED]
    most = sum(one.max_score for one in counted)
    earned = [one.points for one in counted if one.points is not None]
    share = sum(earned) / most if earned and most else None
    return StudentRow(person, True, cells, _late(standings), _sum(found), share)


def _sections(rows: Sequence[StudentRow]) -> Iterator[Section]:
    if not any(row.person.section for row in rows):
        return
    for name in sorted({row.person.section for row in rows if row.is_known}):
        shares = [row.share for row in rows if row.is_known and row.person.section == name]
        marked = [share for share in shares if share is not None]
        yield Section(name, len(shares), len(marked), statistics.mean(marked) if marked else None)


def _cell(result: NotebookResult | None, verdict: Verdict | None) -> MarkCell:
    if verdict and verdict.status != JUDGED:
        return MarkCell("?", JUDGE_FAILED)
    if result is None or result.standing == MISSING:
        return MarkCell("–", "missing: nothing was handed in")
    if result.standing == EXCUSED and result.score is None:
        return MarkCell("exc.", "excused: nothing is expected")
    if result.score is None:
        return MarkCell("…", "handed in, and not yet entered")
    text, means = write_number(result.points), []
    if result.standing == EXCUSED:
        text, means = f"({text})", ["excused: does not count"]
    elif result.standing == WAITING:
        text, means = f"{text} …", ["a person has still to grade something in it"]
    if result.penalty:
        means.append(
            f"{write_number(result.score)} less {write_number(result.penalty)} for lateness"
        )
    return MarkCell(text, "; ".join(means), result.points)


def _sum(results: Sequence[NotebookResult]) -> MarkCell:
    """The points of all that counts, of what they could be."""
    counted = [result for result in results if result.standing != EXCUSED]
    if not counted:
        return MarkCell("exc." if results else "–")
    whole = sum(result.points or 0.0 for result in counted)
    waiting = sum(result.standing == WAITING for result in counted)
    missing = sum(result.standing == MISSING for result in counted)
    kinds = {"wait for a person": waiting, "missing": missing}
    means = ", ".join(f"{number} {what}" for what, number in kinds.items() if number)
    most = write_number(sum(result.max_score for result in counted))
    return MarkCell(f"{write_number(whole)} of {most}{' …' if waiting else ''}", means, whole)


def _late(stages: Sequence[StageResult]) -> MarkCell:
    penalty = sum(stage.penalty for stage in stages)
    late = max((stage.late for stage in stages), default=timedelta())
    undecided = [stage for stage in stages if stage.undecided]
    parts = [duration(late)] if late else []
    parts += [f"−{write_number(penalty)}"] if penalty else []
    parts += ["undecided"] if undecided else []
    means = "; ".join(
        f"{stage.stage}: {duration(stage.late)} late" for stage in stages if stage.late
    )
    return MarkCell(", ".join(parts), means, late.total_seconds())


def duration(time: timedelta) -> str:
    """How long in the largest two units: ``1 d 3 h``, ``5 h 20 min``; at least a minute."""
    minutes = max(1, round(time.total_seconds() / 60))
    days, hours, rest = minutes // 1440, minutes % 1440 // 60, minutes % 60
    parts = [(days, "d"), (hours, "h"), (0 if days else rest, "min")]
    return " ".join(f"{number} {unit}" for number, unit in parts if number)


def _unknown(
    id: str, lessons: Sequence[Lesson], judged: Mapping[str, Verdict], is_stranger: bool
) -> StudentRow:
    cells = []
    for lesson in lessons:
        verdict = judged.get(lesson.name)
        if verdict is None:
            cells.append(MarkCell("–", "missing: nothing was handed in"))
        elif verdict.status != JUDGED:
            cells.append(MarkCell("?", JUDGE_FAILED))
        else:
            cells.append(MarkCell(write_number(verdict.score), "", verdict.score))
    scores = [verdict.score for verdict in judged.values() if verdict.status == JUDGED]
    whole = MarkCell(write_number(sum(scores)), "by the judge", sum(scores))
    return StudentRow(Person(id), not is_stranger, tuple(cells), MarkCell(""), whole)
