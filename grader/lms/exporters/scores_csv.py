"""A class as a table of comma-separated values: a row a student, for spreadsheets and programs."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from datetime import UTC, timedelta

from grader.course.roster import Person
from grader.course.tables import harmless_cell
from grader.lms.exporters.protocol import Exported, ExportTrouble, Order
from grader.lms.instructor_notes import not_on_the_roster
from grader.lms.results import (
    EXCUSED,
    MISSING,
    WAITING,
    NotebookResult,
    StageResult,
    standing_in_stage,
    write_number,
)

ABOUT_PERSON = ("Student", "Last name", "First name", "E-mail", "Section")
ABOUT_STAGE = ("handed in", "days late", "late penalty", "standing")


def scores_csv(order: Order) -> Exported:
    """Write the scores of a class; of one stage or lesson, where the order names it.

    A heading, a row with what each lesson is worth, and a row for each student: the score in each
    lesson, empty where there is none; of each stage when it was handed in, how late, what is taken
    off for it, and how the student stands, in words; at last the total and what it is out of. Who
    is excused from a stage has neither points nor a place for them.
    """
    notebooks = [
        one for one in order.results.notebooks if order.assignment in (None, one.stage, one.lesson)
    ]
    if not notebooks:
        raise ExportTrouble(f"Nobody has handed in anything for {order.assignment}.")
    stages: dict[str, dict[str, float]] = {}
    for one in sorted(notebooks, key=lambda one: one.lesson):
        stages.setdefault(one.stage, {})[one.lesson] = one.max_score
    file = io.StringIO()
    table = csv.writer(file, lineterminator="\n")
    table.writerow(_head(stages))
    table.writerow(_out_of(stages))
    for person in order.results.people:
        mine = [notebook for notebook in notebooks if notebook.student == person.id]
        table.writerow(_row(order, person, mine, stages))
    content = file.getvalue().encode("utf-8", "replace")
    marked = {one.student for one in notebooks if one.standing != EXCUSED and one.score is not None}
    return Exported(content, len(marked), tuple(not_on_the_roster(order.results)))


def _head(stages: dict[str, dict[str, float]]) -> list[str]:
    columns = list(ABOUT_PERSON)
    for stage, lessons in stages.items():
        columns += [*lessons, *(f"{stage}: {what}" for what in ABOUT_STAGE)]
    return [*columns, "Total", "Out of"]


def _out_of(stages: dict[str, dict[str, float]]) -> list[str]:
    cells = ["out of", *[""] * (len(ABOUT_PERSON) - 1)]
    for lessons in stages.values():
        cells += [*map(write_number, lessons.values()), *[""] * len(ABOUT_STAGE)]
    most = sum(sum(lessons.values()) for lessons in stages.values())
    return [*cells, write_number(most), write_number(most)]


def _row(
    order: Order,
    person: Person,
    mine: Sequence[NotebookResult],
    stages: dict[str, dict[str, float]],
) -> list[str]:
    about = (person.id, person.last_name, person.first_name, person.email, person.section)
    cells = [harmless_cell(text) for text in about]
    for stage in stages:
        of_stage = [one for one in mine if one.stage == stage]
        cells += [_score(one) for one in of_stage]
        cells += _about_stage(order.results.stage(person.id, stage), of_stage)
    counted = [one for one in mine if one.standing != EXCUSED]
    total = sum(one.points or 0.0 for one in counted)
    return [*cells, write_number(total), write_number(sum(one.max_score for one in counted))]


def _score(result: NotebookResult) -> str:
    if result.standing == EXCUSED or result.score is None:
        return ""
    return write_number(result.score)


def _about_stage(stage: StageResult, lessons: Sequence[NotebookResult]) -> list[str]:
    handed_in = stage.handed_in.astimezone(UTC) if stage.handed_in else None
    return [
        handed_in.strftime("%Y-%m-%d %H:%M:%S UTC") if handed_in else "",
        _days_late(stage),
        write_number(sum(lesson.penalty for lesson in lessons if lesson.standing != EXCUSED)),
        _standing(lessons),
    ]


def _days_late(stage: StageResult) -> str:
    if stage.undecided:
        return "undecided"
    if stage.due is None or stage.handed_in is None:
        return ""
    return write_number(stage.late / timedelta(days=1))


def _standing(lessons: Sequence[NotebookResult]) -> str:
    """The standing in a stage or lesson, with the lessons that stand otherwise than it sounds."""
    whole = standing_in_stage(lessons)
    words = [] if whole == WAITING else [whole]
    if whole not in (EXCUSED, MISSING):
        for standing in (WAITING, MISSING):
            names = [lesson.lesson for lesson in lessons if lesson.standing == standing]
            words += [f"{standing}: {', '.join(names)}"] if names else []
    return "; ".join(words)
