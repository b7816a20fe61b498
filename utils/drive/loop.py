"""The loop: scan from where the car is, detect, decide, drive on.

What the detector answers arrives a tenth of a second after its scan, or later by as much as it
takes; meanwhile it sees no other scan, as it would on the road.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from utils.drive.clock import Clock, on_time, ticks
from utils.drive.ground_truth import distances, true_boxes
from utils.drive.motion import motion_by
from utils.drive.planner import Decision, Planner
from utils.drive.rules import JERK, TICK
from utils.drive.streets import SCANNER, Street
from utils.drive.weather import with_dirt, with_rain
from utils.films.film import checked_boxes
from utils.progress import progress
from utils.remote_objects import RemoteStopped
from utils.simulator.frames import Frame, observe
from utils.simulator.sensor import Sensor
from utils.simulator.world import World
from utils.tracking import Tracker

ROLLING = 0.3
"""m/s from which on touching is a collision; into a car that stands, others walk by themselves."""

NO_BOXES = np.empty((0, 8, 3))


@dataclass(frozen=True, eq=False)
class Moment:
    """A tenth of a second of a drive.

    Attributes
    ----------
    number : int
        From 0.
    position, speed : float
        Metres along the road and m/s, at its beginning.
    decision : Decision
        What the planner made of what it knew.
    acceleration : float
        What the car did, in m/s²: brakes take a while to build up.
    seen : int or None
        The number of the scan whose boxes the planner knew; None before the first answer.
    boxes : ndarray, shape (N, 8, 3)
        The detector's answer to the scan of *this* moment; empty where it was still busy.
    busy : bool
        Whether the detector was busy with an earlier scan.
    began : dict of int to float
        When actors began, so far.
    gaps : dict of int to float
        Metres to what is near, by its identity.
    """

    number: int
    position: float
    speed: float
    decision: Decision
    acceleration: float
    seen: int | None
    boxes: np.ndarray
    busy: bool = False
    began: dict[int, float] = field(default_factory=dict)
    gaps: dict[int, float] = field(default_factory=dict)

    @property
    def time(self) -> float:
        """Seconds since the beginning."""
        return self.number * TICK

    @property
    def brakes(self) -> bool:
        """Whether the planner brakes, and not only waits or follows."""
        return self.decision.cause is not None and self.decision.acceleration < -1.0


@dataclass(frozen=True, eq=False)
class Drive:
    """A drive, from beginning to end.

    Attributes
    ----------
    street : Street
    moments : tuple of Moment
    hit : int or None
        Identity of what the car ran into, which ended the drive.
    problems : tuple of str
        One sentence for each scan for which the detector or the matching of boxes failed.
    sensor : Sensor
    """

    street: Street
    moments: tuple[Moment, ...]
    hit: int | None = None
    problems: tuple[str, ...] = ()
    sensor: Sensor = SCANNER

    @property
    def metres(self) -> float:
        """How far the car came."""
        return self.moments[-1].position

    def world(self, number: int) -> World:
        """The world at a moment, seen from the car."""
        moment = self.moments[number]
        return self.street.world(moment.time, moment.position, moment.began)

    def frame(self, number: int) -> Frame:
        """The scan of a moment, made again, with its true boxes."""
        return scan_from(self.world(number), self.street, self.sensor, number)


def drive(
    street: Street,
    detect: Callable | None = None,
    tracker: Tracker | None = None,
    *,
    seconds: float = 20.0,
    clock: Callable | None = None,
    sensor: Sensor = SCANNER,
) -> Drive:
    """Drive through a street, seeing it through a detector.

    Parameters
    ----------
    street : Street
        One of `utils.drive.STREETS`.
    detect : callable, optional
        From a cloud (n, 4) to boxes (N, 8, 3), such as ``detect_obstacles``; without one the car
        sees the true boxes.
    tracker : utils.tracking.Tracker, optional
        Of the functions of lesson 12; what it lacks is given.
    seconds : float
        How long; a collision ends the drive.
    clock : callable, optional
        What counts how late the detector is: see `utils.drive.clock`.
    sensor : Sensor
        A coarser one is quicker.

    Raises
    ------
    Exception
        Whatever the detector raises for the first scan. Its later failures, and those of
        ``match_boxes``, go into `Drive.problems`: for these scans the car sees no box.
    utils.remote_objects.RemoteStopped
        The detector lives elsewhere, and is gone.
    """
    clock = on_time if detect is None else clock or Clock()
    eyes = _Eyes(detect, clock)
    planner, motion, things = Planner(), motion_by(tracker), []
    base = _Answer(-1, 0, 0.0, NO_BOXES)  # a scan before the first, of which nobody knows
    position, speed, acceleration = 0.0, street.limit, 0.0
    moments, began, pending, hit = [], {}, None, None
    for number in progress(range(round(seconds / TICK)), f"Driving, street {street.number}"):
        time = number * TICK
        for place, actor in enumerate(street.actors):
            if place not in began and position >= actor.begins:
                began = began | {place: time}
        world = street.world(time, position, began)
        gaps = distances(world)
        hit = next((one for one, gap in gaps.items() if gap <= 0.0 and speed > ROLLING), None)
        if pending and pending.ready <= number:
            since = TICK * (pending.scan - base.scan)
            try:
                things = motion.update(pending.boxes, pending.position - base.position, since)
            except RemoteStopped:
                raise
            except Exception as error:
                eyes.note(pending.scan, error)
                things = []
            base, pending = pending, None
        busy, boxes = pending is not None, NO_BOXES
        if not busy:
            boxes, late = eyes.look(scan_from(world, street, sensor, number), number)
            pending = _Answer(number, number + late, position, boxes)
        shift = (position - base.position, 0.0, 0.0)
        now = [replace(thing, corners=thing.corners - shift) for thing in things]
        decision = planner.decide(speed, street.limit, now)
        change = np.clip(decision.acceleration - acceleration, -JERK * TICK, JERK * TICK)
        acceleration = float(np.clip(acceleration + change, -speed / TICK, None))
        seen = base.scan if base.boxes is not NO_BOXES else None
        moments.append(
            Moment(number, position, speed, decision, acceleration, seen, boxes, busy, began, gaps)
        )
        if hit is not None:
            break
        faster = max(speed + acceleration * TICK, 0.0)
        position, speed = position + (speed + faster) / 2 * TICK, faster
    return Drive(street, tuple(moments), hit, tuple(eyes.problems), sensor)


@dataclass(frozen=True, eq=False)
class _Answer:
    """What the detector made of a scan, when it is there, and where the car was then."""

    scan: int
    ready: int
    position: float
    boxes: np.ndarray


class _Eyes:
    """A detector that is timed, and whose failures are written down."""

    def __init__(self, detect: Callable | None, clock: Callable) -> None:
        self._detect, self._clock, self._looked = detect, clock, False
        self.problems: list[str] = []

    def look(self, frame: Frame, number: int) -> tuple[np.ndarray, int]:
        """Boxes, and the number of scans after which they are there."""
        if self._detect is None:
            return true_boxes(frame), 1
        try:
            if not self._looked:  # loading libraries is not detecting
                self._detect(frame.cloud.copy())
            found, seconds = self._clock(lambda: self._detect(frame.cloud.copy()))
            boxes = checked_boxes(found)
        except RemoteStopped:  # nobody is there any more who could see
            raise
        except Exception as error:
            if not self._looked:
                raise
            self.note(number, error)
            return NO_BOXES.copy(), 1
        self._looked = True
        return boxes[np.isfinite(boxes).all(axis=(1, 2))], ticks(seconds)

    def note(self, number: int, error: Exception) -> None:
        """Write down that a student's function failed for a scan."""
        self.problems.append(f"scan {number}: {type(error).__name__}: {error}")


def scan_from(world: World, street: Street, sensor: Sensor, number: int) -> Frame:
    """What the scanner sees of a world, in the weather of the street."""
    frame = observe(world, sensor, (street.seed, 31, number), number * TICK)
    swept, rng = frame.scan, np.random.default_rng((street.seed, 32, number))
    if street.rain:
        swept = with_rain(swept, street.rain, rng)
    if street.dirt:
        swept = with_dirt(swept, rng)
    return Frame(swept, frame.boxes, frame.time)
