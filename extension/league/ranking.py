"""Count the metres of a league, and rank its entrants.

A drive with a collision earns nothing. In other drives, a metre counts only if it is beyond the
stopping distance of a car that brakes at once. A car that stands still therefore earns nothing, and
neither does a car that drives blind.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from extension.league.drives import DriveResult
from extension.league.season import Entrant, Season
from utils.drive.rules import stopping_distance
from utils.drive.streets import Street

NEEDLESS_COST = 10.0
"""Metres deducted for needless braking, in addition to the metres that it costs."""


@dataclass(frozen=True)
class Standing:
    """An entrant's result in a season.

    Attributes
    ----------
    entrant : Entrant
    place : int or None
        Rank among the students, shared by equal points; None for the reference entrants.
    points : int
        Whole metres that count.
    drives : tuple of (Street, DriveResult, int)
        For each street that counts: the street, the drive, and the metres that count.
    """

    entrant: Entrant
    place: int | None
    points: int
    drives: tuple[tuple[Street, DriveResult, int], ...]

    @property
    def metres(self) -> float:
        """Total distance driven."""
        return sum(result.metres for _, result, _ in self.drives)

    @property
    def needless(self) -> int:
        """Number of needless braking events."""
        return sum(sum(result.needless) for _, result, _ in self.drives)

    @property
    def collisions(self) -> int:
        """Number of streets with a collision."""
        return sum(bool(result.collision) for _, result, _ in self.drives)

    @property
    def near_misses(self) -> int:
        """Number of times that a road user was passed too closely and too fast."""
        return sum(result.near_misses for _, result, _ in self.drives)

    @property
    def stopped(self) -> int:
        """Number of drives that ended early because the detector failed."""
        return sum(bool(result.stopped) for _, result, _ in self.drives)


def counted_metres(street: Street, result: DriveResult) -> int:
    """Return the metres of a drive that count as points."""
    if result.collision or result.stopped or result.fault:
        return 0
    free = stopping_distance(street.limit)
    return max(round(result.metres - free - NEEDLESS_COST * sum(result.needless)), 0)


def standings(season: Season) -> list[Standing]:
    """Return the results of all entrants, best first."""
    results = [_standing(season, entrant, drives) for entrant, drives in season.drives.items()]
    students_points = [standing.points for standing in results if standing.entrant.is_student]
    placed_standings = [
        replace(standing, place=1 + sum(points > standing.points for points in students_points))
        if standing.entrant.is_student
        else standing
        for standing in results
    ]
    return sorted(placed_standings, key=lambda standing: -standing.points)


def _standing(season: Season, entrant: Entrant, results: Mapping[int, DriveResult]) -> Standing:
    drives = tuple(
        (street, results[street.number], counted_metres(street, results[street.number]))
        for street in season.streets
    )
    return Standing(entrant, None, sum(points for *_, points in drives), drives)
