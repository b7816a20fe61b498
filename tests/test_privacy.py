"""The guide's commands delete all data about one student and no data about others."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from grader.course.paths import PROJECT
from grader.lms import gradebook
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.standings import class_results
from tests.test_gradebook import STAGE, make_course, quiet, verdicts

NEEDLE = "Needle-Eyre"  # a last name that occurs nowhere else


def readme_commands():
    """Return the guide's commands that delete a student, except the command for the report."""
    text = (PROJECT / "docs" / "privacy.md").read_text("utf-8")
    (block,) = re.findall(r"```sh\n(X=anna\n.*?)```", text, re.S)
    return block.replace("X=anna", "X=ada").replace("python -m grader report\n", "")


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


@pytest.mark.slow
def test_deleting_a_student_removes_all_traces_and_keeps_the_other_students(tmp_path):
    course = make_course(tmp_path / "course")
    roster = course.root / "roster.csv"
    roster.write_text(f"id,last_name\nada,{NEEDLE}\nbob,Bell\n")
    enter_verdicts(course, verdicts(course), [STAGE], quiet)
    for folder in ("feedback/ada", "verdicts/ada", "handed_back/x", "report"):
        (course.root / folder).mkdir(parents=True, exist_ok=True)
    for file in (
        "feedback/ada/x.html",
        "handed_back/x/ada.html",
        "report/index.html",
        "scores.csv",
    ):
        (course.root / file).write_text(f"ada {NEEDLE}")
    (course.root / "handed_back" / "x" / "bob.html").write_text("bob")
    lines = [
        f'{{"student": "{id}", "stage": "{STAGE}", "label": "{label}"}}\n'
        for id, label in (("ada", NEEDLE), ("bob", "Bobby"))
    ]
    (course.submitted / ".whose.jsonl").write_text("".join(lines))
    assert len(files_containing(course, NEEDLE)) >= 7
    roster.write_text("id,last_name\nbob,Bell\n")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-e", "-c", readme_commands()],
        cwd=course.root,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    assert files_containing(course, NEEDLE) == []
    assert files_containing(course, "/ada/", "ada.html", '"ada"') == []
    with gradebook.open_gradebook(course) as book:
        assert [student.id for student in book.students] == ["bob"]
    enter_verdicts(
        course, verdicts(course), [STAGE], quiet
    )  # grading again must not restore the student
    assert b"ada" not in (course.root / "marks.jsonl").read_bytes()
    assert {notebook.student for notebook in class_results(course).notebooks} == {"bob"}
    assert (course.root / "handed_back" / "x" / "bob.html").exists()
    assert (course.autograded / "bob" / STAGE).is_dir()
    assert (course.submitted / ".whose.jsonl").read_text() == lines[1]


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
