"""Judge one notebook: read it once, ask the student's functions, decide here."""

from __future__ import annotations

import functools
import time
import traceback
from pathlib import Path

from grader.course.lessons import Exercise, Lesson, find_lesson
from grader.intake.handed_in import HandedIn, read_handed_in
from grader.intake.preflight import prepare
from grader.judging.asking import JudgeFault, JudgeTimeout, run_tests
from grader.judging.followed import Followed, follow_through
from grader.judging.key import verdict_key
from grader.judging.messages import messages_of, text_of, told
from grader.judging.points import shares, total
from grader.judging.verdict import FAILED, JUDGED, CheckResult, ExerciseResult, Verdict
from grader.sandbox import Limits, Sandbox
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.program import PACKAGES, Given, Program
from grader.sandbox.student import Student
from utils.checks import CheckFailed
from utils.checks.diagnosis import Mistake, asked_through, diagnose
from utils.checks.outcomes import Outcome
from utils.checks.story import resolve
from utils.notebooks.reading import UnreadableNotebook

# What a wrong answer makes a test raise; anything else may be a fault of the test.
_FINE = (type(None), CheckFailed, StudentError, StudentStopped, JudgeTimeout)
UNFAIR = (
    "The judge failed on this notebook; this is not the student's fault, and no points were "
    "given or taken. Whoever grades finds the reason in the verdict's file."
)


class UnknownLesson(Exception):
    """A notebook does not say which lesson it is; `str()` is the sentence to show."""


def judge(
    path: Path,
    seed: int,
    sandbox: Sandbox,
    lesson: Lesson | None = None,
    student: str = "",
    limits: Limits | None = None,
) -> Verdict:
    """Judge one notebook.

    Parameters
    ----------
    path : pathlib.Path
    seed : int
        The course's secret; the hidden scenes are drawn from it.
    sandbox : grader.sandbox.Sandbox
    lesson : grader.course.lessons.Lesson, optional
        By default taken from the notebook's name or its metadata.
    student : str, optional
        Identity to note in the verdict.
    limits : grader.sandbox.Limits, optional

    Returns
    -------
    grader.judging.verdict.Verdict
        Whatever the student's code did.

    Raises
    ------
    UnknownLesson
    grader.sandbox.SandboxUnavailable
    """
    return judge_handed_in(read_handed_in(Path(path)), seed, sandbox, lesson, student, limits)


def judge_handed_in(
    handed_in: HandedIn,
    seed: int,
    sandbox: Sandbox,
    lesson: Lesson | None = None,
    student: str = "",
    limits: Limits | None = None,
) -> Verdict:
    """Judge what has been read; see `judge`."""
    begin = time.perf_counter()
    lesson = lesson or find_lesson(Path(handed_in.name).stem)
    outcomes, problems, faults, starved = None, [], [], False
    versions, claims, followed = {}, {}, {}
    try:
        notebook = handed_in.notebook()
    except UnreadableNotebook as error:
        if lesson is None:
            raise UnknownLesson(str(error)) from None
        problems = [str(error)]
    else:
        lesson = lesson or find_lesson(notebook.lesson_name)
        if lesson is None:
            raise UnknownLesson(
                f"{handed_in.name}: cannot tell which lesson this is. Give the file the name it "
                "was released under, such as 06_filter_ground.ipynb."
            )
        prepared = prepare(handed_in, lesson)
        versions = prepared.versions
        program = program_for(lesson, prepared.code, handed_in.modules)
        with Student(program, sandbox, limits) as proxy:
            try:
                outcomes = run_tests(lesson, proxy, seed)
                claims = _claims(lesson, outcomes, proxy)
            except JudgeFault as error:
                faults = [str(error)]
            problems, starved = [*prepared.notes, *proxy.problems], proxy.starved
    if _odd(outcomes):
        outcomes, starved_again = _once_more(lesson, program, outcomes, seed, sandbox, limits)
        starved |= starved_again
    odd = _odd(outcomes)
    if odd and complaints_about_reference(lesson, seed, sandbox):
        faults += ["".join(traceback.format_exception(outcome.failure)) for outcome in odd]
    if faults:
        outcomes, problems = None, [UNFAIR]
    elif outcomes is not None:
        followed, starved_again = follow_through(
            lesson, program, proxy.uses, outcomes, seed, sandbox, limits
        )
        starved |= starved_again
    exercises = tuple(
        _score(exercise, outcomes, claims.get(exercise.name), followed.get(exercise.name))
        for exercise in lesson.machine_graded
    )
    if outcomes is not None:
        problems += [one.sentence for one in followed.values()]
        lost = [result.name for result in exercises if result.score < result.max_score]
        problems += [versions[name] for name in lost if name in versions]
    return Verdict(
        lesson=lesson.name,
        student=student,
        status=FAILED if faults else JUDGED,
        score=total([exercise.score for exercise in exercises]),
        max_score=total([exercise.max_score for exercise in exercises]),
        exercises=exercises,
        problems=tuple(problems),
        seconds=round(time.perf_counter() - begin, 3),
        key=verdict_key(handed_in, lesson, seed, student),
        faults=tuple(faults),
        starved=starved,
        fingerprint=handed_in.fingerprint(),
    )


def program_for(lesson: Lesson, cells: tuple[str, ...], modules: dict[str, str]) -> Program:
    """What runs behind the wall for a notebook of a lesson."""
    return Program(
        cells,
        lesson.names,
        modules,
        Given(lesson.header.given, given_code(lesson)),
        lesson.header.forbidden,
        (*PACKAGES, *lesson.header.packages),
        lesson.steps,
    )


@functools.cache
def given_code(lesson: Lesson) -> str:
    """Source of what a lesson gives, as it was released."""
    return lesson.source_of(lesson.header.given)


@functools.cache
def complaints_about_reference(lesson: Lesson, seed: int, sandbox: Sandbox) -> tuple[str, ...]:
    """What the tests of a lesson find wrong with its own solution: faults of the tests.

    Empty when the solution earns everything, as it must before anybody is judged. A fault is there
    each time; what befalls a busy machine once is none.
    """
    return _complaints(lesson, seed, sandbox) and _complaints(lesson, seed, sandbox)


def _complaints(lesson: Lesson, seed: int, sandbox: Sandbox) -> tuple[str, ...]:
    handed_in = read_handed_in(lesson.solved)
    program = program_for(lesson, handed_in.notebook().code, {})
    with Student(program, sandbox) as proxy:
        try:
            outcomes = run_tests(lesson, proxy, seed)
        except JudgeFault as error:
            return (str(error),)
        failed = [outcome for outcome in outcomes if outcome.failure]
        return (*map(_complaint, failed), *proxy.problems)


def _complaint(outcome: Outcome) -> str:
    check, failure = outcome.check, outcome.failure
    return f"{check.exercise}, {check.name}: {type(failure).__name__}: {failure}"


def _odd(outcomes: list[Outcome] | None) -> list[Outcome]:
    """Those that ended as no wrong answer makes a test end."""
    return [one for one in outcomes or () if not isinstance(one.failure, _FINE)]


def _once_more(
    lesson: Lesson,
    program: Program,
    outcomes: list[Outcome],
    seed: int,
    sandbox: Sandbox,
    limits: Limits | None,
) -> tuple[list[Outcome], bool]:
    """The outcomes, with another one for each that was odd; and whether that try was starved.

    What befell the judge only once takes no point from anybody.
    """
    odd = {outcome.check for outcome in _odd(outcomes)}
    with Student(program, sandbox, limits) as proxy:
        try:
            again = run_tests(lesson, proxy, seed, odd.__contains__)
        except JudgeFault:  # then the first try counts
            return outcomes, False
        starved = proxy.starved
    better = {outcome.check: outcome for outcome in again}
    return [better.get(outcome.check, outcome) for outcome in outcomes], starved


def _claims(lesson: Lesson, outcomes: list[Outcome], student: Student) -> dict[str, Mistake]:
    """What explains the answers to each exercise, by its name."""
    found = {}
    for exercise in lesson.machine_graded:
        if any(isinstance(one.failure, CheckFailed) for one in _of(exercise, outcomes)):
            student.exercise = exercise.name
            found[exercise.name] = diagnose(
                exercise.name, getattr(student, asked_through(exercise.name))
            )
    return found


def _score(
    exercise: Exercise,
    outcomes: list[Outcome] | None,
    claim: Mistake | None,
    followed: Followed | None,
) -> ExerciseResult:
    """`ExerciseResult` of one exercise; nothing was tried where `outcomes` is None."""
    if outcomes is None:
        return ExerciseResult(exercise.name, 0.0, exercise.points, ())
    mine, said, claim = _of(exercise, outcomes), [], None if followed else claim
    if followed:
        mine, said = followed.outcomes, [followed.sentence]
    stories = [told(outcome, open_to_all=followed is None) for outcome in mine]
    story = resolve(stories, claim=claim)
    messages = messages_of(story)
    most = shares(exercise.points, [outcome.check.weight for outcome in mine])
    tests = tuple(
        _result(outcome, points, messages.get(outcome, ""))
        for outcome, points in zip(stories, most, strict=True)
    )
    said += [text_of(story.first, story.claim)] if story.first else []
    first = story.first.check.name if story.first and not story.not_started else ""
    score = total([result.score for result in tests])
    return ExerciseResult(exercise.name, score, exercise.points, tests, "\n".join(said), first)


def _of(exercise: Exercise, outcomes: list[Outcome]) -> list[Outcome]:
    return [outcome for outcome in outcomes if outcome.check.exercise == exercise.name]


def _result(outcome: Outcome, points: float, message: str) -> CheckResult:
    check, passed = outcome.check, outcome.failure is None
    score = points if passed else 0.0
    return CheckResult(check.name, check.title, passed, score, points, message, check.is_shown)
