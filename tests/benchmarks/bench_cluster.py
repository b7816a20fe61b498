"""Measure the cost of grading on a cluster, in core seconds per notebook and in money.

The sample class submits right and wrong answers of many kinds to all lessons. One worker judges
them with all processors of this machine. Run the script on an otherwise idle machine, and give your
provider's price per core and hour: ``python tests/benchmarks/bench_cluster.py --price 0.03``
"""

import argparse
import contextlib
import os
import tempfile
import time
from pathlib import Path

from distributed import LocalCluster

from grader.classroom.cluster import connect
from grader.classroom.executors import processor_count
from grader.classroom.grade import judge_class, judge_one
from grader.classroom.submissions import find_submissions
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import all_lessons
from grader.course.paths import Course
from grader.sandbox import choose_sandbox

SEED = 1
CLASSES = (1_000, 100_000, 1_000_000)
# Assumed price in USD per hour for one virtual core of an on-demand c5.2xlarge in US East. The user
# guide of Amazon EC2 Auto Scaling uses 0.34 USD for eight cores as an example.
PRICE = 0.0425


def make_class(root, students):
    """Return a course in which the students submit different kept answers to each exercise."""
    course = Course(root)
    for number in range(students):
        for lesson in all_lessons():
            answers = {}
            for exercise in lesson.machine_graded:
                variants = answers_to(exercise.name)
                answers[exercise.name] = variants[number % len(variants)].source
            path = course.submitted / f"student{number}" / lesson.stage / f"{lesson.name}.ipynb"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(fill_in(lesson, answers), "utf-8")
    return course


def cpu_seconds(course, sandbox):
    """Judge all notebooks one after another; return the mean processor seconds.

    This is a lower bound, because the time of processes killed with a sandbox is not counted.
    """
    submissions = find_submissions(course)
    for submission in submissions[: len(all_lessons())]:  # fill caches of scenes and right answers
        judge(course, submission, sandbox)
    start = sum(os.times()[:4])
    for submission in submissions:
        judge(course, submission, sandbox)
    return (sum(os.times()[:4]) - start) / len(submissions)


def judge(course, submission, sandbox):
    lesson, student = submission.lesson.name, submission.student
    judge_one(submission.read(course), lesson, student, SEED, sandbox.name)


def core_seconds(course, sandbox):
    """Return the billed core seconds per notebook: cores times seconds until the last verdict."""
    with LocalCluster(
        n_workers=1, threads_per_worker=processor_count(), dashboard_address=None
    ) as cluster:
        start = time.perf_counter()
        with connect(cluster.scheduler_address, sandbox.name, print) as executor:
            judged = judge_class(
                course,
                (),
                SEED,
                sandbox,
                lambda workers: contextlib.nullcontext(executor),
                1,
                lambda *news: None,
            )
        return (time.perf_counter() - start) * processor_count() / len(judged)


def main():
    """Measure the costs and print them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--price", type=float, default=PRICE, help="price of a core per hour")
    parser.add_argument("--students", type=int, default=5, help="size of the sample class")
    options = parser.parse_args()
    sandbox = choose_sandbox()
    with tempfile.TemporaryDirectory() as folder:
        course = make_class(Path(folder).resolve(), options.students)
        seconds, paid = cpu_seconds(course, sandbox), core_seconds(course, sandbox)
    print(f"Per notebook: at least {seconds:.2f} CPU seconds; {paid:.2f} core seconds to pay")
    print(f"At a price of {options.price} per core and hour:")
    print("submissions   core hours        money   hours on 100 cores")
    for count in CLASSES:
        hours = count * paid / 3600
        print(f"{count:11,} {hours:12,.1f} {hours * options.price:12,.2f} {hours / 100:20,.2f}")


if __name__ == "__main__":
    main()
