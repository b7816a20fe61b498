"""What became of everything that was to be collected."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from grader.course.lessons import Lesson
from grader.course.roster import Roster

ASKED = "?"


@dataclass(frozen=True)
class Question:
    """What waits for somebody.

    Attributes
    ----------
    name : str
        Of a file, or of whoever handed it in.
    text : str
        What is the matter, and what to do; goes on where `name` ends.
    """

    name: str
    text: str


@dataclass
class CollectionReport:
    """What became of everything.

    Attributes
    ----------
    lessons : list of Lesson
        That could be handed in.
    archives : list of (pathlib.Path, str, int)
        With the kind of each, and how many files are in it.
    roster : Roster or None
    states : dict of str to (dict of Lesson to str)
        By student: "new", "newer", "same", "kept", or "?" where a question has to be answered.
    questions, remarks : list of Question
        What has to be answered, and what only shall be known.
    left : collections.Counter
        Names of files that no lesson needs.
    late : list of str
        Students whose work the learning platform marks late, and of whom no time is known.
    undecided : dict of str to str
        By student, why nobody knows when the work was handed in.
    excused : list of str
        Who is on the roster, and excused from all that could be handed in.
    """

    lessons: list[Lesson]
    archives: list[tuple[Path, str, int]] = field(default_factory=list)
    roster: Roster | None = None
    states: dict[str, dict[Lesson, str]] = field(default_factory=dict)
    questions: list[Question] = field(default_factory=list)
    remarks: list[Question] = field(default_factory=list)
    left: Counter = field(default_factory=Counter)
    late: list[str] = field(default_factory=list)
    undecided: dict[str, str] = field(default_factory=dict)
    excused: list[str] = field(default_factory=list)

    def ask(self, name: str, text: str) -> None:
        """Ask something; of a team's file only once."""
        question = Question(name, text)
        if question not in self.questions:
            self.questions.append(question)
