"""The key of a verdict: a fingerprint of all that it depends on, and of nothing else.

So a verdict on disk holds as long as its key does, and a comment in a plotting module judges
nobody again.
"""

from __future__ import annotations

import functools
import hashlib
import re
import sys
from importlib import metadata
from pathlib import Path

from grader.course.lessons import Lesson
from grader.course.paths import PROJECT
from grader.intake.handed_in import HandedIn

# What decides, beside the lesson's own files: the judge, the wall, the slicer, the data.
DECIDES = (
    "grader/course/header.py",
    "grader/course/lessons.py",
    "grader/intake",
    "grader/judging",
    "grader/sandbox",
    "utils/boxes",
    "utils/checks",
    "utils/clouds",
    "utils/notebooks",
    "utils/simulator",
    "utils/scenes.py",
    "utils/scoring.py",
    "data/cloud.txt",
)
LIBRARIES = ("numpy", "scipy", "scikit-learn", "shapely", "pytest")


def versions() -> dict[str, str]:
    """Version of Python and of each library that decides, by name."""
    # A release that only mends Python changes no answer.
    python = ".".join(map(str, sys.version_info[:2]))
    return {"Python": python} | {name: metadata.version(name) for name in LIBRARIES}


def verdict_key(handed_in: HandedIn, lesson: Lesson, seed: int, student: str = "") -> str:
    """Fingerprint of a submission and of the rules that it is judged by."""
    digest = hashlib.sha256(f"{seed}\0{student}\0{rules_key(lesson)}\0".encode(errors="replace"))
    digest.update(handed_in.fingerprint())
    return digest.hexdigest()


@functools.cache
def rules_key(lesson: Lesson) -> str:
    """Fingerprint of what decides in one lesson."""
    digest = hashlib.sha256(lesson.name.encode())
    for name, version in versions().items():
        digest.update(f"{name} {version}\0".encode())
    for path in sorted({*_files(), *_files_of(lesson)}):
        digest.update(f"{path.relative_to(PROJECT)}\0".encode() + path.read_bytes())
    return digest.hexdigest()


def _files() -> set[Path]:
    """The files of `DECIDES`, less what belongs to single lessons."""
    found = set()
    for name in DECIDES:
        path = PROJECT / name
        found |= set(path.rglob("*.py")) if path.is_dir() else {path}
    return {path for path in found if not re.match(r"lesson_\d\d", path.name)}


def _files_of(lesson: Lesson) -> set[Path]:
    """The notebook as released, the tests, and the checks that these use."""
    found = {lesson.released, lesson.tests}
    waiting = [lesson.number, *_lessons_named_in(lesson.tests)]
    while waiting:
        checks = PROJECT / "utils" / "checks" / f"lesson_{waiting.pop()}.py"
        if checks not in found:
            found.add(checks)
            waiting += _lessons_named_in(checks)
    return found


def _lessons_named_in(path: Path) -> list[str]:
    return re.findall(r"utils\.checks\.lesson_(\d\d)", path.read_text("utf-8"))
