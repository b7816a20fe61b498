"""What the walls need of files in a container, made once, with the image: it is the slow part.

``setup.sh`` runs this module. Where it may not, each submission makes its own.
"""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

from grader.course.lessons import Lesson
from grader.judging.judge import program_for
from grader.lms.autograder.judging import assigned
from grader.sandbox import chroot, jail

SMALLEST: chroot.Kind = ((), ())
"""With which it is tried whether there can be such walls."""


def prepare(source: Path) -> None:
    """Make a folder for each kind of worker of the assignment, and a list of them."""
    folder = source / "jails"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(mode=0o700)
    kinds = dict.fromkeys([SMALLEST, *map(_kind, assigned(source))])
    made = [(kind, jail.build(*kind, within=folder).name) for kind in kinds]
    (folder / "list.json").write_text(json.dumps(made), "utf-8")


def offer(source: Path) -> None:
    """Have those used that are there."""
    folder = source / "jails"
    if (folder / "list.json").exists():
        for (packages, forbidden), name in json.loads((folder / "list.json").read_text("utf-8")):
            chroot.offer((tuple(packages), tuple(forbidden)), folder / name)


def _kind(lesson: Lesson) -> chroot.Kind:
    program = program_for(lesson, (), {})
    return program.packages, program.forbidden


if __name__ == "__main__":
    try:
        prepare(Path(sys.argv[1]))
    except OSError as error:
        print(f"The image keeps no folders for student code: {error}")
