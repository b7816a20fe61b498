"""The report on a class: one HTML page that needs nothing beside it, and one without names.

The marks are the gradebook's; what went wrong is the judge's.
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

from grader.classroom.item_analysis import (
    ENOUGH,
    common_messages,
    hardest_checks,
    items_of,
    not_started,
    out_of_time,
)
from grader.classroom.pages import TEMPLATES, coded, printable, render
from grader.classroom.submissions import Submission
from grader.course.atomic_files import write_atomically
from grader.course.deadlines import read_deadlines
from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import Course
from grader.course.roster import Person, read_roster
from grader.intake.submission import HandedIn
from grader.judging.verdict import JUDGED, Verdict
from grader.lms.distribution import Distribution, distribution_of
from grader.lms.marks_table import duration, marks_table
from grader.lms.results import ClassResults, write_number

NOBODY = ClassResults((), (), ())
# A lesson that fewer have handed in says too much about each of them, even without names.
FEWEST = 5

Judged = Sequence[tuple[Submission, Verdict]]


@dataclass(frozen=True)
class GradingRun:
    """What a run of `grade` did.

    Attributes
    ----------
    judged, before : int
        Notebooks that it judged, and those that had been judged before.
    seconds : float
        What judging took, by the clock on the wall.
    sandbox : str
        The program that built the sandbox; empty if a cluster's workers each chose their own.
    """

    judged: int
    before: int
    seconds: float
    sandbox: str = ""


def write_report(
    course: Course,
    judged: Judged,
    results: ClassResults = NOBODY,
    run: GradingRun | None = None,
    warning: str = "",
    left: Sequence[tuple[Path, str]] = (),
) -> Path:
    """Write the report, and beside it ``anonymous.html``, which names nobody.

    Parameters
    ----------
    course : grader.course.paths.Course
    judged : list of (grader.classroom.submissions.Submission, grader.judging.verdict.Verdict)
    results : grader.lms.results.ClassResults, optional
        What the gradebook says. Without it, scores are the judge's.
    run : GradingRun, optional
        What was done just now.
    warning : str, optional
        A sentence for the head of the page.
    left : list of (Path, str), optional
        Files that nobody judged, each with the reason.

    Returns
    -------
    pathlib.Path
        ``report/index.html`` in the course's folder.
    """
    pairs = [(printable(submission.student), verdict) for submission, verdict in judged]
    counted = [verdict for _, verdict in pairs if verdict.status == JUDGED]
    lessons = _lessons(pairs, results)
    by_student: dict[str, dict[str, Verdict]] = {}
    for student, verdict in pairs:
        by_student.setdefault(student, {})[verdict.lesson] = verdict
    table = marks_table(lessons, results, by_student)
    deadlines = read_deadlines(course)
    script = (TEMPLATES / "report.js").read_text("utf-8")
    about = {
        "made": datetime.now().strftime("%d %B %Y, %H:%M"),
        "distributions": _distributions(lessons, results, counted),
        "hardest": hardest_checks(counted),
        "items": _items(lessons, counted),
        "enough": ENOUGH,
        "not_started": not_started(counted),
        "notebooks": len(pairs),
    }
    page = render(
        "report.html",
        **about,
        coded=coded,
        points=write_number,
        duration=duration,
        zone=deadlines.zone if deadlines else None,
        script=Markup(script),
        script_hash=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
        run=run,
        warning=warning,
        table=table,
        namesakes=_namesakes(results),
        strangers=results.strangers,
        has_roster=read_roster(course) is not None,
        undecided=[stage for stage in results.stages if stage.undecided],
        mistakes=common_messages(counted),
        stopped=[(student, v.lesson, names) for student, v in pairs if (names := out_of_time(v))],
        same=_same_files(pairs),
        mended=[(student, v) for student, v in pairs if v.problems],
        left=left,
        slowest=sorted(pairs, key=lambda pair: -pair[1].seconds)[:5],
        people=_people(by_student, results),
        links=_links(course),
    )
    path = course.report / "index.html"
    write_atomically(page, path)
    write_atomically(_anonymous(about, counted), course.report / "anonymous.html")
    return path


def _lessons(pairs: Sequence[tuple[str, Verdict]], results: ClassResults) -> list[Lesson]:
    names = {verdict.lesson for _, verdict in pairs} | set(results.lessons)
    return [lesson for lesson in all_lessons() if lesson.name in names]


def _distributions(
    lessons: Sequence[Lesson], results: ClassResults, counted: Sequence[Verdict]
) -> list[Distribution]:
    found = (distribution_of(lesson, results, counted) for lesson in lessons)
    return [one for one in found if one.count]


def _items(lessons: Sequence[Lesson], counted: Sequence[Verdict]) -> list[tuple[str, list]]:
    found = []
    for lesson in lessons:
        items = items_of([verdict for verdict in counted if verdict.lesson == lesson.name])
        if items:
            found.append((lesson.name, items))
    return found


def _same_files(pairs: Sequence[tuple[str, Verdict]]) -> list[tuple[str, list[str]]]:
    """(lesson, students who handed in the same bytes), but for those of the notebook given out."""
    found: dict[tuple[str, str], list[str]] = {}
    for student, verdict in pairs:
        if verdict.fingerprint:
            found.setdefault((verdict.lesson, verdict.fingerprint), []).append(student)
    twice = {place: students for place, students in found.items() if len(students) > 1}
    given = {
        HandedIn(lesson.released.name, lesson.released.read_bytes()).fingerprint()
        for lesson in all_lessons()
        if lesson.name in {name for name, _ in twice}
    }
    return [
        (lesson, students) for (lesson, print_), students in twice.items() if print_ not in given
    ]


def _people(
    by_student: dict[str, dict[str, Verdict]], results: ClassResults
) -> list[tuple[Person, list, dict[str, Verdict]]]:
    """Each with how they stand in the stages, and the verdicts on their notebooks."""
    known = {person.id: person for person in results.people}
    ids = dict.fromkeys([*known, *by_student])
    stages: dict[str, list] = {}
    for stage in results.stages:
        stages.setdefault(stage.student, []).append(stage)
    return [(known.get(id) or Person(id), stages.get(id, []), by_student.get(id, {})) for id in ids]


def _namesakes(results: ClassResults) -> set[str]:
    """Names that more than one student has."""
    counts = Counter(person.name for person in results.people)
    return {name for name, count in counts.items() if count > 1}


def _links(course: Course) -> list[tuple[str, str]]:
    """(address, words) of what lies beside the report."""
    found = [("anonymous.html", "this report without names")]
    for path in sorted(course.report.glob("similarity_*.html")):
        stage = path.stem.removeprefix("similarity_")
        found.append((quote(path.name), f"which answers of {stage} are alike"))
    for path in sorted(course.report.glob("league_*.csv")):
        stage = path.stem.removeprefix("league_")
        found.append(
            (f"../league/{quote(stage)}.html", f"the league of {stage}, for a class to see")
        )
        found.append((quote(path.name), f"who is who in the league of {stage}"))
    for path in sorted(course.root.glob("scores*.csv")):
        found.append((f"../{quote(path.name)}", f"exported marks: {path.name}"))
    for path in sorted((course.root / "handed_back").glob("*/")):
        found.append((f"../handed_back/{quote(path.name)}/", f"feedback on {path.name}"))
    return found


def _anonymous(about: dict, counted: Sequence[Verdict]) -> str:
    """The page without names: it gets numbers, and titles of ours; no word of a student."""
    handed_in = Counter(verdict.lesson for verdict in counted)
    few = sorted(lesson for lesson, count in handed_in.items() if count < FEWEST)
    shown = [verdict for verdict in counted if verdict.lesson not in few]
    kept = {
        **about,
        "distributions": [
            one for one in about["distributions"] if one.count >= FEWEST and one.name not in few
        ],
        "hardest": [one for one in about["hardest"] if one.lesson not in few],
        "items": [(lesson, items) for lesson, items in about["items"] if lesson not in few],
        "not_started": not_started(shown),
    }
    stopped = sum(bool(out_of_time(verdict)) for verdict in shown)
    return render("anonymous.html", **kept, few=few, fewest=FEWEST, stopped=stopped)
