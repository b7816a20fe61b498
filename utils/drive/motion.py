"""From boxes to things that move: which box is which, and how fast it was in the last half second.

The speed is the median of those between any two of the last places (P. K. Sen, "Estimates of the
regression coefficient based on Kendall's tau", 1968): a box that grows or jumps once, as boxes do
where things come close to each other, does not count for a speed. Sideways, where the middle of a
box goes says little: of a car that is torn for a few scans one side stays and the other comes
nearer. So a thing moves sideways as fast as that of its sides which moves less.
"""

from __future__ import annotations

import copy
import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from utils.drive.planner import Thing
from utils.tracking import Tracker

FARTHEST = 1.5
"""Metres between where a thing is expected and its box, as in lesson 12."""

PATIENCE = 3
"""Scans for which a track lives on without a box."""

WINDOW, OLD_ENOUGH = 7, 4
"""Scans that a speed is taken of, and from how many on; until then a thing stands."""

SLOWEST = 0.5
"""Metres per second; slower than that, it is the box that wobbles."""

STEADY = 0.5
"""How far speeds may spread around their median, as a share of it: a box that jumps has none."""

Place = tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class Track:
    """One thing, from scan to scan.

    Parameters
    ----------
    name : int
    box : ndarray, shape (8, 3)
        The scanner at the origin.
    places : tuple of (float, float, float, float)
        When it was where, over the ground: seconds, metres along the road of its middle, and
        across the road of its right side and of its left.
    velocity : tuple of float
        Over the ground, in m/s.
    missed : int
        Scans in a row without a box.
    """

    name: int
    box: np.ndarray
    places: tuple[Place, ...]
    velocity: tuple[float, float] = (0.0, 0.0)
    missed: int = 0


class Motion:
    """Follows boxes through a drive.

    Parameters
    ----------
    match : callable, optional
        `match_boxes` of lesson 12; else the pairs with the smallest sum of distances.
    """

    def __init__(self, match: Callable | None = None) -> None:
        self._match = match or closest_pairs
        self._tracks: list[Track] = []
        self._names = itertools.count()
        self._time = self._position = 0.0

    def update(self, boxes: np.ndarray, driven: float, seconds: float) -> list[Thing]:
        """What moves how, after another answer of the detector.

        Parameters
        ----------
        boxes : ndarray, shape (N, 8, 3)
        driven : float
            Metres that we drove since the scan of the last answer: the wheels measure it.
        seconds : float
            Since that scan.
        """
        self._time, self._position = self._time + seconds, self._position + driven
        expected = [_moved(track, driven, seconds) for track in self._tracks]
        places = np.reshape([track.box for track in expected], (-1, 8, 3))
        partners = np.asarray(self._match(places, boxes, FARTHEST), dtype=int).tolist()
        if len(partners) != len(boxes):
            raise ValueError(f"match_boxes returned {len(partners)} numbers for {len(boxes)} boxes")
        seen = []
        for box, partner in zip(boxes, partners, strict=True):
            known = 0 <= partner < len(expected)
            name, before = next(self._names), ()
            if known:
                name, before = expected[partner].name, expected[partner].places
            now = (*before, _place(box, self._time, self._position))[-WINDOW:]
            seen.append(Track(name, box, now, _velocity(now)))
        coasting = [
            replace(track, missed=track.missed + 1)
            for row, track in enumerate(expected)
            if row not in partners and track.missed < PATIENCE and len(track.places) > 1
        ]
        self._tracks = seen + coasting
        return [
            Thing(track.box, track.velocity, track.missed == 0, track.name)
            for track in self._tracks
        ]


class MotionOf:
    """The same by a student's tracker, which sees the street from a car that drives.

    Parameters
    ----------
    tracker : utils.tracking.Tracker
        That knows velocities. It is copied, so that each drive begins with nobody.
    """

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = copy.copy(tracker)
        self._places: dict[int, tuple[Place, ...]] = {}
        self._time = self._position = 0.0

    def update(self, boxes: np.ndarray, driven: float, seconds: float) -> list[Thing]:
        """What moves how; see `Motion.update`."""
        self._time, self._position = self._time + seconds, self._position + driven
        names = self._tracker.update(boxes, seconds).tolist()
        tracks = self._tracker.tracks
        self._places = {name: self._places.get(name, ()) for name in tracks.names.tolist()}
        for name, box in dict(zip(names, boxes, strict=True)).items():  # a wrong match shares names
            now = _place(box, self._time, self._position)
            self._places[name] = (*self._places[name], now)[-OLD_ENOUGH:]
        speeds = tracks.velocities[:, :2] + (driven / seconds, 0.0)
        speeds[:, 1] = [
            _least(speed, *_between(self._places[name]))
            for name, speed in zip(tracks.names.tolist(), speeds[:, 1].tolist(), strict=True)
        ]
        speeds = np.where((np.abs(speeds) < SLOWEST) | ~np.isfinite(speeds), 0.0, speeds)
        speeds[tracks.age < OLD_ENOUGH] = 0.0
        return [
            Thing(box, tuple(speed), missed == 0, name)
            for box, speed, missed, name in zip(
                tracks.boxes, speeds.tolist(), tracks.missed, tracks.names.tolist(), strict=True
            )
        ]


def motion_by(tracker: Tracker | None) -> Motion | MotionOf:
    """What follows boxes in a drive: a student's tracker as far as it is written, and the rest."""
    if tracker and tracker.knows_velocities:
        return MotionOf(tracker)
    return Motion(tracker and tracker.match)


def _moved(track: Track, driven: float, seconds: float) -> Track:
    """A track where it should be by now, seen from where we are."""
    forward, left = track.velocity
    return replace(track, box=track.box + (forward * seconds - driven, left * seconds, 0.0))


def _place(box: np.ndarray, time: float, position: float) -> Place:
    """Where a box is at a time, over the ground."""
    x, y = box[:, :2].T
    return time, float(x.mean()) + position, float(y.min()), float(y.max())


def _velocity(places: tuple[Place, ...]) -> tuple[float, float]:
    """The speed over the ground, along and across the road."""
    if len(places) < OLD_ENOUGH:
        return 0.0, 0.0
    moments = np.array(places)
    first, second = np.triu_indices(len(moments), 1)
    steps = moments[second] - moments[first]
    speeds = steps[:, 1:] / steps[:, :1]
    middle = np.median(speeds, axis=0)
    spread = np.median(np.abs(speeds - middle), axis=0)
    believed = (np.abs(middle) >= SLOWEST) & (spread <= STEADY * np.abs(middle))
    along, right, left = np.where(believed, middle, 0.0).tolist()
    return along, _least(right, left)


def _between(places: tuple[Place, ...]) -> tuple[float, float]:
    """Speeds of the right side and of the left, from the first of some places to the last."""
    if len(places) < 2:
        return 0.0, 0.0
    (began, *_, right, left), (now, *_, right_now, left_now) = places[0], places[-1]
    return (right_now - right) / (now - began), (left_now - left) / (now - began)


def _least(*speeds: float) -> float:
    """The speed of those that is nearest to none; none, where they do not all go one way."""
    return max(min(speeds), 0.0) + min(max(speeds), 0.0)


def closest_pairs(previous: np.ndarray, current: np.ndarray, max_distance: float) -> np.ndarray:
    """Partners of boxes, by the smallest sum of distances; -1 for none. Shape (N_current,)."""
    from scipy.optimize import linear_sum_assignment
    from scipy.spatial.distance import cdist

    middles = (np.reshape(boxes, (-1, 8, 3)).mean(axis=1) for boxes in (current, previous))
    apart = cdist(*middles)
    rows, columns = linear_sum_assignment(np.minimum(apart, 1e3 * max_distance))
    near = apart[rows, columns] <= max_distance
    partners = np.full(len(current), -1)
    partners[rows[near]] = columns[near]
    return partners
