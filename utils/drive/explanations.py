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
from utils.drive.ground_truth import FEWEST_RETURNS, true_tracked_boxes
from utils.drive.loop import Drive
from utils.drive.planner import TrackedBox, braking_gap, gap_to, overlap_from_front
from utils.drive.rules import OVERLAP_WITH_CAR
from utils.drive.weather import KINDS

KINDS_IN_WORDS = {
    "car": "a car",
    "truck": "a lorry",
    "pedestrian": "a person",
    "cyclist": "a cyclist",
    "pole": "a pole",
    "wall": "a wall",
    "foliage": "a tree or hedge",
}
FALSE_CAUSES = {
    "ground": "road mistaken for an obstacle",
    "ego": "the ego car mistaken for an obstacle",
    "invalid": "lost returns mistaken for an obstacle",
    "raindrop": "rain mistaken for an obstacle",
}

LONGEST_PAUSE = 5
"""Longest pause, in moments, between two phases of braking that count as one event."""

JUSTIFYING_MOMENTS = 10
"""Moments before and after the start of braking in which a real object justifies it."""

EXTRA_WIDTH, DISTANCE_FACTOR = 0.3, 1.3
"""Tolerance: metres added to the corridor on either side, and a factor for the distance."""

SCANS_BEFORE_COLLISION = 30
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


def braking_events(drive: Drive) -> Iterator[Braking]:
    """Yield all braking events of a drive, in order."""
    for first, last in _braking_spans(drive):
        number = _decisive_moment(drive, first, last)
        moment = drive.moments[number]
        cause = moment.decision.cause
        justifying = _justifying_objects(drive, first)
        reason = _describe_real_cause(drive, number, cause, justifying)
        if not reason:
            reason = _describe_apparent_cause(drive, number, cause)
            if justifying:  # justified by an object outside the box
                other = KINDS_IN_WORDS[drive.street.kind_of(min(justifying))]
                reason += f", and {other} is also in the way"
        yield Braking(
            first, last, moment.latest_scan or 0, moment.decision.gap, not justifying, reason
        )


def _braking_spans(drive: Drive) -> list[tuple[int, int]]:
    """Return the first and last moment of each braking event."""
    spans: list[tuple[int, int]] = []
    for moment in drive.moments:
        if not moment.is_braking or moment.speed < 1.0:
            continue
        if spans and moment.number - spans[-1][1] <= LONGEST_PAUSE:
            spans[-1] = spans[-1][0], moment.number
        else:
            spans.append((moment.number, moment.number))
    return spans


def _decisive_moment(drive: Drive, first: int, last: int) -> int:
    """Return the index of the moment whose cause explains a braking event.

    A box that overlaps the ego car has priority, because it keeps the car from driving on.
    Without such a box, the first moment explains the event.
    """
    for moment in drive.moments[first : last + 1]:
        cause = moment.decision.cause
        if cause and overlap_from_front(cause, moment.speed) > OVERLAP_WITH_CAR:
            return moment.number
    return first


def _justifying_objects(drive: Drive, first: int) -> set[int]:
    """Return the identities of all real objects that justify braking from moment `first`."""
    numbers = range(
        max(first - JUSTIFYING_MOMENTS, 0), min(first + JUSTIFYING_MOMENTS + 1, len(drive.moments))
    )
    return {
        obstacle.identity
        for number in numbers
        for obstacle, box in true_tracked_boxes(drive.world(number))
        if gap_to(box, drive.moments[number].speed, EXTRA_WIDTH)
        <= DISTANCE_FACTOR * braking_gap(box, drive.moments[number].speed)
    }


def returns_in_box(drive: Drive, number: int, cause: TrackedBox) -> tuple[np.ndarray, np.ndarray]:
    """Return the classes and object identities of the returns in the box that made the car brake.

    Parameters
    ----------
    drive : Drive
    number : int
        Index of the moment.
    cause : TrackedBox
        The box that made the car brake, as the planner knew it at that moment.
    """
    moment = drive.moments[number]
    scan = drive.frame(moment.latest_scan or 0).scan
    start = drive.moments[moment.latest_scan or 0].position
    corners = cause.corners + (moment.position - start, 0, 0)
    floor, xyz = corners[np.argsort(corners[:, 2], kind="stable")[:4], :2], scan.cloud[:, :3]
    middle = floor.mean(axis=0)
    around = np.argsort(np.arctan2(*(floor - middle).T[::-1]))
    low, high = corners[:, 2].min(), corners[:, 2].max()
    inside = (distance_outside(xyz[:, :2], floor[around]) <= 0.1) & (xyz[:, 2] >= low - 0.1)
    inside &= xyz[:, 2] <= high + 0.1
    return scan.classes[inside], scan.objects[inside]


def _describe_apparent_cause(drive: Drive, number: int, cause: TrackedBox) -> str:
    """Describe the box that caused braking, if no object in it justifies the braking."""
    classes, objects = returns_in_box(drive, number, cause)
    if not len(classes):
        return "a box without returns"
    counts = np.bincount(classes, minlength=len(KINDS))
    kind = KINDS[int(counts.argmax())]
    if kind in FALSE_CAUSES:
        return FALSE_CAUSES[kind]
    identities, returns = np.unique(objects[objects > 0], return_counts=True)
    order = np.argsort(-returns)
    identities_by_returns = [
        int(identities[row]) for row in order if returns[row] >= max(3, 0.05 * len(objects))
    ]
    first = (
        KINDS_IN_WORDS[drive.street.kind_of(identities_by_returns[0])]
        if identities_by_returns
        else KINDS_IN_WORDS[kind]
    )
    if not np.isfinite(gap_to(TrackedBox(cause.corners), drive.moments[number].speed)):
        return f"{first} next to our lane, assumed to move into it"
    if len(identities_by_returns) > 1:
        second = KINDS_IN_WORDS[drive.street.kind_of(identities_by_returns[1])]
        other = f"another {second.partition(' ')[2]}" if second == first else second
        return f"{first} and {other} in one box"
    return f"{first} next to our lane, whose box reaches into it"


def _describe_real_cause(drive: Drive, number: int, cause: TrackedBox, justifying: set[int]) -> str:
    """Describe the object in the box that justifies the braking; empty if there is none."""
    _, objects = returns_in_box(drive, number, cause)
    identities, returns = np.unique(objects[objects > 0], return_counts=True)
    real = [int(identities[row]) for row in np.argsort(-returns) if identities[row] in justifying]
    if not real:
        return ""
    text = KINDS_IN_WORDS[drive.street.kind_of(real[0])]
    comes = not np.isfinite(gap_to(TrackedBox(cause.corners), drive.moments[number].speed))
    return f"{text} about to enter our lane" if comes else f"{text} in our lane"


def describe_collision(drive: Drive) -> str:
    """Describe a collision, its speed and how the object was detected; empty without one."""
    if drive.hit_identity is None:
        return ""
    end = drive.moments[-1]
    text = KINDS_IN_WORDS[drive.street.kind_of(drive.hit_identity)]
    subject = f"The {text.partition(' ')[2]}"
    seen = _describe_detections(drive, subject)
    return f"The car hits {text} at {3.6 * end.speed:.0f} km/h. {seen}"


def _describe_detections(drive: Drive, subject: str) -> str:
    """Describe in one sentence how often the object that was hit had returns and a box."""
    examined = [m for m in drive.moments[-SCANS_BEFORE_COLLISION:-1] if not m.is_busy]
    seen, boxed = [], []
    for moment in examined:
        scan = drive.frame(moment.number).scan
        points = scan.cloud[scan.objects == drive.hit_identity, :3]
        if len(points) < FEWEST_RETURNS:
            continue
        seen.append(moment.number)
        low, high = moment.boxes.min(axis=1), moment.boxes.max(axis=1)
        within = ((points[:, None] >= low) & (points[:, None] <= high)).all(axis=2)
        if len(moment.boxes) and within.any(axis=1).mean() >= 0.3:
            boxed.append(moment.number)
    if not seen:
        return f"{subject} had too few returns in each of the last scans."
    if not boxed:
        return f"{subject} was in {len(seen)} of the last scans, but never had a box."
    end = drive.moments[-1]
    age = (end.number - (end.latest_scan or 0)) / 10
    if age > 0.35:
        return f"{subject} had a box, but the car's latest boxes were {age:.1f} s old."
    share = f"{subject} was in {len(seen)} of the last scans and had a box in {len(boxed)} of them"
    return f"{share}, for the first time {(end.number - boxed[0]) / 10:.1f} s before the collision."
