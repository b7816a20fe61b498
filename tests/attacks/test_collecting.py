"""Attacks through the names of submitted files, which students choose."""

import csv
import os
import subprocess

import pytest

from grader.classroom.collect import collection
from grader.classroom.collect.record import read_record
from grader.classroom.submissions import find_submissions, unaccounted_files
from grader.course.paths import Course
from tests.archives import (
    SIX,
    blackboard_files,
    brightspace_files,
    canvas_files,
    gradescope_files,
    ilias_files,
    make_zip,
    moodle_files,
    notebook,
    prairielearn_files,
    sakai_files,
)

STAGE = "stage3_obstacles"
TIME, WRITTEN_TIME = "2026-10-12-23-10-00", "12 October, 2026 1110 PM"
PEOPLE = (
    ("ada", "Ada", "Lovelace", "ada@x.edu", "4001"),
    ("bjorn", "Björn", "Müller", "bjorn@x.edu", "4002"),
    ("cy", "Cy", "Neil", "cy@x.edu", "4003"),
)
SUBMISSION_NUMBERS = {"Björn": 12, "Cy": 13}

# Each function returns a person's files as the platform names them in the download of a class.
PLATFORMS = {
    "Moodle": lambda id, first, last, mail, files: moodle_files(
        f"{first} {last}", SUBMISSION_NUMBERS[first], files
    ),
    "Moodle without folders": lambda id, first, last, mail, files: moodle_files(
        f"{first} {last}", SUBMISSION_NUMBERS[first], files, folders=False
    ),
    "Canvas": lambda id, first, last, mail, files: canvas_files(
        f"{last}, {first}",
        {"bjorn": 4002, "cy": 4003}[id],
        [(SUBMISSION_NUMBERS[first] * 100 + n, *file) for n, file in enumerate(files)],
    ),
    "Blackboard": lambda id, first, last, mail, files: blackboard_files(id, TIME, files),
    "Brightspace": lambda id, first, last, mail, files: brightspace_files(
        f"{first} {last}", SUBMISSION_NUMBERS[first], WRITTEN_TIME, files
    ),
    "Sakai": lambda id, first, last, mail, files: sakai_files(f"{last}, {first}", id, files),
    "Sakai without folders": lambda id, first, last, mail, files: sakai_files(
        f"{last}, {first}", id, files, folders=False
    ),
    "PrairieLearn": lambda id, first, last, mail, files: prairielearn_files(mail, 3, files),
    "ILIAS": lambda id, first, last, mail, files: ilias_files(
        last, first, id, SUBMISSION_NUMBERS[first], files
    ),
}

# Names that a platform would write for Ada. A platform removes folders from a file's name.
NAMES_FOR_ADA = {
    "Moodle": f"Ada Lovelace_5_assignsubmission_file_{SIX}{{}}.ipynb",
    "Canvas": f"lovelaceada_4001_77_{SIX}{{}}.ipynb",
    "Blackboard": f"_ada_attempt_{TIME}_{SIX}{{}}.ipynb",
    "Brightspace": f"12-34 - Ada Lovelace - {WRITTEN_TIME} - {SIX}{{}}.ipynb",
    "Sakai": f"Lovelace, Ada(ada)_Submission attachment(s)_{SIX}{{}}.ipynb",
    "PrairieLearn": f"ada@x.edu_1_lab_1_1_{SIX}{{}}.ipynb",
}


@pytest.fixture
def course(tmp_path):
    course = Course(tmp_path / "course")
    course.root.mkdir()
    with open(course.root / "roster.csv", "w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows(
            [["id", "first_name", "last_name", "email", "lms_id"], *PEOPLE],
        )
    return course


def collect(course, path):
    return collection.collect(course, [path], (STAGE,), None, {}, {}, lambda *progress: None)


def archive(course, files):
    path = course.root / "class.zip"
    path.write_bytes(make_zip(files))
    return path


@pytest.mark.parametrize("forged", NAMES_FOR_ADA)
@pytest.mark.parametrize("platform", PLATFORMS)
def test_a_file_name_in_another_platforms_style_changes_neither_owner_nor_format(
    course, platform, forged
):
    """One such name used to decide the format of a whole Canvas download.

    Ada then got Cy's notebook, and the other students' files had no owner.
    """
    _, bjorn, cy = PEOPLE
    honest, cheeky = notebook(text="by bjorn"), notebook(text="by cy")
    names = [NAMES_FOR_ADA[forged].format(suffix) for suffix in ("", " (1)")]
    in_class = PLATFORMS[platform]
    files = [
        *in_class(*bjorn[:4], [(f"{SIX}.ipynb", honest)]),
        *in_class(*cy[:4], [(name, cheeky) for name in names]),
    ]
    outcome = collect(course, archive(course, files))
    assert [archive[1] for archive in outcome.archives] == [platform.split(" ")[0]]
    assert set(outcome.states) == {"bjorn", "cy"}
    (placed,) = (course.submitted / "bjorn" / STAGE).glob("*.ipynb")
    assert placed.read_bytes() == honest


@pytest.mark.parametrize("forged", NAMES_FOR_ADA)
def test_no_file_name_in_a_gradescope_export_changes_the_owner(course, forged):
    """This holds even if there is a single submission, so that one student chose all names."""
    name = NAMES_FOR_ADA[forged].format("")
    mine = [(1, [("Cy Neil", "", "cy@x.edu")], "2026-10-12 21:10:00 Z", [(name, notebook())])]
    outcome = collect(course, archive(course, gradescope_files(mine)))
    assert set(outcome.states) == {"cy"}


@pytest.mark.parametrize("platform", ["Moodle", "Brightspace", "ILIAS"])
def test_the_only_student_in_an_archive_cannot_forge_the_gradescope_list(course, platform):
    """All files are in this student's folder, so the list looks like the platform's."""
    exported = gradescope_files(
        [(1, [("Ada", "", "ada@x.edu")], "", [(f"{SIX}.ipynb", notebook())])], root=""
    )
    files = PLATFORMS[platform](*PEOPLE[2][:4], exported)
    outcome = collect(course, archive(course, files))
    assert "ada" not in outcome.states and outcome.archives[0][1] == platform


def test_a_submodule_named_like_a_repository_belongs_to_the_student_who_added_it(course, tmp_path):
    """Git writes a file `.git` into a submodule, so it looks like a checkout."""
    for login in ("ada", "cy"):
        path = tmp_path / "hw" / f"hw-3-{login}"
        (path / ".git").mkdir(parents=True)
        (path / ".git" / "HEAD").write_text("ref")
        (path / f"{SIX}.ipynb").write_bytes(notebook(text=f"by {login}"))
    inner = tmp_path / "hw" / "hw-3-cy" / "hw-3-ada"
    inner.mkdir()
    (inner / ".git").write_text("gitdir: ../.git/modules/hw-3-ada")
    (inner / f"{SIX}.ipynb").write_bytes(notebook(text="for ada"))
    outcome = collect(course, tmp_path / "hw")
    assert "ada" in outcome.states
    (placed,) = (course.submitted / "ada" / STAGE).glob("*.ipynb")
    assert placed.read_bytes() == notebook(text="by ada")


@pytest.mark.parametrize("within", ["", "work/", "a zip"])
@pytest.mark.parametrize(
    "name", [".collected.json", "timestamp.txt", f".older/{SIX}.ipynb", "submission_secret.txt"]
)
def test_submitted_files_do_not_replace_files_of_the_grader(course, name, within):
    """The grader's own files state the time, the owner and the earlier work of a student."""
    files = [(name, b'{"files": {}, "others": "x"}'), (f"{SIX}.ipynb", notebook())]
    if within == "a zip":
        files = [("work.zip", make_zip(files))]
    else:
        files = [(f"{within}{path}", data) for path, data in files]
    collect(course, archive(course, [(f"cy/{path}", data) for path, data in files]))
    folder = course.submitted / "cy" / STAGE
    assert read_record(folder).files.keys() == {f"{SIX}.ipynb"}
    assert {path.name for path in folder.iterdir()} == {".collected.json", f"{SIX}.ipynb"}


@pytest.fixture
def make_bottomless_folder(tmp_path):
    """Return a function that nests folders deeply, and remove them, because pytest cannot."""
    made = []

    def make(path):
        made.append(path)
        path.mkdir(parents=True)
        deepest = os.open(path, os.O_RDONLY)
        for _ in range(1_500):
            os.mkdir("d", dir_fd=deepest)
            inner = os.open("d", os.O_RDONLY, dir_fd=deepest)
            os.close(deepest)
            deepest = inner
        os.close(deepest)

    yield make
    subprocess.run(["rm", "-rf", *made], check=True)


def test_a_bottomless_folder_in_a_repository_does_not_affect_other_students(
    course, tmp_path, make_bottomless_folder
):
    """Before Python 3.12, `os.walk` reaches the recursion limit."""
    for login in ("ada", "cy"):
        path = tmp_path / "hw" / f"hw-3-{login}"
        (path / ".git").mkdir(parents=True)
        (path / f"{SIX}.ipynb").write_bytes(notebook(text=f"by {login}"))
    make_bottomless_folder(tmp_path / "hw" / "hw-3-cy" / "x")
    outcome = collect(course, tmp_path / "hw")
    assert outcome.states.keys() == {"ada", "cy"}


def test_a_bottomless_folder_in_a_submission_does_not_affect_other_students(
    course, make_bottomless_folder
):
    for student in ("ada", "cy"):
        path = course.submitted / student / STAGE / f"{SIX}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_bytes(notebook(text=f"by {student}"))
    make_bottomless_folder(course.submitted / "cy" / STAGE / "x")
    assert [submission.student for submission in find_submissions(course)] == ["ada", "cy"]
    assert unaccounted_files(course) == []
