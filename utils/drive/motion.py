"""Motion of boxes: match them from scan to scan and estimate their velocities.

The speed is the median of the speeds between any two of the latest places (P. K. Sen, "Estimates of
the regression coefficient based on Kendall's tau", 1968). A box that grows or jumps once therefore
does not change the speed.

Sideways, the centre of a box is misleading. When a car is split for a few scans, one side of its
box stays in place and the other comes nearer. The speed of the slower side is therefore used, or 0
if the sides move in opposite directions.
"""

from __future__ import annotations

import copy
import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from utils.drive.planner import TrackedBox
from utils.tracking import Tracker

FARTHEST = 1.5
"""Largest distance in metres between an expected and a found box, as in lesson 12."""

PATIENCE = 3
"""Number of consecutive scans for which a track is kept without a box."""

WINDOW, FEWEST_PLACES = 7, 4
"""Number of latest places from which a speed is estimated, and the minimum for a speed above 0."""

SMALLEST_SPEED = 0.5
"""Smallest speed in m/s that counts; anything slower is noise in the box."""

LARGEST_SPREAD = 0.5
"""Largest spread of the speeds, as a share of their median; if it is larger, the speed is 0."""

Place = tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class Track:
    """One object, followed from scan to scan.

    Parameters
    ----------
    track_id : int
        The same from scan to scan.
    box : ndarray, shape (8, 3)
        Corners in metres, with the scanner at the origin.
    places : tuple of (float, float, float, float)
        Latest places over the ground. Each consists of the time in seconds and, in metres, the
        centre along the road and the right and left sides across it.
    velocity : tuple of float
        Velocity over the ground, forward and to the left, in m/s.
    missed : int
        Number of consecutive scans without a box.
    """

    track_id: int
    box: np.ndarray
    places: tuple[Place, ...]
    velocity: tuple[float, float] = (0.0, 0.0)
    missed: int = 0


class Motion:
    """Follows boxes through a drive and estimates their velocities.

    Parameters
    ----------
    match : callable, optional
        `match_boxes` of lesson 12. By default, `match_by_total_distance`.
    """

    def __init__(self, match: Callable | None = None) -> None:
        self._match = match or match_by_total_distance
        self._tracks: list[Track] = []
        self._track_ids = itertools.count()
        self._time = self._position = 0.0

    def update(self, boxes: np.ndarray, distance: float, seconds: float) -> list[TrackedBox]:
        """Update the tracks with the detector's next answer and return them as tracked boxes.

        Parameters
        ----------
        boxes : ndarray, shape (N, 8, 3)
            Corners in metres, with the scanner at the origin.
        distance : float
            Metres driven since the scan of the previous answer, measured at the wheels.
        seconds : float
            Time since that scan.
        """
        self._time, self._position = self._time + seconds, self._position + distance
        expected = [_predict(track, distance, seconds) for track in self._tracks]
        places = np.reshape([track.box for track in expected], (-1, 8, 3))
        partners = np.asarray(self._match(places, boxes, FARTHEST), dtype=int).tolist()
        if len(partners) != len(boxes):
            raise ValueError(f"match_boxes returned {len(partners)} numbers for {len(boxes)} boxes")
        seen = []
        for box, partner in zip(boxes, partners, strict=True):
            is_known = 0 <= partner < len(expected)
            track_id, before = next(self._track_ids), ()
            if is_known:
                track_id, before = expected[partner].track_id, expected[partner].places
            now = (*before, _place(box, self._time, self._position))[-WINDOW:]
            seen.append(Track(track_id, box, now, _velocity(now)))
        coasting = [
            replace(track, missed=track.missed + 1)
            for row, track in enumerate(expected)
            if row not in partners and track.missed < PATIENCE and len(track.places) > 1
        ]
        self._tracks = seen + coasting
        return [
            TrackedBox(track.box, track.velocity, track.missed == 0, track.track_id)
            for track in self._tracks
        ]


class TrackerMotion:
    """Converts a student's tracks, relative to the moving car, into velocities over the ground.

    Parameters
    ----------
    tracker : utils.tracking.Tracker
        A tracker that estimates velocities. It is copied, so that each drive starts without tracks.
    """

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = copy.copy(tracker)
        self._places: dict[int, tuple[Place, ...]] = {}
        self._time = self._position = 0.0

    def update(self, boxes: np.ndarray, distance: float, seconds: float) -> list[TrackedBox]:
        """Update the tracker and return the tracks that count as boxes; see `Motion.update`."""
        self._time, self._position = self._time + seconds, self._position + distance
        track_ids = self._tracker.update(boxes, seconds).tolist()
        tracks = self._tracker.tracks
        self._places = {
            track_id: self._places.get(track_id, ()) for track_id in tracks.ids.tolist()
        }
        # Wrong matches repeat a track ID; the last box counts.
        latest_boxes = dict(zip(track_ids, boxes, strict=True))
        for track_id, box in latest_boxes.items():
            now = _place(box, self._time, self._position)
            self._places[track_id] = (*self._places[track_id], now)[-FEWEST_PLACES:]
        speeds = tracks.velocities[:, :2] + (distance / seconds, 0.0)
        speeds[:, 1] = [
            _speed_nearest_to_zero(speed, *_side_speeds(self._places[track_id]))
            for track_id, speed in zip(tracks.ids.tolist(), speeds[:, 1].tolist(), strict=True)
        ]
        speeds = np.where((np.abs(speeds) < SMALLEST_SPEED) | ~np.isfinite(speeds), 0.0, speeds)
        speeds[tracks.age < FEWEST_PLACES] = 0.0
        # The car also brakes for new obstacles, so a tentative track counts while it has a box.
        counted = (tracks.missed == 0) | tracks.confirmed
        return [
            TrackedBox(box, tuple(speed), missed == 0, track_id)
            for box, speed, missed, track_id in zip(
                tracks.boxes[counted],
                speeds[counted].tolist(),
                tracks.missed[counted],
                tracks.ids[counted].tolist(),
                strict=True,
            )
        ]


def make_motion(tracker: Tracker | None) -> Motion | TrackerMotion:
    """Return a `TrackerMotion` if the tracker estimates velocities, else a `Motion`."""
    if tracker and tracker.knows_velocities:
        return TrackerMotion(tracker)
    return Motion(tracker and tracker.match)


def _predict(track: Track, distance: float, seconds: float) -> Track:
    """Return a track at its predicted place, relative to the car's new position."""
    forward, left = track.velocity
    return replace(track, box=track.box + (forward * seconds - distance, left * seconds, 0.0))


def _place(box: np.ndarray, time: float, position: float) -> Place:
    """Return the place of a box over the ground; see `Track.places`."""
    x, y = box[:, :2].T
    return time, float(x.mean()) + position, float(y.min()), float(y.max())


def _velocity(places: tuple[Place, ...]) -> tuple[float, float]:
    """Estimate the velocity over the ground, along and across the road, in m/s."""
    if len(places) < FEWEST_PLACES:
        return 0.0, 0.0
    moments = np.array(places)
    first, second = np.triu_indices(len(moments), 1)
    steps = moments[second] - moments[first]
    speeds = steps[:, 1:] / steps[:, :1]
    middle = np.median(speeds, axis=0)
    spread = np.median(np.abs(speeds - middle), axis=0)
    believed = (np.abs(middle) >= SMALLEST_SPEED) & (spread <= LARGEST_SPREAD * np.abs(middle))
    along, right, left = np.where(believed, middle, 0.0).tolist()
    return along, _speed_nearest_to_zero(right, left)


def _side_speeds(places: tuple[Place, ...]) -> tuple[float, float]:
    """Return the mean sideways speeds of the right and left sides over all places."""
    if len(places) < 2:
        return 0.0, 0.0
    (start, *_, right, left), (now, *_, right_now, left_now) = places[0], places[-1]
    return (right_now - right) / (now - start), (left_now - left) / (now - start)


def _speed_nearest_to_zero(*speeds: float) -> float:
    """Return the speed nearest to 0, or 0 if the speeds have different signs."""
    return max(min(speeds), 0.0) + min(max(speeds), 0.0)


def match_by_total_distance(
    previous: np.ndarray, current: np.ndarray, max_distance: float
) -> np.ndarray:
    """Match boxes so that the sum of the distances between partners is smallest.

    Returns
    -------
    ndarray of int, shape (N_current,)
        Index of each box's partner among the previous boxes; -1 for none.
    """
    from scipy.optimize import linear_sum_assignment
    from scipy.spatial.distance import cdist

    middles = (np.reshape(boxes, (-1, 8, 3)).mean(axis=1) for boxes in (current, previous))
    apart = cdist(*middles)
    rows, columns = linear_sum_assignment(np.minimum(apart, 1e3 * max_distance))
    near = apart[rows, columns] <= max_distance
    partners = np.full(len(current), -1)
    partners[rows[near]] = columns[near]
    return partners
