"""The report on collecting: the results for each student, and open questions."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from grader.course.lessons import Lesson
from grader.course.roster import Roster

UNANSWERED_MARK = "?"


@dataclass(frozen=True)
class Question:
    """A question for the instructor.

    Attributes
    ----------
    name : str
        Name of a file or of its owner.
    text : str
        The problem and what to do: the rest of a sentence that begins with `name`.
    """

    name: str
    text: str


@dataclass
class CollectionReport:
    """The result of collecting.

    Attributes
    ----------
    lessons : list of Lesson
        Lessons of the collected stages.
    archives : list of (pathlib.Path, str, int)
        Each archive with its kind and number of files.
    roster : Roster or None
    states : dict of str to (dict of Lesson to str)
        For each student, the state of each lesson: "new", "newer", "same", "kept", or "?" if there
        is a question.
    questions : list of Question
        Questions about files that are collected only after an answer.
    doubts : list of Question
        Questions about the owners of files that were collected.
    remarks : list of Question
        Remarks that need no answer.
    ignored : collections.Counter
        The names of files that no lesson needs, each with its count.
    late_students : list of str
        Students whose work the learning platform marked late without a submission time.
    students_with_time : list of str, or None
        Students whose submission times are in the table; None without a table.
    undecided : dict of str to str
        For each student, why the submission time is unknown.
    ignored_files : set of (str, str)
        Name and SHA-256 of notebooks and modules that an answer ignores.
    excused_students : list of str
        Students on the roster who are excused from all collected stages.
    earlier_students : list of str
        Students whose notebooks of these stages were collected before.
    """

    lessons: list[Lesson]
    archives: list[tuple[Path, str, int]] = field(default_factory=list)
    roster: Roster | None = None
    states: dict[str, dict[Lesson, str]] = field(default_factory=dict)
    questions: list[Question] = field(default_factory=list)
    doubts: list[Question] = field(default_factory=list)
    remarks: list[Question] = field(default_factory=list)
    ignored: Counter = field(default_factory=Counter)
    late_students: list[str] = field(default_factory=list)
    students_with_time: list[str] | None = None
    undecided: dict[str, str] = field(default_factory=dict)
    ignored_files: set[tuple[str, str]] = field(default_factory=set)
    excused_students: list[str] = field(default_factory=list)
    earlier_students: list[str] = field(default_factory=list)

    def add_question(self, name: str, text: str) -> None:
        """Add a question once, even if a team's file raises it for each member."""
        question = Question(name, text)
        if question not in self.questions:
            self.questions.append(question)
