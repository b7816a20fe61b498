"""Record what marks were computed from, so that exports can announce marks that are out of date.

Scores and penalties are entered by `grade`. If a submitted file, a submission time, a due date or
the points of an exercise changes afterwards, the gradebook keeps the old mark until the next run.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from pathlib import Path

from grader.classroom.submissions import Submission
from grader.course.atomic_files import write_atomically
from grader.course.deadlines import Deadlines
from grader.course.paths import Course
from grader.lms.stage_entries import StageEntry
from grader.lms.submission_times import lesson_times, naive_submission_time


def record_inputs(course: Course, entry: StageEntry, deadlines: Deadlines) -> None:
    """Record the inputs of a student's marks in a stage, after these marks were entered."""
    # A file may have been replaced since it was judged, so its fingerprint is not computed again.
    fingerprints = {submission: verdict.fingerprint for submission, verdict in entry.judged}
    path = _path(course, entry.student, entry.stage)
    write_atomically(_digest(course, fingerprints, deadlines), path)


def outdated_marks(
    course: Course, submissions: Iterable[Submission], deadlines: Deadlines
) -> Iterator[tuple[str, str]]:
    """Yield (student, stage) of marks whose inputs have changed since they were entered."""
    for key, group in groupby(sorted(submissions, key=_student_and_stage), _student_and_stage):
        path = _path(course, *key)
        if not path.is_file():
            continue  # these marks have not been entered yet
        fingerprints = {submission: submission.read(course).fingerprint() for submission in group}
        if path.read_text("utf-8") != _digest(course, fingerprints, deadlines):
            yield key


def _student_and_stage(submission: Submission) -> tuple[str, str]:
    return submission.student, submission.lesson.stage


def _digest(course: Course, fingerprints: Mapping[Submission, str], deadlines: Deadlines) -> str:
    """Return a digest of everything that changes a student's scores or penalties in a stage.

    `fingerprints` contains all submissions of the student to the stage.
    """
    student, stage = _student_and_stage(next(iter(fingerprints)))
    stage_due_date = deadlines.due_date(student, stage)
    lessons = {
        submission.lesson.name: (
            fingerprint,
            deadlines.lesson_due_date(student, stage, submission.lesson.name, stage_due_date),
            deadlines.rules.excluded_in(submission.lesson),
            [(exercise.name, exercise.points) for exercise in submission.lesson.exercises],
        )
        for submission, fingerprint in fingerprints.items()
    }
    time = naive_submission_time({submission.stage_folder(course) for submission in fingerprints})
    inputs = [lessons, stage_due_date, time, lesson_times(fingerprints, deadlines), deadlines.zone]
    text = json.dumps(inputs, sort_keys=True, default=str)
    return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()


def _path(course: Course, student: str, stage: str) -> Path:
    return course.verdicts / student / stage / ".inputs"
