"""The instructor's answers to questions about a file's owner or lesson.

Answers about owners are stored in ``submitted/.whose.jsonl``, one line for each student that an
answer names, so that the next archive of the stage does not raise the question again. Answers about
lessons are not stored, because the record in a student's folder already lists the collected files.
"""

from __future__ import annotations

import contextlib
import json
import shlex
import unicodedata
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.classroom.collect.models import CollectError
from grader.course.atomic_files import write_atomically
from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import Course
from grader.course.roster import Roster

NOBODY = "-"


@dataclass(frozen=True)
class Answers:
    """The new and stored answers that apply.

    Attributes
    ----------
    owners : dict of str to (tuple of str)
        Ids of all owners, by `normalized` label; empty if the work does not belong to a student.
    lessons : dict of str to grader.course.lessons.Lesson
        Lessons by file name.
    earlier : frozenset of str
        Labels in `owners` whose answers were given earlier.
    """

    owners: dict[str, tuple[str, ...]]
    lessons: dict[str, Lesson]
    earlier: frozenset[str] = frozenset()


def read_answers(
    course: Course,
    roster: Roster | None,
    stages: Sequence[str],
    owners: dict[str, str],
    lessons: dict[str, str],
) -> Answers:
    """Return the new answers, and the stored answers that they do not replace.

    Parameters
    ----------
    course : grader.course.paths.Course
    roster : grader.course.roster.Roster or None
        Stored answers about students who are no longer on the roster are ignored.
    stages : sequence of str
        The stages that are collected.
    owners, lessons : dict of str to str
        New answers, as typed.

    Raises
    ------
    CollectError
        If an answer names an unknown lesson.
    """
    earlier: dict[str, list[str]] = {}
    for stage, label, id in _read_entries(course):
        if stage in stages and (roster is None or not id or roster.person(id)):
            earlier.setdefault(normalized(label), []).extend([id] if id else [])
    new = {
        normalized(label): () if ids == NOBODY else tuple(ids.split(","))
        for label, ids in owners.items()
    }
    ids_by_label = {label: tuple(dict.fromkeys(ids)) for label, ids in earlier.items()} | new
    return Answers(ids_by_label, _lessons(lessons), frozenset(earlier.keys() - new.keys()))


def store_answers(
    course: Course, stages: Sequence[str], answers: Answers, labels: Collection[str]
) -> None:
    """Store the new answers about owners for these stages."""
    new = {normalized(label): label for label in labels}
    new = {
        key: label for key, label in new.items() if key in answers.owners.keys() - answers.earlier
    }
    entries = [
        entry
        for entry in _read_entries(course)
        if not (entry[0] in stages and normalized(entry[1]) in new)
    ] + [
        (stage, label, id)
        for stage in stages
        for key, label in new.items()
        for id in answers.owners[key] or ("",)
    ]
    if new:
        write_atomically("".join(map(_json_line, entries)), _path(course))


def normalized(label: str) -> str:
    """Return a label in lower case, in NFC and without outer spaces, for comparisons."""
    return unicodedata.normalize("NFC", label).casefold().strip()


def _lessons(answers: dict[str, str]) -> dict[str, Lesson]:
    """Return the lesson that each answer names by number or name."""
    chosen_lessons = {}
    for file, answer in answers.items():
        lesson = next((one for one in all_lessons() if answer in (one.number, one.name)), None)
        if lesson is None:
            raise CollectError(
                f"--lesson {shlex.quote(file)}=…: there is no lesson {answer}. Write a lesson's "
                "number, such as 06."
            )
        chosen_lessons[file] = lesson
    return chosen_lessons


def _read_entries(course: Course) -> list[tuple[str, str, str]]:
    """Return the stage, label and student id in each readable line."""
    entries = []
    with contextlib.suppress(OSError, UnicodeDecodeError):
        for line in _path(course).read_text("utf-8").splitlines():
            with contextlib.suppress(ValueError, TypeError, KeyError):
                entry = json.loads(line)
                entries.append((entry["stage"], entry["label"], entry["student"]))
    return entries


def _json_line(entry: tuple[str, str, str]) -> str:
    stage, label, id = entry
    # The documented command for deleting a student's data searches for this text.
    return json.dumps({"student": id, "stage": stage, "label": label}, ensure_ascii=False) + "\n"


def _path(course: Course) -> Path:
    return course.submitted / ".whose.jsonl"
