"""Notebooks per minute: our judge against nbgrader's own autograde, on the same submissions.

Both grade copies of each lesson's solved notebook on the same cores, a stage at a time. nbgrader
executes a notebook in a kernel, one after another; ours judges in parallel, sandbox and the
course's own solutions included, and then enters the scores into a gradebook. What a class of 200
takes in all lessons is reckoned from that. Give it a machine that does nothing else:

    python tests/benchmarks/bench_judge.py [STAGE ...]
"""

import os
import resource
import shutil
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from nbgrader.converters import Autograde
from nbgrader.preprocessors import AssignLatePenalties, Execute, LimitOutput, SaveAutoGrades

from grader.classroom.executors import EXECUTORS
from grader.classroom.grade import judge_class
from grader.classroom.submissions import Submission
from grader.course.lessons import all_lessons, stages
from grader.course.nbgrader_settings import converter
from grader.course.paths import PROJECT, Course
from grader.lms.entering import enter
from grader.lms.gradebook import open_gradebook
from grader.lms.registering import register
from grader.sandbox import choose_sandbox

STUDENTS = 20
STUDENTS_OF_NBGRADER = 2
CLASS = 200
SEED = 1


@dataclass(frozen=True)
class Times:
    """Seconds of a stage, and megabytes of this process, which reads and writes.

    `further` is what each further student costs the judging: all lessons of the stage.
    """

    first: float
    further: float
    judging: float
    entering: float
    notebooks: int
    memory: tuple


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


def megabytes():
    """The most memory that this process has had so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def time_ours(lessons, folder):
    """`Times` of our judge, started cold."""
    course, seen, memory = make_course(folder / "ours", STUDENTS, lessons), {}, []
    sandbox = choose_sandbox()

    def progress(done, total, what):
        if isinstance(what, Submission):
            seen.setdefault(what.lesson, []).append(time.perf_counter())
        if done == total // 4:
            memory.append(megabytes())

    begin = time.perf_counter()
    processes, count = EXECUTORS["processes"], os.cpu_count()
    judged = judge_class(course, (), SEED, sandbox, processes, count, progress)
    memory.append(megabytes())
    middle = time.perf_counter()
    assert all(verdict.score == verdict.max_score for _, verdict in judged)
    enter(course, judged, stages_of(lessons), lambda *news: None)
    end = time.perf_counter()
    return Times(
        min(min(times) for times in seen.values()) - begin,
        sum(map(steady, seen.values())),
        middle - begin,
        end - middle,
        len(judged),
        tuple(memory),
    )


def steady(times):
    """Seconds from verdict to verdict of a lesson, where nothing is made for the first time."""
    few, most = len(times) // 4, 3 * len(times) // 4
    return (times[most] - times[few]) / (most - few)


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


def main(wanted):
    """Measure and print."""
    whole, reckoned = [], 0.0
    for stage in wanted or stages():
        lessons = [lesson for lesson in all_lessons() if lesson.stage == stage]
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder).resolve()
            ours = time_ours(lessons, folder)
            seconds, notebooks = time_nbgrader(lessons, folder)
        theirs, mine = seconds / notebooks, (ours.judging + ours.entering) / ours.notebooks
        whole.append((theirs, mine, len(lessons)))
        each = ours.further + ours.entering / STUDENTS
        reckoned += ours.judging + ours.entering + (CLASS - STUDENTS) * each
        print(
            f"{stage}: nbgrader autograde {60 / theirs:.1f} notebooks per minute; ours "
            f"{60 / mine:.1f}, gradebook included, {theirs / mine:.1f} x "
            f"({theirs * ours.notebooks / ours.judging:.1f} x without)"
        )
        print(
            f"  {ours.notebooks} notebooks: the first after {ours.first:.1f} s, all judged after "
            f"{ours.judging:.1f} s, entered in {ours.entering:.1f} s; memory "
            f"{ours.memory[0]:.0f} MB after a quarter of them, {ours.memory[-1]:.0f} MB after all",
            flush=True,
        )
    lessons = sum(count for *_, count in whole)
    theirs, mine = (sum(one[which] * one[2] for one in whole) / lessons for which in (0, 1))
    print(f"{lessons} lessons: {theirs / mine:.1f} x nbgrader autograde")
    print(f"{CLASS} students x {lessons} lessons, at this rate: {reckoned / 60:.0f} min")


if __name__ == "__main__":
    main(sys.argv[1:])
