"""Archives that are collected after others: newer work replaces older work."""

import pytest

from grader.classroom.collect.record import read_record
from grader.classroom.submissions import find_submissions, unaccounted_files
from tests.archives import SIX, canvas_files, notebook
from tests.collecting import (
    MONDAY,
    STAGE,
    TUESDAY,
    archive,
    collect,
    older_files,
    placed_files,
    questions,
    resubmission,
    states,
)


def test_an_identical_file_is_not_replaced(course):
    first, second = resubmission(course, notebook(), notebook())
    collect(course, first)
    path = course.submitted / "ada" / STAGE / f"{SIX}.ipynb"
    before = path.stat()
    assert states(collect(course, second)) == {"ada": {"06": "same"}}
    assert (path.stat().st_ino, path.stat().st_mtime_ns) == (before.st_ino, before.st_mtime_ns)


def test_a_newer_submission_replaces_the_older_one_which_is_kept(course):
    first, second = resubmission(course, notebook(text="first"), notebook(text="second"))
    collect(course, first)
    assert states(collect(course, second)) == {"ada": {"06": "newer"}}
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text="second")}
    assert older_files(course, "ada") == [notebook(text="first")]
    assert [submission.path.name for submission in find_submissions(course)] == [f"{SIX}.ipynb"]
    assert find_submissions(course)[0].older == ()
    assert unaccounted_files(course) == []


def test_an_older_archive_does_not_replace_newer_work(course):
    first, second = resubmission(course, notebook(text="first"), notebook(text="second"))
    collect(course, second)
    assert states(collect(course, first)) == {"ada": {"06": "kept"}}
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text="second")}


def test_canvas_numbers_take_precedence_over_the_time_of_the_download(course):
    for number, name, modified in ((9, "new", MONDAY), (8, "old", TUESDAY)):
        files = canvas_files("L, Ada", 4001, [(number, f"{SIX}.ipynb", notebook(text=name))])
        outcome = collect(course, archive(course, files, f"{name}.zip", when=modified))
    assert states(outcome) == {"ada": {"06": "kept"}}
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text="new")}


@pytest.mark.parametrize("hand", ["changed", "put there"])
def test_manual_changes_are_never_overwritten(course, hand):
    first, second = resubmission(course, notebook(text="first"), notebook(text="second"))
    path = course.submitted / "ada" / STAGE / f"{SIX}.ipynb"
    if hand == "changed":
        collect(course, first)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"by hand")
    outcome = collect(course, second)
    assert states(outcome) == {"ada": {"06": "?"}}
    assert f"submitted/ada/{STAGE}/{SIX}.ipynb" in questions(outcome)[f"ada/{SIX}.ipynb"]
    assert path.read_bytes() == b"by hand"
    path.unlink()
    assert states(collect(course, second)) == {"ada": {"06": "new"}}


def test_a_time_belongs_to_the_files_that_it_arrived_with(course):
    first, second = resubmission(course, notebook(text="first"), notebook(text="second"))
    table = course.root / "times.csv"
    head = "id,Last modified (submission)\n"
    table.write_text(head + "ada,2026-10-12 10:00:00 UTC\n")
    collect(course, first, times=table)
    table.write_text(head + "ada,2026-10-19 10:00:00 UTC\n")
    collect(course, first, times=table)
    assert placed_files(course, "ada")["timestamp.txt"] == b"2026-10-12 10:00:00 UTC\n"
    outcome = collect(course, second)
    assert "timestamp.txt" not in placed_files(course, "ada"), "this is the time of older work"
    assert outcome.undecided["ada"] == "the work was submitted again, and the time is unknown"
    assert outcome.states and b"2026-10-12 10:00:00 UTC\n" in older_files(course, "ada")
    collect(course, second, times=table)
    assert placed_files(course, "ada")["timestamp.txt"] == b"2026-10-19 10:00:00 UTC\n"
    assert read_record(course.submitted / "ada" / STAGE).undecided == ""
