"""The names that collected files had in an archive from an LMS."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from grader.classroom.collect.record import read_record
from grader.classroom.submissions import find_submissions
from grader.course.paths import Course

# `FileOrigin.archive` ends with the owner's name in the archive and the submitted file's name.
_OWNER_AND_FILE = re.compile(r": (?P<owner>[^/:]+)/(?P<file>[^/]+)(?:/.*)?$")


@dataclass(frozen=True)
class CollectedFile:
    """The data that identifies a submitted file in an LMS.

    Attributes
    ----------
    owner, file : str
    attachment : int
        Canvas attachment ID; 0 for other platforms.
    participant : str
        Moodle participant number; empty for other platforms.
    """

    owner: str
    file: str
    attachment: int
    participant: str


def collected_files(
    course: Course, stages: Iterable[str] = ()
) -> dict[str, dict[str, CollectedFile]]:
    """Return the data that identifies each judged file in an LMS, by student and lesson."""
    files: dict[str, dict[str, CollectedFile]] = {}
    for submission in find_submissions(course, stages):
        origin = read_record(submission.stage_folder(course)).files.get(submission.path.name)
        match = origin and _OWNER_AND_FILE.search(origin.archive)
        if match:
            file = CollectedFile(match["owner"], match["file"], origin.order, origin.participant)
            files.setdefault(submission.student, {})[submission.lesson.name] = file
    return files
