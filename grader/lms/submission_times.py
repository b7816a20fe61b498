"""Read submission times from nbgrader's ``timestamp.txt`` next to the submitted files."""

from __future__ import annotations

import re
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from nbgrader.utils import gettz, parse_utc

from grader.classroom.collect.record import reason_without_time
from grader.intake.notebook import read_file
from utils.notebooks.reading import UnreadableNotebook


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
        If a folder's time cannot be read, or if the collected work is marked late or has no time in
        the table of times. The times of other folders make no difference.
    """
    times = [_time(folder) for folder in sorted(folders)]
    return max((time for time in times if time), default=None)


def known_time(folders: Iterable[Path]) -> datetime | None:
    """Return the submission time as nbgrader stores it: naive and in UTC. None if it is unknown."""
    try:
        time = submission_time(folders)
    except SubmissionTimeUnknown:
        return None
    return time and time.replace(tzinfo=None)


def _time(folder: Path) -> datetime | None:
    path = folder / "timestamp.txt"
    if not path.is_file():
        if reason := reason_without_time(folder):
            raise SubmissionTimeUnknown(reason)
        return None
    try:
        text = read_file(path).decode().strip()
        if not text:  # nbgrader leaves an empty file if the disk is full
            raise SubmissionTimeUnknown("timestamp.txt is empty")
        return parse_utc(_with_known_zone(text)).replace(tzinfo=UTC)
    except (UnreadableNotebook, ValueError, OverflowError, TypeError) as error:
        raise SubmissionTimeUnknown("timestamp.txt does not contain a valid time") from error


def _with_known_zone(text: str) -> str:
    """Rewrite a time so that nbgrader reads its time zone correctly.

    nbgrader treats an unknown time zone as UTC, even one that it writes itself because of
    `Exchange.timezone`, such as CEST. It reads +0200 as 200 seconds.
    """
    match = re.fullmatch(r"(\d\S*) +(\d\S*) +(\S+)", text)
    if not match:
        return text
    date, clock, zone = match.groups()
    if re.fullmatch(r"[+-]\d\d:?\d\d", zone):
        return f"{date} {clock}{zone}"
    if gettz(zone) is None:
        raise SubmissionTimeUnknown(
            f"timestamp.txt contains a time zone that is unknown on this machine, {zone!r}"
        )
    return f"{date} {clock} {zone}"
