"""A lock that allows only one command at a time to change the data of a course."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterator

from grader.course.paths import Course
from grader.errors import FAULT, UserError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None


class AlreadyRunning(UserError):
    """Another process is changing the data of this course."""

    exit_status = FAULT


@contextlib.contextmanager
def course_lock(course: Course) -> Iterator[None]:
    """Hold the lock of a course, and remove files that killed runs left unfinished.

    The operating system releases the lock when the process ends for any reason.

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
            process_id = file.read(20).strip() or "unknown"
            raise AlreadyRunning(
                f"Another run is grading this course (process {process_id}). Wait until that run "
                "ends, then run the command again. Nothing is judged twice."
            ) from None
        file.truncate(0)
        file.write(f"{os.getpid()}\n")
        file.flush()
        for folder in (course.verdicts, course.report):
            for path in folder.rglob("*.part"):
                path.unlink(missing_ok=True)
        for pattern in ("*/*/.*.part", "*/*/.older/.*.part"):  # left by `grader.classroom.collect`
            for path in course.submitted.glob(pattern):
                path.unlink(missing_ok=True)
        for pattern in ("*/.*.part", "*/.*.old"):  # left by `grader.lms.autograded_folder`
            for path in course.autograded.glob(pattern):
                shutil.rmtree(path, ignore_errors=True)
        yield
