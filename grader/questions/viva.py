"""Make the questions of a class about one stage."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random

from grader.classroom.submissions import ReplacedSubmission, Submission, find_submissions
from grader.course.lessons import Exercise, Lesson
from grader.course.paths import Course
from grader.course.roster import read_roster
from grader.intake.preflight import prepare_to_judge
from grader.intake.reader_process import ReadingFailed
from grader.judging.verdict import JUDGED, read_verdict
from grader.questions.answer import Answer, ListedLine, observe
from grader.questions.helpers import called_helpers
from grader.questions.question import Question
from grader.questions.remarks import Remark, remarks_on
from grader.questions.selection import choose_questions, peer_outcomes
from grader.sandbox import Sandbox
from grader.sandbox.failures import StudentError, StudentStopped
from utils.notebooks.reading import UnreadableNotebook
from utils.questions.cases import cases_of

# A longer answer fills more than one page, so an exercise with a shorter answer is preferred.
MAX_LINES = 60


@dataclass(frozen=True)
class Sheet:
    """The questions for one student.

    Attributes
    ----------
    student, name : str
        The ID, and the name on the roster.
    exercise : str
        Empty if there are no questions.
    lines : tuple of ListedLine
        The student's code.
    questions : tuple of Question
    remarks : tuple of Remark
    problem : str
        The reason why there are no questions, or fewer than requested.
    helpers : tuple of str
        Functions and classes of the lesson that the code calls but that the sheet does not print.
    """

    student: str
    name: str
    exercise: str = ""
    lines: tuple[ListedLine, ...] = ()
    questions: tuple[Question, ...] = ()
    remarks: tuple[Remark, ...] = ()
    problem: str = ""
    helpers: tuple[str, ...] = ()


def viva_folder(course: Course, stage: str) -> Path:
    """Return the folder for the questions about a stage."""
    return course.root / "viva" / stage


def make_sheets(
    course: Course,
    stage: str,
    seed: int,
    sandbox: Sandbox,
    count: int,
    executor: Executor,
    student: str = "",
    advance: Callable[[int, int, object], None] = lambda *_: None,
) -> list[Sheet]:
    """Return a sheet for each student with a submission, sorted by student.

    Parameters
    ----------
    course : grader.course.paths.Course
    stage : str
    seed : int
        The course's secret, from which exercises, questions and the order of choices are drawn.
    sandbox : grader.sandbox.Sandbox
    count : int
        Number of questions for each student.
    executor : concurrent.futures.Executor
    student : str, optional
        ID of the only student; by default, the whole class.
    advance : callable, optional
        Called with (0, total, None) first, and with (done, total, student) after each sheet.
    """
    by_student: dict[str, list[Submission]] = {}
    for submission in find_submissions(course, [stage]):
        if student in ("", submission.student):
            by_student.setdefault(submission.student, []).append(submission)
    names = _names(course)
    advance(0, len(by_student), None)
    futures = {
        id: executor.submit(
            make_sheet, course, names.get(id, id), submissions, seed, sandbox, count
        )
        for id, submissions in by_student.items()
    }
    sheets = []
    for id, future in futures.items():
        name = names.get(id, id)
        try:
            sheets.append(future.result())
        except BrokenExecutor:
            sheets.append(Sheet(id, name, problem="The process ended. Run the command again."))
        advance(len(sheets), len(by_student), name)
    return sheets


def _names(course: Course) -> dict[str, str]:
    roster = read_roster(course)
    return {person.id: person.display_name for person in roster.people} if roster else {}


def make_sheet(
    course: Course,
    name: str,
    submissions: Sequence[Submission],
    seed: int,
    sandbox: Sandbox,
    count: int,
) -> Sheet:
    """Return one student's sheet, about the first drawn exercise with enough questions."""
    student = submissions[0].student
    stage = submissions[0].lesson.stage
    random = Random(f"{seed} {stage} {student}")
    problems: list[str] = []
    accepted = list(_accepted_exercises(course, submissions, problems))
    best = Sheet(student, name)
    for submission, exercise in _draw_order(accepted, random):
        try:
            sheet = _sheet_about(course, name, submission, exercise, random, sandbox, count)
        except (UnreadableNotebook, ReadingFailed, ReplacedSubmission) as error:
            problems.append(str(error).splitlines()[0])
            continue
        except (StudentError, StudentStopped):
            problems.append(f"The code of {exercise.name} raised an error or did not finish.")
            continue
        best = max(best, sheet, key=_quality)
        if _quality(best) == (count, True):
            return best
    if len(best.questions) == count:
        return best
    if best.questions:
        found = len(best.questions)
        problem = f"The grader found only {found} of {count} questions about this code."
    else:
        problem = " ".join(dict.fromkeys(problems)) or (
            "No exercise in this stage earned full points, so there is no correct code to ask "
            "about."
        )
    return replace(best, problem=problem)


def _quality(sheet: Sheet) -> tuple[int, bool]:
    return len(sheet.questions), len(sheet.lines) <= MAX_LINES


def _accepted_exercises(
    course: Course, submissions: Sequence[Submission], problems: list[str]
) -> Iterator[tuple[Submission, Exercise]]:
    """Yield the exercises with full points that have cases."""
    for submission in submissions:
        verdict = read_verdict(submission.verdict_path(course))
        if verdict is None or verdict.status != JUDGED:
            problems.append(
                f"{submission.lesson.name} has not been graded. "
                f"Run: python -m grader grade {submission.lesson.stage}"
            )
            continue
        full = {result.name for result in verdict.exercises if result.score == result.max_score}
        for exercise in submission.lesson.machine_graded:
            if exercise.name in full and cases_of(exercise.name):
                yield submission, exercise


def _draw_order(
    accepted: list[tuple[Submission, Exercise]], random: Random
) -> Iterator[tuple[Submission, Exercise]]:
    """Yield all exercises in random order; those with more points tend to be earlier."""
    left = list(accepted)
    while left:
        (drawn,) = random.choices(left, [exercise.points for _, exercise in left])
        left.remove(drawn)
        yield drawn


def _sheet_about(
    course: Course,
    name: str,
    submission: Submission,
    exercise: Exercise,
    random: Random,
    sandbox: Sandbox,
    count: int,
) -> Sheet:
    lesson: Lesson = submission.lesson
    verdict = read_verdict(submission.verdict_path(course))
    submitted_files = submission.read_again(course, verdict.fingerprint)
    judged = prepare_to_judge(submitted_files, lesson)
    answer = Answer(lesson, exercise.name, judged.code, judged.modules)
    behaviour = observe(answer, sandbox, peer_outcomes(lesson, exercise.name, sandbox))
    questions = tuple(choose_questions(behaviour, sandbox, count, random))
    return Sheet(
        submission.student,
        name,
        exercise.name,
        behaviour.lines,
        questions,
        remarks_on(behaviour),
        helpers=called_helpers(lesson, exercise.name, behaviour.lines, questions),
    )
