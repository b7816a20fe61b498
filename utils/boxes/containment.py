"""Find points inside a `Box`, and measure how far points are outside a rectangle."""

import numpy as np

from utils.boxes.box import Box


def inside(cloud: np.ndarray, box: Box) -> np.ndarray:
    """Find the points inside an upright box, including its faces.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        In metres, in the coordinate system of the box.
    box : Box

    Returns
    -------
    ndarray, shape (n,), bool
        True for a point inside the box.
    """
    offsets = cloud[:, :3] - np.asarray(box.centre)
    along = np.array([np.cos(box.yaw), np.sin(box.yaw)])
    half = np.asarray(box.size) / 2
    return (_distance_beyond_side(offsets[:, :2], along, half[:2]) <= 0) & (
        np.abs(offsets[:, 2]) <= half[2]
    )


def distance_outside(points: np.ndarray, rectangle: np.ndarray) -> np.ndarray:
    """Measure how far points are outside a rectangle in the plane.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
    rectangle : ndarray, shape (4, 2)
        Corners in cyclic order. Sides may have length 0; if both do, they count as axis-aligned.

    Returns
    -------
    ndarray, shape (n,)
        Distance in metres along or across the rectangle, whichever is larger; negative inside.
    """
    halves = np.array([rectangle[1] - rectangle[0], rectangle[2] - rectangle[1]]) / 2
    lengths = np.linalg.norm(halves, axis=1)
    longer = lengths.argmax()  # the direction of a side of length 0 is undefined
    along = halves[longer] / lengths[longer] if lengths[longer] else np.array([1.0, 0.0])
    return _distance_beyond_side(
        points - rectangle.mean(axis=0), along, lengths[[longer, 1 - longer]]
    )


def _distance_beyond_side(offsets: np.ndarray, along: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Return how far points are outside a rectangle, given their offsets (n, 2) from its centre.

    `half` contains half the lengths of the sides parallel and perpendicular to `along`.
    """
    across = np.array([-along[1], along[0]])
    return np.maximum(np.abs(offsets @ along) - half[0], np.abs(offsets @ across) - half[1])
