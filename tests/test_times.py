"""Ambiguous times are not read, and days after a due date are counted in local time."""

import random
import time
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

import pytest

from grader.classroom.collect.models import CollectError
from grader.classroom.collect.submission_table import read_submission_table
from grader.classroom.timestamp_file import read_timestamp
from grader.course.times import UnclearTime, compute_lateness, read_time, to_utc

BERLIN = ZoneInfo("Europe/Berlin")


@pytest.mark.parametrize(
    ("text", "utc"),
    [
        ("2026-10-12 23:59:00.123456 UTC", "2026-10-12T23:59:00.123456"),  # nbgrader's own form
        ("2026-10-12T23:59:07Z", "2026-10-12T23:59:07"),
        ("2026-10-12 23:59 +0200", "2026-10-12T21:59:00"),
        ("2026-10-12 23:59:07-03", "2026-10-13T02:59:07"),
        ("2026-12-12 23:59 Europe/Berlin", "2026-12-12T22:59:00"),
        ("2026-10-12 11:59 PM Europe/Berlin", "2026-10-12T21:59:00"),
        ("Mon, 12 Oct 2026 23:59:07 +0200", "2026-10-12T21:59:07"),
    ],
)
def test_a_time_with_a_zone_is_converted_to_utc(text, utc):
    assert read_time(text) == datetime.fromisoformat(utc).replace(tzinfo=UTC)


@pytest.mark.parametrize(
    ("text", "language", "expected"),
    [
        ("2026-10-14 2:05", "en", (2, 5)),
        ("2026-10-14 11:59 PM", "en", (23, 59)),
        ("Wednesday, 14 October 2026, 2:14\u202fPM", "en", (14, 14)),  # a narrow space
        ("Wednesday, October 14, 2026, 12:05 AM", "en", (0, 5)),
        ("Mittwoch, 14. Oktober 2026, 14:14", "de", (14, 14)),
        ("14. Oktober 2026, 14.14 Uhr", "de", (14, 14)),
        ("14 de octubre de 2026, 2:14 p. m.", "es", (14, 14)),
        ("quarta, 14 de outubro de 2026 às 14:14", "pt", (14, 14)),
        ("mercredi 14 octobre 2026, 14h14", "fr", (14, 14)),
        ("środa, 14 października 2026, 14:14", "pl", (14, 14)),
        ("среда, 14 октября 2026, 14:14", "ru", (14, 14)),
        ("2026年10月14日 星期三 14:14", "zh", (14, 14)),
    ],
)
def test_a_time_without_a_zone_stays_without_one(text, language, expected):
    assert read_time(text, language) == datetime(2026, 10, 14, *expected)


@pytest.mark.parametrize(
    "text",
    [
        *("12.10.2026 12:00", "12/10/2026 23:59", "10/12/2026 11:59 PM", "10-12-2026 23:59"),
        *("2026-10-12", "23:59", "2026-10-12 14:05 AM", "14:05 12 October 2026 2027", "yesterday"),
        *("2026-02-30 10:00", "2026-10-12 25:00", "9999-12-31 23:59", "0001-01-01 00:00"),
        *("14 Oktobre 2026, 3:00", "2026-10-12 23:59 or so", "2026-10-12 23:59 -99:99"),
        *("1 May or 2 May 2026, 3:00", "2026-10-12 23:59:00 Europe", "2026-10-12 23:59 ../UTC"),
    ],
)
def test_a_text_without_a_single_meaning_is_quoted(text):
    with pytest.raises(UnclearTime) as reason:
        read_time(text)
    assert str(reason.value).startswith(f"has {text!r}, ")


def test_a_long_text_with_control_characters_is_quoted_in_one_short_line():
    with pytest.raises(UnclearTime) as reason:
        read_time("2026-10-12 23:59\x1b[2J\n" + "1:00 " * 10**6)
    assert str(reason.value).isprintable() and len(str(reason.value)) < 200


@pytest.mark.skipif(not hasattr(time, "tzset"), reason="setting the machine's time zone")
def test_abbreviations_of_the_machines_zone_are_known(monkeypatch):
    """nbgrader uses the tz database's zone CET, which has summer time."""
    monkeypatch.setenv("TZ", "Europe/Berlin")
    time.tzset()
    try:
        assert read_time("2026-10-12 23:59 CEST") == datetime(2026, 10, 12, 21, 59, tzinfo=UTC)
        assert read_time("2026-10-12 23:59 CET") == datetime(2026, 10, 12, 21, 59, tzinfo=UTC)
        assert read_time("2026-12-12 23:59 CET") == datetime(2026, 12, 12, 22, 59, tzinfo=UTC)
    finally:
        monkeypatch.undo()
        time.tzset()


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be with a mark"])
def test_files_from_windows_editors_are_read(tmp_path, encoding):
    def encode(text):
        marked = encoding.endswith("mark")
        return f"\ufeff{text}".encode("utf-16-be") if marked else text.encode(encoding)

    (tmp_path / "timestamp.txt").write_bytes(encode("2026-10-12 23:59:00 +02:00\r\n"))
    assert read_timestamp(tmp_path).when == datetime(2026, 10, 12, 21, 59, tzinfo=UTC)
    table = tmp_path / "times.csv"
    table.write_bytes(encode("id,Last modified (submission)\r\nbjörn,2026-10-12 23:59\r\n"))
    (row,) = read_submission_table(table, BERLIN).rows
    assert row.identifiers == ("björn",)
    assert row.when == datetime(2026, 10, 12, 21, 59, tzinfo=UTC)


def test_a_table_in_an_unknown_encoding_is_refused(tmp_path):
    (tmp_path / "times.csv").write_bytes("id,name\nx,Björn\n".encode("cp1252"))
    with pytest.raises(CollectError, match="Save it as CSV UTF-8"):
        read_submission_table(tmp_path / "times.csv", BERLIN)


# ---- days late ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("due", "submitted", "days"),
    [  # Berlin's clocks go back on 25 October 2026, and forward on 28 March 2027
        ("2026-10-24 20:00", "2026-10-25 19:30", 1),  # 24.5 hours
        ("2026-10-24 20:00", "2026-10-25 20:00", 1),
        ("2026-10-24 20:00", "2026-10-25 20:01", 2),
        ("2027-03-27 20:00", "2027-03-28 20:00", 1),
        ("2027-03-27 20:00", "2027-03-28 20:30", 2),  # 23.5 hours
        ("2026-10-23 20:00", "2026-10-26 20:00", 3),
        ("2027-03-26 20:00", "2027-03-29 20:01", 4),
    ],
)
def test_days_late_are_days_of_local_time(due, submitted, days):
    due, submitted = (to_utc(datetime.fromisoformat(text), BERLIN) for text in (due, submitted))
    assert -(compute_lateness(submitted, due, BERLIN) // -timedelta(1)) == days


@pytest.mark.parametrize("zone", [BERLIN, ZoneInfo("Australia/Lord_Howe"), UTC, None])
def test_days_late_agree_with_a_calendar(zone):
    """Lord Howe Island changes its clocks by half an hour."""
    rng = random.Random(3)
    for _ in range(400):
        minute = timedelta(minutes=rng.randrange(366 * 1440))
        due = to_utc((datetime(2026, 3, 1, 0, 0, 30) + minute).replace(tzinfo=zone), zone)
        submitted = due + timedelta(minutes=rng.randrange(1, 5000))
        late = compute_lateness(submitted, due, zone)
        # Walk from one day to the next, until the clock has passed the submission.
        local, expected = due.astimezone(zone), 1
        end = local.replace(tzinfo=None) + timedelta(1)
        while to_utc(end, zone) < submitted:
            end, expected = end + timedelta(1), expected + 1
        assert -(late // -timedelta(1)) == expected
        assert abs(late - (submitted - due)) <= timedelta(hours=1)


def test_minutes_after_the_due_date_are_minutes_even_if_the_clocks_change():
    """Otherwise, a grace period of 15 minutes could last an hour or end at once."""
    for due in (datetime(2027, 3, 28, 1, 59), datetime(2026, 10, 25, 2, 59)):
        for fold in (0, 1):
            start = to_utc(due.replace(fold=fold), BERLIN)
            late = compute_lateness(start + timedelta(minutes=10), start, BERLIN)
            assert late == timedelta(minutes=10)


def test_work_on_time_is_not_late():
    due = datetime(2026, 10, 24, 18, tzinfo=UTC)
    assert (
        compute_lateness(due, due, BERLIN)
        == compute_lateness(due - timedelta(1), due, None)
        == timedelta()
    )
