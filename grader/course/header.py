"""The header of a lesson's source, which contains the settings of the lesson.

The header is YAML in comments, where jupytext stores the metadata of a notebook:

    # ---
    # jupyter:
    #   kernelspec: ...
    #   lidar_obstacle_lab:
    #     forbidden: [scipy.spatial]
    #     given: [KdTree]
    #     lent: [share_of_successes]
    # ---
"""

import re
from dataclasses import dataclass, fields
from pathlib import Path

import yaml


@dataclass(frozen=True)
class LessonHeader:
    """The settings of a lesson, all of which are optional.

    Attributes
    ----------
    forbidden : tuple of str
        Modules that students may not use, because they would solve the exercise.
    given : tuple of str
        Functions and classes that the lesson defines and that answers use. The judge uses a
        notebook's own version only if it is above the checks, and otherwise the lesson's.
    lent : tuple of str
        Functions of the lesson that call an exercise very often. Their results are stored instead
        of the exercise's answers; see `utils.lent`.
    """

    forbidden: tuple[str, ...] = ()
    given: tuple[str, ...] = ()
    lent: tuple[str, ...] = ()


def read_header(source: Path) -> LessonHeader:
    """Read the header of a lesson.

    Parameters
    ----------
    source : pathlib.Path
        The ``lesson.py`` of a lesson.

    Raises
    ------
    ValueError
        If there is no header, or if it contains an unknown setting or one that is not a list.
    """
    match = re.match(r"# ---\n((?:#.*\n)*?)# ---\n", source.read_text("utf-8"))
    if not match:
        raise ValueError(
            f"{source.parent.name}/{source.name} has no header. A header begins with a line "
            "`# ---`; see docs/authors.md."
        )
    content = yaml.safe_load(re.sub(r"^# ?", "", match[1], flags=re.M))
    settings = content["jupyter"].get("lidar_obstacle_lab", {})
    known_settings = [field.name for field in fields(LessonHeader)]
    for name, value in settings.items():
        if name not in known_settings or not isinstance(value, list):
            raise ValueError(
                f"{source.parent.name}/{source.name}: the header contains `{name}: {value}`, which "
                "is not valid below lidar_obstacle_lab. Write a list of names for one of these "
                f"settings: {', '.join(known_settings)}."
            )
    return LessonHeader(**{name: tuple(value) for name, value in settings.items()})
