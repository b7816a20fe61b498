"""The course's secret: the number that the hidden scenes are drawn from."""

import contextlib
import os
import secrets
import tempfile

from grader.course.paths import Course


def course_seed(course: Course, given: int | None = None) -> int:
    """The seed to grade with.

    Parameters
    ----------
    course : grader.course.paths.Course
    given : int, optional
        What the command line says; it wins and is not kept.

    Returns
    -------
    int
        The same on every call for one course: drawn once and kept in ``.course_seed``.
    """
    if given is not None:
        return given
    if not course.seed_file.exists():
        # Complete before it has its name: two graders may start at the same time.
        descriptor, draft = tempfile.mkstemp(dir=course.root)
        with open(descriptor, "w", encoding="utf-8") as file:
            file.write(f"{secrets.randbits(128)}\n")
        with contextlib.suppress(FileExistsError):
            os.link(draft, course.seed_file)
        os.unlink(draft)
    return int(course.seed_file.read_text("utf-8"))
