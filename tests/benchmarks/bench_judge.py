"""Notebooks per minute: our judge against nbgrader's own autograde, on the same submissions.

Both grade copies of each lesson's solved notebook on the same cores. nbgrader executes a
notebook in a kernel, one after another; ours judges in parallel, sandbox included, and then
enters the scores into a gradebook, which is timed too.
"""

import os
import shutil
import tempfile
import time
from pathlib import Path

from nbgrader.converters import Autograde
from nbgrader.preprocessors import AssignLatePenalties, Execute, LimitOutput, SaveAutoGrades

from grader.classroom.executors import EXECUTORS
from grader.classroom.grade import judge_class
from grader.course.lessons import all_lessons
from grader.course.nbgrader_settings import converter
from grader.course.paths import PROJECT, Course
from grader.lms.gradebook import enter, open_gradebook, register
from grader.sandbox import choose_sandbox

STUDENTS = 6
STUDENTS_OF_NBGRADER = 2
SEED = 1


def make_course(root, students, lessons):
    """A course with `students` copies of the solved notebooks."""
    course = Course(root)
    for folder in ("solutions", "notebooks"):
        shutil.copytree(
            PROJECT / folder,
            root / folder,
            ignore=shutil.ignore_patterns("*.py", "*.md", "pictures"),
        )
    # nbgrader runs notebooks where they lie and these look for the course above them.
    for name in ("utils", "data"):
        (root / name).symlink_to(PROJECT / name)
    for number in range(students):
        for lesson in lessons:
            path = course.submitted / f"student{number}" / lesson.stage / f"{lesson.name}.ipynb"
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(lesson.solved, path)
    return course


def time_ours(lessons, folder):
    """(seconds of judging, seconds of entering, notebooks)."""
    course = make_course(folder / "ours", STUDENTS, lessons)
    sandbox = choose_sandbox()
    begin = time.perf_counter()
    processes, count = EXECUTORS["processes"], os.cpu_count()
    judged = judge_class(course, (), SEED, sandbox, processes, count, lambda *news: None)
    middle = time.perf_counter()
    enter(course, judged, stages_of(lessons), lambda *news: None)
    return middle - begin, time.perf_counter() - middle, len(judged)


def stages_of(lessons):
    return tuple(dict.fromkeys(lesson.stage for lesson in lessons))


def time_nbgrader(lessons, folder):
    """(seconds, notebooks) of nbgrader as it comes."""
    course = make_course(folder / "nbgrader", STUDENTS_OF_NBGRADER, lessons)
    stages = stages_of(lessons)
    with open_gradebook(course) as book:
        register(course, book, stages)
    begin = time.perf_counter()
    for stage in stages:
        autograde = converter(Autograde, course.root, stage)
        autograde.autograde_preprocessors = [
            Execute,
            LimitOutput,
            SaveAutoGrades,
            AssignLatePenalties,
        ]
        autograde.coursedir.student_id = "*"
        autograde.start()
    return time.perf_counter() - begin, STUDENTS_OF_NBGRADER * len(lessons)


def main():
    """Measure and print."""
    lessons = all_lessons()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder).resolve()
        judging, entering, ours = time_ours(lessons, folder)
        seconds, theirs = time_nbgrader(lessons, folder)
    per_minute = 60 * theirs / seconds
    print(f"nbgrader autograde        {per_minute:8.1f} notebooks per minute")
    for name, mine in (("judging", judging), ("judging and gradebook", judging + entering)):
        rate = 60 * ours / mine
        print(f"{name:25} {rate:8.1f} notebooks per minute, {rate / per_minute:5.1f} x")


if __name__ == "__main__":
    main()
