"""Copy submissions from archives into ``submitted/``, and ask about unknown owners."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path

from grader.classroom.collect import open_archives
from grader.classroom.collect.collection_report import CollectionReport, Question
from grader.classroom.collect.folder import (
    extra_words,
    folders_of_lessons,
    named_folders,
    student_name_in,
)
from grader.classroom.collect.inspection import OTHER, file_kind
from grader.classroom.collect.instructor_answers import (
    InstructorAnswers,
    read_answers,
    store_answers,
    store_ignored,
    store_teams,
)
from grader.classroom.collect.models import (
    ArchiveEntry,
    Owner,
    SubmittedArchive,
    SubmittedFile,
)
from grader.classroom.collect.name_patterns import may_be_notebook
from grader.classroom.collect.owners import OwnerFinder, UnknownOwner
from grader.classroom.collect.student_collector import StudentCollector
from grader.classroom.collect.submission_table import (
    SubmissionRow,
    SubmissionTable,
    read_submission_table,
)
from grader.classroom.lesson_recognition import lesson_by_name
from grader.classroom.submissions import Submission, find_submissions
from grader.course.deadlines import Deadlines
from grader.course.deadlines_file import read_deadlines
from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import Course
from grader.course.roster import Roster, read_roster

MAX_SHOWN_NAMES = 3
ArchivedFile = tuple[Path, SubmittedFile]
"""The archive and a submitted file in it."""


def collect(
    course: Course,
    archive_paths: Sequence[Path],
    stages: Sequence[str],
    timestamps: Path | None,
    owner_answers: dict[str, str],
    lesson_answers: dict[str, str],
    progress: Callable[[int, int, object], None],
    folder_level: int = 0,
) -> CollectionReport:
    """Collect the submissions of a class.

    Parameters
    ----------
    course : grader.course.paths.Course
    archive_paths : sequence of pathlib.Path
        Zips, folders or single files.
    stages : sequence of str
    timestamps : pathlib.Path or None
        A table of submission times.
    owner_answers, lesson_answers : dict of str to str
        Answers to questions, as typed.
    progress : callable
        Called with (done, total, None) at the start and after each student.
    folder_level : int, optional
        Level of the students' folders in archives of an unknown format: 1 for the outermost. By
        default, it is recognised.

    Raises
    ------
    CollectError, grader.course.roster.RosterError, grader.course.deadlines_file.DeadlinesError
    """
    roster = read_roster(course)
    deadlines = read_deadlines(course)
    zone = deadlines.zone if deadlines else None
    worksheet = read_submission_table(timestamps, zone) if timestamps else SubmissionTable()
    answers = read_answers(course, roster, stages, owner_answers, lesson_answers)
    owners = OwnerFinder(roster, worksheet, answers)
    owners.check_answers(owner_answers)
    report = CollectionReport(
        [lesson for lesson in all_lessons() if lesson.stage in stages],
        roster=roster,
        students_with_time=[] if timestamps else None,
        excused_students=_excused_students(roster, deadlines, stages),
    )
    archives = []
    for archive in open_archives(archive_paths, folder_level):
        report.archives.append((archive.path, archive.kind, len(archive.files)))
        report.ignored.update(entry.path[-1] for entry in archive.other_entries)
        archive = _assign_to_one_student(archive, owners)
        archives.append(_decide_level(archive, owners, report))
    archived_files = [(archive.path, file) for archive in archives for file in archive.files]
    store_answers(course, stages, answers)
    students: dict[str, list[ArchivedFile]] = {}
    listed_teams = []
    for ids, files in _group_by_owner(archived_files, owners, answers, report):
        if len(ids) > 1 and not owners.is_answered(files[0][1].owner):
            listed_teams.append(ids)
        for id in ids:
            students.setdefault(id, []).extend(files)
    existing = _existing_submissions(course)
    report.earlier_students.extend(
        id for id, lessons in existing.items() if not lessons.keys().isdisjoint(report.lessons)
    )
    for done, (id, files) in enumerate(sorted(students.items())):
        progress(done, len(students), None)
        rows = _time_rows(owners, files, id) if timestamps else None
        StudentCollector(course, id, existing.get(id, {}), answers, report).collect(files, rows)
    progress(len(students), len(students), None)
    store_ignored(course, stages, sorted(report.ignored_files))
    store_teams(course, stages, listed_teams)
    return report


def _excused_students(
    roster: Roster | None, deadlines: Deadlines | None, stages: Sequence[str]
) -> list[str]:
    if roster is None:
        return []
    deadlines = deadlines or Deadlines({})
    return [
        person.id
        for person in roster.people
        if all(deadlines.is_excused(person.id, stage) for stage in stages)
    ]


def _assign_to_one_student(archive: SubmittedArchive, owners: OwnerFinder) -> SubmittedArchive:
    """Assign all files to one student if an answer says whose archive it is.

    Return the archive unchanged if it names several students.
    """
    name = archive.path.name if archive.path.is_dir() else archive.path.stem
    owner = Owner(name, name, (name,), is_folder=True)
    others = {file.owner for file in archive.files} - {owner}
    has_students = len(others) > 1 and not any(other.is_folder for other in others)
    if has_students or not owners.owns_whole_archive(owner, others):
        return archive
    files = (dataclasses.replace(file, owner=owner, path=file.entry.path) for file in archive.files)
    return dataclasses.replace(archive, files=tuple(files))


def _decide_level(
    archive: SubmittedArchive, owners: OwnerFinder, report: CollectionReport
) -> SubmittedArchive:
    """Decide which folders belong to students: look them up on the roster, or ask.

    A student could name a folder after another student, so most names at a deeper level must be on
    the roster.
    """
    if not archive.levels or any(owners.is_known(file.owner) for file in archive.files):
        return archive
    owners_by_level = {
        level: [file.owner for file in files if may_be_notebook(file.entry)]
        for level, files in archive.levels.items()
    }
    (outer_level, outer_owners), *inner = owners_by_level.items()
    for level, inner_owners in inner:
        known = [owners.is_known(owner) for owner in set(inner_owners)]
        if 2 * sum(known) > len(known):
            return dataclasses.replace(archive, files=tuple(archive.levels[level]))
    outer_names = {owner.label for owner in outer_owners}
    lesson_folders = folders_of_lessons([file.entry for file in archive.files])
    for level, inner_owners in inner:
        inner_names = {owner.label for owner in inner_owners}
        has_several = len(set(zip(outer_owners, inner_owners, strict=True))) > len(outer_names)
        if has_several and lesson_folders.isdisjoint(inner_names):
            report.add_question(
                archive.path.name,
                f"Add --folder-level {outer_level} if {_format_folders(outer_names)} named after "
                f"students, or --folder-level {level} if {_format_folders(inner_names)}",
            )
            return dataclasses.replace(archive, files=())
    return archive


def _group_by_owner(
    archived_files: Sequence[ArchivedFile],
    owners: OwnerFinder,
    answers: InstructorAnswers,
    report: CollectionReport,
) -> Iterator[tuple[tuple[str, ...], list[ArchivedFile]]]:
    """Yield each known owner's IDs and files, and add questions about the other owners."""
    groups: dict[tuple[Path, Owner], list[ArchivedFile]] = {}
    for archive, file in archived_files:
        groups.setdefault((archive, file.owner), []).append((archive, file))
    entries: dict[Path, list[ArchiveEntry]] = {}
    for archive, file in archived_files:
        entries.setdefault(archive, []).append(file.entry)
    lesson_folders = {archive: folders_of_lessons(files) for archive, files in entries.items()}
    ids_by_owner: dict[tuple[Path, Owner], tuple[str, ...]] = {}
    for (archive, owner), files in groups.items():
        # Files outside the students' folders have the archive itself as their owner.
        is_unnamed = owner.label in (archive.name, archive.stem)
        if is_unnamed and all(_is_irrelevant(file) for _, file in files):
            report.ignored.update(file.path[-1] for _, file in files)
            continue
        count = _format_file_count(len(files))
        if (
            owner.is_folder
            and not owners.is_known(owner)
            and _may_belong_to_several(
                [file.entry.path for _, file in files if may_be_notebook(file.entry)],
                lesson_folders[archive],
                is_named=report.roster is None and not is_unnamed,
            )
        ):
            report.add_question(owner.label, f"{count}. {owners.ambiguous_files_question(owner)}")
            continue
        try:
            ids_by_owner[archive, owner] = owners.ids_of(owner)
        except UnknownOwner as question:
            report.add_question(owner.label, f"{count} from this student. {question}")
    for (archive, owner), ids in ids_by_owner.items():
        if answers.is_earlier(owner.label):
            decision = f"assigned to {', '.join(ids)}" if ids else "ignored"
            report.remarks.append(Question(owner.label, f"{decision}, as in your earlier answer"))
        other_owners = [
            other_owner
            for (other_archive, other_owner), other_ids in ids_by_owner.items()
            if other_archive == archive and set(ids) & set(other_ids)
        ]
        question = owners.identity_question(
            owner, ids, [rival for rival in other_owners if rival != owner]
        )
        if question:
            if len(other_owners) > 1:
                report.add_question(owner.label, question)
            else:
                report.doubts.append(Question(owner.label, question))
        if len(other_owners) == 1 or all(map(owners.is_answered, other_owners)):
            yield ids, groups[archive, owner]


def _existing_submissions(course: Course) -> dict[str, dict[Lesson, Submission]]:
    """Return the submissions in ``submitted/``, by student."""
    submissions: dict[str, dict[Lesson, Submission]] = {}
    for submission in find_submissions(course):
        submissions.setdefault(submission.student, {})[submission.lesson] = submission
    return submissions


def _time_rows(
    owners: OwnerFinder, submitted: Sequence[ArchivedFile], id: str
) -> list[SubmissionRow]:
    """Return a student's rows in the table of submission times."""
    return [
        row
        for owner in {file.owner for _, file in submitted}
        for row in owners.submission_rows(owner, id)
    ]


def _format_file_count(count: int) -> str:
    return "1 file" if count == 1 else f"{count} files"


def _format_folders(names: Collection[str]) -> str:
    """Return a subject and its verb, such as ``the folders ada, bo are``."""
    shown = ", ".join(sorted(names)[:MAX_SHOWN_NAMES])
    if len(names) == 1:
        return f"the folder {shown} is"
    return f"the folders {shown}{', …' if len(names) > MAX_SHOWN_NAMES else ''} are"


def _may_belong_to_several(
    paths: Collection[tuple[str, ...]], lesson_folders: Collection[str], is_named: bool
) -> bool:
    """Return whether the paths of notebooks show that several students may own them.

    One student's files have different names, and are in nested folders or in folders named after
    lessons. If the files are in a folder that is named after a student (`is_named`), a second
    version, or a word that the student added to a file name, is not enough evidence.
    """
    names = [lesson_by_name(path[-1]) or path[-1].lower() for path in paths]
    words = {extra_words(path[-1]) for path in paths} - {""}
    students = {student_name_in(path[-1]) for path in paths} - {""}
    students_before = {student_name_in(path[-1], only_before=True) for path in paths} - {""}
    is_repeated = len(set(names)) < len(names)
    folders = {named_folders(path, lesson_folders) for path in paths}
    innermost = max(folders, key=len, default=())
    if any(innermost[: len(folder)] != folder for folder in folders):
        return True
    if not is_named:
        return is_repeated or len(words) > 1
    return len(students_before) > 1 or (is_repeated and len(students) > 1)


def _is_irrelevant(submitted: SubmittedFile) -> bool:
    name = submitted.path[-1]
    return not submitted.remark and file_kind(name) == OTHER
