"""Check that right notebooks lose no points on a busy machine.

The script judges a class of right answers with one job per processor: first on an otherwise idle
machine, then with one, two and four busy processes for each processor. The lessons are rehearsed
first. The exit status is 1 if a right notebook loses a point.

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

from grader.classroom.executors import EXECUTORS, processor_count
from grader.classroom.grade import judge_class
from grader.classroom.rehearsals import Rehearsals
from grader.classroom.submissions import Submission
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import all_lessons
from grader.course.paths import Course
from grader.sandbox import choose_sandbox

LOADS = (0, 1, 2, 4)  # busy processes per processor
NOTEBOOKS = 100
SEED = 1


def submit(course, count):
    """Write `count` submissions, cycling through all lessons and right answers."""
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
    """Run `count` busy processes with the same priority as this one."""
    # Each process has its own session, because some kernels share processor time among sessions.
    command = [sys.executable, "-c", "while True: pass"]
    others = [subprocess.Popen(command, start_new_session=True) for _ in range(count)]
    try:
        yield
    finally:
        for process in others:
            process.kill()
            process.wait()


def judge_under_load(load, course, sandbox):
    """Judge the class under a load; return verdicts, repeated submissions and seconds."""
    for verdicts in course.verdicts.glob("student*"):
        shutil.rmtree(verdicts)
    judged_submissions = []

    def progress(done, total, news):
        judged_submissions.extend([news] * isinstance(news, Submission))

    with busy(load * processor_count()):
        start = time.perf_counter()
        judged = judge_class(
            course, (), SEED, sandbox, EXECUTORS["processes"], processor_count(), progress
        )
        again = [
            submission for submission, times in Counter(judged_submissions).items() if times > 1
        ]
        return judged, again, time.perf_counter() - start


def main(count=NOTEBOOKS):
    """Judge a class in a temporary course under each load, and return the exit status."""
    with tempfile.TemporaryDirectory() as folder:
        return measure_loads(Course(Path(folder).resolve()), count)


def measure_loads(course, count):
    """Judge under each load, print the times and lost points, and return the exit status."""
    sandbox, lost, judged_twice = choose_sandbox(), [], []
    submit(course, count)
    with EXECUTORS["processes"](processor_count()) as executor:
        Rehearsals(course, all_lessons()[:count], SEED, sandbox).finish(executor)
    print("load | right | points lost | judged again | slowest (s) | all (s)", flush=True)
    for load in LOADS:
        judged, again, seconds = judge_under_load(load, course, sandbox)
        incomplete = [
            (submission, verdict)
            for submission, verdict in judged
            if verdict.score < verdict.max_score
        ]
        points = sum(verdict.max_score - verdict.score for _, verdict in incomplete)
        slowest = max(verdict.seconds for _, verdict in judged)
        print(
            f"{load:4} | {len(judged) - len(incomplete):5} | {points:11.2f} | {len(again):12} | "
            f"{slowest:11.1f} | {seconds:7.1f}",
            flush=True,
        )
        lost += [(load, submission, verdict) for submission, verdict in incomplete]
        judged_twice += [
            f"load {load}, {submission.student}, {submission.lesson.name}: judged again"
            for submission in again
        ]
    print(*judged_twice, sep="\n", end="\n" * bool(judged_twice))
    for load, submission, verdict in lost:
        for test in (
            test for exercise in verdict.exercises for test in exercise.tests if not test.passed
        ):
            print(
                f"load {load}, {submission.student}, {verdict.lesson}, {test.name}: {test.message}"
            )
    return int(bool(lost))


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
