"""Judge one submission in Gradescope's container; its files may be in any folder."""

from __future__ import annotations

import shutil
import stat
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from grader.classroom.grade import judge_one
from grader.classroom.lesson_recognition import is_notebook_name, lesson_by_content, lesson_by_name
from grader.classroom.submissions import Submission, find_submissions
from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import Course
from grader.course.seed import course_seed
from grader.intake.preflight import prepare_to_judge
from grader.intake.reader_process import ReadingFailed
from grader.intake.submission import SubmittedFiles, is_skipped_folder, walk_submitted
from grader.judging.verdict import JUDGED, Verdict
from grader.sandbox import Sandbox
from grader.untrusted_text import one_line
from utils.notebooks.reading import UnreadableNotebook

# Used instead of the student's ID, which the judge does not need.
PLACEHOLDER_STUDENT = "submission"


class JudgeFailed(Exception):
    """The judge failed, not the student; the message is shown to instructors."""


@dataclass(frozen=True)
class JudgedLesson:
    """The result of one lesson in the assignment.

    Attributes
    ----------
    lesson : grader.course.lessons.Lesson
    verdict : grader.judging.verdict.Verdict or None
        None if the lesson was not submitted.
    notes : tuple of str
        Messages about the file itself. They are written before any check runs, so they do not
        reveal anything about hidden tests.
    """

    lesson: Lesson
    verdict: Verdict | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class JudgedSubmission:
    """A judged submission: the lessons in order, and a sentence for each unjudged file."""

    lessons: tuple[JudgedLesson, ...]
    unjudged_notes: tuple[str, ...]


def lessons_of(assignment: str) -> tuple[Lesson, ...]:
    """Return the lessons of a stage, or the lesson with that name; empty for unknown names."""
    return tuple(lesson for lesson in all_lessons() if assignment in (lesson.stage, lesson.name))


def assigned_lessons(source: Path) -> tuple[Lesson, ...]:
    """Return the lessons of the assignment for which this autograder was built."""
    return lessons_of((source / "assignment").read_text("utf-8").strip())


def judge_submission(submitted: Path, source: Path, sandbox: Sandbox) -> JudgedSubmission:
    """Judge all notebooks of the assignment.

    Parameters
    ----------
    submitted : pathlib.Path
        Folder with a student's files.
    source : pathlib.Path
        Folder of the autograder, with the assignment's name and the course.
    sandbox : grader.sandbox.Sandbox

    Raises
    ------
    JudgeFailed
        If the judge failed on a lesson.
    """
    lessons = assigned_lessons(source)
    seed = course_seed(Course(source / "course"))
    with tempfile.TemporaryDirectory() as temporary:
        course = Course(Path(temporary))
        folder = course.submitted / PLACEHOLDER_STUDENT / lessons[0].stage
        shutil.copytree(submitted, folder, symlinks=True, ignore=_special_files)
        submissions = {
            submission.lesson: submission
            for submission in find_submissions(course, [lessons[0].stage])
        }
        judged = tuple(
            _judge(course, lesson, submissions.get(lesson), seed, sandbox) for lesson in lessons
        )
        unjudged = (*_explain_special_files(submitted), *_explain_unjudged(folder, lessons))
        return JudgedSubmission(judged, unjudged)


def _special_files(folder: str, names: list[str]) -> list[str]:
    """Return the pipes and devices, which must not be copied; links are copied but not followed."""
    paths = {name: Path(folder, name) for name in names}
    return [name for name, path in paths.items() if _is_special(path) and not path.is_symlink()]


def _is_special(path: Path) -> bool:
    mode = path.lstat().st_mode
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def _explain_special_files(submitted: Path) -> Iterator[str]:
    """Yield a sentence for the student about each link, pipe and device."""
    for root, folders, names in walk_submitted(submitted):
        folders[:] = sorted(name for name in folders if not is_skipped_folder(name))
        for name in sorted((*folders, *names)):
            if not name.startswith(".") and _is_special(root / name):
                yield (
                    f"{one_line(name)} is a link, a pipe or a device, so the judge did not open "
                    "it. Submit the file itself."
                )


def _judge(
    course: Course, lesson: Lesson, submission: Submission | None, seed: int, sandbox: Sandbox
) -> JudgedLesson:
    if submission is None:
        return JudgedLesson(lesson)
    submitted_files = submission.read(course)
    arguments = submitted_files, lesson.name, "", seed, sandbox.name
    verdict = judge_one(*arguments)
    if verdict.starved:  # nothing else runs here, so the submission itself causes the timeout
        verdict = judge_one(*arguments, is_alone=True)
    if verdict.status != JUDGED:
        raise JudgeFailed("\n".join((f"{lesson.name}:", *verdict.faults)))
    return JudgedLesson(lesson, verdict, _notes(submitted_files, lesson))


def _notes(submitted_files: SubmittedFiles, lesson: Lesson) -> tuple[str, ...]:
    try:
        notes = prepare_to_judge(submitted_files, lesson).notes
    except (UnreadableNotebook, ReadingFailed) as error:
        notes = (str(error),)
    return tuple(map(one_line, notes))


def _explain_unjudged(folder: Path, lessons: tuple[Lesson, ...]) -> Iterator[str]:
    """Yield sentences for the student about files that were not judged."""
    for root, folders, names in walk_submitted(folder):
        folders[:] = sorted(name for name in folders if not is_skipped_folder(name))
        for name in sorted(name for name in names if not name.startswith(".")):
            is_notebook = is_notebook_name(name)
            lesson = lesson_by_name(name) or (is_notebook and lesson_by_content(root / name))
            name = one_line(name)
            if lesson and not is_notebook:
                yield f"{name} is not a notebook. Submit {lesson.name}.ipynb, as Jupyter saves it."
            elif lesson and lesson not in lessons:
                yield f"{name} is lesson {lesson.name}, which is not part of this assignment."
            elif is_notebook and not lesson:
                yield (
                    f"{name} cannot be matched with a lesson. Give the file the name under which "
                    f"it was released, such as {lessons[0].name}.ipynb."
                )
