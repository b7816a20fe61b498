"""The grammar of the command line, ``python -m grader``; `commands` has the commands."""

import argparse
import errno
import sys
from collections.abc import Sequence
from pathlib import Path

from grader import commands
from grader.authoring.skeleton import OWN_STAGE
from grader.classroom.executors import processors
from grader.course.deadlines import DeadlinesError
from grader.course.extension import course_constant
from grader.course.paths import PROJECT
from grader.course.roster import RosterError
from grader.course.seed import ShortSeed
from grader.course.settings import course_title, version
from grader.lms.exporters import EXPORTERS
from grader.lms.results import GradebookUnavailable
from grader.sandbox import AUTO, SANDBOXES, SandboxUnavailable

DISK_FULL = (errno.ENOSPC, errno.EDQUOT)
ACCESS_DENIED = (errno.EACCES, errno.EPERM, errno.EROFS, errno.EEXIST, errno.ENOTDIR)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : list of str, optional
        By default the arguments of the process.

    Returns
    -------
    int
        Exit status: 0 for success, 1 if the command found a fault, 2 for a wrong call.
    """
    options = build_parser().parse_args(arguments)
    try:
        return options.run(options)
    except (
        SandboxUnavailable,
        ShortSeed,
        RosterError,
        DeadlinesError,
        GradebookUnavailable,
    ) as error:
        print(error, file=sys.stderr)
        return commands.USAGE_ERROR
    except KeyboardInterrupt:
        print(
            "\nStopped. What has been judged is kept: the same command goes on from here.",
            file=sys.stderr,
        )
        return 130
    except OSError as error:
        if error.errno not in (*DISK_FULL, *ACCESS_DENIED):
            raise
        where = error.filename or error
        print(
            f"The disk is full ({where}). What has been judged is kept: make room, and give the "
            "same command again."
            if error.errno in DISK_FULL
            else f"{where}: {error.strerror}. Make it yours to read and write, a folder where one "
            "is needed, and give the same command again.",
            file=sys.stderr,
        )
        return commands.FAULT


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m grader", description="Build the course, judge notebooks, grade a class."
    )
    parser.add_argument("--version", action="version", version=f"{course_title()} {version()}")
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True)
    for add in (*COMMANDS, *course_constant("COMMANDS")):
        add(subparsers)
    parser.set_defaults(parser=parser)
    return parser


def _add_new(subparsers: argparse._SubParsersAction) -> None:
    new = subparsers.add_parser(
        "new",
        help="write the skeleton of a lesson of your own, which builds and can be judged",
    )
    new.add_argument("name", metavar="NN_NAME", help="such as 14_free_distance")
    new.add_argument(
        "--stage",
        default=OWN_STAGE,
        help="folder of the lesson in solutions/ (default: %(default)s)",
    )
    new.set_defaults(run=commands.run_new)


def _add_try(subparsers: argparse._SubParsersAction) -> None:
    attempt = subparsers.add_parser(
        "try",
        help="build a lesson, run its notebooks, judge its kept answers, and list what is missing",
    )
    attempt.add_argument("number", metavar="NN", help="number or name of the lesson, such as 14")
    add_sandbox_option(attempt)
    attempt.set_defaults(run=commands.run_try)


def _add_build(subparsers: argparse._SubParsersAction) -> None:
    build = subparsers.add_parser("build", help="write every notebook from its source")
    build.add_argument(
        "--check",
        action="store_true",
        help="only compare: fail if a notebook is stale or gives a solution away",
    )
    build.set_defaults(run=commands.run_build)


def _add_release(subparsers: argparse._SubParsersAction) -> None:
    release = subparsers.add_parser(
        "release", help="write what students get: a zip for each stage that runs when unzipped"
    )
    release.add_argument("stages", nargs="*", metavar="STAGE", help="such as stage3_obstacles")
    kind = release.add_mutually_exclusive_group()
    kind.add_argument(
        "--standalone",
        action="store_true",
        help="notebooks instead that need no file beside them: the tools are in each",
    )
    kind.add_argument(
        "--solutions",
        action="store_true",
        help="the solutions instead, with outputs and as pages, once nobody may hand in any more",
    )
    release.add_argument(
        "--anyway", action="store_true", help="give out solutions while some may still hand in"
    )
    release.add_argument(
        "--to",
        type=Path,
        default=PROJECT / "released",
        metavar="DIR",
        help="where to write (default: released/ in the course's folder)",
    )
    release.set_defaults(run=commands.run_release)


def _add_site(subparsers: argparse._SubParsersAction) -> None:
    site = subparsers.add_parser(
        "site", help="write the course as pages, with search, for a web server"
    )
    site.add_argument(
        "--to",
        type=Path,
        default=PROJECT / "site",
        metavar="DIR",
        help="where to write (default: site/ in the course's folder)",
    )
    site.add_argument(
        "--live",
        action="store_true",
        help="with pages on which lessons run in the browser, which fetches a kernel from jsDelivr",
    )
    add_workers_option(site)
    site.set_defaults(run=commands.run_site)


def _add_collect(subparsers: argparse._SubParsersAction) -> None:
    collect = subparsers.add_parser("collect", help="put what a class handed in into submitted/")
    collect.add_argument(
        "archives",
        nargs="+",
        type=Path,
        metavar="ARCHIVE",
        help="a zip from Canvas or Moodle, a folder, checkouts of GitHub Classroom, one file",
    )
    collect.add_argument(
        "--stage",
        action="append",
        required=True,
        dest="stages",
        metavar="STAGE",
        help="what was handed in, such as stage3_obstacles; may be given more than once",
    )
    collect.add_argument(
        "--timestamps",
        type=Path,
        metavar="FILE.csv",
        help="when they handed in: Moodle's grading worksheet, or a table like it",
    )
    collect.add_argument(
        "--who",
        action="append",
        default=[],
        type=_parse_answer,
        metavar="NAME=ID[,ID...]",
        help="whose that is; more than one of a team",
    )
    collect.add_argument(
        "--lesson",
        action="append",
        default=[],
        type=_parse_answer,
        metavar="FILE=NN",
        help="which lesson a file is",
    )
    collect.set_defaults(run=commands.run_collect)


def _parse_answer(text: str) -> tuple[str, str]:
    """Return the two sides of NAME=ID; a name may contain the equals sign."""
    name, divider, answer = text.rpartition("=")
    if not (name and divider and answer):
        raise argparse.ArgumentTypeError(f"{text!r} is no answer: write what is asked, = and it")
    return name, answer


def _add_judge(subparsers: argparse._SubParsersAction) -> None:
    judge = subparsers.add_parser("judge", help="judge one notebook")
    judge.add_argument("notebook", type=Path, metavar="NOTEBOOK.ipynb")
    judge.add_argument("--json", action="store_true", help="print the verdict as one JSON object")
    add_judging_options(judge)
    judge.set_defaults(run=commands.run_judge)


def _add_grade(subparsers: argparse._SubParsersAction) -> None:
    grade = subparsers.add_parser("grade", help="grade the class in submitted/")
    grade.add_argument("stages", nargs="*", metavar="STAGE", help="such as stage3_obstacles")
    grade.add_argument(
        "--student",
        metavar="X",
        help="judge this one alone, and again whatever was judged before; says how the marks "
        "came to be what they are",
    )
    add_judging_options(grade)
    add_executor_options(grade)
    grade.set_defaults(run=commands.run_grade, workers=None)


def _add_report(subparsers: argparse._SubParsersAction) -> None:
    report = subparsers.add_parser("report", help="write the report on what has been graded")
    report.set_defaults(run=commands.run_report)


def _add_export(subparsers: argparse._SubParsersAction) -> None:
    export = subparsers.add_parser(
        "export", help="write the marks to a file, for a learning platform"
    )
    export.add_argument(
        "--format", choices=tuple(EXPORTERS), default=next(iter(EXPORTERS)), help="of the file"
    )
    export.add_argument(
        "--assignment", metavar="NAME", help="the stage or lesson whose marks they are"
    )
    export.add_argument(
        "--into",
        type=Path,
        metavar="FILE",
        help="fill in what Canvas or Moodle gave you; the file itself stays as it is",
    )
    export.add_argument(
        "--column", metavar="TITLE", help="of the marks in that file, where it cannot be guessed"
    )
    export.add_argument(
        "--scale",
        action="store_true",
        help="convert marks where the platform gives other points for the assignment",
    )
    export.add_argument(
        "--provisional",
        action="store_true",
        help="export also what waits for a person, with the points that it has so far",
    )
    export.add_argument("--to", type=Path, metavar="FILE", help="where to write")
    export.set_defaults(run=commands.run_export)


def _add_autograder(subparsers: argparse._SubParsersAction) -> None:
    autograder = subparsers.add_parser(
        "autograder", help="write a zip with which Gradescope judges an assignment by itself"
    )
    autograder.add_argument("assignment", metavar="NAME", help="a stage or a lesson")
    autograder.add_argument(
        "--to",
        type=Path,
        metavar="FILE.zip",
        help="where to write (default: autograder.NAME.zip in the course's folder)",
    )
    autograder.set_defaults(run=commands.run_autograder)


def _add_feedback(subparsers: argparse._SubParsersAction) -> None:
    feedback = subparsers.add_parser("feedback", help="write a page for each student: what to mend")
    feedback.add_argument("stages", nargs="*", metavar="STAGE", help="such as stage3_obstacles")
    feedback.add_argument(
        "--student", action="append", default=[], metavar="X", help="only for them"
    )
    feedback.add_argument(
        "--for",
        dest="platform",
        choices=("moodle", "canvas"),
        help="also a zip of all, with which the learning platform gives each their own",
    )
    feedback.add_argument(
        "--to",
        type=Path,
        metavar="DIR",
        help="where to write (default: handed_back/ in the course's folder)",
    )
    feedback.set_defaults(run=commands.run_feedback)


def _add_similarity(subparsers: argparse._SubParsersAction) -> None:
    similarity = subparsers.add_parser("similarity", help="which answers of a stage are alike?")
    similarity.add_argument("stage", metavar="STAGE", help="such as stage3_obstacles")
    similarity.set_defaults(run=commands.run_similarity)


def _add_doctor(subparsers: argparse._SubParsersAction) -> None:
    doctor = subparsers.add_parser("doctor", help="is everything ready to grade?")
    add_workers_option(doctor)
    doctor.set_defaults(run=commands.run_doctor)


def _add_demo(subparsers: argparse._SubParsersAction) -> None:
    demo = subparsers.add_parser("demo", help="grade a pretend class, end to end, in demo/")
    demo.add_argument(
        "--students",
        type=int,
        default=13,
        metavar="N",
        help="how many students to pretend (default: %(default)s)",
    )
    demo.add_argument(
        "--stages",
        nargs="*",
        metavar="STAGE",
        help="what they hand in; without a name, all stages (default: stage 3)",
    )
    add_workers_option(demo)
    demo.set_defaults(run=commands.run_demo)


COMMANDS = (
    _add_new,
    _add_try,
    _add_build,
    _add_release,
    _add_site,
    _add_collect,
    _add_judge,
    _add_grade,
    _add_report,
    _add_export,
    _add_autograder,
    _add_feedback,
    _add_similarity,
    _add_doctor,
    _add_demo,
)
"""Each adds a command, in the order of ``--help``; a course may have more of its own."""


def add_judging_options(command: argparse.ArgumentParser) -> None:
    """Add the options of every command that runs student code."""
    command.add_argument(
        "--seed",
        type=int,
        metavar="N",
        help="seed of the hidden tests; by default the course's own secret, in .course_seed",
    )
    add_sandbox_option(command)


def add_sandbox_option(command: argparse.ArgumentParser) -> None:
    """Add the option that says where student code runs."""
    command.add_argument(
        "--sandbox",
        choices=(AUTO, *SANDBOXES),
        default=AUTO,
        help="where student code runs; `process` protects nothing and is for "
        "code you trust (default: bubblewrap, or refuse)",
    )


def _parse_workers(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError("at least one notebook is judged at a time")
    return number


def add_workers_option(command: argparse.ArgumentParser) -> None:
    """Add the option for the number of notebooks that are judged at a time."""
    command.add_argument(
        "--workers",
        type=_parse_workers,
        default=processors(),
        metavar="N",
        help="notebooks judged at a time (default: one per core)",
    )


def add_executor_options(command: argparse.ArgumentParser) -> None:
    """Add the options for the place to judge: this machine or a cluster."""
    add_workers_option(command)
    command.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="judge on the workers of a Dask cluster instead, such as tcp://10.0.0.1:8786",
    )
