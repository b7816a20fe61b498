"""Compute the angles that shapes cover from the origin, to select the rays that may hit them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

FULL_CIRCLE = (-math.pi, math.pi)


def disc_azimuths(centre: np.ndarray, radius: float) -> tuple[float, float]:
    """Return the azimuths in radians that a disc around `centre` covers, seen from the origin."""
    distance = math.hypot(centre[0], centre[1])
    if distance <= radius:
        return FULL_CIRCLE
    middle, half = math.atan2(centre[1], centre[0]), math.asin(radius / distance)
    return middle - half, middle + half


def polygon_azimuths(corners: Sequence[Sequence[float]]) -> tuple[float, float]:
    """Return the azimuths in radians that a hull of corners (x, y) covers, seen from the origin."""
    middle_x, middle_y = _middle(corners)
    if math.hypot(middle_x, middle_y) == 0.0:
        return FULL_CIRCLE
    # Relative to the middle of the hull no angle wraps around, unless the origin is inside.
    turns = [
        math.atan2(middle_x * y - middle_y * x, x * middle_x + y * middle_y) for x, y in corners
    ]
    first, last = min(turns), max(turns)
    if last - first >= math.pi:
        return FULL_CIRCLE
    heading = math.atan2(middle_y, middle_x)
    return heading + first, heading + last


def polygon_distance(corners: Sequence[Sequence[float]]) -> float:
    """Return a lower bound of the distance from the origin to the hull of corners (x, y).

    The bound is the largest distance to a line that separates the origin from the hull. The lines
    are perpendicular to an axis, or to the direction of a corner or of the middle. The bound is
    exact or slightly too small, never too large.
    """
    ahead, aside = [x for x, _ in corners], [y for _, y in corners]
    # Faces perpendicular to an axis are common, such as a long wall along the road.
    distance = max(0.0, min(ahead), -max(ahead), min(aside), -max(aside))
    for toward_x, toward_y in (*corners, _middle(corners)):
        length = math.hypot(toward_x, toward_y)
        if length:
            nearest = min(x * toward_x + y * toward_y for x, y in corners)
            distance = max(distance, nearest / length)
    return distance


def _middle(corners: Sequence[Sequence[float]]) -> tuple[float, float]:
    return (
        sum(x for x, _ in corners) / len(corners),
        sum(y for _, y in corners) / len(corners),
    )


def elevation_limits(
    lowest: float, highest: float, nearest: float, farthest: float
) -> tuple[float, float]:
    """Return the lowest and highest elevation, in radians, of an object with these limits."""
    return (
        math.atan2(lowest, nearest if lowest < 0 else farthest),
        math.atan2(highest, nearest if highest > 0 else farthest),
    )
