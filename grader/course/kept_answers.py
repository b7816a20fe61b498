"""Read the answers that are kept with the course: right ones, and wrong ones with real mistakes.

Each lesson has a file ``answers/<exercise>.txt`` for each exercise. An answer begins with a line
such as ``# %% right: a loop in plain Python`` or ``# %% wrong: labels from 0``. A right answer
that does exactly what the lesson's hints say is named ``the hints followed to the letter``.

Notes follow the title of a wrong answer:

- ``# loses:`` names checks that the answer fails. ``# loses only:`` names all of them.
- ``# says:`` quotes the message of a failed check.
- ``# told:`` quotes the mistake that the student sees. Without this note, the student must not see
  any mistake.

A long answer may be an edit of another answer in the same file. The note ``# like:`` contains the
title of that answer, and the changes follow. Lines that begin with ``-`` are replaced with the
lines with ``+`` below them. Lines with ``=`` stay unchanged, and mark the place of the edit. The
``-`` and ``=`` lines of an edit must occur exactly once in the other answer.

The tests grade all kept answers, and the sample class of the demo submits them.
"""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grader.course.lessons import Lesson
from grader.course.paths import PROJECT

ANOTHER_CELL = "# ---- another cell ----\n"
NOTES = ("like", "loses", "loses only", "says", "told")
_HEADING = re.compile(r"^# %% (right|wrong): (.+)\n", re.M)
_NOTE = re.compile(r"# ([a-z ]+): *(.*)\n")


class MalformedAnswers(ValueError):
    """A file of kept answers cannot be read; `str()` is the sentence to show."""


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
        """Whether the answer does exactly what the lesson's hints say."""
        return self.right and "the hints" in self.name


def answers_to(exercise: str) -> tuple[KeptAnswer, ...]:
    """Return the answers to an exercise or to an ungraded step, in the order of their file."""
    (path,) = (PROJECT / "solutions").glob(f"*/*/answers/{exercise}.txt")
    text = path.read_text("utf-8")
    for number, line in enumerate(text.splitlines(keepends=True), start=1):
        if line.startswith("# %%") and not _HEADING.match(line):
            raise MalformedAnswers(
                f"answers/{path.name}, line {number}: {line.strip()!r} is not a heading. Write "
                '"# %% right: NAME" or "# %% wrong: NAME".'
            )
    sections = _HEADING.split(text)[1:]
    bodies = {name.strip(): body for name, body in zip(sections[1::3], sections[2::3], strict=True)}
    return tuple(
        _kept_answer(exercise, kind == "right", name.strip(), body, bodies)
        for kind, name, body in zip(sections[::3], sections[1::3], sections[2::3], strict=True)
    )


def _kept_answer(
    exercise: str, right: bool, name: str, body: str, bodies: Mapping[str, str]
) -> KeptAnswer:
    notes, source = _notes_and_source(body)
    if unknown := notes.keys() - {*NOTES}:
        raise MalformedAnswers(
            f"{exercise}, {name}: there is no note {', '.join(unknown)}. The notes are: "
            f"{', '.join(NOTES)}. If this is a student's comment, leave an empty line above it."
        )
    if like := notes.get("like"):
        if like not in bodies:
            raise MalformedAnswers(f"{exercise}, {name}: there is no answer {like!r} to edit.")
        source = apply_edits(_notes_and_source(bodies[like])[1], source, f"{exercise}, {name}")
    only = notes.get("loses only", "")
    loses = tuple(filter(None, map(str.strip, (only or notes.get("loses", "")).split(","))))
    return KeptAnswer(
        exercise,
        name,
        right,
        source + "\n",
        loses,
        notes.get("says", ""),
        bool(only),
        notes.get("told", ""),
    )


def _notes_and_source(body: str) -> tuple[dict[str, str], str]:
    notes, end = {}, 0
    while note := _NOTE.match(body, end):
        notes[note[1]], end = note[2], note.end()
    return notes, body[end:].strip()


def apply_edits(source: str, edits: str, name: str) -> str:
    """Apply the edits of a kept answer to the source of another answer.

    Parameters
    ----------
    source : str
    edits : str
        Lines that begin with ``=``, ``-`` or ``+``; see the module's docstring.
    name : str
        Name of the new answer in error messages.

    Raises
    ------
    MalformedAnswers
        If the source does not contain the lines of an edit exactly once.
    """
    lines, changes = source.split("\n"), []
    for before, after in _hunks(edits):
        places = [
            start for start in range(len(lines)) if lines[start : start + len(before)] == before
        ]
        if len(places) != 1:
            raise MalformedAnswers(
                f"{name}: {before[0]!r} and the lines below it must occur exactly once in the "
                f"answer to edit, but occur {len(places)} times. If they occur more than once, "
                "add the line above, prefixed with =."
            )
        changes.append((places[0], len(before), after))
    for start, count, after in reversed(changes):
        lines[start : start + count] = after
    return "\n".join(lines)


def _hunks(edits: str) -> Iterator[tuple[list[str], list[str]]]:
    """Yield the old and the new lines of each edit."""
    before, after, is_complete = [], [], False
    for line in [*edits.split("\n"), ""]:
        mark, text = line[:1], line[2:]
        if before and (not mark or (is_complete and mark != "+")):
            yield before, after
            before, after = [], []
        is_complete = mark == "+"
        before += [text] if mark in ("=", "-") else []
        after += [text] if mark in ("=", "+") else []


def fill_in(lesson: Lesson, answers: dict[str, str]) -> str:
    """Return the student's notebook with the given answers in it.

    Parameters
    ----------
    lesson : grader.course.lessons.Lesson
    answers : dict of str to str
        Source by exercise. `ANOTHER_CELL` separates the cells of an answer.

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
