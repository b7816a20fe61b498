"""Measure how fast one writer enters a class in a growing gradebook, in SQLite and PostgreSQL.

All students submit the solved notebooks of the first stage, which are judged only once. The script
skips PostgreSQL if Debian's package ``postgresql`` is not installed.
"""

import argparse
import contextlib
import dataclasses
import shutil
import tempfile
import time
from pathlib import Path

from grader.classroom.demo import CONFIGURATION
from grader.classroom.grade import judge_one
from grader.classroom.submissions import Submission
from grader.course.lessons import all_lessons, stages
from grader.course.paths import PROJECT, Course
from grader.intake.submission import read_submitted_files
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.results_reader import class_results
from grader.sandbox import choose_sandbox
from tests.postgresql import NotInstalled, server

SEED = 1
STAGE = stages()[0]


def make_course(root, database):
    """Return a course without students whose gradebook is in the given database."""
    shutil.copytree(PROJECT / "notebooks" / STAGE, root / "notebooks" / STAGE)
    line = f"get_config().CourseDirectory.db_url = {database!r}\n" if database else ""
    (root / "nbgrader_config.py").write_text(CONFIGURATION.format(project=str(PROJECT)) + line)
    return Course(root)


def submit(course, verdicts, students):
    """Submit the solved notebooks for these students; return (submission, verdict) pairs."""
    judged = []
    for student in students:
        for lesson, verdict in verdicts.items():
            path = course.submitted / student / STAGE / f"{lesson.name}.ipynb"
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(lesson.solved, path)
            own_verdict = dataclasses.replace(verdict, student=student)
            judged.append((Submission(student, lesson, path), own_verdict))
    return judged


def seconds(function, *arguments):
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start


def measure(name, course, verdicts, students, step):
    """Enter `step` students at a time and print how long each step takes."""
    judged, ignore = [], lambda *news: None
    for first in range(0, students, step):
        names = [f"student{number:06}" for number in range(first, first + step)]
        judged += submit(course, verdicts, names)
        before = seconds(enter_verdicts, course, judged[: -step * len(verdicts)], [STAGE], ignore)
        both = seconds(enter_verdicts, course, judged, [STAGE], ignore)
        again = seconds(enter_verdicts, course, judged, [STAGE], ignore)
        count = len(judged) // len(verdicts)
        print(
            f"{name:12} {count:9,} {1000 * (both - before) / step:22.0f} "
            f"{1000 * again / count:20.1f} {seconds(class_results, course):18.1f}",
            flush=True,
        )


def main():
    """Measure the times of both databases, and print them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--students", type=int, default=120, help="final number of students")
    parser.add_argument(
        "--step", type=int, default=40, help="number of students to enter at a time"
    )
    options = parser.parse_args()
    sandbox = choose_sandbox()
    verdicts = {
        lesson: judge_one(read_submitted_files(lesson.solved), lesson.name, "", SEED, sandbox.name)
        for lesson in all_lessons()
        if lesson.stage == STAGE
    }
    print("gradebook     students   ms to enter a student   ms to compare one  s to read all marks")
    with contextlib.ExitStack() as stack:
        databases = {"SQLite": ""}
        try:
            databases["PostgreSQL"] = stack.enter_context(server())
        except NotInstalled as error:
            print(error)
        for name, database in databases.items():
            root = Path(stack.enter_context(tempfile.TemporaryDirectory())).resolve()
            course = make_course(root, database)
            measure(name, course, verdicts, options.students, options.step)


if __name__ == "__main__":
    main()
