"""The command `doctor` examines the machine, the course and the submissions."""

import contextlib
import sys
from importlib import metadata

import pytest

from grader.classroom import doctor, rehearsals
from grader.console import progress_bar
from grader.course.lessons import all_lessons
from grader.course.paths import Course
from tests.class_of_three import class_of_three
from tests.executors import InlineExecutor


@pytest.fixture
def course(tmp_path):
    return class_of_three(tmp_path / "course")


def test_the_doctor_shows_progress_of_the_rehearsals(course, sandbox, monkeypatch):
    """No progress bar is shown if the solutions have already been judged."""
    # Sandboxes and versions depend on the machine; other tests cover them.
    monkeypatch.setattr(doctor, "_examine_sandboxes", lambda: ())
    monkeypatch.setattr(doctor, "_examine_versions", lambda: ())
    steps, bars = [], []
    monkeypatch.setattr(rehearsals, "rehearse_one", lambda *about: ())

    @contextlib.contextmanager
    def bar(title):
        bars.append(title)
        yield lambda done, total, what: steps.append((done, total))

    for _ in range(2):
        assert all(
            finding.is_good
            for finding in doctor.examine(course, 1, sandbox, InlineExecutor(1), bar)
        )
    assert len(bars) == 1
    assert steps == [(done, 12) for done in range(13)]


def test_the_doctor_lists_problems(course, sandbox, monkeypatch):
    monkeypatch.setattr(doctor.Rehearsals, "finish", lambda *about: None)
    (course.submitted / "ada" / "lost.ipynb").write_text("{}")
    course.seed_file.write_text("1")
    course.seed_file.chmod(0o644)
    findings = list(doctor.examine(course, 1, sandbox, InlineExecutor(1), progress_bar))
    wrong = {finding.subject: finding.text for finding in findings if not finding.is_good}
    assert "lost.ipynb" in wrong["submitted"] and "chmod 600" in wrong["seed"]
    subjects = [finding.subject for finding in findings]
    for subject in ("packages", "isolation", "disk", "solutions", "sandbox bubblewrap"):
        assert subject in subjects
    python = next(finding.text for finding in findings if finding.subject == "Python")
    version = ".".join(map(str, sys.version_info[:2]))
    assert f"Students may use Python {version} or older." in python


@pytest.mark.parametrize("with_dask", [False, True])
def test_the_doctor_compares_the_version_of_an_installed_dask(monkeypatch, with_dask):
    found = {"rich": "0.1"} | dict.fromkeys(("dask", "distributed"), "0.2" if with_dask else None)

    def version(name, version=metadata.version):
        if name in found and found[name] is None:
            raise metadata.PackageNotFoundError(name)
        return found.get(name) or version(name)

    monkeypatch.setattr(doctor.metadata, "version", version)
    wrong = [finding.text for finding in doctor._examine_versions() if not finding.is_good]
    assert len(wrong) == 1 + with_dask
    assert "rich is 0.1, but should be " in wrong[0]
    assert wrong[0].endswith(". Run: pip install -r requirements.txt")
    if with_dask:
        assert (
            "dask is 0.2, but should be " in wrong[1]
            and "distributed is 0.2, but should be " in wrong[1]
        )
        assert wrong[1].endswith(". Run: pip install -r requirements-cluster.txt")


def test_the_doctor_reports_a_course_that_student_code_could_read(tmp_path, monkeypatch):
    monkeypatch.setattr(doctor, "is_shown", lambda path: path == tmp_path)
    finding = doctor._examine_boundary(Course(tmp_path))
    assert not finding.is_good and str(tmp_path) in finding.text


def test_the_doctor_checks_that_hidden_tests_cannot_be_read(monkeypatch):
    checked = []
    monkeypatch.setattr(doctor, "is_shown", lambda path: checked.append(path))
    assert doctor._examine_boundary(Course()).is_good
    for lesson in all_lessons():
        assert any(lesson.tests.is_relative_to(path) and path.is_dir() for path in checked)
