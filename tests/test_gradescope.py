"""The autograder that is exported for Gradescope reports the right marks."""

import dataclasses
import io
import json
import os
import shutil
import stat
import subprocess
import sys
import zipfile

import pytest

from grader.classroom.submissions import find_submissions
from grader.course.paths import Course
from grader.course.roster import Person
from grader.judging.verdict import CheckResult, ExerciseResult, Verdict, write_verdict
from grader.lms.exporters.gradescope import export_gradescope
from grader.lms.exporters.protocol import ExportOptions
from grader.lms.results import MARKED, MISSING, ClassResults, NotebookResult, StageResult

STAGE, SIX, SEVEN = "stage3_obstacles", "06_filter_ground", "07_filter_by_distance"
ANNA = Person("anna", "Anna", "Schmidt", "Anna@x.edu")
BO = Person("bo", "Bo", "", "bo@x.edu")
VISIBLE = {"hidden", "after_due_date", "after_published", "visible"}


@pytest.fixture
def course(tmp_path):
    """Return a course with the verdicts on two students' notebooks."""
    course = Course(tmp_path / "course")
    for student in ("anna", "bo"):
        folder = course.submitted / student / STAGE
        folder.mkdir(parents=True)
        (folder / f"{SIX}.ipynb").write_text(f'{{"of": "{student}"}}')
        (folder / "mine.py").write_text("x = 1")
    judge(course)
    return course


def judge(course):
    checks = (
        CheckResult("a", "A road is ground", False, 0.0, 10.0, "Yours: 1\nExpected: 2", True),
        CheckResult("b", "A hidden road", False, 0.0, 10.0, "A wall is not a road.", False),
        CheckResult("c", "Nothing changes", True, 10.0, 10.0, "", True),
    )
    exercise = ExerciseResult("filter_ground", 10.0, 30.0, checks)
    for submission in find_submissions(course):
        fingerprint = submission.read(course).fingerprint()
        verdict = Verdict(
            SIX, submission.student, "judged", 10.0, 30.0, (exercise,), ("A cell moved.",), 1, "k"
        )
        write_verdict(
            dataclasses.replace(verdict, fingerprint=fingerprint),
            submission.verdict_path(course),
        )


def results(people=(ANNA, BO), score=15.0, penalty=2.5):
    notebooks, stages = [], []
    for person in people:
        notebooks.append(NotebookResult(person.id, STAGE, SIX, MARKED, score, 30.0, penalty))
        notebooks.append(NotebookResult(person.id, STAGE, SEVEN, MISSING, None, 20.0))
        stages.append(StageResult(person.id, STAGE, MARKED, score, 50.0, penalty))
    return ClassResults(tuple(people), tuple(notebooks), tuple(stages))


def write(course, people=(ANNA, BO), **settings):
    return export_gradescope(ExportOptions(course, results(people, **settings), STAGE))


@pytest.fixture
def run(tmp_path, course):
    """Return a function that runs an exported autograder on a student's folder.

    The function returns the results that Gradescope reads, or the autograder's error message.
    """

    def run_autograder(exported, student, email):
        root = tmp_path / "autograder"
        shutil.rmtree(root, ignore_errors=True)
        with zipfile.ZipFile(io.BytesIO(exported.content)) as archive:
            archive.extractall(root / "source")
            modes = {member.filename: member.external_attr >> 16 for member in archive.infolist()}
        assert modes["setup.sh"] & modes["run_autograder"] & stat.S_IXUSR
        shutil.copytree(course.submitted / student / STAGE, root / "submission")
        (root / "submission" / "__MACOSX").mkdir()
        (root / "submission" / "__MACOSX" / f"._{SIX}.ipynb").write_bytes(b"\0")
        users = [{"email": part, "id": 1, "name": "N"} for part in email.split()]
        (root / "submission_metadata.json").write_text(json.dumps({"users": users}))
        script = (root / "source" / "run_autograder").read_text()
        assert script.startswith("#!/usr/bin/env python3\n")
        # Gradescope runs the script in /autograder; only the path differs here.
        script = script.replace('Path("/autograder")', f"Path({str(root)!r})")
        process = subprocess.run(
            [sys.executable, "-I", "-c", script], cwd=root, capture_output=True, text=True
        )
        path = root / "results" / "results.json"
        assert path.exists() == (process.returncode == 0), process.stderr
        return json.loads(path.read_text()) if path.exists() else process.stderr

    return run_autograder


def test_a_submission_gets_its_marks(course, run):
    exported = write(course)
    assert (exported.mark_count, exported.failures) == (2, ())
    result = run(exported, "anna", "anna@X.edu")
    assert result["score"] == 12.5 and result["visibility"] in VISIBLE
    assert result["output"] == (
        f"{SIX}: 15 of 30 points\n{SEVEN}: 0 of 20 points\nPoints subtracted for lateness: 2.5"
    )
    six, seven = result["tests"]
    assert (six["name"], six["score"], six["max_score"]) == (SIX, 15.0, 30.0)
    assert six["output"].splitlines() == [
        "A cell moved.",
        "filter_ground: 10 of 30 points",
        "  FAILED  A road is ground",
        "          Yours: 1",
        "          Expected: 2",
        "  FAILED  A hidden road",
        "Points given by a grader: +5",
    ]
    assert (seven["score"], seven["output"]) == (0.0, "Nothing was submitted.")
    assert all(test["visibility"] in VISIBLE for test in result["tests"])


def test_the_export_is_reproducible(course):
    assert write(course).content == write(course).content


@pytest.mark.parametrize("change", ["other", "new", "module", "empty"])
def test_a_submission_changed_after_judging_gets_no_mark(course, run, change):
    exported = write(course)
    folder = course.submitted / "anna" / STAGE
    if change == "other":
        (folder / f"{SIX}.ipynb").write_text('{"of": "anna, again"}')
    elif change == "new":
        (folder / f"{SEVEN}.ipynb").write_text("{}")
    elif change == "module":
        (folder / "mine.py").write_text("x = 2")
    else:
        (folder / f"{SIX}.ipynb").unlink()
    assert "not the one that was judged" in run(exported, "anna", "anna@x.edu")


def test_no_student_gets_the_mark_of_another_student(course, run):
    exported = write(course)
    assert "not the one that was judged" in run(exported, "anna", "bo@x.edu")
    assert "There is no mark for cy@x.edu" in run(exported, "anna", "cy@x.edu")


def test_a_team_gets_the_mark_of_the_member_whose_work_it_submits(course, run):
    assert run(write(course), "bo", "cy@x.edu bo@x.edu")["score"] == 12.5


def test_different_marks_of_team_members_are_an_error(course, run):
    folders = [course.submitted / student / STAGE for student in ("anna", "bo")]
    shutil.copytree(*folders, dirs_exist_ok=True)
    judge(course)
    exported = write(course)
    assert run(exported, "bo", "anna@x.edu bo@x.edu")["score"] == 12.5
    anna, bo = results((ANNA,)), results((BO,), score=20.0)
    both = (getattr(anna, kind) + getattr(bo, kind) for kind in ("people", "notebooks", "stages"))
    differing = export_gradescope(ExportOptions(course, ClassResults(*both), STAGE))
    assert "submitted together but have different marks" in run(
        differing, "bo", "anna@x.edu bo@x.edu"
    )


def test_two_students_with_one_address_are_reported_and_get_no_mark(course):
    twin = dataclasses.replace(BO, email=" anna@X.edu")
    exported = write(course, (ANNA, twin))
    assert exported.mark_count == 0
    assert [sentence.partition(" ")[0] for sentence in exported.failures] == ["anna", "bo"]
    assert all("anna@x.edu also belongs to another" in sentence for sentence in exported.failures)


def test_marks_that_cannot_be_exported_are_listed(course):
    without_email = Person("anna", "Anna", "Schmidt")
    (lost,) = write(course, (without_email, BO)).failures
    assert lost == (
        "anna (Anna Schmidt), 12.5 points: Gradescope identifies students by e-mail, but the "
        "roster has no address for this student."
    )
    (course.submitted / "anna" / STAGE / f"{SIX}.ipynb").write_text("{}")
    (lost,) = write(course).failures
    assert "was replaced after it was judged" in lost
    os.remove(course.submitted / "anna" / STAGE / f"{SIX}.ipynb")
    assert "no longer in submitted/" in write(course).failures[0]
    shutil.rmtree(course.verdicts / "bo")
    assert "there is no verdict" in write(course).failures[1]
