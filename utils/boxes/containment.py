"""What lies in a box: in a `Box`, which has a heading, or over four corners, which imply one."""

import numpy as np

from utils.boxes.box import Box


def inside(cloud: np.ndarray, box: Box) -> np.ndarray:
    """Find the points inside an upright box, its faces included.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        In metres, in the frame that the box is given in.
    box : Box

    Returns
    -------
    ndarray, shape (n,), bool
        True for a point in the box.
    """
    offsets = cloud[:, :3] - np.asarray(box.centre)
    along = np.array([np.cos(box.yaw), np.sin(box.yaw)])
    half = np.asarray(box.size) / 2
    return (_beyond(offsets[:, :2], along, half[:2]) <= 0) & (np.abs(offsets[:, 2]) <= half[2])


def distance_outside(points: np.ndarray, rectangle: np.ndarray) -> np.ndarray:
    """Measure how far points are outside a rectangle in the plane.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
    rectangle : ndarray, shape (4, 2)
        Corners in cyclic order. Sides may have no length; a single point heads along x.

    Returns
    -------
    ndarray, shape (n,)
        In metres along or across the rectangle, whichever is more; negative inside.
    """
    halves = np.array([rectangle[1] - rectangle[0], rectangle[2] - rectangle[1]]) / 2
    lengths = np.linalg.norm(halves, axis=1)
    longer = lengths.argmax()  # a side without length has no direction of its own
    along = halves[longer] / lengths[longer] if lengths[longer] else np.array([1.0, 0.0])
    return _beyond(points - rectangle.mean(axis=0), along, lengths[[longer, 1 - longer]])


def _beyond(offsets: np.ndarray, along: np.ndarray, half: np.ndarray) -> np.ndarray:
    """How far offsets (n, 2) from the middle go beyond half the sides, the first one `along`."""
    across = np.array([-along[1], along[0]])
    return np.maximum(np.abs(offsets @ along) - half[0], np.abs(offsets @ across) - half[1])
