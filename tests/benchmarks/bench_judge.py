"""Notebooks per minute: our judge against nbgrader's own autograde, on the same submissions.

Both grade copies of each lesson's solved notebook, from the command line and in turns, in a copy
of the course each; whoever gives less than full marks ends the race. nbgrader executes a notebook
in a kernel, one after another; what one more takes is the difference between two students and one,
so that its start is told apart. Ours is timed on a class, start, sandbox, report and gradebook
included. ROUNDS says how often.

What a class of 200 takes in all lessons is reckoned from a run inside this process, where
verdicts can be watched as they come.

Give it a machine that does nothing else. nbgrader keeps one hardware thread busy, and has the
whole core while nobody is on the other one; ours fills all threads anyway. That may be why
others at work cost nbgrader more than ours.

    python tests/benchmarks/bench_judge.py [STAGE ...]

It adds to `.bench/measured.json`, under "judge".
"""

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from nbgrader.api import Gradebook

from grader.classroom.executors import EXECUTORS
from grader.classroom.grade import judge_class
from grader.classroom.submissions import Submission
from grader.course.lessons import all_lessons, stages
from grader.course.paths import PROJECT, Course
from grader.lms.gradebook import open_gradebook
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.registration import register_stages
from grader.sandbox import choose_sandbox
from tests.benchmarks.racing import write_down

STUDENTS = 20
ROUNDS = int(os.environ.get("ROUNDS", 3))
# Seconds that nbgrader took for a notebook of the course's first edition, when it was shorter.
FIRST_EDITION = 4.0
# nbgrader as it comes: it executes notebooks, and counts the visible checks that pass.
PLAIN = """\
c = get_config()
c.CourseDirectory.source_directory = "solutions"
c.CourseDirectory.release_directory = "notebooks"
"""
CLASS = 200
SEED = 1


@dataclass(frozen=True)
class Times:
    """Seconds of a stage, and megabytes of this process, which reads and writes.

    `further` is what each further student costs the judging, by the name of the lesson.
    """

    first: float
    further: dict
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
            ignore=shutil.ignore_patterns("*.py", "*.md", "*.png", "*.gif"),
        )
    # nbgrader runs notebooks where they lie and these look for the course above them.
    for name in ("utils", "data"):
        (root / name).symlink_to(PROJECT / name)
    for number in range(students):
        for lesson in lessons:
            path = course.submitted / f"student{number}" / lesson.stage / f"{lesson.name}.ipynb"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(_as_written_by(number, lesson)), "utf-8")
    return course


def _as_written_by(number, lesson):
    """The solved notebook, with a comment in each answer: what is right is asked only once."""
    notebook = json.loads(lesson.solved.read_text("utf-8"))
    for cell in notebook["cells"]:
        if cell["metadata"].get("nbgrader", {}).get("solution") and cell["cell_type"] == "code":
            cell["source"] = ["".join(cell["source"]) + f"\n# Student {number}"]
    return notebook


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
    enter_verdicts(course, judged, stages_of(lessons), lambda *news: None)
    end = time.perf_counter()
    return Times(
        min(min(times) for times in seen.values()) - begin,
        {lesson.name: steady(times) for lesson, times in seen.items()},
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


def command_line(root, *words):
    """Seconds of a command in a course, as somebody types it."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"  # nbgrader's alembic
    environment = {**os.environ, "PATH": path, "PYTHONPATH": str(root)}
    begin = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", *words], cwd=root, env=environment, capture_output=True, text=True
    )
    seconds = time.perf_counter() - begin
    assert done.returncode == 0, done.stdout + done.stderr
    return seconds


def assert_full_marks(root, stage, notebooks):
    """Every automatic mark of this many notebooks is in the gradebook, and full."""
    with Gradebook(f"sqlite:///{root / 'gradebook.db'}") as book:
        graded = [
            notebook
            for submission in book.assignment_submissions(stage)
            for notebook in submission.notebooks
        ]
        assert len(graded) == notebooks, (len(graded), notebooks)
        for notebook in graded:
            marks = [grade for grade in notebook.grades if grade.cell.cell_type == "code"]
            assert marks, notebook
            assert all(mark.auto_score == mark.max_score for mark in marks), notebook


def time_theirs(lessons, folder, students):
    """Seconds of nbgrader as it comes, from a gradebook that knows the stage."""
    stage, course = lessons[0].stage, make_course(folder, students, lessons)
    with open_gradebook(course) as book:
        register_stages(course, book, [stage])
    (folder / "nbgrader_config.py").write_text(PLAIN)
    seconds = command_line(folder, "nbgrader", "autograde", stage)
    assert_full_marks(folder, stage, students * len(lessons))
    return seconds


def time_grade(lessons, folder):
    """Seconds of `python -m grader grade` in a copy of the project."""
    stage, _ = lessons[0].stage, make_course(folder, STUDENTS, lessons)
    shutil.copytree(PROJECT / "grader", folder / "grader")
    shutil.copytree(PROJECT / "solutions", folder / "solutions", dirs_exist_ok=True)
    for name in ("nbgrader_config.py", "pyproject.toml"):
        shutil.copy(PROJECT / name, folder)
    seconds = command_line(folder, "grader", "grade", stage)
    assert_full_marks(folder, stage, STUDENTS * len(lessons))
    return seconds


def race(lessons):
    """Seconds a notebook, (rounds, 2): nbgrader's, ours; and nbgrader's start, (rounds,)."""
    found, starts = [], []
    for _ in range(ROUNDS):
        with tempfile.TemporaryDirectory() as place:
            place = Path(place).resolve()
            one = time_theirs(lessons, place / "one", 1)
            ours = time_grade(lessons, place / "ours")
            two = time_theirs(lessons, place / "two", 2)
        found.append(((two - one) / len(lessons), ours / (STUDENTS * len(lessons))))
        starts.append(2 * one - two)
    return np.array(found), np.array(starts)


def main(wanted):
    """Measure, print, write down."""
    if os.getloadavg()[0] > 0.5:
        print("Others are at work on this machine, which may flatter ours.")
    record, reckoned, count = {}, 0.0, 0
    for stage in wanted or stages():
        lessons = [lesson for lesson in all_lessons() if lesson.stage == stage]
        seconds, starts = race(lessons)
        ratios = seconds[:, 0] / seconds[:, 1]
        theirs, mine = np.median(seconds, axis=0)
        print(
            f"{stage}: nbgrader autograde {theirs:.2f} s a notebook, after {np.median(starts):.1f} "
            f"s to start; ours {mine:.2f} s, start and gradebook included: "
            f"{np.median(ratios):.1f} x as fast ({min(ratios):.1f} to {max(ratios):.1f} in "
            f"{ROUNDS} rounds). A notebook of the first edition took nbgrader {FIRST_EDITION:.0f} "
            f"s: {FIRST_EDITION / mine:.1f} x"
        )
        with tempfile.TemporaryDirectory() as folder:
            ours = time_ours(lessons, Path(folder).resolve())
        print(
            f"  {ours.notebooks} notebooks: the first after {ours.first:.1f} s, all judged after "
            f"{ours.judging:.1f} s, entered in {ours.entering:.1f} s; memory "
            f"{ours.memory[0]:.0f} MB after a quarter of them, {ours.memory[-1]:.0f} MB after all"
        )
        print(
            "  each further notebook, in ms: "
            + ", ".join(f"{name} {1000 * s:.0f}" for name, s in ours.further.items()),
            flush=True,
        )
        each = sum(ours.further.values()) + ours.entering / STUDENTS
        reckoned += ours.judging + ours.entering + (CLASS - STUDENTS) * each
        count += len(lessons)
        record[stage] = {
            "seconds a notebook": {
                "nbgrader": seconds[:, 0].tolist(),
                "ours": seconds[:, 1].tolist(),
            },
            "seconds to start nbgrader": starts.tolist(),
            "times as fast": ratios.tolist(),
            "seconds a further student": each,
            "seconds a further notebook": ours.further,
        }
    print(f"{CLASS} students x {count} lessons, at this rate: {reckoned / 60:.0f} min")
    write_down("judge", record)


if __name__ == "__main__":
    main(sys.argv[1:])
