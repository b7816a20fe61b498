"""Judge one notebook: read it, call the student's functions, and award points in this process."""

from __future__ import annotations

import functools
import hashlib
import json
import platform
import time
from dataclasses import dataclass, replace
from pathlib import Path

from grader.course.lessons import Lesson, find_lesson, optional_lessons
from grader.errors import UserError
from grader.intake.preflight import JudgeInput, lesson_name_in, prepare_to_judge
from grader.intake.reader_process import ReadingFailed
from grader.intake.submission import SubmittedFiles, read_submitted_files
from grader.judging.error_carried_forward import carry_forward
from grader.judging.points import sum_points
from grader.judging.program_run import JudgingContext, RunResults, run_program, untouched_results
from grader.judging.repair import find_slips
from grader.judging.results import result_of, unjudged_results
from grader.judging.runner import EXPECTED_FAILURES
from grader.judging.verdict import FAILED, JUDGED, ExerciseResult, Verdict, with_shared_parts
from grader.judging.verdict_key import verdict_key
from grader.sandbox import Limits, Sandbox
from grader.sandbox.program import INSTALLED_PACKAGES, GivenCode, Program
from grader.sandbox.time_budget import Budget
from grader.untrusted_text import one_line
from utils.checks.outcomes import Outcome
from utils.notebooks.reading import UnreadableNotebook, is_lfs_pointer

JUDGE_FAILED_NOTE = (
    "The judge failed on this notebook. This is not the student's fault. No points were "
    "given or taken away. The verdict file says why the judge failed."
)
STARVED_NOTE = (
    "The judge stopped before it had finished, probably because the machine was busy or had too "
    "little memory, so the score may be too low. Grade this notebook again when the machine is "
    "less busy."
)


class UnknownLesson(UserError):
    """The lesson of a notebook is unknown."""


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
        The course's secret, from which the input of hidden tests is drawn.
    sandbox : grader.sandbox.Sandbox
    lesson : grader.course.lessons.Lesson, optional
        By default, the notebook's file name or metadata determines the lesson.
    student : str, optional
        The student's ID, which the verdict records.
    limits : grader.sandbox.Limits, optional

    Returns
    -------
    grader.judging.verdict.Verdict
        Always returned, whatever the student's code does.

    Raises
    ------
    UnknownLesson
    grader.sandbox.SandboxUnavailable
    """
    return judge_files(read_submitted_files(Path(path)), seed, sandbox, lesson, student, limits)


def judge_files(
    submitted_files: SubmittedFiles,
    seed: int,
    sandbox: Sandbox,
    lesson: Lesson | None = None,
    student: str = "",
    limits: Limits | None = None,
) -> Verdict:
    """Judge a submission that has already been read; see `judge`."""
    start = time.perf_counter()
    lesson = lesson or _identify_lesson(submitted_files)
    try:
        judge_input = prepare_to_judge(submitted_files, lesson)
    except UnreadableNotebook as error:
        decision = _Decision(unjudged_results(lesson), (str(error),))
    except ReadingFailed as error:
        decision = _Decision(unjudged_results(lesson), (JUDGE_FAILED_NOTE,), (str(error),))
    else:
        context = JudgingContext(lesson, seed, sandbox, limits, Budget(limits or Limits()))
        decision = _decide_cached(context, judge_input)
    if is_lfs_pointer(submitted_files.data):  # the file is missing from the instructor's checkout
        decision = _unjudged_decision(lesson, *decision.problems)
    return Verdict(
        lesson=lesson.name,
        student=student,
        status=FAILED if decision.faults else JUDGED,
        score=sum_points([exercise.score for exercise in decision.exercises]),
        max_score=sum_points([exercise.max_score for exercise in decision.exercises]),
        exercises=decision.exercises,
        problems=tuple(map(one_line, decision.problems)),
        seconds=round(time.perf_counter() - start, 3),
        key=verdict_key(submitted_files, lesson, seed, student),
        faults=decision.faults,
        starved=decision.starved,
        fingerprint=submitted_files.fingerprint(),
    )


def lesson_of_file(path: Path) -> Lesson:
    """Return the lesson of a notebook, without running the notebook.

    Raises
    ------
    UnknownLesson
        If the file is not a notebook, or if its lesson has no points.
    """
    return _identify_lesson(read_submitted_files(path))


def _identify_lesson(submitted_files: SubmittedFiles) -> Lesson:
    """Return the lesson that the notebook's file name or metadata identifies."""
    if lesson := find_lesson(Path(submitted_files.name).stem):
        return lesson
    try:
        name = lesson_name_in(submitted_files)
        lesson = find_lesson(name)
    except (UnreadableNotebook, ReadingFailed) as error:
        raise UnknownLesson(one_line(str(error))) from None
    if lesson is None:
        texts = {name, Path(submitted_files.name).stem}
        file_name = one_line(submitted_files.name)
        if any(optional.name in texts for optional in optional_lessons()):
            raise UnknownLesson(
                f"{file_name} is an optional lesson. It is not graded, so there is "
                "nothing to judge."
            )
        raise UnknownLesson(
            f"{file_name} cannot be matched with a lesson. Give the file the name under which it "
            "was released, such as 06_filter_ground.ipynb."
        )
    return lesson


@dataclass(frozen=True)
class _Decision:
    """The part of a verdict that depends on the behaviour of the student's code."""

    exercises: tuple[ExerciseResult, ...]
    problems: tuple[str, ...]
    faults: tuple[str, ...] = ()
    starved: bool = False


# Results of notebooks with full marks. The key contains everything that a result depends on.
_full_mark_decisions: dict[tuple, _Decision] = {}


def _decide_cached(context: JudgingContext, judge_input: JudgeInput) -> _Decision:
    """Call `_decide`, or return the cached result of identical code with full marks.

    Only full marks are cached. A failure may be the machine's fault, and must not be copied to
    another student's identical notebook.
    """
    key_parts = [judge_input.code, judge_input.notes, judge_input.modules, judge_input.python]
    text = json.dumps(key_parts, sort_keys=True).encode()
    rules = (context.lesson, context.seed, context.sandbox, context.limits)
    key = (*rules, hashlib.sha256(text).digest())
    if key in _full_mark_decisions:
        return _full_mark_decisions[key]
    decision = _decide(context, judge_input)
    if not decision.faults and all(
        exercise.score == exercise.max_score for exercise in decision.exercises
    ):
        # Share equal parts to save memory, because a class may have ten thousand students.
        _full_mark_decisions[key] = replace(
            decision, exercises=tuple(map(with_shared_parts, decision.exercises))
        )
    return decision


def _decide(context: JudgingContext, judge_input: JudgeInput) -> _Decision:
    """Run the checks, retry suspicious failures, and build the result."""
    lesson, budget = context.lesson, context.budget
    program = program_for(lesson, judge_input.code, judge_input.modules)
    program = replace(program, python=judge_input.python)
    if judge_input.is_as_released:
        results = untouched_results(lesson)
    else:
        results = run_program(context, program, explain=True)
        if too_new := _newer_python_sentences(results):
            return _unjudged_decision(lesson, *judge_input.notes, *results.problems, *too_new)
        results = _retry_suspicious_checks(context, program, results)
    if faults := _judge_faults(context, results):
        return _Decision(unjudged_results(lesson), (JUDGE_FAILED_NOTE,), faults, budget.starved)
    carried = carry_forward(context, program, results)
    slips = find_slips(context, program, results, carried)
    exercises = tuple(
        result_of(exercise, results, carried.get(exercise.name), slips.get(exercise.name))
        for exercise in lesson.machine_graded
    )
    incomplete = [result.name for result in exercises if result.score < result.max_score]
    # A notebook with full marks cannot gain from another try, so it does not count as starved.
    starved = bool(incomplete) and budget.starved
    problems = (
        *[STARVED_NOTE] * starved,
        *judge_input.notes,
        *results.problems,
        *(result.sentence for result in carried.values()),
        *(judge_input.versions[name] for name in incomplete if name in judge_input.versions),
    )
    return _Decision(exercises, problems, (), starved)


def _unjudged_decision(lesson: Lesson, *sentences: str) -> _Decision:
    """Return the decision on a notebook that cannot be judged with this machine or this file.

    The last of `sentences` is the reason, which also becomes the first problem.
    """
    *others, reason = sentences
    problems = (f"{reason} No points were given or taken away.", *others)
    return _Decision(unjudged_results(lesson), problems, (reason,))


def _newer_python_sentences(results: RunResults) -> tuple[str, ...]:
    """Return sentences about code that lost points because only a newer Python can run it."""
    lost = {outcome.check.exercise for outcome in results.outcomes if outcome.failure}
    sentences = dict.fromkeys(part for name, part in results.newer_names.items() if name in lost)
    here = platform.python_version()
    return tuple(
        f"{part}, and this judge has Python {here}. Run the grader with the newer version."
        for part in sentences
    )


def _retry_suspicious_checks(
    context: JudgingContext, program: Program, results: RunResults
) -> RunResults:
    """Run suspicious checks again, and replace their outcomes.

    A failure that does not recur does not cost any points.
    """
    suspicious = {outcome.check for outcome in _suspicious_outcomes(results)}
    if not suspicious:
        return results
    again = run_program(context, program, suspicious.__contains__)
    if again.fault:  # keep the result of the first run
        return results
    new_outcomes = {outcome.check: outcome for outcome in again.outcomes}
    outcomes = tuple(new_outcomes.get(outcome.check, outcome) for outcome in results.outcomes)
    return replace(results, outcomes=outcomes)


def _suspicious_outcomes(results: RunResults) -> list[Outcome]:
    """Return the outcomes with an exception that a wrong answer would not cause."""
    return [
        outcome
        for outcome in results.outcomes
        if outcome.failure and not isinstance(outcome.failure, EXPECTED_FAILURES)
    ]


def _judge_faults(context: JudgingContext, results: RunResults) -> tuple[str, ...]:
    """Return descriptions of faults in the judge itself, which make a verdict impossible."""
    if results.fault:
        return (results.fault,)
    suspicious = _suspicious_outcomes(results)
    if suspicious and reference_failures(context.lesson, context.seed, context.sandbox):
        return tuple(_format_traceback(outcome.failure) for outcome in suspicious)
    return ()


def _format_traceback(error: Exception) -> str:
    """Return the traceback of an exception, which the runner keeps as a note."""
    return "".join(getattr(error, "__notes__", ())) + f"{type(error).__name__}: {error}\n"


def program_for(lesson: Lesson, cells: tuple[str, ...], modules: dict[str, str]) -> Program:
    """Return the program that runs in the sandbox for a notebook of a lesson."""
    return Program(
        cells,
        lesson.names,
        modules,
        GivenCode(lesson.header.given, given_code(lesson), open_names=lesson.header.given),
        lesson.header.forbidden,
        INSTALLED_PACKAGES,
        lesson.steps,
    )


@functools.cache
def given_code(lesson: Lesson) -> str:
    """Return the source of the functions that a lesson gives to students, as released."""
    return lesson.source_of(lesson.header.given)


@functools.cache
def reference_failures(lesson: Lesson, seed: int, sandbox: Sandbox) -> tuple[str, ...]:
    """Return a sentence for each check that a lesson's own solution fails.

    Such a check is faulty, so a class is judged only if there are none. If there are any, the
    checks run once more, because a busy machine may cause a single failure.
    """
    return _find_reference_failures(lesson, seed, sandbox) and _find_reference_failures(
        lesson, seed, sandbox
    )


def _find_reference_failures(lesson: Lesson, seed: int, sandbox: Sandbox) -> tuple[str, ...]:
    program = program_for(lesson, read_submitted_files(lesson.solved).notebook().code, {})
    results = run_program(JudgingContext(lesson, seed, sandbox), program)
    if results.fault:
        return (results.fault,)
    failed = [outcome for outcome in results.outcomes if outcome.failure]
    return (*map(_describe_failure, failed), *results.problems)


def _describe_failure(outcome: Outcome) -> str:
    check, failure = outcome.check, outcome.failure
    return f"{check.exercise}, {check.name}: {type(failure).__name__}: {failure}"
