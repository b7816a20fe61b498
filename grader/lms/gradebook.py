"""Enter verdicts into nbgrader's gradebook: all of a submission or nothing.

What the gradebook should hold is compared with what it holds, before and after. Whatever differs
is entered again, so a run that was broken off, a deleted gradebook, a new due date and changed
points need no care of their own. One process writes.
"""

from __future__ import annotations

import contextlib
import functools
import os
import shutil
import stat
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import nbformat
import nbgrader.api
from alembic.config import Config as AlembicConfig
from alembic.script import ScriptDirectory
from nbgrader.api import (
    Assignment,
    Comment,
    Grade,
    Gradebook,
    MissingEntry,
    Notebook,
    SubmittedAssignment,
    SubmittedNotebook,
)
from nbgrader.coursedir import CourseDirectory
from nbgrader.preprocessors import AssignLatePenalties, SaveCells
from nbgrader.utils import compute_checksum, determine_grade, is_grade, is_solution
from sqlalchemy import exists, func, make_url, or_
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from grader.classroom.folders import strangers
from grader.classroom.submissions import Replaced, Submission
from grader.course.deadlines import Deadlines, read_deadlines
from grader.course.lessons import Lesson, all_lessons
from grader.course.nbgrader_settings import course_settings
from grader.course.paths import Course
from grader.course.roster import Person, read_roster
from grader.intake.notebook import read_file
from grader.judging.verdict import JUDGED, Verdict
from grader.lms.answers import fingerprints, read_known, regrade, write_known
from grader.lms.autograded import graded_cells, judged_copy, key_of_copy
from grader.lms.dates import enter_due_dates, extend, extension
from grader.lms.history import note_changes
from grader.lms.people import enrol
from grader.lms.results import ClassResults, GradebookUnreachable
from grader.lms.standings import Row, standings
from grader.lms.times import known_time
from utils.notebooks.reading import UnreadableNotebook

CLOSE = 1e-6  # points are written with two digits
# Of a notebook: a person has given points for it, or has written about it.
_MARKED_BY_HAND = exists().where(
    Grade.notebook_id == SubmittedNotebook.id,
    or_(Grade.manual_score.is_not(None), func.coalesce(Grade.extra_credit, 0.0) != 0.0),
)
_COMMENTED = exists().where(
    Comment.notebook_id == SubmittedNotebook.id, func.coalesce(Comment.manual_comment, "") != ""
)


class GradebookTrouble(Exception):
    """The gradebook does not hold what it should; `str()` is the sentence to show."""


@dataclass(frozen=True)
class Entry:
    """What a student handed in for a stage, with its verdicts."""

    student: str
    stage: str
    judged: tuple[tuple[Submission, Verdict], ...]

    @property
    def name(self) -> str:
        """What sentences call it."""
        return f"{self.student}, {self.stage}"

    def places(self, course: Course) -> tuple[Path, ...]:
        """The folders in which it lies; more than one where the student's is spelt in two ways."""
        found = {submission.place(course) for submission, _ in self.judged}
        return tuple(sorted(found))


def open_gradebook(course: Course) -> Gradebook:
    """Open nbgrader's gradebook of a course, made where there is none; a context manager.

    Raises
    ------
    GradebookUnreachable
    """
    # nbgrader starts a program for this, which takes seconds for each new gradebook.
    nbgrader.api.get_alembic_version = _alembic_version
    directory = CourseDirectory(config=course_settings(course.root))
    try:
        return Gradebook(directory.db_url, directory.course_id)
    except ModuleNotFoundError as error:
        raise GradebookUnreachable(
            f"The gradebook needs the package {error.name}, which is not installed. For PostgreSQL "
            'write c.CourseDirectory.db_url = "postgresql+pg8000://USER:PASSWORD@HOST/DATABASE" '
            "into nbgrader_config.py, and run: pip install pg8000 -c constraints.txt"
        ) from error
    except SQLAlchemyError as error:
        reason = str(error).splitlines()[0].rstrip(".")
        raise GradebookUnreachable(
            f"The gradebook cannot be opened: {reason}. c.CourseDirectory.db_url in "
            "nbgrader_config.py says where it is."
        ) from error


def address(course: Course) -> str:
    """Where the gradebook is, without a password."""
    url = make_url(_url(course))
    return url.database if url.drivername == "sqlite" else url.render_as_string(True)


@functools.cache
def _alembic_version() -> str:
    """The version of nbgrader's tables."""
    settings = AlembicConfig()
    folder = Path(nbgrader.api.__file__).parent / "alembic"
    settings.set_main_option("script_location", str(folder))
    return ScriptDirectory.from_config(settings).get_current_head()


def enter(
    course: Course,
    judged: Sequence[tuple[Submission, Verdict]],
    stages: Iterable[str],
    progress: Callable[[int, int, object], None],
    student: str | None = None,
) -> None:
    """Make the gradebook say what the verdicts say, and note which marks have changed.

    Parameters
    ----------
    course : grader.course.paths.Course
    judged : list of (Submission, Verdict)
    stages : iterable of str
        What was graded; there nobody else has a submission.
    progress : callable
        Called with (done, total, student) after each student's stage.
    student : str, optional
        Who alone was graded; the others stay as they are.

    Raises
    ------
    GradebookTrouble
        After everybody else has been entered.
    grader.course.roster.RosterTrouble, grader.course.deadlines.DeadlinesTrouble
    """
    roster, deadlines = read_roster(course), read_deadlines(course) or Deadlines({})
    unknown = strangers(course, roster) if roster else {}
    entries, trouble = _entries(course, judged, unknown)
    with open_gradebook(course) as book:
        note_changes(course, book)  # what was graded by hand since
        late = _late_penalties(course)
        trouble += register(course, book, dict.fromkeys(stages))
        if roster:
            enrol(book, roster)
        enter_due_dates(course, book, deadlines)
        known = {(submission.student, submission.lesson.stage) for submission, _ in judged}
        trouble += _withdraw(course, book, stages, known, student)
        for done, entry in enumerate(entries, start=1):
            if differences(course, book, entry, late, deadlines):
                trouble += _enter_or_say_why_not(course, book, entry, late, deadlines)
            progress(done, len(entries), entry.student)
        keys = {(one.student, one.lesson.name): verdict.key for one, verdict in judged}
        note_changes(course, book, keys)
    if trouble:
        raise GradebookTrouble(
            "The gradebook does not hold everything:\n" + "\n".join(dict.fromkeys(trouble))
        )


def register(course: Course, book: Gradebook, stages: Iterable[str]) -> list[str]:
    """Let the gradebook know the stages, with the cells and points of the release.

    The release is only read. What the gradebook knows already is compared, so that changed points
    arrive.

    Returns
    -------
    list of str
        What could not be changed, one sentence each.
    """
    trouble = []
    for stage in stages:
        with contextlib.suppress(MissingEntry):
            if all(_is_registered(book, lesson) for lesson in _lessons(course, stage)):
                continue
        book.update_or_create_assignment(stage)
        book.db.commit()  # what follows writes through a connection of its own
        for lesson in _lessons(course, stage):
            about = {"notebook": lesson.name, "assignment": stage, "db_url": _url(course)}
            try:
                SaveCells().preprocess(_released(lesson), {"nbgrader": about})
            except RuntimeError as error:
                trouble.append(
                    f"{lesson.name}: its graded cells are others than when submissions were "
                    f"entered, and nbgrader refuses to change them: {error}"
                )
        book.db.expire_all()
    return trouble


def differences(
    course: Course, book: Gradebook, entry: Entry, late: AssignLatePenalties, deadlines: Deadlines
) -> list[str]:
    """What the gradebook and the autograded copies say otherwise than the verdicts do.

    Returns
    -------
    list of str
        One sentence each; empty when all is as it should be.
    """
    try:
        submission = book.find_submission(entry.stage, entry.student)
    except MissingEntry:
        return [f"{entry.name}: it is not in the gradebook"]
    found = []
    if submission.timestamp != _timestamp(course, entry):
        found.append(f"{entry.name}: the gradebook has another time of submission")
    if submission.extension != extension(course, submission, deadlines):
        found.append(f"{entry.name}: the gradebook has another extension")
    verdicts = {verdict.lesson: verdict for _, verdict in entry.judged}
    for notebook in submission.notebooks:
        where = f"{entry.name}, {notebook.name}"
        verdict = verdicts.get(notebook.name)
        wanted = _scores(verdict)
        for grade in notebook.grades:
            score, most = wanted.get(grade.name, (None if verdict else 0.0, None))
            if (verdict is None or grade.name in wanted) and not _same(grade.auto_score, score):
                found.append(
                    f"{where}: {grade.name} has {grade.auto_score} points, judged were {score}"
                )
            if most is not None and not _same(grade.max_score, most):
                found.append(f"{where}: {grade.name} is worth {grade.max_score} points, not {most}")
        if not _same(notebook.late_submission_penalty, _penalty(submission, notebook, late)):
            found.append(f"{where}: the penalty for lateness is another")
        if (
            verdict
            and key_of_copy(course, entry.student, entry.stage, notebook.name) != verdict.key
        ):
            found.append(f"{where}: the autograded copy is of another verdict")
    missing = set(verdicts) - {notebook.name for notebook in submission.notebooks}
    return found + [f"{entry.name}, {name}: it is not in the gradebook" for name in sorted(missing)]


def class_results(course: Course) -> ClassResults:
    """How everybody stands, by the gradebook, the roster and the dates of a course.

    Raises
    ------
    grader.course.roster.RosterTrouble, grader.course.deadlines.DeadlinesTrouble
    """
    # All in one question: each object by itself is three, which a server far away answers slowly.
    asked = (
        SubmittedAssignment.student_id,
        Assignment.name,
        Notebook.name,
        SubmittedNotebook.score,
        SubmittedNotebook.max_score,
        func.coalesce(SubmittedNotebook.late_submission_penalty, 0.0),
        SubmittedNotebook.needs_manual_grade,
        _MARKED_BY_HAND,
        SubmittedAssignment.timestamp,
        Assignment.duedate,
        SubmittedAssignment.extension,
    )
    with open_gradebook(course) as book:
        rows = (
            book.db.query(*asked)
            .select_from(SubmittedNotebook)
            .join(SubmittedNotebook.assignment)
            .join(SubmittedAssignment.assignment)
            .join(SubmittedNotebook.notebook)
            .all()
        )
        known = [
            Person(
                student.id,
                student.first_name or "",
                student.last_name or "",
                student.email or "",
                lms_id=student.lms_user_id or "",
            )
            for student in book.students
        ]
    return standings(course, [Row(*row) for row in rows], known)


def _entries(
    course: Course, judged: Sequence[tuple[Submission, Verdict]], unknown: Mapping[str, str]
) -> tuple[list[Entry], list[str]]:
    """(what can be entered, a sentence on each that cannot); `unknown` has those on strangers."""
    groups: dict[tuple[str, str], list] = {}
    for submission, verdict in judged:
        groups.setdefault((submission.student, submission.lesson.stage), []).append(
            (submission, verdict)
        )
    entries, trouble = [], []
    for (student, stage), pairs in groups.items():
        if student in unknown:
            trouble.append(unknown[student])
            continue
        failed = [pair for pair in pairs if pair[1].status != JUDGED]
        trouble += [
            f"{student}, {stage}: not entered, because the judge failed on "
            f"{submission.lesson.name}; see {submission.verdict_path(course)}"
            for submission, _ in failed
        ]
        if not failed:  # no mark is better than a wrong one
            entries.append(Entry(student, stage, tuple(pairs)))
    return entries, trouble


def _enter_or_say_why_not(
    course: Course, book: Gradebook, entry: Entry, late: AssignLatePenalties, deadlines: Deadlines
) -> list[str]:
    """Write one submission; a sentence on each thing that is not as it should be then."""
    trouble = []
    try:
        trouble = _enter_one(course, book, entry, late, deadlines)
    except Replaced as replaced:  # what is there stays, until somebody judges again
        return [str(replaced)]
    except Exception as error:  # one student must not stop the others
        trouble = [f"{entry.name}: {type(error).__name__}: {error}"]
    return trouble + differences(course, book, entry, late, deadlines)


def _enter_one(
    course: Course, book: Gradebook, entry: Entry, late: AssignLatePenalties, deadlines: Deadlines
) -> list[str]:
    """Write one submission: files beside their place, the gradebook, then the files' place.

    Returns
    -------
    list of str
        A sentence on each copy in which nothing of the student's could be shown.
    """
    copies, modules, trouble = {}, {}, []
    for submission, verdict in entry.judged:
        handed_in = submission.read_again(course, verdict.fingerprint)
        copy, complaint = judged_copy(handed_in, submission.lesson, verdict)
        copies[submission.lesson.name] = copy
        if complaint:
            trouble.append(
                f"{entry.name}: its points are entered, and its copy in autograded/ shows nothing "
                f"of the student's. {complaint}"
            )
        for name, source in handed_in.modules.items():
            path = submission.path.with_name(f"{name}.py").relative_to(submission.place(course))
            modules[path] = source.encode()
    folder = course.autograded / entry.student / entry.stage
    draft = folder.with_name(f".{folder.name}.part")
    _write_files(course, entry, copies, modules, draft)
    known = read_known(course, entry.student, entry.stage)
    answers = {name: fingerprints(copy) for name, copy in copies.items()}
    with _one_transaction(book):
        book.update_or_create_student(entry.student)
        submission = book.update_or_create_submission(
            entry.stage, entry.student, timestamp=_timestamp(course, entry)
        )
        extend(course, submission, deadlines)
        for notebook in submission.notebooks:
            copy = copies.get(notebook.name)
            if copy is None:
                _nothing_handed_in(notebook)
            else:
                same = known.get(notebook.name, {})
                _save(notebook, copy, same, answers[notebook.name])
        book.db.flush()
        book.db.expire_all()  # sums are made by the database
        for notebook in submission.notebooks:
            notebook.late_submission_penalty = _penalty(submission, notebook, late)
    _replace(draft, folder)
    write_known(course, entry.student, entry.stage, answers)
    return trouble


def _save(
    notebook: SubmittedNotebook,
    copy: nbformat.NotebookNode,
    before: dict[str, str],
    now: dict[str, str],
) -> None:
    """Take scores from the cells of a copy, as nbgrader's SaveAutoGrades does."""
    cells = {cell.metadata.nbgrader.grade_id: cell for cell in graded_cells(copy)}
    for grade in notebook.grades:
        score, _ = determine_grade(cells[grade.name])
        regrade(grade, score, before.get(grade.name) == now.get(grade.name))
    for comment in notebook.comments:
        cell = cells[comment.name]
        untouched = cell.metadata.nbgrader.get("checksum") == compute_checksum(cell)
        comment.auto_comment = "No response." if untouched else None


def _nothing_handed_in(notebook: SubmittedNotebook) -> None:
    for grade in notebook.grades:
        grade.auto_score, grade.needs_manual_grade = 0.0, False


def _scores(verdict: Verdict | None) -> dict[str, tuple[float, float]]:
    """(score, most) by nbgrader's name of the cell with the points."""
    return {
        f"test_{exercise.name}": (exercise.score, exercise.max_score)
        for exercise in (verdict.exercises if verdict else ())
    }


def _same(one: float | None, other: float | None) -> bool:
    return abs((one or 0.0) - (other or 0.0)) < CLOSE


def _withdraw(
    course: Course,
    book: Gradebook,
    stages: Iterable[str],
    known: set[tuple[str, str]],
    only: str | None,
) -> list[str]:
    """Take out what is no longer handed in; what a person has graded is named and stays."""
    trouble = []
    for stage in stages:
        with contextlib.suppress(MissingEntry):
            for submission in list(book.find_assignment(stage).submissions):
                student = submission.student.id
                if (student, stage) in known or only not in (None, student):
                    continue
                of_a_person = book.db.query(SubmittedNotebook.id).filter(
                    SubmittedNotebook.assignment_id == submission.id,
                    or_(_MARKED_BY_HAND, _COMMENTED),
                )
                if of_a_person.first():
                    trouble.append(
                        f"{student}, {stage}: nothing is handed in any more, but the gradebook "
                        "holds marks or comments of a person. Put the submission back, or take it "
                        f"out with: nbgrader db assignment list, and Gradebook.remove_submission"
                        f"({stage!r}, {student!r})"
                    )
                    continue
                book.remove_submission(stage, student)
                shutil.rmtree(course.autograded / student / stage, ignore_errors=True)
    return trouble


def _lessons(course: Course, stage: str) -> list[Lesson]:
    """The lessons of a stage that the course has released."""
    lessons = [lesson for lesson in all_lessons() if lesson.stage == stage]
    released = course.released / stage
    return [
        lesson
        for lesson in lessons
        if not released.is_dir() or (released / f"{lesson.name}.ipynb").is_file()
    ]


def _released(lesson: Lesson) -> nbformat.NotebookNode:
    return nbformat.reads(lesson.released.read_text("utf-8"), as_version=4)


def _is_registered(book: Gradebook, lesson: Lesson) -> bool:
    """Whether the gradebook knows a lesson's cells as they are released."""
    notebook = book.find_notebook(lesson.name, lesson.stage)
    cells = graded_cells(_released(lesson))
    wanted = {
        (cell.metadata.nbgrader.grade_id, cell.metadata.nbgrader.get("checksum")) for cell in cells
    }
    points = {
        (cell.metadata.nbgrader.grade_id, float(cell.metadata.nbgrader.points))
        for cell in cells
        if is_grade(cell)
    }
    solutions = {cell.metadata.nbgrader.grade_id for cell in cells if is_solution(cell)}
    return (
        wanted == {(cell.name, cell.checksum) for cell in notebook.source_cells}
        and points == {(cell.name, cell.max_score) for cell in notebook.grade_cells}
        and solutions == {cell.name for cell in notebook.solution_cells}
    )


def _late_penalties(course: Course) -> AssignLatePenalties:
    """Nbgrader's penalties for lateness, with the plugin that the course chose."""
    penalties = AssignLatePenalties(config=course_settings(course.root))
    penalties.init_plugin()
    return penalties


def _penalty(
    submission: SubmittedAssignment, notebook: SubmittedNotebook, late: AssignLatePenalties
) -> float | None:
    if submission.assignment.duedate is None or submission.total_seconds_late <= 0:
        return None
    penalty = late.plugin_inst.late_submission_penalty(
        submission.student.id, notebook.score, submission.total_seconds_late
    )
    return None if penalty is None else late._check_late_penalty(notebook, penalty)


def _timestamp(course: Course, entry: Entry) -> datetime | None:
    return known_time(entry.places(course))


def _write_files(
    course: Course, entry: Entry, copies: dict, modules: dict[Path, bytes], draft: Path
) -> None:
    """Write into a folder of their own the copies, modules as judged, and all other files."""
    shutil.rmtree(draft, ignore_errors=True)
    draft.mkdir(parents=True)
    for place in entry.places(course):
        for path in _other_files(place):
            with contextlib.suppress(UnreadableNotebook):
                _put(read_file(path), draft / path.relative_to(place))
    for path, source in modules.items():
        _put(source, draft / path)
    for name, notebook in copies.items():
        (draft / f"{name}.ipynb").write_text(nbformat.writes(notebook) + "\n", "utf-8")
    for path in draft.rglob("*"):
        if path.is_file():
            path.chmod(0o444)  # as nbgrader leaves them


def _put(content: bytes, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def _other_files(place: Path) -> Iterator[Path]:
    for folder, folders, files in os.walk(place):
        folders[:] = [name for name in folders if not name.startswith((".", "__"))]
        for name in files:
            path = Path(folder) / name
            ordinary = stat.S_ISREG(path.lstat().st_mode)
            if ordinary and path.suffix != ".ipynb" and not name.startswith("."):
                yield path


def _replace(draft: Path, folder: Path) -> None:
    """Put a complete folder in the place of the one before."""
    old = folder.with_name(f".{folder.name}.old")
    shutil.rmtree(old, ignore_errors=True)
    with contextlib.suppress(FileNotFoundError):
        folder.rename(old)
    draft.rename(folder)
    shutil.rmtree(old, ignore_errors=True)


@contextlib.contextmanager
def _one_transaction(book: Gradebook) -> Iterator[None]:
    """Keep what nbgrader would commit step by step until all of it is there."""
    session: Session = book.db()
    commit, session.commit = session.commit, session.flush
    try:
        yield
        commit()
    except BaseException:
        session.rollback()
        raise
    finally:
        del session.commit


def _url(course: Course) -> str:
    return CourseDirectory(config=course_settings(course.root)).db_url
