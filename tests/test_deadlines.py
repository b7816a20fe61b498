"""Due dates of the class, of sections and of individual students, with extensions and excuses."""

import os
import time
from datetime import UTC, datetime

import pytest

from grader.course.deadlines_file import DeadlinesError, read_deadlines
from grader.course.lessons import all_lessons
from grader.course.paths import Course
from grader.course.roster import Person, RosterError

ROSTER = "id,section\nanna,A\nben,B\ncleo,B\ndora,\nnoshow,A\nmary jane,\n"
DATES = """
timezone = "Europe/Berlin"
[stage1_ransac]
due = 2026-10-12T23:59:00
[stage1_ransac.sections]
B = 2026-10-13T23:59:00
[stage1_ransac.students]
anna = 2026-10-19T23:59:00
cleo = 2026-10-13T12:00:00
noshow = "excused"
[stage2_clustering]
due = 2026-11-02T08:00:00+05:00
"""


@pytest.fixture
def course(tmp_path):
    (tmp_path / "roster.csv").write_text(ROSTER)
    return Course(tmp_path)


def read(course, text):
    (course.root / "deadlines.toml").write_text(text, "utf-8")
    return read_deadlines(course)


def utc(*numbers):
    return datetime(*numbers, tzinfo=UTC)


def test_composed_and_decomposed_letters_are_equal(course):
    composed, decomposed = "jörg", "jo\u0308rg"
    (course.root / "roster.csv").write_text(f"id,section\n{composed},Übung\n", "utf-8")
    dates = read(
        course,
        "[stage1_ransac]\ndue = 2026-10-12T23:59:00Z\n"
        '[stage1_ransac.sections]\n"U\u0308bung" = 2026-10-13T23:59:00Z\n'
        f'[stage1_ransac.students]\n"{decomposed}" = 2026-10-14T23:59:00Z\n',
    )
    assert dates.due_date(composed, "stage1_ransac") == utc(2026, 10, 14, 23, 59)


def test_there_are_no_dates_without_a_file(course):
    assert read_deadlines(course) is None


def test_dates_of_students_take_precedence_over_sections_and_the_class(course):
    dates = read(course, DATES)
    due = {name: dates.due_date(name, "stage1_ransac") for name in ("anna", "ben", "cleo", "dora")}
    assert due == {  # UTC is two hours behind summer time
        "anna": utc(2026, 10, 19, 21, 59),
        "ben": utc(2026, 10, 13, 21, 59),
        "cleo": utc(2026, 10, 13, 10, 0),
        "dora": utc(2026, 10, 12, 21, 59),
    }
    assert dates.due_date(Person("ben", section="B"), "stage1_ransac") == due["ben"]
    assert dates.due_date("another student", "stage1_ransac") == due["dora"]


def test_a_date_may_have_a_time_zone_and_a_stage_may_have_no_date(course):
    dates = read(course, DATES)
    assert dates.due_date("anna", "stage2_clustering") == utc(2026, 11, 2, 3)
    assert dates.due_date("anna", "stage3_obstacles") is None
    assert not dates.is_excused("noshow", "stage2_clustering")


def test_extensions_and_excuses_are_read(course):
    dates = read(course, DATES)
    assert dates.extensions("stage1_ransac") == {"anna": utc(2026, 10, 19, 21, 59)}
    assert dates.extensions("stage2_clustering") == dates.extensions("stage3_obstacles") == {}
    assert dates.is_excused("noshow", "stage1_ransac") and not dates.is_excused(
        "anna", "stage1_ransac"
    )


def test_extensions_are_relative_to_the_section(course):
    text = DATES.replace("cleo = 2026-10-13T12:00:00", "cleo = 2026-10-14T00:00:00")
    assert set(read(course, text).extensions("stage1_ransac")) == {"anna", "cleo"}


@pytest.mark.skipif(not hasattr(time, "tzset"), reason="setting the machine's time zone")
def test_dates_without_a_time_zone_use_the_zone_of_the_machine(course, monkeypatch):
    monkeypatch.setenv("TZ", "America/New_York")
    time.tzset()
    try:
        dates = read(course, "[stage1_ransac]\ndue = 2026-10-12T23:59:00\n")
        assert dates.due_date("x", "stage1_ransac") == utc(2026, 10, 13, 3, 59)
        later = read(course, "[stage1_ransac]\ndue = 2026-12-12T23:59:00\n")
        assert later.due_date("x", "stage1_ransac") == utc(2026, 12, 13, 4, 59)
    finally:
        monkeypatch.undo()
        time.tzset()
    assert os.environ.get("TZ") != "America/New_York"


def test_students_may_have_their_own_dates_without_a_roster(course):
    (course.root / "roster.csv").unlink()
    dates = read(
        course,
        '[stage1_ransac]\ndue = 2026-10-12T12:00:00Z\n[stage1_ransac.students]\n"mary jane" = '
        '2026-10-13T12:00:00Z\nghost = "excused"\n',
    )
    assert dates.due_date("mary jane", "stage1_ransac") == utc(2026, 10, 13, 12)
    assert dates.is_excused("ghost", "stage1_ransac")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[stage1_ransac", "in quotation marks"),
        (
            "[stage1_ransac]\ndue = 12.10.2026 23:59",
            "deadlines.toml, line 2, due = 12.10.2026 23:59: Expected newline or end of document "
            "after a statement. Write dates as 2026-10-12T23:59:00.",
        ),
        ("due = 2026-10-12T23:59:00", "move due below the heading of its stage."),
        (
            '[stage1_ransac]\ndue = 2026-10-12T23:59:00\ntimezone = "UTC"',
            "[stage1_ransac]: move timezone above the first heading.",
        ),
        (
            'Timezone = "UTC"',
            "there is no stage, lesson or setting Timezone. Choose from: stage1_ransac,",
        ),
        (
            "[stage1_ransac]\ndue = 2026-10-12T23:59:00\n[stage1_ransac.students]\nmary jane = 1",
            "mary",
        ),
        (
            "[stage1]\n",
            "no stage, lesson or setting stage1. Choose from: stage1_ransac, stage2_clustering",
        ),
        ("stage1_ransac = 2026-10-12T23:59:00", "make this a heading, and write due ="),
        ("[stage1_ransac]\nlessons = [1]", "[stage1_ransac], lessons: list the numbers"),
        ('[stage1_ransac]\nlessons = "01"', "[stage1_ransac], lessons: list the numbers"),
        ('[stage1_ransac]\nlessons = ["06"]', "The lessons of this stage are: 01, 02, 03."),
        ("[stage1_ransac]\ndeu = 2026-10-12T23:59:00", "there is no entry deu. Choose from: due,"),
        (
            "[stage1_ransac]\ndue = 2026-11-02",
            "due: 2026-11-02 is not a date with a time. Write it as 2026-11-02T23:59:00.",
        ),
        ('[stage1_ransac]\ndue = "12.10.2026 23:59"', "12.10.2026 23:59 is not a date with a time"),
        ("[stage1_ransac]\ndue = 23:59:00", "23:59:00 is not a date with a time"),
        ('[stage1_ransac]\ndue = "excused"', "excused is not a date"),
        ("[stage1_ransac]\ndue = 9999-12-31T23:59:00-05:00", "out of range"),
        (
            'timezone = "Europe/Berlin"\n[stage1_ransac]\ndue = 0001-01-01T00:00:00',
            "[stage1_ransac], due: 0001-01-01 00:00:00 is out of range",
        ),
        (
            '[stage1_ransac.students]\nanna = "excussed"',
            "students], anna: excussed is not a date with a time. Write it as 2026-10-12T23:59:00, "
            'or "excused".',
        ),
        (
            "[stage1_ransac]\nstudents = 3",
            "make students a separate heading, [stage1_ransac.students]",
        ),
        (
            "[stage1_ransac.students]\nanna = 2026-10-12T23:59:00",
            "[stage1_ransac]: only some students have a date.",
        ),
        (
            "[stage1_ransac]\ndue = 2026-10-12T23:59:00\n[stage1_ransac.sections]\nC = "
            "2026-10-12T23:59:00",
            "[stage1_ransac.sections], C: no student on the roster is in this section. "
            "The sections are: A, B.",
        ),
        (
            '[stage1_ransac.students]\nAnna = "excused"',
            "[stage1_ransac.students], Anna: no student on the roster has this id. Write anna.",
        ),
        ('[stage1_ransac.students]\nzoe = "excused"', "Correct it, or add a line to roster.csv."),
        ('timezone = "Europe/Berlyn"', "the time zone 'Europe/Berlyn' is unknown"),
        ('timezone = "../../etc/passwd"', "is unknown on this machine"),
        ("timezone = 2", "the time zone 2 is unknown"),
    ],
)
def test_errors_name_the_entry_and_suggest_a_fix(course, text, message):
    with pytest.raises(DeadlinesError) as trouble:
        read(course, text)
    assert message in str(trouble.value) and str(trouble.value).startswith("deadlines.toml")


@pytest.mark.parametrize(
    "text",
    [
        "2026-10-12T23:59",
        "2026-10-12 23:59  # Monday",
        "2026-10-12T21:59Z",
        "2026-10-12T14:59-07:00",
        '"2026-10-12 23:59"',
        '"2026-10-12 11:59 PM"',
        '"Monday, 12 October 2026, 23:59"',
        '"2026-10-12 21:59:00 UTC"',
    ],
)
def test_unambiguous_dates_are_read(course, text):
    dates = read(
        course,
        f'timezone = "Europe/Berlin"\n[stage1_ransac]\ndue = {text}\n'
        f'[stage1_ransac.students]\n"mary jane"={text}\n',
    )
    due = utc(2026, 10, 12, 21, 59)
    assert (
        dates.due_date("anna", "stage1_ransac")
        == dates.due_date("mary jane", "stage1_ransac")
        == due
    )


def test_a_stage_with_only_excuses_needs_no_date(course):
    assert (
        read(course, '[stage1_ransac.students]\nnoshow = "excused"').due_date("x", "stage1_ransac")
        is None
    )


def test_sections_need_a_roster(course):
    (course.root / "roster.csv").unlink()
    with pytest.raises(DeadlinesError, match="because there is no roster.csv"):
        read(course, DATES)


def test_an_unreadable_roster_raises_a_roster_error(course):
    (course.root / "roster.csv").write_text("name\nx\n")
    with pytest.raises(RosterError):
        read(course, DATES)


def test_lessons_that_count_are_read_in_their_order(course):
    deadlines = read(course, '[stage1_ransac]\nlessons = ["03", "01"]\n[stage2_clustering]\n')
    assert deadlines.assigned_lessons("stage1_ransac") == ("01_point_clouds", "03_ransac_plane")
    assert deadlines.assigned_lessons("stage2_clustering") is None
    assert deadlines.assigned_lessons("stage3_obstacles") is None
    deadlines = read(course, "[stage1_ransac]\nlessons = []")
    assert deadlines.assigned_lessons("stage1_ransac") == ()
    lessons = [lesson for lesson in all_lessons() if lesson.stage == "stage1_ransac"]
    assert deadlines.unassigned_lessons(all_lessons()) == lessons


LESSON = """
timezone = "UTC"
[stage1_ransac]
due = 2026-10-12T12:00:00
[stage1_ransac.sections]
B = 2026-10-13T12:00:00
[stage1_ransac.students]
anna = 2026-10-19T12:00:00
[01_point_clouds]
due = 2026-10-05T12:00:00
[01_point_clouds.students]
cleo = 2026-10-06T12:00:00
[03_ransac_plane]
due = 2026-10-20T12:00:00
"""


def lesson_dates(dates, lesson, granted=None):
    """Return the day on which a lesson is due, by student; `granted` is from the gradebook."""
    due = {}
    for name in ("anna", "ben", "cleo", "dora"):
        of_stage = granted or dates.due_date(name, "stage1_ransac")
        due[name] = dates.lesson_due_date(name, "stage1_ransac", lesson, of_stage).day
    return due


def test_a_lesson_may_have_its_own_dates(course):
    dates = read(course, LESSON)
    assert lesson_dates(dates, "02_ransac_line") == {"anna": 19, "ben": 13, "cleo": 13, "dora": 12}
    assert lesson_dates(dates, "01_point_clouds") == {"anna": 19, "ben": 5, "cleo": 6, "dora": 5}
    assert set(dates.lessons_with_dates("stage1_ransac")) == {"01_point_clouds", "03_ransac_plane"}
    assert dates.lessons_with_dates("stage2_clustering") == {}
    assert set(dates.extensions("01_point_clouds")) == {"cleo"}


def test_an_extension_of_the_stage_never_shortens_the_time_for_a_lesson(course):
    dates = read(course, LESSON)
    assert lesson_dates(dates, "03_ransac_plane") == dict.fromkeys(
        ("anna", "ben", "cleo", "dora"), 20
    )
    granted = lesson_dates(dates, "01_point_clouds", utc(2026, 10, 25))
    assert granted == dict.fromkeys(("anna", "ben", "cleo", "dora"), 25)
    assert lesson_dates(dates, "03_ransac_plane", utc(2026, 10, 11)) == dict.fromkeys(granted, 20)


def test_a_lesson_may_have_a_date_in_a_stage_without_one(course):
    dates = read(course, "[01_point_clouds]\ndue = 2026-10-05T12:00:00Z\n")
    due = dates.lesson_due_date("anna", "stage1_ransac", "01_point_clouds", None)
    assert due == utc(2026, 10, 5, 12)
    assert dates.lesson_due_date("anna", "stage1_ransac", "02_ransac_line", None) is None


def test_everything_counts_without_rules(course):
    rules = read(course, DATES).rules
    assert (rules.excluded_exercises, rules.drop_lowest, rules.pass_mark) == (frozenset(), 0, None)


def test_rules_are_read_and_described(course):
    dates = read(
        course,
        "drop_lowest = 2\npass_mark = 50.5\n"
        + LESSON.replace(
            "12:00:00\n[stage1_ransac.s",
            '12:00:00\nlessons = ["01", "03"]\n'
            'without = ["fit_plane", "drop_invalid"]\n[stage1_ransac.s',
            1,
        ),
    )
    assert dates.rules.excluded_exercises == {"drop_invalid", "fit_plane"}
    assert (dates.rules.drop_lowest, dates.rules.pass_mark) == (2, 50.5)
    assert list(dates.descriptions()) == [
        "stage1_ransac due 2026-10-12 12:00 UTC, section B due 2026-10-13 12:00 UTC, "
        "1 with an extension, lessons that count: 01 03",
        "01_point_clouds due 2026-10-05 12:00 UTC, 1 with an extension",
        "03_ransac_plane due 2026-10-20 12:00 UTC",
        "exercises that do not count: drop_invalid, fit_plane",
        "totals leave out each student's 2 lowest lessons",
        "pass mark 50.5 %",
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("drop_lowest = 12", "12 is not a number of lessons that can be left out of 12. Write a"),
        ("drop_lowest = -1", "-1 is not a number of lessons"),
        ("drop_lowest = true", "is not a number of lessons"),
        ('drop_lowest = "1"', "drop_lowest: 1 is not a number of lessons"),
        ("drop_lowest = 9\n[stage1_ransac]\nlessons = []", "can be left out of 9."),
        ("[stage1_ransac]\ndrop_lowest = 1", "move drop_lowest above the first heading"),
        ("pass_mark = 0", "pass_mark: 0 is not a percentage"),
        ("pass_mark = 100.5", "is not a percentage"),
        ("pass_mark = nan", "is not a percentage"),
        ('pass_mark = "50 %"', "is not a percentage"),
        ("[stage1_ransac]\npass_mark = 50", "move pass_mark above the first heading"),
        ('without = ["fit_plane"]', "move without below the heading of its stage"),
        ('[stage1_ransac]\nwithout = ["fit_plan"]', "The exercises that count are: horizontal_di"),
        ('[stage1_ransac]\nwithout = "fit_plane"', "list exercises in quotation marks"),
        ("[stage1_ransac]\nwithout = [1]", "list exercises in quotation marks"),
        ('[stage1_ransac]\nwithout = ["filter_ground"]', "The exercises that count are:"),
        (
            '[stage1_ransac]\nlessons = ["01"]\nwithout = ["fit_plane"]',
            "The exercises that count are: horizontal_distance, drop_invalid.",
        ),
        (
            '[stage1_ransac]\nwithout = ["drop_invalid", "horizontal_distance"]',
            "`without` switches off all exercises of 01_point_clouds. To leave out the whole",
        ),
        (
            "[01_point_clouds]",
            "[01_point_clouds]: there is no date. Add a line due = 2026-10-12T23:59:00",
        ),
        ("[01_point_clouds]\nlessons = []", "move lessons below the heading of its stage"),
        (
            '[01_point_clouds]\ndue = 2026-10-12T23:59:00\nwithout = ["fit_plane"]',
            "move without below the heading of its stage",
        ),
        (
            "[01_point_clouds]\ndue = 2026-10-12T23:59:00\n[01_point_clouds.students]\n"
            'anna = "excused"',
            "[01_point_clouds.students], anna: a student can be excused only from a whole stage. "
            "Move this line below [stage1_ransac.students]",
        ),
        (
            "[01_point_clouds]\ndue = 2026-10-12T23:59:00\n[01_point_clouds.students]\n"
            "zoe = 2026-10-12T23:59:00",
            "[01_point_clouds.students], zoe: no student on the roster has this id",
        ),
        (
            '[stage1_ransac]\nlessons = ["02"]\n[01_point_clouds]\ndue = 2026-10-12T23:59:00',
            '[01_point_clouds]: this lesson has a date but does not count. Add "01" to lessons',
        ),
    ],
)
def test_contradictory_rules_are_refused(course, text, message):
    with pytest.raises(DeadlinesError) as trouble:
        read(course, text)
    assert message in str(trouble.value) and str(trouble.value).startswith("deadlines.toml")
