"""The report on a class: one HTML page that needs nothing beside it."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

import jinja2

from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import Course
from grader.judging.messages import without_numbers
from grader.judging.verdict import JUDGED, Verdict, write_atomically

if TYPE_CHECKING:
    from grader.classroom.submissions import Submission

BINS = 10


@dataclass(frozen=True)
class LessonSummary:
    """How a class did in one lesson."""

    name: str
    stage: str
    count: int
    mean: float
    median: float
    max_score: float
    histogram: tuple
    seconds: float


@dataclass(frozen=True)
class CheckSummary:
    """How many students met their first failure of an exercise in one check."""

    lesson: str
    exercise: str
    title: str
    visible: bool
    failed: int
    tried: int


def write_report(
    course: Course,
    judged: Sequence[tuple[Submission, Verdict]],
    seconds: float | None = None,
    warning: str = "",
    left: Sequence[tuple[Path, str]] = (),
) -> Path:
    """Write the report.

    Parameters
    ----------
    course : grader.course.paths.Course
    judged : list of (grader.classroom.grade.Submission, grader.judging.verdict.Verdict)
    seconds : float, optional
        Wall-clock time that grading took.
    warning : str, optional
        A sentence for the head of the page.
    left : list of (Path, str), optional
        Files that nobody judged, each with the reason.

    Returns
    -------
    pathlib.Path
        ``report/index.html`` in the course's folder.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    verdicts = [verdict for _, verdict in judged]
    lessons = [
        lesson
        for lesson in all_lessons()
        if any(verdict.lesson == lesson.name for verdict in verdicts)
    ]
    students = {}
    for submission, verdict in judged:
        # The name of a folder need not be text.
        name = submission.student.encode("utf-8", "replace").decode()
        students.setdefault(name, {})[verdict.lesson] = verdict
    most = {verdict.lesson: verdict.max_score for verdict in verdicts}
    counted = [verdict for verdict in verdicts if verdict.status == JUDGED]
    page = environment.get_template("report.html").render(
        made=datetime.now().strftime("%d %B %Y, %H:%M"),
        seconds=seconds,
        warning=warning,
        students=students,
        lessons=lessons,
        notebooks=len(verdicts),
        most=most,
        summaries=[
            summarise_lesson(lesson, counted)
            for lesson in lessons
            if any(verdict.lesson == lesson.name for verdict in counted)
        ],
        hardest=hardest_checks(counted),
        mistakes=common_messages(counted),
        left=left,
        slowest=sorted(judged, key=lambda pair: -pair[1].seconds)[:5],
    )
    path = course.report / "index.html"
    write_atomically(page, path)
    return path


def summarise_lesson(lesson: Lesson, verdicts: Sequence[Verdict]) -> LessonSummary:
    """`LessonSummary` of the verdicts on one lesson."""
    mine = [verdict for verdict in verdicts if verdict.lesson == lesson.name]
    scores = [verdict.score for verdict in mine]
    whole = mine[0].max_score
    histogram = [0] * BINS
    for score in scores:
        histogram[min(BINS - 1, int(BINS * score / whole))] += 1
    return LessonSummary(
        lesson.name,
        lesson.stage,
        len(mine),
        statistics.mean(scores),
        statistics.median(scores),
        whole,
        tuple(histogram),
        statistics.median(verdict.seconds for verdict in mine),
    )


def hardest_checks(verdicts: Sequence[Verdict], most: int = 10) -> list[CheckSummary]:
    """`CheckSummary` of the checks at which most students stopped, hardest first.

    Each student counts once for each exercise, with what failed first: what else failed may have
    the same cause. Who wrote nothing stopped at no check.
    """
    tried, stopped = Counter(), Counter()
    for verdict in verdicts:
        for exercise in verdict.exercises:
            tried[verdict.lesson, exercise.name] += 1
            first = next((test for test in exercise.tests if test.name == exercise.first), None)
            if first:
                stopped[verdict.lesson, exercise.name, first.title, first.visible] += 1
    found = [CheckSummary(*check, count, tried[check[:2]]) for check, count in stopped.items()]
    return sorted(found, key=lambda check: -check.failed / check.tried)[:most]


def common_messages(verdicts: Sequence[Verdict], most: int = 8) -> list[tuple[str, str, int]]:
    """(exercise, what is wrong, number of students), most frequent first."""
    students = {}
    for verdict in verdicts:
        for exercise in verdict.exercises:
            if exercise.cause:
                mistake = (exercise.name, without_numbers(exercise.cause.splitlines()[0]))
                students.setdefault(mistake, set()).add(verdict.student)
    found = [(*mistake, len(names)) for mistake, names in students.items()]
    return sorted(found, key=lambda mistake: -mistake[2])[:most]
