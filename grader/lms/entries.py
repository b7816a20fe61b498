"""What is to be entered: of each student a stage, all of it or nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.classroom.submissions import Submission
from grader.course.paths import Course
from grader.judging.verdict import JUDGED, Verdict


@dataclass(frozen=True)
class StageEntry:
    """What a student handed in for a stage, with its verdicts."""

    student: str
    stage: str
    judged: tuple[tuple[Submission, Verdict], ...]

    @property
    def name(self) -> str:
        """What sentences call it."""
        return f"{self.student}, {self.stage}"

    def places(self, course: Course) -> tuple[Path, ...]:
        """The folders in which it lies; more than one where the student's is spelt in two ways."""
        found = {submission.place(course) for submission, _ in self.judged}
        return tuple(sorted(found))


def entries_of(
    course: Course, judged: Sequence[tuple[Submission, Verdict]], unknown: Mapping[str, str]
) -> tuple[list[StageEntry], list[str]]:
    """(what can be entered, a sentence on each that cannot); `unknown` has those on strangers."""
    groups: dict[tuple[str, str], list] = {}
    for submission, verdict in judged:
        groups.setdefault((submission.student, submission.lesson.stage), []).append(
            (submission, verdict)
        )
    entries, trouble = [], []
    for (student, stage), pairs in groups.items():
        if student in unknown:
            trouble.append(unknown[student])
            continue
        failed = [pair for pair in pairs if pair[1].status != JUDGED]
        trouble += [
            f"{student}, {stage}: not entered, because the judge failed on "
            f"{submission.lesson.name}; see {submission.verdict_path(course)}"
            for submission, _ in failed
        ]
        if not failed:  # no mark is better than a wrong one
            entries.append(StageEntry(student, stage, tuple(pairs)))
    return entries, trouble
