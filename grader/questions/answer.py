"""Read a student's answer to one exercise in the sandbox, and observe what it does.

The sandbox's replies are untrusted. A line that is not in the notebook, or a value that is not
plain data, is left out. Nothing in this module affects a mark.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from grader.course.lessons import Lesson
from grader.intake.preflight import cells_as_released
from grader.judging.judge import program_for
from grader.sandbox import Limits, Sandbox
from grader.sandbox.failures import StudentStopped
from grader.sandbox.program import Program
from grader.sandbox.student import StudentProxy
from utils.questions.cases import Case, cases_of
from utils.questions.changed_lines import as_written, is_plausible, is_readable
from utils.questions.choices import in_rounds
from utils.questions.texts import outcome_text, outcome_texts, same_answer, value_text

OBSERVER = Path(__file__).parent / "inside" / "answer_observer.py"
TASKS = ("read_answer", "run_cases", "evaluate", "trace_case")
MAX_EDITS = 150
# Fewer edits of a slow answer are tried, so that its questions take a few seconds. This is the
# largest number of edits times the number of function calls in all cases. Unlike seconds, it leads
# to the same questions on every machine.
MAX_CALLS = 3_500_000
MAX_LISTING = 150  # lines of an answer that fit on two pages
# Functions of `numpy.linalg` with results that students cannot compute on paper.
DECOMPOSITION = re.compile(r"\b(svd|eigh?)\b")
# Constructs whose code may run several times each time their line runs.
LOOPS = frozenset(
    ["a lambda function", "a generator expression"]
    + ["a list comprehension", "a set comprehension", "a dict comprehension"]
)
MAX_WATCHED = 6  # variables whose values in a case are compared between versions
# Versions that are run with one request. If a request takes too long, its versions are left out.
VERSIONS_PER_REQUEST = 10
LIMITS = Limits(call_seconds=3.0)
# No further versions are run after these processor seconds. Usually their number is the limit, so
# that the questions are the same on every machine.
MAX_CPU_SECONDS = 12.0


@dataclass(frozen=True)
class Answer:
    """The code of a student's notebook, and the exercise that the questions are about.

    Attributes
    ----------
    lesson : grader.course.lessons.Lesson
    exercise : str
    cells : tuple of str
        Source of each code cell.
    modules : dict of str to str
        Source of the modules that were submitted with the notebook.
    """

    lesson: Lesson
    exercise: str
    cells: tuple[str, ...]
    modules: dict[str, str]

    @property
    def program(self) -> Program:
        """The notebook's program, with the functions of the observer added."""
        program = program_for(
            self.lesson,
            (*self.cells, f"from {OBSERVER.stem} import {', '.join(TASKS)}"),
            {**self.modules, OBSERVER.stem: _observer_source()},
        )
        return replace(program, names=(*program.names, *TASKS))

    @property
    def request(self) -> tuple[list, str, list, list, list]:
        """The arguments of the observer's `read_answer`."""
        released = {cell.source.strip() for cell in cells_as_released(self.lesson)}
        others = {exercise.name for exercise in self.lesson.machine_graded} - {self.exercise}
        unchanged = [
            number for number, cell in enumerate(self.cells, start=1) if cell.strip() in released
        ]
        given = list(self.lesson.header.given)
        return list(self.cells), self.exercise, given, sorted(others), unchanged


@functools.cache
def _observer_source() -> str:
    return OBSERVER.read_text("utf-8")


@dataclass(frozen=True)
class ListedLine:
    """A line of the answer as it is printed, with its place in the notebook."""

    number: int
    cell: int
    line: int
    text: str


@dataclass(frozen=True)
class Statement:
    """A simple statement, such as an assignment, that shares its lines with no other statement.

    Attributes
    ----------
    first, last : int
        Numbers of its listed lines.
    names : tuple of str
        Variables that it may change.
    """

    first: int
    last: int
    names: tuple[str, ...]


@dataclass(frozen=True)
class Edit:
    """A change of the answer.

    Attributes
    ----------
    first, last : int
        Numbers of the listed lines that it replaces.
    before, after : str
        Text of these lines, and their new text.
    row : tuple
        The edit for the observer: cell, first line, last line, text.
    """

    first: int
    last: int
    before: str
    after: str
    row: tuple[int, int, int, str]

    @functools.cached_property
    def shown(self) -> str:
        """The new text as questions show it."""
        return as_written(self.before, self.after).strip()

    @property
    def is_plausible(self) -> bool:
        """Whether a person might write the new text."""
        return is_plausible(self.before, self.after)

    @property
    def can_be_shown(self) -> bool:
        """Whether the edit replaces one line with one other line that a person might write."""
        return self.first == self.last and is_readable(self.before, self.shown)


@dataclass(frozen=True)
class Run:
    """What one version of the answer does in one case.

    Attributes
    ----------
    outcome : str
        Text of the value or error; empty if it is not suitable for a question.
    counts : dict of int to int
        How often each listed line runs.
    notes : tuple of (int, str, str)
        Line, variable and value after each statement that changes a variable.
    calls : int
        Number of functions that were called; 0 for an edited version.
    """

    outcome: str = ""
    counts: dict[int, int] = None
    notes: tuple[tuple[int, str, str], ...] = ()
    calls: int = 0

    def values(self, line: int, name: str) -> list[str]:
        """Return the values of a variable after each run of a line."""
        return [text for at, which, text in self.notes if (at, which) == (line, name)]


@dataclass(frozen=True)
class Behaviour:
    """What is known about an answer and its edited versions.

    Attributes
    ----------
    answer : Answer
    lines : tuple of ListedLine
    statements : tuple of Statement
    words : tuple of (int, str, str)
        Line, kind and text of library names and constructs.
    cases : tuple of Case
    own : tuple of Run
        What the student's own version does: one run per case, followed by one run per larger case.
    edited, deleted : dict of Edit to tuple of Run
        What the version after an edit, or without a statement, does.
    peers : tuple of (tuple of str)
        Outcomes of other right answers.
    """

    answer: Answer
    lines: tuple[ListedLine, ...]
    statements: tuple[Statement, ...]
    words: tuple[tuple[int, str, str], ...]
    cases: tuple[Case, ...]
    own: tuple[Run, ...]
    edited: dict[Edit, tuple[Run, ...]]
    deleted: dict[Edit, tuple[Run, ...]]
    peers: tuple[tuple[str, ...], ...] = ()

    def text_of(self, line: int) -> str:
        """Return the text of a listed line."""
        return self.lines[line - 1].text

    def decomposes(self, statement: Statement) -> bool:
        """Return whether a statement computes singular values or eigenvectors."""
        lines = range(statement.first, statement.last + 1)
        return any(DECOMPOSITION.search(self.text_of(line)) for line in lines)

    def loops(self, statement: Statement) -> bool:
        """Return whether a part of a statement may run several times each time the line runs."""
        lines = range(statement.first, statement.last + 1)
        return any(line in lines and word in LOOPS for line, _, word in self.words)

    def edited_outcomes(self, case: int) -> Iterator[str]:
        """Yield the outcome of each edited version in a case, the likeliest edits first."""
        for runs in self.edited.values():
            if case < len(runs):
                yield runs[case].outcome

    def matches_peers(self, case: int) -> bool:
        """Return whether all known right answers have this outcome in a case; False without any."""
        own = self.own[case].outcome
        return bool(self.peers) and all(same_answer(peer[case], own) for peer in self.peers)


def observe(answer: Answer, sandbox: Sandbox, peers: tuple[tuple[str, ...], ...] = ()) -> Behaviour:
    """Read an answer and run all its versions.

    Parameters
    ----------
    answer : Answer
    sandbox : grader.sandbox.Sandbox
    peers : tuple of (tuple of str)
        Outcomes of other right answers, from `outcomes_of`.

    Raises
    ------
    grader.sandbox.failures.StudentError, grader.sandbox.failures.StudentStopped
        If the notebook does not answer.
    grader.sandbox.SandboxUnavailable
    """
    cases = cases_of(answer.exercise)
    codes = case_codes(cases)
    with StudentProxy(answer.program, sandbox, LIMITS) as student:
        description = _as_dict(student.read_answer(*answer.request))
        lines = _listing(answer, description.get("places"))
        number_of = {(line.cell, line.line): line.number for line in lines}
        (own,) = _runs(student.run_cases([None], codes, []), number_of) or [()]
        own = (*own, *[Run(counts={})] * (len(codes) - len(own)))
        edits = _edits(lines, number_of, description.get("edits"))
        count = min(MAX_EDITS, MAX_CALLS // max(sum(run.calls for run in own), 1))
        edits = in_rounds(edit for edit in edits if edit.is_plausible)[:count]
        deletions = _edits(lines, number_of, description.get("deletions"))
        watched = list(_watched(own, lines))
        versions = [*deletions, *edits]
        by_edit: dict[Edit, tuple[Run, ...]] = {}
        for start in range(0, len(versions), VERSIONS_PER_REQUEST):
            if student.cpu_seconds > MAX_CPU_SECONDS:
                break
            part = versions[start : start + VERSIONS_PER_REQUEST]
            rows = [list(edit.row) for edit in part]
            # A separate name, so that versions that hang do not shorten the time of the next call.
            student.exercise = f"versions from {start}"
            try:
                runs = _runs(student.run_cases(rows, codes, watched), number_of)
            except StudentStopped as stopped:
                if not stopped.out_of_time:
                    raise
                student.exercise = ""
                student.read_answer(*answer.request)  # in a new process
                continue
            by_edit |= {edit: run for edit, run in zip(part, runs, strict=False) if run}
    return Behaviour(
        answer,
        lines,
        tuple(_statements(number_of, description.get("statements"))),
        tuple(_words(number_of, description.get("words"))),
        cases,
        own,
        {edit: by_edit[edit] for edit in edits if edit in by_edit},
        {edit: by_edit[edit] for edit in deletions if edit in by_edit},
        peers,
    )


def case_codes(cases: Sequence[Case]) -> list[str]:
    """Return the code of each case, followed by the code of each larger case."""
    return [case.executed for case in cases] + [case.larger for case in cases if case.larger]


def outcomes_of(answer: Answer, sandbox: Sandbox) -> tuple[str, ...]:
    """Return the outcome of each case of an answer, without any changes."""
    codes = case_codes(cases_of(answer.exercise))
    with StudentProxy(answer.program, sandbox) as student:
        student.read_answer(*answer.request)
        return tuple((outcome_texts(student.evaluate(None, code)) or [""])[0] for code in codes)


# ---- untrusted replies ---------------------------------------------------------------------------


def _as_dict(reply: object) -> dict:
    return reply if isinstance(reply, dict) else {}


def _rows(reply: object, *kinds: type) -> Iterator[list]:
    """Yield the rows of an untrusted table that have the expected types."""
    for row in reply if isinstance(reply, list) else ():
        if isinstance(row, list) and [*map(type, row)] == [*kinds]:
            yield row


def _listing(answer: Answer, places: object) -> tuple[ListedLine, ...]:
    """Return the lines of the answer's statements, in the order of the notebook."""
    found = []
    for cell, first, last in sorted(_rows(places, int, int, int)):
        if 0 < cell <= len(answer.cells):
            lines = answer.cells[cell - 1].split("\n")
            for line in range(max(first, 1), min(last, len(lines)) + 1):
                found.append((cell, line, lines[line - 1].rstrip()))
    unique = list(dict.fromkeys(found))[:MAX_LISTING]
    return tuple(ListedLine(number, *row) for number, row in enumerate(unique, start=1))


def _edits(
    lines: tuple[ListedLine, ...], number_of: dict[tuple[int, int], int], table: object
) -> list[Edit]:
    found = []
    for cell, first, last, text in _rows(table, int, int, int, str):
        numbers = [number_of.get((cell, line)) for line in (first, last)]
        if all(numbers) and numbers[1] - numbers[0] == last - first >= 0:
            before = "\n".join(line.text for line in lines[numbers[0] - 1 : numbers[1]])
            found.append(Edit(*numbers, before, text, (cell, first, last, text)))
    return list(dict.fromkeys(found))


def _statements(number_of: dict[tuple[int, int], int], table: object) -> Iterator[Statement]:
    for cell, first, last, names in _rows(table, int, int, int, list):
        numbers = [number_of.get((cell, line)) for line in (first, last)]
        if all(numbers):
            yield Statement(*numbers, tuple(name for name in names if _is_name(name)))


def _words(number_of: dict[tuple[int, int], int], table: object) -> Iterator[tuple]:
    for cell, line, kind, word in _rows(table, int, int, str, str):
        if (cell, line) in number_of and kind in ("name", "construct"):
            yield number_of[cell, line], kind, word[:60]


def _is_name(value: object) -> bool:
    return isinstance(value, str) and value.isidentifier() and len(value) < 60


def _runs(reply: object, number_of: dict[tuple[int, int], int]) -> list[tuple[Run, ...]]:
    """Return the runs of each version; an empty tuple for a version that is not valid."""
    return [
        tuple(_run(_as_dict(run), number_of) for run in runs) if isinstance(runs, list) else ()
        for runs in (reply if isinstance(reply, list) else ())
    ]


def _run(reply: dict, number_of: dict[tuple[int, int], int]) -> Run:
    counts = {
        number_of[cell, line]: count
        for cell, line, count in _rows(reply.get("counts"), int, int, int)
        if (cell, line) in number_of
    }
    notes = tuple(
        (number_of[row[0], row[1]], row[2], value_text(row[3]))
        for row in (reply.get("notes") if isinstance(reply.get("notes"), list) else ())
        if isinstance(row, list)
        and len(row) == 4
        and isinstance(row[0], int)
        and isinstance(row[1], int)
        and (row[0], row[1]) in number_of
        and _is_name(row[2])
    )
    calls = reply.get("calls")
    return Run(
        outcome_text(reply.get("outcome")), counts, notes, calls if isinstance(calls, int) else 0
    )


def _watched(own: Sequence[Run], lines: tuple[ListedLine, ...]) -> Iterator[list]:
    """Yield the variables to watch: in each case, the first few with a value to ask about."""
    for case, run in enumerate(own):
        pairs = dict.fromkeys((line, name) for line, name, text in run.notes if text)
        for line, name in list(pairs)[:MAX_WATCHED]:
            yield [case, lines[line - 1].cell, lines[line - 1].line, name]
