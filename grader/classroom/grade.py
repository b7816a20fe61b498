"""Judge a class: every submission, in parallel.

A verdict is a file that names all it depends on. Whoever needs one looks there first, so a run
that was broken off goes on where it stopped, and `nbgrader autograde` finds what `grade` judged.
"""

from __future__ import annotations

import queue
import traceback
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import BrokenExecutor, Executor, Future

from grader.classroom.protocol import ExecutorLost, room
from grader.classroom.rehearsals import Rehearsals
from grader.classroom.submissions import Submission, find_submissions
from grader.course.lessons import Lesson, find_lesson
from grader.course.paths import Course
from grader.intake.submission import HandedIn
from grader.judging.judge import UNFAIR, judge_handed_in
from grader.judging.key import verdict_key
from grader.judging.verdict import (
    FAILED,
    JUDGED,
    ExerciseResult,
    Verdict,
    read_verdict,
    write_verdict,
)
from grader.sandbox import SANDBOXES, Sandbox, SandboxUnavailable

Judged = list[tuple[Submission, Verdict]]


def stored_verdict(course: Course, submission: Submission, seed: int) -> Verdict | None:
    """The verdict on disk, if it is about this very file, these rules and this seed.

    And if it can be believed: the judge did its work, and the student's code had a processor.
    """
    verdict = read_verdict(submission.verdict_path(course))
    if verdict is None or verdict.status != JUDGED or verdict.starved:
        return None
    handed_in = submission.read(course)
    key = verdict_key(handed_in, submission.lesson, seed, submission.student)
    same = (verdict.key, verdict.fingerprint) == (key, handed_in.fingerprint())
    return verdict if same else None


def judge_one(
    handed_in: HandedIn, lesson: str, student: str, seed: int, sandbox: str, alone: bool = False
) -> Verdict:
    """Judge one notebook: plain data in, a verdict out, wherever there is the course's code.

    Parameters
    ----------
    handed_in : grader.intake.submission.HandedIn
    lesson, student : str
        Names.
    seed : int
    sandbox : str
        A name in `grader.sandbox.SANDBOXES`.
    alone : bool
        That nothing else is judged meanwhile: then a time limit is believed.
    """
    verdict = judge_handed_in(handed_in, seed, SANDBOXES[sandbox], find_lesson(lesson), student)
    return verdict.believed() if alone else verdict


def judge_and_store(
    course: Course, submission: Submission, seed: int, sandbox: Sandbox, alone: bool = False
) -> Verdict:
    """Judge one submission here and keep the verdict; `alone` as for `judge_one`."""
    verdict = judge_one(*_job(course, submission, seed, sandbox), alone)
    write_verdict(verdict, submission.verdict_path(course))
    return verdict


def _job(course: Course, submission: Submission, seed: int, sandbox: Sandbox) -> tuple:
    """What `judge_one` takes; this reads the submission."""
    handed_in = submission.read(course)
    return handed_in, submission.lesson.name, submission.student, seed, sandbox.name


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
    student: str | None = None,
) -> Judged:
    """Judge what has no verdict yet.

    What judges gets data and gives verdicts; here alone submissions are read and verdicts
    written, each as soon as it arrives. A notebook that kills the process that judges it is tried
    once more by itself; so is one whose code reached a time limit without having had a processor.

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
        Called with (done, total, submission) after each notebook, and with a sentence in its place
        when something else takes long.
    student : str, optional
        Judge this one alone, and again what was judged before.

    Raises
    ------
    grader.classroom.rehearsals.RehearsalFailed
        Before anybody of that lesson is judged; verdicts on others are kept.
    """
    submissions = [
        one for one in find_submissions(course, stages) if student in (None, one.student)
    ]
    verdicts = {
        submission: None if student else stored_verdict(course, submission, seed)
        for submission in submissions
    }
    waiting = [submission for submission, verdict in verdicts.items() if verdict is None]
    done = len(submissions) - len(waiting)
    progress(done, len(submissions), None)
    suspects = []

    def note(submission: Submission, future: Future) -> None:
        nonlocal done
        verdict = _result(future, submission)
        write_verdict(verdict, submission.verdict_path(course))
        done += verdicts[submission] is None
        verdicts[submission] = verdict
        progress(done, len(submissions), submission)

    def tell(lesson: Lesson) -> None:
        progress(done, len(submissions), f"the course's own {lesson.name} first")

    def job(submission: Submission) -> tuple:
        return _job(course, submission, seed, sandbox)

    if waiting:
        with open_executor(workers) as executor:
            rehearsals = Rehearsals(
                course, {submission.lesson for submission in waiting}, seed, sandbox, tell
            )
            suspects = _judge_all(waiting, job, executor, workers, note, rehearsals)
    suspects += [
        submission for submission, verdict in verdicts.items() if verdict and verdict.starved
    ]
    for submission in suspects:
        with open_executor(1) as executor:
            note(submission, executor.submit(judge_one, *job(submission), True))
    return [(submission, verdicts[submission]) for submission in submissions]


def _judge_all(
    waiting: Iterable[Submission],
    job: Callable[[Submission], tuple],
    executor: Executor,
    workers: int,
    note: Callable[[Submission, Future], None],
    rehearsals: Rehearsals,
) -> list[Submission]:
    """Judge in parallel, reading only so many submissions ahead as the executor has room for.

    Lesson by lesson, each as soon as its own solution has earned everything. Returned are those
    whose process died.
    """
    coming = deque(sorted(waiting, key=lambda one: one.lesson.name))
    running, finished, died = {}, queue.SimpleQueue(), []

    def give(what: Submission | Lesson, future: Future) -> None:
        running[future] = what
        future.add_done_callback(finished.put)

    def fill() -> None:
        while coming and rehearsals.passed(coming[0].lesson):
            if len(running) >= room(executor):
                return
            give(coming[0], executor.submit(judge_one, *job(coming[0])))
            coming.popleft()
        # Not all at once: whoever waits for a first verdict waits for no other lesson.
        begun = sum(isinstance(what, Lesson) for what in running.values())
        for lesson in rehearsals.next(workers - begun, not running):
            give(lesson, rehearsals.start(lesson, executor))

    while True:
        fill()
        if not running:
            rehearsals.verify()
            return died
        future = finished.get()
        what = running.pop(future, None)
        if isinstance(what, Lesson):
            rehearsals.note(what, future)
            if rehearsals.failed:  # the others may have faults, too; nobody is judged any more
                coming.clear()
                for other, what in list(running.items()):
                    if isinstance(what, Submission) and other.cancel():
                        del running[other]
        elif what and isinstance(future.exception(), BrokenExecutor):
            died.append(what)
        elif what:  # else it was called off
            note(what, future)


def _result(future: Future, submission: Submission) -> Verdict:
    """The verdict of a future; one that says so where the judge itself failed."""
    try:
        return future.result().compact()
    except (SandboxUnavailable, ExecutorLost):
        raise
    except Exception as error:  # one submission must not stop the others
        return failed_verdict(submission, error)


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
