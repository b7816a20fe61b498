"""A class through all streets, in parallel. What was driven is kept, and not driven again."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from dataclasses import dataclass, replace
from pathlib import Path

from grader.classroom.league.drives import DETECTOR, Driven, drive_one, from_json, key_of
from grader.classroom.league.streets import streets_of
from grader.classroom.protocol import ExecutorLost, room
from grader.classroom.submissions import find_submissions
from grader.course.atomic_files import write_atomically
from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import Course
from grader.intake.submission import SubmittedFiles, read_submitted_files
from grader.sandbox import Sandbox, SandboxUnavailable
from utils.drive.streets import Street

TRUE_BOXES, OUR_OWN = "the true boxes", "the course's detector"
"""Who drives beside the class, to compare with."""

GONE = "The process that drove ended, twice. Is there memory enough?"


@dataclass(frozen=True)
class Entrant:
    """Somebody who drives.

    Attributes
    ----------
    name : str
        The student, or one of those to compare with.
    student : bool
    read : callable
        Returns what was handed in; None for the true boxes.
    folder : Path
        Where drives are kept.
    """

    name: str
    student: bool
    read: Callable[[], SubmittedFiles | None]
    folder: Path


@dataclass(frozen=True)
class Season:
    """What came of it.

    Attributes
    ----------
    lesson : Lesson
    streets : tuple of Street
        That count: the true boxes come through.
    left_out : tuple of Street
        Those in which the true boxes hit something: the street is to blame.
    drives : dict of Entrant to dict of int to Driven
        By number of the street.
    """

    lesson: Lesson
    streets: tuple[Street, ...]
    left_out: tuple[Street, ...]
    drives: dict[Entrant, dict[int, Driven]]

    @property
    def students(self) -> list[Entrant]:
        """Those of the class."""
        return [drive for drive in self.drives if drive.student]

    @property
    def faults(self) -> list[str]:
        """What could not be driven, and why, for whoever teaches."""
        return [
            f"{one.name}, street {driven.street}: {driven.fault}"
            for one, known in self.drives.items()
            for driven in known.values()
            if driven.fault
        ]


def lesson_of_league(stage: str) -> Lesson | None:
    """The lesson of a stage that asks for a detector, if one does."""
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
) -> Season:
    """Drive what has not been driven yet; where nobody has handed in anything, nothing.

    What drives gets data and gives data; here alone files are read and written, each drive as soon
    as it is over. One that ends the process that drives, and one that was given no processor, is
    driven once more, by itself.

    Parameters
    ----------
    course : grader.course.paths.Course
    lesson : Lesson
    seed : int
    sandbox : grader.sandbox.Sandbox
    open_executor : callable
        One of `grader.classroom.executors`; takes the number of workers.
    workers : int
    progress : callable
        Called with (done, total, None) after each drive.
    """
    streets = streets_of(seed)
    entrants = list(_entrants(course, lesson))
    if not any(entrant.student for entrant in entrants):
        return Season(lesson, streets, (), {})
    drives = {one: _kept(one, streets, lesson) for one in entrants}
    missing = [
        (one, street)
        for street in streets
        for one, known in drives.items()
        if street.number not in known
    ]
    total = len(streets) * len(drives)

    def note(one: Entrant, street: Street, driven: Driven) -> None:
        if not driven.fault:
            write_atomically(driven.as_json(), _file(one, street))
        drives[one][street.number] = driven
        progress(sum(map(len, drives.values())), total, None)

    def job(one: Entrant, street: Street) -> tuple:
        return drive_one, one.read(), lesson.name, street.number, seed, sandbox.name

    progress(total - len(missing), total, None)
    again = []
    if missing:
        with open_executor(workers) as executor:
            for one, street, future in _as_they_end(missing, job, executor):
                driven = _result(future, street)
                if driven is None or driven.starved:
                    again.append((one, street))
                else:
                    note(one, street, driven)
    for one, street in again:
        with open_executor(1) as executor:
            driven = _result(executor.submit(*job(one, street)), street)
        driven = driven or Driven(street.number, fault=GONE)
        note(one, street, replace(driven, starved=False))  # with the machine to itself
    return _season(lesson, streets, drives)


def _as_they_end(
    missing: list[tuple[Entrant, Street]], job: Callable[..., tuple], executor: Executor
) -> Iterator[tuple[Entrant, Street, Future]]:
    """Give an executor as much as it has room for, and yield each that is over."""
    coming, running = deque(missing), {}
    while coming or running:
        while coming and len(running) < room(executor):
            what = coming.popleft()
            running[executor.submit(*job(*what))] = what
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            yield *running.pop(future), future


def _result(future: Future, street: Street) -> Driven | None:
    """The drive of a future; None where its process died, and a fault where ours is to blame."""
    try:
        return future.result()
    except BrokenExecutor:
        return None
    except (SandboxUnavailable, ExecutorLost):
        raise
    except Exception as error:  # one drive must not stop the others
        return Driven(street.number, fault=f"{type(error).__name__}: {error}")


def _season(
    lesson: Lesson, streets: tuple[Street, ...], drives: dict[Entrant, dict[int, Driven]]
) -> Season:
    (best,) = (known for one, known in drives.items() if one.name == TRUE_BOXES and not one.student)
    bad = {number for number, driven in best.items() if driven.collision or driven.fault}
    return Season(
        lesson,
        tuple(street for street in streets if street.number not in bad),
        tuple(street for street in streets if street.number in bad),
        drives,
    )


def _entrants(course: Course, lesson: Lesson) -> Iterator[Entrant]:
    ours = course.verdicts / ".league" / lesson.stage
    yield Entrant(TRUE_BOXES, False, lambda: None, ours / "true")
    yield Entrant(OUR_OWN, False, lambda: read_submitted_files(lesson.solved), ours / "own")
    for submission in find_submissions(course, [lesson.stage]):
        if submission.lesson == lesson:
            beside = submission.verdict_path(course).parent / ".league"
            yield Entrant(
                submission.student,
                True,
                lambda submission=submission: submission.read(course),
                beside,
            )


def _file(one: Entrant, street: Street) -> Path:
    return one.folder / f"street_{street.number}.json"


def _kept(one: Entrant, streets: tuple[Street, ...], lesson: Lesson) -> dict[int, Driven]:
    """What is on disk, if it is about this very file, these rules and this street."""
    handed_in, found = one.read(), {}
    for street in streets:
        try:
            driven = from_json(_file(one, street).read_text("utf-8"))
        except (OSError, ValueError, TypeError, KeyError):
            continue
        if driven.key == key_of(handed_in, street, lesson):
            found[street.number] = driven
    return found
