"""Compare the gradebook and the autograded copies with the verdicts."""

from __future__ import annotations

from nbgrader.api import Gradebook, MissingEntry
from nbgrader.preprocessors import AssignLatePenalties

from grader.course.deadlines import Deadlines
from grader.course.paths import Course
from grader.judging.verdict import Verdict
from grader.lms.autograded_copy import verdict_key_of_copy
from grader.lms.gradebook_dates import extension_of
from grader.lms.penalties import penalty_of
from grader.lms.stage_entries import StageEntry
from grader.lms.submission_times import naive_submission_time

TOLERANCE = 1e-6  # points are written with two decimal places


def differences(
    course: Course,
    book: Gradebook,
    entry: StageEntry,
    late_penalties: AssignLatePenalties,
    deadlines: Deadlines,
) -> list[str]:
    """List how the gradebook and the autograded copies differ from the verdicts.

    Returns
    -------
    list of str
        One sentence per difference; empty if everything matches.
    """
    try:
        submission = book.find_submission(entry.stage, entry.student)
    except MissingEntry:
        return [f"{entry.name}: not in the gradebook"]
    sentences = []
    if submission.timestamp != naive_submission_time(entry.folders(course)):
        sentences.append(f"{entry.name}: the gradebook has a different submission time")
    if submission.extension != extension_of(course, submission, deadlines):
        sentences.append(f"{entry.name}: the gradebook has a different extension")
    times = entry.lesson_times(deadlines)
    verdicts = {verdict.lesson: verdict for _, verdict in entry.judged}
    for notebook in submission.notebooks:
        label = f"{entry.name}, {notebook.name}"
        verdict = verdicts.get(notebook.name)
        expected_scores = _scores(verdict)
        for grade in notebook.grades:
            score, max_score = expected_scores.get(grade.name, (None if verdict else 0.0, None))
            is_judged = verdict is None or grade.name in expected_scores
            # Rows for new exercises have no score, and wait for a person until they are entered.
            if is_judged and (grade.auto_score is None or not _is_close(grade.auto_score, score)):
                sentences.append(
                    f"{label}: {grade.name} has {grade.auto_score} points instead of {score}"
                )
            if max_score is not None and not _is_close(grade.max_score, max_score):
                sentences.append(
                    f"{label}: {grade.name} is worth {grade.max_score} points, not {max_score}"
                )
        penalty = penalty_of(submission, notebook, late_penalties, deadlines, times)
        if not _is_close(notebook.late_submission_penalty, penalty):
            sentences.append(f"{label}: the gradebook has a different late penalty")
        if (
            verdict
            and verdict_key_of_copy(course, entry.student, entry.stage, notebook.name)
            != verdict.key
        ):
            sentences.append(f"{label}: the autograded copy belongs to another verdict")
    missing = set(verdicts) - {notebook.name for notebook in submission.notebooks}
    return sentences + [f"{entry.name}, {name}: not in the gradebook" for name in sorted(missing)]


def _scores(verdict: Verdict | None) -> dict[str, tuple[float, float]]:
    """Return (score, maximum score) by nbgrader's name for the graded cell."""
    return {
        f"test_{exercise.name}": (exercise.score, exercise.max_score)
        for exercise in (verdict.exercises if verdict else ())
    }


def _is_close(first: float | None, second: float | None) -> bool:
    return abs((first or 0.0) - (second or 0.0)) < TOLERANCE
