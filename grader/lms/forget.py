"""Find and delete all data about one student in the folder of a course.

Each kind of data is a `Trace`: a sentence for the list that the instructor sees first, and the
function that deletes it. The two files that the instructor writes are never changed.
"""

from __future__ import annotations

import contextlib
import functools
import shutil
import sqlite3
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import make_url

from grader.classroom.collect.instructor_answers import count_answers_about, delete_answers_about
from grader.classroom.collect.record import RECORD_NAME as RECORD
from grader.classroom.collect.record import read_record, remove_archives, write_record
from grader.classroom.folders import UnknownStudent, find_student
from grader.course.deadlines_file import deadlines_path
from grader.course.nbgrader_settings import course_settings
from grader.course.paths import Course
from grader.course.roster import Roster, normalized_text, read_roster, roster_path
from grader.lms.gradebook import database_url, gradebook_exists, open_gradebook
from grader.lms.mark_history import count_changes_of, delete_changes_of

CLASS_PAGES = ("report", "league", "viva", "scores*", "handed_back/*.zip")
"""Files and folders about the whole class, which are written again without the student."""


@dataclass(frozen=True)
class Trace:
    """Data about a student in one place.

    Attributes
    ----------
    sentence : str
        What the data is, and where it is stored.
    delete : callable
    is_class_page : bool
        Whether the data is a page or table about the whole class, which can be written again.
    """

    sentence: str
    delete: Callable[[], None]
    is_class_page: bool = False


def student_to_forget(course: Course, text: str) -> str:
    """Return the ID of a student, who may be only in the gradebook, a log or the due dates.

    Raises
    ------
    grader.classroom.folders.UnknownStudent
    """
    try:
        return find_student(course, text)
    except UnknownStudent:
        if any(_own_traces(course, text)) or any(remaining_lines(course, text)):
            return text
        roster = read_roster(course)
        if roster and roster.find_people(text):
            raise  # several students have this name
        raise UnknownStudent(
            f"There is no data about {text!r} in this course. If you expected some, correct the "
            "name."
        ) from None


def find_traces(course: Course, student: str) -> list[Trace]:
    """Return all data about a student, except lines in the roster and in the due dates."""
    own = list(_own_traces(course, student))
    return [*own, *_class_page_traces(course)] if own else []


def remaining_lines(course: Course, student: str) -> Iterator[str]:
    """Yield a sentence about each file of the instructor that still names the student."""
    roster = read_roster(course)
    if roster and roster.owner_of(student):
        yield f"Delete {student}'s line in {roster_path(course).name}."
    with contextlib.suppress(OSError, ValueError):
        stages = tomllib.loads(deadlines_path(course).read_text("utf-8")).values()
        tables = [stage.get("students", {}) for stage in stages if isinstance(stage, dict)]
        if any(
            normalized_text(str(name)) == normalized_text(student)
            for table in tables
            for name in table
        ):
            yield f"Delete each line about {student} in {deadlines_path(course).name}."


def _own_traces(course: Course, student: str) -> Iterator[Trace]:
    # Records of team members come first, because they are found through the student's own
    # folders, which are deleted next.
    yield from _team_record_traces(course, student)
    yield from _folder_traces(course, student)
    yield from _page_traces(course, student)
    yield from _gradebook_traces(course, student)
    yield from _log_traces(course, student)


def _folder_traces(course: Course, student: str) -> Iterator[Trace]:
    feedback = course_settings(course.root).CourseDirectory.get("feedback_directory", "feedback")
    kinds = {
        course.submitted: "submissions",
        course.autograded: "copies for graders",
        course.verdicts: "verdicts",
        course.root / feedback: "feedback from nbgrader",
    }
    for folder, kind in kinds.items():
        for path in _folders_of(course, student, folder):
            count = sum(file.is_file() for file in path.rglob("*"))
            yield Trace(
                f"{kind}: {_relative(course, path)}/ with {count} file{'s' * (count != 1)}",
                _make_deletion(path),
            )


def _folders_of(course: Course, student: str, folder: Path) -> list[Path]:
    """Return the student's folders in a folder, whose names may be other spellings of the ID."""
    roster = read_roster(course)
    paths = sorted(folder.iterdir()) if folder.is_dir() else []
    return [path for path in paths if path.is_dir() and _is_name_of(student, path.name, roster)]


def _is_name_of(student: str, name: str, roster: Roster | None) -> bool:
    if name == student:
        return True
    owner = roster.owner_of(name) if roster else None
    return owner is not None and owner.id == student


def _page_traces(course: Course, student: str) -> Iterator[Trace]:
    for folder in sorted((course.root / "handed_back").glob("*/")):
        path = folder / f"{student}.html"
        if path.is_file():
            yield Trace(f"feedback page: {_relative(course, path)}", path.unlink)


def _team_record_traces(course: Course, student: str) -> Iterator[Trace]:
    """Yield records of other students that contain the name under which this one submitted."""
    own = _folders_of(course, student, course.submitted)
    archives = {
        origin.archive
        for folder in own
        for path in folder.glob(f"*/{RECORD}")
        for origin in read_record(path.parent).files.values()
    }
    for path in sorted(course.submitted.glob(f"*/*/{RECORD}")) if archives else ():
        record = read_record(path.parent)
        kept = remove_archives(record, archives)
        if path.parent.parent not in own and kept != record:
            yield Trace(
                f"the name in a team member's record: {_relative(course, path)}",
                functools.partial(write_record, kept, path.parent),
            )


def _gradebook_traces(course: Course, student: str) -> Iterator[Trace]:
    if not gradebook_exists(course):
        return
    with open_gradebook(course) as book:
        is_enrolled = any(person.id == student for person in book.students)
    if is_enrolled:
        yield Trace(
            "name, marks and comments in the gradebook",
            functools.partial(_remove_from_gradebook, course, student),
        )


def _remove_from_gradebook(course: Course, student: str) -> None:
    with open_gradebook(course) as book:
        book.remove_student(student)
    url = make_url(database_url(course))
    if url.drivername == "sqlite":
        # Until then, deleted text stays in unused parts of the file.
        with contextlib.closing(sqlite3.connect(url.database)) as database:
            database.execute("vacuum")


def _log_traces(course: Course, student: str) -> Iterator[Trace]:
    logs = (
        ("marks.jsonl", count_changes_of, delete_changes_of),
        (f"{course.submitted.name}/.whose.jsonl", count_answers_about, delete_answers_about),
    )
    for name, count, delete in logs:
        lines = count(course, student)
        if lines:
            yield Trace(
                f"{lines} line{'s' * (lines != 1)} in {name}",
                functools.partial(delete, course, student),
            )


def _class_page_traces(course: Course) -> Iterator[Trace]:
    for pattern in CLASS_PAGES:
        for path in sorted(course.root.glob(pattern)):
            sentence = f"pages or tables about the whole class: {_relative(course, path)}"
            yield Trace(sentence, _make_deletion(path), is_class_page=True)
    url = make_url(database_url(course))
    if url.drivername == "sqlite" and url.database:
        database = Path(url.database)
        for path in sorted(database.parent.glob(f"{database.name}.*")):  # from nbgrader db upgrade
            yield Trace(f"older copy of the whole gradebook: {path.name}", path.unlink)


def _make_deletion(path: Path) -> Callable[[], None]:
    is_folder = path.is_dir() and not path.is_symlink()
    return functools.partial(shutil.rmtree, path) if is_folder else path.unlink


def _relative(course: Course, path: Path) -> str:
    return str(path.relative_to(course.root))
