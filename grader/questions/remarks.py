"""Find names and constructs in an answer that no lesson has shown yet, so an examiner can ask.

They do not prove anything, because students also know other courses, books and manuals.
"""

from __future__ import annotations

import ast
import functools
import json
import re
from dataclasses import dataclass

from grader.course.lessons import Lesson, all_lessons
from grader.questions.answer import Behaviour

MAX_REMARKS = 6


@dataclass(frozen=True)
class Remark:
    """A name or construct that the lessons have not shown, and the lines that contain it."""

    lines: tuple[int, ...]
    text: str


def remarks_on(behaviour: Behaviour) -> tuple[Remark, ...]:
    """Return the names and constructs in an answer that no lesson up to its own has shown."""
    shown = _shown_words(behaviour.answer.lesson)
    own = {word for line in behaviour.lines for word in re.findall(r"def (\w+)", line.text)}
    lines: dict[str, list[int]] = {}
    for line, kind, word in behaviour.words:
        is_shown = word in shown[kind] or word in own
        if not is_shown:
            text = word if kind == "construct" else f"`{word}`"
            lines.setdefault(text, []).append(line)
    remarks = [Remark(tuple(dict.fromkeys(numbers)), text) for text, numbers in lines.items()]
    return tuple(remarks[:MAX_REMARKS])


@functools.cache
def _shown_words(lesson: Lesson) -> dict[str, frozenset[str]]:
    """Return the names and constructs in all lessons up to this one.

    Solved notebooks are included, because the hints lead to the solutions.
    """
    names, constructs = set(), set()
    lessons = all_lessons()
    for earlier in lessons[: lessons.index(lesson) + 1]:
        for path in (earlier.released, earlier.solved):
            for cell in json.loads(path.read_text("utf-8"))["cells"]:
                source = "".join(cell["source"])
                names.update(re.findall(r"\w+(?:\.\w+)*", source), re.findall(r"\w+", source))
                if cell["cell_type"] == "code":
                    constructs |= _constructs_in(source)
    return {"name": frozenset(names), "construct": frozenset(constructs)}


def _constructs_in(source: str) -> set[str]:
    """Return the constructs in a code cell of the course, in the observer's words."""
    from grader.questions.inside.answer_observer import constructs_of

    try:
        return set(constructs_of(ast.parse(source)))
    except SyntaxError:  # the cell contains an IPython magic
        return set()
