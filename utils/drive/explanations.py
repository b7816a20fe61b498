"""Explanations in words: why the car braked, and why it hit something.

Braking is justified if the planner would have braked for a real object, with some tolerance, within
a second of the start. Otherwise it was needless, and the returns in the box that made the planner
brake show the mistake.
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
    "ground": "road mistaken for an obstacle",
    "ego": "the ego car mistaken for an obstacle",
    "invalid": "lost returns mistaken for an obstacle",
    "raindrop": "rain mistaken for an obstacle",
}

TOGETHER = 5
"""Longest pause, in moments, between two phases of braking that count as one event."""

AROUND = 10
"""Moments before and after the start of braking in which a real object justifies it."""

WIDER, FARTHER = 0.3, 1.3
"""Tolerance: metres added to the corridor on either side, and a factor for the distance."""

LOOKING_BACK = 30
"""Number of scans that are examined to explain a collision."""


@dataclass(frozen=True)
class Braking:
    """One braking event of the car.

    Attributes
    ----------
    first, last : int
        Indices of its first and last moment.
    scan : int
        Index of the scan whose box made the car brake.
    gap : float
        Distance in metres from the bumper to the current or predicted place of that box.
    needless : bool
        Whether no real object justifies the braking.
    reason : str
        Reason for braking, such as "road mistaken for an obstacle".
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
    """Yield all braking events of a drive, in order."""
    for first, last in _spans(drive):
        number = _decisive(drive, first, last)
        moment = drive.moments[number]
        cause = moment.decision.cause
        needed = _justifying(drive, first)
        reason = _real_cause(drive, number, cause, needed)
        if not reason:
            reason = _apparent_cause(drive, number, cause)
            if needed:  # justified by an object outside the box
                other = WORDS[drive.street.kind_of(min(needed))]
                reason += f", and {other} is also in the way"
        yield Braking(first, last, moment.seen or 0, moment.decision.gap, not needed, reason)


def _spans(drive: Drive) -> list[tuple[int, int]]:
    """Return the first and last moment of each braking event."""
    spans: list[tuple[int, int]] = []
    for moment in drive.moments:
        if not moment.brakes or moment.speed < 1.0:
            continue
        if spans and moment.number - spans[-1][1] <= TOGETHER:
            spans[-1] = spans[-1][0], moment.number
        else:
            spans.append((moment.number, moment.number))
    return spans


def _decisive(drive: Drive, first: int, last: int) -> int:
    """Return the index of the moment whose cause explains a braking event.

    A thing that overlaps the ego car has priority, because it keeps the car from driving on.
    Without such a thing, the first moment explains the event.
    """
    for moment in drive.moments[first : last + 1]:
        cause = moment.decision.cause
        if cause and reach(cause, moment.speed) > OVER:
            return moment.number
    return first


def _justifying(drive: Drive, first: int) -> set[int]:
    """Return the identities of all real objects that justify braking from moment `first`."""
    numbers = range(max(first - AROUND, 0), min(first + AROUND + 1, len(drive.moments)))
    return {
        obstacle.identity
        for number in numbers
        for obstacle, thing in true_things(drive.world(number))
        if room(thing, drive.moments[number].speed, WIDER)
        <= FARTHER * needed_room(thing, drive.moments[number].speed)
    }


def contents(drive: Drive, number: int, cause: Thing) -> tuple[np.ndarray, np.ndarray]:
    """Return the classes and object identities of the returns in the box that made the car brake.

    Parameters
    ----------
    drive : Drive
    number : int
        Index of the moment.
    cause : Thing
        The thing that made the car brake, as the planner knew it at that moment.
    """
    moment = drive.moments[number]
    scan = drive.frame(moment.seen or 0).scan
    corners = cause.corners + (moment.position - drive.moments[moment.seen or 0].position, 0, 0)
    floor, xyz = corners[np.argsort(corners[:, 2], kind="stable")[:4], :2], scan.cloud[:, :3]
    middle = floor.mean(axis=0)
    around = np.argsort(np.arctan2(*(floor - middle).T[::-1]))
    low, high = corners[:, 2].min(), corners[:, 2].max()
    inside = (distance_outside(xyz[:, :2], floor[around]) <= 0.1) & (xyz[:, 2] >= low - 0.1)
    inside &= xyz[:, 2] <= high + 0.1
    return scan.classes[inside], scan.objects[inside]


def _apparent_cause(drive: Drive, number: int, cause: Thing) -> str:
    """Describe the box that caused braking, if no object in it justifies the braking."""
    classes, objects = contents(drive, number, cause)
    if not len(classes):
        return "a box without returns"
    counts = np.bincount(classes, minlength=len(KINDS))
    kind = KINDS[int(counts.argmax())]
    if kind in MISTAKEN:
        return MISTAKEN[kind]
    identities, returns = np.unique(objects[objects > 0], return_counts=True)
    order = np.argsort(-returns)
    things = [int(identities[row]) for row in order if returns[row] >= max(3, 0.05 * len(objects))]
    first = WORDS[drive.street.kind_of(things[0])] if things else WORDS[kind]
    if not np.isfinite(room(Thing(cause.corners), drive.moments[number].speed)):
        return f"{first} next to our lane, assumed to move into it"
    if len(things) > 1:
        second = WORDS[drive.street.kind_of(things[1])]
        other = f"another {second.partition(' ')[2]}" if second == first else second
        return f"{first} and {other} in one box"
    return f"{first} next to our lane, whose box reaches into it"


def _real_cause(drive: Drive, number: int, cause: Thing, needed: set[int]) -> str:
    """Describe the object in the box that justifies the braking; empty if there is none."""
    _, objects = contents(drive, number, cause)
    identities, returns = np.unique(objects[objects > 0], return_counts=True)
    real = [int(identities[row]) for row in np.argsort(-returns) if identities[row] in needed]
    if not real:
        return ""
    thing = WORDS[drive.street.kind_of(real[0])]
    comes = not np.isfinite(room(Thing(cause.corners), drive.moments[number].speed))
    return f"{thing} about to enter our lane" if comes else f"{thing} in our lane"


def collision(drive: Drive) -> str:
    """Describe a collision, its speed and how the object was detected; empty without one."""
    if drive.hit is None:
        return ""
    end = drive.moments[-1]
    thing = WORDS[drive.street.kind_of(drive.hit)]
    return f"The car hits {thing} at {3.6 * end.speed:.0f} km/h. {_detections_of_hit(drive)}"


def _detections_of_hit(drive: Drive) -> str:
    """Describe in one sentence how often the object that was hit had returns and a box."""
    examined = [m for m in drive.moments[-LOOKING_BACK:-1] if not m.busy]
    seen, boxed = [], []
    for moment in examined:
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
        return "It had too few returns in each of the last scans."
    if not boxed:
        return f"It was in {len(seen)} of the last scans, but never had a box."
    end = drive.moments[-1]
    age = (end.number - (end.seen or 0)) / 10
    if age > 0.35:
        return f"It had a box, but the latest boxes that the car received were {age:.1f} s old."
    share = f"It was in {len(seen)} of the last scans and had a box in {len(boxed)} of them"
    return f"{share}, for the first time {(end.number - boxed[0]) / 10:.1f} s before the collision."
