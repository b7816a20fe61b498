"""Answers that students give: right ones in many styles, wrong ones from real mistakes.

They are in ``answers/<exercise>.py`` of their lesson, one after another, each under a line such as
``# %% right: a loop in plain Python`` or ``# %% wrong: labels from 0``. A right one that does what
the lesson's hints say is called so: ``the hints followed to the letter``. A wrong one goes on with
``# loses:`` (the checks that it fails, among others; with ``# loses only:`` no others),
``# says:`` (words that the message of one of them holds) and ``# told:`` (words of the mistake
that is told; without that line, none may be told). The tests grade them all; the demo gives them
to its pretend students.
"""

import json
import re
from dataclasses import dataclass

from grader.course.lessons import Lesson
from grader.course.paths import PROJECT

ANOTHER_CELL = "# ---- another cell ----\n"


@dataclass(frozen=True)
class KeptAnswer:
    """One answer to one exercise."""

    exercise: str
    name: str
    right: bool
    source: str
    loses: tuple
    says: str
    loses_only: bool
    told: str

    @property
    def follows_hints(self) -> bool:
        """Whether it is what the lesson's own hints lead to."""
        return self.right and "the hints" in self.name


def answers_to(exercise: str) -> tuple[KeptAnswer, ...]:
    """The answers to an exercise, or to a step that nothing grades, in the order of their file."""
    (path,) = (PROJECT / "solutions").glob(f"*/*/answers/{exercise}.py")
    text = path.read_text("utf-8")
    sections = re.split(r"^# %% (right|wrong): (.+)\n", text, flags=re.M)[1:]
    return tuple(
        _kept_answer(exercise, kind == "right", name, body)
        for kind, name, body in zip(sections[::3], sections[1::3], sections[2::3], strict=True)
    )


def _kept_answer(exercise: str, right: bool, name: str, body: str) -> KeptAnswer:
    kinds = r"^# (loses only|loses|says|told): (.+)\n"
    notes, source = dict(re.findall(kinds, body, flags=re.M)), re.sub(kinds, "", body, flags=re.M)
    only = notes.get("loses only", "")
    loses = tuple(filter(None, map(str.strip, (only or notes.get("loses", "")).split(","))))
    return KeptAnswer(
        exercise,
        name.strip(),
        right,
        source.strip() + "\n",
        loses,
        notes.get("says", ""),
        bool(only),
        notes.get("told", ""),
    )


def fill_in(lesson: Lesson, answers: dict[str, str]) -> str:
    """The student's notebook with answers typed in.

    Parameters
    ----------
    lesson : grader.course.lessons.Lesson
    answers : dict of str to str
        Source by exercise; `ANOTHER_CELL` parts it into cells.

    Returns
    -------
    str
        Text of the notebook.
    """
    notebook = json.loads(lesson.released.read_text("utf-8"))
    cells = []
    for cell in notebook["cells"]:
        source = answers.get(cell["metadata"].get("nbgrader", {}).get("grade_id"))
        if source is not None:
            *before, cell["source"] = source.split(ANOTHER_CELL)
            cells += [
                {
                    "cell_type": "code",
                    "id": f"{cell['id']}-extra-{number}",
                    "metadata": {},
                    "execution_count": None,
                    "outputs": [],
                    "source": text,
                }
                for number, text in enumerate(before)
            ]
        cells.append(cell)
    return json.dumps({**notebook, "cells": cells}, indent=1) + "\n"
