"""From boxes to things that move: which box is which, and how fast it was in the last half second.

The speed is the median of those between any two of the last places (P. K. Sen, "Estimates of the
regression coefficient based on Kendall's tau", 1968): a box that grows or jumps once, as boxes do
where things come close to each other, does not count for a speed.
"""

from __future__ import annotations

import copy
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


@dataclass(frozen=True, eq=False)
class Track:
    """One thing, from scan to scan.

    Parameters
    ----------
    box : ndarray, shape (8, 3)
        The scanner at the origin.
    places : tuple of (float, float, float)
        When it was where, over the ground: seconds, and metres along and across the road.
    velocity : tuple of float
        Over the ground, in m/s.
    missed : int
        Scans in a row without a box.
    """

    box: np.ndarray
    places: tuple[tuple[float, float, float], ...]
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
        seen = []
        for box, partner in zip(boxes, partners, strict=True):
            before = expected[partner].places if 0 <= partner < len(expected) else ()
            x, y = box[:, :2].mean(axis=0).tolist()
            now = (*before, (self._time, x + self._position, y))[-WINDOW:]
            seen.append(Track(box, now, _velocity(now)))
        coasting = [
            replace(track, missed=track.missed + 1)
            for row, track in enumerate(expected)
            if row not in partners and track.missed < PATIENCE and len(track.places) > 1
        ]
        self._tracks = seen + coasting
        return [Thing(track.box, track.velocity) for track in self._tracks]


class MotionOf:
    """The same by a student's tracker, which sees the street from a car that drives.

    Parameters
    ----------
    tracker : utils.tracking.Tracker
        That knows velocities. It is copied, so that each drive begins with nobody.
    """

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = copy.copy(tracker)

    def update(self, boxes: np.ndarray, driven: float, seconds: float) -> list[Thing]:
        """What moves how; see `Motion.update`."""
        self._tracker.update(boxes, seconds)
        tracks = self._tracker.tracks
        speeds = tracks.velocities[:, :2] + (driven / seconds, 0.0)
        speeds = np.where((np.abs(speeds) < SLOWEST) | ~np.isfinite(speeds), 0.0, speeds)
        speeds[tracks.age < OLD_ENOUGH] = 0.0
        return [
            Thing(box, tuple(speed))
            for box, speed in zip(tracks.boxes, speeds.tolist(), strict=True)
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


def _velocity(places: tuple[tuple[float, float, float], ...]) -> tuple[float, float]:
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
    return tuple(np.where(believed, middle, 0.0).tolist())


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
