"""Write the skeleton of a new lesson: ``python -m grader new 14_free_distance``."""

from __future__ import annotations

import keyword
import re
from pathlib import Path

from grader.course.lessons import OPTIONAL_FOLDER, every_lesson
from grader.course.paths import PROJECT
from grader.errors import UserError

TEMPLATES = Path(__file__).with_name("templates")
DEFAULT_STAGE = "stage5_own"


class UnusableName(UserError):
    """A new lesson cannot have this name; `str()` says why and what to do."""


def write_skeleton(name: str, stage: str = DEFAULT_STAGE) -> list[Path]:
    """Write the files of a small lesson that builds and can be judged.

    Parameters
    ----------
    name : str
        Number and name, such as "14_free_distance". The exercise is named "free_distance".
    stage : str
        Folder of the lesson in solutions/.

    Returns
    -------
    list of pathlib.Path
        Paths of the new files.

    Raises
    ------
    UnusableName
        If the name is not valid, or if the number, the exercise or a file already exists.
    """
    match = re.fullmatch(r"(\d\d)_([a-z]\w*)", name)
    if not match:
        raise UnusableName(
            f"{name!r} is not a valid lesson name. Write two digits, _ and the name of the "
            "function, such as 14_free_distance."
        )
    if not re.fullmatch(rf"stage\w+|{OPTIONAL_FOLDER}", stage):
        raise UnusableName(
            f"{stage!r} is not a valid stage name. Begin the name with stage, such as "
            f"--stage {DEFAULT_STAGE}."
        )
    number, exercise = match.groups()
    if keyword.iskeyword(exercise):
        raise UnusableName(
            f"{exercise} is a keyword of Python, so no function can have this name. Choose another "
            "name."
        )
    _check_not_taken(number, exercise)
    folder = PROJECT / "solutions" / stage / name
    files = {
        folder / "lesson.py": "lesson.py.txt",
        folder / "hidden_tests.py": "hidden_tests.py.txt",
        folder / "answers" / f"{exercise}.txt": "answers.txt",
        PROJECT / "utils" / "checks" / f"lesson_{number}.py": "checks.py.txt",
    }
    for path in files:
        if path.exists():
            raise UnusableName(
                f"{path.relative_to(PROJECT)} already exists. Choose another number."
            )
    placeholders = {
        "NUMBER": number,
        "NAME": exercise,
        "TITLE": exercise.replace("_", " ").capitalize(),
    }
    for path, template in files.items():
        text = (TEMPLATES / template).read_text("utf-8")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(
            re.sub("|".join(placeholders), lambda word: placeholders[word[0]], text), "utf-8"
        )
    return list(files)


def _check_not_taken(number: str, exercise: str) -> None:
    for lesson in every_lesson():
        if lesson.number == number:
            free = 1 + max(int(other.number) for other in every_lesson())
            raise UnusableName(
                f"{lesson.name} already has the number {number}. Use {free}, which is free."
            )
        if f'"grade_id": "{exercise}"' in lesson.source.read_text("utf-8"):
            raise UnusableName(
                f"{lesson.name} already has an exercise {exercise}. Choose another name."
            )
