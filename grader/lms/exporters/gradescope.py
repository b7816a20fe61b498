"""Build an autograder for Gradescope that delivers stored marks instead of judging.

Gradescope accepts marks for programming assignments only from an autograder. This autograder
contains the marks by e-mail address, and does not run student code. It writes `results.json` for a
submission only if that submission is the one that was judged.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from grader.classroom.submissions import ReplacedSubmission, Submission, find_submissions
from grader.course.archives import make_zip
from grader.judging.verdict import ExerciseResult, Verdict, read_verdict
from grader.lms.exporters import inside_gradescope
from grader.lms.exporters.assignment_marks import Mark, collect_marks
from grader.lms.exporters.inside_gradescope import digest, files_of
from grader.lms.exporters.protocol import ExportError, ExportOptions, ExportResult
from grader.lms.results import MISSING, ClassResults, NotebookResult, format_points

SETUP = "#!/bin/sh\napt-get update && apt-get install -y python3\n"
EXECUTABLES = ("setup.sh", "run_autograder")


def export_gradescope(options: ExportOptions) -> ExportResult:
    """Build an autograder that can be uploaded to Gradescope unchanged.

    Returns
    -------
    ExportResult
        A zip archive.

    Raises
    ------
    ExportError
        If the marks cannot be exported; see `collect_marks`.
    """
    if options.other_people:
        raise ExportError(
            "Gradescope uses one autograder for all students in an assignment. Leave out --section."
        )
    marks = collect_marks(options)
    submitted: dict[str, list[Submission]] = {}
    for submission in find_submissions(options.course):
        if options.assignment in (submission.lesson.stage, submission.lesson.name):
            submitted.setdefault(submission.student, []).append(submission)
    entries, failures = {}, list(marks.failures)
    sharing = Counter(_email(mark) for mark in marks.marks)
    for mark in marks.marks:
        email = _email(mark)
        try:
            if not email:
                raise _MarkNotDelivered(
                    "Gradescope identifies students by e-mail, but the roster has no address for "
                    "this student."
                )
            if sharing[email] > 1:
                raise _MarkNotDelivered(
                    f"Gradescope identifies students by e-mail, but {email} also belongs to "
                    "another student."
                )
            entries[email] = _entry(options, mark, submitted.get(mark.person.id, ()))
        except _MarkNotDelivered as error:
            failures.append(
                f"{mark.person.display_name}, {format_points(mark.points)} "
                f"point{'s' * (mark.points != 1)}: {error}"
            )
    files = {
        "setup.sh": SETUP,
        "run_autograder": Path(inside_gradescope.__file__).read_text("utf-8"),
        "marks.json": json.dumps(entries, indent=1, sort_keys=True),
    }
    content = make_zip({name: text.encode() for name, text in files.items()}, EXECUTABLES)
    return ExportResult(content, len(entries), tuple(failures), marks.notes)


class _MarkNotDelivered(Exception):
    """A mark cannot be delivered; the message is the reason."""


def _email(mark: Mark) -> str:
    """Return the address by which Gradescope identifies a student; empty if unknown."""
    return mark.person.email.strip().casefold()


def _entry(options: ExportOptions, mark: Mark, submissions: Sequence[Submission]) -> dict:
    """Build one student's results, with digests that identify the judged submission."""
    course = options.course
    if not submissions:
        raise _MarkNotDelivered("the submission is no longer in submitted/.")
    judged_files, reports = [], {}
    for submission in submissions:
        verdict = read_verdict(submission.verdict_path(course))
        if verdict is None:
            raise _MarkNotDelivered("there is no verdict yet. Run `python -m grader grade`.")
        try:
            submission.read_again(course, verdict.fingerprint)
        except ReplacedSubmission as error:
            raise _MarkNotDelivered(str(error)) from error
        judged_files.append(digest(submission.path))
        reports[submission.lesson.name] = verdict
    folders = {submission.stage_folder(course) for submission in submissions}
    all_files = [digest(path) for folder in folders for path in files_of(folder)]
    results = [
        result
        for result in options.results.notebooks
        if result.student == mark.person.id and options.assignment in (result.stage, result.lesson)
    ]
    return {
        "judged": sorted(judged_files),
        "known": sorted(all_files),
        "results": {
            "score": round(mark.points, 2),
            "output": _summary(results),
            "visibility": "visible",
            "tests": [
                _lesson_test(options.results, result, reports.get(result.lesson))
                for result in results
            ],
        },
    }


def _summary(results: Sequence[NotebookResult]) -> str:
    lines = [
        f"{row.lesson}: {format_points(row.score or 0.0)} of {format_points(row.max_score)} points"
        for row in results
    ]
    penalty = sum(row.penalty for row in results)
    if penalty:
        lines.append(f"Points subtracted for lateness: {format_points(penalty)}")
    return "\n".join(lines)


def _lesson_test(results: ClassResults, result: NotebookResult, verdict: Verdict | None) -> dict:
    """Build the entry for a lesson in Gradescope's list of tests."""
    return {
        "name": result.lesson,
        "score": round(result.score or 0.0, 2),
        "max_score": result.max_score,
        "output": "Nothing was submitted."
        if result.status == MISSING
        else _lesson_output(results, result, verdict),
        "visibility": "visible",
    }


def _lesson_output(results: ClassResults, result: NotebookResult, verdict: Verdict | None) -> str:
    if verdict is None:
        return ""
    lines = [*verdict.problems]
    for exercise in verdict.exercises:
        if exercise.name not in results.rules.excluded_exercises:
            lines += _exercise_lines(exercise)
    by_hand = (result.score or 0.0) - results.judged_points(verdict)
    if abs(by_hand) >= 0.005:
        lines.append(f"Points given by a grader: {by_hand:+.4g}")
    return "\n".join(lines)


def _exercise_lines(exercise: ExerciseResult) -> list[str]:
    """Return the points of an exercise and its failed checks, with the first message in full."""
    head = f"{exercise.name}: {exercise.score:.4g} of {exercise.max_score:.4g} points"
    failed = [test for test in exercise.tests if not test.passed]
    lines = [head, *(f"  FAILED  {test.title}" for test in failed)]
    if failed:
        lines[2:2] = [f"          {line}" for line in failed[0].message.splitlines()]
    return [*lines, *([f"  {exercise.slip.sentence}"] if exercise.slip else [])]
