"""Compare the functions that all students wrote for a stage."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from grader.classroom.pages import printable
from grader.classroom.similarity.answers import (
    ComparedAnswer,
    NotebookParts,
    kept_answers,
    read_notebook_parts,
    suggested_answers,
)
from grader.classroom.similarity.comparison import Comparison, Pair, compare
from grader.classroom.submissions import Submission, find_submissions
from grader.course.lessons import all_lessons
from grader.course.paths import Course
from grader.intake.reader_process import ReadingFailed
from utils.notebooks.reading import UnreadableNotebook


@dataclass(frozen=True)
class SameFile:
    """Students who submitted the same notebook.

    Attributes
    ----------
    lesson : str
    students : tuple of str
    same_bytes : bool
        False if only the text of the cells is the same, and outputs or metadata differ.
    own, all : int
        The number of cells that differ from the release, and the total number of cells.
    """

    lesson: str
    students: tuple[str, ...]
    same_bytes: bool
    own: int
    all: int


@dataclass(frozen=True)
class PairOfStudents:
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
        The students whose work was compared.
    notebooks : int
    comparisons : tuple of Comparison
        One comparison for each exercise with at least one answer.
    answers : dict of (str, str) to ComparedAnswer
        Answers by exercise and student.
    same_files : tuple of SameFile
    problems : tuple of (str, str, str)
        Student, lesson, and the reason why something was not compared.
    """

    stage: str
    students: tuple[str, ...]
    notebooks: int
    comparisons: tuple[Comparison, ...]
    answers: Mapping[tuple[str, str], ComparedAnswer] = field(repr=False, hash=False)
    same_files: tuple[SameFile, ...]
    problems: tuple[tuple[str, str, str], ...]

    @property
    def pairs(self) -> tuple[PairOfStudents, ...]:
        """Pairs of students with similar answers, the most unusual first."""
        found: dict[tuple[str, str], list[Pair]] = {}
        for comparison in self.comparisons:
            for pair in comparison.pairs:
                found.setdefault(pair.students, []).append(pair)
        pairs = (PairOfStudents(students, tuple(mine)) for students, mine in found.items())
        return tuple(sorted(pairs, key=lambda pair: -pair.bits))


def compare_stage(
    course: Course, stage: str, advance: Callable[[int, int, object], None] = lambda *_: None
) -> StageComparison:
    """Compare the submissions for a stage.

    Parameters
    ----------
    course : grader.course.paths.Course
    stage : str
    advance : callable, optional
        Called with (done, total, None) before each notebook and at the end.
    """
    submissions = find_submissions(course, [stage])
    read: list[tuple[Submission, str, NotebookParts]] = []
    problems = []
    for number, submission in enumerate(submissions):
        advance(number, len(submissions), None)
        student, lesson = printable(submission.student), submission.lesson.name
        submitted_files = submission.read(course)
        try:
            parts = read_notebook_parts(submitted_files, submission.lesson)
        except (UnreadableNotebook, ReadingFailed) as error:
            problems.append((student, lesson, str(error).splitlines()[0]))
            continue
        problems += [(student, lesson, sentence) for sentence in parts.problems]
        read.append((submission, hashlib.sha256(submitted_files.data).hexdigest(), parts))
    advance(len(submissions), len(submissions), None)
    answers = {
        (exercise, printable(submission.student)): answer
        for submission, _, parts in read
        for exercise, answer in parts.answers.items()
    }
    return StageComparison(
        stage,
        tuple(dict.fromkeys(printable(submission.student) for submission in submissions)),
        len(read),
        tuple(_comparisons(stage, answers)),
        answers,
        tuple(_same_files(read)),
        tuple(problems),
    )


def _comparisons(
    stage: str, answers: Mapping[tuple[str, str], ComparedAnswer]
) -> Iterable[Comparison]:
    written: dict[str, dict[str, ComparedAnswer]] = {}
    for (exercise, student), answer in answers.items():
        written.setdefault(exercise, {})[student] = answer
    for lesson in (lesson for lesson in all_lessons() if lesson.stage == stage):
        for name in (exercise.name for exercise in lesson.machine_graded):
            if name in written:
                kept, suggested = kept_answers(lesson)[name], suggested_answers(lesson)[name]
                yield compare(name, written[name], kept, suggested)


def _same_files(read: Iterable[tuple[Submission, str, NotebookParts]]) -> Iterable[SameFile]:
    files: dict[tuple[str, str], list[str]] = {}
    sizes = {}
    for submission, data, parts in read:
        if parts.cells:
            for digest in (data, parts.cells):
                key = submission.lesson.name, digest
                files.setdefault(key, []).append(printable(submission.student))
                sizes[key] = parts.own, parts.all, digest is data
    reported = set()
    # Files with the same bytes come first, so that their equal cells are not reported again.
    for key, students in sorted(
        files.items(), key=lambda file: (file[0][0], not sizes[file[0]][2])
    ):
        group = key[0], frozenset(students)
        if len(students) > 1 and group not in reported:
            reported.add(group)
            own, cells, same_bytes = sizes[key]
            yield SameFile(key[0], tuple(students), same_bytes, own, cells)
