"""Right notebooks on a machine that others keep busy: nobody may lose a point by it.

A class of right answers is judged, as many at once as there are processors, with nothing beside it
and then beside one, two and four processes for each processor that never rest. Rehearsals are done
first. It ends with status 1 where a right notebook has lost a point. Give it a machine that does
nothing else:

    PYTHONPATH=. python tests/benchmarks/load.py [NOTEBOOKS]     # 100 by default; an hour or two
"""

import contextlib
import itertools
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from grader.classroom.executors import EXECUTORS, processors
from grader.classroom.grade import judge_class
from grader.classroom.rehearsals import Rehearsals
from grader.classroom.submissions import Submission
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import all_lessons
from grader.course.paths import Course
from grader.sandbox import choose_sandbox

LOADS = (0, 1, 2, 4)  # processes that never rest, for each processor
NOTEBOOKS = 100
SEED = 1


def hand_in(course, count):
    """So many notebooks, lesson by lesson, with one right answer after another."""
    for number, lesson in zip(range(count), itertools.cycle(all_lessons()), strict=False):
        answers = {}
        for exercise in lesson.machine_graded:
            right = [answer for answer in answers_to(exercise.name) if answer.right]
            answers[exercise.name] = right[number // len(all_lessons()) % len(right)].source
        path = course.submitted / f"student{number:03}" / lesson.stage / f"{lesson.name}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(fill_in(lesson, answers), "utf-8")


@contextlib.contextmanager
def busy(count):
    """So many processes that never rest, as eager for a processor as this one."""
    # Each in a session of its own: some kernels share a processor out by session.
    command = [sys.executable, "-c", "while True: pass"]
    others = [subprocess.Popen(command, start_new_session=True) for _ in range(count)]
    try:
        yield
    finally:
        for process in others:
            process.kill()
            process.wait()


def judge_beside(load, course, sandbox):
    """What came of a class beside some load: (verdicts, who was judged again, seconds)."""
    for verdicts in course.verdicts.glob("student*"):
        shutil.rmtree(verdicts)
    told = []

    def progress(done, total, what):
        told.extend([what] * isinstance(what, Submission))

    with busy(load * processors()):
        begin = time.perf_counter()
        judged = judge_class(
            course, (), SEED, sandbox, EXECUTORS["processes"], processors(), progress
        )
        again = [submission for submission, times in Counter(told).items() if times > 1]
        return judged, again, time.perf_counter() - begin


def main(count=NOTEBOOKS):
    """Measure and print."""
    with tempfile.TemporaryDirectory() as folder:
        return try_loads(Course(Path(folder).resolve()), count)


def try_loads(course, count):
    """The exit status; prints a line for each load, and what was lost."""
    sandbox, lost, twice = choose_sandbox(), [], []
    hand_in(course, count)
    with EXECUTORS["processes"](processors()) as executor:
        Rehearsals(course, all_lessons()[:count], SEED, sandbox).finish(executor)
    print("load | right | points lost | judged again | slowest (s) | all (s)", flush=True)
    for load in LOADS:
        judged, again, seconds = judge_beside(load, course, sandbox)
        short = [(who, verdict) for who, verdict in judged if verdict.score < verdict.max_score]
        points = sum(verdict.max_score - verdict.score for _, verdict in short)
        slowest = max(verdict.seconds for _, verdict in judged)
        print(
            f"{load:4} | {len(judged) - len(short):5} | {points:11.2f} | {len(again):12} | "
            f"{slowest:11.1f} | {seconds:7.1f}",
            flush=True,
        )
        lost += [(load, who, verdict) for who, verdict in short]
        twice += [f"load {load}, {who.student}, {who.lesson.name}: judged again" for who in again]
    print(*twice, sep="\n", end="\n" * bool(twice))
    for load, who, verdict in lost:
        for test in (
            test for exercise in verdict.exercises for test in exercise.tests if not test.passed
        ):
            print(f"load {load}, {who.student}, {verdict.lesson}, {test.name}: {test.message}")
    return int(bool(lost))


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
