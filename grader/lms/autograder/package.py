"""Build the zip to upload: the files for judging, the course's seed, and a container's setup."""

from __future__ import annotations

import os
from pathlib import Path

from grader.course.archives import make_zip
from grader.course.paths import PROJECT
from grader.course.portable_files import files_for_judging
from grader.course.release import requirements_for

PACKAGE_FOLDER = Path(__file__).parent
PROGRAMS = ("setup.sh", "run_autograder")


def build_autograder_zip(assignment: str, seed: int) -> bytes:
    """Build the zip; the same course, assignment and seed give the same bytes.

    Parameters
    ----------
    assignment : str
        Name of a stage or lesson.
    seed : int
        Secret seed of the course.
    """
    needed = requirements_for("For the notebooks") + requirements_for("For grading")
    return make_zip(
        {
            **{name: (PACKAGE_FOLDER / name).read_bytes() for name in PROGRAMS},
            "assignment": f"{assignment}\n".encode(),
            "requirements.txt": f"-c constraints.txt\n\n{needed}".encode(),
            "constraints.txt": (PROJECT / "constraints.txt").read_bytes(),
            "course/.course_seed": f"{seed}\n".encode(),
            **{f"course/{name}": content for name, content in files_for_judging().items()},
        },
        PROGRAMS,
    )


def write_secret(content: bytes, path: Path) -> None:
    """Write a file that contains the seed and that only this user can read."""
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    with open(descriptor, "wb") as file:
        os.fchmod(descriptor, 0o600)
        file.write(content)
