"""The marks of a class in one assignment of a learning platform."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from grader.course.roster import Person
from grader.lms.exporters.protocol import ExportTrouble, Order
from grader.lms.instructor_notes import not_on_the_roster
from grader.lms.results import EXCUSED, MARKED, MISSING, WAITING, ClassResults, NotebookResult

WITHOUT = {
    EXCUSED: "Without a mark, because they are excused",
    MISSING: "Without a mark, because they handed in nothing",
    WAITING: "Without a mark, because what they handed in is not entered yet",
}


@dataclass(frozen=True)
class Mark:
    """What one person is given.

    Attributes
    ----------
    person : grader.course.roster.Person
    points : float
        After the penalty for lateness.
    """

    person: Person
    points: float


@dataclass(frozen=True)
class Marks:
    """Who has a mark, and who has none.

    Attributes
    ----------
    assignment : str
        A stage or a lesson.
    worth : dict of str to float
        Points of each of its lessons.
    marks : tuple of Mark
    without : dict of str to tuple of grader.course.roster.Person
        Those who have no mark, by standing.
    lost, notes : tuple of str
        As in `Exported`.
    """

    assignment: str
    worth: dict[str, float]
    marks: tuple[Mark, ...]
    without: dict[str, tuple[Person, ...]]
    lost: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def most(self) -> float:
        """What the assignment is worth."""
        return sum(self.worth.values())

    @property
    def people(self) -> tuple[Person, ...]:
        """All on the roster."""
        others = (person for people in self.without.values() for person in people)
        return (*(mark.person for mark in self.marks), *others)


def marks_of(order: Order) -> Marks:
    """The marks that are to be exported.

    Raises
    ------
    ExportTrouble
        Where there is no such assignment, and where a mark waits for a person and nobody said that
        it may.
    """
    results, assignment = order.results, order.assignment
    notebooks = [one for one in results.notebooks if assignment in (one.stage, one.lesson)]
    if not notebooks:
        names = dict.fromkeys(
            name for notebook in results.notebooks for name in (notebook.stage, notebook.lesson)
        )
        raise ExportTrouble(
            f"Say with --assignment which stage or lesson these marks are of. Handed in was: "
            f"{', '.join(sorted(names))}."
        )
    waiting = [one for one in notebooks if one.standing == WAITING]
    if waiting and not order.provisional:
        raise ExportTrouble(
            f"{'; '.join(_by_lesson(waiting))}: waiting. Grade in Formgrader what a person grades, "
            "and run `python -m grader grade` for what is not entered yet; --provisional exports "
            "the points that there are so far."
        )
    marks, without = [], {standing: [] for standing in WITHOUT}
    for person in results.people:
        standing, points = _standing(results, person, assignment)
        if standing == MARKED or (standing == WAITING and points is not None):
            marks.append(Mark(person, points))
        else:
            without[standing].append(person)
    return Marks(
        assignment,
        {one.lesson: one.max_score for one in notebooks},
        tuple(marks),
        {standing: tuple(people) for standing, people in without.items()},
        tuple(not_on_the_roster(results)),
        tuple(filter(None, _notes(results, notebooks, marks, without))),
    )


def _notes(
    results: ClassResults,
    notebooks: Sequence[NotebookResult],
    marks: Sequence[Mark],
    without: dict[str, list[Person]],
) -> Iterator[str]:
    """What these marks are made of, and who has none; empty where there is nothing to say."""
    ids = {mark.person.id for mark in marks}
    mine = [notebook for notebook in notebooks if notebook.student in ids]
    waiting = [one for one in mine if one.standing == WAITING]
    zeros = [one for one in mine if one.standing == MISSING]
    stage = notebooks[0].stage
    undecided = [
        one.student
        for one in results.stages
        if one.undecided and one.stage == stage and one.student in ids
    ]
    yield listed("Provisional, with what waits for a person still to come", _by_lesson(waiting))
    yield listed("Counted as 0, because nothing was handed in", _by_lesson(zeros))
    yield listed("Nothing taken off, as whether they were late is undecided", undecided)
    for standing, people in without.items():
        yield listed(WITHOUT[standing], (person.called for person in people))


def listed(title: str, names: Iterable[str]) -> str:
    """One sentence with all names; none where there are none."""
    names = list(names)
    return f"{title}: {'; '.join(names)}." if names else ""


def _standing(results: ClassResults, person: Person, assignment: str) -> tuple[str, float | None]:
    found = results.stage(person.id, assignment) or results.notebook(person.id, assignment)
    return (found.standing, found.points) if found else (MISSING, None)


def _by_lesson(notebooks: Iterable[NotebookResult]) -> list[str]:
    students: dict[str, list[str]] = {}
    for notebook in sorted(notebooks, key=lambda one: one.lesson):
        students.setdefault(notebook.lesson, []).append(notebook.student)
    return [f"{lesson} of {', '.join(names)}" for lesson, names in students.items()]
