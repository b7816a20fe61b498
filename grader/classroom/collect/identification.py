"""Which lesson a notebook is for: by its name, by what stands in it, or by an answer."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Collection

from grader.classroom.collect.selection import File
from grader.classroom.contents import lesson_by_name
from grader.course.lessons import Lesson, all_lessons, find_lesson


class Unrecognised(Exception):
    """Nothing tells what a file is for; `str()` says what to do."""


class Contradiction(Exception):
    """A file's name and what stands in it name two lessons; `str()` is the question."""

    def __init__(self, text: str, lessons: tuple[Lesson, Lesson]) -> None:
        super().__init__(text)
        self.lessons = lessons


def lesson_of(
    file: File, there: Collection[Lesson], is_placed: Callable[[Lesson, File], bool]
) -> Lesson:
    """What a notebook is for, where nobody has answered now.

    Parameters
    ----------
    file : File
    there : collection of Lesson
        Of which the student has something in place.
    is_placed : callable
        Whether a file was collected for a lesson before: then it was answered, or clear.

    Raises
    ------
    Unrecognised, Contradiction
    """
    named, inside = lesson_by_name(file.path[-1]), find_lesson(file.piece.content.lesson)
    if named and inside and named != inside:
        if is_placed(named, file):
            return named
        if named in there and is_placed(inside, file):
            return inside
        raise Contradiction(
            f"is called {named.name}, and says inside that it is {inside.name}. Look at it, "
            f"and add {is_lesson(file, inside.number)} or {is_lesson(file, named.number)}",
            (named, inside),
        )
    found = named or inside
    found = found or next((lesson for lesson in all_lessons() if is_placed(lesson, file)), None)
    if found is None:
        complaint = file.piece.complaint
        reason = f"{complaint}. " if complaint else "names no lesson, and holds none. "
        raise Unrecognised(f"{reason}If it is one, add {is_lesson(file, 'NN')}")
    return found


def is_lesson(file: File, number: str) -> str:
    """The option that says what a file is for."""
    return f"--lesson {shlex.quote(f'{file.name}={number}')}"
