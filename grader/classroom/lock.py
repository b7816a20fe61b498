"""One run at a time on a course."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterator

from grader.course.paths import Course

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None


class AlreadyRunning(Exception):
    """Somebody else is grading this course; `str()` is the sentence to show."""


@contextlib.contextmanager
def only_one(course: Course) -> Iterator[None]:
    """Hold the lock of a course, and clear away what a run that was killed left half done.

    The lock goes with the process, however that ends.

    Raises
    ------
    AlreadyRunning
    """
    course.root.mkdir(parents=True, exist_ok=True)
    with open(course.root / ".grading.lock", "a+", encoding="utf-8") as file:
        try:
            if fcntl:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.seek(0)
            who = file.read(20).strip() or "unknown"
            raise AlreadyRunning(
                f"Another run is grading this course (process {who}). Wait until it ends, and "
                "start this one again: what is done is not done twice."
            ) from None
        file.truncate(0)
        file.write(f"{os.getpid()}\n")
        file.flush()
        for folder in (course.verdicts, course.report):
            for path in folder.rglob("*.part"):
                path.unlink(missing_ok=True)
        for pattern in ("*/*/.*.part", "*/*/.older/.*.part"):  # as `grader.classroom.collect` does
            for path in course.submitted.glob(pattern):
                path.unlink(missing_ok=True)
        for pattern in ("*/.*.part", "*/.*.old"):  # whole folders, as `grader.lms.copies` makes
            for path in course.autograded.glob(pattern):
                shutil.rmtree(path, ignore_errors=True)
        yield
