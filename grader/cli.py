"""The command line, ``python -m grader``."""

import argparse
import contextlib
import json
import os
import sys
import time
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from grader.lessons import stages
from grader.paths import PROJECT, Course
from grader.sandbox import UNPROTECTED, SandboxUnavailable, choose_tier

GOOD, WRONG_CALL, FAULT = 0, 2, 1


def main(arguments=None):
    """Run one command.

    Parameters
    ----------
    arguments : list of str, optional
        By default those of the process.

    Returns
    -------
    int
        Exit status: 0 done, 1 done and found wanting, 2 the call itself was wrong.
    """
    options = parser().parse_args(arguments)
    try:
        return options.run(options)
    except SandboxUnavailable as error:
        print(error, file=sys.stderr)
        return WRONG_CALL
    except KeyboardInterrupt:
        print("\nStopped. What has been judged is kept: the same command goes on from here.",
              file=sys.stderr)
        return 130


def parser():
    """The command line's grammar."""
    top = argparse.ArgumentParser(prog="python -m grader", description="Build the course, judge "
                                  "notebooks, grade a class.")
    commands = top.add_subparsers(metavar="COMMAND", required=True)

    build = commands.add_parser("build", help="write every notebook from its source")
    build.add_argument("--check", action="store_true",
                       help="only compare: fail if a notebook is stale or gives a solution away")
    build.set_defaults(run=run_build)

    judge = commands.add_parser("judge", help="judge one notebook")
    judge.add_argument("notebook", type=Path, metavar="NOTEBOOK.ipynb")
    judge.add_argument("--json", action="store_true", help="print the verdict as one JSON object")
    add_judging_options(judge)
    judge.set_defaults(run=run_judge)

    grade = commands.add_parser("grade", help="grade the class in submitted/")
    grade.add_argument("stages", nargs="*", metavar="STAGE", help="such as stage3_obstacles")
    add_judging_options(grade)
    add_workers(grade)
    grade.set_defaults(run=run_grade)

    report = commands.add_parser("report", help="write the report on what has been graded")
    report.set_defaults(run=run_report)

    demo = commands.add_parser("demo", help="grade a pretend class, end to end, in demo/")
    demo.add_argument("--students", type=int, default=13, metavar="N",
                      help="how many students to pretend (default: %(default)s)")
    add_workers(demo)
    demo.set_defaults(run=run_demo)
    return top


def add_judging_options(command):
    """Options of every command that runs student code."""
    command.add_argument("--seed", type=int, metavar="N", help="seed of the hidden scenes; by "
                         "default the course's own secret, in .course_seed")
    command.add_argument("--sandbox", choices=("auto", "bubblewrap", "process"), default="auto",
                         help="where student code runs; `process` protects nothing and is for "
                         "code you trust (default: bubblewrap, or refuse)")


def add_workers(command):
    """How many notebooks to judge at a time."""
    command.add_argument("--workers", type=int, default=os.cpu_count() or 1, metavar="N",
                         help="notebooks judged at a time (default: one per core)")


def run_build(options):
    """``build [--check]``"""
    from grader import build

    if options.check:
        faults = build.check()
        print("\n".join(faults) if faults else "Every notebook is what its source says.")
        return FAULT if faults else GOOD
    done = build.build()
    for what, path in done:
        print(what, path.relative_to(PROJECT))
    if not done:
        print("Every notebook is what its source says.")
    return GOOD


def run_judge(options):
    """``judge NOTEBOOK``"""
    from grader.judge import UnknownLesson, judge
    from grader.seed import course_seed

    if not options.notebook.is_file():
        print(f"There is no file {options.notebook}.", file=sys.stderr)
        return WRONG_CALL
    tier = choose_tier(options.sandbox)
    warn_if_unprotected(tier)
    try:
        verdict = judge(options.notebook, course_seed(Course(), options.seed), tier)
    except UnknownLesson as error:
        print(error, file=sys.stderr)
        return WRONG_CALL
    if options.json:
        print(json.dumps(verdict.as_dict(), indent=1))
    else:
        print_verdict(verdict)
    return GOOD


def run_grade(options):
    """``grade [STAGE ...]``"""
    from grader.seed import course_seed

    unknown = set(options.stages) - set(stages())
    if unknown:
        print(f"There is no stage {', '.join(sorted(unknown))}. The stages are: "
              f"{', '.join(stages())}.", file=sys.stderr)
        return WRONG_CALL
    course = Course()
    tier = choose_tier(options.sandbox)
    warn_if_unprotected(tier)
    return grade_course(course, options.stages, course_seed(course, options.seed), tier,
                        options.workers)


def run_report(options):
    """``report``"""
    from grader.grade import find_submissions
    from grader.report import write_report
    from grader.verdict import read_verdict

    course = Course()
    verdicts = [(submission, read_verdict(submission.verdict_path(course)))
                for submission in find_submissions(course)]
    judged = [(submission, verdict) for submission, verdict in verdicts if verdict]
    if not judged:
        print("Nothing has been graded yet. Run: python -m grader grade", file=sys.stderr)
        return WRONG_CALL
    print(f"Report: {write_report(course, judged)}")
    return GOOD


def run_demo(options):
    """``demo``"""
    from grader.demo import make_class

    try:
        tier, warning = choose_tier(), ""
    except SandboxUnavailable as error:
        tier = "process"
        warning = (f"{error.args[0].split(' Student code')[0]} This demo runs its own pretend "
                   "students without a sandbox; real grading would have refused.")
        print(warning, file=sys.stderr)
    if options.students < 1:
        print("A class has at least one student.", file=sys.stderr)
        return WRONG_CALL
    course = make_class(options.students, hostile=tier == "bubblewrap")
    return grade_course(course, (), 20_170_405, tier, options.workers, warning)


def grade_course(course, wanted, seed, tier, workers, warning=""):
    """Judge, enter, report: what `grade` and `demo` do."""
    from grader.grade import judge_class
    from grader.gradebook import GradebookTrouble, enter
    from grader.report import write_report

    if tier == "process" and not warning:
        warning = UNPROTECTED
    begin = time.perf_counter()
    with progress_bar("Judging") as advance:
        judged = judge_class(course, wanted, seed, tier, workers, advance)
    seconds = time.perf_counter() - begin
    if not judged:
        print(f"Nothing to grade: no {course.submitted}/<student>/<stage>/<NN_name>.ipynb. "
              "Put submissions there, as nbgrader collect does.", file=sys.stderr)
        return WRONG_CALL
    status = GOOD
    with progress_bar("Entering into the gradebook") as advance:
        try:
            enter(course, judged, seed, tier, advance)
        except GradebookTrouble as error:
            print(error, file=sys.stderr)
            status = FAULT
    path = write_report(course, judged, seconds, warning)
    print_class(judged)
    print(f"Judged {len(judged)} notebooks in {seconds:.1f} s. "
          f"Gradebook: {course.root / 'gradebook.db'}")
    print(f"Report: {path}")
    return status


@contextlib.contextmanager
def progress_bar(title):
    """A progress bar on stderr; yields a function (done, total, what)."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(),
               TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True)) as progress:
        task = progress.add_task(title, total=None)
        yield lambda done, total, what: progress.update(task, completed=done, total=total)


def warn_if_unprotected(tier):
    """Say loudly what a missing sandbox means."""
    if tier == "process":
        Console(stderr=True).print(UNPROTECTED, style="bold red", highlight=False)


def print_verdict(verdict):
    """Print one verdict for a person."""
    console = Console(highlight=False)
    for sentence in verdict.problems:
        console.print(f"! {sentence}", markup=False)
    for exercise in verdict.exercises:
        console.print(f"\n{exercise.name}: {exercise.score:g} of {exercise.max_score:g} points",
                      style="bold", markup=False)
        for test in exercise.tests:
            mark = "passed" if test.passed else "FAILED"
            console.print(f"  {mark}  {test.title}", markup=False)
            for line in test.message.splitlines():
                console.print(f"          {line}", markup=False, style="dim")
    console.print(f"\n{verdict.lesson}: {verdict.score:g} of {verdict.max_score:g} points "
                  f"({verdict.seconds:.1f} s)", style="bold", markup=False)


def print_class(judged):
    """Print a table of scores, one line a student."""
    lessons = sorted({verdict.lesson for _, verdict in judged})
    students = {}
    for submission, verdict in judged:
        students.setdefault(submission.student, {})[verdict.lesson] = verdict
    table = Table(title="Scores by lesson", title_justify="left", box=SIMPLE_HEAD,
                  show_footer=True, padding=(0, 1, 0, 0), expand=True)
    table.add_column("Student", "out of", no_wrap=True, width=14)
    for lesson in lessons:
        most = max(verdict.max_score for _, verdict in judged if verdict.lesson == lesson)
        table.add_column(lesson[:2], f"{most:g}", justify="right", no_wrap=True, width=4)
    table.add_column("First thing that went wrong", no_wrap=True, ratio=1)
    for student, verdicts in students.items():
        table.add_row(escape(student), *(
            f"{verdicts[lesson].score:.3g}" if lesson in verdicts else "-" for lesson in lessons),
            _first_fault(verdicts.values()))
    Console(highlight=False, width=None if sys.stdout.isatty() else 120).print(table)


def _first_fault(verdicts):
    faults = [test.message.splitlines()[0] for verdict in verdicts
              for exercise in verdict.exercises for test in exercise.tests if not test.passed]
    problems = [sentence for verdict in verdicts if not any(
        exercise.tests for exercise in verdict.exercises) for sentence in verdict.problems]
    return escape(next(iter(problems + faults), ""))
