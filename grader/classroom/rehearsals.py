"""Check, before a class is judged, that each lesson's solution earns all points.

The check uses the class's seed. If a solution loses points, the tests are at fault, and would also
deduct points for students' right answers.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from concurrent.futures import BrokenExecutor, Executor, Future
from pathlib import Path

from grader.course.atomic_files import write_atomically
from grader.course.lessons import Lesson, find_lesson
from grader.course.paths import Course
from grader.intake.submission import read_submitted_files
from grader.judging.judge import reference_failures
from grader.judging.verdict_key import verdict_key
from grader.sandbox import SANDBOXES, Sandbox


class RehearsalFailed(Exception):
    """A lesson's own solution does not earn all points; the message names the tests."""


class Rehearsals:
    """The rehearsals of some lessons. A rehearsal judges a lesson's own solution.

    A passed rehearsal is recorded, and is valid until the solution or the rules change.

    Parameters
    ----------
    course : grader.course.paths.Course
    lessons : iterable of Lesson
    seed : int
    sandbox : grader.sandbox.Sandbox
    announce : callable, optional
        Called with each lesson when its rehearsal begins.

    Attributes
    ----------
    waiting : list of Lesson
        Lessons whose rehearsal has not begun, sorted by name.
    """

    def __init__(
        self,
        course: Course,
        lessons: Iterable[Lesson],
        seed: int,
        sandbox: Sandbox,
        announce: Callable[[Lesson], object] = lambda lesson: None,
    ) -> None:
        self._seed, self._sandbox, self._announce = seed, sandbox, announce
        records = {lesson: record_of(course, lesson, seed) for lesson in lessons}
        self._missing = {
            lesson: record for lesson, record in records.items() if not _is_recorded(*record)
        }
        self._complaints: dict[str, tuple[str, ...]] = {}
        self.waiting = sorted(self._missing, key=lambda lesson: lesson.name)
        self._started: list[Lesson] = []
        self._died: list[Lesson] = []

    def has_passed(self, lesson: Lesson) -> bool:
        """Return whether the lesson's own solution has earned all points."""
        return lesson not in self._missing

    @property
    def has_failed(self) -> bool:
        """Whether a solution has failed to earn all points."""
        return bool(self._complaints)

    def next_lessons(self, capacity: int, is_alone: bool) -> list[Lesson]:
        """Return the next lessons to rehearse: waiting ones, or a single one whose worker died."""
        return self.waiting[: max(0, capacity)] or self._died[:is_alone]

    def start(self, lesson: Lesson, executor: Executor) -> Future:
        """Start the rehearsal of a lesson; pass the returned future to `record_result`."""
        self._announce(lesson)
        future = executor.submit(rehearse_one, lesson.name, self._seed, self._sandbox.name)
        (self.waiting if lesson in self.waiting else self._died).remove(lesson)
        self._started.append(lesson)
        return future

    def record_result(self, lesson: Lesson, future: Future) -> None:
        """Record the result of a rehearsal."""
        try:
            complaints = future.result()
        except BrokenExecutor as death:
            # Other jobs may have used up the memory, so the lesson gets one more try alone.
            if self._started.count(lesson) == 1:
                self._died.append(lesson)
                return
            complaints = (str(death),)
        if complaints:
            self._complaints[lesson.name] = complaints
            return
        path, key = self._missing.pop(lesson)
        write_atomically(json.dumps(key), path)

    def verify(self) -> None:
        """Raise `RehearsalFailed` if a solution has failed to earn all points."""
        if self.has_failed:
            found = sorted(self._complaints.items())
            raise RehearsalFailed(
                "No notebook was graded, because these tests reject the lesson's own "
                "solution with the course's seed. Fix the tests, or use another seed with --seed.\n"
                + "\n".join("\n".join((f"{name}:", *complaints)) for name, complaints in found)
            )

    def finish(
        self,
        executor: Executor,
        progress: Callable[[int, int, object], None] = lambda done, total, what: None,
    ) -> None:
        """Rehearse all waiting lessons.

        Parameters
        ----------
        executor : concurrent.futures.Executor
        progress : callable, optional
            Called with (done, total, None) at the start and after each lesson.

        Raises
        ------
        RehearsalFailed
        """
        total = len(self.waiting)
        progress(0, total, None)
        while lessons := self.next_lessons(len(self.waiting), is_alone=True):
            started = [(lesson, self.start(lesson, executor)) for lesson in lessons]
            for lesson, future in started:
                self.record_result(lesson, future)
                progress(total - len(self._missing), total, None)
        self.verify()


def rehearse_one(lesson: str, seed: int, sandbox: str) -> tuple[str, ...]:
    """Return the complaints of a lesson's tests about its own solution, as strings."""
    return reference_failures(find_lesson(lesson), seed, SANDBOXES[sandbox])


def record_of(course: Course, lesson: Lesson, seed: int) -> tuple[Path, str]:
    """Return the file that records a passed rehearsal, and the key to write there."""
    path = course.verdicts / ".rehearsed" / f"{lesson.name}.json"
    return path, verdict_key(read_submitted_files(lesson.solved), lesson, seed)


def _is_recorded(path: Path, key: str) -> bool:
    try:
        return json.loads(path.read_text("utf-8")) == key
    except (OSError, ValueError):
        return False
