"""The marks of a class for one assignment in an LMS."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from grader.course.lessons import find_lesson
from grader.course.roster import Person
from grader.lms.exporters.protocol import ExportError, ExportOptions
from grader.lms.instructor_notes import (
    counted_lesson_notes,
    excessive_mark_notes,
    outdated_mark_notes,
    unlisted_student_notes,
)
from grader.lms.results import (
    AUDITOR,
    EXCUSED,
    MARKED,
    MISSING,
    WAITING,
    ClassResults,
    NotebookResult,
)

UNMARKED_TITLES = {
    EXCUSED: "No mark for excused students",
    AUDITOR: "No mark for auditors",
    MISSING: "No mark, because nothing was submitted",
    WAITING: "No mark, because the submission is not in the gradebook yet",
}


@dataclass(frozen=True)
class Mark:
    """One student's points for an assignment.

    Attributes
    ----------
    person : grader.course.roster.Person
    points : float
        Points after the penalty for lateness.
    """

    person: Person
    points: float


@dataclass(frozen=True)
class Marks:
    """The marks of a class for an assignment, and the students without a mark.

    Attributes
    ----------
    assignment : str
        Name of a stage or lesson.
    lesson_points : dict of str to float
        Points of each lesson in the assignment.
    excluded : tuple of str
        Exercises of these lessons that do not count.
    marks : tuple of Mark
    unmarked : dict of str to tuple of grader.course.roster.Person
        Students without a mark, by status.
    failures, notes : tuple of str
        As in `ExportResult`.
    other_people : tuple of grader.course.roster.Person
        As in `ExportOptions`.
    """

    assignment: str
    lesson_points: dict[str, float]
    excluded: tuple[str, ...]
    marks: tuple[Mark, ...]
    unmarked: dict[str, tuple[Person, ...]]
    failures: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    other_people: tuple[Person, ...] = ()

    @property
    def max_points(self) -> float:
        """Maximum number of points in the assignment."""
        return sum(self.lesson_points.values())

    @property
    def people(self) -> tuple[Person, ...]:
        """All students; students with a mark come first."""
        without = (person for people in self.unmarked.values() for person in people)
        return (*(mark.person for mark in self.marks), *without, *self.other_people)


def collect_marks(options: ExportOptions) -> Marks:
    """Collect the marks to export.

    Raises
    ------
    ExportError
        If the assignment does not exist, or if a mark still waits for a grader and the options do
        not allow provisional marks.
    """
    results, assignment = options.results, options.assignment
    notebooks = [
        result for result in results.notebooks if assignment in (result.stage, result.lesson)
    ]
    if not notebooks:
        names = dict.fromkeys(
            name for result in results.notebooks for name in (result.stage, result.lesson)
        )
        raise ExportError(
            "Name the stage or lesson to export with --assignment. There are submissions "
            f"for: {', '.join(sorted(names))}."
        )
    waiting = [result for result in notebooks if result.status == WAITING]
    if waiting and not options.provisional:
        raise ExportError(_waiting_sentences(waiting))
    marks, unmarked = [], {status: [] for status in UNMARKED_TITLES}
    for person in results.people:
        status, points = _status_and_points(results, person, assignment)
        if status == MARKED or (status == WAITING and points is not None):
            marks.append(Mark(person, points))
        else:
            unmarked[status].append(person)
    lesson_points = {result.lesson: result.max_score for result in notebooks}
    excluded = [results.rules.excluded_in(find_lesson(lesson)) for lesson in lesson_points]
    return Marks(
        assignment,
        lesson_points,
        tuple(itertools.chain(*excluded)),
        tuple(marks),
        {status: tuple(people) for status, people in unmarked.items()},
        tuple(unlisted_student_notes(results)),
        tuple(filter(None, _notes(results, notebooks, marks, unmarked))),
        options.other_people,
    )


def _notes(
    results: ClassResults,
    notebooks: Sequence[NotebookResult],
    marks: Sequence[Mark],
    unmarked: dict[str, list[Person]],
) -> Iterator[str]:
    """Yield sentences about the marks and about students without a mark; some may be empty."""
    ids = {mark.person.id for mark in marks}
    own = [result for result in notebooks if result.student in ids]
    zeros = [result for result in own if result.status == MISSING]
    stage = notebooks[0].stage
    if len({result.lesson for result in notebooks}) > 1:
        yield counted_lesson_notes(results)[stage]
    yield from outdated_mark_notes(results, stage)
    yield from excessive_mark_notes(results)
    undecided = [
        result.student
        for result in results.stages
        if result.undecided and result.stage == stage and result.student in ids
    ]
    yield from provisional_notes(own)
    yield list_sentence(
        "Counted as 0, because nothing was submitted", _list_by_lesson(zeros, len(ids))
    )
    yield list_sentence("No penalty subtracted, because the submission time is unknown", undecided)
    for status, people in unmarked.items():
        yield list_sentence(UNMARKED_TITLES[status], (person.display_name for person in people))


def provisional_notes(notebooks: Sequence[NotebookResult]) -> Iterator[str]:
    """Yield sentences about marks that are not final; they may be empty."""
    waiting = [result for result in notebooks if result.status == WAITING]
    by_hand = [result for result in waiting if result.score is not None]
    not_entered = [result for result in waiting if result.score is None]
    yield list_sentence(
        "Provisional, because some work still has to be graded by hand", _list_by_lesson(by_hand)
    )
    yield list_sentence("Submitted, but not in the gradebook yet", _list_by_lesson(not_entered))


def list_sentence(title: str, names: Iterable[str]) -> str:
    """Join a title and names into one sentence; empty if there are no names."""
    names = list(names)
    return f"{title}: {'; '.join(names)}." if names else ""


def _status_and_points(
    results: ClassResults, person: Person, assignment: str
) -> tuple[str, float | None]:
    result = results.stage(person.id, assignment) or results.notebook(person.id, assignment)
    return (result.status, result.points) if result else (MISSING, None)


def _waiting_sentences(waiting: Sequence[NotebookResult]) -> str:
    """Return which marks are not final, why, and what to do."""
    incomplete = "; ".join(
        _list_by_lesson([result for result in waiting if result.score is not None])
    )
    not_entered = "; ".join(_list_by_lesson([result for result in waiting if result.score is None]))
    sentences = []
    if incomplete:
        sentences.append(
            f"Not fully graded: {incomplete}. Grade the written answers in Formgrader."
        )
    if not_entered:
        sentences.append(
            f"Not in the gradebook yet: {not_entered}. Run `python -m grader grade`, which enters "
            "these submissions or gives the reason."
        )
    return " ".join(
        [*sentences, "To export the other marks and the points so far, add --provisional."]
    )


def _list_by_lesson(notebooks: Iterable[NotebookResult], class_size: int = 0) -> list[str]:
    """List lessons, each with its students; leave out the names if they are the whole class."""
    students: dict[str, list[str]] = {}
    for result in sorted(notebooks, key=lambda result: result.lesson):
        students.setdefault(result.lesson, []).append(result.student)
    return [
        f"{lesson} for {'all students' if len(names) == class_size > 1 else ', '.join(names)}"
        for lesson, names in students.items()
    ]
