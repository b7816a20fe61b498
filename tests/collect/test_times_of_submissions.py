"""The time of a submission, with archives in any order and runs that stop at any moment."""

import contextlib
from datetime import UTC, datetime
from pathlib import Path

import pytest

from grader.classroom.collect import record, storage
from grader.course.paths import Course
from grader.lms.submission_times import SubmissionTimeUnknown, submission_time
from tests.archives import EIGHT, SEVEN, SIX, canvas_files, notebook
from tests.collecting import (
    MONDAY,
    STAGE,
    TUESDAY,
    archive,
    collect,
    older_files,
    placed_files,
    resubmission,
    states,
)

EARLY, LATE = "2026-10-10 10:00:00 UTC", "2026-10-20 10:00:00 UTC"


def make_course(root):
    root.mkdir()
    (root / "roster.csv").write_text("id,last_name,first_name,lms_id\nada,Lovelace,Ada,4001\n")
    return Course(root)


@pytest.fixture
def course(tmp_path):
    return make_course(tmp_path / "course")


def utc(text):
    return datetime.strptime(text, "%Y-%m-%d %H:%M:%S UTC").replace(tzinfo=UTC)


def write_table(course, time):
    path = course.root / "times.csv"
    path.write_text(f"id,Last modified (submission)\nada,{time}\n")
    return path


def stage_folder(course):
    return course.submitted / "ada" / STAGE


def time_of(course):
    """Return the submission time of the stage, or the reason why it is unknown."""
    try:
        return submission_time([stage_folder(course)])
    except SubmissionTimeUnknown as reason:
        return str(reason)


def lesson_archive(course, name, text="x = 1", file=None):
    files = [(f"ada/{name}.ipynb", notebook(name, text))]
    return archive(course, files, file or f"{name}-{text[:1]}.zip")


@pytest.mark.parametrize("times", [(LATE, EARLY), (EARLY, LATE)])
def test_the_latest_time_of_all_lessons_counts_in_any_order(course, times):
    for name, time in zip((EIGHT, SIX), times, strict=True):
        collect(course, lesson_archive(course, name), times=write_table(course, time))
    assert placed_files(course, "ada")["timestamp.txt"].decode() == f"{LATE}\n"
    collect(course, lesson_archive(course, SEVEN), times=write_table(course, EARLY))
    assert time_of(course) == utc(LATE)


def test_the_time_of_a_deleted_lesson_does_not_count(course):
    for name, time in ((EIGHT, LATE), (SIX, EARLY)):
        collect(course, lesson_archive(course, name), times=write_table(course, time))
    (stage_folder(course) / f"{EIGHT}.ipynb").unlink()
    collect(course, lesson_archive(course, SEVEN), times=write_table(course, EARLY))
    assert time_of(course) == utc(EARLY)


def test_a_lesson_without_a_time_leaves_the_stage_undecided(course):
    collect(course, lesson_archive(course, EIGHT))
    assert time_of(course) is None
    outcome = collect(course, lesson_archive(course, SIX), times=write_table(course, LATE))
    assert (
        time_of(course)
        == outcome.undecided["ada"]
        == f"the submission time of {EIGHT}.ipynb is unknown"
    )
    # The same file is collected again.
    collect(course, lesson_archive(course, EIGHT), times=write_table(course, EARLY))
    assert time_of(course) == utc(LATE)


def test_an_earlier_submission_is_restored_with_its_time(course):
    """The test follows the steps in docs/grading.md."""
    (first, second) = (
        archive(course, [(f"ada/{SIX}.ipynb", notebook(text=text))], f"{text}.zip", when=day)
        for text, day in (("old", MONDAY), ("new", TUESDAY))
    )
    collect(course, first, times=write_table(course, EARLY))
    collect(course, second, times=write_table(course, LATE))
    earlier = stage_folder(course) / ".older" / f"{SIX}.1.ipynb"
    (stage_folder(course) / f"{SIX}.ipynb").write_bytes(earlier.read_bytes())
    (stage_folder(course) / "timestamp.txt").write_text(EARLY)
    assert time_of(course) == utc(EARLY)
    outcome = collect(course, second, times=write_table(course, LATE))
    (question,) = outcome.questions
    outcome = collect(course, second, times=write_table(course, LATE), who={question.name: "-"})
    assert outcome.questions == [] and time_of(course) == utc(EARLY)
    assert placed_files(course, "ada")[f"{SIX}.ipynb"] == notebook(text="old")


def test_a_time_written_by_hand_counts_for_all_files_in_the_folder(course):
    files = canvas_files("Lovelace, Ada", 4001, [(1, f"{SIX}.ipynb", notebook())], late=True)
    collect(course, archive(course, files))
    (stage_folder(course) / "timestamp.txt").write_text(LATE)
    collect(course, archive(course, files))
    assert placed_files(course, "ada")["timestamp.txt"].decode() == LATE, "nothing has changed"
    collect(course, lesson_archive(course, SEVEN), times=write_table(course, EARLY))
    assert time_of(course) == utc(LATE)
    assert LATE.encode() in older_files(course, "ada")


def test_each_lesson_has_its_own_time_until_a_time_is_written_by_hand(course):
    """Lessons with their own due dates need these times."""
    # Lesson 06 is collected twice with the same content, so it keeps its earlier time.
    for name, time in ((SIX, EARLY), (SEVEN, LATE), (SIX, LATE)):
        collect(course, lesson_archive(course, name), times=write_table(course, time))
    paths = [stage_folder(course) / f"{name}.ipynb" for name in (SIX, SEVEN)]
    assert [record.file_time(path) for path in paths] == [utc(EARLY), utc(LATE)]
    assert record.file_time(stage_folder(course) / "other.ipynb") is None
    (stage_folder(course) / "timestamp.txt").write_text("2026-10-19 10:00:00 UTC")
    assert [record.file_time(path) for path in paths] == [None, None]
    (stage_folder(course) / "timestamp.txt").unlink()
    assert [record.file_time(path) for path in paths] == [None, None]


def test_the_time_of_files_that_nbgrader_collected_counts(course):
    """A file that nbgrader collected earlier determines the stage's time if its time is later."""
    stage_folder(course).mkdir(parents=True)
    (stage_folder(course) / f"{EIGHT}.ipynb").write_bytes(notebook(EIGHT))
    (stage_folder(course) / "timestamp.txt").write_text("2026-10-20 12:00:00.250000 UTC")
    collect(course, lesson_archive(course, SIX), times=write_table(course, EARLY))
    assert time_of(course) == datetime(2026, 10, 20, 12, tzinfo=UTC)
    collect(course, lesson_archive(course, SEVEN), times=write_table(course, LATE))
    assert time_of(course) == datetime(2026, 10, 20, 12, tzinfo=UTC)


def test_an_unreadable_time_stays_undecided(course):
    collect(course, lesson_archive(course, SIX), times=write_table(course, EARLY))
    (stage_folder(course) / "timestamp.txt").write_text("Tuesday, I think")
    collect(course, lesson_archive(course, SEVEN), times=write_table(course, EARLY))
    reason = "timestamp.txt has 'Tuesday, I think', which is not a time such as 2026-10-12 23:59"
    assert time_of(course) == reason


def remark(outcome):
    """Return the only remark, which is about Ada, or an empty string."""
    if not outcome.remarks:
        return ""
    (found,) = outcome.remarks
    assert found.name == "ada"
    return found.text


def test_an_earlier_time_for_the_same_files_is_entered(course):
    path = lesson_archive(course, SIX)
    collect(course, path, times=write_table(course, LATE))
    outcome = collect(course, path, times=write_table(course, EARLY))
    assert time_of(course) == utc(EARLY)
    assert remark(outcome).startswith(f"The submission time was {LATE} and is now {EARLY}, because")
    assert LATE.encode() + b"\n" in older_files(course, "ada")
    assert remark(collect(course, path, times=write_table(course, EARLY))) == ""


def test_a_later_time_for_the_same_files_is_reported_with_the_edit_that_enters_it(course):
    """The time may belong to another attempt with the same file, so a person has to decide."""
    path = lesson_archive(course, SIX)
    collect(course, path, times=write_table(course, EARLY))
    text = remark(collect(course, path, times=write_table(course, LATE)))
    assert f"has {LATE!r}, but submitted/ada/{STAGE}/timestamp.txt has {EARLY} for" in text
    assert time_of(course) == utc(EARLY)
    assert f"write {LATE} there" in text
    (stage_folder(course) / "timestamp.txt").write_text(LATE)
    assert remark(collect(course, path, times=write_table(course, LATE))) == ""
    assert time_of(course) == utc(LATE)


@pytest.mark.parametrize(
    ("zone", "expected"),
    [("America/New_York", "2026-10-12 21:00:00 UTC"), ("Asia/Tokyo", "2026-10-12 08:00:00 UTC")],
)
def test_a_time_is_read_again_in_another_time_zone(course, zone, expected):
    path, times = lesson_archive(course, SIX), write_table(course, "2026-10-12 17:00")
    deadlines = course.root / "deadlines.toml"
    deadlines.write_text('timezone = "Europe/Berlin"\n')
    collect(course, path, times=times)
    deadlines.write_text(f'timezone = "{zone}"\n')
    text = remark(collect(course, path, times=times))
    assert f"was 2026-10-12 15:00:00 UTC and is now {expected}, because" in text
    assert time_of(course) == utc(expected)


@pytest.mark.parametrize("text", ["garbage", "03/04/2026 23:59", "22.11.2026 1:10"])
def test_an_unreadable_time_in_the_table_is_quoted_even_if_there_is_an_earlier_time(course, text):
    path = lesson_archive(course, SIX)
    collect(course, path, times=write_table(course, EARLY))
    outcome = collect(course, path, times=write_table(course, text))
    assert remark(outcome).startswith(f"The table of submission times has {text!r}, which is not")
    assert f"so the earlier time, {EARLY}, still counts" in remark(outcome)
    assert not outcome.undecided and time_of(course) == utc(EARLY)
    assert remark(collect(course, path, times=write_table(course, "-"))) == ""


@pytest.mark.parametrize("written_after", ["the first run", "no run"])
def test_a_time_written_by_hand_takes_precedence_over_a_table(course, written_after):
    if written_after == "the first run":
        collect(course, lesson_archive(course, SIX), times=write_table(course, LATE))
    else:
        stage_folder(course).mkdir(parents=True)
        (stage_folder(course) / f"{SIX}.ipynb").write_bytes(notebook(SIX, "x = 1"))
    (stage_folder(course) / "timestamp.txt").write_text("2026-10-15 10:00:00 UTC")
    for time in (EARLY, LATE):
        text = remark(collect(course, lesson_archive(course, SIX), times=write_table(course, time)))
        assert f"write {time} there" in text
        assert time_of(course) == utc("2026-10-15 10:00:00 UTC")
    collect(course, lesson_archive(course, SEVEN), times=write_table(course, EARLY))
    if written_after == "the first run":  # the time now belongs to the first file
        text = remark(
            collect(course, lesson_archive(course, SIX), times=write_table(course, EARLY))
        )
        assert f"write {EARLY} there" in text
    assert time_of(course) == utc("2026-10-15 10:00:00 UTC")


def test_an_assignment_for_each_lesson_may_have_its_own_times(course):
    """The same module is next to both notebooks, and each download is collected twice."""
    module = ("ada/helper.py", b"y = 1")
    paths = [
        archive(course, [(f"ada/{name}.ipynb", notebook(name)), module], f"{name}.zip")
        for name in (SIX, SEVEN)
    ]
    for _ in range(2):
        for path, time in zip(paths, (EARLY, LATE), strict=True):
            assert remark(collect(course, path, times=write_table(course, time))) == ""
    assert time_of(course) == utc(LATE)


def test_a_time_in_the_table_is_not_compared_with_the_time_of_newer_files(course):
    first, second = resubmission(course, notebook(text="first"), notebook(text="second"))
    collect(course, second, times=write_table(course, EARLY))
    outcome = collect(course, first, times=write_table(course, LATE))
    assert states(outcome) == {"ada": {"06": "kept"}} and remark(outcome) == ""
    assert time_of(course) == utc(EARLY)


def test_an_unreadable_row_is_not_hidden_by_a_readable_one(course):
    times = write_table(course, EARLY)
    times.write_text(times.read_text() + "ada,12/11/2026 10:00\n")
    outcome = collect(course, lesson_archive(course, SIX), times=times)
    assert "'12/11/2026 10:00'" in outcome.undecided["ada"] == time_of(course)


class Stopped(BaseException):
    """Takes the place of KeyboardInterrupt, which also ends a run."""


def stop_at(change, calls, number, after):
    """Return a version of `change` that raises `Stopped` before or after the nth call."""

    def changing(*args, **kwargs):
        calls.append(change)
        if len(calls) == number and not after:
            raise Stopped
        change(*args, **kwargs)
        if len(calls) == number:
            raise Stopped

    return changing


@contextlib.contextmanager
def stopped_at(monkeypatch, number, after):
    """Stop the code in the context at its nth change of a file; yield the list of changes."""
    changes = []
    with monkeypatch.context() as patch, contextlib.suppress(Stopped):
        for owner, name in (
            (storage, "write_atomically"),
            (record, "write_atomically"),
            (Path, "unlink"),
        ):
            patch.setattr(owner, name, stop_at(getattr(owner, name), changes, number, after))
        yield changes


@pytest.mark.end_to_end
@pytest.mark.parametrize("after", [False, True])
def test_a_stopped_correction_of_a_time_is_completed_by_the_next_run(tmp_path, monkeypatch, after):
    for number in range(1, 30):
        course = make_course(tmp_path / str(number))
        path = lesson_archive(course, SIX)
        collect(course, path, times=write_table(course, LATE))
        times = write_table(course, EARLY)
        with stopped_at(monkeypatch, number, after) as changes:
            collect(course, path, times=times)
        assert isinstance(time_of(course), str) or time_of(course) in (utc(EARLY), utc(LATE))
        collect(course, path, times=times)
        assert time_of(course) == utc(EARLY)
        if len(changes) < number:
            break
    assert 4 < number < 29


@pytest.mark.end_to_end
@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize("written_by", ["the grader", "a person", "no one"])
def test_new_work_never_gets_the_time_of_old_work_if_a_run_is_stopped(
    tmp_path, monkeypatch, after, written_by
):
    """Stop a run at each change in turn. Running the same command again completes the run."""
    for number in range(1, 30):
        course = make_course(tmp_path / str(number))
        first, second = resubmission(course, notebook(text="first"), notebook(text="second"))
        collect(
            course, first, times=write_table(course, EARLY) if written_by == "the grader" else None
        )
        if written_by == "a person":
            (stage_folder(course) / "timestamp.txt").write_text(EARLY)
        before = time_of(course)
        new_times = write_table(course, LATE)
        with stopped_at(monkeypatch, number, after) as changes:
            collect(course, second, times=new_times)
        is_new = placed_files(course, "ada")[f"{SIX}.ipynb"] == notebook(text="second")
        found = time_of(course)
        assert isinstance(found, str) or found == (utc(LATE) if is_new else before)
        state = states(collect(course, second, times=new_times))["ada"]["06"]
        assert state == ("same" if is_new else "newer")
        assert placed_files(course, "ada")[f"{SIX}.ipynb"] == notebook(text="second")
        assert time_of(course) == utc(LATE)
        if len(changes) < number:
            break
    assert 4 < number < 29, "the run was stopped at each change, and at last not stopped"
