"""The instructor's answers to questions about a file's owner or lesson.

Answers about owners are stored in ``submitted/.whose.jsonl``, one line for each student that an
answer names, so that the next archive of the stage does not raise the question again. A name in an
archive may be the name of another student, so only its digest is stored. Answers about lessons are
not stored, because the record in a student's folder already lists the collected files.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import re
import shlex
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.classroom.collect.models import CollectError
from grader.course.atomic_files import write_atomically
from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import Course
from grader.course.roster import Roster

NO_OWNER = "-"


@dataclass(frozen=True)
class InstructorAnswers:
    """The new and stored answers that apply.

    Attributes
    ----------
    owners : dict of str to (tuple of str)
        IDs of all owners, by the digest of the name of an owner or file; empty if the work does not
        belong to a student.
    lessons : dict of str to grader.course.lessons.Lesson
        Lessons by file name.
    earlier : frozenset of str
        Digests in `owners` whose answers were given earlier.
    """

    owners: dict[str, tuple[str, ...]]
    lessons: dict[str, Lesson]
    earlier: frozenset[str] = frozenset()

    def owners_of(self, name: str) -> tuple[str, ...] | None:
        """Return the IDs in the answer about an owner or file, or None without an answer."""
        return self.owners.get(_digest(name))

    def is_earlier(self, name: str) -> bool:
        """Return whether the answer about an owner was given earlier."""
        return _digest(name) in self.earlier

    def is_ignored(self, name: str, content: str = "") -> bool:
        """Return whether a file is to be ignored.

        Parameters
        ----------
        name : str
        content : str, optional
            SHA-256 of a notebook or module. The student may submit another one with the same name,
            so an answer that was given earlier applies only to the same content.
        """
        return (
            self.owners_of(_name_with_content(content, name) if self.is_earlier(name) else name)
            == ()
        )

    def teams_of(self, id: str) -> set[frozenset[str]]:
        """Return the teams of a student, as sets of IDs."""
        teams = {frozenset(ids) for ids in self.owners.values() if len(ids) > 1}
        return {team for team in teams if id in team}


def read_answers(
    course: Course,
    roster: Roster | None,
    stages: Sequence[str],
    owners: dict[str, str],
    lessons: dict[str, str],
) -> InstructorAnswers:
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
    stored_owners: dict[str, list[str]] = {}
    for stage, digest, id in _read_entries(course):
        if stage in stages and (roster is None or not id or roster.person(id)):
            stored_owners.setdefault(digest, []).extend([id] if id else [])
    new = {_digest(name): ids_in(answer) for name, answer in owners.items()}
    ids_by_digest = {
        digest: tuple(dict.fromkeys(ids)) for digest, ids in stored_owners.items()
    } | new
    return InstructorAnswers(
        ids_by_digest, _parse_lessons(lessons), frozenset(stored_owners.keys() - new.keys())
    )


def store_answers(course: Course, stages: Sequence[str], answers: InstructorAnswers) -> None:
    """Store the new answers about owners for these stages."""
    new = {digest: ids for digest, ids in answers.owners.items() if digest not in answers.earlier}
    _store(course, stages, new)


def store_ignored(
    course: Course, stages: Sequence[str], ignored: Iterable[tuple[str, str]]
) -> None:
    """Store the name and content of notebooks and modules that a new answer ignores."""
    _store(
        course,
        stages,
        {_digest(_name_with_content(content, name)): () for name, content in ignored},
    )


def store_teams(course: Course, stages: Sequence[str], teams: Iterable[tuple[str, ...]]) -> None:
    """Store the teams that an archive lists; `teams_in` treats them as declared."""
    _store(course, stages, {_digest("/".join(sorted(team))): team for team in teams})


def teams_in(course: Course, stage: str) -> list[frozenset[str]]:
    """Return the teams of a stage that answers or archives declare, as sets of IDs."""
    members: dict[str, set[str]] = {}
    for entry_stage, digest, id in _read_entries(course):
        if entry_stage == stage:
            members.setdefault(digest, set()).add(id)
    return [frozenset(ids) for ids in members.values() if len(ids) > 1]


def count_answers_about(course: Course, student: str) -> int:
    """Return the number of stored lines that name a student."""
    return sum(id == student for _, _, id in _read_entries(course))


def delete_answers_about(course: Course, student: str) -> None:
    """Delete the stored lines that name a student."""
    kept = [entry for entry in _read_entries(course) if entry[2] != student]
    write_atomically("".join(map(_json_line, kept)), _path(course))


def _store(course: Course, stages: Sequence[str], new: dict[str, tuple[str, ...]]) -> None:
    if not new:
        return
    entries = [
        entry for entry in _read_entries(course) if not (entry[0] in stages and entry[1] in new)
    ]
    for digest, ids in new.items():
        entries += [(stage, digest, id) for stage in stages for id in ids or ("",)]
    write_atomically("".join(map(_json_line, entries)), _path(course))


def ids_in(answer: str) -> tuple[str, ...]:
    """Split a typed answer about an owner into IDs; empty if no student owns the files."""
    return () if answer == NO_OWNER else tuple(answer.split(","))


def normalize_label(label: str) -> str:
    """Normalize a label for comparisons: NFC, lower case, no surrounding spaces."""
    return unicodedata.normalize("NFC", label).casefold().strip()


def _digest(name: str) -> str:
    """Return the SHA-256 of a name in an archive; names that differ only in case are equal."""
    return hashlib.sha256(normalize_label(name).encode("utf-8", "surrogatepass")).hexdigest()


def _name_with_content(content: str, name: str) -> str:
    return f"{name}/{content}" if content else name


def _parse_lessons(answers: dict[str, str]) -> dict[str, Lesson]:
    """Return the lesson that each answer names by number or name."""
    chosen_lessons = {}
    for file, answer in answers.items():
        lesson = next(
            (lesson for lesson in all_lessons() if answer in (lesson.number, lesson.name)), None
        )
        if lesson is None:
            raise CollectError(
                f"--lesson {shlex.quote(file)}=…: there is no lesson {answer}. Write the number "
                "of a lesson, such as 06."
            )
        chosen_lessons[file] = lesson
    return chosen_lessons


def _read_entries(course: Course) -> list[tuple[str, str, str]]:
    """Return the stage, the digest of the name, and the student ID in each readable line."""
    entries = []
    with contextlib.suppress(OSError, UnicodeDecodeError):
        for line in _path(course).read_text("utf-8").splitlines():
            with contextlib.suppress(ValueError, TypeError, KeyError):
                entry = json.loads(line)
                label = entry["label"]  # earlier versions stored the name itself
                digest = label if re.fullmatch("[0-9a-f]{64}", label) else _digest(label)
                entries.append((entry["stage"], digest, entry["student"]))
    return entries


def _json_line(entry: tuple[str, str, str]) -> str:
    stage, digest, id = entry
    return json.dumps({"student": id, "stage": stage, "label": digest}, ensure_ascii=False) + "\n"


def _path(course: Course) -> Path:
    return course.submitted / ".whose.jsonl"
