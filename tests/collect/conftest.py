"""Fixtures for tests that collect submissions: a course of three students, and the command."""

import csv

import pytest

from grader import cli, commands
from grader.course.paths import Course
from tests.collecting import PEOPLE, STAGE


@pytest.fixture(autouse=True)
def read_in_this_process(reading_without_fork):
    """Read the submitted files in this process, because that is faster."""


@pytest.fixture
def course(tmp_path):
    """Return an empty course with three students on its roster."""
    course = Course(tmp_path / "course")
    course.root.mkdir()
    with open(course.root / "roster.csv", "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["id", "first_name", "last_name", "email", "lms_id", "github"])
        table.writerows(PEOPLE)
    return course


@pytest.fixture
def course_without_roster(course):
    """Return the course without its roster."""
    (course.root / "roster.csv").unlink()
    return course


@pytest.fixture(params=["roster", "no roster"])
def course_with_strangers(request, course):
    """Return a course whose roster, if there is one, has no name from the archives."""
    if request.param == "no roster":
        (course.root / "roster.csv").unlink()
    return course


@pytest.fixture
def run_command(course, monkeypatch):
    """Return a function that runs the command `collect` in the course."""
    monkeypatch.setattr(commands, "Course", lambda: course)

    def run(*words):
        return cli.main(["collect", "--stage", STAGE, *map(str, words)])

    return run
