"""The command `forget` deletes all data about one student and no data about others."""

import json
import shutil
import subprocess
import sys

import pytest

from grader import cli, commands
from grader.classroom.collect.record import FileOrigin, Record, read_record, write_record
from grader.course import paths
from grader.course.paths import Course
from grader.lms import gradebook
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.mark_history import read_changes
from grader.lms.results_reader import class_results
from tests.gradebooks import GROUND, STAGE, ignore_progress, make_course, submit, verdicts

NEEDLE = "Needle-Eyre"  # a last name that occurs nowhere else


def forget(course, monkeypatch, *arguments):
    """Run the command ``forget``, and return its exit status."""
    monkeypatch.setattr(commands, "Course", lambda: course)
    return cli.main(["forget", *arguments])


def files_containing(course, *needles):
    """Return the files whose path or content contains one of the texts."""
    return [
        path
        for path in course.root.rglob("*")
        if path.is_file()
        and any(
            needle in str(path.relative_to(course.root)) or needle.encode() in path.read_bytes()
            for needle in needles
        )
    ]


@pytest.fixture
def course(tmp_path):
    """Return a graded course with a file of each kind that contains data about Ada."""
    course = make_course(tmp_path / "course")
    (course.root / "roster.csv").write_text(f"id,last_name\nada,{NEEDLE}\nbob,Bell\n")
    (course.root / "deadlines.toml").write_text(
        f"[{STAGE}]\ndue = 2026-10-12T23:59:00\n[{STAGE}.students]\nada = 'excused'\n"
    )
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    for file in (
        *(f"{folder}/ada/x.html" for folder in ("feedback", "verdicts", "submitted", "autograded")),
        *("handed_back/x/ada.html", f"handed_back/{STAGE}_canvas.zip", "report/index.html"),
        *(
            "report/similarity_x.html",
            "league/x.html",
            "viva/x/key.html",
            "scores.csv",
            "scores.until-2026.csv",
        ),
        *("gradebook.db.2026-10-12", "submitted/ADA/x.html"),
    ):
        (course.root / file).parent.mkdir(parents=True, exist_ok=True)
        (course.root / file).write_text(f"ada {NEEDLE}")
    (course.root / "handed_back" / "x" / "bob.html").write_text("bob")
    for id in ("ada", "bob"):  # a team, whose work is in the archive under Ada's name
        origin = FileOrigin("0" * 64, f"canvas.zip: {NEEDLE}_4711/06_filter_ground.ipynb", "", 7)
        own = FileOrigin("1" * 64, f"canvas.zip: {id.title()}/07.ipynb", "", 8)
        record = Record({"06_filter_ground.ipynb": origin, "07.ipynb": own})
        write_record(record, course.submitted / id / STAGE)
    lines = [
        json.dumps({"student": id, "stage": STAGE, "label": label}) + "\n"
        for id, label in (("ada", "a" * 64), ("bob", "a" * 64), ("bob", "b" * 64))
    ]
    (course.submitted / ".whose.jsonl").write_text("".join(lines))
    return course


def contents(course):
    return {path: path.read_bytes() for path in course.root.rglob("*") if path.is_file()}


def test_nothing_is_deleted_without_the_option(course, monkeypatch, capsys):
    before = contents(course)
    assert forget(course, monkeypatch, NEEDLE) == 1
    printed = capsys.readouterr()
    after = contents(course)
    del after[course.root / ".grading.lock"]
    assert after == before
    for part in (
        *("submitted/ada/", "submitted/ADA/", "autograded/ada/", "verdicts/ada/", "feedback/ada/"),
        *(
            "handed_back/x/ada.html",
            "in the gradebook",
            "marks.jsonl",
            "line in submitted/.whose",
        ),
        *(f"bob/{STAGE}/.collected.json", "whole class: report", "league", "scores.until", ".zip"),
        *("gradebook.db.2026-10-12", "roster.csv", "deadlines.toml"),
    ):
        assert part in printed.out
    assert "To write the pages and tables about the class again, run report" in printed.out
    assert "Nothing was deleted" in printed.err and "--delete" in printed.err


def test_deleting_a_student_removes_all_traces_and_keeps_the_other_students(
    course, monkeypatch, capsys
):
    assert len(files_containing(course, NEEDLE)) >= 13
    assert forget(course, monkeypatch, "ada", "--delete") == 1
    assert {path.name for path in files_containing(course, NEEDLE)} == {"roster.csv"}
    (course.root / "roster.csv").write_text("id,last_name\nbob,Bell\n")
    capsys.readouterr()
    assert forget(course, monkeypatch, "ada") == 1  # although she is no longer on the roster
    assert "Delete each line about ada in deadlines.toml." in capsys.readouterr().out
    (course.root / "deadlines.toml").unlink()
    assert forget(course, monkeypatch, "ada", "--delete") == 2
    assert "There is no data about 'ada' in this course." in capsys.readouterr().err
    assert files_containing(course, "/ada/", "ada.html", '"ada"') == []
    with gradebook.open_gradebook(course) as book:
        assert [student.id for student in book.students] == ["bob"]
    # Entering the class again must not restore the student.
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    assert b"ada" not in (course.root / "marks.jsonl").read_bytes()
    assert {notebook.student for notebook in class_results(course).notebooks} == {"bob"}
    assert (course.root / "handed_back" / "x" / "bob.html").exists()
    assert (course.autograded / "bob" / STAGE).is_dir()
    kept = read_record(course.submitted / "bob" / STAGE).files
    assert [origin.archive for origin in kept.values()] == ["", "canvas.zip: Bob/07.ipynb"]
    labels = [
        json.loads(line)["label"][0]
        for line in (course.submitted / ".whose.jsonl").read_text().splitlines()
    ]
    assert labels == ["a", "b"]


@pytest.mark.parametrize("id", ["DOMAIN\\anna", 'q"q', "-dash", "日本", "a[1]*"])
def test_ids_with_special_characters_are_deleted(tmp_path, monkeypatch, id):
    course = Course(tmp_path / "course")
    for student in (id, "ada"):
        submit(course, student, GROUND)
    (course.released / STAGE).mkdir(parents=True)
    shutil.copy(GROUND.released, course.released / STAGE)
    paths._folder.cache_clear()
    earned = {student: {GROUND: (3.25, 8.5)} for student in (id, "ada")}
    enter_verdicts(course, verdicts(course, earned), [STAGE], ignore_progress)
    assert forget(course, monkeypatch, "--delete", "--", id) == 0
    assert {change.student for change in read_changes(course)} == {"ada"}
    with gradebook.open_gradebook(course) as book:
        assert [student.id for student in book.students] == ["ada"]
    assert [path.name for path in course.submitted.iterdir()] == ["ada"]


def test_a_student_without_a_folder_is_found_in_the_gradebook(course, monkeypatch):
    for folder in (course.submitted, course.autograded):
        shutil.rmtree(folder / "ada")
    shutil.rmtree(course.submitted / "ADA")
    for name in ("roster.csv", "deadlines.toml"):
        (course.root / name).unlink()
    assert forget(course, monkeypatch, "ada", "--delete") == 0
    with gradebook.open_gradebook(course) as book:
        assert [student.id for student in book.students] == ["bob"]
    assert forget(course, monkeypatch, "zoe", "--delete") == 2  # and the class's pages are kept


@pytest.mark.slow
def test_nbgrader_can_import_the_roster(tmp_path):
    course = make_course(tmp_path / "course")
    (course.root / "roster.csv").write_text(
        "id,first_name,last_name,email,section,lms_id,github\nada,Ada,Ash,a@x.edu,A,4711,a-ash\n"
    )
    done = subprocess.run(
        [sys.executable, "-m", "nbgrader", "db", "student", "import", "roster.csv"],
        cwd=course.root,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    with gradebook.open_gradebook(course) as book:
        assert book.find_student("ada").email == "a@x.edu"
