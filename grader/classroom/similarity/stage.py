"""Compare the functions that all students wrote for a stage."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from grader.classroom.collect.instructor_answers import teams_in
from grader.classroom.pages import printable_name
from grader.classroom.similarity.answers import (
    ComparedAnswer,
    NotebookParts,
    kept_answers,
    read_notebook_parts,
    suggested_answers,
)
from grader.classroom.similarity.comparison import Comparison, Pair, compare
from grader.classroom.submissions import find_submissions
from grader.course.lessons import all_lessons
from grader.course.paths import Course
from grader.course.roster import read_roster
from grader.intake.reader_process import ReadingFailed
from utils.notebooks.reading import UnreadableNotebook


@dataclass(frozen=True)
class SharedNotebook:
    """A notebook that several students submitted.

    Attributes
    ----------
    lesson : str
    students : tuple of str
    same_bytes : bool
        False if only the text of the cells is the same, and outputs or metadata differ.
    own_cells, all_cells : int
        The number of cells that differ from the release, and the total number of cells.
    """

    lesson: str
    students: tuple[str, ...]
    same_bytes: bool
    own_cells: int
    all_cells: int


@dataclass(frozen=True)
class StudentPair:
    """Two students, and the exercises to which their answers are similar."""

    students: tuple[str, str]
    pairs: tuple[Pair, ...]

    @property
    def bits(self) -> float:
        """How unusual the two students' similarities are in total, in bits."""
        return sum(pair.bits for pair in self.pairs)


@dataclass(frozen=True)
class StageComparison:
    """The comparison of all submissions for a stage.

    Attributes
    ----------
    stage : str
    students : tuple of str
        The students of this course whose work was compared, with their names.
    earlier_students : tuple of str
        The students of earlier courses.
    teams : tuple of (tuple of str)
        Declared teams, whose members are not compared with each other.
    notebook_count : int
    comparisons : tuple of Comparison
        One comparison for each exercise with at least one answer.
    answers : dict of (str, str) to ComparedAnswer
        Answers by exercise and student.
    shared_notebooks : tuple of SharedNotebook
    problems : tuple of (str, str, str)
        Student, lesson, and the reason why something was not compared.
    """

    stage: str
    students: tuple[str, ...]
    earlier_students: tuple[str, ...]
    teams: tuple[tuple[str, ...], ...]
    notebook_count: int
    comparisons: tuple[Comparison, ...]
    answers: Mapping[tuple[str, str], ComparedAnswer] = field(repr=False, hash=False)
    shared_notebooks: tuple[SharedNotebook, ...]
    problems: tuple[tuple[str, str, str], ...]

    @property
    def pairs(self) -> tuple[StudentPair, ...]:
        """Pairs of students with similar answers, the most unusual first."""
        pairs_by_students: dict[tuple[str, str], list[Pair]] = {}
        for comparison in self.comparisons:
            for pair in comparison.pairs:
                pairs_by_students.setdefault(pair.students, []).append(pair)
        pairs = (
            StudentPair(students, tuple(shared)) for students, shared in pairs_by_students.items()
        )
        return tuple(sorted(pairs, key=lambda pair: -pair.bits))


@dataclass(frozen=True)
class EarlierCourse(Course):
    """The folder of an earlier course; `root` may also be a folder of submissions."""

    @property
    def submitted(self) -> Path:
        """Folder of the submissions, ``<student>/<stage>/<NN_name>.ipynb``."""
        folder = self.root / "submitted"
        return folder if folder.is_dir() else self.root


@dataclass(frozen=True)
class _StudentNotebook:
    """The parts of one student's notebook, with the student's name as shown on the page."""

    student: str
    lesson: str
    digest: str
    parts: NotebookParts


@dataclass(frozen=True)
class _ExemptStudents:
    """The students who are not compared with each other."""

    earlier: frozenset[str]
    teams: tuple[frozenset[str], ...]

    def belong_together(self, students: Collection[str]) -> bool:
        """Return whether all of these students are in the same team, or all in earlier courses."""
        return any(group.issuperset(students) for group in (self.earlier, *self.teams))


def earlier_course(folder: Path) -> EarlierCourse:
    """Return the earlier course in `folder`, which may also be the course's ``submitted/``."""
    folder = folder.resolve()
    return EarlierCourse(folder.parent if folder.name == "submitted" else folder)


def compare_stage(
    course: Course,
    stage: str,
    advance: Callable[[int, int, object], None] = lambda *_: None,
    earlier_courses: Sequence[EarlierCourse] = (),
) -> StageComparison:
    """Compare the submissions for a stage.

    Parameters
    ----------
    course : grader.course.paths.Course
    stage : str
    advance : callable, optional
        Called with (done, total, None) before each notebook and at the end.
    earlier_courses : sequence of EarlierCourse, optional
        Courses whose students are compared with those of `course`, but not with each other.
    """
    names = _student_names(course)
    labelled_submissions = [
        (source, submission, _label(source, submission.student, names))
        for source in (course, *earlier_courses)
        for submission in find_submissions(source, [stage])
    ]
    read_notebooks: list[_StudentNotebook] = []
    problems = []
    for number, (source, submission, student) in enumerate(labelled_submissions):
        advance(number, len(labelled_submissions), None)
        lesson = submission.lesson.name
        submitted_files = submission.read(source)
        try:
            parts = read_notebook_parts(submitted_files, submission.lesson)
        except (UnreadableNotebook, ReadingFailed) as error:
            problems.append((student, lesson, str(error).splitlines()[0]))
            continue
        problems += [(student, lesson, sentence) for sentence in parts.problems]
        digest = hashlib.sha256(submitted_files.data).hexdigest()
        read_notebooks.append(_StudentNotebook(student, lesson, digest, parts))
    advance(len(labelled_submissions), len(labelled_submissions), None)
    answers = {
        (exercise, notebook.student): answer
        for notebook in read_notebooks
        for exercise, answer in notebook.parts.answers.items()
    }
    students = dict.fromkeys(
        student for source, _, student in labelled_submissions if source is course
    )
    earlier_students = dict.fromkeys(
        student for source, _, student in labelled_submissions if source is not course
    )
    teams = tuple(
        frozenset(_label(course, id, names) for id in team) for team in teams_in(course, stage)
    )
    exempt = _ExemptStudents(frozenset(earlier_students), teams)
    return StageComparison(
        stage,
        tuple(students),
        tuple(earlier_students),
        tuple(sorted(tuple(sorted(team)) for team in set(teams))),
        len(read_notebooks),
        tuple(_comparisons(stage, answers, exempt)),
        answers,
        tuple(_shared_notebooks(read_notebooks, exempt)),
        tuple(problems),
    )


def _student_names(course: Course) -> dict[str, str]:
    roster = read_roster(course)
    return {person.id: person.display_name for person in roster.people} if roster else {}


def _label(course: Course, student: str, names: Mapping[str, str]) -> str:
    """Return a student's ID with the name, or with the folder of an earlier course."""
    if isinstance(course, EarlierCourse):
        return printable_name(f"{course.root.name}/{student}")
    return printable_name(names.get(student, student))


def _comparisons(
    stage: str, answers: Mapping[tuple[str, str], ComparedAnswer], exempt: _ExemptStudents
) -> Iterator[Comparison]:
    written: dict[str, dict[str, ComparedAnswer]] = {}
    for (exercise, student), answer in answers.items():
        written.setdefault(exercise, {})[student] = answer
    for lesson in (lesson for lesson in all_lessons() if lesson.stage == stage):
        for name in (exercise.name for exercise in lesson.machine_graded):
            if name in written:
                kept, suggested = kept_answers(lesson)[name], suggested_answers(lesson)[name]
                compared = compare(name, written[name], kept, suggested)
                pairs = [
                    pair for pair in compared.pairs if not exempt.belong_together(pair.students)
                ]
                yield dataclasses.replace(compared, pairs=tuple(pairs))


def _shared_notebooks(
    read_notebooks: Iterable[_StudentNotebook], exempt: _ExemptStudents
) -> Iterator[SharedNotebook]:
    files: dict[tuple[str, str], list[str]] = {}
    sizes = {}
    for notebook in read_notebooks:
        if notebook.parts.cells:
            for digest in (notebook.digest, notebook.parts.cells):
                key = notebook.lesson, digest
                files.setdefault(key, []).append(notebook.student)
                sizes[key] = (
                    notebook.parts.own_cells,
                    notebook.parts.all_cells,
                    digest is notebook.digest,
                )
    reported = set()
    # Files with the same bytes come first, so that their equal cells are not reported again.
    for key, students in sorted(
        files.items(), key=lambda file: (file[0][0], not sizes[file[0]][2])
    ):
        group = key[0], frozenset(students)
        if len(students) > 1 and group not in reported and not exempt.belong_together(students):
            reported.add(group)
            own_cells, all_cells, same_bytes = sizes[key]
            yield SharedNotebook(key[0], tuple(students), same_bytes, own_cells, all_cells)
