"""Why the car braked, and why it ran into something, in words.

A braking has a reason if the planner would have braked for what is really there, seen with some
tolerance, a second before or after. Else it was needless, and what lies in the box that the
planner braked for says what was mistaken for what.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from utils.boxes import distance_outside
from utils.drive.ground_truth import ENOUGH, true_things
from utils.drive.loop import Drive
from utils.drive.planner import Thing, needed_room, reach, room
from utils.drive.rules import OVER
from utils.drive.weather import KINDS

WORDS = {
    "car": "a car",
    "truck": "a lorry",
    "pedestrian": "a person",
    "cyclist": "a cyclist",
    "pole": "a pole",
    "wall": "a wall",
    "foliage": "a tree or hedge",
}
MISTAKEN = {
    "ground": "road taken for an obstacle",
    "ego": "our own car taken for an obstacle",
    "invalid": "lost returns taken for an obstacle",
    "raindrop": "rain taken for an obstacle",
}

TOGETHER = 5
"""Moments that may lie between two brakings that are one."""

AROUND = 10
"""Moments before and after, in which a reason would do."""

WIDER, FARTHER = 0.3, 1.3
"""The tolerance: metres more to either side, and times as far ahead."""

LOOKING_BACK = 30
"""Scans that are looked at to explain a collision."""


@dataclass(frozen=True)
class Braking:
    """One braking.

    Attributes
    ----------
    first, last : int
        Numbers of its moments.
    scan : int
        Number of the scan whose box had the car brake.
    gap : float
        Metres from the bumper to where that box was, or would be.
    needless : bool
    reason : str
        Such as "road taken for an obstacle".
    """

    first: int
    last: int
    scan: int
    gap: float
    needless: bool
    reason: str

    def __str__(self) -> str:
        return f"{self.reason}, {max(self.gap, 0):.0f} m ahead, frame {self.scan}"


def brakings(drive: Drive) -> Iterator[Braking]:
    """All brakings of a drive, in order."""
    for first, last in _spans(drive):
        told = _telling(drive, first, last)
        moment = drive.moments[told]
        cause = moment.decision.cause
        needed = _needed(drive, first)
        reason = _meant(drive, told, cause, needed)
        if not reason:
            reason = _mistaken(drive, told, cause)
            if needed:  # by chance, and nobody is accused
                other = WORDS[drive.street.kind_of(min(needed))]
                reason += f", and {other} is in the way, too"
        yield Braking(first, last, moment.seen or 0, moment.decision.gap, not needed, reason)


def _spans(drive: Drive) -> list[tuple[int, int]]:
    """First and last moment of each braking."""
    spans: list[tuple[int, int]] = []
    for moment in drive.moments:
        if not moment.brakes or moment.speed < 1.0:
            continue
        if spans and moment.number - spans[-1][1] <= TOGETHER:
            spans[-1] = spans[-1][0], moment.number
        else:
            spans.append((moment.number, moment.number))
    return spans


def _telling(drive: Drive, first: int, last: int) -> int:
    """The moment of a braking whose cause is told: what is over our car will not let it go on."""
    for moment in drive.moments[first : last + 1]:
        cause = moment.decision.cause
        if cause and reach(cause, moment.speed) > OVER:
            return moment.number
    return first


def _needed(drive: Drive, first: int) -> set[int]:
    """Identities of all that would have the planner brake, about then."""
    numbers = range(max(first - AROUND, 0), min(first + AROUND + 1, len(drive.moments)))
    return {
        obstacle.identity
        for number in numbers
        for obstacle, thing in true_things(drive.world(number))
        if room(thing, drive.moments[number].speed, WIDER)
        <= FARTHER * needed_room(thing, drive.moments[number].speed)
    }


def contents(drive: Drive, number: int, cause: Thing) -> tuple[np.ndarray, np.ndarray]:
    """Classes and identities of the returns in the box for which the car braked.

    Parameters
    ----------
    drive : Drive
    number : int
        Of the moment.
    cause : Thing
        As the planner knew it then.
    """
    moment = drive.moments[number]
    scan = drive.frame(moment.seen or 0).scan
    corners = cause.corners + (moment.position - drive.moments[moment.seen or 0].position, 0, 0)
    floor, xyz = corners[np.argsort(corners[:, 2], kind="stable")[:4], :2], scan.cloud[:, :3]
    middle = floor.mean(axis=0)
    around = np.argsort(np.arctan2(*(floor - middle).T[::-1]))
    low, high = corners[:, 2].min(), corners[:, 2].max()
    held = (distance_outside(xyz[:, :2], floor[around]) <= 0.1) & (xyz[:, 2] >= low - 0.1)
    held &= xyz[:, 2] <= high + 0.1
    return scan.classes[held], scan.objects[held]


def _mistaken(drive: Drive, number: int, cause: Thing) -> str:
    """What a needless braking was for."""
    classes, objects = contents(drive, number, cause)
    if not len(classes):
        return "a box with nothing in it"
    counts = np.bincount(classes, minlength=len(KINDS))
    kind = KINDS[int(counts.argmax())]
    if kind in MISTAKEN:
        return MISTAKEN[kind]
    identities, returns = np.unique(objects[objects > 0], return_counts=True)
    order = np.argsort(-returns)
    things = [int(identities[row]) for row in order if returns[row] >= max(3, 0.05 * len(objects))]
    first = WORDS[drive.street.kind_of(things[0])] if things else WORDS[kind]
    if not np.isfinite(room(Thing(cause.corners), drive.moments[number].speed)):
        return f"{first} beside our lane, taken to move into it"
    if len(things) > 1:
        second = WORDS[drive.street.kind_of(things[1])]
        other = f"another {second.partition(' ')[2]}" if second == first else second
        return f"{first} and {other} in one box"
    return f"box of {first} beside our lane reaches into it"


def _meant(drive: Drive, number: int, cause: Thing, needed: set[int]) -> str:
    """What a braking with a reason was for; empty where that is not in the box."""
    _, objects = contents(drive, number, cause)
    identities, returns = np.unique(objects[objects > 0], return_counts=True)
    held = [int(identities[row]) for row in np.argsort(-returns) if identities[row] in needed]
    if not held:
        return ""
    thing = WORDS[drive.street.kind_of(held[0])]
    comes = not np.isfinite(room(Thing(cause.corners), drive.moments[number].speed))
    return f"{thing} about to come into our lane" if comes else f"{thing} in our lane"


def collision(drive: Drive) -> str:
    """What the car ran into, how fast, and what the detector knew of it; empty if nothing."""
    if drive.hit is None:
        return ""
    end = drive.moments[-1]
    thing = WORDS[drive.street.kind_of(drive.hit)]
    return f"The drive ends at {thing}, at {3.6 * end.speed:.0f} km/h. {_why(drive)}"


def _why(drive: Drive) -> str:
    """A sentence on what the detector knew of what was hit."""
    looked = [m for m in drive.moments[-LOOKING_BACK:-1] if not m.busy]
    seen, boxed = [], []
    for moment in looked:
        scan = drive.frame(moment.number).scan
        points = scan.cloud[scan.objects == drive.hit, :3]
        if len(points) < ENOUGH:
            continue
        seen.append(moment.number)
        low, high = moment.boxes.min(axis=1), moment.boxes.max(axis=1)
        within = ((points[:, None] >= low) & (points[:, None] <= high)).all(axis=2)
        if len(moment.boxes) and within.any(axis=1).mean() >= 0.3:
            boxed.append(moment.number)
    if not seen:
        return "No scan had enough of it to see."
    if not boxed:
        return f"It was in {len(seen)} of the last scans, and had a box in none of them."
    end = drive.moments[-1]
    age = (end.number - (end.seen or 0)) / 10
    if age > 0.35:
        return f"It had a box, but what the car knew was {age:.1f} s old."
    share = f"It was in {len(seen)} of the last scans, and had a box in {len(boxed)} of them"
    return f"{share}, the first {(end.number - boxed[0]) / 10:.1f} s before."
