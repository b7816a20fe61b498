"""Judge all submissions of a class in parallel.

The file of a verdict has a key, which changes with everything that the verdict depends on. A
submission with a valid verdict is not judged again. An interrupted run therefore continues where it
stopped, and `nbgrader autograde` uses the verdicts of `grade`.
"""

from __future__ import annotations

import queue
import traceback
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import BrokenExecutor, Executor, Future

from grader.classroom.protocol import ExecutorLost, capacity
from grader.classroom.rehearsals import Rehearsals
from grader.classroom.submissions import Submission, find_submissions
from grader.course.lessons import Lesson, find_lesson
from grader.course.paths import Course
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import JUDGE_FAILED_NOTE, judge_files
from grader.judging.verdict import (
    FAILED,
    JUDGED,
    ExerciseResult,
    Verdict,
    read_verdict,
    write_verdict,
)
from grader.judging.verdict_key import verdict_key
from grader.sandbox import SANDBOXES, Sandbox, SandboxUnavailable

JudgedSubmissions = list[tuple[Submission, Verdict]]


def stored_verdict(course: Course, submission: Submission, seed: int) -> Verdict | None:
    """Return the verdict on disk if it is valid for this file, the current rules and this seed.

    It must also be reliable: the judge did not fail, and the student's code got enough CPU time.
    """
    verdict = read_verdict(submission.verdict_path(course))
    if verdict is None or verdict.status != JUDGED or verdict.starved:
        return None
    submitted_files = submission.read(course)
    key = verdict_key(submitted_files, submission.lesson, seed, submission.student)
    same = (verdict.key, verdict.fingerprint) == (key, submitted_files.fingerprint())
    return verdict if same else None


def judge_one(
    submitted_files: SubmittedFiles,
    lesson: str,
    student: str,
    seed: int,
    sandbox: str,
    is_alone: bool = False,
) -> Verdict:
    """Judge one notebook, on any machine that has the course's code.

    Parameters
    ----------
    submitted_files : grader.intake.submission.SubmittedFiles
    lesson, student : str
        Names of the lesson and the student.
    seed : int
    sandbox : str
        Name of a sandbox in `grader.sandbox.SANDBOXES`.
    is_alone : bool
        Whether nothing else is being judged, so that time limits are reliable.
    """
    verdict = judge_files(submitted_files, seed, SANDBOXES[sandbox], find_lesson(lesson), student)
    return verdict.without_starved_flag() if is_alone else verdict


def judge_and_store(
    course: Course, submission: Submission, seed: int, sandbox: Sandbox, is_alone: bool = False
) -> Verdict:
    """Judge one submission in this process and store the verdict; see `judge_one`."""
    verdict = judge_one(*_job_arguments(course, submission, seed, sandbox), is_alone)
    write_verdict(verdict, submission.verdict_path(course))
    return verdict


def _job_arguments(course: Course, submission: Submission, seed: int, sandbox: Sandbox) -> tuple:
    """Read a submission and return the arguments of `judge_one`."""
    submitted_files = submission.read(course)
    return submitted_files, submission.lesson.name, submission.student, seed, sandbox.name


def current_verdict(course: Course, submission: Submission, seed: int, sandbox: Sandbox) -> Verdict:
    """Return the stored verdict if it is valid; otherwise judge the submission."""
    stored = stored_verdict(course, submission, seed)
    return stored or judge_and_store(course, submission, seed, sandbox, is_alone=True)


def judge_class(
    course: Course,
    stages: Iterable[str],
    seed: int,
    sandbox: Sandbox,
    open_executor: Callable[[int], Executor],
    workers: int,
    progress: Callable[[int, int, object], None],
    student: str | None = None,
) -> JudgedSubmissions:
    """Judge every submission without a valid verdict.

    Workers receive data and return verdicts. Only this process reads submissions and writes
    verdicts, each as soon as it arrives. A notebook that kills its worker, or that reaches a time
    limit because it gets too little CPU time, is judged once more, alone.

    Parameters
    ----------
    course : grader.course.paths.Course
    stages : iterable of str
    seed : int
    sandbox : grader.sandbox.Sandbox
    open_executor : callable
        Called with the number of workers; see `grader.classroom.executors`.
    workers : int
    progress : callable
        Called first with (done, total, None), where `done` counts the valid verdicts that were
        already stored. Then called with (done, total, submission) after each notebook, and with
        (done, total, text) before other long work.
    student : str, optional
        Judge only this student, even if there are valid verdicts.

    Raises
    ------
    grader.classroom.rehearsals.RehearsalFailed
        If a lesson's solution fails, before any submission for that lesson is judged; verdicts on
        other lessons are kept.
    """
    submissions = [
        submission
        for submission in find_submissions(course, stages)
        if student in (None, submission.student)
    ]
    verdicts = {
        submission: None if student else stored_verdict(course, submission, seed)
        for submission in submissions
    }
    waiting = [submission for submission, verdict in verdicts.items() if verdict is None]
    done = len(submissions) - len(waiting)
    progress(done, len(submissions), None)
    to_repeat = []

    def store_result(submission: Submission, future: Future) -> None:
        nonlocal done
        verdict = _verdict_of(future, submission)
        write_verdict(verdict, submission.verdict_path(course))
        done += verdicts[submission] is None
        verdicts[submission] = verdict
        progress(done, len(submissions), submission)

    def announce_rehearsal(lesson: Lesson) -> None:
        progress(done, len(submissions), f"the course's solution of {lesson.name}")

    def job(submission: Submission) -> tuple:
        return _job_arguments(course, submission, seed, sandbox)

    if waiting:
        with open_executor(workers) as executor:
            rehearsals = Rehearsals(
                course,
                {submission.lesson for submission in waiting},
                seed,
                sandbox,
                announce_rehearsal,
            )
            to_repeat = _judge_all(waiting, job, executor, workers, store_result, rehearsals)
    to_repeat += [
        submission for submission, verdict in verdicts.items() if verdict and verdict.starved
    ]
    for submission in to_repeat:
        with open_executor(1) as executor:
            store_result(submission, executor.submit(judge_one, *job(submission), True))
    return [(submission, verdicts[submission]) for submission in submissions]


def _judge_all(
    waiting: Iterable[Submission],
    job: Callable[[Submission], tuple],
    executor: Executor,
    workers: int,
    store_result: Callable[[Submission, Future], None],
    rehearsals: Rehearsals,
) -> list[Submission]:
    """Judge in parallel and return the submissions whose worker died.

    No more submissions are read in advance than the executor has room for. A lesson's submissions
    are judged only after the lesson's own solution has earned all points.
    """
    upcoming = deque(sorted(waiting, key=lambda submission: submission.lesson.name))
    running, finished_futures, interrupted = {}, queue.SimpleQueue(), []

    def watch(task: Submission | Lesson, future: Future) -> None:
        running[future] = task
        future.add_done_callback(finished_futures.put)

    def submit_jobs() -> None:
        while upcoming and rehearsals.has_passed(upcoming[0].lesson):
            if len(running) >= capacity(executor):
                return
            watch(upcoming[0], executor.submit(judge_one, *job(upcoming[0])))
            upcoming.popleft()
        # Rehearse a few lessons at a time, so that the first verdict need not wait for all of them.
        rehearsing = sum(isinstance(task, Lesson) for task in running.values())
        for lesson in rehearsals.next_lessons(workers - rehearsing, not running):
            watch(lesson, rehearsals.start(lesson, executor))

    while True:
        submit_jobs()
        if not running:
            rehearsals.verify()
            return interrupted
        future = finished_futures.get()
        task = running.pop(future, None)
        if isinstance(task, Lesson):
            rehearsals.record_result(task, future)
            if rehearsals.has_failed:  # stop, because other lessons may be faulty as well
                upcoming.clear()
                for other_future, other_task in list(running.items()):
                    if isinstance(other_task, Submission) and other_future.cancel():
                        del running[other_future]
        elif task and isinstance(future.exception(), BrokenExecutor):
            interrupted.append(task)
        elif task:  # a cancelled job has no task
            store_result(task, future)


def _verdict_of(future: Future, submission: Submission) -> Verdict:
    """Return the verdict in a future, or a verdict that reports a failure of the judge."""
    try:
        return future.result().compact()
    except (SandboxUnavailable, ExecutorLost):
        raise
    except Exception as error:  # one submission must not stop the others
        return failed_verdict(submission, error)


def failed_verdict(submission: Submission, error: Exception) -> Verdict:
    """Return a verdict that reports a failure of the judge; the next run tries again."""
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
        problems=(JUDGE_FAILED_NOTE,),
        seconds=0.0,
        key="",
        faults=("".join(traceback.format_exception(error)),),
    )
