"""Write a league's page for the class, and a separate list of real names for the instructor."""

from __future__ import annotations

import base64
import csv
import io
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from extension.league.drives import (
    DRIVE_SECONDS,
    LIMITS,
    MAX_BOXES,
    MAX_FAILURES,
    REPLY_SECONDS,
    DriveResult,
    repeat_drive,
)
from extension.league.pseudonyms import pseudonyms
from extension.league.ranking import NEEDLESS_COST, Standing, standings
from extension.league.season import Season
from extension.league.streets import SPEED
from grader.classroom.pages import render
from grader.course.atomic_files import write_atomically
from grader.course.paths import Course
from grader.course.tables import escape_cell
from utils.drive.film import make_film
from utils.drive.metrics import NEAR_MISS_GAP, NEAR_MISS_SPEED
from utils.drive.rules import stopping_distance
from utils.drive.streets import Street
from utils.films.writers import best_film_suffix

FILM_SIZE = (720, 404)
"""Size of the film in pixels; at this size, the page has a few megabytes."""


@dataclass(frozen=True)
class LeagueFilm:
    """The film on the page.

    Attributes
    ----------
    driver : str
        Pseudonym of the driver.
    street : utils.drive.streets.Street
        The street in the film.
    comparison : str
        A sentence about the other students' drives in that street; empty if there are none.
    description : str
        A text for readers who cannot see the film.
    data : str
        Content of the file, in Base64.
    is_video : bool
        Whether the file is a video; otherwise it is an image.
    """

    driver: str
    street: Street
    comparison: str
    description: str
    data: str
    is_video: bool


def page_path(course: Course, stage: str) -> Path:
    """Return the path of the league's page for a stage."""
    return course.root / "league" / f"{stage}.html"


def real_names_path(course: Course, stage: str) -> Path:
    """Return the path of the list of real names, next to the report."""
    return course.report / f"league_{stage}.csv"


def write_league(course: Course, season: Season, seed: int, warning: str = "") -> list[Path]:
    """Write the page and, separately, the list of real names; return both paths.

    Parameters
    ----------
    course : grader.course.paths.Course
    season : Season
    seed : int
        The course's secret; without it, the student behind a pseudonym cannot be found.
    warning : str, optional
        A sentence for the top of the page.
    """
    students, stage = [student.name for student in season.students], season.lesson.stage
    names = pseudonyms(students, seed)

    def display_name(standing: Standing) -> str:
        return (
            names[standing.entrant.name] if standing.entrant.is_student else standing.entrant.name
        )

    # Students with equal points are sorted by pseudonym, because the order of their real names
    # would make them easier to identify.
    ranked = sorted(
        standings(season),
        key=lambda standing: (
            -standing.points,
            standing.entrant.is_student,
            display_name(standing),
        ),
    )
    page = render(
        "league/league.html",
        season=season,
        ranked=ranked,
        display_name=display_name,
        problem_sentences=lambda result: list(problem_sentences(result)),
        students=len(students),
        film=_film_best_drive(season, ranked, display_name),
        made=datetime.now().strftime("%d %B %Y, %H:%M"),
        warning=warning,
        seconds=DRIVE_SECONDS,
        free=stopping_distance(SPEED),
        cost=NEEDLESS_COST,
        limits=LIMITS,
        most_boxes=MAX_BOXES,
        most_failures=MAX_FAILURES,
        reading_seconds=REPLY_SECONDS,
        close=NEAR_MISS_GAP,
        fast=NEAR_MISS_SPEED,
    )
    paths = [page_path(course, stage), real_names_path(course, stage)]
    write_atomically(page, paths[0])
    write_atomically(_real_names_csv(ranked, names), paths[1])
    return paths


def problem_sentences(result: DriveResult) -> Iterator[str]:
    """Yield a sentence about each problem in a drive, without text that the student chose."""
    if result.fault:
        yield "The drive failed, but the detector was not the cause."
    if result.stopped:
        yield result.stopped
    if result.collision:
        yield result.collision
    for description, needless in zip(result.brakings, result.needless, strict=True):
        if needless:
            yield f"The car braked needlessly: {description}."
    if result.near_misses:
        yield f"Near misses: {result.near_misses}."
    if result.failed and not result.stopped:
        plural = "s" * (result.failed != 1)
        yield (f"The detector returned no boxes for {result.failed} scan{plural}. {result.failure}")


def _film_best_drive(
    season: Season, standings_in_order: Sequence[Standing], display_name: object
) -> LeagueFilm | None:
    """Film the best student's drive in the street where the most other students earned nothing.

    Returns
    -------
    LeagueFilm or None
        None if no student has earned a point.
    """
    students = [standing for standing in standings_in_order if standing.entrant.is_student]
    if not students or not students[0].points:
        return None
    best, *other_students = students

    def count_failures(street: Street) -> int:
        return sum(
            not metres
            for standing in other_students
            for driven_in, _, metres in standing.drives
            if driven_in == street
        )

    street, result, _ = max(
        (drive for drive in best.drives if drive[2]), key=lambda drive: count_failures(drive[0])
    )
    comparison = (
        f"Other students who scored 0 m there: {count_failures(street)} of {len(other_students)}."
        if other_students
        else ""
    )
    drive, report = repeat_drive(result, street)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"best{best_film_suffix()}")
        description = make_film(drive, report, path, size=FILM_SIZE).description
        data = base64.b64encode(path.read_bytes()).decode()
    return LeagueFilm(
        display_name(best), street, comparison, description, data, path.suffix == ".mp4"
    )


def _real_names_csv(ranked: Sequence[Standing], names: dict[str, str]) -> str:
    """Return the list of real names as CSV text that is safe to open in a spreadsheet."""
    file = io.StringIO()
    table = csv.writer(file, lineterminator="\n")
    table.writerow(("Pseudonym", "Student", "Place", "Metres that count"))
    for standing in ranked:
        if standing.entrant.is_student:
            student = standing.entrant.name
            table.writerow((names[student], escape_cell(student), standing.place, standing.points))
    return file.getvalue()
