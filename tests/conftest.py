"""What the project's own tests share."""

import os
from pathlib import Path

import pytest

from grader.course.lessons import all_lessons
from grader.sandbox import SANDBOXES, SandboxUnavailable, choose_sandbox


@pytest.fixture(scope="session")
def sandbox():
    """The sandbox to run code with: bubblewrap, or a plain process for the tests' own code."""
    try:
        return choose_sandbox()
    except SandboxUnavailable:
        return SANDBOXES["process"]


@pytest.fixture(scope="session")
def real_clouds():
    """Folder of real recordings, named by REAL_CLOUDS; tests that need it skip without."""
    folder = os.environ.get("REAL_CLOUDS")
    if not folder:
        pytest.skip("REAL_CLOUDS does not name a folder of real recordings")
    return Path(folder)


def pytest_generate_tests(metafunc):
    """Run a test that takes `lesson` once for each lesson of the course."""
    if "lesson" in metafunc.fixturenames:
        metafunc.parametrize("lesson", all_lessons(), ids=lambda lesson: lesson.name)
