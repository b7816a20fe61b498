"""Collect: from archives to ``submitted/``, a student at a time; what cannot be placed is asked."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from grader.classroom.collect import open_all
from grader.classroom.collect.choosing import File, newest
from grader.classroom.collect.looking import MODULE, NOTEBOOK, OTHER, kind_of, look_at
from grader.classroom.collect.owners import Owners, Unknown
from grader.classroom.collect.placing import KEPT, StageFolder, Unsure
from grader.classroom.collect.protocol import CollectTrouble, Handed, Owner
from grader.classroom.collect.worksheet import Worksheet, read_worksheet
from grader.classroom.contents import lesson_by_name
from grader.classroom.submissions import find_submissions
from grader.course.deadlines import read_deadlines
from grader.course.lessons import Lesson, all_lessons, find_lesson
from grader.course.paths import Course
from grader.course.roster import Roster, read_roster

ASKED = "?"


@dataclass(frozen=True)
class Question:
    """What waits for somebody.

    Attributes
    ----------
    name : str
        Of a file, or of whoever handed it in.
    text : str
        What is the matter, and what to do; goes on where `name` ends.
    """

    name: str
    text: str


@dataclass
class Outcome:
    """What became of everything.

    Attributes
    ----------
    lessons : list of Lesson
        That could be handed in.
    archives : list of (pathlib.Path, str, int)
        With the kind of each, and how many files are in it.
    roster : Roster or None
    states : dict of str to (dict of Lesson to str)
        By student: "new", "newer", "same", "kept", or "?" where a question has to be answered.
    questions, remarks : list of Question
        What has to be answered, and what only shall be known.
    left : collections.Counter
        Names of files that no lesson needs.
    late : list of str
        Students whose work the learning platform marks late, and of whom no time is known.
    undecided : dict of str to str
        By student, why nobody knows when the work was handed in.
    """

    lessons: list[Lesson]
    archives: list[tuple[Path, str, int]] = field(default_factory=list)
    roster: Roster | None = None
    states: dict[str, dict[Lesson, str]] = field(default_factory=dict)
    questions: list[Question] = field(default_factory=list)
    remarks: list[Question] = field(default_factory=list)
    left: Counter = field(default_factory=Counter)
    late: list[str] = field(default_factory=list)
    undecided: dict[str, str] = field(default_factory=dict)


def collect(
    course: Course,
    paths: Sequence[Path],
    stages: Sequence[str],
    timestamps: Path | None,
    who: dict[str, str],
    lessons: dict[str, str],
    progress: Callable[[int, int, object], None],
) -> Outcome:
    """Collect what a class handed in.

    Parameters
    ----------
    course : grader.course.paths.Course
    paths : sequence of pathlib.Path
        Archives.
    stages : sequence of str
    timestamps : pathlib.Path or None
        A table of times.
    who, lessons : dict of str to str
        Answers to questions, as they were typed.
    progress : callable
        Called with (done, total, None) after each student.

    Raises
    ------
    CollectTrouble, grader.course.roster.RosterTrouble, grader.course.deadlines.DeadlinesTrouble
    """
    roster = read_roster(course)
    deadlines = read_deadlines(course)
    zone = deadlines.zone if deadlines else None
    worksheet = read_worksheet(timestamps, zone) if timestamps else Worksheet()
    answers = {label: tuple(ids.split(",")) for label, ids in who.items()}
    owners = Owners(roster, worksheet, answers)
    collector = Collector(course, stages, owners, _lessons(lessons), timestamps is not None)
    opened = open_all(paths)
    outcome = collector.collect(
        [(path, one) for path, _, handed in opened for one in handed], progress
    )
    outcome.archives = [(path, kind, len(handed)) for path, kind, handed in opened]
    outcome.roster = roster
    return outcome


def _lessons(answers: dict[str, str]) -> dict[str, Lesson]:
    """Lessons that were named by number or name."""
    found = {}
    for file, answer in answers.items():
        lesson = next((one for one in all_lessons() if answer in (one.number, one.name)), None)
        if lesson is None:
            raise CollectTrouble(f"--lesson {shlex.quote(file)}=…: there is no lesson {answer}.")
        found[file] = lesson
    return found


class Collector:
    """Places what was handed in for some stages.

    Parameters
    ----------
    course : grader.course.paths.Course
    stages : sequence of str
    owners : Owners
    lessons : dict of str to Lesson
        Answers of whoever collects: what a file is for, by its name.
    timed : bool
        Whether there is a table of times.
    """

    def __init__(
        self,
        course: Course,
        stages: Sequence[str],
        owners: Owners,
        lessons: dict[str, Lesson],
        timed: bool,
    ) -> None:
        self._course, self._stages, self._owners = course, tuple(stages), owners
        self._lessons, self._timed = lessons, timed
        self._wanted = [lesson for lesson in all_lessons() if lesson.stage in self._stages]
        self._there = {
            (submission.student, submission.lesson): submission
            for submission in find_submissions(course)
        }
        self.outcome = Outcome(self._wanted)

    def collect(
        self,
        handed: Sequence[tuple[Path, Handed]],
        progress: Callable[[int, int, object], None],
    ) -> Outcome:
        """Place all that was handed in.

        Parameters
        ----------
        handed : sequence of (pathlib.Path, Handed)
            With the archive that it is in.
        progress : callable
            Called with (done, total, None) after each student.
        """
        students: dict[str, list[tuple[Path, Handed]]] = {}
        for ids, mine in self._by_owner(handed):
            for id in ids:
                students.setdefault(id, []).extend(mine)
        for done, (student, mine) in enumerate(sorted(students.items())):
            progress(done, len(students), None)
            self._collect_from(student, mine)
        progress(len(students), len(students), None)
        return self.outcome

    def _by_owner(
        self, handed: Sequence[tuple[Path, Handed]]
    ) -> Iterable[tuple[tuple[str, ...], list[tuple[Path, Handed]]]]:
        """What each handed in, with the ids of whom it is."""
        groups: dict[tuple[Path, Owner], list[tuple[Path, Handed]]] = {}
        for archive, one in handed:
            groups.setdefault((archive, one.owner), []).append((archive, one))
        found: dict[tuple[Path, Owner], tuple[str, ...]] = {}
        for (archive, owner), mine in groups.items():
            nobody = owner.label in (archive.name, archive.stem)  # the archive's own files
            if nobody and all(_is_of_no_use(one) for _, one in mine):
                self.outcome.left.update(one.path[-1] for _, one in mine)
                continue
            try:
                found[archive, owner] = self._owners.whose(owner)
            except Unknown as question:
                self._ask(owner.label, f"{_files(len(mine))} of theirs. {question}")
        for (archive, owner), ids in found.items():
            same = [
                other
                for (place, other), theirs in found.items()
                if place == archive and set(ids) & set(theirs)
            ]
            question = self._owners.doubt(owner, ids, [one for one in same if one != owner])
            if question:
                self._ask(owner.label, question)
            if len(same) == 1 or all(map(self._owners.is_answered, same)):
                yield ids, groups[archive, owner]

    def _collect_from(self, student: str, handed: list[tuple[Path, Handed]]) -> None:
        """Place all of one student's."""
        states = self.outcome.states.setdefault(student, {})
        files, doubtful = self._files(handed)
        notebooks: dict[Lesson, list[File]] = {}
        for file in files:
            if file.piece.kind != NOTEBOOK:
                continue
            if file.handed.given and file.piece.content.untouched:
                self.outcome.left[file.path[-1]] += 1
                continue
            lesson = self._lesson_of(student, file, states)
            if isinstance(lesson, str):
                doubtful.append(Question(file.name, lesson))
            elif lesson:
                notebooks.setdefault(lesson, []).append(file)
        folders: dict[str, StageFolder] = {}
        for lesson, several in sorted(notebooks.items(), key=lambda pair: pair[0].name):
            if lesson.stage in self._stages:
                folder = folders.setdefault(lesson.stage, self._folder(student, lesson.stage))
                states[lesson] = self._place(student, folder, lesson, several, files)
            else:
                self._tell_other_stage(student, lesson, several)
        self._note_times(student, handed, folders)
        missing = [
            lesson
            for lesson in self._wanted
            if lesson not in states and (student, lesson) not in self._there
        ]
        if not notebooks and not doubtful:
            names = ", ".join(dict.fromkeys(one.path[-1] for _, one in handed))
            doubtful.append(Question(handed[0][1].owner.label, f"handed in no notebook: {names}"))
        (self.outcome.questions if missing else self.outcome.remarks).extend(doubtful)

    def _files(self, handed: list[tuple[Path, Handed]]) -> tuple[list[File], list[Question]]:
        """Notebooks and modules, and what may have been meant to be one."""
        files, doubtful = [], []
        for archive, one in handed:
            if one.remark:
                doubtful.append(Question(one.name, one.remark))
                continue
            for piece in look_at(one.entry, one.path[-1]):
                file = File(archive, one, piece)
                if piece.kind == OTHER:
                    self.outcome.left[file.path[-1]] += 1
                elif piece.kind in (NOTEBOOK, MODULE):
                    files.append(file)
                else:
                    doubtful.append(Question(file.name, piece.complaint or _meant(file)))
        return files, doubtful

    def _lesson_of(
        self, student: str, file: File, states: dict[Lesson, str]
    ) -> Lesson | str | None:
        """What a notebook is for; a doubt about it; or None where a question was asked."""
        answer = self._lessons.get(file.name)
        if answer:
            return answer
        named = lesson_by_name(file.path[-1])
        inside = find_lesson(file.piece.content.lesson)
        if named and inside and named != inside:
            if self._is_placed(student, named, file):
                return named
            if (student, named) in self._there and self._is_placed(student, inside, file):
                return inside
            states[named] = states[inside] = ASKED
            self._ask(
                file.name,
                f"is called {named.name}, and says inside that it is {inside.name}. Look at it, "
                f"and add {_is_lesson(file, inside.number)} or {_is_lesson(file, named.number)}",
            )
            return None
        if named or inside:
            return named or inside
        complaint = file.piece.complaint
        return (f"{complaint}. " if complaint else "names no lesson, and holds none. ") + (
            f"If it is one, add {_is_lesson(file, 'NN')}"
        )

    def _place(
        self,
        student: str,
        folder: StageFolder,
        lesson: Lesson,
        several: list[File],
        files: list[File],
    ) -> str:
        """Place the newest of some files for a lesson, and its modules; how that went."""
        answered = [file for file in several if file.name in self._lessons]
        best = newest(answered or several)
        if len(best) > 1:
            names = ", ".join(file.name for file in best[1:])
            self._ask(
                best[0].name,
                f"is for {lesson.name}, as is {names}, and nothing tells which is newer. Add "
                f"{_is_lesson(best[0], lesson.number)}, or the same for the other",
            )
            return ASKED
        file = best[0]
        there = self._there.get((student, lesson))
        try:
            state = folder.place(f"{lesson.name}.ipynb", file.piece.data, file.source, there)
        except Unsure as question:
            self._ask(file.name, str(question))
            return ASKED
        if state != KEPT:
            self._place_modules(folder, file, files)
        return state

    def _place_modules(self, folder: StageFolder, notebook: File, files: list[File]) -> None:
        """Place the modules that lie beside a notebook, which may import them."""
        beside: dict[str, list[File]] = {}
        for file in files:
            if file.piece.kind == MODULE and file.lies_beside(notebook):
                beside.setdefault(file.path[-1], []).append(file)
        for name, several in beside.items():
            file = newest(several)[0]
            try:
                folder.place(name, file.piece.data, file.source)
            except Unsure as question:
                self._ask(file.name, str(question))

    def _tell_other_stage(self, student: str, lesson: Lesson, several: list[File]) -> None:
        """Ask about files that were handed in with the wrong stage, unless they are there.

        What nobody worked in came with the course, of which somebody handed in all.
        """
        worked = [file for file in several if not file.piece.content.untouched]
        several = [file for file in worked if not self._is_placed(student, lesson, file)]
        if not several:
            return
        text = f"belongs to {lesson.stage}. To place it there, add --stage {lesson.stage}"
        if (student, lesson) in self._there:
            self.outcome.remarks.append(Question(several[0].name, text))
        else:
            self._ask(several[0].name, text)

    def _note_times(
        self,
        student: str,
        handed: list[tuple[Path, Handed]],
        folders: dict[str, StageFolder],
    ) -> None:
        """Write when it was handed in, where that is known, and keep in mind where it is not."""
        when, undecided = self._time(student, handed) if self._timed else (None, "")
        for folder in folders.values():
            reason = folder.note_time(when, undecided)
            if reason:
                self.outcome.undecided[student] = reason
            elif folder.is_late() and not (folder.path / "timestamp.txt").is_file():
                self.outcome.late.append(student)

    def _time(self, student: str, handed: list[tuple[Path, Handed]]) -> tuple[datetime | None, str]:
        """When a student handed in, and why nobody knows where nobody does."""
        owners = {one.owner for _, one in handed}
        rows = [row for owner in owners for row in self._owners.rows(owner, student)]
        times = [row.when for row in rows if row.when]
        if times:
            return max(times), ""
        if rows:
            return None, f"for a time, the table of times has {rows[0].said or 'nothing'!r}"
        return None, "the table of times has no line about them"

    def _is_placed(self, student: str, lesson: Lesson, file: File) -> bool:
        """Whether this very file was collected for a lesson before."""
        folder = self._folder(student, lesson.stage)
        return folder.holds(f"{lesson.name}.ipynb", file.digest)

    def _folder(self, student: str, stage: str) -> StageFolder:
        return StageFolder(self._course.submitted / student / stage)

    def _ask(self, name: str, text: str) -> None:
        question = Question(name, text)
        if question not in self.outcome.questions:  # a team's file is asked about once
            self.outcome.questions.append(question)


def _files(count: int) -> str:
    return "1 file" if count == 1 else f"{count} files"


def _is_of_no_use(handed: Handed) -> bool:
    name = handed.path[-1]
    return not handed.remark and kind_of(name) == OTHER


def _meant(file: File) -> str:
    lesson = lesson_by_name(file.path[-1])
    wish = f"{lesson.name}.ipynb" if lesson else "the .ipynb file"
    return f"is no notebook: ask for {wish}"


def _is_lesson(file: File, number: str) -> str:
    return f"--lesson {shlex.quote(f'{file.name}={number}')}"
