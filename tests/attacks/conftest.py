"""Fixtures of the attacks: the sandbox under attack and a way to submit answers."""

import json

import pytest

from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.judging.judge import judge
from grader.sandbox import Limits
from tests.attacks.attack import SEED, SHORT, WALLS
from tests.prerequisites import demand_sandbox


@pytest.fixture(scope="session", autouse=True)
def walls():
    """Return the sandbox that the attacks run in, or skip them all without one."""
    return demand_sandbox(WALLS.name)


@pytest.fixture(scope="session")
def filtering():
    """Return lesson 06, which has two short exercises worth 30 points."""
    return find_lesson("06_filter_ground")


@pytest.fixture
def hand_in(filtering, tmp_path):
    """Return a function that judges answers to a lesson, or the whole text of a file."""

    def hand_in(answers=None, text=None, lesson=filtering, modules=(), **limits):
        path = tmp_path / f"{lesson.name}.ipynb"
        path.write_text(fill_in(lesson, answers) if text is None else text, "utf-8")
        for name, source in dict(modules).items():
            (tmp_path / f"{name}.py").write_text(source)
        return judge(path, SEED, WALLS, lesson, "mallory", Limits(**{**SHORT, **limits}))

    return hand_in


@pytest.fixture
def verdict_text():
    """Return a function that turns everything a verdict publishes into one text."""
    return lambda verdict: json.dumps(verdict.as_dict(), ensure_ascii=False)
