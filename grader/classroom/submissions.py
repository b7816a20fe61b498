"""Find the submissions of a class, and explain why other files are not judged."""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from grader.classroom.lesson_recognition import (
    copy_number,
    is_notebook_name,
    lesson_by_content,
    lesson_by_name,
)
from grader.course.lessons import Lesson, all_lessons, stages
from grader.course.paths import Course
from grader.course.roster import read_roster
from grader.intake.submission import (
    SubmittedFiles,
    is_skipped_folder,
    read_submitted_files,
    walk_submitted,
)

# Files that nbgrader's exchange adds: the submission time and the key for the feedback.
EXCHANGE_FILES = {"timestamp.txt", "submission_secret.txt"}
MAX_LISTED_FILES = 10  # if a folder has more files, only the folder is listed


class ReplacedSubmission(Exception):
    """A submission was replaced after it was judged; the message is shown to the user."""


@dataclass(frozen=True)
class Submission:
    """One submitted notebook.

    Attributes
    ----------
    student : str
        The ID on the roster, or the name of the folder if the student is not on a roster.
    lesson : grader.course.lessons.Lesson
    path : pathlib.Path
        The file that is judged.
    older : tuple of Path
        The student's other files for this lesson, which are not judged.
    """

    student: str
    lesson: Lesson
    path: Path
    older: tuple[Path, ...] = ()

    def verdict_path(self, course: Course) -> Path:
        """Return the path of the verdict."""
        return course.verdicts / self.student / self.lesson.stage / f"{self.lesson.name}.json"

    def stage_folder(self, course: Course) -> Path:
        """Return the folder ``submitted/<student>/<stage>/`` of the file, as spelt on disk."""
        folder = self.path.relative_to(course.submitted).parts[0]
        return course.submitted / folder / self.lesson.stage

    def read(self, course: Course) -> SubmittedFiles:
        """Read the file, unless its path is a link into another folder."""
        if not self._is_in_its_folder(course):
            return SubmittedFiles(
                self.path.name,
                b"",
                f"{self.path.name} is a link, or is in a linked folder. Submit the file itself.",
            )
        return dataclasses.replace(
            read_submitted_files(self.path), notes=tuple(self._notes(course))
        )

    def _is_in_its_folder(self, course: Course) -> bool:
        if not self.path.is_relative_to(course.submitted):
            return False
        own_folder = self.stage_folder(course).relative_to(course.submitted)
        return self.path.parent.resolve().is_relative_to(course.submitted.resolve() / own_folder)

    def read_again(self, course: Course, fingerprint: str) -> SubmittedFiles:
        """Read the file again; raise an error if it was replaced after it was judged.

        Parameters
        ----------
        course : grader.course.paths.Course
        fingerprint : str
            Fingerprint of the judged submission, from its verdict.

        Raises
        ------
        ReplacedSubmission
        """
        submitted_files = self.read(course)
        if submitted_files.fingerprint() != fingerprint:
            raise ReplacedSubmission(
                f"{self.student}, {self.lesson.stage}: {self.path.name}, or a module next to "
                "it, was replaced after it was judged, so no score for this stage was entered into "
                "the gradebook. Run grade again."
            )
        return submitted_files

    def _notes(self, course: Course) -> Iterator[str]:
        name = f"{self.lesson.name}.ipynb"
        if self.older:
            files = [path.relative_to(course.submitted) for path in (self.path, *self.older)]
            # A student's files may be in several folders.
            several_folders = len({file.parts[0] for file in files}) > 1
            newest, *ignored = [str(file) if several_folders else file.name for file in files]
            yield (
                f"Several files belong to this lesson. The newest, {newest}, was judged, and "
                f"these were not: {', '.join(ignored)}. If the newest is the wrong file, submit "
                "only the right one."
            )
        elif self.path.name != name:
            yield f"{self.path.name} was recognised as {name}. Submit it under that name."


def find_submissions(course: Course, stages: Iterable[str] = ()) -> list[Submission]:
    """Return every notebook under ``submitted/<student>/<stage>/`` that belongs to a lesson.

    Browsers and editors rename files and create folders, so the lesson of a file is found from its
    name or, if the name is unclear, from its content. If a student submits several files for a
    lesson, the newest counts. The roster determines the owner of a folder; two spellings of an ID
    count as one student.

    Parameters
    ----------
    course : grader.course.paths.Course
    stages : iterable of str, optional
        Stages to look for; by default all.

    Returns
    -------
    list of Submission
        Sorted by student and lesson.

    Raises
    ------
    grader.course.roster.RosterError
    """
    roster = read_roster(course)
    paths_by_lesson: dict[tuple[str, Lesson], list[Path]] = {}
    for stage in dict.fromkeys(lesson.stage for lesson in all_lessons()):
        if stages and stage not in stages:
            continue
        for folder in course.submitted.glob(f"*/{stage}"):
            owner = roster.owner_of(folder.parent.name) if roster else None
            student = owner.id if owner else folder.parent.name
            for path in _files_below(folder):
                lesson = _lesson_of_file(path)
                if lesson and lesson.stage == stage:
                    paths_by_lesson.setdefault((student, lesson), []).append(path)
    submissions = []
    for (student, lesson), paths in paths_by_lesson.items():
        *older, newest = sorted(paths, key=_age_key)
        submissions.append(Submission(student, lesson, newest, tuple(older)))
    return sorted(submissions, key=lambda submission: (submission.student, submission.lesson.name))


def unaccounted_files(course: Course) -> list[tuple[Path, str]]:
    """Return the files in ``submitted/`` that are not judged, each with the reason.

    If a folder contains many such files with the same reason, the folder is listed instead.
    """
    submissions = find_submissions(course)
    judged = {path for submission in submissions for path in (submission.path, *submission.older)}
    files_with_reason = []
    for path in _files_below(course.submitted):
        if path not in judged and path.name not in EXCHANGE_FILES:
            reason = _reason_not_judged(course, path)
            if reason:
                files_with_reason.append((path.relative_to(course.root), reason))
    return list(_summarise_by_folder(files_with_reason))


def _summarise_by_folder(
    files_with_reason: Iterable[tuple[Path, str]],
) -> Iterator[tuple[Path, str]]:
    groups: dict[tuple[Path, str], list[Path]] = {}
    for path, reason in files_with_reason:  # submitted/<student>/<stage>/<folder>
        folder = Path(*path.parent.parts[:4])
        groups.setdefault((folder, reason), []).append(path)
    for (folder, reason), paths in groups.items():
        if len(paths) > MAX_LISTED_FILES:
            yield folder, f"{len(paths)} files: {reason}"
        else:
            yield from ((path, reason) for path in paths)


def _files_below(root: Path) -> Iterator[Path]:
    """Yield all files except hidden ones and packages, sorted; links are not followed."""
    for folder, folders, files in walk_submitted(root):
        folders[:] = sorted(name for name in folders if not is_skipped_folder(name))
        links = [name for name in folders if (folder / name).is_symlink()]
        # A folder named like a notebook is a mistake, so it is reported.
        misnamed_folders = [name for name in folders if name.endswith(".ipynb")]
        for name in sorted({*files, *links, *misnamed_folders}):
            if not name.startswith("."):
                yield folder / name


def _lesson_of_file(path: Path) -> Lesson | None:
    """Return the lesson of a notebook, found from its name or otherwise from its content."""
    if not is_notebook_name(path.name):
        return None
    return lesson_by_name(path.name) or lesson_by_content(path)


def _age_key(path: Path) -> tuple[float, int, str]:
    """Return a sort key: the time when the file was saved, then the number of the copy."""
    return path.lstat().st_mtime, copy_number(path.name), path.name


def _reason_not_judged(course: Course, file: Path) -> str:
    """Return why a file is not a submission and what to do; empty if it belongs to a submission."""
    path = file.relative_to(course.submitted)
    student, *_ = path.parts
    lesson = _lesson_of_file(file)
    if len(path.parts) < 3 or path.parts[1] not in stages():
        folder = f"{student}/{lesson.stage}/" if lesson and len(path.parts) > 1 else ""
        return "it is not in <student>/<stage>/" + (folder and f"; move it to {folder}")
    if lesson:
        return f"{lesson.name} belongs to {lesson.stage}; move it to {student}/{lesson.stage}/"
    if path.suffix.lower() == ".zip":
        words = [file.relative_to(course.root).as_posix(), "--stage", path.parts[1], "--who"]
        command = " ".join(map(shlex.quote, [*words, f"{path.stem}={student}"]))
        return f"it is a zip; run python -m grader collect {command}, and delete the zip"
    lesson = lesson_by_name(path.name)
    if lesson:
        return f"it is not a notebook; submit {lesson.name}.ipynb as Jupyter saves it"
    return "" if path.suffix == ".py" else "it is not a notebook from this course"
