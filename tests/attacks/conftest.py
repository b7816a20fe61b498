"""Attacks need a wall to run against."""

import json

import pytest

from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.judging.judge import judge
from grader.sandbox import Limits
from tests.attacks.attack import SEED, SHORT, WALLS
from tests.prerequisites import demand_walls


@pytest.fixture(scope="session", autouse=True)
def walls():
    """The sandbox for strangers' code."""
    return demand_walls(WALLS.name)


@pytest.fixture(scope="session")
def filtering():
    """Lesson 06: two short exercises, 30 points."""
    return find_lesson("06_filter_ground")


@pytest.fixture
def hand_in(filtering, tmp_path):
    """Judge answers typed into a lesson, or the whole text of a file."""

    def hand_in(answers=None, text=None, lesson=filtering, modules=(), **limits):
        path = tmp_path / f"{lesson.name}.ipynb"
        path.write_text(fill_in(lesson, answers) if text is None else text, "utf-8")
        for name, source in dict(modules).items():
            (tmp_path / f"{name}.py").write_text(source)
        return judge(path, SEED, WALLS, lesson, "mallory", Limits(**{**SHORT, **limits}))

    return hand_in


@pytest.fixture
def verdict_text():
    """All that a verdict publishes, as one text."""
    return lambda verdict: json.dumps(verdict.as_dict(), ensure_ascii=False)
