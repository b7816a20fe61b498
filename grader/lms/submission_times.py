"""Read submission times from nbgrader's ``timestamp.txt`` next to the submitted files."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path

from grader.classroom.collect.record import file_time, unknown_time_reason
from grader.classroom.submissions import Submission
from grader.classroom.timestamp_file import read_timestamp
from grader.course.deadlines import Deadlines
from grader.course.times import UnclearTime


class SubmissionTimeUnknown(Exception):
    """The submission time is unknown; the message is the reason."""


def submission_time(folders: Iterable[Path]) -> datetime | None:
    """Return the time when a student's work for a stage was submitted.

    Parameters
    ----------
    folders : iterable of Path
        Folders that contain the work. The latest of their times counts.

    Returns
    -------
    datetime or None
        Time with a time zone; None if no folder has a time.

    Raises
    ------
    SubmissionTimeUnknown
        If the time of any folder cannot be read, or if the collected work is marked late or has no
        time in the table of times.
    """
    times = [_time(folder) for folder in sorted(folders)]
    return max((time for time in times if time), default=None)


def naive_submission_time(folders: Iterable[Path]) -> datetime | None:
    """Return the submission time in UTC without a zone, as nbgrader stores it; None if unknown."""
    try:
        time = submission_time(folders)
    except SubmissionTimeUnknown:
        return None
    return time and time.replace(tzinfo=None)


def lesson_times(submissions: Iterable[Submission], deadlines: Deadlines) -> dict[str, datetime]:
    """Return when each lesson of a student's stage was submitted, by lesson.

    Lessons are timed separately only if a lesson of their stage has its own due date. Otherwise, or
    if only the time of the whole stage is known, a lesson is missing from the result.
    """
    times = {
        submission.lesson.name: file_time(submission.path)
        for submission in submissions
        if deadlines.lessons_with_dates(submission.lesson.stage)
    }
    return {lesson: time for lesson, time in times.items() if time}


def lacks_zone(folders: Iterable[Path]) -> bool:
    """Return whether a time has no time zone and is therefore read as UTC."""
    for folder in folders:
        with contextlib.suppress(UnclearTime):
            timestamp = read_timestamp(folder)
            if timestamp and not timestamp.has_zone:
                return True
    return False


def _time(folder: Path) -> datetime | None:
    try:
        timestamp = read_timestamp(folder)
    except UnclearTime as reason:
        raise SubmissionTimeUnknown(str(reason)) from None
    if timestamp:
        return timestamp.when
    if reason := unknown_time_reason(folder):
        raise SubmissionTimeUnknown(reason)
    return None
