"""The course's planner, which decides how hard to brake and for which box.

The planner does not steer, because the lane is straight. It knows only the detector's boxes and
their motion, so the car stops for a box around nothing and hits an object without a box.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from utils.drive.rules import (
    ACCELERATION,
    BUMPER,
    COMFORTABLE_DECELERATION,
    CORRIDOR,
    DECELERATION,
    LARGEST_SHIFT,
    OVERLAP_WITH_CAR,
    REACTION_TIME,
    SCANS_TO_BE_SURE,
    SCANS_TO_STAY,
    STANDSTILL_GAP,
    stopping_distance,
)

PREDICTIONS = 5
"""Number of moments, from now until standstill, for which the place of a box is predicted."""


@dataclass(frozen=True, eq=False)
class TrackedBox:
    """A box as the planner sees it.

    Parameters
    ----------
    corners : ndarray, shape (8, 3)
        Current corners in metres, with the scanner at the origin.
    velocity : tuple of float
        Velocity over the ground, forward and to the left, in m/s.
    was_seen : bool
        Whether the latest scan had a box for it; otherwise its place is a prediction.
    track_id : int
        Track ID, the same from scan to scan.
    """

    corners: np.ndarray
    velocity: tuple[float, float] = (0.0, 0.0)
    was_seen: bool = True
    track_id: int = 0


@dataclass(frozen=True, eq=False)
class Decision:
    """Acceleration for the next tenth of a second, with its cause.

    Parameters
    ----------
    acceleration : float
        In m/s²; negative values brake.
    cause : TrackedBox or None
        Box for which the car brakes, waits or slows down.
    gap : float
        Distance in metres from the bumper to the current or predicted place of the cause.
    """

    acceleration: float
    cause: TrackedBox | None = None
    gap: float = np.inf


@dataclass(frozen=True, eq=False)
class StationaryBox:
    """A box that overlaps the ego car and stays in one place.

    Parameters
    ----------
    centre : ndarray, shape (2,)
        Centre of the box in metres, with the scanner at the origin.
    scans : int
        Number of scans with this box; scans without it neither count nor reset the count.
    """

    centre: np.ndarray
    scans: int


class Planner:
    """Brakes only for boxes that are in the way in three consecutive scans, to ignore flicker.

    A road user cannot get onto the ego car from one scan to the next. A raindrop can appear there
    but vanishes immediately. A box that overlaps the car therefore counts only after it has stayed
    in one place for a second.
    """

    def __init__(self) -> None:
        self._scans_in_the_way, self._boxes_over_car = {}, []

    def decide(self, speed: float, limit: float, tracked_boxes: Iterable[TrackedBox]) -> Decision:
        """Return the decision for this moment; see `plan` for the parameters.

        The car does not accelerate while a box has been in the way for fewer than three scans.
        """
        tracked_boxes = self._without_phantoms(speed, list(tracked_boxes))
        in_the_way = [box.track_id for box in tracked_boxes if plan(speed, limit, [box]).cause]
        self._scans_in_the_way = {
            track_id: self._scans_in_the_way.get(track_id, 0) + 1 for track_id in in_the_way
        }
        certain = [
            box
            for box in tracked_boxes
            if self._scans_in_the_way.get(box.track_id, SCANS_TO_BE_SURE) >= SCANS_TO_BE_SURE
        ]
        decision = plan(speed, limit, certain)
        if len(certain) == len(tracked_boxes):
            return decision
        return replace(decision, acceleration=min(decision.acceleration, 0.0))

    def _without_phantoms(self, speed: float, tracked_boxes: list[TrackedBox]) -> list[TrackedBox]:
        """Return all boxes except those over the ego car that have not stayed for a second."""
        over = {
            box: self._stationary_box(box)
            for box in tracked_boxes
            if overlap_from_front(box, speed) > OVERLAP_WITH_CAR
        }
        self._boxes_over_car = list(over.values())
        return [box for box in tracked_boxes if box not in over or over[box].scans >= SCANS_TO_STAY]

    def _stationary_box(self, box: TrackedBox) -> StationaryBox:
        middle = box.corners[:, :2].mean(axis=0)
        near = [
            other
            for other in self._boxes_over_car
            if np.abs(other.centre - middle).max() <= LARGEST_SHIFT
        ]
        return StationaryBox(middle, box.was_seen + max((other.scans for other in near), default=0))


def plan(speed: float, limit: float, tracked_boxes: Iterable[TrackedBox]) -> Decision:
    """Decide to drive as fast as allowed, but brake for boxes that are or will be in the corridor.

    Parameters
    ----------
    speed, limit : float
        Speed of the ego car and limit of the street, in m/s.
    tracked_boxes : iterable of TrackedBox
        Boxes around the car.
    """
    free = min(ACCELERATION, (limit - speed) / 0.5)
    decisions = [Decision(free)]
    for box in tracked_boxes:
        gap = gap_to(box, speed)
        ahead = (
            max(box.velocity[0], 0.0) if gap > 0 else 0.0
        )  # a box that overlaps us is not a leading vehicle
        needed = braking_gap(box, speed)
        if gap <= needed + (speed == 0):  # before it starts, a standing car waits for 1 m more
            excess = max(speed**2 - ahead**2, 0.0)
            brake = excess / (2 * max(gap - STANDSTILL_GAP, 0.1))
            gentle = COMFORTABLE_DECELERATION if speed > ahead else 0.0
            decisions.append(Decision(-min(max(brake, gentle), DECELERATION), box, gap))
        elif ahead > 1 and gap <= needed + speed:  # adapt to the speed of the vehicle ahead
            follow = min(free, max(ahead - speed, -2.0) / 2)
            decisions.append(Decision(follow, box if follow < free else None, gap))
    return min(decisions, key=lambda decision: decision.acceleration)


def braking_gap(box: TrackedBox, speed: float) -> float:
    """Return the gap in metres below which the car brakes for a box in the corridor."""
    distance_of_leader = max(box.velocity[0], 0.0) ** 2 / (2 * DECELERATION)
    return STANDSTILL_GAP + max(stopping_distance(speed) - distance_of_leader, 0.0)


def gap_to(box: TrackedBox, speed: float, extra_width: float = 0.0) -> float:
    """Return the gap in metres from the bumper to a box; infinite if outside the corridor.

    Parameters
    ----------
    box : TrackedBox
        The box, with the scanner at the origin.
    speed : float
        Speed of the ego car in m/s. The prediction covers the time until the car would stop.
    extra_width : float
        Metres added to the corridor on either side.
    """
    (x, y), (forward, left) = box.corners[:, :2].T, box.velocity
    if x.max() < 0.0:
        return np.inf  # behind us
    for later in np.linspace(0.0, REACTION_TIME + speed / DECELERATION, PREDICTIONS):
        nearest = _nearest_x_within(CORRIDOR + extra_width, x, y + left * later)
        if np.isfinite(nearest):
            # Only oncoming traffic changes the gap; `braking_gap` accounts for a leading vehicle.
            return float(nearest + min(forward, 0.0) * later) - BUMPER
    return np.inf


def overlap_from_front(box: TrackedBox, speed: float) -> float:
    """Return the overlap in metres of a box in the corridor with the front of the ego car.

    Return 0 if the box begins ahead of the bumper, or extends more than STANDSTILL_GAP metres ahead
    of the bumper.
    """
    x, y = box.corners[:, :2].T
    farthest = -_nearest_x_within(CORRIDOR, -x, y)
    if x.min() > BUMPER or farthest > BUMPER + STANDSTILL_GAP:
        return 0.0
    return max(-gap_to(box, speed), 0.0)


def _nearest_x_within(half_width: float, x: np.ndarray, y: np.ndarray) -> float:
    """Return the smallest x of the points' convex hull within a corridor; infinite if none.

    This x is at a point, or where a line between two points crosses the edge of the corridor.
    """
    a, b = np.triu_indices(len(x), 1)
    rise = y[b] - y[a]
    steep = rise != 0  # other lines are parallel to the edges
    a, b, rise = a[steep], b[steep], rise[steep]
    share = (np.array([[-half_width], [half_width]]) - y[a]) / rise
    crossings = (x[a] + share * (x[b] - x[a]))[(share > 0) & (share < 1)]
    return min(x[np.abs(y) < half_width].min(initial=np.inf), crossings.min(initial=np.inf))
