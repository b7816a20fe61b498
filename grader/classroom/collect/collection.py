"""Copy submissions from archives into ``submitted/``; ask if the owner is unknown."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from grader.classroom.collect import open_all
from grader.classroom.collect.answers import Answers, read_answers, remember, same
from grader.classroom.collect.inspection import OTHER, kind_of
from grader.classroom.collect.outcome import CollectionReport, Question
from grader.classroom.collect.owners import Owners, UnknownOwner
from grader.classroom.collect.protocol import Owner, SubmittedFile
from grader.classroom.collect.student import StudentCollector
from grader.classroom.collect.worksheet import SubmissionRow, SubmissionTable, read_worksheet
from grader.classroom.submissions import Submission, find_submissions
from grader.course.deadlines import Deadlines, read_deadlines
from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import Course
from grader.course.roster import Roster, read_roster

Place = tuple[Path, SubmittedFile]
"""What somebody handed in, and the archive that it is in."""


def collect(
    course: Course,
    paths: Sequence[Path],
    stages: Sequence[str],
    timestamps: Path | None,
    who: dict[str, str],
    lessons: dict[str, str],
    progress: Callable[[int, int, object], None],
) -> CollectionReport:
    """Collect what a class handed in.

    Parameters
    ----------
    course : grader.course.paths.Course
    paths : sequence of pathlib.Path
        Archives.
    stages : sequence of str
    timestamps : pathlib.Path or None
        A table of submission times.
    who, lessons : dict of str to str
        Answers to questions, as they were typed.
    progress : callable
        Called with (done, total, None) after each student.

    Raises
    ------
    CollectError, grader.course.roster.RosterError, grader.course.deadlines.DeadlinesError
    """
    roster = read_roster(course)
    deadlines = read_deadlines(course)
    zone = deadlines.zone if deadlines else None
    worksheet = read_worksheet(timestamps, zone) if timestamps else SubmissionTable()
    answers = read_answers(course, roster, stages, who, lessons)
    owners = Owners(roster, worksheet, answers.who)
    opened = [
        (path, kind, _as_one_student(path, handed, owners))
        for path, kind, handed in open_all(paths)
    ]
    outcome = CollectionReport(
        [lesson for lesson in all_lessons() if lesson.stage in stages],
        [(path, kind, len(handed)) for path, kind, handed in opened],
        roster,
        excused=_excused(roster, deadlines, stages),
    )
    places = [(path, one) for path, _, handed in opened for one in handed]
    remember(course, stages, answers, {one.owner.label for _, one in places})
    students: dict[str, list[Place]] = {}
    for ids, mine in _by_owner(places, owners, answers, outcome):
        for id in ids:
            students.setdefault(id, []).extend(mine)
    there = _existing(course)
    for done, (id, mine) in enumerate(sorted(students.items())):
        progress(done, len(students), None)
        rows = _rows(owners, mine, id) if timestamps else None
        StudentCollector(course, id, there.get(id, {}), answers, outcome).collect(mine, rows)
    progress(len(students), len(students), None)
    return outcome


def _excused(
    roster: Roster | None, deadlines: Deadlines | None, stages: Sequence[str]
) -> list[str]:
    if roster is None or deadlines is None:
        return []
    return [
        person.id
        for person in roster.people
        if all(deadlines.excused(person.id, stage) for stage in stages)
    ]


def _as_one_student(path: Path, handed: list[SubmittedFile], owners: Owners) -> list[SubmittedFile]:
    """Return the archive as one student's work, if an answer says so and no other is named."""
    name = path.name if path.is_dir() else path.stem
    owner = Owner(name, name, (name,))
    if not owners.has_all(owner, {one.owner for one in handed} - {owner}):
        return handed
    return [dataclasses.replace(one, owner=owner, path=one.entry.path) for one in handed]


def _by_owner(
    places: Sequence[Place], owners: Owners, answers: Answers, outcome: CollectionReport
) -> Iterator[tuple[tuple[str, ...], list[Place]]]:
    """Group the submitted files by owner, with the ids of the owners."""
    groups: dict[tuple[Path, Owner], list[Place]] = {}
    for archive, one in places:
        groups.setdefault((archive, one.owner), []).append((archive, one))
    found: dict[tuple[Path, Owner], tuple[str, ...]] = {}
    for (archive, owner), mine in groups.items():
        nobody = owner.label in (archive.name, archive.stem)  # the archive's own files
        if nobody and all(_is_of_no_use(one) for _, one in mine):
            outcome.left.update(one.path[-1] for _, one in mine)
            continue
        try:
            found[archive, owner] = owners.ids_of(owner)
        except UnknownOwner as question:
            outcome.ask(owner.label, f"{_files(len(mine))} of theirs. {question}")
    for (archive, owner), ids in found.items():
        if same(owner.label) in answers.before:
            ids_of = f"taken for that of {', '.join(ids)}" if ids else "left out"
            outcome.remarks.append(Question(owner.label, f"{ids_of}, as you answered before"))
        rivals = [
            other
            for (place, other), theirs in found.items()
            if place == archive and set(ids) & set(theirs)
        ]
        question = owners.doubt(owner, ids, [rival for rival in rivals if rival != owner])
        if question:
            outcome.ask(owner.label, question)
        if len(rivals) == 1 or all(map(owners.is_answered, rivals)):
            yield ids, groups[archive, owner]


def _existing(course: Course) -> dict[str, dict[Lesson, Submission]]:
    """Return the submissions in ``submitted/``, by student."""
    found: dict[str, dict[Lesson, Submission]] = {}
    for submission in find_submissions(course):
        found.setdefault(submission.student, {})[submission.lesson] = submission
    return found


def _rows(owners: Owners, handed: Sequence[Place], id: str) -> list[SubmissionRow]:
    """Return the rows of the table of times about a student."""
    return [row for owner in {one.owner for _, one in handed} for row in owners.rows(owner, id)]


def _files(count: int) -> str:
    return "1 file" if count == 1 else f"{count} files"


def _is_of_no_use(handed: SubmittedFile) -> bool:
    name = handed.path[-1]
    return not handed.remark and kind_of(name) == OTHER
