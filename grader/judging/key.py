"""The key of a verdict: a fingerprint of all that it depends on, and of nothing else.

So a verdict on disk holds as long as its key does, and a comment in a plotting module judges
nobody again. No list says which code decides: statements that import are followed, from the judge,
what runs a student's code, and the lesson's own tests and checks.
"""

from __future__ import annotations

import functools
import hashlib
import re
import sys
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

from grader.course.lessons import Lesson
from grader.course.paths import PROJECT
from grader.intake.submission import HandedIn
from grader.sandbox.boundary import SHOWN

# Where judging begins: here, and in the process that students' code is forked from.
ENTRIES = (
    PROJECT / "grader" / "judging" / "judge.py",
    PROJECT / "grader" / "sandbox" / "fork_server.py",
)
# What only shows a result, and is imported when somebody looks. Judging does not even read it.
SHOWS = ("utils.plots.", "utils.scene3d.", "utils.checks.display.")
# Of what students see; checks ask about single objects of it.
TRUTH = PROJECT / "data" / "cloud_truth.npz"
LIBRARIES = ("numpy", "scipy", "scikit-learn", "shapely", "pytest")

# Text instead of a syntax tree, which takes ten times as long; what it finds in a docstring
# does no harm.
_IMPORT = re.compile(r"^[ \t]*(?:from ([\w.]+) import (\([^)]*\)|.*)|import (.*))$", re.M)


def versions() -> dict[str, str]:
    """Version of Python and of each library that decides, by name."""
    # A release that only mends Python changes no answer.
    python = ".".join(map(str, sys.version_info[:2]))
    return {"Python": python} | {name: metadata.version(name) for name in LIBRARIES}


def verdict_key(handed_in: HandedIn, lesson: Lesson, seed: int, student: str = "") -> str:
    """Fingerprint of a submission and of the rules that it is judged by."""
    about = (str(seed), student, rules_key(lesson), handed_in.fingerprint())
    return hashlib.sha256("\0".join(about).encode(errors="replace")).hexdigest()


@functools.cache
def rules_key(lesson: Lesson) -> str:
    """Fingerprint of what decides in one lesson."""
    return key_of_files(lesson.name, files_that_decide(lesson))


def key_of_files(about: str, files: Iterable[Path]) -> str:
    """Fingerprint of what some files and the libraries decide about something."""
    digest = hashlib.sha256(about.encode())
    for name, version in versions().items():
        digest.update(f"{name} {version}\0".encode())
    for path in sorted(files):
        digest.update(f"{path.relative_to(PROJECT).as_posix()}\0".encode() + _digest_of(path))
    return digest.hexdigest()


def files_that_decide(lesson: Lesson) -> frozenset[Path]:
    """The files of this project that a verdict on a lesson depends on."""
    entries = {*ENTRIES, lesson.tests, _file_of(f"utils.checks.lesson_{lesson.number}")}
    # The source says what is forbidden; the solution holds right helpers, borrowed ones as well.
    notebooks = {lesson.source, lesson.solved, lesson.released}
    return frozenset(with_all_they_run(entries) | notebooks | {TRUTH})


def with_all_they_run(files: Iterable[Path]) -> set[Path]:
    """Some files, all of this project that they import, and what runs beside a student's code."""
    found, waiting = set(), set(files)
    while waiting:
        file = waiting.pop()
        found.add(file)
        waiting |= _imported_by(file) - found
    shown = {file for path in SHOWN for file in ([path] if path.is_file() else path.rglob("*.py"))}
    return found | shown


@functools.cache
def _imported_by(file: Path) -> set[Path]:
    """The files of this project that one imports, at its head or within a function."""
    modules = set()
    for package, names, whole in _IMPORT.findall(file.read_text("utf-8")):
        modules |= {f"{package}.{name}" for name in re.findall(r"\w+", names)}
        modules |= set(re.findall(r"[\w.]+", whole))
    # With a module come the packages that it lies in.
    parts = [module.split(".") for module in modules]
    modules = {".".join(part[:end]) for part in parts for end in range(1, len(part) + 1)}
    modules = {module for module in modules if not f"{module}.".startswith(SHOWS)}
    return {file for module in modules if (file := _file_of(module))}


@functools.cache
def _file_of(module: str) -> Path | None:
    """Where a module of this project is written; None for any other."""
    path = PROJECT.joinpath(*module.split("."))
    files = (path.with_suffix(".py"), path / "__init__.py")
    return next((file for file in files if file.is_file()), None)


@functools.cache
def _digest_of(file: Path) -> bytes:
    return hashlib.sha256(file.read_bytes()).digest()
