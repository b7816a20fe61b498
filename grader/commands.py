"""Commands of the command line; each takes the parsed options and returns the exit status.

Commands import most modules only when they run, so that ``--help`` is quick.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
import textwrap
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from grader import console
from grader.course.lessons import stages
from grader.course.paths import PROJECT, Course
from grader.errors import FAULT, SUCCESS, USAGE_ERROR, UserError
from grader.sandbox import AUTO, SANDBOXES, Sandbox, SandboxUnavailable, choose_sandbox

if TYPE_CHECKING:
    from pathlib import Path

    from grader.course.lessons import Lesson
    from grader.course.roster import Person

SAMPLE_SEED, SAMPLE_QUESTIONS = 20_170_405, 3  # for the sample class of `demo`


def run_new(options: argparse.Namespace) -> int:
    """Run the command ``new NN_NAME``."""
    from grader.authoring.skeleton import write_skeleton

    for path in write_skeleton(options.name, options.stage):
        print("wrote", path.relative_to(PROJECT))
    number = options.name[:2]
    print(f"Edit these files. To list what is missing, run: python -m grader try {number}")
    return SUCCESS


def run_try(options: argparse.Namespace) -> int:
    """Run the command ``try NN``."""
    from grader.authoring.trial import try_lesson
    from grader.course.lessons import every_lesson

    requested_number = options.number
    lesson = next(
        (each for each in every_lesson() if requested_number in (each.number, each.name)), None
    )
    if lesson is None:
        print(
            f"There is no lesson {requested_number}. To write it, run: "
            f"python -m grader new {requested_number[:2]}_NAME",
            file=sys.stderr,
        )
        return USAGE_ERROR
    _write_generated_files(options.parser)
    sandbox = choose_sandbox(options.sandbox)
    console.warn_if_unprotected(sandbox)
    findings = []
    for finding in try_lesson(lesson, sandbox):
        mark = "ok" if finding.is_good else "!!"
        print(f"  {mark}   {textwrap.indent(finding.sentence, ' ' * 7).lstrip()}", flush=True)
        findings.append(finding)
    unfinished = sum(not finding.is_good for finding in findings)
    print(
        f"{lesson.name}: {unfinished} still to fix."
        if unfinished
        else f"{lesson.name} is complete."
    )
    return FAULT if unfinished else SUCCESS


def run_build(options: argparse.Namespace) -> int:
    """Run the command ``build [--check]``."""
    from grader import documentation
    from grader.course import build

    if options.check:
        faults = [*build.check(), *documentation.check(options.parser)]
        print("\n".join(faults) if faults else "All generated files are up to date.")
        return FAULT if faults else SUCCESS
    _write_generated_files(options.parser)
    return SUCCESS


def _write_generated_files(parser: argparse.ArgumentParser) -> None:
    """Write the files that `build` generates, and print what changed."""
    from grader import documentation
    from grader.course import build

    changes = [*build.build(), *documentation.write(parser)]
    for action, path in changes:
        print(action, path.relative_to(PROJECT))
    if not changes:
        print("All generated files are up to date.")


def run_release(options: argparse.Namespace) -> int:
    """Run the command ``release [--standalone | --solutions] [STAGE ...]``."""
    from grader.course.deadlines import Deadlines
    from grader.course.deadlines_file import read_deadlines
    from grader.course.lessons import all_lessons
    from grader.course.release import write_zips
    from grader.course.standalone import ReleaseError, write_standalone

    require_stages(options.stages)
    try:
        if options.solutions:
            return _release_solutions(options)
        deadlines = read_deadlines(Course()) or Deadlines({})
        write = write_standalone if options.standalone else write_zips
        for path in write(options.to or PROJECT / "released", options.stages):
            print(f"wrote {path} ({path.stat().st_size / 1000:.0f} KB)")
    except ReleaseError as error:
        print(error, file=sys.stderr)
        return FAULT
    requested_stages = options.stages or stages()
    left_out = deadlines.unassigned_lessons(
        lesson for lesson in all_lessons() if lesson.stage in requested_stages
    )
    if left_out:
        names = ", ".join(lesson.name for lesson in left_out)
        print(
            f"These lessons were released, but do not count according to deadlines.toml: {names}."
        )
    return SUCCESS


def _release_solutions(options: argparse.Namespace) -> int:
    from grader.classroom.executors import processor_count
    from grader.course.deadlines import Deadlines
    from grader.course.deadlines_file import read_deadlines
    from grader.course.lessons import all_lessons
    from grader.course.solutions import reason_to_withhold, write_solutions
    from grader.lms.gradebook_dates import gradebook_extensions
    from grader.site.runs import solved_runs
    from grader.site.solution import as_notebook

    requested_stages, course = options.stages or stages(), Course()
    deadlines = read_deadlines(course) or Deadlines({})
    extensions = gradebook_extensions(course, requested_stages, deadlines)
    now = datetime.now(UTC)
    open_stages = [
        reason_to_withhold(deadlines, stage, now, extensions[stage]) for stage in requested_stages
    ]
    if any(open_stages):
        print(*filter(None, open_stages), sep="\n", file=sys.stderr)
        if not options.anyway:
            print(
                "Nothing was written. To write the solutions anyway, add --anyway.", file=sys.stderr
            )
            return FAULT
    lessons = [lesson for lesson in all_lessons() if lesson.stage in requested_stages]
    with console.progress_bar("Running the solutions") as advance:
        ran = solved_runs(lessons, processor_count(), advance)
    solutions = {lesson: as_notebook(notebook) for lesson, notebook in ran.items()}
    for path in write_solutions(options.to or PROJECT / "released", solutions):
        print(f"wrote {path} ({path.stat().st_size / 1000:.0f} KB)")
    return SUCCESS


def run_site(options: argparse.Namespace) -> int:
    """Run the command ``site [--to DIR] [--live] [--pdf]``."""
    from grader.course.build import read_origin
    from grader.course.lessons import all_lessons, optional_lessons
    from grader.course.standalone import ReleaseError
    from grader.site.builder import check_ready, write_site
    from grader.site.errors import SiteError
    from grader.site.live.files import FOLDER as LIVE_FOLDER
    from grader.site.live.files import pack
    from grader.site.pdf import FILE as PDF_FILE
    from grader.site.pdf import find_browser
    from grader.site.runs import CACHE, missing_packages, solved_runs

    folder = options.to or PROJECT / "site"
    missing = {lesson: missing_packages(lesson) for lesson in optional_lessons()}
    can_run = [lesson for lesson, packages in missing.items() if not packages]
    try:
        check_ready(folder)
        browser = find_browser() if options.pdf else ""
        live = pack(CACHE) if options.live else None
        with console.progress_bar("Running the lessons") as advance:
            ran = solved_runs([*all_lessons(), *can_run], options.workers, advance)
        write_site(folder, ran, read_origin(), live, browser)
    except (ReleaseError, SiteError) as error:
        print(error, file=sys.stderr)
        return FAULT
    for lesson, packages in missing.items():
        if packages:
            print(
                f"The page for {lesson.name} shows no outputs. To add outputs, install "
                f"{', '.join(packages)} and run the command again."
            )
    if live:
        for name, content in live.files.items():
            print(f"wrote {folder / LIVE_FOLDER / name} ({len(content) / 1e6:.1f} MB)")
    if browser:
        print(f"wrote {folder / PDF_FILE} ({(folder / PDF_FILE).stat().st_size / 1e6:.1f} MB)")
    print(f"wrote {folder / 'index.html'}")
    return SUCCESS


def run_collect(options: argparse.Namespace) -> int:
    """Run the command ``collect ARCHIVE... --stage STAGE``."""
    from grader.classroom.collect.collection import collect
    from grader.classroom.lock import course_lock

    require_stages(options.stages)
    course = Course()
    with course_lock(course), console.progress_bar("Collecting") as advance:
        collected = collect(
            course,
            options.archives,
            options.stages,
            options.timestamps,
            dict(options.who),
            dict(options.lesson),
            advance,
            options.folder_level,
        )
    console.print_collected(collected)
    is_open = bool(collected.questions or collected.doubts)
    if any(collected.states.values()):
        return FAULT if is_open else SUCCESS
    remedy = "Decide about the files above" if is_open else "Name another archive"
    print(
        f"No notebook was collected for {', '.join(options.stages)}. {remedy}, or correct --stage.",
        file=sys.stderr,
    )
    return FAULT if is_open else USAGE_ERROR


def require_stages(names: Sequence[str]) -> None:
    """Raise UserError if the course lacks one of these stages."""
    unknown = set(names) - set(stages())
    if unknown:
        raise UserError(
            f"There is no stage {', '.join(sorted(unknown))}. The stages are: "
            f"{', '.join(stages())}."
        )


def run_judge(options: argparse.Namespace) -> int:
    """Run the command ``judge NOTEBOOK``."""
    from grader.course.seed import course_seed
    from grader.judging.judge import judge, lesson_of_file

    if options.notebook.is_dir():
        print(
            f"{options.notebook} is a folder. Name one notebook, or judge everything in submitted/ "
            "with: python -m grader grade",
            file=sys.stderr,
        )
        return USAGE_ERROR
    if not options.notebook.is_file():
        print(f"{options.notebook} does not exist. Correct the path.", file=sys.stderr)
        return USAGE_ERROR
    lesson = lesson_of_file(options.notebook)
    sandbox = choose_sandbox(options.sandbox)
    console.warn_if_unprotected(sandbox)
    verdict = judge(options.notebook, course_seed(Course(), options.seed), sandbox, lesson)
    if options.json:
        print(json.dumps(verdict.as_dict(), indent=1))
    else:
        console.print_verdict(verdict)
    return SUCCESS


def run_grade(options: argparse.Namespace) -> int:
    """Run the command ``grade [STAGE ...]``."""
    from grader.classroom.executors import processor_count
    from grader.classroom.folders import find_student
    from grader.course.deadlines_file import read_deadlines
    from grader.course.seed import course_seed
    from grader.grading import grade_course

    require_stages(options.stages)
    require_one_executor(options)
    course = Course()
    read_deadlines(course)  # report a faulty file now, not after hours of judging
    student = find_student(course, options.student) if options.student else None
    sandbox = (sandbox_of_workers if options.scheduler else choose_sandbox)(options.sandbox)
    console.warn_if_unprotected(sandbox)
    workers = options.workers or processor_count()
    seed = course_seed(course, options.seed)
    return grade_course(
        course,
        options.stages,
        seed,
        sandbox,
        workers,
        scheduler=options.scheduler,
        student=student,
        restore=options.restore_marks,
    )


def require_one_executor(options: argparse.Namespace) -> None:
    """Raise UserError if the options select two executors."""
    if options.workers and options.scheduler:
        raise UserError(
            "--workers is for this machine, and --scheduler is for a cluster. Use only one."
        )


def sandbox_of_workers(choice: str) -> Sandbox:
    """Return the requested sandbox unchecked, because each worker checks its own sandbox."""
    if choice == AUTO:
        return next(sandbox for sandbox in SANDBOXES.values() if not sandbox.warning)
    return SANDBOXES[choice]


def _sandbox_for_course_code() -> tuple[Sandbox, str]:
    """Return a sandbox for code that is part of the course, and why it does not protect anything.

    The reason is empty if the sandbox is safe. Otherwise, no safe sandbox works on this machine.
    """
    try:
        return choose_sandbox(), ""
    except SandboxUnavailable as error:
        return SANDBOXES["process"], error.reason


def run_report(options: argparse.Namespace) -> int:
    """Run the command ``report``."""
    from grader.classroom.submissions import unaccounted_files
    from grader.grading import read_verdicts
    from grader.lms.report import write_report
    from grader.lms.results_reader import class_results

    course = Course()
    judged = read_verdicts(course)
    if not judged:
        print("Nothing has been graded yet. Run: python -m grader grade", file=sys.stderr)
        return USAGE_ERROR
    unjudged_files, results, section = unaccounted_files(course), class_results(course), ""
    if options.section is not None:
        people, section = _section_and_name(course, options.section)
        results, unjudged_files = (
            results.of_people(people),
            _files_of(course, people, unjudged_files),
        )
        ids = {person.id for person in people}
        judged = [pair for pair in judged if pair[0].student in ids]
    path = write_report(course, judged, results, unjudged_files=unjudged_files, section=section)
    print(f"Report: {path}")
    return SUCCESS


def _section_and_name(course: Course, name: str) -> tuple[Sequence[Person], str]:
    """Return the students of a section, and its name as on the roster."""
    from grader.classroom.folders import find_section

    people = find_section(course, name)
    return people, people[0].section


def _files_of(
    course: Course, people: Sequence[Person], files: Sequence[tuple[Path, str]]
) -> list[tuple[Path, str]]:
    """Return the files in ``submitted/`` that are in the folders of the given students."""
    from grader.course.roster import read_roster

    roster = read_roster(course)
    return [(path, reason) for path, reason in files if roster.owner_of(path.parts[1]) in people]


def run_export(options: argparse.Namespace) -> int:
    """Run the command ``export``."""
    from grader.course.roster import section_slug
    from grader.lms.exporters import EXPORTERS, ExportOptions
    from grader.lms.exporters.destination import write_export
    from grader.lms.results_reader import class_results

    course, exporter = Course(), EXPORTERS[options.format]
    if bool(exporter.fills) != bool(options.into):
        print(
            f"--format {options.format} fills in {exporter.fills}. Name this file with --into."
            if exporter.fills
            else f"--format {options.format} does not fill in a file. Leave out --into.",
            file=sys.stderr,
        )
        return USAGE_ERROR
    results = class_results(course)
    if not any(result.score is not None for result in results.notebooks):
        print("The gradebook contains no marks. Run: python -m grader grade", file=sys.stderr)
        return USAGE_ERROR
    export_settings = (
        options.assignment,
        options.provisional,
        options.into,
        options.column,
        options.scale,
    )
    section, others = "", ()
    if options.section is not None:
        people, section = _section_and_name(course, options.section)
        others = tuple(person for person in results.people if person not in people)
        results = results.of_people(people)
    exported = exporter.write(ExportOptions(course, results, *export_settings, others))
    parts = ("scores", options.assignment, section_slug(section))
    name = ".".join(filter(None, parts)) + exporter.ending
    path, backup = write_export(exported.content, options.to, course.root / name, options.into)
    console.print_exported(exported, path, backup, exporter.next_step)
    return FAULT if exported.failures else SUCCESS


def run_autograder(options: argparse.Namespace) -> int:
    """Run the command ``autograder NAME``."""
    from grader.classroom.executors import EXECUTORS, processor_count
    from grader.classroom.rehearsals import RehearsalFailed, Rehearsals
    from grader.course.deadlines import Deadlines
    from grader.course.deadlines_file import read_deadlines
    from grader.course.seed import course_seed
    from grader.lms.autograder.judging import lessons_of
    from grader.lms.autograder.package import build_autograder_zip, write_secret

    course, lessons = Course(), lessons_of(options.assignment)
    if not lessons:
        print(
            f"There is no stage or lesson {options.assignment}. Name a notebook, such as "
            f"06_filter_ground, or one of the stages: {', '.join(stages())}.",
            file=sys.stderr,
        )
        return USAGE_ERROR
    sandbox, _ = _sandbox_for_course_code()
    seed, counter = course_seed(course), itertools.count()
    try:
        with (
            EXECUTORS["processes"](processor_count()) as executor,
            console.progress_bar("Judging the course's own solutions") as advance,
        ):

            def announce(lesson: Lesson) -> None:
                advance(next(counter), len(lessons), lesson.name)

            Rehearsals(course, lessons, seed, sandbox, announce).finish(executor)
    except RehearsalFailed as error:
        print(console.printable_lines(error), file=sys.stderr)
        return FAULT
    path = options.to or course.root / f"autograder.{options.assignment}.zip"
    write_secret(build_autograder_zip(options.assignment, seed), path)
    deadlines = read_deadlines(course) or Deadlines({})
    uncounted_items = [lesson.name for lesson in deadlines.unassigned_lessons(lessons)]
    uncounted_items += [name for lesson in lessons for name in deadlines.rules.excluded_in(lesson)]
    console.print_autograder(path, lessons, uncounted_items)
    return SUCCESS


def run_feedback(options: argparse.Namespace) -> int:
    """Run the command ``feedback [STAGE ...]``."""
    from grader.classroom.folders import find_student
    from grader.course.deadlines_file import read_deadlines
    from grader.lms.feedback_archives import PLATFORMS, write_feedback
    from grader.lms.instructor_notes import assignment_notes
    from grader.lms.results_reader import class_results

    require_stages(options.stages)
    course, people, section = Course(), (), ""
    students = [find_student(course, text) for text in options.student]
    if options.section is not None:
        people, section = _section_and_name(course, options.section)
    folder = options.to or course.root / "handed_back"
    with console.progress_bar("Writing feedback") as advance:
        feedback = [
            write_feedback(
                course,
                stage,
                students or [person.id for person in people],
                folder,
                options.platform,
                advance,
                section,
            )
            for stage in options.stages or stages()
        ]
    console.print_feedback(feedback)
    if any(item.pages for item in feedback):  # students see which lessons count
        results = class_results(course)
        results = results.of_people(people) if people else results
        notes = assignment_notes(results, read_deadlines(course), options.stages)
        console.print_notes([*notes])
    if not any(item.pages for item in feedback):
        print("There is no feedback to write yet. Run: python -m grader grade", file=sys.stderr)
        return USAGE_ERROR
    if any(item.archive for item in feedback):
        print(PLATFORMS[options.platform].next_step)
    without_feedback = set(students) - {path.stem for item in feedback for path in item.pages}
    if without_feedback:
        names = console.printable_text(", ".join(sorted(without_feedback)))
        print(f"There is no feedback for {names}.", file=sys.stderr)
    is_incomplete = without_feedback or any(item.skipped or item.lacks_zip for item in feedback)
    return FAULT if is_incomplete else SUCCESS


def run_similarity(options: argparse.Namespace) -> int:
    """Run the command ``similarity STAGE``."""
    from grader.classroom.similarity.page import write_similarity
    from grader.classroom.similarity.stage import compare_stage, earlier_course
    from grader.classroom.submissions import find_submissions

    require_stages([options.stage])
    course = Course()
    earlier = [earlier_course(folder) for folder in options.earlier]
    for source in earlier:
        if not find_submissions(source, [options.stage]):
            print(
                f"There are no submissions in {source.submitted}/<student>/{options.stage}/. "
                "Correct --earlier.",
                file=sys.stderr,
            )
            return USAGE_ERROR
    with console.progress_bar("Comparing") as advance:
        compared = compare_stage(course, options.stage, advance, earlier)
    if len(compared.students) < (1 if earlier else 2):
        print(
            f"Fewer than two students have submissions in "
            f"{course.submitted}/<student>/{options.stage}/. "
            f"Run: python -m grader collect ARCHIVE --stage {options.stage}",
            file=sys.stderr,
        )
        return USAGE_ERROR
    path = write_similarity(course, compared)
    console.print_similarity(compared)
    print(f"Similar pairs side by side: {path}")
    return SUCCESS


def run_viva(options: argparse.Namespace) -> int:
    """Run the command ``viva STAGE``."""
    from grader.classroom.executors import EXECUTORS
    from grader.classroom.folders import find_student
    from grader.course.lessons import all_lessons
    from grader.course.seed import course_seed
    from grader.questions.pages import write_pages
    from grader.questions.quizzes import write_quizzes
    from grader.questions.viva import make_sheets
    from utils.questions.cases import cases_of

    require_stages([options.stage])
    lessons = [lesson for lesson in all_lessons() if lesson.stage == options.stage]
    if not any(cases_of(exercise.name) for lesson in lessons for exercise in lesson.exercises):
        print(
            f"No lesson in {options.stage} has small cases to ask about. Write them in "
            "utils/questions/; see docs/authors.md.",
            file=sys.stderr,
        )
        return USAGE_ERROR
    course = Course()
    student = find_student(course, options.student) if options.student else ""
    sandbox = choose_sandbox(options.sandbox)
    console.warn_if_unprotected(sandbox)
    seed = course_seed(course, options.seed)
    with (
        EXECUTORS["processes"](options.workers) as executor,
        console.progress_bar("Asking") as advance,
    ):
        sheets = make_sheets(
            course, options.stage, seed, sandbox, options.questions, executor, student, advance
        )
    if not sheets:
        print(
            f"There are no submissions in {course.submitted}/{student or '<student>'}/"
            f"{options.stage}/. Run: python -m grader collect ARCHIVE --stage {options.stage}",
            file=sys.stderr,
        )
        return USAGE_ERROR
    sheets_path, key_path = write_pages(course, options.stage, sheets, student)
    quizzes = write_quizzes(course, options.stage, sheets)
    print(f"Sheets for students: {sheets_path}\nKey (do not show it to the class): {key_path}")
    print(f"Quizzes for Moodle and Canvas: {quizzes}")
    for sheet in sheets:
        if sheet.problem:
            console.print_notice(f"{sheet.name}: {sheet.problem}")
    return SUCCESS


def run_forget(options: argparse.Namespace) -> int:
    """Run the command ``forget STUDENT [--delete]``."""
    from grader.classroom.lock import course_lock
    from grader.lms.forget import find_traces, remaining_lines, student_to_forget

    course = Course()
    with course_lock(course):
        student = student_to_forget(course, options.student)
        traces = find_traces(course, student)
        for trace in traces:
            if options.delete:
                trace.delete()
            print(console.printable_text(f"{'deleted ' if options.delete else ''}{trace.sentence}"))
        remaining = list(remaining_lines(course, student))
    for sentence in remaining:
        notice = f"{sentence} Otherwise, the next run of grade adds the student again."
        print(console.printable_text(notice))
    if any(trace.is_class_page for trace in traces):
        print(
            "To write the pages and tables about the class again, run report, export, feedback, "
            "similarity, viva or league."
        )
    if traces and not options.delete:
        print("Nothing was deleted. To delete all of this, add --delete.", file=sys.stderr)
        return FAULT
    return FAULT if remaining else SUCCESS


def run_doctor(options: argparse.Namespace) -> int:
    """Run the command ``doctor``."""
    from grader.classroom.doctor import examine
    from grader.classroom.executors import EXECUTORS
    from grader.course.seed import course_seed
    from grader.lms.gradebook_check import check_gradebook

    course = Course()
    sandbox, _ = _sandbox_for_course_code()
    all_good = True
    with EXECUTORS["processes"](options.workers) as executor:
        seed = course_seed(course)
        grading_findings = examine(course, seed, sandbox, executor, console.progress_bar)
        for finding in itertools.chain(grading_findings, check_gradebook(course)):
            console.print_finding(finding)
            all_good &= finding.is_good
    return SUCCESS if all_good else FAULT


def run_demo(options: argparse.Namespace) -> int:
    """Run the command ``demo``."""
    from grader.classroom.demo import STAGE, make_class
    from grader.grading import grade_course

    require_stages(options.stages or ())
    sandbox, reason = _sandbox_for_course_code()
    warning = ""
    if reason:
        warning = (
            f"{reason.split(' Student code')[0]} The demo therefore runs the code of its sample "
            "students without a sandbox. Real grading refuses to do this."
        )
        print(warning, file=sys.stderr)
    requested_stages = (STAGE,) if options.stages is None else options.stages or stages()
    course = make_class(options.students, not sandbox.warning, requested_stages)
    status = grade_course(course, (), SAMPLE_SEED, sandbox, options.workers, warning)
    for stage in requested_stages:
        print(f"Feedback pages for {stage}: {_write_sample_feedback(course, stage)}")
        print(f"Similar answers in {stage}: {_write_sample_similarity(course, stage)}")
        sheets = _write_sample_questions(course, stage, sandbox, options.workers)
        print(f"Questions about students' code in {stage}: {sheets}")
    print(f"Marks for a spreadsheet: {_write_sample_marks(course)}")
    return status


def _write_sample_feedback(course: Course, stage: str) -> Path:
    """Write the feedback pages of the sample class, and return their folder."""
    from grader.lms.feedback_archives import write_feedback

    folder = course.root / "handed_back"
    with console.progress_bar("Writing feedback") as advance:
        write_feedback(course, stage, (), folder, None, advance)
    return folder / stage


def _write_sample_similarity(course: Course, stage: str) -> Path:
    """Write the page of similar answers in the sample class, and return its path."""
    from grader.classroom.similarity.page import write_similarity
    from grader.classroom.similarity.stage import compare_stage

    with console.progress_bar("Comparing") as advance:
        return write_similarity(course, compare_stage(course, stage, advance))


def _write_sample_questions(course: Course, stage: str, sandbox: Sandbox, workers: int) -> Path:
    """Write the questions for the sample class, and return the path of the sheets."""
    from grader.classroom.executors import EXECUTORS
    from grader.questions.pages import write_pages
    from grader.questions.viva import make_sheets

    with (
        EXECUTORS["processes"](workers) as executor,
        console.progress_bar("Asking") as advance,
    ):
        sheets = make_sheets(
            course, stage, SAMPLE_SEED, sandbox, SAMPLE_QUESTIONS, executor, advance=advance
        )
    sheets_path, _ = write_pages(course, stage, sheets)
    return sheets_path


def _write_sample_marks(course: Course) -> Path:
    """Write the marks of the sample class as a CSV file, and return its path."""
    from grader.course.atomic_files import write_atomically
    from grader.lms.exporters import EXPORTERS, ExportOptions
    from grader.lms.results_reader import class_results

    exported = EXPORTERS["csv"].write(ExportOptions(course, class_results(course)))
    path = course.root / "scores.csv"
    write_atomically(exported.content, path)
    return path
