"""Write the report on a class: one self-contained HTML page, and a second page without names.

Marks come from the gradebook; failures come from the judge's verdicts.
"""

from __future__ import annotations

import base64
import hashlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from urllib.parse import quote

from markupsafe import Markup

from grader.classroom.collect.instructor_answers import teams_in
from grader.classroom.item_analysis import (
    MIN_STUDENTS,
    common_messages,
    count_not_started,
    exercises_out_of_time,
    hardest_checks,
    items_of,
)
from grader.classroom.pages import TEMPLATES, format_code, printable_name, render
from grader.classroom.submissions import Submission
from grader.course.atomic_files import write_atomically
from grader.course.deadlines_file import read_deadlines
from grader.course.extension import extension_constant
from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import Course
from grader.course.roster import Person, read_roster, section_slug
from grader.intake.submission import SubmittedFiles
from grader.judging.verdict import JUDGED, Verdict
from grader.lms.distribution import Distribution, distribution_of
from grader.lms.marks_table import format_duration, marks_table
from grader.lms.overview import overview_of
from grader.lms.results import ClassResults, rounded_points
from grader.lms.term import describe_term, term_result

NO_RESULTS = ClassResults((), (), ())
# With fewer submissions, results could be traced to individual students even without names.
MIN_SUBMISSIONS = 5

JudgedSubmissions = Sequence[tuple[Submission, Verdict]]


@dataclass(frozen=True)
class GradingRun:
    """Statistics of one run of the `grade` command.

    Attributes
    ----------
    judged_count, stored_count : int
        Number of notebooks judged in this run, and of notebooks judged in earlier runs.
    seconds : float
        Wall-clock time of judging.
    sandbox : str
        Program that built the sandbox; empty if each worker of a cluster chose one.
    """

    judged_count: int
    stored_count: int
    seconds: float
    sandbox: str = ""


def write_report(
    course: Course,
    judged: JudgedSubmissions,
    results: ClassResults = NO_RESULTS,
    run: GradingRun | None = None,
    warning: str = "",
    unjudged_files: Sequence[tuple[Path, str]] = (),
    section: str = "",
) -> Path:
    """Write the report, and ``anonymous.html`` without names next to it.

    The report on a section does not link to files about the whole class, and has no page without
    names.

    Parameters
    ----------
    course : grader.course.paths.Course
    judged : list of (grader.classroom.submissions.Submission, grader.judging.verdict.Verdict)
    results : grader.lms.results.ClassResults, optional
        Marks from the gradebook. Without them, the report shows the judge's scores.
    run : GradingRun, optional
        Statistics of the run that has just ended.
    warning : str, optional
        Sentence at the top of the page.
    unjudged_files : list of (Path, str), optional
        Files that were not judged, each with the reason.
    section : str, optional
        Name of the section to which `judged` and `results` are limited.

    Returns
    -------
    pathlib.Path
        ``report/index.html`` or ``report/section_NAME.html`` in the course's folder.
    """
    pairs = [(printable_name(submission.student), verdict) for submission, verdict in judged]
    counted = [verdict for _, verdict in pairs if verdict.status == JUDGED]
    lessons = _lessons(pairs, results)
    by_student: dict[str, dict[str, Verdict]] = {}
    for student, verdict in pairs:
        by_student.setdefault(student, {})[verdict.lesson] = verdict
    table = marks_table(lessons, results, by_student)
    deadlines = read_deadlines(course)
    script = (TEMPLATES / "report.js").read_text("utf-8")
    common = {
        "made": datetime.now().strftime("%d %B %Y, %H:%M"),
        "distributions": _distributions(lessons, results, counted),
        "hardest": hardest_checks(counted),
        "items": _items(lessons, counted),
        "enough": MIN_STUDENTS,
        "not_started": count_not_started(counted),
        "notebooks": len(pairs),
    }
    sections = {
        "undecided": [stage for stage in results.stages if stage.undecided],
        "same": _same_files(course, pairs),
        "stopped": [
            (student, v.lesson, names)
            for student, v in pairs
            if (names := exercises_out_of_time(v))
        ],
        "repaired": [(student, v.lesson, v.findings) for student, v in pairs if v.findings],
        "left": unjudged_files,
    }
    page = render(
        "report.html",
        **common,
        coded=format_code,
        points=rounded_points,
        duration=format_duration,
        zone=deadlines.zone if deadlines else None,
        script=Markup(script),
        script_hash=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
        run=run,
        warning=warning,
        table=table,
        namesakes=_namesakes(results),
        unlisted=results.unlisted,
        has_roster=read_roster(course) is not None,
        **sections,
        overview=overview_of(
            results, deadlines, table, {name: len(rows) for name, rows in sections.items()}
        ),
        mistakes=common_messages(counted),
        slowest=sorted(pairs, key=lambda pair: -pair[1].seconds)[:5],
        people=_people(by_student, results),
        without=results.rules.excluded_exercises,
        links=() if section else _links(course),
        section=section,
    )
    if section:
        path = course.report / f"section_{section_slug(section)}.html"
        write_atomically(page, path)
        return path
    path = course.report / "index.html"
    write_atomically(page, path)
    write_atomically(_render_anonymous(common, counted), course.report / "anonymous.html")
    return path


def _lessons(pairs: Sequence[tuple[str, Verdict]], results: ClassResults) -> list[Lesson]:
    names = set(results.lessons) or {verdict.lesson for _, verdict in pairs}
    return [lesson for lesson in all_lessons() if lesson.name in names]


def _distributions(
    lessons: Sequence[Lesson], results: ClassResults, counted: Sequence[Verdict]
) -> list[Distribution]:
    distributions = (distribution_of(lesson, results, counted) for lesson in lessons)
    return [distribution for distribution in distributions if distribution.count]


def _items(lessons: Sequence[Lesson], counted: Sequence[Verdict]) -> list[tuple[str, list]]:
    analyses = []
    for lesson in lessons:
        items = items_of([verdict for verdict in counted if verdict.lesson == lesson.name])
        if items:
            analyses.append((lesson.name, items))
    return analyses


def _same_files(
    course: Course, pairs: Sequence[tuple[str, Verdict]]
) -> list[tuple[str, list[str]]]:
    """Return (lesson, students with identical files), without unchanged notebooks and teams."""
    by_content: dict[tuple[str, str], list[str]] = {}
    for student, verdict in pairs:
        if verdict.fingerprint:
            by_content.setdefault((verdict.lesson, verdict.fingerprint), []).append(student)
    duplicates = {
        content: students for content, students in by_content.items() if len(students) > 1
    }
    teams = {
        lesson.name: teams_in(course, lesson.stage)
        for lesson in all_lessons()
        if lesson.name in {name for name, _ in duplicates}
    }
    as_released = {
        SubmittedFiles(lesson.released.name, lesson.released.read_bytes()).fingerprint()
        for lesson in all_lessons()
        if lesson.name in teams
    }
    return [
        (lesson, students)
        for (lesson, fingerprint), students in duplicates.items()
        if fingerprint not in as_released
        and not any(team.issuperset(students) for team in teams.get(lesson, ()))
    ]


def _people(
    by_student: dict[str, dict[str, Verdict]], results: ClassResults
) -> list[tuple[Person, list, str, dict[str, Verdict]]]:
    """Return each student, with stage results, a sentence about the total, and verdicts."""
    people_by_id = {person.id: person for person in results.people}
    ids = dict.fromkeys([*people_by_id, *by_student])
    stages: dict[str, list] = {}
    for stage in results.stages:
        stages.setdefault(stage.student, []).append(stage)
    people = []
    for id in ids:
        total = term_result(results.of_student(id), results.rules)
        sentence = describe_term(total, results.rules) if total.max_score else ""
        verdicts = by_student.get(id, {})
        people.append((people_by_id.get(id) or Person(id), stages.get(id, []), sentence, verdicts))
    return people


def _namesakes(results: ClassResults) -> set[str]:
    """Return the names that several students share."""
    counts = Counter(person.name for person in results.people)
    return {name for name, count in counts.items() if count > 1}


def _links(course: Course) -> list[tuple[str, str]]:
    """Return (address, link text) for each page or file that the report links to."""
    links = [("anonymous.html", "report without names")]
    for path in sorted(course.report.glob("similarity_*.html")):
        stage = path.stem.removeprefix("similarity_")
        links.append((quote(path.name), f"similar answers in {stage}"))
    for course_links in extension_constant("REPORT_LINKS"):
        links += course_links(course)
    for path in sorted(course.root.glob("scores*.csv")):
        links.append((f"../{quote(path.name)}", f"exported marks: {path.name}"))
    for path in sorted((course.root / "handed_back").glob("*/")):
        links.append((f"../handed_back/{quote(path.name)}/", f"feedback on {path.name}"))
    return links


def _render_anonymous(common: dict, counted: Sequence[Verdict]) -> str:
    """Render the page without names from numbers and check titles, without any student's text."""
    submission_counts = Counter(verdict.lesson for verdict in counted)
    small_lessons = sorted(
        lesson for lesson, count in submission_counts.items() if count < MIN_SUBMISSIONS
    )
    shown_verdicts = [verdict for verdict in counted if verdict.lesson not in small_lessons]
    content = {
        **common,
        "distributions": [
            distribution
            for distribution in common["distributions"]
            if distribution.count >= MIN_SUBMISSIONS and distribution.name not in small_lessons
        ],
        "hardest": [check for check in common["hardest"] if check.lesson not in small_lessons],
        "items": [
            (lesson, items) for lesson, items in common["items"] if lesson not in small_lessons
        ],
        "not_started": count_not_started(shown_verdicts),
    }
    stopped = sum(bool(exercises_out_of_time(verdict)) for verdict in shown_verdicts)
    return render(
        "anonymous.html", **content, few=small_lessons, fewest=MIN_SUBMISSIONS, stopped=stopped
    )
