"""Drive every street with every student's detector, in parallel.

Finished drives are stored and not repeated.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from dataclasses import dataclass, replace
from pathlib import Path

from extension.league.drives import DETECTOR, DriveResult, drive_key, drive_submission, from_json
from extension.league.streets import draw_streets
from grader.classroom.protocol import ExecutorLost, capacity
from grader.classroom.submissions import find_submissions
from grader.course.atomic_files import write_atomically
from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import Course
from grader.intake.submission import SubmittedFiles, read_submitted_files
from grader.sandbox import Sandbox, SandboxUnavailable
from utils.drive.streets import Street

TRUE_BOXES, COURSE_DETECTOR = "the true boxes", "the course's detector"
"""Names of the two reference entrants, with which the class is compared."""

PROCESS_DIED = "The process ended twice during this drive. Is there enough memory?"


@dataclass(frozen=True)
class Entrant:
    """A student of the class, or a reference entrant.

    Attributes
    ----------
    name : str
        Name of the student, or one of `TRUE_BOXES` and `COURSE_DETECTOR`.
    is_student : bool
        Whether the entrant belongs to the class.
    read : callable
        Returns the submission, or None for the true boxes.
    folder : Path
        Folder in which the drives are stored.
    """

    name: str
    is_student: bool
    read: Callable[[], SubmittedFiles | None]
    folder: Path


@dataclass(frozen=True)
class Season:
    """The drives of a class.

    Attributes
    ----------
    lesson : Lesson
    streets : tuple of Street
        Streets that count, because a drive with the true boxes has no collision there.
    omitted_streets : tuple of Street
        Streets in which even a drive with the true boxes fails.
    drives : dict of Entrant to dict of int to DriveResult
        Drives of each entrant, by street number.
    """

    lesson: Lesson
    streets: tuple[Street, ...]
    omitted_streets: tuple[Street, ...]
    drives: dict[Entrant, dict[int, DriveResult]]

    @property
    def students(self) -> list[Entrant]:
        """Entrants that belong to the class."""
        return [entrant for entrant in self.drives if entrant.is_student]

    @property
    def faults(self) -> list[str]:
        """A sentence for the instructor on each drive that failed on the grader's side."""
        return [
            f"{entrant.name}, street {result.street}: {result.fault}"
            for entrant, drives in self.drives.items()
            for result in drives.values()
            if result.fault
        ]


def lesson_of_league(stage: str) -> Lesson | None:
    """Return the lesson of a stage in which students write a detector, or None."""
    return next(
        (
            lesson
            for lesson in all_lessons()
            if lesson.stage == stage
            and DETECTOR in (exercise.name for exercise in lesson.machine_graded)
        ),
        None,
    )


def drive_class(
    course: Course,
    lesson: Lesson,
    seed: int,
    sandbox: Sandbox,
    open_executor: Callable[[int], Executor],
    workers: int,
    progress: Callable[[int, int, object], None],
    students: Collection[str] = (),
    street_count: int | None = None,
) -> Season:
    """Return the drives of a class; run those that are not stored yet.

    If there are no submissions, nothing is run. Worker processes only exchange data with this
    process, which reads and writes all files and stores each drive as soon as it ends. If a drive's
    process died or got hardly any processor time, the drive is repeated once, on its own.

    Parameters
    ----------
    course : grader.course.paths.Course
    lesson : Lesson
    seed : int
    sandbox : grader.sandbox.Sandbox
    open_executor : callable
        Takes the number of workers and returns an executor; see `grader.classroom.executors`.
    workers : int
    progress : callable
        Called with (done, total, None) at the start and after each drive.
    students : collection of str, optional
        Run only the drives of these students. The other students take part if all their drives are
        stored. By default, all students drive.
    street_count : int, optional
        Drive only through this many streets.
    """
    streets = draw_streets(seed)[:street_count]
    entrants = list(_entrants(course, lesson))
    drives = {entrant: _read_valid_drives(entrant, streets, lesson) for entrant in entrants}
    drives = {
        entrant: stored_drives
        for entrant, stored_drives in drives.items()
        if not students
        or not entrant.is_student
        or entrant.name in students
        or len(stored_drives) == len(streets)
    }
    if not any(entrant.is_student for entrant in drives):
        return Season(lesson, streets, (), {})
    missing_drives = [
        (entrant, street)
        for street in streets
        for entrant, stored_drives in drives.items()
        if street.number not in stored_drives
    ]
    drive_count = len(streets) * len(drives)

    def store(entrant: Entrant, street: Street, result: DriveResult) -> None:
        if not result.fault:
            write_atomically(result.as_json(), _result_path(entrant, street))
        drives[entrant][street.number] = result
        progress(sum(map(len, drives.values())), drive_count, None)

    def job_arguments(entrant: Entrant, street: Street) -> tuple:
        return drive_submission, entrant.read(), lesson.name, street.number, seed, sandbox.name

    progress(drive_count - len(missing_drives), drive_count, None)
    to_repeat = []
    if missing_drives:
        with open_executor(workers) as executor:
            for entrant, street, future in _as_completed(missing_drives, job_arguments, executor):
                result = _drive_result(future, street)
                if result is None or result.starved:
                    to_repeat.append((entrant, street))
                else:
                    store(entrant, street, result)
    for entrant, street in to_repeat:
        with open_executor(1) as executor:
            result = _drive_result(executor.submit(*job_arguments(entrant, street)), street)
        result = result or DriveResult(street.number, fault=PROCESS_DIED)
        # The drive ran alone, so if the detector was stopped, it was too slow.
        store(entrant, street, replace(result, starved=False))
    return _build_season(lesson, streets, drives)


def _as_completed(
    missing_drives: list[tuple[Entrant, Street]],
    job_arguments: Callable[..., tuple],
    executor: Executor,
) -> Iterator[tuple[Entrant, Street, Future]]:
    """Submit drives while the executor has room, and yield each as soon as it ends."""
    waiting, running = deque(missing_drives), {}
    while waiting or running:
        while waiting and len(running) < capacity(executor):
            entrant, street = waiting.popleft()
            running[executor.submit(*job_arguments(entrant, street))] = entrant, street
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            yield *running.pop(future), future


def _drive_result(future: Future, street: Street) -> DriveResult | None:
    """Return a future's drive, with `fault` set if the grader failed; None if a process died."""
    try:
        return future.result()
    except BrokenExecutor:
        return None
    except (SandboxUnavailable, ExecutorLost):
        raise
    except Exception as error:  # one drive must not stop the others
        return DriveResult(street.number, fault=f"{type(error).__name__}: {error}")


def _build_season(
    lesson: Lesson, streets: tuple[Street, ...], drives: dict[Entrant, dict[int, DriveResult]]
) -> Season:
    (true_drives,) = (
        result
        for entrant, result in drives.items()
        if entrant.name == TRUE_BOXES and not entrant.is_student
    )
    failed = {number for number, result in true_drives.items() if result.collision or result.fault}
    return Season(
        lesson,
        tuple(street for street in streets if street.number not in failed),
        tuple(street for street in streets if street.number in failed),
        drives,
    )


def _entrants(course: Course, lesson: Lesson) -> Iterator[Entrant]:
    folder = course.verdicts / ".league" / lesson.stage
    yield Entrant(TRUE_BOXES, False, lambda: None, folder / "true")
    yield Entrant(
        COURSE_DETECTOR, False, lambda: read_submitted_files(lesson.solved), folder / "own"
    )
    for submission in find_submissions(course, [lesson.stage]):
        if submission.lesson == lesson:
            yield Entrant(
                submission.student,
                True,
                lambda submission=submission: submission.read(course),
                submission.verdict_path(course).parent / ".league",
            )


def _result_path(entrant: Entrant, street: Street) -> Path:
    return entrant.folder / f"street_{street.number}.json"


def _read_valid_drives(
    entrant: Entrant, streets: tuple[Street, ...], lesson: Lesson
) -> dict[int, DriveResult]:
    """Return the stored drives that are still valid: same submission, rules and street."""
    submitted, stored = entrant.read(), {}
    for street in streets:
        try:
            result = from_json(_result_path(entrant, street).read_text("utf-8"))
        except (OSError, ValueError, TypeError, KeyError):
            continue
        if result.key == drive_key(submitted, street, lesson):
            stored[street.number] = result
    return stored
