"""Check whether everything is ready for grading, and suggest a fix for each problem."""

from __future__ import annotations

import contextlib
import platform
import re
import shutil
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from dataclasses import dataclass
from importlib import metadata

from packaging.requirements import Requirement

from grader.classroom.folders import misspelt_folders, unmatched_folders
from grader.classroom.rehearsals import RehearsalFailed, Rehearsals
from grader.classroom.submissions import find_submissions, unaccounted_files
from grader.course.deadlines import Deadlines
from grader.course.deadlines_file import DeadlinesError, read_deadlines
from grader.course.lessons import all_lessons
from grader.course.paths import PROJECT, Course
from grader.course.roster import Roster, RosterError, read_roster
from grader.sandbox import SANDBOXES, Sandbox, SandboxUnavailable
from grader.sandbox.boundary import is_shown

MIN_FREE_BYTES = 2**30
NOT_CHECKED = "not checked. Correct roster.csv or deadlines.toml, and run doctor again"


@dataclass(frozen=True)
class Finding:
    """The result of examining one subject.

    Attributes
    ----------
    subject : str
    is_good : bool
    text : str
        The result and, if there is a problem, how to fix it.
    """

    subject: str
    is_good: bool
    text: str


def examine(
    course: Course,
    seed: int,
    sandbox: Sandbox,
    executor: Executor,
    progress_bar: Callable[[str], AbstractContextManager],
) -> Iterator[Finding]:
    """Examine everything that grading relies on, and yield the quickest findings first.

    Parameters
    ----------
    course : grader.course.paths.Course
    seed : int
    sandbox : grader.sandbox.Sandbox
        Runs the lessons' own solutions.
    executor : concurrent.futures.Executor
    progress_bar : callable
        Shows the progress of long work, like `grader.console.progress_bar`.
    """
    yield from _examine_versions()
    yield from _examine_sandboxes()
    yield _examine_boundary(course)
    yield _examine_free_space(course)
    yield _examine_seed(course)
    yield _examine_solutions(
        Rehearsals(course, all_lessons(), seed, sandbox), executor, progress_bar
    )
    try:
        yield from _examine_roster(course)
        yield from _examine_files(course)
    except RosterError as error:
        yield Finding("roster", False, str(error))
        yield Finding("submitted", False, NOT_CHECKED)
    yield _examine_deadlines(course)


def _examine_versions() -> Iterator[Finding]:
    newest = ".".join(map(str, sys.version_info[:2]))
    yield Finding(
        "Python",
        True,
        f"{platform.python_version()} on {platform.platform()}. Students may use Python {newest} "
        "or older. A notebook that needs a newer Python gets no mark, and `grade` lists it",
    )
    yield _examine_packages("requirements.txt")
    if _installed_version("distributed"):  # installed only for a cluster
        yield _examine_packages("requirements-cluster.txt")


def _examine_packages(file: str) -> Finding:
    lines = re.findall(r"^\w[^#\n]*==[^#\n]*", (PROJECT / file).read_text("utf-8"), re.M)
    pins = [pin for pin in map(Requirement, lines) if not pin.marker or pin.marker.evaluate()]
    mismatches = [
        f"{pin.name} is {_installed_version(pin.name) or 'missing'}, but "
        f"should be {str(pin.specifier)[2:]}"
        for pin in pins
        if not _installed_version(pin.name) or _installed_version(pin.name) not in pin.specifier
    ]
    return Finding(
        "packages",
        not mismatches,
        f"{'; '.join(mismatches)}. Run: pip install -r {file}"
        if mismatches
        else f"the versions of all {len(pins)} packages match {file}",
    )


def _installed_version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _examine_sandboxes() -> Iterator[Finding]:
    for sandbox in SANDBOXES.values():
        if sandbox.warning:
            remark = f"protects less than bubblewrap; used only with --sandbox {sandbox.name}"
            yield Finding(f"sandbox {sandbox.name}", True, remark)
            continue
        try:
            sandbox.check_available()
        except SandboxUnavailable as error:
            yield Finding(f"sandbox {sandbox.name}", False, str(error))
        else:
            text = f"{sandbox.label()}: {sandbox.protections()}"
            yield Finding(f"sandbox {sandbox.name}", True, text)


def _examine_boundary(course: Course) -> Finding:
    exposed = [path for path in (PROJECT / "solutions", course.root) if is_shown(path)]
    if not exposed:
        return Finding("isolation", True, "student code sees neither hidden tests nor submissions")
    return Finding(
        "isolation",
        False,
        f"student code could read {exposed[0]}, because it is in a folder that is visible in every "
        "sandbox. Move it, for example into your home folder.",
    )


def _examine_free_space(course: Course) -> Finding:
    free = shutil.disk_usage(course.root).free
    return Finding("disk", free > MIN_FREE_BYTES, f"{free / 2**30:.1f} GB free at {course.root}")


def _examine_seed(course: Course) -> Finding:
    if not course.seed_file.exists():
        return Finding("seed", True, "not created yet; the first run of `grade` creates it")
    is_readable_by_others = course.seed_file.stat().st_mode & 0o077
    return Finding(
        "seed",
        not is_readable_by_others,
        f"other users can read {course.seed_file}. Run: chmod 600 {course.seed_file}"
        if is_readable_by_others
        else "created, and readable only by you",
    )


def _examine_solutions(
    rehearsals: Rehearsals,
    executor: Executor,
    progress_bar: Callable[[str], AbstractContextManager],
) -> Finding:
    try:
        if rehearsals.waiting:
            with progress_bar("Judging the solutions") as advance:
                rehearsals.finish(executor, advance)
    except RehearsalFailed as error:
        return Finding("solutions", False, str(error))
    return Finding(
        "solutions",
        True,
        f"the solutions for all {len(all_lessons())} lessons earn full points with this seed",
    )


def _examine_files(course: Course) -> Iterator[Finding]:
    found = unaccounted_files(course)
    if not found:
        yield Finding("submitted", True, "every file is a submission, or belongs to a submission")
    for path, reason in found:
        yield Finding("submitted", False, f"{path}: {reason}")


def _examine_roster(course: Course) -> Iterator[Finding]:
    """Compare the roster with the folders in ``submitted/``."""
    class_roster = read_roster(course)
    if class_roster is None:
        yield Finding(
            "roster",
            True,
            "there is no roster.csv, so every folder in submitted/ counts as a student",
        )
        return
    sections = Counter(person.section for person in class_roster.people if person.section)
    size = len(class_roster.people)
    counts = [f"{size} {'person' if size == 1 else 'people'}"]
    counts += [f"{count} in section {name}" for name, count in sorted(sections.items())]
    without_number = [person.id for person in class_roster.people if not person.lms_id]
    counts += [f"{len(without_number)} without an lms_id"] if without_number else []
    yield Finding("roster", True, ", ".join(counts))
    yield from _examine_submissions(course, class_roster)
    for sentence in misspelt_folders(course, class_roster):
        yield Finding("roster", True, sentence)
    for sentence in unmatched_folders(course, class_roster).values():
        yield Finding("roster", False, sentence)


def _examine_submissions(course: Course, roster: Roster) -> Iterator[Finding]:
    """Yield the missing and excused students of each stage that has submissions."""
    deadlines = Deadlines({})
    with contextlib.suppress(DeadlinesError):  # `_examine_deadlines` reports the error
        deadlines = read_deadlines(course) or deadlines
    by_stage: dict[str, set[str]] = {}
    for submission in find_submissions(course):
        by_stage.setdefault(submission.lesson.stage, set()).add(submission.student)
    for stage, students in sorted(by_stage.items()):
        expected = [person.id for person in roster.people if not person.is_auditor]
        absent = [id for id in expected if id not in students]
        excused = [id for id in absent if deadlines.is_excused(id, stage)]
        missing = [id for id in absent if id not in excused]
        texts = [f"{len(expected) - len(absent)} of {len(expected)} submitted"]
        texts += [f"missing: {', '.join(missing)}"] if missing else []
        texts += [f"excused: {', '.join(excused)}"] if excused else []
        yield Finding(stage, True, "; ".join(texts))


def _examine_deadlines(course: Course) -> Finding:
    try:
        deadlines = read_deadlines(course)
    except (DeadlinesError, RosterError) as error:
        return Finding("deadlines", False, str(error))
    if deadlines is None:
        return Finding(
            "deadlines", True, "there is no deadlines.toml, so the dates in the gradebook apply"
        )
    text = "; ".join(deadlines.descriptions())
    return Finding("deadlines", True, text or "deadlines.toml does not contain any settings")
