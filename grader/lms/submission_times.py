"""When work was handed in, as nbgrader's ``timestamp.txt`` beside it says."""

from __future__ import annotations

import re
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from nbgrader.utils import gettz, parse_utc

from grader.classroom.collect.record import why_untimed
from grader.intake.notebook import read_file
from utils.notebooks.reading import UnreadableNotebook


class Undecided(Exception):
    """Nobody knows when something was handed in; `str()` is the reason."""


def handed_in_at(places: Iterable[Path]) -> datetime | None:
    """When a student's work for a stage was handed in.

    Parameters
    ----------
    places : iterable of Path
        The folders in which it lies. Of several the latest time counts.

    Returns
    -------
    datetime or None
        Aware; None where no file says anything.

    Raises
    ------
    Undecided
        Work whose time cannot be read is neither late nor in time; nor is work that was collected
        late, or from a table that has no time for it. So it is with the work in one of several
        folders, whatever the others say.
    """
    times = [_time(place) for place in sorted(places)]
    return max((time for time in times if time), default=None)


def known_time(places: Iterable[Path]) -> datetime | None:
    """The same as nbgrader keeps it, in UTC without saying so; None also where it is undecided."""
    try:
        time = handed_in_at(places)
    except Undecided:
        return None
    return time and time.replace(tzinfo=None)


def _time(place: Path) -> datetime | None:
    path = place / "timestamp.txt"
    if not path.is_file():
        if reason := why_untimed(place):
            raise Undecided(reason)
        return None
    try:
        text = read_file(path).decode().strip()
        if not text:  # such as nbgrader leaves one on a disk that is full
            raise Undecided("timestamp.txt is empty")
        return parse_utc(_with_known_zone(text)).replace(tzinfo=UTC)
    except (UnreadableNotebook, ValueError, OverflowError, TypeError) as error:
        raise Undecided("timestamp.txt does not say a time that can be read") from error


def _with_known_zone(text: str) -> str:
    """A time whose zone nbgrader reads as it is meant.

    It takes one that the machine does not know, such as the CEST that `Exchange.timezone` makes it
    write, for UTC; and +0200 for as many seconds.
    """
    found = re.fullmatch(r"(\d\S*) +(\d\S*) +(\S+)", text)
    if not found:
        return text
    date, clock, zone = found.groups()
    if re.fullmatch(r"[+-]\d\d:?\d\d", zone):
        return f"{date} {clock}{zone}"
    if gettz(zone) is None:
        raise Undecided(f"timestamp.txt has a time zone that this machine does not know, {zone!r}")
    return f"{date} {clock} {zone}"
