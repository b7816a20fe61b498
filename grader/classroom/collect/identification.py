"""Find the lesson of a notebook from its name, its content or an earlier answer."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Collection

from grader.classroom.collect.selection import StudentFile
from grader.classroom.lesson_recognition import lesson_by_name
from grader.course.lessons import Lesson, all_lessons, find_lesson


class UnrecognisedLesson(Exception):
    """The lesson of a file is unknown; the message explains what to do."""


class ContradictoryLesson(Exception):
    """A file's name and content belong to different lessons; the message is a question."""

    def __init__(self, text: str, lessons: tuple[Lesson, Lesson]) -> None:
        super().__init__(text)
        self.lessons = lessons


def identify_lesson(
    file: StudentFile,
    existing_lessons: Collection[Lesson],
    is_placed: Callable[[Lesson, StudentFile], bool],
) -> Lesson:
    """Return the lesson of a notebook for which there is no new answer.

    Parameters
    ----------
    file : StudentFile
    existing_lessons : collection of Lesson
        Lessons for which the student already has a file in place.
    is_placed : callable
        Accepts a lesson and a file, and returns whether the file was collected for that lesson.

    Raises
    ------
    UnrecognisedLesson, ContradictoryLesson
    """
    named_lesson, content_lesson = (
        lesson_by_name(file.path[-1]),
        find_lesson(file.unpacked.content.lesson),
    )
    if named_lesson and content_lesson and named_lesson != content_lesson:
        if is_placed(named_lesson, file):
            return named_lesson
        if named_lesson in existing_lessons and is_placed(content_lesson, file):
            return content_lesson
        raise ContradictoryLesson(
            f"is named {named_lesson.name}, but contains lesson {content_lesson.name}. Open it to "
            f"see which is right, and add {lesson_option(file, content_lesson.number)} or "
            f"{lesson_option(file, named_lesson.number)}",
            (named_lesson, content_lesson),
        )
    found = named_lesson or content_lesson
    found = found or next((lesson for lesson in all_lessons() if is_placed(lesson, file)), None)
    if found is None:
        complaint = file.unpacked.complaint
        reason = complaint or "does not match any lesson by name or content"
        raise UnrecognisedLesson(
            f"{reason}. If it belongs to a lesson, add {lesson_option(file, 'NN')}"
        )
    return found


def lesson_option(file: StudentFile, number: str) -> str:
    """Return the command-line option that assigns a file to a lesson."""
    return f"--lesson {shlex.quote(f'{file.name}={number}')}"
