"""The course's secret seed, from which hidden tests draw their input."""

import contextlib
import os
import secrets
import tempfile

from grader.course.paths import Course
from grader.errors import UserError

# Student code could find a smaller seed by trying all seeds until one gives a hidden test's input.
MIN_SEED = 2**64


class SeedTooSmall(UserError):
    """The seed is so small that students could guess it; `str()` is the sentence to show."""


def course_seed(course: Course, requested_seed: int | None = None) -> int:
    """Return the seed for grading, and draw one if the course does not have one.

    Parameters
    ----------
    course : grader.course.paths.Course
    requested_seed : int, optional
        Seed from the command line, which takes precedence and is not stored.

    Returns
    -------
    int
        `requested_seed`, or the seed that is drawn once for a course and stored in
        ``.course_seed``.

    Raises
    ------
    SeedTooSmall
        If the seed is less than `MIN_SEED`.
    """
    if requested_seed is not None:
        return _require_large_seed(requested_seed, "Leave --seed out")
    if not course.seed_file.exists():
        # Two graders may start at the same time. Each links its complete file to the final name,
        # and only the first link succeeds.
        descriptor, draft = tempfile.mkstemp(dir=course.root)
        with open(descriptor, "w", encoding="utf-8") as file:
            file.write(f"{secrets.randbits(128)}\n")
        with contextlib.suppress(FileExistsError):
            os.link(draft, course.seed_file)
        os.unlink(draft)
    stored = int(course.seed_file.read_text("utf-8"))
    return _require_large_seed(stored, f"Remove {course.seed_file.name}")


def _require_large_seed(seed: int, remedy: str) -> int:
    if seed < MIN_SEED:
        suggested_seed = secrets.randbits(127) | MIN_SEED
        raise SeedTooSmall(
            f"The seed {seed} is so small that students could guess it and predict every hidden "
            f"test. {remedy} to let the grader draw a seed, or use this one: {suggested_seed}"
        )
    return seed
