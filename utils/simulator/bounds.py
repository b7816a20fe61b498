"""The angles under which shapes appear from the origin: which rays are worth trying on them."""

from __future__ import annotations

import math

import numpy as np

FULL_CIRCLE = (-math.pi, math.pi)


def disc_azimuths(centre: np.ndarray, radius: float) -> tuple[float, float]:
    """Azimuths that a disc around `centre` covers, seen from the origin."""
    distance = math.hypot(centre[0], centre[1])
    if distance <= radius:
        return FULL_CIRCLE
    middle, half = math.atan2(centre[1], centre[0]), math.asin(radius / distance)
    return middle - half, middle + half


def polygon_azimuths(corners: np.ndarray) -> tuple[float, float]:
    """Azimuths that the convex hull of `corners` (k, 2) covers, seen from the origin."""
    middle = corners.mean(axis=0)
    if math.hypot(middle[0], middle[1]) == 0.0:
        return FULL_CIRCLE
    # Measured from the middle of the hull nothing wraps around, unless the origin lies within.
    across = middle[0] * corners[:, 1] - middle[1] * corners[:, 0]
    turns = np.arctan2(across, corners @ middle)
    first, last = float(turns.min()), float(turns.max())
    if last - first >= math.pi:
        return FULL_CIRCLE
    heading = math.atan2(middle[1], middle[0])
    return heading + first, heading + last


def polygon_distance(corners: np.ndarray) -> float:
    """Lower bound of the distance from the origin to the convex hull of `corners` (k, 2).

    It is the largest distance to a line that separates the two and is square to a direction
    towards a corner or towards the middle: exact or a little too small, never too large.
    """
    directions = np.vstack([corners, corners.mean(axis=0)])
    lengths = np.hypot(directions[:, 0], directions[:, 1])
    directions = directions[lengths > 0] / lengths[lengths > 0, np.newaxis]
    # Faces square to the axes are common too: a long wall beside the road.
    directions = np.vstack([directions, [(1, 0), (-1, 0), (0, 1), (0, -1)]])
    return max(float((corners @ directions.T).min(axis=0).max()), 0.0)


def elevation_limits(
    lowest: float, highest: float, nearest: float, farthest: float
) -> tuple[float, float]:
    """Elevations under which heights lowest..highest at nearest..farthest metres appear."""
    return (
        math.atan2(lowest, nearest if lowest < 0 else farthest),
        math.atan2(highest, nearest if highest > 0 else farthest),
    )
