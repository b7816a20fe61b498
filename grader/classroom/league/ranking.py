"""What counts in a league, and who is where.

Standing still is worth nothing, and so is driving blind: a street counts only for who comes through
it without a collision, and only beyond the metres in which a car stops that brakes at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from grader.classroom.league.drives import Driven
from grader.classroom.league.season import Entrant, Season
from utils.drive.rules import stopping_distance
from utils.drive.streets import Street

NEEDLESS = 10.0
"""Metres that a needless braking costs, beside those that it takes."""


@dataclass(frozen=True)
class Standing:
    """How somebody stands.

    Attributes
    ----------
    entrant : Entrant
    place : int or None
        Shared by all who have the same points; None for those to compare with.
    points : int
        Whole metres that count.
    drives : tuple of (Street, Driven, int)
        In each street that counts, with the metres that count there.
    """

    entrant: Entrant
    place: int | None
    points: int
    drives: tuple[tuple[Street, Driven, int], ...]

    @property
    def metres(self) -> float:
        """Driven in all."""
        return sum(driven.metres for _, driven, _ in self.drives)

    @property
    def needless(self) -> int:
        """Brakings for nothing."""
        return sum(sum(driven.needless) for _, driven, _ in self.drives)

    @property
    def collisions(self) -> int:
        """Streets in which something was hit."""
        return sum(bool(driven.collision) for _, driven, _ in self.drives)

    @property
    def near_misses(self) -> int:
        """How often somebody was passed too near and too fast."""
        return sum(driven.near_misses for _, driven, _ in self.drives)

    @property
    def stopped(self) -> int:
        """Streets that were not driven to their end, for the detector's sake."""
        return sum(bool(driven.stopped) for _, driven, _ in self.drives)


def counted(street: Street, driven: Driven) -> int:
    """Metres of a drive that count."""
    if driven.collision or driven.stopped or driven.fault:
        return 0
    free = stopping_distance(street.limit)
    return max(round(driven.metres - free - NEEDLESS * sum(driven.needless)), 0)


def standings(season: Season) -> list[Standing]:
    """Everybody, the best first."""
    found = [_standing(season, one, known) for one, known in season.drives.items()]
    ours = sorted(one.points for one in found if one.entrant.student)
    placed = [
        Standing(
            one.entrant,
            1 + sum(points > one.points for points in ours) if one.entrant.student else None,
            one.points,
            one.drives,
        )
        for one in found
    ]
    return sorted(placed, key=lambda one: -one.points)


def _standing(season: Season, one: Entrant, known: Mapping[int, Driven]) -> Standing:
    drives = tuple(
        (street, known[street.number], counted(street, known[street.number]))
        for street in season.streets
    )
    return Standing(one, None, sum(points for *_, points in drives), drives)
