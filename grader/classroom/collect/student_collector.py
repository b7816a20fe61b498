"""Collect the files of one student: store each notebook by lesson, or ask the instructor."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from pathlib import Path

from grader.classroom.collect import inspection
from grader.classroom.collect.collection_report import UNANSWERED_MARK, CollectionReport, Question
from grader.classroom.collect.identification import (
    ContradictoryLesson,
    UnrecognisedLesson,
    identify_lesson,
    lesson_option,
)
from grader.classroom.collect.inspection import (
    MODULE,
    NOTEBOOK,
    OTHER,
    TOO_LARGE,
    unpack_file,
)
from grader.classroom.collect.instructor_answers import InstructorAnswers
from grader.classroom.collect.models import SubmittedFile
from grader.classroom.collect.selection import StudentFile, find_newest, rivals_by_copy_number
from grader.classroom.collect.stated_time import NOTHING_STATED, StatedTime
from grader.classroom.collect.storage import KEPT, StageFolder, UnclearVersion
from grader.classroom.collect.submission_table import SubmissionRow
from grader.classroom.lesson_recognition import contains_work, lesson_by_name
from grader.classroom.submissions import Submission
from grader.classroom.timestamp_file import TIMESTAMP_FILE
from grader.course.lessons import Lesson
from grader.course.paths import Course

_TABLE_NAME = "the table of submission times"


class StudentCollector:
    """Places the files of one student in ``submitted/``.

    Parameters
    ----------
    course : grader.course.paths.Course
    id : str
    existing : dict of Lesson to Submission
        The student's submissions in ``submitted/``.
    answers : InstructorAnswers
    report : CollectionReport
        The report to which results are added.
    """

    def __init__(
        self,
        course: Course,
        id: str,
        existing: dict[Lesson, Submission],
        answers: InstructorAnswers,
        report: CollectionReport,
    ) -> None:
        self._course, self._id, self._existing = course, id, existing
        self._answers, self._report = answers, report
        self._states = report.states.setdefault(id, {})
        self._problems: list[tuple[Question, Lesson | None]] = []

    def collect(
        self, submitted: Sequence[tuple[Path, SubmittedFile]], rows: Sequence[SubmissionRow] | None
    ) -> None:
        """Place all files of this student in ``submitted/``.

        Parameters
        ----------
        submitted : sequence of (pathlib.Path, SubmittedFile)
            Each submitted file with its archive.
        rows : sequence of SubmissionRow, or None
            The student's rows in the table of submission times; None without a table.
        """
        files = self._unpack_files(submitted)
        notebooks = self._group_by_lesson(files)
        stated = _stated_time(submitted, rows)
        folders: dict[str, StageFolder] = {}
        for lesson, candidates in sorted(notebooks.items(), key=lambda pair: pair[0].name):
            if lesson in self._report.lessons:
                folder = folders.setdefault(lesson.stage, self._folder(lesson.stage, stated))
                self._states[lesson] = self._place_lesson(folder, lesson, candidates, files)
            else:
                self._ask_about_other_stage(lesson, candidates)
        if stated.when and folders:
            self._report.students_with_time.append(self._id)
        self._write_times(folders.values())
        if not notebooks and not self._problems:
            self._report_missing_work([file for _, file in submitted])
        self._report_problems()

    def _unpack_files(self, submitted: Sequence[tuple[Path, SubmittedFile]]) -> list[StudentFile]:
        """Return notebooks and modules; record files sent instead of a notebook as problems."""
        files, size = [], 0
        for archive, submitted_file in submitted:
            if submitted_file.remark:
                if self._answers.is_ignored(submitted_file.name):
                    self._report.ignored[submitted_file.path[-1]] += 1
                else:
                    self._add_problem(submitted_file.name, submitted_file.remark)
                continue
            unpacked_files = unpack_file(submitted_file.entry, submitted_file.path[-1])
            size += sum(len(unpacked.data) for unpacked in unpacked_files)
            if size > inspection.MAX_BYTES_PER_STUDENT:
                total = f"brings the student's total to {TOO_LARGE}"
                text = f"{total}. Ask for smaller files"
                self._add_problem(
                    submitted_file.name, text, lesson_by_name(submitted_file.path[-1])
                )
                continue
            for unpacked in unpacked_files:
                file = StudentFile(archive, submitted_file, unpacked)
                if unpacked.kind == OTHER or self._is_ignored(file):
                    self._report.ignored[file.path[-1]] += 1
                elif unpacked.kind in (NOTEBOOK, MODULE):
                    files.append(file)
                else:
                    lesson = lesson_by_name(file.path[-1])
                    wanted_file = f"{lesson.name}.ipynb" if lesson else "the .ipynb file"
                    text = unpacked.complaint or f"is not a notebook. Ask for {wanted_file}"
                    self._add_problem(file.name, text, lesson)
        return files

    def _is_ignored(self, file: StudentFile) -> bool:
        content = file.digest if file.unpacked.data else ""
        ignored = self._answers.is_ignored(file.name, content)
        if ignored and content:
            self._report.ignored_files.add((file.name, content))
        return ignored

    def _group_by_lesson(self, files: Sequence[StudentFile]) -> dict[Lesson, list[StudentFile]]:
        """Return the notebooks by lesson, and ask about notebooks whose lesson is unknown."""
        notebooks: dict[Lesson, list[StudentFile]] = {}
        for file in files:
            if file.unpacked.kind != NOTEBOOK:
                continue
            if file.submitted.is_given and file.unpacked.content.untouched:
                self._report.ignored[file.path[-1]] += 1
                continue
            try:
                lesson = self._answers.lessons.get(file.name) or identify_lesson(
                    file, self._existing, self._is_placed
                )
            except UnrecognisedLesson as problem:
                self._add_problem(file.name, str(problem))
            except ContradictoryLesson as question:
                self._states.update(dict.fromkeys(question.lessons, UNANSWERED_MARK))
                self._report.add_question(file.name, str(question))
            else:
                notebooks.setdefault(lesson, []).append(file)
        return notebooks

    def _place_lesson(
        self,
        folder: StageFolder,
        lesson: Lesson,
        candidates: list[StudentFile],
        files: list[StudentFile],
    ) -> str:
        """Place a lesson's newest file with its modules, and return the state of the lesson."""
        name = f"{lesson.name}.ipynb"
        has_answer = [file for file in candidates if file.name in self._answers.lessons]
        rejected_digests = folder.rejected_digests(name)
        choices = (
            has_answer
            or [file for file in candidates if file.digest not in rejected_digests]
            or candidates
        )
        newest_files = find_newest(choices)
        if len(newest_files) > 1:
            names = ", ".join(file.name for file in newest_files[1:])
            self._report.add_question(
                newest_files[0].name,
                f"belongs to {lesson.name}, like {names}. It is unknown which is newer. Add "
                f"{lesson_option(newest_files[0], lesson.number)}, or the same option for the "
                "other file",
            )
            return UNANSWERED_MARK
        file = newest_files[0]
        if has_answer:
            rejected_digests = {candidate.digest for candidate in candidates} - {file.digest}
        origin = dataclasses.replace(file.origin, beaten=tuple(sorted(rejected_digests)))
        current = self._existing.get(lesson)
        may_replace_work = has_answer or not file.unpacked.content.untouched
        if current and not may_replace_work and contains_work(current.path):
            text = (
                "contains no work, so the notebook that was collected earlier still counts. To use "
                f"this file, add {lesson_option(file, lesson.number)}"
            )
            self._report.remarks.append(Question(file.name, text))
            return KEPT
        try:
            state = folder.place(name, file.unpacked.data, origin, current)
        except UnclearVersion as question:
            self._report.add_question(file.name, str(question))
            return UNANSWERED_MARK
        if state != KEPT:
            self._place_modules(folder, file, files)
            for rival in rivals_by_copy_number(choices, file):
                text = (
                    f"counts instead of {rival.name}, because the number in its name is higher. If "
                    f"the other file is the right one, add {lesson_option(rival, lesson.number)}"
                )
                self._report.remarks.append(Question(file.name, text))
        if file.unpacked.complaint:
            text = (
                f"{file.unpacked.complaint}. It was collected, and the judge will give it 0 points"
            )
            self._report.remarks.append(Question(file.name, text))
        for sentence in file.unpacked.content.repairs:
            text = f"is damaged. It was collected, and the judge will say: {sentence.rstrip('.')}"
            self._report.remarks.append(Question(file.name, text))
        return state

    def _place_modules(
        self, folder: StageFolder, notebook: StudentFile, files: list[StudentFile]
    ) -> None:
        """Place the modules from a notebook's folder, because the notebook may import them."""
        modules: dict[str, list[StudentFile]] = {}
        for file in files:
            if file.unpacked.kind == MODULE and file.is_next_to(notebook):
                modules.setdefault(file.path[-1], []).append(file)
        for name, candidates in modules.items():
            file = find_newest(candidates)[0]
            try:
                folder.place(name, file.unpacked.data, file.origin)
            except UnclearVersion as question:
                self._report.add_question(file.name, str(question))

    def _ask_about_other_stage(self, lesson: Lesson, candidates: list[StudentFile]) -> None:
        """Ask about files submitted with the wrong stage, unless they were collected before.

        Unchanged notebooks are ignored, because some students submit the whole course.
        """
        changed = [file for file in candidates if not file.unpacked.content.untouched]
        candidates = [file for file in changed if not self._is_placed(lesson, file)]
        if not candidates:
            return
        text = f"belongs to {lesson.stage}. To collect it, add --stage {lesson.stage}"
        if lesson in self._existing:
            self._report.remarks.append(Question(candidates[0].name, text))
        else:
            self._report.add_question(candidates[0].name, text)

    def _write_times(self, folders: Iterable[StageFolder]) -> None:
        """Write the submission time of each folder, or report why it is unknown."""
        for folder in folders:
            reason = folder.write_time()
            if reason:
                self._report.undecided[self._id] = reason
            elif folder.is_late() and not (folder.path / TIMESTAMP_FILE).is_file():
                self._report.late_students.append(self._id)
            remark = folder.time_remark()
            if remark:
                self._report.remarks.append(Question(self._id, remark))

    def _report_missing_work(self, submitted: Sequence[SubmittedFile]) -> None:
        """Ask about the files of a student who submitted no notebook with work."""
        if any(self._answers.is_ignored(file.name) for file in submitted):
            return
        names = list(dict.fromkeys(file.path[-1] for file in submitted))
        if all(file.is_given for file in submitted):
            text = "contains no notebook that the student changed"
            self._report.remarks.append(Question(submitted[0].owner.label, text))
        else:
            more = ", …" if len(names) > 5 else ""
            text = f"is not a notebook. The student submitted only: {', '.join(names[:5])}{more}"
            self._add_problem(submitted[0].name, text)

    def _report_problems(self) -> None:
        """Report each problem as a question if a notebook is missing, otherwise as a remark."""
        missing = [
            lesson
            for lesson in self._report.lessons
            if lesson not in self._states and lesson not in self._existing
        ]
        for question, lesson in self._problems:
            is_wanted = lesson in self._report.lessons
            is_open = lesson in missing if is_wanted else bool(missing)
            (self._report.questions if is_open else self._report.remarks).append(question)

    def _add_problem(self, name: str, text: str, lesson: Lesson | None = None) -> None:
        self._problems.append((Question(name, text), lesson))

    def _is_placed(self, lesson: Lesson, file: StudentFile) -> bool:
        """Return whether this file was collected for a lesson earlier."""
        return self._folder(lesson.stage).has_collected(f"{lesson.name}.ipynb", file.digest)

    def _folder(self, stage: str, stated: StatedTime = NOTHING_STATED) -> StageFolder:
        return StageFolder(self._course.submitted / self._id / stage, stated)


def _stated_time(
    submitted: Sequence[tuple[Path, SubmittedFile]], rows: Sequence[SubmissionRow] | None
) -> StatedTime:
    """Return when a student submitted according to the table of submission times."""
    for row in rows or ():
        if row.time_problem:
            return StatedTime(None, row.time_text, f"{_TABLE_NAME} {row.time_problem}")
    timed = [row for row in rows or () if row.when]
    if timed:
        latest = max(timed, key=lambda row: row.when)
        return StatedTime(latest.when, latest.time_text)
    if rows:
        return StatedTime(undecided=f"{_TABLE_NAME} has no time for this student")
    # If the platform marks late work, all other work is on time and needs no row in the table.
    if rows is None or all(file.late is False for _, file in submitted):
        return StatedTime()
    return StatedTime(undecided=f"{_TABLE_NAME} has no row or several rows for this student")
