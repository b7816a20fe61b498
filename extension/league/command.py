"""The command ``python -m grader league STAGE``."""

from __future__ import annotations

import argparse
import sys
from urllib.parse import quote

from grader import cli, commands, console
from grader.course.lessons import stages
from grader.course.paths import Course
from grader.errors import FAULT, SUCCESS, USAGE_ERROR
from grader.sandbox import choose_sandbox


def add_league(subparsers: argparse._SubParsersAction) -> None:
    """Add the command ``league`` to the command line."""
    league = cli.add_command(
        subparsers,
        "league",
        run_league,
        "Drive a simulated car with each student's detector, and rank the class. This game does "
        "not affect marks. Write league/STAGE.html with pseudonyms, and report/league_STAGE.csv, "
        "which links pseudonyms to students.",
        "stage4_realtime",
        "stage4_realtime --student anna --streets 2",
    )
    league.add_argument(
        "stage", metavar="STAGE", help="stage with a detector, such as stage4_realtime"
    )
    league.add_argument(
        "--student",
        action="append",
        default=[],
        metavar="X",
        help="run only this student's drives; other students take part if their drives are stored; "
        "X is an id, name, e-mail address or login; may be repeated (default: whole class)",
    )
    league.add_argument(
        "--streets",
        type=cli.positive_number,
        metavar="N",
        help="drive only through the first N streets (default: all)",
    )
    cli.add_judging_options(league, "streets")
    cli.add_executor_options(league, "drives run")
    league.set_defaults(workers=None)


def run_league(options: argparse.Namespace) -> int:
    """Run the command ``league STAGE``."""
    from extension.league.page import write_league
    from extension.league.season import drive_class, lesson_of_league
    from grader.classroom.executors import executor_factory, processor_count
    from grader.classroom.folders import find_student
    from grader.classroom.lock import course_lock
    from grader.classroom.protocol import ExecutorLost
    from grader.course.seed import course_seed

    commands.require_stages([options.stage])
    commands.require_one_executor(options)
    course, lesson = Course(), lesson_of_league(options.stage)
    if lesson is None:
        print(
            f"No exercise in {options.stage} is a detector. Choose a stage that has one: "
            f"{', '.join(filter(lesson_of_league, stages()))}.",
            file=sys.stderr,
        )
        return USAGE_ERROR
    students = [find_student(course, text) for text in options.student]
    choose = commands.sandbox_of_workers if options.scheduler else choose_sandbox
    sandbox = choose(options.sandbox)
    console.warn_if_unprotected(sandbox)
    seed, workers = course_seed(course, options.seed), options.workers or processor_count()
    try:
        with course_lock(course):
            with (
                executor_factory(
                    options.scheduler, sandbox.name, console.print_notice
                ) as open_executor,
                console.progress_bar("Driving") as advance,
            ):
                season = drive_class(
                    course,
                    lesson,
                    seed,
                    sandbox,
                    open_executor,
                    workers,
                    advance,
                    students,
                    options.streets,
                )
            if not season.students:
                print(
                    f"There is no {lesson.name}.ipynb in "
                    f"{course.submitted}/<student>/{options.stage}/. "
                    f"Run: python -m grader collect ARCHIVE --stage {options.stage}",
                    file=sys.stderr,
                )
                return USAGE_ERROR
            page, names_path = write_league(course, season, seed, sandbox.warning)
    except ExecutorLost as error:
        print(console.printable_lines(error), file=sys.stderr)
        return FAULT
    print(f"League: {page}\nReal names (do not show this file to the class): {names_path}")
    for fault in season.faults:
        console.print_notice(f"Not driven: {fault}")
    return FAULT if season.faults else SUCCESS


def league_links(course: Course) -> list[tuple[str, str]]:
    """Return links to the pages of each league, as (address, link text), for the report."""
    links = []
    for path in sorted(course.report.glob("league_*.csv")):
        stage = path.stem.removeprefix("league_")
        page = f"../league/{quote(stage)}.html"
        links.append((page, f"league for {stage}, to show to the class"))
        links.append((quote(path.name), f"real names in the league for {stage}"))
    return links
