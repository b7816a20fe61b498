"""The due dates of a term and the rules for its marks.

`grader.course.deadlines_file` reads both from ``deadlines.toml``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from datetime import datetime, tzinfo

from grader.course.lessons import Lesson, all_lessons
from grader.course.roster import Person, Roster


@dataclass(frozen=True)
class DueDates:
    """The due dates of one stage or lesson.

    All dates are in UTC, because Python ignores daylight saving when it subtracts two times in
    the same zone.

    Attributes
    ----------
    due : datetime or None
        Due date of students who are not in `sections` or `students`.
    sections : dict of str to datetime
    students : dict of str to datetime
    excused : frozenset of str
        Students who do not have to submit; always empty for a lesson.
    lessons : tuple of str or None
        Names of the lessons of a stage that count; None if the file does not say.
    """

    due: datetime | None = None
    sections: dict[str, datetime] = field(default_factory=dict)
    students: dict[str, datetime] = field(default_factory=dict)
    excused: frozenset[str] = frozenset()
    lessons: tuple[str, ...] | None = None


@dataclass(frozen=True)
class TermRules:
    """Rules for the marks of a term; by default, everything counts.

    Attributes
    ----------
    excluded_exercises : frozenset of str
        Exercises that are switched off. They count neither in scores nor in maxima.
    drop_lowest : int
        Number of lessons that each student's total leaves out.
    pass_mark : float or None
        Minimum percentage of the possible points that a student needs to pass.
    """

    excluded_exercises: frozenset[str] = frozenset()
    drop_lowest: int = 0
    pass_mark: float | None = None

    def excluded_in(self, lesson: Lesson) -> tuple[str, ...]:
        """Return the exercises of a lesson that are switched off, in the lesson's order."""
        return tuple(
            exercise.name
            for exercise in lesson.exercises
            if exercise.name in self.excluded_exercises
        )


@dataclass(frozen=True)
class Deadlines:
    """The due dates of all stages and lessons, and the rules of the term.

    Attributes
    ----------
    stages : dict of str to DueDates
    roster : grader.course.roster.Roster or None
        Contains the section of each student.
    zone : tzinfo or None
        Zone of times that do not state one; None for the zone of this machine.
    lessons : dict of str to DueDates
        Lessons that have their own due dates.
    rules : TermRules
    """

    stages: dict[str, DueDates]
    roster: Roster | None = None
    zone: tzinfo | None = None
    lessons: dict[str, DueDates] = field(default_factory=dict)
    rules: TermRules = TermRules()

    def due_date(self, person: Person | str, stage: str) -> datetime | None:
        """Return the due date of a stage for a student, in UTC, or None if there is none."""
        dates = self.stages.get(stage, DueDates())
        id = person if isinstance(person, str) else person.id
        return dates.students.get(id, self._due_without_extension(id, dates))

    def lesson_due_date(
        self,
        student: str,
        stage: str,
        lesson: str,
        due_of_stage: datetime | None,
        due_in_gradebook: datetime | None = None,
    ) -> datetime | None:
        """Return the due date of a lesson for a student, in UTC, or None if there is none.

        Parameters
        ----------
        student, stage, lesson : str
        due_of_stage : datetime or None
            The student's due date for the stage, from the gradebook if that date is later. If it is
            an extension, it also applies to a lesson with its own date.
        due_in_gradebook : datetime or None
            The due date of the stage for the class, which counts if the file has none.
        """
        if lesson not in self.lessons:
            return due_of_stage
        dates = self.lessons[lesson]
        own = dates.students.get(student, self._due_without_extension(student, dates))
        regular = self._due_without_extension(student, self.stages.get(stage, DueDates()))
        regular = regular or due_in_gradebook
        has_extension = due_of_stage and regular and due_of_stage > regular
        return max(own, due_of_stage) if has_extension else own

    def lessons_with_dates(self, stage: str) -> dict[str, DueDates]:
        """Return the lessons of a stage that have their own due dates, in order."""
        names = [lesson.name for lesson in all_lessons() if lesson.stage == stage]
        return {name: self.lessons[name] for name in names if name in self.lessons}

    def to_local_time(self, time: datetime) -> datetime:
        """Convert a time to the time zone of the course."""
        return time.astimezone(self.zone)

    def is_excused(self, id: str, stage: str) -> bool:
        """Return whether a student is excused from a stage."""
        return id in self.stages.get(stage, DueDates()).excused

    def assigned_lessons(self, stage: str) -> tuple[str, ...] | None:
        """Return the names of a stage's lessons that count, or None if the file does not say."""
        return self.stages.get(stage, DueDates()).lessons

    def unassigned_lessons(self, lessons: Iterable[Lesson]) -> list[Lesson]:
        """Return the lessons that do not count, because the file lists only other lessons."""
        assigned = {lesson: self.assigned_lessons(lesson.stage) for lesson in lessons}
        return [
            lesson
            for lesson, names in assigned.items()
            if names is not None and lesson.name not in names
        ]

    def extensions(self, name: str) -> dict[str, datetime]:
        """Return the students with an extension for a stage or lesson, and their due dates."""
        dates = (self.stages | self.lessons).get(name, DueDates())
        return {
            id: due
            for id, due in dates.students.items()
            if due > self._due_without_extension(id, dates)
        }

    def _due_without_extension(self, id: str, dates: DueDates) -> datetime | None:
        person = self.roster.person(id) if self.roster else None
        return dates.sections.get(person.section, dates.due) if person else dates.due

    def descriptions(self) -> Iterator[str]:
        """Yield phrases about all settings: one for each stage, lesson and rule."""
        for name, dates in (self.stages | self.lessons).items():
            yield f"{name} {', '.join(self._dates_in_words(name, dates))}"
        if self.rules.excluded_exercises:
            names = [name for lesson in all_lessons() for name in self.rules.excluded_in(lesson)]
            yield f"exercises that do not count: {', '.join(names)}"
        if self.rules.drop_lowest:
            count = self.rules.drop_lowest
            lessons = f"{count} lowest lessons" if count > 1 else "lowest lesson"
            yield f"totals leave out each student's {lessons}"
        if self.rules.pass_mark is not None:
            yield f"pass mark {self.rules.pass_mark:g} %"

    def _dates_in_words(self, name: str, dates: DueDates) -> Iterator[str]:
        yield f"due {self._time_in_words(dates.due)}" if dates.due else "no date"
        for section, due in dates.sections.items():
            yield f"section {section} due {self._time_in_words(due)}"
        if extensions := self.extensions(name):
            yield f"{len(extensions)} with an extension"
        if dates.excused:
            yield f"{len(dates.excused)} excused"
        if dates.lessons is not None:
            yield f"lessons that count: {' '.join(name[:2] for name in dates.lessons) or 'none'}"

    def _time_in_words(self, due: datetime) -> str:
        return f"{self.to_local_time(due):%Y-%m-%d %H:%M %Z}"
