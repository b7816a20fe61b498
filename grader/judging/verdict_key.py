"""The key of a verdict: a fingerprint of everything that the verdict depends on.

A stored verdict is valid as long as its key does not change. After a change of a plotting module,
for example, the key is the same, and submissions are not judged again. The code that a verdict
depends on is not listed by hand. It is found by following import statements from the judge, the
sandbox's fork server, and the lesson's tests and checks.
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
from grader.intake.submission import SubmittedFiles
from grader.sandbox.boundary import SHOWN_PATHS

# Entry points of judging: the judge, and the server that forks processes for student code.
ENTRY_MODULES = (
    PROJECT / "grader" / "judging" / "judge.py",
    PROJECT / "grader" / "sandbox" / "fork_server.py",
)
# Modules that only display results. They are imported on demand, and judging never uses them.
DISPLAY_MODULES = ("utils.plots.", "utils.scene3d.", "utils.checks.display.")
# Arrays that checks read.
ARRAY_FILES = tuple((PROJECT / "data").glob("*.npz"))
LIBRARIES = ("numpy", "scipy", "scikit-learn", "shapely", "pytest")

# A regular expression finds imports ten times as fast as a syntax tree. It may also match text in a
# docstring, which is harmless.
_IMPORT = re.compile(r"^[ \t]*(?:from ([\w.]+) import (\([^)]*\)|.*)|import (.*))$", re.M)


def versions() -> dict[str, str]:
    """Return the versions of Python and of each library that verdicts depend on, by name."""
    # Python's patch releases are ignored, because they do not change answers.
    python = ".".join(map(str, sys.version_info[:2]))
    return {"Python": python} | {name: metadata.version(name) for name in LIBRARIES}


def verdict_key(
    submitted_files: SubmittedFiles, lesson: Lesson, seed: int, student: str = ""
) -> str:
    """Return the fingerprint of a submission and everything that is used to judge it."""
    parts = (str(seed), student, rules_key(lesson), submitted_files.fingerprint())
    return hashlib.sha256("\0".join(parts).encode(errors="replace")).hexdigest()


@functools.cache
def rules_key(lesson: Lesson) -> str:
    """Return the fingerprint of everything that verdicts on one lesson depend on."""
    return key_of_files(lesson.name, verdict_dependencies(lesson))


def key_of_files(subject: str, files: Iterable[Path]) -> str:
    """Return the fingerprint of a subject's name, the library versions, and some files."""
    digest = hashlib.sha256(subject.encode())
    for name, version in versions().items():
        digest.update(f"{name} {version}\0".encode())
    for path in sorted(files):
        digest.update(f"{path.relative_to(PROJECT).as_posix()}\0".encode() + _digest_of(path))
    return digest.hexdigest()


def verdict_dependencies(lesson: Lesson) -> frozenset[Path]:
    """Return the files of this project that a verdict on a lesson depends on."""
    entries = {
        *ENTRY_MODULES,
        lesson.tests,
        _find_module_file(f"utils.checks.lesson_{lesson.number}"),
    }
    # The source lists forbidden modules, the solution contains correct helpers, and the released
    # notebook contains given code.
    notebooks = {lesson.source, lesson.solved, lesson.released}
    return frozenset(add_imports(entries) | notebooks | {*ARRAY_FILES})


def add_imports(files: Iterable[Path]) -> set[Path]:
    """Return the files, all project files that they import, and the files shown in the sandbox."""
    files_with_imports, waiting = set(), set(files)
    while waiting:
        file = waiting.pop()
        files_with_imports.add(file)
        waiting |= _imported_files(file) - files_with_imports
    sandbox_files = {
        file for path in SHOWN_PATHS for file in ([path] if path.is_file() else path.rglob("*.py"))
    }
    return files_with_imports | sandbox_files


@functools.cache
def _imported_files(file: Path) -> set[Path]:
    """Return the project files that a file imports, at its top or inside a function."""
    modules = set()
    for package, names, whole in _IMPORT.findall(file.read_text("utf-8")):
        modules |= {f"{package}.{name}" for name in re.findall(r"\w+", names)}
        modules |= set(re.findall(r"[\w.]+", whole))
    # Importing a module also runs the `__init__.py` of each package that contains it.
    parts = [module.split(".") for module in modules]
    modules = {".".join(part[:end]) for part in parts for end in range(1, len(part) + 1)}
    modules = {module for module in modules if not f"{module}.".startswith(DISPLAY_MODULES)}
    return {file for module in modules if (file := _find_module_file(module))}


@functools.cache
def _find_module_file(module: str) -> Path | None:
    """Return the file of a module of this project, or None for any other module."""
    path = PROJECT.joinpath(*module.split("."))
    files = (path.with_suffix(".py"), path / "__init__.py")
    return next((file for file in files if file.is_file()), None)


@functools.cache
def _digest_of(file: Path) -> bytes:
    return hashlib.sha256(file.read_bytes()).digest()
