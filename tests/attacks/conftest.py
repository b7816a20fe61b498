"""Fixtures for the attacks: the attacked sandbox, and a function that submits answers."""

import json

import pytest

from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.judging.judge import judge
from grader.sandbox import Limits
from tests.attacks.attack import SANDBOX, SEED, SHORT
from tests.prerequisites import require_sandbox


@pytest.fixture(scope="session", autouse=True)
def sandbox_under_attack():
    """Return the sandbox that the attacks run in; skip all attacks if it is not available."""
    return require_sandbox(SANDBOX.name)


@pytest.fixture(scope="session")
def filter_lesson():
    """Return lesson 06, which has two short exercises worth 30 points."""
    return find_lesson("06_filter_ground")


@pytest.fixture
def submit(filter_lesson, tmp_path):
    """Return a function that judges answers to a lesson, or a notebook given as text."""

    def submit(answers=None, text=None, lesson=filter_lesson, modules=(), **limits):
        path = tmp_path / f"{lesson.name}.ipynb"
        path.write_text(fill_in(lesson, answers) if text is None else text, "utf-8")
        for name, source in dict(modules).items():
            (tmp_path / f"{name}.py").write_text(source)
        return judge(path, SEED, SANDBOX, lesson, "mallory", Limits(**{**SHORT, **limits}))

    return submit


@pytest.fixture
def verdict_text():
    """Return a function that converts a verdict to JSON text, as published."""
    return lambda verdict: json.dumps(verdict.as_dict(), ensure_ascii=False)
