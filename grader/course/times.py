"""Read times that programs and people wrote, and compute how late work is.

A time that could mean two days is never guessed. Dates in figures are read only in the order of
ISO 8601, as in ``2026-10-12 23:59``, which is also the form of nbgrader. In all other dates the
month must be a word, as in Moodle's worksheets.
"""

from __future__ import annotations

import functools
import re
import time
import unicodedata
from datetime import UTC, datetime, timedelta, timezone, tzinfo
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import babel

from grader.untrusted_text import one_line

MAX_TEXT_LENGTH = 80
# In these years, adding a day or a time zone's offset cannot exceed the range of `datetime`.
YEARS = range(2000, 3000)
_CLOCK = r"(?P<hour>\d{1,2}) ?[:.h] ?(?P<minute>\d\d)(?:[:.](?P<second>\d\d)(?:\.(?P<part>\d+))?)?"
_HALF_OF_DAY = r"(?: ?(?:(?P<half>[ap])\.? ?m\b\.?|uhr\b))?"
_ZONE = r"(?: ?(?P<zone>[+-]\d\d(?::?[0-5]\d)?|[a-z][a-z0-9_+/-]*))?"
_TIME = re.compile(rf"(?P<date>.+?)[t,， ]*(?<!\d){_CLOCK}{_HALF_OF_DAY}{_ZONE}", re.IGNORECASE)
_ISO = re.compile(r"(\d{4})-(\d\d)-(\d\d)", re.ASCII)
_CHINESE = re.compile(r"(\d{4})年(\d{1,2})月(\d{1,2})日[,， ]*(?:星期\w)?")
_OFFSET = re.compile(r"([+-])(\d\d):?(\d\d)?")


class UnclearTime(Exception):
    """A text is not a time with a single meaning; the message continues a sentence about it."""


def read_time(text: str, language: str = "en") -> datetime:
    """Return the time in a text.

    Parameters
    ----------
    text : str
    language : str
        Language of the names of months.

    Returns
    -------
    datetime
        In UTC if the text states a time zone; otherwise without a zone.

    Raises
    ------
    UnclearTime
    """
    text = " ".join(unicodedata.normalize("NFC", text).split())
    match = _TIME.fullmatch(text) if len(text) <= MAX_TEXT_LENGTH else None
    date = _parse_date(match["date"], language) if match else None
    clock = _parse_clock(match) if match else None
    if date is None or clock is None or date[0] not in YEARS:
        raise UnclearTime(
            f"has {quote_beginning(text)}, which is not a time such as 2026-10-12 23:59"
        )
    zone = _find_zone(match["zone"]) if match["zone"] else None
    if match["zone"] and zone is None:
        raise UnclearTime(
            f"has {quote_beginning(text)}, whose time zone {quote_beginning(match['zone'])} is "
            "unknown on this "
            "machine"
        )
    try:
        stated = datetime(*date, *clock, tzinfo=zone)
    except ValueError:
        raise UnclearTime(f"has {quote_beginning(text)}, a time that does not exist") from None
    return stated.astimezone(UTC) if zone else stated


def quote_beginning(text: str) -> str:
    """Return the beginning of an untrusted text in quotation marks."""
    line = one_line(text)
    return repr(line if len(line) <= MAX_TEXT_LENGTH else f"{line[: MAX_TEXT_LENGTH - 1]}…")


def to_utc(when: datetime, zone: tzinfo | None) -> datetime:
    """Convert a time to UTC; a time without a zone is in `zone`, or in this machine's if None."""
    return when.replace(tzinfo=when.tzinfo or zone).astimezone(UTC)


def compute_lateness(submitted_at: datetime, due: datetime, zone: tzinfo | None) -> timedelta:
    """Return how late work is; each day counts as 24 hours, even if the clocks change.

    A day ends when the clock shows the time of the due date. If the clocks go back, 25 hours pass
    between 20:00 and 20:00 on the next day. Students count one day, so they are penalised for one.

    Parameters
    ----------
    submitted_at, due : datetime
        With time zones.
    zone : tzinfo or None
        Zone of the clock; None for this machine's.
    """
    if submitted_at <= due:
        return timedelta()
    clock = due.astimezone(zone).replace(tzinfo=None)
    days = (submitted_at - due).days + 1  # at most, because a day may have 23 hours
    while days and to_utc(clock + timedelta(days), zone) > submitted_at:
        days -= 1
    last_day_start = to_utc(clock + timedelta(days), zone) if days else due
    return timedelta(days) + min(submitted_at - last_day_start, timedelta(1))


def _parse_date(text: str, language: str) -> tuple[int, int, int] | None:
    """Return the year, month and day in a text without a clock time."""
    in_figures = _ISO.fullmatch(text) or _CHINESE.fullmatch(text)
    if in_figures:
        return tuple(map(int, in_figures.groups()))
    normalized_text = _fold_case(text)
    years = re.findall(r"(?<!\d)\d{4}(?!\d)", normalized_text)
    days = re.findall(r"(?<!\d)\d{1,2}(?!\d)", normalized_text)
    month = _find_month(normalized_text, language)
    if len(years) != 1 or len(days) != 1 or month is None:
        return None
    return int(years[0]), month, int(days[0])


def _parse_clock(match: re.Match) -> tuple[int, int, int, int] | None:
    """Return the hour, minute, second and microsecond, or None for a time such as "14:05 AM"."""
    hour = int(match["hour"])
    half = (match["half"] or "").lower()
    if half and hour <= 12:
        hour = hour % 12 + 12 * (half == "p")
    elif half == "a":
        return None
    microseconds = int((match["part"] or "0").ljust(6, "0")[:6])
    return hour, int(match["minute"]), int(match["second"] or 0), microseconds


def _find_zone(name: str) -> tzinfo | None:
    """Return the time zone with a name, or None if this machine does not know it.

    nbgrader's own reader treats unknown names as UTC, even names such as CEST, which nbgrader
    writes if `Exchange.timezone` is set. It reads +0200 as 200 seconds.
    """
    offset = _OFFSET.fullmatch(name)
    if offset:
        sign, hours, minutes = offset.groups()
        shift = timedelta(hours=int(hours), minutes=int(minutes or 0))
        return timezone(-shift if sign == "-" else shift) if shift < timedelta(days=1) else None
    if name.upper() in ("Z", "UTC"):
        return UTC
    try:
        return ZoneInfo(name)
    except (ZoneInfoNotFoundError, ValueError, OSError):
        if name not in time.tzname:
            return None
        is_standard = name == time.tzname[0]
        return timezone(timedelta(seconds=-(time.timezone if is_standard else time.altzone)))


def _find_month(text: str, language: str) -> int | None:
    words = set(re.findall(r"[^\W\d]+", text))
    months = {number for number, names in _month_names(language).items() if names & words}
    return months.pop() if len(months) == 1 else None


@functools.cache
def _month_names(language: str) -> dict[int, set[str]]:
    """Return the full and abbreviated names of each month in all forms, by month number."""
    names_by_month: dict[int, set[str]] = {number: set() for number in range(1, 13)}
    for use in babel.Locale(language).months.values():
        for width in ("wide", "abbreviated"):
            for number, name in use.get(width, {}).items():
                names_by_month[number].add(_fold_case(name).strip("."))
    return names_by_month


def _fold_case(text: str) -> str:
    return " ".join(unicodedata.normalize("NFC", text).casefold().split())
