"""The driving loop: scan from the car's position, detect, decide and drive on.

The detector's answer is available a tenth of a second after its scan, or later if the detector
takes longer. While the detector is busy it misses scans, as it would on the road.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from utils.drive.clock import Clock, on_time, ticks
from utils.drive.ground_truth import distances_to_objects, true_boxes
from utils.drive.motion import make_motion
from utils.drive.planner import Decision, Planner, TrackedBox
from utils.drive.rules import JERK, TICK
from utils.drive.streets import SCANNER, Street
from utils.drive.weather import with_dirt, with_rain
from utils.films.film import as_boxes
from utils.progress import progress
from utils.remote_objects import RemoteStopped
from utils.simulator.frames import Frame, observe
from utils.simulator.sensor import Sensor
from utils.simulator.world import World
from utils.tracking import Tracker

COLLISION_SPEED = 0.3
"""Speed in m/s above which contact is a collision; others may walk into a standing car."""

NO_BOXES = np.empty((0, 8, 3))


@dataclass(frozen=True, eq=False)
class Moment:
    """A tenth of a second of a drive.

    Attributes
    ----------
    number : int
        Index of the moment, from 0.
    position, speed : float
        Position along the road in metres and speed in m/s, at the beginning of the moment.
    decision : Decision
        The planner's decision, based on the detector's latest answer.
    acceleration : float
        Actual acceleration of the car in m/s²; brakes take a while to build up.
    latest_scan : int or None
        Index of the scan whose boxes the planner used; None before the first answer.
    boxes : ndarray, shape (N, 8, 3)
        The detector's answer to the scan of *this* moment; empty if the detector was still busy.
    is_busy : bool
        Whether the detector was busy with an earlier scan.
    start_times : dict of int to float
        Start time in seconds of each actor that has begun, by its index in the street.
    gaps : dict of int to float
        Distance in metres to each object near the car, by the object's identity.
    tracked_boxes : tuple of TrackedBox
        The boxes on which the decision is based, relative to the car's position in this moment.
    """

    number: int
    position: float
    speed: float
    decision: Decision
    acceleration: float
    latest_scan: int | None
    boxes: np.ndarray
    is_busy: bool = False
    start_times: dict[int, float] = field(default_factory=dict)
    gaps: dict[int, float] = field(default_factory=dict)
    tracked_boxes: tuple[TrackedBox, ...] = ()

    @property
    def time(self) -> float:
        """Seconds since the beginning of the drive."""
        return self.number * TICK

    @property
    def is_braking(self) -> bool:
        """Whether the planner brakes; False if the car only waits or follows."""
        return self.decision.cause is not None and self.decision.acceleration < -1.0


@dataclass(frozen=True, eq=False)
class Drive:
    """A drive, from beginning to end.

    Attributes
    ----------
    street : Street
    moments : tuple of Moment
    hit_identity : int or None
        Identity of the object that the car hit, which ended the drive.
    problems : tuple of str
        One sentence for each scan on which the detector or ``match_boxes`` failed.
    sensor : Sensor
    """

    street: Street
    moments: tuple[Moment, ...]
    hit_identity: int | None = None
    problems: tuple[str, ...] = ()
    sensor: Sensor = SCANNER

    @property
    def metres(self) -> float:
        """Distance that the car drove."""
        return self.moments[-1].position

    def world(self, number: int) -> World:
        """Return the world at a moment, in the car's frame."""
        moment = self.moments[number]
        return self.street.world(moment.time, moment.position, moment.start_times)

    def frame(self, number: int) -> Frame:
        """Compute the scan of a moment again, with its true boxes."""
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
    """Drive down a street, guided by the boxes of a detector.

    Parameters
    ----------
    street : Street
        One of `utils.drive.STREETS`.
    detect : callable, optional
        Takes a cloud (n, 4) and returns boxes (N, 8, 3), such as ``detect_obstacles``. Without a
        detector the car sees the true boxes.
    tracker : utils.tracking.Tracker, optional
        A tracker with a student's functions from lesson 12. The course provides missing ones.
    seconds : float
        Duration of the drive; a collision ends it earlier.
    clock : callable, optional
        Measures the delay of the detector, see `utils.drive.clock`; by default a `Clock`.
    sensor : Sensor
        The car's scanner; a coarser one takes less time to simulate.

    Raises
    ------
    Exception
        Any exception that the detector raises for the first scan. Later failures, and failures
        of ``match_boxes``, are added to `Drive.problems`; the car sees no box in these scans.
    utils.remote_objects.RemoteStopped
        The detector runs in another process, which has ended.
    """
    clock = on_time if detect is None else clock or Clock()
    detector = _TimedDetector(detect, clock)
    planner, motion, tracked_boxes = Planner(), make_motion(tracker), []
    latest = _DetectorAnswer(-1, 0, 0.0, NO_BOXES)  # a placeholder until the first answer arrives
    position, speed, acceleration = 0.0, street.limit, 0.0
    moments, start_times, pending, hit_identity = [], {}, None, None
    for number in progress(range(round(seconds / TICK)), f"Driving, street {street.number}"):
        time = number * TICK
        for index, actor in enumerate(street.actors):
            if index not in start_times and position >= actor.start_position:
                start_times = start_times | {index: time}
        world = street.world(time, position, start_times)
        gaps = distances_to_objects(world)
        hit_identity = next(
            (key for key, gap in gaps.items() if gap <= 0.0 and speed > COLLISION_SPEED), None
        )
        if pending and pending.ready_at <= number:
            elapsed = TICK * (pending.scan - latest.scan)
            try:
                tracked_boxes = motion.update(
                    pending.boxes, pending.position - latest.position, elapsed
                )
            except RemoteStopped:
                raise
            except Exception as error:
                detector.note_failure(pending.scan, error)
                tracked_boxes = []
            latest, pending = pending, None
        is_busy, boxes = pending is not None, NO_BOXES
        if not is_busy:
            boxes, delay = detector.run(scan_from(world, street, sensor, number), number)
            pending = _DetectorAnswer(number, number + delay, position, boxes)
        shift = (position - latest.position, 0.0, 0.0)
        now = [replace(box, corners=box.corners - shift) for box in tracked_boxes]
        decision = planner.decide(speed, street.limit, now)
        change = np.clip(decision.acceleration - acceleration, -JERK * TICK, JERK * TICK)
        acceleration = float(np.clip(acceleration + change, -speed / TICK, None))
        latest_scan = latest.scan if latest.boxes is not NO_BOXES else None
        moments.append(
            Moment(
                number,
                position,
                speed,
                decision,
                acceleration,
                latest_scan,
                boxes,
                is_busy,
                start_times,
                gaps,
                tuple(now),
            )
        )
        if hit_identity is not None:
            break
        next_speed = max(speed + acceleration * TICK, 0.0)
        position, speed = position + (speed + next_speed) / 2 * TICK, next_speed
    return Drive(street, tuple(moments), hit_identity, tuple(detector.problems), sensor)


@dataclass(frozen=True, eq=False)
class _DetectorAnswer:
    """The boxes of a scan, the time when they are ready, and the car's position at the scan."""

    scan: int
    ready_at: int
    position: float
    boxes: np.ndarray


class _TimedDetector:
    """Times a detector and collects its failures."""

    def __init__(self, detect: Callable | None, clock: Callable) -> None:
        self._detect, self._clock, self._has_answered = detect, clock, False
        self.problems: list[str] = []

    def run(self, frame: Frame, number: int) -> tuple[np.ndarray, int]:
        """Return the boxes, and the number of scans after which they are available."""
        if self._detect is None:
            return true_boxes(frame), 1
        try:
            if not self._has_answered:  # the first call may load libraries and is not timed
                self._detect(frame.cloud.copy())
            found, seconds = self._clock(lambda: self._detect(frame.cloud.copy()))
            boxes = as_boxes(found)
        except RemoteStopped:  # the process has ended, so every later scan would fail
            raise
        except Exception as error:
            if not self._has_answered:
                raise
            self.note_failure(number, error)
            return NO_BOXES.copy(), 1
        self._has_answered = True
        return boxes[np.isfinite(boxes).all(axis=(1, 2))], ticks(seconds)

    def note_failure(self, number: int, error: Exception) -> None:
        """Record that a student's function failed for a scan."""
        self.problems.append(f"scan {number}: {type(error).__name__}: {error}")


def scan_from(world: World, street: Street, sensor: Sensor, number: int) -> Frame:
    """Scan a world, with the rain and the dirty bonnet of a street."""
    frame = observe(world, sensor, (street.seed, 31, number), number * TICK)
    swept, rng = frame.scan, np.random.default_rng((street.seed, 32, number))
    if street.rain:
        swept = with_rain(swept, street.rain, rng)
    if street.has_dirty_bonnet:
        swept = with_dirt(swept, rng)
    return Frame(swept, frame.boxes, frame.time)
