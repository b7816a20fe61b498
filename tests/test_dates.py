"""Dates in deadlines.toml are copied to the gradebook, so every penalty agrees with them."""

import shutil
from datetime import UTC, datetime, timedelta

import pytest

from grader.course import paths
from grader.course.deadlines_file import read_deadlines
from grader.course.paths import Course
from grader.lms import gradebook
from grader.lms import gradebook_dates as dates_module
from grader.lms.differences import differences
from grader.lms.exporters import EXPORTERS, ExportOptions
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.instructor_notes import notes
from grader.lms.penalties import load_late_penalties
from grader.lms.results_reader import class_results
from grader.lms.stage_entries import StageEntry
from tests.gradebooks import (
    EARNED,
    GROUND,
    LATE_PLUGIN,
    STAGE,
    ignore_progress,
    make_course,
    penalties,
    verdicts,
)
from tests.postgresql import NotInstalled, server

pytestmark = pytest.mark.usefixtures("reading_without_fork")

ROSTER = "id,section\nada,A\nbob,B\n"
HEAD = f'timezone = "Europe/Berlin"\n[{STAGE}]\ndue = 2026-03-01T12:00:00\n'
FULL_MARKS = 30.0  # Ada's points in two lessons; 10 % of them are 3 points


@pytest.fixture(scope="module")
def entered_root(tmp_path_factory):
    course = make_course(tmp_path_factory.mktemp("dates") / "course")
    (course.root / "nbgrader_config.py").write_text(LATE_PLUGIN)
    (course.root / "roster.csv").write_text(ROSTER)
    for student in EARNED:  # 13:00 in Berlin
        path = course.submitted / student / STAGE / "timestamp.txt"
        path.write_text("2026-03-01 12:00:00 UTC")
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    return course.root


@pytest.fixture
def course(entered_root, tmp_path):
    """Return a course without due dates, to which Ada and Bob submitted at 12:00 UTC."""
    shutil.copytree(entered_root, tmp_path / "course")
    paths._folder.cache_clear()
    return Course(tmp_path / "course")


def grade_with(course, dates):
    (course.root / "deadlines.toml").write_text(dates)
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    return penalties(course)


def lateness(course):
    stages = class_results(course).stages
    return {stage.student: stage.late for stage in stages if stage.late}


def grant(course, student, **time):
    with gradebook.open_gradebook(course) as book:
        book.grant_extension(STAGE, student, **time)


def note_texts(course):
    return list(notes(course, class_results(course), read_deadlines(course)))


@pytest.mark.end_to_end
def test_the_due_date_of_a_stage_is_copied_to_the_gradebook(course):
    assert penalties(course) == {}
    lost = grade_with(course, HEAD)
    assert lost == {"ada": pytest.approx(3.0), "bob": pytest.approx(2.075)}
    with gradebook.open_gradebook(course) as book:
        assert book.find_assignment(STAGE).duedate == datetime(2026, 3, 1, 11)
    assert lateness(course) == dict.fromkeys(EARNED, timedelta(hours=1))
    assert grade_with(course, HEAD.replace("T12", "T14")) == {}  # the due date moves to 14:00


def test_a_section_may_have_its_own_due_date(course):
    lost = grade_with(course, HEAD + f"[{STAGE}.sections]\nB = 2026-03-01T13:00:00\n")
    assert lost == {"ada": pytest.approx(3.0)}
    earlier = HEAD.replace("T12", "T18") + f"[{STAGE}.sections]\nB = 2026-02-28T12:00:00\n"
    assert grade_with(course, earlier) == {"bob": pytest.approx(2 * 2.075)}
    assert lateness(course) == {"bob": timedelta(hours=25)}
    assert note_texts(course) == []


def test_an_extension_counts_from_the_first_submission(entered_root, tmp_path):
    course = make_course(tmp_path / "course")
    (course.root / "nbgrader_config.py").write_text(LATE_PLUGIN)
    path = course.submitted / "ada" / STAGE / "timestamp.txt"
    path.write_text("2026-03-03 12:00:00 UTC")
    later = course.submitted.rename(course.root / "later")
    dates = HEAD + f"[{STAGE}.students]\nada = 2026-03-03T13:00:00\n"
    (course.root / "deadlines.toml").write_text(dates)
    enter_verdicts(course, [], [STAGE], ignore_progress)  # there are no submissions yet
    later.rename(course.submitted)
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    assert penalties(course) == {}
    assert class_results(course).stage("ada", STAGE).due == datetime(2026, 3, 3, 12, tzinfo=UTC)


def submit_at(course, student, time):
    (course.submitted / student / STAGE / "timestamp.txt").write_text(f"{time} UTC")


@pytest.mark.end_to_end
@pytest.mark.parametrize(
    ("due", "until", "last"),
    [  # Berlin's clocks go back on 25 October 2026 and forward on 28 March 2027
        ("2026-10-24T23:59:00", "2026-10-26T23:59:00", "2026-10-26 22:59"),
        ("2027-03-27T23:59:00", "2027-03-29T23:59:00", "2027-03-29 21:59"),
    ],
)
def test_an_extension_across_a_change_of_clocks_ends_at_the_right_second(course, due, until, last):
    head = f'timezone = "Europe/Berlin"\n[{STAGE}]\ndue = {due}\n'
    dates = f"{head}[{STAGE}.sections]\nB = {until}\n[{STAGE}.students]\nada = {until}\n"
    for student in EARNED:
        submit_at(course, student, f"{last}:00")
    assert grade_with(course, dates) == {}
    assert note_texts(course) == []
    for student in EARNED:
        submit_at(course, student, f"{last}:01")
    assert set(grade_with(course, dates)) == set(EARNED)
    assert lateness(course) == dict.fromkeys(EARNED, timedelta(seconds=1))


def rewrite(name, edit):
    """Return a function that edits a file in the course's folder."""

    def change(course):
        path = course.root / name
        path.write_text(edit(path.read_text()))

    return change


def change_file(course):
    path = next((course.submitted / "bob" / STAGE).rglob("*.ipynb"))
    path.write_bytes(path.read_bytes() + b"\n")


DEADLINES = "deadlines.toml"
SWITCHED_OFF = 'without = ["filter_ground"]\ndue ='
# Changes, and the students whose marks depend on them. Bob's section, B, has its own date.
CHANGES = {
    "zone": (rewrite(DEADLINES, lambda text: text.replace("Berlin", "London")), ["ada", "bob"]),
    "date": (rewrite(DEADLINES, lambda text: text.replace("-01T", "-02T")), ["ada"]),
    "extension": (
        rewrite(DEADLINES, lambda text: f"{text}[{STAGE}.students]\nbob = 2026-03-10T12:00:00\n"),
        ["bob"],
    ),
    "date of a lesson": (
        rewrite(DEADLINES, lambda text: f"{text}[{GROUND.name}]\ndue = 2026-03-03T13:00:00\n"),
        ["ada"],
    ),
    "exercise": (rewrite(DEADLINES, lambda text: text.replace("due =", SWITCHED_OFF, 1)), ["ada"]),
    "pass mark": (rewrite(DEADLINES, lambda text: "pass_mark = 60\n" + text), []),
    "comment": (rewrite(DEADLINES, lambda text: "# due next week\n" + text), []),
    "section": (rewrite("roster.csv", lambda text: text.replace("ada,A", "ada,B")), ["ada"]),
    "enrolment": (rewrite("roster.csv", lambda text: text + "cleo,A\n"), []),
    "time": (lambda course: submit_at(course, "ada", "2026-03-01 10:00:00"), ["ada"]),
    "file": (change_file, ["bob"]),
}


@pytest.mark.parametrize(("change", "students"), CHANGES.values(), ids=CHANGES)
def test_marks_are_announced_if_their_inputs_have_changed(course, change, students):
    grade_with(course, HEAD + f"[{STAGE}.sections]\nB = 2026-03-09T12:00:00\n")
    assert class_results(course).outdated == ()
    change(course)
    results = class_results(course)
    assert [student for student, stage in results.outdated if stage == STAGE] == students
    for name in ("csv", "exercises"):
        exported = EXPORTERS[name].write(ExportOptions(course, results))
        [*announced] = [note for note in exported.notes if "may be out of date" in note]
        assert len(announced) == bool(students)
        assert all(", ".join(students) in note for note in announced)


def test_grading_one_student_again_leaves_the_others_outdated(course):
    grade_with(course, HEAD)
    (course.root / DEADLINES).write_text(HEAD.replace("-01T", "-02T"))
    of_ada = [pair for pair in verdicts(course) if pair[0].student == "ada"]
    enter_verdicts(course, of_ada, [STAGE], ignore_progress, student="ada")
    assert [student for student, _ in class_results(course).outdated] == ["bob"]
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    assert class_results(course).outdated == ()


@pytest.mark.end_to_end
def test_dates_removed_from_the_file_are_removed_from_the_gradebook(course):
    section = f"[{STAGE}.sections]\nB = 2026-02-28T12:00:00\n"
    assert set(grade_with(course, HEAD + section)) == set(EARNED)
    grade_with(course, HEAD.replace("-01T", "-02T"))  # changes the date temporarily
    others = 'timezone = "Europe/Berlin"\n[stage1_ransac]\ndue = 2026-03-01T12:00:00\n'
    assert "bob" in grade_with(course, HEAD + section)
    assert grade_with(course, others) == {}
    assert class_results(course).stage("bob", STAGE).due is None
    assert set(grade_with(course, HEAD + section)) == set(EARNED)
    (course.root / "deadlines.toml").unlink()
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    assert penalties(course) == {}
    with gradebook.open_gradebook(course) as book:
        assert book.find_assignment(STAGE).duedate is None
        assert book.find_submission(STAGE, "bob").extension is None


@pytest.mark.end_to_end
def test_a_manual_date_returns_when_the_date_in_the_file_is_removed(course):
    with gradebook.open_gradebook(course) as book:
        book.update_or_create_assignment(STAGE, duedate="2026-03-01 10:00:00")
    for hour in ("18", "19"):  # no student is late
        assert grade_with(course, HEAD.replace("T12", f"T{hour}")) == {}
    grade_with(course, "")
    assert lateness(course) == dict.fromkeys(EARNED, timedelta(hours=2))
    grade_with(course, HEAD.replace("T12", "T18"))
    with gradebook.open_gradebook(course) as book:  # a date that a person enters later is also kept
        book.update_or_create_assignment(STAGE, duedate="2026-03-01 09:00:00")
    grade_with(course, "")
    assert lateness(course) == dict.fromkeys(EARNED, timedelta(hours=3))


@pytest.mark.end_to_end
def test_a_manual_extension_stays_when_the_date_in_the_file_is_removed(course):
    with gradebook.open_gradebook(course) as book:
        book.update_or_create_assignment(STAGE, duedate="2026-03-01 10:00:00")
    assert "ada" in grade_with(course, HEAD)
    grant(course, "ada", days=3)
    assert "ada" not in grade_with(course, "")
    with gradebook.open_gradebook(course) as book:  # without a due date an extension has no effect
        book.find_assignment(STAGE).duedate = None
        book.db.commit()
    assert grade_with(course, "") == {}


def test_a_run_stopped_between_its_writes_keeps_the_manual_date(course, monkeypatch):
    with gradebook.open_gradebook(course) as book:
        book.update_or_create_assignment(STAGE, duedate="2026-03-01 10:00:00")
    write = dates_module.write_atomically

    def stop(content, path):
        write(content, path)
        raise KeyboardInterrupt

    monkeypatch.setattr(dates_module, "write_atomically", stop)
    with pytest.raises(KeyboardInterrupt):
        grade_with(course, HEAD.replace("T12", "T18"))
    monkeypatch.undo()
    grade_with(course, "")
    assert lateness(course) == dict.fromkeys(EARNED, timedelta(hours=2))


def test_an_extension_removed_from_the_file_is_revoked(course):
    extended = HEAD + f"[{STAGE}.students]\nada = 2026-03-09T12:00:00\n"
    assert "ada" not in grade_with(course, extended)
    assert "ada" in grade_with(course, HEAD)
    assert note_texts(course) == []


def test_a_later_date_in_the_file_does_not_move_dates_of_sections(course):
    section = f"[{STAGE}.sections]\nB = 2026-03-08T12:00:00\n"
    grade_with(course, HEAD + section)
    grade_with(course, HEAD.replace("-01T", "-06T") + section)
    due = {stage.student: stage.due for stage in class_results(course).stages}
    assert due == {
        "ada": datetime(2026, 3, 6, 11, tzinfo=UTC),
        "bob": datetime(2026, 3, 8, 11, tzinfo=UTC),
    }
    assert note_texts(course) == []


@pytest.mark.end_to_end
def test_a_manual_extension_counts_until_the_file_names_the_student(course):
    assert "ada" in grade_with(course, HEAD)
    grant(course, "ada", days=3)
    assert "ada" not in grade_with(course, HEAD)
    (sentence,) = note_texts(course)
    assert sentence.startswith(f"ada, {STAGE}: the gradebook grants more time than deadlines.toml")
    line = sentence.partition("students] in the file: ")[2].partition(". To change")[0]
    assert line == '"ada" = 2026-03-04T11:00:00Z'
    assert "ada" not in grade_with(course, f"{HEAD}[{STAGE}.students]\n{line}\n")
    assert note_texts(course) == []
    assert "ada" in grade_with(course, f"{HEAD}[{STAGE}.students]\nada = 2026-03-01T12:00:00\n")
    assert note_texts(course) == []


@pytest.mark.parametrize(
    ("time", "zone", "phrases", "lines"),
    [
        ("19:59", "Europe/Berlin", ("1 h 59 min late", "on time"), ("UTC", "+0200")),
        ("17:59", "America/New_York", ("on time", "3 h 59 min late"), ("UTC", "-0400")),
    ],
)
def test_a_time_without_a_zone_is_reported_if_its_zone_matters(course, time, zone, phrases, lines):
    dates = f'timezone = "{zone}"\n[{STAGE}]\ndue = 2026-05-01T18:00:00Z\n'
    path = course.submitted / "ada" / STAGE / "timestamp.txt"
    path.write_text(f"2026-05-01 {time}:00")
    submit_at(course, "bob", "2026-04-01 12:00:00")
    assert ("ada" in grade_with(course, dates)) == ("late" in phrases[0])
    (sentence,) = note_texts(course)
    assert f"The work counts as {phrases[0]}. In the time zone of the course" in sentence
    assert f"it would be {phrases[1]}. Add the zone" in sentence
    for suffix in lines:
        line = f"2026-05-01 {time}:00{' ' * (suffix == 'UTC')}{suffix}"
        assert line in sentence
        path.write_text(line)
        late = "ada" in grade_with(course, dates)
        assert late == ("late" in (phrases[0] if suffix == "UTC" else phrases[1]))
        assert note_texts(course) == []
    path.write_text("2026-04-01 12:00:00")  # on time in both zones
    grade_with(course, dates)
    assert note_texts(course) == []


def test_a_time_that_cannot_be_read_is_quoted_and_costs_nothing(course):
    (course.submitted / "ada" / STAGE / "timestamp.txt").write_text("01.03.2026 9:00")
    assert "ada" not in grade_with(course, HEAD)
    (sentence,) = note_texts(course)
    assert "timestamp.txt has '01.03.2026 9:00', which is not a time such as" in sentence
    assert "so it is unknown whether the work is late, and no penalty is subtracted" in sentence


def test_a_shorter_extension_in_the_gradebook_is_corrected(course):
    section = f"[{STAGE}.sections]\nB = 2026-03-08T12:00:00\n"
    grade_with(course, HEAD + section)
    grant(course, "bob", hours=-5)
    assert "bob" not in grade_with(course, HEAD + section)


def test_a_stage_that_is_not_in_the_file_keeps_its_dates(course):
    with gradebook.open_gradebook(course) as book:
        book.update_or_create_assignment(STAGE, duedate="2026-03-01 11:00:00")
    grant(course, "ada", days=1)
    other = HEAD.replace(STAGE, "stage1_ransac")
    assert grade_with(course, other) == {"bob": pytest.approx(2.075)}
    (course.root / "deadlines.toml").unlink()
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    assert penalties(course) == {"bob": pytest.approx(2.075)}
    assert note_texts(course) == []


def test_a_different_extension_in_the_gradebook_is_reported(course):
    grade_with(course, HEAD)
    deadlines = read_deadlines(course)
    entry = StageEntry("ada", STAGE, tuple(verdicts(course)[:2]))
    with gradebook.open_gradebook(course) as book:
        arguments = (course, book, entry, load_late_penalties(course), deadlines)
        assert differences(*arguments) == []
        book.find_submission(STAGE, "ada").extension = -timedelta(hours=1)
        found = differences(*arguments)
    assert found[0] == f"ada, {STAGE}: the gradebook has a different extension"


@pytest.fixture
def postgresql():
    try:
        with server() as address:
            yield address
    except NotInstalled as missing:
        pytest.skip(str(missing))


@pytest.mark.slow
def test_dates_are_the_same_on_a_database_server(course, postgresql):
    with (course.root / "nbgrader_config.py").open("a") as file:
        file.write(f"c.CourseDirectory.db_url = {postgresql!r}\n")
    dates = (
        HEAD + f"[{STAGE}.sections]\nB = 2026-02-28T12:00:00\n"
        f"[{STAGE}.students]\nada = 2026-03-09T12:00:00\n"
    )
    assert grade_with(course, dates) == {"bob": pytest.approx(2 * 2.075)}
    assert lateness(course) == {"bob": timedelta(hours=25)}
    stage = class_results(course).stage("ada", STAGE)
    assert stage.due == datetime(2026, 3, 9, 11, tzinfo=UTC)
