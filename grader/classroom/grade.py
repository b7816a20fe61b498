"""Judge a class: every submission, in parallel.

A verdict is a file that names all it depends on. Whoever needs one looks there first, so a run
that was broken off goes on where it stopped, and `nbgrader autograde` finds what `grade` judged.
"""

from __future__ import annotations

import contextlib
import json
import queue
import traceback
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import BrokenExecutor, Executor, Future
from pathlib import Path

from grader.classroom.executors import ExecutorLost, room
from grader.classroom.submissions import Submission, find_submissions
from grader.course.lessons import Lesson, find_lesson
from grader.course.paths import Course
from grader.intake.handed_in import HandedIn, read_handed_in
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
from grader.sandbox import SANDBOXES, Sandbox, SandboxUnavailable

Judged = list[tuple[Submission, Verdict]]


class RehearsalFailed(Exception):
    """A lesson's own solution does not earn everything; `str()` says which tests are at fault."""


class Rehearsals:
    """Let lessons' own solutions be judged on the course's seed; each must earn everything.

    What has been seen is remembered until the solution or a rule changes.

    Parameters
    ----------
    course : grader.course.paths.Course
    lessons : iterable of Lesson
    seed : int
    sandbox : grader.sandbox.Sandbox
    tell : callable, optional
        Called with each lesson that is begun.

    Attributes
    ----------
    waiting : list of Lesson
        In order of name: those that have not been seen, and nobody works on.
    """

    def __init__(
        self,
        course: Course,
        lessons: Iterable[Lesson],
        seed: int,
        sandbox: Sandbox,
        tell: Callable[[Lesson], object] = lambda lesson: None,
    ) -> None:
        self._seed, self._sandbox, self._tell = seed, sandbox, tell
        self._complaints: dict[str, tuple[str, ...]] = {}
        self._notes = {lesson: rehearsal(course, lesson, seed) for lesson in lessons}
        new = [lesson for lesson, (path, key) in self._notes.items() if _read(path) != key]
        self.waiting = sorted(new, key=lambda lesson: lesson.name)
        self._missing = set(new)

    def passed(self, lesson: Lesson) -> bool:
        """Whether the lesson's own solution has earned everything."""
        return lesson not in self._missing

    def start(self, executor: Executor) -> tuple[Lesson, Future]:
        """Have the first that waits judged."""
        lesson = self.waiting[0]
        self._tell(lesson)
        future = executor.submit(rehearse_one, lesson.name, self._seed, self._sandbox.name)
        return self.waiting.pop(0), future

    def note(self, lesson: Lesson, complaints: tuple[str, ...]) -> None:
        """Remember what came of one."""
        if complaints:
            self._complaints[lesson.name] = complaints
            return
        path, key = self._notes[lesson]
        write_atomically(json.dumps(key), path)
        self._missing.discard(lesson)

    @property
    def failed(self) -> bool:
        """Whether there were complaints."""
        return bool(self._complaints)

    def verify(self) -> None:
        """Raise `RehearsalFailed` if there were complaints."""
        if self.failed:
            found = ("\n".join((f"{name}:", *said)) for name, said in self._complaints.items())
            raise RehearsalFailed(
                "Nobody was graded: with the course's seed, these tests find fault with the "
                "lesson's own solution. Mend them, or name another seed with --seed.\n"
                + "\n".join(found)
            )


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


def judge_one(
    handed_in: HandedIn, lesson: str, student: str, seed: int, sandbox: str, alone: bool = False
) -> Verdict:
    """Judge one notebook: plain data in, a verdict out, wherever there is the course's code.

    Parameters
    ----------
    handed_in : grader.intake.handed_in.HandedIn
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


def rehearse_one(lesson: str, seed: int, sandbox: str) -> tuple[str, ...]:
    """What the tests of a lesson find wrong with its own solution; names as for `judge_one`."""
    return complaints_about_reference(find_lesson(lesson), seed, SANDBOXES[sandbox])


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

    someone_died = False
    while waiting:
        with open_executor(workers) as executor:
            lessons = {one.lesson for one in waiting}
            if someone_died:
                rehearse(course, lessons, seed, sandbox, executor)
            rehearsals = Rehearsals(course, lessons, seed, sandbox, tell)
            waiting = _judge_all(waiting, job, executor, workers, note, suspects, rehearsals)
        someone_died = True  # or nobody is waiting
    suspects += [one for one, verdict in verdicts.items() if verdict and verdict.starved]
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
    suspects: list[Submission],
    rehearsals: Rehearsals,
) -> list[Submission]:
    """Judge in parallel, reading only so many submissions ahead as the executor has room for.

    Lesson by lesson, each as soon as its own solution has earned everything. What was at work when
    a process died is added to `suspects`; what the executor then did not take any more is returned.
    """
    coming = deque(sorted(waiting, key=lambda one: one.lesson.name))
    running, finished, broken = {}, queue.SimpleQueue(), False

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
        for _ in rehearsals.waiting[: max(0, workers - begun)]:
            give(*rehearsals.start(executor))

    try:
        while True:
            if not broken:
                try:
                    fill()
                except BrokenExecutor:
                    broken = True
            if not running:
                rehearsals.verify()
                return list(coming)
            future = finished.get()
            what = running.pop(future, None)
            if what is None:
                continue  # called off
            died = isinstance(future.exception(), BrokenExecutor)
            if isinstance(what, Submission):
                suspects.append(what) if died else note(what, future)
            elif not died:  # else its submissions are returned, and it is tried alone
                rehearsals.note(what, future.result())
                if rehearsals.failed:  # the others may have faults, too; nobody is judged any more
                    coming.clear()
                    for other, what in list(running.items()):
                        if isinstance(what, Submission) and other.cancel():
                            del running[other]
    except BaseException:
        executor.shutdown(wait=True, cancel_futures=True)
        raise


def rehearse(
    course: Course, lessons: Iterable[Lesson], seed: int, sandbox: Sandbox, executor: Executor
) -> None:
    """Let every lesson's own solution be judged, and nothing else meanwhile; see `Rehearsals`.

    Raises
    ------
    RehearsalFailed
    """
    rehearsals, running = Rehearsals(course, lessons, seed, sandbox), {}
    with contextlib.suppress(BrokenExecutor):  # those that were begun say so
        while rehearsals.waiting:
            lesson, future = rehearsals.start(executor)
            running[future] = lesson
    for future, lesson in running.items():
        try:
            complaints = future.result()
        except BrokenExecutor:
            complaints = ("The process that judged it died. Is there memory enough?",)
        rehearsals.note(lesson, complaints)
    rehearsals.verify()


def rehearsal(course: Course, lesson: Lesson, seed: int) -> tuple[Path, str]:
    """Where is noted that a lesson's own solution earned everything, and the key that is noted."""
    path = course.verdicts / ".rehearsed" / f"{lesson.name}.json"
    return path, verdict_key(read_handed_in(lesson.solved), lesson, seed)


def _read(path: Path) -> object:
    try:
        return json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return None


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
