"""Scores of a class as a CSV file with one row per student, for spreadsheets and programs."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from datetime import UTC, timedelta

from grader.course.deadlines import TermRules
from grader.course.roster import Person
from grader.course.tables import escape_cell
from grader.lms.exporters.assignment_marks import provisional_notes
from grader.lms.exporters.protocol import ExportError, ExportOptions, ExportResult
from grader.lms.instructor_notes import (
    excessive_mark_notes,
    outdated_mark_notes,
    unlisted_student_notes,
)
from grader.lms.results import (
    MARKED,
    MISSING,
    WAITING,
    NotebookResult,
    StageResult,
    combined_status,
    format_points,
)
from grader.lms.term import TermResult, term_result

PERSON_TITLES = ("Student", "Last name", "First name", "E-mail", "Section")
STAGE_TITLES = ("submitted", "days late", "late penalty", "status")


def export_scores_csv(options: ExportOptions) -> ExportResult:
    """Write the scores of a class, limited to one stage or lesson if the options name one.

    The file has a heading, a row with the maximum score of each lesson, and one row per student. A
    student's row contains the score in each lesson; without a score, the cell is empty. For each
    stage it also contains the submission time, the days late, the penalty and the status. The
    next columns are the total and its maximum, without the stages from which a student is excused.
    They are empty if a student has no mark. If there is a pass mark, the last column shows whether
    the total reaches it. The rules of the term apply only if the options name no assignment.
    """
    rules = options.results.rules if options.assignment is None else TermRules()
    notebooks = notebooks_of(options)
    stages: dict[str, dict[str, float]] = {}
    for result in sorted(notebooks, key=lambda result: result.lesson):
        stages.setdefault(result.stage, {})[result.lesson] = result.max_score
    file = io.StringIO()
    table = csv.writer(file, lineterminator="\n")
    table.writerow(_title_row(options, stages, rules))
    table.writerow(_maximum_row(options, stages, rules))
    for person in options.results.people:
        own = [result for result in notebooks if result.student == person.id]
        table.writerow(_row(options, person, own, stages, rules))
    # Without a byte order mark, Excel shows umlauts as other characters.
    content = file.getvalue().encode("utf-8-sig", "replace")
    marked = {result.student for result in notebooks if result.counts and result.score is not None}
    notes = [note for stage in stages for note in outdated_mark_notes(options.results, stage)]
    notes += excessive_mark_notes(options.results)
    notes += filter(None, provisional_notes(notebooks))
    return ExportResult(
        content, len(marked), tuple(unlisted_student_notes(options.results)), tuple(notes)
    )


def notebooks_of(options: ExportOptions) -> list[NotebookResult]:
    """Return the results in all lessons, or in the stage or lesson that the options name."""
    notebooks = [
        result
        for result in options.results.notebooks
        if options.assignment in (None, result.stage, result.lesson)
    ]
    if not notebooks:
        raise ExportError(f"No student has submitted anything for {options.assignment}.")
    return notebooks


def person_titles(options: ExportOptions) -> list[str]:
    """Return the titles of the columns about a person, with the roster's additional columns."""
    people = options.results.people
    return [*PERSON_TITLES, *(escape_cell(title) for title, _ in people[0].additional_cells)]


def person_cells(person: Person) -> list[str]:
    """Return the cells about a person."""
    texts = (person.id, person.last_name, person.first_name, person.email, person.section)
    return [escape_cell(text) for text in (*texts, *(text for _, text in person.additional_cells))]


def _title_row(
    options: ExportOptions, stages: dict[str, dict[str, float]], rules: TermRules
) -> list[str]:
    columns = person_titles(options)
    for stage, lessons in stages.items():
        columns += [*lessons, *(f"{stage}: {title}" for title in STAGE_TITLES)]
    return [*columns, "Total", "Out of", *["Passed"] * (rules.pass_mark is not None)]


def _maximum_row(
    options: ExportOptions, stages: dict[str, dict[str, float]], rules: TermRules
) -> list[str]:
    cells = ["out of", *[""] * (len(person_titles(options)) - 1)]
    for lessons in stages.values():
        cells += [*map(format_points, lessons.values()), *[""] * len(STAGE_TITLES)]
    total = format_points(sum(sum(lessons.values()) for lessons in stages.values()))
    return [*cells, total, total, *[""] * (rules.pass_mark is not None)]


def _row(
    options: ExportOptions,
    person: Person,
    own_results: Sequence[NotebookResult],
    stages: dict[str, dict[str, float]],
    rules: TermRules,
) -> list[str]:
    cells = person_cells(person)
    for stage in stages:
        in_stage = [result for result in own_results if result.stage == stage]
        cells += [_score_cell(result) for result in in_stage]
        cells += _stage_cells(options.results.stage(person.id, stage), in_stage)
    term = term_result(own_results, rules)
    has_mark = term.points is not None  # missing work is not a 0
    cells += [format_points(term.points), format_points(term.max_score)] if has_mark else ["", ""]
    return cells + [_passed(term)] * (rules.pass_mark is not None)


def _passed(term: TermResult) -> str:
    if not term.max_score:
        return ""
    return WAITING if term.passed is None else "yes" if term.passed else "no"


def _score_cell(result: NotebookResult) -> str:
    if not result.counts or result.score is None:
        return ""
    return format_points(result.score)


def _stage_cells(stage: StageResult, lessons: Sequence[NotebookResult]) -> list[str]:
    submitted_at = stage.submitted_at.astimezone(UTC) if stage.submitted_at else None
    return [
        submitted_at.strftime("%Y-%m-%d %H:%M:%S UTC") if submitted_at else "",
        _days_late(stage),
        format_points(sum(result.penalty for result in lessons if result.counts)),
        _describe_status(lessons),
    ]


def _days_late(stage: StageResult) -> str:
    if stage.undecided:
        return "unknown"
    if stage.due is None or stage.submitted_at is None:
        return ""
    return format_points(stage.late / timedelta(days=1))


def _describe_status(lessons: Sequence[NotebookResult]) -> str:
    """Return the status in a stage or lesson, followed by the lessons that differ."""
    combined = combined_status(lessons)
    texts = [] if combined == WAITING else [combined]
    if combined in (MARKED, WAITING):
        for status in (WAITING, MISSING):
            names = [result.lesson for result in lessons if result.status == status]
            texts += [f"{status}: {', '.join(names)}"] if names else []
    return "; ".join(texts)
