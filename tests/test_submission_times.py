"""The submission time of a student with one or two folders, or why it is unknown."""

import os
from datetime import UTC, datetime

import pytest

from grader.classroom.collect.record import FileOrigin, Record, write_record
from grader.lms.submission_times import (
    SubmissionTimeUnknown,
    lacks_zone,
    naive_submission_time,
    submission_time,
)

LATE = Record({"06.ipynb": FileOrigin("0", "a.zip", "2026-10-14T12:00:00", late=True)})
OCTOBER = datetime(2026, 10, 1, 10, tzinfo=UTC)


@pytest.fixture
def folders(tmp_path):
    """Return two folders of a student whose ID is spelt in two ways, each with a notebook."""
    for name in ("ada", "Ada"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "06.ipynb").write_text("{}")
    return tmp_path / "ada", tmp_path / "Ada"


def write_time(folder, text):
    (folder / "timestamp.txt").write_text(text)


def test_the_later_of_two_times_counts(folders):
    assert submission_time(folders) is None
    write_time(folders[0], "2026-10-01 12:00:00 Europe/Berlin\n")
    assert submission_time(folders) == submission_time(folders[:1]) == OCTOBER
    write_time(folders[1], "2026-09-01 12:00:00 UTC")
    assert submission_time(folders) == OCTOBER


def test_late_work_without_a_time_is_undecided(folders):
    write_record(LATE, folders[0])
    write_time(folders[1], "2026-10-01 10:00:00 UTC")
    with pytest.raises(SubmissionTimeUnknown, match="marks the work as late, but gives no time"):
        submission_time(folders)
    write_time(folders[0], "2026-09-01 10:00:00 UTC")  # the instructor decided
    assert submission_time(folders) == OCTOBER


def test_a_decision_about_a_deleted_file_is_ignored(folders):
    write_record(LATE, folders[0])
    os.unlink(folders[0] / "06.ipynb")
    assert submission_time(folders) is None


@pytest.mark.parametrize("text", ["", " \n"])
def test_an_empty_timestamp_file_is_an_unknown_time(folders, text):
    write_time(folders[0], text)
    write_time(folders[1], "2026-10-01 10:00:00 UTC")
    with pytest.raises(SubmissionTimeUnknown, match="is empty"):
        submission_time(folders)


@pytest.mark.parametrize(
    "zone", ["+0200", " +0200", " +02:00", " CET", "  Europe/Berlin", ".000 Europe/Berlin"]
)
def test_time_zones_are_read(folders, zone):
    write_time(folders[0], f"2026-10-01 12:00:00{zone}")
    assert submission_time(folders) == OCTOBER
    write_time(folders[0], "2026-10-01 10:00:00")  # nbgrader's own times are in UTC
    assert submission_time(folders) == OCTOBER


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("2026-10-01 11:30:00 AEDT", "whose time zone 'AEDT' is unknown on this machine"),
        ("12.10.2026 12:00", "which is not a time such as 2026-10-12 23:59"),
        ("10/12/2026 11:59 PM", "which is not a time such as 2026-10-12 23:59"),
    ],
)
def test_a_time_that_has_no_single_meaning_is_unknown_and_quoted(folders, text, reason):
    write_time(folders[0], text)
    with pytest.raises(SubmissionTimeUnknown, match=f"timestamp.txt has '{text}', .*{reason}"):
        submission_time(folders)
    assert naive_submission_time(folders) is None


def test_a_time_without_a_zone_is_recognised(folders):
    write_time(folders[0], "2026-10-01 12:00:00 UTC")
    assert not lacks_zone(folders)
    write_time(folders[1], "2026-10-01 12:00:00")
    assert lacks_zone(folders)
    write_time(folders[1], "yesterday")
    assert not lacks_zone(folders)


def test_the_gradebook_stores_times_in_utc_without_a_zone(folders):
    assert naive_submission_time(folders) is None
    write_time(folders[0], "2026-10-01 12:00:00 Europe/Berlin")
    assert naive_submission_time(folders) == datetime(2026, 10, 1, 10)
