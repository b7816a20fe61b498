"""Grade a class: judge its notebooks, enter the marks into the gradebook and write the report."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from grader import console
from grader.classroom.executors import executor_factory
from grader.classroom.folders import misspelt_folders
from grader.classroom.grade import JudgedSubmissions, judge_class
from grader.classroom.lock import course_lock
from grader.classroom.protocol import ExecutorLost
from grader.classroom.rehearsals import RehearsalFailed
from grader.classroom.submissions import find_submissions, unaccounted_files
from grader.course.deadlines_file import read_deadlines
from grader.course.lessons import stages
from grader.course.paths import Course
from grader.course.roster import read_roster
from grader.errors import FAULT, SUCCESS, USAGE_ERROR
from grader.judging.verdict import read_verdict
from grader.lms.gradebook import gradebook_location
from grader.lms.gradebook_writer import GradebookError, enter_verdicts
from grader.lms.instructor_notes import counted_lesson_notes, notes
from grader.lms.mark_history import read_changes
from grader.lms.report import GradingRun, write_report
from grader.lms.results_reader import class_results
from grader.lms.term import describe_term, term_result
from grader.sandbox import Sandbox

if TYPE_CHECKING:
    from pathlib import Path

    from grader.lms.results import ClassResults


def grade_course(
    course: Course,
    requested_stages: Sequence[str],
    seed: int,
    sandbox: Sandbox,
    workers: int,
    warning: str = "",
    scheduler: str | None = None,
    student: str | None = None,
    restore: bool = False,
) -> int:
    """Judge a class, enter the marks and write the report.

    Parameters
    ----------
    course : grader.course.paths.Course
    requested_stages : sequence of str
        The stages to grade. An empty sequence selects all.
    seed : int
    sandbox : grader.sandbox.Sandbox
    workers : int
        Number of processes that judge notebooks on this machine.
    warning : str, optional
        Warning in the report, instead of the one of `sandbox`.
    scheduler : str, optional
        Address of the cluster that judges the notebooks, instead of this machine.
    student : str, optional
        ID of the only student to grade.
    restore : bool, optional
        Whether to enter graders' marks that are missing from the gradebook.

    Returns
    -------
    int
        The exit status of the command.

    Raises
    ------
    grader.classroom.lock.AlreadyRunning
    """
    with course_lock(course):
        start_time = time.perf_counter()
        try:
            judged, stored_count = _judge_all(
                course, requested_stages, seed, sandbox, workers, scheduler, student
            )
        except (RehearsalFailed, ExecutorLost) as error:
            print(console.printable_lines(error), file=sys.stderr)
            return FAULT
        seconds = time.perf_counter() - start_time
        if not judged:
            print(
                f"There is no notebook in {course.submitted}/{student or '<student>'}/<stage>/. "
                "Run: python -m grader collect ARCHIVE --stage STAGE",
                file=sys.stderr,
            )
            return USAGE_ERROR
        status = _enter_marks(course, judged, requested_stages or stages(), student, restore)
        unjudged_files = unaccounted_files(course)
        # If the user named a student or a stage, `judged` contains only a part of the class.
        reported = read_verdicts(course) if student or requested_stages else judged
        results, now = class_results(course), len(judged) - stored_count
        label = "" if scheduler else sandbox.label()
        run = GradingRun(now, len(reported) - now, seconds, label)
        path = write_report(
            course, reported, results, run, warning or sandbox.warning, unjudged_files
        )
        if student:
            _print_student(course, student, judged, results)
        else:
            _print_class(course, judged, results, unjudged_files)
        _print_summary(course, len(judged), stored_count, seconds, label)
        print(f"Report: {path}")
        return status


def _judge_all(
    course: Course,
    requested_stages: Sequence[str],
    seed: int,
    sandbox: Sandbox,
    workers: int,
    scheduler: str | None,
    student: str | None,
) -> tuple[JudgedSubmissions, int]:
    """Return the submissions with their verdicts, and how many verdicts were already stored."""
    finished_counts = []
    with (
        executor_factory(scheduler, sandbox.name, console.print_notice) as open_executor,
        console.progress_bar("Judging") as advance,
    ):

        def record_progress(done: int, total: int, item: object) -> None:
            finished_counts.append(done)
            advance(done, total, item)

        judged = judge_class(
            course,
            requested_stages,
            seed,
            sandbox,
            open_executor,
            workers,
            record_progress,
            student,
        )
    # `judge_class` first reports how many verdicts were stored.
    return judged, finished_counts[0]


def read_verdicts(course: Course) -> JudgedSubmissions:
    """Return all submissions that have a verdict, each with its verdict."""
    submissions = find_submissions(course)
    verdicts = [
        (submission, read_verdict(submission.verdict_path(course))) for submission in submissions
    ]
    return [(submission, verdict) for submission, verdict in verdicts if verdict]


def _enter_marks(
    course: Course,
    judged: JudgedSubmissions,
    requested_stages: Sequence[str],
    student: str | None,
    restore: bool,
) -> int:
    """Enter verdicts into the gradebook and return the exit status."""
    with console.progress_bar("Entering marks into the gradebook") as advance:
        try:
            enter_verdicts(
                course, judged, requested_stages, advance, student, restore, console.print_notice
            )
        except GradebookError as error:
            print(console.printable_lines(error), file=sys.stderr)
            return FAULT
    return SUCCESS


def _print_class(
    course: Course,
    judged: JudgedSubmissions,
    results: ClassResults,
    unjudged_files: Sequence[tuple[Path, str]],
) -> None:
    """Print the results of the class, and everything that needs attention."""
    roster = read_roster(course)
    console.print_class(judged, results)
    for sentence in counted_lesson_notes(results).values():
        print(sentence)
    console.print_unaccounted(unjudged_files)
    respelt = misspelt_folders(course, roster) if roster else ()
    console.print_notes([*respelt, *notes(course, results, read_deadlines(course))])


def _print_student(
    course: Course, student: str, judged: JudgedSubmissions, results: ClassResults
) -> None:
    """Print a student's verdicts, results of the term, and history of marks."""
    for _, verdict in judged:
        console.print_verdict(verdict, results.rules.excluded_exercises)
    if notebooks := results.of_student(student):
        total = term_result(notebooks, results.rules)
        console.print_term(notebooks, describe_term(total, results.rules))
    lessons = {submission.lesson.name for submission, _ in judged}
    console.print_history(
        [
            change
            for change in read_changes(course)
            if change.student == student and change.lesson in lessons
        ]
    )


def _print_summary(
    course: Course, count: int, stored_count: int, seconds: float, label: str
) -> None:
    print(
        f"{count} notebook{'s' * (count != 1)}: {count - stored_count} judged in {seconds:.1f} s"
        f"{f', {stored_count} unchanged' if stored_count else ''}. "
        f"Gradebook: {gradebook_location(course)}"
        f"{f'. Sandbox: {label}' if label else ''}"
    )
