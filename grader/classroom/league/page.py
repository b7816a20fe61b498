"""The page of a league, which a class may see; and who is who, for whoever teaches it, apart."""

from __future__ import annotations

import base64
import csv
import io
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from grader.classroom.league.drives import (
    LIMITS,
    MOST_BOXES,
    MOST_FAILURES,
    SECONDS,
    Driven,
    driven_again,
)
from grader.classroom.league.pseudonyms import pseudonyms
from grader.classroom.league.ranking import NEEDLESS, Standing, standings
from grader.classroom.league.season import Season
from grader.classroom.league.streets import SPEED
from grader.classroom.pages import render
from grader.course.atomic_files import write_atomically
from grader.course.paths import Course
from grader.course.tables import harmless_cell
from utils.drive.film import film
from utils.drive.metrics import CLOSE, FAST
from utils.drive.rules import stopping_distance
from utils.drive.streets import Street
from utils.films.writers import suffix_of_films

SIZE = (720, 404)
"""Of the film in pixels: a page with it has some megabytes."""


@dataclass(frozen=True)
class LeagueFilm:
    """A film for the page: of whom and where, how others did there, in words, and as data."""

    who: str
    street: Street
    others: str
    words: str
    data: str
    is_video: bool


def page_of_league(course: Course, stage: str) -> Path:
    """Where the page on a stage lies."""
    return course.root / "league" / f"{stage}.html"


def who_is_who(course: Course, stage: str) -> Path:
    """Where it is written down who is who, beside the report."""
    return course.report / f"league_{stage}.csv"


def write_league(course: Course, season: Season, seed: int, warning: str = "") -> list[Path]:
    """Write the page and, apart from it, who is who; returns where they lie.

    Parameters
    ----------
    course : grader.course.paths.Course
    season : Season
    seed : int
        The course's secret, without which nobody finds out who a pseudonym is.
    warning : str, optional
        A sentence for the head of the page.
    """
    students, stage = [student.name for student in season.students], season.lesson.stage
    names = pseudonyms(students, seed)

    def called(one: Standing) -> str:
        return names[one.entrant.name] if one.entrant.student else one.entrant.name

    # Among those who share a place, the order of their true names would tell something.
    ranked = sorted(
        standings(season), key=lambda one: (-one.points, one.entrant.student, called(one))
    )
    page = render(
        "league.html",
        season=season,
        ranked=ranked,
        called=called,
        happened=lambda driven: list(happened(driven)),
        students=len(students),
        film=_film(season, ranked, called),
        made=datetime.now().strftime("%d %B %Y, %H:%M"),
        warning=warning,
        seconds=SECONDS,
        free=stopping_distance(SPEED),
        cost=NEEDLESS,
        limits=LIMITS,
        most_boxes=MOST_BOXES,
        most_failures=MOST_FAILURES,
        close=CLOSE,
        fast=FAST,
    )
    paths = [page_of_league(course, stage), who_is_who(course, stage)]
    write_atomically(page, paths[0])
    write_atomically(_table(ranked, names), paths[1])
    return paths


def happened(driven: Driven) -> Iterator[str]:
    """What stopped a car, or slowed it down for nothing, in words of ours."""
    if driven.fault:
        yield "It could not be driven here, which is not the detector's fault."
    if driven.stopped:
        yield driven.stopped
    if driven.collision:
        yield driven.collision
    for words, needless in zip(driven.brakings, driven.needless, strict=True):
        if needless:
            yield f"It braked for nothing: {words}."
    if driven.near_misses:
        yield f"Near misses: {driven.near_misses}."
    if driven.failed and not driven.stopped:
        yield f"It had no boxes to give for {driven.failed} of the scans. {driven.failure}"


def _film(season: Season, ranked: Sequence[Standing], called: object) -> LeagueFilm | None:
    """The best of the class, in the street in which most others got no metre."""
    class_ = [one for one in ranked if one.entrant.student]
    if not class_ or not class_[0].points:
        return None
    best, *others = class_

    def failed(street: Street) -> int:
        return sum(
            not metres for one in others for other, _, metres in one.drives if other == street
        )

    street, driven, _ = max(
        (drive for drive in best.drives if drive[2]), key=lambda drive: failed(drive[0])
    )
    said = f"{failed(street)} of the {len(others)} others got no metre there." if others else ""
    drive, report = driven_again(driven, street)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"best{suffix_of_films()}")
        words = film(drive, report, path, size=SIZE).seen
        data = base64.b64encode(path.read_bytes()).decode()
    return LeagueFilm(called(best), street, said, words, data, path.suffix == ".mp4")


def _table(ranked: Sequence[Standing], names: dict[str, str]) -> str:
    """Who is who, as a table for spreadsheets."""
    file = io.StringIO()
    table = csv.writer(file, lineterminator="\n")
    table.writerow(("Pseudonym", "Student", "Place", "Metres that count"))
    for one in ranked:
        if one.entrant.student:
            student = one.entrant.name
            table.writerow((names[student], harmless_cell(student), one.place, one.points))
    return file.getvalue()
