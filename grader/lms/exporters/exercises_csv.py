"""Marks by exercise as a CSV file with one row per student and one column per exercise."""

from __future__ import annotations

import csv
import io

from grader.lms.exporters.assignment_marks import provisional_notes
from grader.lms.exporters.protocol import ExportOptions, ExportResult
from grader.lms.exporters.scores_csv import notebooks_of, person_cells, person_titles
from grader.lms.instructor_notes import (
    excessive_mark_notes,
    outdated_mark_notes,
    unlisted_student_notes,
)
from grader.lms.results import NotebookResult, format_points


def export_exercises_csv(options: ExportOptions) -> ExportResult:
    """Write the points in each exercise, limited to one stage or lesson if the options name one.

    Points are those of the judge or of a grader, before late penalties. A cell is empty if the
    lesson is missing or does not count for the student, or if the exercise waits for a grader.
    Exercises that are switched off have no column.
    """
    results: dict[tuple[str, str], NotebookResult] = {
        (result.student, result.lesson): result for result in notebooks_of(options)
    }
    lessons = {result.lesson: result.exercises for result in results.values()}
    exercises = [(lesson, mark) for lesson in sorted(lessons) for mark in lessons[lesson]]
    file = io.StringIO()
    table = csv.writer(file, lineterminator="\n")
    titles = person_titles(options)
    table.writerow([*titles, *(f"{lesson[:2]} {mark.name}" for lesson, mark in exercises)])
    maxima = [format_points(mark.max_score) for _, mark in exercises]
    table.writerow(["out of", *[""] * (len(titles) - 1), *maxima])
    mark_count = 0
    for person in options.results.people:
        points = [_points(results[person.id, lesson], mark.name) for lesson, mark in exercises]
        table.writerow([*person_cells(person), *points])
        mark_count += any(points)
    # Without a byte order mark, Excel shows umlauts as other characters.
    content = file.getvalue().encode("utf-8-sig", "replace")
    stages = dict.fromkeys(result.stage for result in results.values())
    notes = [note for stage in stages for note in outdated_mark_notes(options.results, stage)]
    notes += excessive_mark_notes(options.results)
    notes += filter(None, provisional_notes(list(results.values())))
    return ExportResult(
        content, mark_count, tuple(unlisted_student_notes(options.results)), tuple(notes)
    )


def _points(result: NotebookResult, exercise: str) -> str:
    points = {mark.name: mark.points for mark in result.exercises}[exercise]
    return format_points(points) if result.counts and points is not None else ""
