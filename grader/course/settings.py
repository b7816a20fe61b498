"""Settings of the course in ``pyproject.toml``, such as title, version and public address."""

from __future__ import annotations

import tomllib

from grader.course.paths import PROJECT


def course_settings() -> dict[str, object]:
    """Return the table ``[tool.lidar-obstacle-lab]`` in ``pyproject.toml``."""
    text = (PROJECT / "pyproject.toml").read_text("utf-8")
    return tomllib.loads(text)["tool"]["lidar-obstacle-lab"]


def course_title() -> str:
    """Return the title of the course."""
    return course_settings().get("title", "Course")


def version() -> str:
    """Return the version of the course, such as "1.0.0"."""
    return course_settings().get("version", "0")


def stage_title(stage: str) -> str:
    """Return the title of a stage. The default is its name without the number."""
    name = stage.removeprefix("stage").lstrip("0123456789").strip("_").replace("_", " ")
    return course_settings().get("stages", {}).get(stage, name)


def minutes_of_calls() -> dict[str, float]:
    """Return how many minutes longer a cell takes if it calls a function, by function name."""
    return course_settings().get("minutes", {})
