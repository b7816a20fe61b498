"""Collect the files of one student: place each one for its lesson, or ask about it."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from datetime import datetime
from pathlib import Path

from grader.classroom.collect import inspection
from grader.classroom.collect.answers import Answers
from grader.classroom.collect.identification import (
    Contradiction,
    Unrecognised,
    is_lesson,
    lesson_of,
)
from grader.classroom.collect.inspection import (
    MODULE,
    NOTEBOOK,
    OTHER,
    TOO_MUCH_OF_A_STUDENT,
    look_at,
)
from grader.classroom.collect.outcome import ASKED, CollectionReport, Question
from grader.classroom.collect.protocol import SubmittedFile
from grader.classroom.collect.selection import File, newest
from grader.classroom.collect.storage import KEPT, StageFolder, UnclearVersion
from grader.classroom.collect.worksheet import SubmissionRow
from grader.classroom.contents import lesson_by_name
from grader.classroom.submissions import Submission
from grader.course.lessons import Lesson
from grader.course.paths import Course


class StudentCollector:
    """Places the files of one student.

    Parameters
    ----------
    course : grader.course.paths.Course
    id : str
    there : dict of Lesson to Submission
        The student's submissions in ``submitted/``.
    answers : Answers
    outcome : CollectionReport
        Results are added to it.
    """

    def __init__(
        self,
        course: Course,
        id: str,
        there: dict[Lesson, Submission],
        answers: Answers,
        outcome: CollectionReport,
    ) -> None:
        self._course, self._id, self._there = course, id, there
        self._answers, self._outcome = answers, outcome
        self._states = outcome.states.setdefault(id, {})
        self._doubts: list[tuple[Question, Lesson | None]] = []

    def collect(
        self, handed: Sequence[tuple[Path, SubmittedFile]], rows: Sequence[SubmissionRow] | None
    ) -> None:
        """Place all files of the student.

        Parameters
        ----------
        handed : sequence of (pathlib.Path, SubmittedFile)
            Each submitted file with its archive.
        rows : sequence of SubmissionRow, or None
            Rows of the table of times about the student; None without a table.
        """
        files = self._files(handed)
        notebooks = self._by_lesson(files)
        time = _time(handed, rows)
        folders: dict[str, StageFolder] = {}
        for lesson, several in sorted(notebooks.items(), key=lambda pair: pair[0].name):
            if lesson in self._outcome.lessons:
                folder = folders.setdefault(lesson.stage, self._folder(lesson.stage, *time))
                self._states[lesson] = self._place(folder, lesson, several, files)
            else:
                self._tell_other_stage(lesson, several)
        self._note_times(folders.values())
        if not notebooks and not self._doubts:
            names = ", ".join(dict.fromkeys(one.path[-1] for _, one in handed))
            self._doubt(handed[0][1].owner.label, f"handed in no notebook: {names}")
        self._tell_doubts()

    def _files(self, handed: Sequence[tuple[Path, SubmittedFile]]) -> list[File]:
        """Return notebooks and modules; files in place of a notebook become doubts."""
        files, size = [], 0
        for archive, one in handed:
            if one.remark:
                self._doubt(one.name, one.remark)
                continue
            pieces = look_at(one.entry, one.path[-1])
            size += sum(len(piece.data) for piece in pieces)
            if size > inspection.MOST_BYTES_OF_A_STUDENT:
                text = f"with what they handed in beside it is {TOO_MUCH_OF_A_STUDENT}"
                self._doubt(one.name, text, lesson_by_name(one.path[-1]))
                continue
            for piece in pieces:
                file = File(archive, one, piece)
                if piece.kind == OTHER:
                    self._outcome.left[file.path[-1]] += 1
                elif piece.kind in (NOTEBOOK, MODULE):
                    files.append(file)
                else:
                    lesson = lesson_by_name(file.path[-1])
                    wish = f"{lesson.name}.ipynb" if lesson else "the .ipynb file"
                    text = piece.complaint or f"is no notebook: ask for {wish}"
                    self._doubt(file.name, text, lesson)
        return files

    def _by_lesson(self, files: Sequence[File]) -> dict[Lesson, list[File]]:
        """Return the notebooks by lesson, and ask about those whose lesson is unknown."""
        found: dict[Lesson, list[File]] = {}
        for file in files:
            if file.piece.kind != NOTEBOOK:
                continue
            if file.handed.given and file.piece.content.untouched:
                self._outcome.left[file.path[-1]] += 1
                continue
            try:
                lesson = self._answers.lessons.get(file.name) or lesson_of(
                    file, self._there, self._is_placed
                )
            except Unrecognised as doubt:
                self._doubt(file.name, str(doubt))
            except Contradiction as question:
                self._states.update(dict.fromkeys(question.lessons, ASKED))
                self._outcome.ask(file.name, str(question))
            else:
                found.setdefault(lesson, []).append(file)
        return found

    def _place(
        self, folder: StageFolder, lesson: Lesson, several: list[File], files: list[File]
    ) -> str:
        """Place the newest of some files for a lesson, with its modules; return the result."""
        name = f"{lesson.name}.ipynb"
        answered = [file for file in several if file.name in self._answers.lessons]
        outdated = folder.outdated(name)
        best = newest(answered or [one for one in several if one.digest not in outdated] or several)
        if len(best) > 1:
            names = ", ".join(file.name for file in best[1:])
            self._outcome.ask(
                best[0].name,
                f"is for {lesson.name}, as is {names}, and nothing tells which is newer. Add "
                f"{is_lesson(best[0], lesson.number)}, or the same for the other",
            )
            return ASKED
        file = best[0]
        if answered:
            outdated = {one.digest for one in several} - {file.digest}
        source = dataclasses.replace(file.source, beaten=tuple(sorted(outdated)))
        try:
            state = folder.place(name, file.piece.data, source, self._there.get(lesson))
        except UnclearVersion as question:
            self._outcome.ask(file.name, str(question))
            return ASKED
        if state != KEPT:
            self._place_modules(folder, file, files)
        return state

    def _place_modules(self, folder: StageFolder, notebook: File, files: list[File]) -> None:
        """Place the modules next to a notebook, which may import them."""
        beside: dict[str, list[File]] = {}
        for file in files:
            if file.piece.kind == MODULE and file.lies_beside(notebook):
                beside.setdefault(file.path[-1], []).append(file)
        for name, several in beside.items():
            file = newest(several)[0]
            try:
                folder.place(name, file.piece.data, file.source)
            except UnclearVersion as question:
                self._outcome.ask(file.name, str(question))

    def _tell_other_stage(self, lesson: Lesson, several: list[File]) -> None:
        """Ask about files that were submitted with the wrong stage, unless they are in place.

        Unchanged notebooks are ignored, because some students submit the whole course.
        """
        worked = [file for file in several if not file.piece.content.untouched]
        several = [file for file in worked if not self._is_placed(lesson, file)]
        if not several:
            return
        text = f"belongs to {lesson.stage}. To place it there, add --stage {lesson.stage}"
        if lesson in self._there:
            self._outcome.remarks.append(Question(several[0].name, text))
        else:
            self._outcome.ask(several[0].name, text)

    def _note_times(self, folders: Iterable[StageFolder]) -> None:
        """Write the submission time if it is known, and report why if it is not."""
        for folder in folders:
            reason = folder.note_time()
            if reason:
                self._outcome.undecided[self._id] = reason
            elif folder.is_late() and not (folder.path / "timestamp.txt").is_file():
                self._outcome.late.append(self._id)

    def _tell_doubts(self) -> None:
        """Ask about files in place of a notebook, if a notebook is missing."""
        missing = [
            lesson
            for lesson in self._outcome.lessons
            if lesson not in self._states and lesson not in self._there
        ]
        for question, lesson in self._doubts:
            named = lesson in self._outcome.lessons
            is_open = lesson in missing if named else bool(missing)
            (self._outcome.questions if is_open else self._outcome.remarks).append(question)

    def _doubt(self, name: str, text: str, lesson: Lesson | None = None) -> None:
        self._doubts.append((Question(name, text), lesson))

    def _is_placed(self, lesson: Lesson, file: File) -> bool:
        """Return whether this file was collected for a lesson earlier."""
        return self._folder(lesson.stage).holds(f"{lesson.name}.ipynb", file.digest)

    def _folder(self, stage: str, when: datetime | None = None, undecided: str = "") -> StageFolder:
        return StageFolder(self._course.submitted / self._id / stage, when, undecided)


def _time(
    handed: Sequence[tuple[Path, SubmittedFile]], rows: Sequence[SubmissionRow] | None
) -> tuple[datetime | None, str]:
    """Return when a student submitted, and why that is unknown if it is."""
    times = [row.when for row in rows or () if row.when]
    if times:
        return max(times), ""
    if rows:
        return None, f"for a time, the table of times has {rows[0].said or 'nothing'!r}"
    # A platform that marks late work says that the rest is on time: a table of it suffices.
    if rows is None or all(one.late is False for _, one in handed):
        return None, ""
    return None, "the table of times has no line about them, or more than one"
