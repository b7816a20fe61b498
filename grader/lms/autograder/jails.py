"""Folders for the chroot sandbox, which are built once with the container image.

Building them is slow, so ``setup.sh`` runs this module. If that is not permitted, each run of the
autograder builds its own folders.
"""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

from grader.course.lessons import Lesson
from grader.judging.judge import program_for
from grader.lms.autograder.judging import assigned_lessons
from grader.sandbox import chroot, jail

SMALLEST_KIND: chroot.Kind = ((), ())
"""The kind of folder with which `chroot` tests whether the sandbox works."""


def build_jails(source: Path) -> None:
    """Build a folder for each kind of worker that the assignment needs, and list them in a file."""
    folder = source / "jails"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(mode=0o700)
    kinds = dict.fromkeys([SMALLEST_KIND, *map(_jail_kind, assigned_lessons(source))])
    built = [(kind, jail.build(*kind, parent=folder).name) for kind in kinds]
    (folder / "list.json").write_text(json.dumps(built), "utf-8")


def register_jails(source: Path) -> None:
    """Make the prepared folders available to the sandbox, if there are any."""
    folder = source / "jails"
    if (folder / "list.json").exists():
        for (packages, forbidden), name in json.loads((folder / "list.json").read_text("utf-8")):
            chroot.put_back_jail((tuple(packages), tuple(forbidden)), folder / name)


def _jail_kind(lesson: Lesson) -> chroot.Kind:
    program = program_for(lesson, (), {})
    return program.packages, program.forbidden


if __name__ == "__main__":
    try:
        build_jails(Path(sys.argv[1]))
    except OSError as error:
        print(f"The folders for student code could not be stored in the image: {error}")
