"""Parser of the command line ``python -m grader``; `grader.commands` runs the commands."""

import argparse
import errno
import sys
import textwrap
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from grader import commands, console
from grader.authoring.skeleton import DEFAULT_STAGE
from grader.classroom.executors import processor_count
from grader.course.extension import extension_constant
from grader.course.settings import course_title, version
from grader.errors import UserError
from grader.lms.exporters import EXPORTERS
from grader.sandbox import AUTO, SANDBOXES

PROGRAM = "python -m grader"
LINE_WIDTH = 78  # characters per line of a description
TERM_EXAMPLES = (
    "release stage1_ransac",
    "collect submissions.zip --stage stage1_ransac",
    "grade stage1_ransac",
    "feedback stage1_ransac",
    "export --format canvas --assignment stage1_ransac --into gradebook.csv",
)
DISK_FULL = (errno.ENOSPC, errno.EDQUOT)
ACCESS_DENIED = (errno.EACCES, errno.EPERM, errno.EROFS, errno.EEXIST, errno.ENOTDIR)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : list of str, optional
        By default, ``sys.argv[1:]``.

    Returns
    -------
    int
        Exit status: 0 for success, 1 if the command found a fault, 2 for a usage error, 130 after
        Ctrl+C.
    """
    options = build_parser().parse_args(arguments)
    try:
        return options.run(options)
    except UserError as error:
        shown = console.printable_lines if error.is_multiline else console.printable_text
        print(shown(error), file=sys.stderr)
        return error.exit_status
    except KeyboardInterrupt:
        print(
            "\nStopped. Verdicts are kept. Run the same command again to continue.",
            file=sys.stderr,
        )
        return 130
    except OSError as error:
        if error.errno not in (*DISK_FULL, *ACCESS_DENIED):
            raise
        where = error.filename or error
        print(
            f"The disk is full ({where}). Verdicts are kept. Free some space and run the same "
            "command again."
            if error.errno in DISK_FULL
            else f"{where}: {error.strerror}. Change its permissions, or name another file or "
            "folder, and run the same command again.",
            file=sys.stderr,
        )
        return commands.FAULT


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog=PROGRAM,
        description="Build the course, release it to students and grade a class.",
        epilog=f"grade a stage in five commands:\n{_format_calls(TERM_EXAMPLES)}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"{course_title()} {version()}")
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True)
    for add in (*COMMANDS, *extension_constant("COMMANDS")):
        add(subparsers)
    parser.set_defaults(parser=parser)
    return parser


def add_command(
    subparsers: argparse._SubParsersAction,
    name: str,
    run: Callable[[argparse.Namespace], int],
    description: str,
    *examples: str,
) -> argparse.ArgumentParser:
    """Add a command to the command line and return its parser.

    Parameters
    ----------
    subparsers : argparse._SubParsersAction
    name : str
    run : callable
        Takes the parsed options and returns the exit status.
    description : str
        What the command does. The list of all commands shows its first sentence.
    *examples : str
        Arguments of the sample calls in the help text.
    """
    first, _, _ = description.partition(". ")
    command = subparsers.add_parser(
        name,
        help=f"{first[0].lower()}{first[1:]}".rstrip("."),
        description=textwrap.fill(description, LINE_WIDTH),
        epilog=f"examples:\n{_format_calls(f'{name} {example}'.strip() for example in examples)}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.set_defaults(run=run)
    return command


def _format_calls(calls: Iterable[str]) -> str:
    return "\n".join(f"  {PROGRAM} {call}" for call in calls)


# ---- before and during a term --------------------------------------------------------------------


def _add_doctor(subparsers: argparse._SubParsersAction) -> None:
    doctor = add_command(
        subparsers,
        "doctor",
        commands.run_doctor,
        "Check that everything is ready for grading. Examine package versions, the sandbox, the "
        "seed, disk space, the roster, due dates and the gradebook, and judge the course's own "
        "solutions. Exit with status 1 if anything needs fixing.",
        "",
    )
    add_workers_option(doctor, "solutions judged")


def _add_demo(subparsers: argparse._SubParsersAction) -> None:
    demo = add_command(
        subparsers,
        "demo",
        commands.run_demo,
        "Grade a sample class in demo/. Print the paths of the report, the feedback pages, the "
        "similarity pages, the question sheets and the marks.",
        "",
        "--students 30 --stages stage1_ransac",
    )
    demo.add_argument(
        "--students",
        type=positive_number,
        default=13,
        metavar="N",
        help="number of sample students (default: %(default)s)",
    )
    demo.add_argument(
        "--stages",
        nargs="*",
        metavar="STAGE",
        help="stages that the sample students submit; --stages without a name selects all stages "
        "(default: stage3_obstacles)",
    )
    add_workers_option(demo)


def _add_release(subparsers: argparse._SubParsersAction) -> None:
    release = add_command(
        subparsers,
        "release",
        commands.run_release,
        "Write one zip per stage for the students. The notebooks run wherever students unzip them. "
        "Several stages can be unzipped into the same folder.",
        "stage1_ransac",
        "--standalone stage1_ransac",
        "--solutions stage1_ransac",
    )
    add_stages_argument(release)
    kind = release.add_mutually_exclusive_group()
    kind.add_argument(
        "--standalone",
        action="store_true",
        help="write one self-contained notebook per lesson instead of zips, for example for Colab",
    )
    kind.add_argument(
        "--solutions",
        action="store_true",
        help="write zips with the executed solutions, as notebooks and pages; refused while a "
        "student may still submit",
    )
    release.add_argument(
        "--anyway", action="store_true", help="write solutions even if students may still submit"
    )
    _add_folder_option(release, "released")


def _add_collect(subparsers: argparse._SubParsersAction) -> None:
    collect = add_command(
        subparsers,
        "collect",
        commands.run_collect,
        "Put the submissions of a class into submitted/. Accept downloads from Canvas, Moodle, "
        "Blackboard, Brightspace, Gradescope, ILIAS, PrairieLearn, Sakai and GitHub Classroom, "
        "folders and single files. If it is unclear which student or lesson a file belongs to, "
        "list options that settle the question, and exit with status 1. To continue, run the "
        "command again with one of these options.",
        "submissions.zip --stage stage3_obstacles",
        "submissions.zip --stage stage3_obstacles --who 'mueller_4711=bjorn'",
    )
    collect.add_argument(
        "archives",
        nargs="+",
        type=Path,
        metavar="ARCHIVE",
        help="zip from a learning platform, folder of GitHub Classroom repositories, any other "
        "folder, or single file",
    )
    collect.add_argument(
        "--stage",
        action="append",
        required=True,
        dest="stages",
        metavar="STAGE",
        help="stage that was submitted, such as stage3_obstacles; may be repeated",
    )
    collect.add_argument(
        "--timestamps",
        type=Path,
        metavar="FILE.csv",
        help="table of submission times, such as Moodle's grading worksheet",
    )
    collect.add_argument(
        "--who",
        action="append",
        default=[],
        type=_parse_answer,
        metavar="NAME=ID[,ID...]",
        help="id of the student who is called NAME in the archive, or several ids for a team; - "
        "ignores the student or file called NAME; may be repeated",
    )
    collect.add_argument(
        "--lesson",
        action="append",
        default=[],
        type=_parse_answer,
        metavar="FILE=NN",
        help="number of the lesson that FILE belongs to, if its name and content do not settle it; "
        "may be repeated",
    )
    collect.add_argument(
        "--folder-level",
        type=positive_number,
        default=0,
        metavar="N",
        help="level of the folders that are named after students, in archives of an unknown "
        "format; 1 is the outermost level, and folders named after stages or lessons do not count "
        "(default: detected automatically)",
    )


def _parse_answer(text: str) -> tuple[str, str]:
    """Split NAME=ID at the last equals sign, because the name may contain one."""
    name, divider, answer = text.rpartition("=")
    if not (name and divider and answer):
        raise argparse.ArgumentTypeError(f"{text!r} must have the form NAME=ANSWER")
    return name, answer


def _add_judge(subparsers: argparse._SubParsersAction) -> None:
    judge = add_command(
        subparsers,
        "judge",
        commands.run_judge,
        "Judge one notebook and print its verdict. Leave the gradebook unchanged.",
        "path/to/06_filter_ground.ipynb",
        "path/to/06_filter_ground.ipynb --json",
    )
    judge.add_argument(
        "notebook", type=Path, metavar="NOTEBOOK.ipynb", help="submitted notebook of a lesson"
    )
    judge.add_argument("--json", action="store_true", help="print the verdict as one JSON object")
    add_judging_options(judge)


def _add_grade(subparsers: argparse._SubParsersAction) -> None:
    grade = add_command(
        subparsers,
        "grade",
        commands.run_grade,
        "Grade the class in submitted/. Judge new and changed notebooks, enter the scores into the "
        "gradebook and write report/index.html. Exit with status 1 if any score could not be "
        "entered.",
        "stage3_obstacles",
        "stage3_obstacles --student anna",
        "--scheduler tcp://10.0.0.1:8786",
    )
    add_stages_argument(grade)
    grade.add_argument(
        "--student",
        metavar="X",
        help="judge only this student's work, even if it is unchanged, and print the history of "
        "the marks; X is an id, name, e-mail address or login (default: whole class)",
    )
    grade.add_argument(
        "--restore-marks",
        action="store_true",
        help="enter graders' marks and comments that are in marks.jsonl but missing from the "
        "gradebook, for example after the gradebook was lost",
    )
    add_judging_options(grade)
    add_executor_options(grade)
    grade.set_defaults(workers=None)


def _add_report(subparsers: argparse._SubParsersAction) -> None:
    report = add_command(
        subparsers,
        "report",
        commands.run_report,
        "Write the class report again without judging. Use this command after you change marks by "
        "hand. It writes report/index.html, and report/anonymous.html, which contains no names.",
        "",
        "--section A",
    )
    _add_section_option(report, "write report/section_NAME.html about the students in one section")


def _add_feedback(subparsers: argparse._SubParsersAction) -> None:
    feedback = add_command(
        subparsers,
        "feedback",
        commands.run_feedback,
        "Write a feedback page for each student and stage.",
        "stage3_obstacles",
        "stage3_obstacles --for moodle",
    )
    add_stages_argument(feedback)
    students = feedback.add_mutually_exclusive_group()
    students.add_argument(
        "--student",
        action="append",
        default=[],
        metavar="X",
        help="write pages only for this student; X is an id, name, e-mail address or login; may be "
        "repeated (default: whole class)",
    )
    _add_section_option(students, "write pages only for the students in one section")
    feedback.add_argument(
        "--for",
        dest="platform",
        choices=("moodle", "canvas"),
        help="also write a zip to upload to Moodle or Canvas, which distributes the feedback",
    )
    _add_folder_option(feedback, "handed_back")


def _add_export(subparsers: argparse._SubParsersAction) -> None:
    export = add_command(
        subparsers,
        "export",
        commands.run_export,
        "Write the marks to a table or to a file for a learning platform. Late penalties are "
        "already subtracted from totals and in files for platforms, but not from the points for a "
        "lesson or an exercise in a table. Files for platforms contain only students with a mark "
        "and, for Canvas, excused students.",
        "",
        "--format exercises",
        "--format canvas --assignment stage3_obstacles --into gradebook.csv",
    )
    export.add_argument(
        "--format",
        choices=tuple(EXPORTERS),
        default=next(iter(EXPORTERS)),
        help="file format: %(choices)s (default: %(default)s)",
    )
    export.add_argument(
        "--assignment",
        metavar="NAME",
        help="stage or lesson to export marks for (default for csv and exercises: all; required "
        "for other formats)",
    )
    export.add_argument(
        "--into",
        type=Path,
        metavar="FILE",
        help="file from Canvas or Moodle to fill in; the file itself is not changed",
    )
    export.add_argument(
        "--column",
        metavar="TITLE",
        help="title of the column to fill in (default: the column whose title contains the name of "
        "the stage or lesson)",
    )
    export.add_argument(
        "--scale",
        action="store_true",
        help="scale the marks to the platform's maximum if it differs from the course's",
    )
    export.add_argument(
        "--provisional",
        action="store_true",
        help="also export work that is waiting for a grader, with its points so far",
    )
    _add_section_option(export, "export only the students in one section")
    export.add_argument(
        "--to",
        type=Path,
        metavar="FILE",
        help="file to write (default: scores.* in the course folder)",
    )


def _add_autograder(subparsers: argparse._SubParsersAction) -> None:
    autograder = add_command(
        subparsers,
        "autograder",
        commands.run_autograder,
        "Write an autograder zip that lets Gradescope judge an assignment itself. The zip "
        "contains the hidden tests and the secret seed.",
        "stage3_obstacles",
    )
    autograder.add_argument(
        "assignment", metavar="NAME", help="stage or lesson to judge, such as stage3_obstacles"
    )
    autograder.add_argument(
        "--to",
        type=Path,
        metavar="FILE.zip",
        help="file to write (default: autograder.NAME.zip in the course folder)",
    )


def _add_similarity(subparsers: argparse._SubParsersAction) -> None:
    similarity = add_command(
        subparsers,
        "similarity",
        commands.run_similarity,
        "Show which answers in a stage are similar. Write report/similarity_STAGE.html, which "
        "shows similar pairs side by side. The command does not run student code.",
        "stage3_obstacles",
        "stage3_obstacles --earlier ../course-2025",
    )
    similarity.add_argument(
        "stage", metavar="STAGE", help="stage to compare, such as stage3_obstacles"
    )
    similarity.add_argument(
        "--earlier",
        action="append",
        default=[],
        type=Path,
        metavar="DIR",
        help="folder of an earlier course, or its submitted/, to compare the class with; may be "
        "repeated",
    )


def _add_viva(subparsers: argparse._SubParsersAction) -> None:
    viva = add_command(
        subparsers,
        "viva",
        commands.run_viva,
        "Write questions about students' own code, for an oral exam. Choose an exercise with full "
        "points for each student, and find the right answers by running the student's code. Write "
        "viva/STAGE/sheets.html with one sheet per student, key.html for the examiner, and quizzes "
        "for Moodle and Canvas. The questions never affect marks.",
        "stage2_clustering",
        "stage2_clustering --student anna --questions 5",
    )
    viva.add_argument(
        "stage", metavar="STAGE", help="graded stage to ask about, such as stage2_clustering"
    )
    viva.add_argument(
        "--student",
        metavar="X",
        help="write only this student's questions, with the pages in viva/STAGE/ID/; X is an id, "
        "name, e-mail address or login (default: whole class)",
    )
    viva.add_argument(
        "--questions",
        type=positive_number,
        default=3,
        metavar="N",
        help="number of questions per student (default: %(default)s)",
    )
    viva.add_argument(
        "--seed",
        type=int,
        metavar="N",
        help="seed that selects exercises and questions (default: the course's secret seed, in "
        ".course_seed)",
    )
    add_sandbox_option(viva)
    add_workers_option(viva, "students whose code runs")


def _add_forget(subparsers: argparse._SubParsersAction) -> None:
    forget = add_command(
        subparsers,
        "forget",
        commands.run_forget,
        "Delete all data about a student from the course folder, except lines in roster.csv and "
        "deadlines.toml. Without --delete, only list the data. Exit with status 1 if data about "
        "the student remains.",
        "anna",
        "anna --delete",
    )
    forget.add_argument(
        "student", metavar="STUDENT", help="id, name, e-mail address or login of the student"
    )
    forget.add_argument(
        "--delete", action="store_true", help="delete the data; it cannot be restored"
    )


def _add_site(subparsers: argparse._SubParsersAction) -> None:
    site = add_command(
        subparsers,
        "site",
        commands.run_site,
        "Generate a website from the course. Run new and changed lessons to include their outputs. "
        "This needs the packages in requirements-site.txt, which `make site` installs.",
        "",
        "--to /var/www/course",
    )
    _add_folder_option(site, "site")
    site.add_argument(
        "--live",
        action="store_true",
        help="add Run and Check buttons under each exercise, with Python in the browser; needs npm",
    )
    site.add_argument(
        "--pdf",
        action="store_true",
        help="also print all lessons into one file, course.pdf, in the folder; needs Chromium",
    )
    add_workers_option(site, "lessons executed")


# ---- for authors ---------------------------------------------------------------------------------


def _add_new(subparsers: argparse._SubParsersAction) -> None:
    new = add_command(
        subparsers,
        "new",
        commands.run_new,
        "Write the skeleton of a new lesson: four files with a small, complete exercise for you to "
        "change.",
        "14_free_distance",
    )
    new.add_argument(
        "name",
        metavar="NN_NAME",
        help="number and name of the lesson, such as 14_free_distance; the exercise has the same "
        "name",
    )
    new.add_argument(
        "--stage",
        default=DEFAULT_STAGE,
        help="folder of the lesson in solutions/ (default: %(default)s)",
    )


def _add_try(subparsers: argparse._SubParsersAction) -> None:
    attempt = add_command(
        subparsers,
        "try",
        commands.run_try,
        "Build a lesson, run it, judge its answers and list what is missing. Also store the "
        "results of its functions for students who have not written them.",
        "14",
    )
    attempt.add_argument("number", metavar="NN", help="number or name of the lesson, such as 14")
    add_sandbox_option(attempt)


def _add_build(subparsers: argparse._SubParsersAction) -> None:
    build = add_command(
        subparsers,
        "build",
        commands.run_build,
        "Write the notebooks of all lessons, and the generated parts of the documentation, except "
        "docs/prices.md.",
        "",
        "--check",
    )
    build.add_argument(
        "--check",
        action="store_true",
        help="write nothing; fail if a file is out of date or reveals a solution",
    )


COMMANDS = (
    _add_doctor,
    _add_demo,
    _add_release,
    _add_collect,
    _add_judge,
    _add_grade,
    _add_report,
    _add_feedback,
    _add_export,
    _add_autograder,
    _add_similarity,
    _add_viva,
    _add_forget,
    _add_site,
    _add_new,
    _add_try,
    _add_build,
)
"""Functions that add one command each, in the order of ``--help``; a course may add more."""


# ---- shared options ------------------------------------------------------------------------------


def add_stages_argument(command: argparse.ArgumentParser) -> None:
    """Add the argument that names the stages to work on."""
    command.add_argument(
        "stages",
        nargs="*",
        metavar="STAGE",
        help="stages to work on, such as stage3_obstacles (default: all)",
    )


def _add_section_option(command: argparse._ActionsContainer, help: str) -> None:
    command.add_argument(
        "--section",
        metavar="NAME",
        help=f"{help}, as named in the column section of roster.csv (default: whole class)",
    )


def _add_folder_option(command: argparse.ArgumentParser, name: str) -> None:
    command.add_argument(
        "--to",
        type=Path,
        metavar="DIR",
        help=f"folder to write to (default: {name}/ in the course folder)",
    )


def add_judging_options(command: argparse.ArgumentParser, generated: str = "hidden tests") -> None:
    """Add the options of every command that runs student code on input from the secret seed."""
    command.add_argument(
        "--seed",
        type=int,
        metavar="N",
        help=f"seed of the {generated} (default: the course's secret seed, in .course_seed)",
    )
    add_sandbox_option(command)


def add_sandbox_option(command: argparse.ArgumentParser) -> None:
    """Add the option that selects a sandbox for student code."""
    command.add_argument(
        "--sandbox",
        choices=(AUTO, *SANDBOXES),
        default=AUTO,
        help="where student code runs; `process` does not protect this machine, so use it only for "
        "code that you trust (default: auto, which uses bubblewrap and stops if it does not work)",
    )


def positive_number(text: str) -> int:
    """Parse a number of at least 1."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1, not {text}.")
    return int(text)


def add_workers_option(
    command: argparse.ArgumentParser, description: str = "notebooks judged"
) -> None:
    """Add the option for the number of parallel processes."""
    command.add_argument(
        "--workers",
        type=positive_number,
        default=processor_count(),
        metavar="N",
        help=f"number of {description} at the same time (default: one per core)",
    )


def add_executor_options(
    command: argparse.ArgumentParser, description: str = "notebooks judged"
) -> None:
    """Add the options that select where to run code: on this machine or on a cluster."""
    add_workers_option(command, description)
    command.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="Dask scheduler of the cluster to use, such as tcp://10.0.0.1:8786",
    )
