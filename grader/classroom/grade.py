"""Judge a class: every submission, in parallel.

A verdict is a file that names all it depends on. Whoever needs one looks there first, so a run
that was broken off goes on where it stopped, and `nbgrader autograde` finds what `grade` judged.
"""

from __future__ import annotations

import json
import traceback
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, as_completed
from pathlib import Path

from grader.classroom.submissions import Submission, find_submissions
from grader.course.lessons import Lesson
from grader.course.paths import Course
from grader.intake.handed_in import read_handed_in
from grader.judging.judge import UNFAIR, complaints_about_reference, judge_handed_in
from grader.judging.key import verdict_key
from grader.judging.verdict import (
    FAILED,
    JUDGED,
    ExerciseResult,
    Verdict,
    read_verdict,
    write_atomically,
    write_verdict,
)
from grader.sandbox import Sandbox, SandboxUnavailable

Judged = list[tuple[Submission, Verdict]]


class RehearsalFailed(Exception):
    """A lesson's own solution does not earn everything; `str()` says which tests are at fault."""


def stored_verdict(course: Course, submission: Submission, seed: int) -> Verdict | None:
    """The verdict on disk, if it is about this very file, these rules and this seed.

    And if it can be believed: the judge did its work, and the student's code had a processor.
    """
    verdict = read_verdict(submission.verdict_path(course))
    if verdict is None or verdict.status != JUDGED or verdict.starved:
        return None
    handed_in = submission.read(course)
    key = verdict_key(handed_in, submission.lesson, seed, submission.student)
    return verdict if verdict.key == key else None


def judge_and_store(
    course: Course, submission: Submission, seed: int, sandbox: Sandbox, alone: bool = False
) -> Verdict:
    """Judge one submission and keep the verdict.

    Parameters
    ----------
    alone : bool
        That nothing else is judged meanwhile: then a time limit is believed.
    """
    handed_in = submission.read(course)
    verdict = judge_handed_in(handed_in, seed, sandbox, submission.lesson, submission.student)
    if alone:
        verdict = verdict.believed()
    write_verdict(verdict, submission.verdict_path(course))
    return verdict


def current_verdict(course: Course, submission: Submission, seed: int, sandbox: Sandbox) -> Verdict:
    """The verdict on disk, or a fresh one."""
    stored = stored_verdict(course, submission, seed)
    return stored or judge_and_store(course, submission, seed, sandbox, alone=True)


def judge_class(
    course: Course,
    stages: Iterable[str],
    seed: int,
    sandbox: Sandbox,
    open_executor: Callable[[int], Executor],
    workers: int,
    progress: Callable[[int, int, object], None],
) -> Judged:
    """Judge what has no verdict yet.

    A notebook that kills the process that judges it is tried once more by itself; so is one whose
    code reached a time limit without having had a processor.

    Parameters
    ----------
    course : grader.course.paths.Course
    stages : iterable of str
    seed : int
    sandbox : grader.sandbox.Sandbox
    open_executor : callable
        One of `grader.classroom.executors`; takes the number of workers.
    workers : int
    progress : callable
        Called with (done, total, submission) after each notebook.

    Returns
    -------
    list of (Submission, grader.judging.verdict.Verdict)

    Raises
    ------
    RehearsalFailed
        Before anybody is judged.
    """
    submissions = find_submissions(course, stages)
    verdicts = {one: stored_verdict(course, one, seed) for one in submissions}
    waiting = [one for one, verdict in verdicts.items() if verdict is None]
    progress(len(submissions) - len(waiting), len(submissions), None)

    def note(submission: Submission, verdict: Verdict) -> None:
        verdicts[submission] = verdict
        done = sum(known is not None for known in verdicts.values())
        progress(done, len(submissions), submission)

    with open_executor(workers) as executor:
        rehearse(course, {one.lesson for one in waiting}, seed, sandbox, executor)
        suspects = _judge_all(course, waiting, seed, sandbox, executor, note)
    suspects += [one for one, verdict in verdicts.items() if verdict and verdict.starved]
    for submission in suspects:
        with open_executor(1) as executor:
            alone = executor.submit(judge_and_store, course, submission, seed, sandbox, True)
            note(submission, _result(alone, course, submission))
    return [(submission, verdicts[submission]) for submission in submissions]


def _judge_all(
    course: Course,
    waiting: Sequence[Submission],
    seed: int,
    sandbox: Sandbox,
    executor: Executor,
    note: Callable[[Submission, Verdict], None],
) -> list[Submission]:
    """Judge in parallel; return what is left when a worker died."""
    running = {
        executor.submit(judge_and_store, course, submission, seed, sandbox): submission
        for submission in waiting
    }
    left = []
    try:
        for future in as_completed(running):
            if isinstance(future.exception(), BrokenExecutor):
                left.append(running[future])
            else:
                note(running[future], _result(future, course, running[future]))
    except BaseException:
        executor.shutdown(wait=True, cancel_futures=True)
        raise
    return left


def rehearse(
    course: Course, lessons: Iterable[Lesson], seed: int, sandbox: Sandbox, executor: Executor
) -> None:
    """Let every lesson's own solution be judged on the course's seed; it must earn everything.

    What has been seen is remembered until the solution or a rule changes.

    Raises
    ------
    RehearsalFailed
    """
    running = {}
    for lesson in sorted(lessons, key=lambda lesson: lesson.name):
        path = course.verdicts / ".rehearsed" / f"{lesson.name}.json"
        key = verdict_key(read_handed_in(lesson.solved), lesson, seed)
        if _read(path) != key:
            future = executor.submit(complaints_about_reference, lesson, seed, sandbox)
            running[future] = (lesson, path, key)
    failed = []
    for future, (lesson, path, key) in running.items():
        try:
            complaints = future.result()
        except BrokenExecutor:
            complaints = ("The process that judged it died. Is there memory enough?",)
        if complaints:
            failed.append(f"{lesson.name}:\n" + "\n".join(complaints))
        else:
            write_atomically(json.dumps(key), path)
    if failed:
        raise RehearsalFailed(
            "Nobody was graded: with the course's seed, these tests find fault with the lesson's "
            "own solution. Mend them, or name another seed with --seed.\n" + "\n".join(failed)
        )


def _read(path: Path) -> object:
    try:
        return json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return None


def _result(future: Future, course: Course, submission: Submission) -> Verdict:
    """The verdict of a future; one that says so where the judge itself failed."""
    try:
        return future.result()
    except SandboxUnavailable:
        raise
    except Exception as error:  # one submission must not stop the others
        verdict = failed_verdict(submission, error)
        write_verdict(verdict, submission.verdict_path(course))
        return verdict


def failed_verdict(submission: Submission, error: Exception) -> Verdict:
    """A verdict on a notebook on which the judge itself failed; the next run tries again."""
    exercises = tuple(
        ExerciseResult(exercise.name, 0.0, exercise.points, ())
        for exercise in submission.lesson.machine_graded
    )
    return Verdict(
        lesson=submission.lesson.name,
        student=submission.student,
        status=FAILED,
        score=0.0,
        max_score=sum(exercise.max_score for exercise in exercises),
        exercises=exercises,
        problems=(UNFAIR,),
        seconds=0.0,
        key="",
        faults=("".join(traceback.format_exception(error)),),
    )
