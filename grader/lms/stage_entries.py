"""Gradebook entries. Each covers one student's stage, and is entered completely or not at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from grader.classroom.pages import printable_name
from grader.classroom.submissions import Submission
from grader.course.deadlines import Deadlines
from grader.course.paths import Course
from grader.judging.judge import JUDGE_FAILED_NOTE
from grader.judging.verdict import JUDGED, Verdict
from grader.lms.submission_times import lesson_times


@dataclass(frozen=True)
class StageEntry:
    """A student's submission for a stage, with its verdicts."""

    student: str
    stage: str
    judged: tuple[tuple[Submission, Verdict], ...]

    @property
    def name(self) -> str:
        """Student and stage, for messages."""
        return f"{self.student}, {self.stage}"

    def lesson_times(self, deadlines: Deadlines) -> dict[str, datetime]:
        """Return when each lesson was submitted; see `grader.lms.submission_times.lesson_times`."""
        return lesson_times([submission for submission, _ in self.judged], deadlines)

    def folders(self, course: Course) -> tuple[Path, ...]:
        """Return the submission folders; several if the student's ID is spelt in several ways."""
        folders = {submission.stage_folder(course) for submission, _ in self.judged}
        return tuple(sorted(folders))


def group_entries(
    course: Course, judged: Sequence[tuple[Submission, Verdict]], unknown: Mapping[str, str]
) -> tuple[list[StageEntry], list[str]]:
    """Return the entries, and one sentence for each submission that cannot be entered.

    `unknown` contains such a sentence for each ID that is not on the roster.
    """
    groups: dict[tuple[str, str], list] = {}
    for submission, verdict in judged:
        groups.setdefault((submission.student, submission.lesson.stage), []).append(
            (submission, verdict)
        )
    entries, problems = [], []
    for (student, stage), pairs in groups.items():
        if student in unknown:
            problems.append(unknown[student])
            continue
        if student != printable_name(student):  # no database can store this ID
            problems.append(
                f"{printable_name(student)}, {stage}: not entered, because the name of the folder "
                "in submitted/ is not valid UTF-8. Rename the folder."
            )
            continue
        failed = [pair for pair in pairs if pair[1].status != JUDGED]
        problems += [
            f"{student}, {stage}: not entered, because {_reason(submission, verdict, course)}"
            for submission, verdict in failed
        ]
        if not failed:  # a missing mark is better than a wrong one
            entries.append(StageEntry(student, stage, tuple(pairs)))
    return entries, problems


def _reason(submission: Submission, verdict: Verdict, course: Course) -> str:
    name = submission.lesson.name
    if verdict.reason in ("", JUDGE_FAILED_NOTE):
        return f"the judge failed on {name}. For the reason, see {submission.verdict_path(course)}"
    return f"{name} was not judged. {verdict.reason}"
