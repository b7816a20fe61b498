"""Boxes, cars, roads and cutting planes as edges (m, 2, 3) and triangles (m, 3, 3)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from utils.visits import Node

RING = ((0, 1), (1, 2), (2, 3), (3, 0))
EDGES = np.array([*RING, *((a + 4, b + 4) for a, b in RING), *((k, k + 4) for k in range(4))])
"""Edges of a box with ordered corners, as pairs of rows.

The corners go around the floor, then around the roof in the same direction from the same corner.
"""

QUADS = np.array([(3, 2, 1, 0), (4, 5, 6, 7), *((a, b, b + 4, a + 4) for a, b in RING)])
TRIANGLES = QUADS[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)

LIGHT = np.array([0.35, -0.5, 0.8]) / np.linalg.norm([0.35, -0.5, 0.8])


def order_corners(corners: np.ndarray) -> np.ndarray:
    """Return boxes (N, 8, 3) with sorted corners: the floor anticlockwise, then the roof above it.

    The order in `corners` does not matter. The four lowest corners form the floor, even in a box
    of the wrong shape, which is drawn as it is.
    """
    corners = np.asarray(corners, dtype=float)
    by_height = np.take_along_axis(
        corners, np.argsort(corners[:, :, 2], axis=1, kind="stable")[..., None], axis=1
    )
    floor, roof = _sorted_by_angle(by_height[:, :4]), _sorted_by_angle(by_height[:, 4:])
    # Floor and roof may begin at different corners, so the roof is rotated to fit the floor best.
    turns = np.stack([np.roll(roof, -turn, axis=1) for turn in range(4)])
    distances = np.linalg.norm(turns - floor, axis=-1).sum(axis=-1)
    best = distances.argmin(axis=0)
    return np.concatenate([floor, turns[best, np.arange(len(floor))]], axis=1)


def _sorted_by_angle(ring: np.ndarray) -> np.ndarray:
    """Return corners (N, 4, 3), sorted by their direction from the centre."""
    spokes = ring[:, :, :2] - ring[:, :, :2].mean(axis=1, keepdims=True)
    angles = np.arctan2(spokes[..., 1], spokes[..., 0])
    return np.take_along_axis(ring, np.argsort(angles, axis=1, kind="stable")[..., None], axis=1)


def edges_of(corners: np.ndarray) -> np.ndarray:
    """Return the twelve edges of each ordered box, shape (12 N, 2, 3)."""
    return corners[:, EDGES].reshape(-1, 2, 3)


def faces_of(corners: np.ndarray) -> np.ndarray:
    """Return the twelve triangles of each ordered box, shape (12 N, 3, 3)."""
    return corners[:, TRIANGLES].reshape(-1, 3, 3)


def shaded_colours(triangles: np.ndarray, colour: np.ndarray) -> np.ndarray:
    """Return the colours (m, 3) of triangles under one light; facing triangles are brightest."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    facing = normals / np.maximum(lengths, 1e-12) @ LIGHT
    return np.clip((0.72 + 0.28 * facing)[:, None] * colour, 0, 255).astype(np.uint8)


def upright_box(minimum: Iterable[float], maximum: Iterable[float]) -> np.ndarray:
    """Return the corners (8, 3) of an axis-aligned box: the floor anticlockwise, then the roof."""
    (x, y, z), (far_x, far_y, far_z) = minimum, maximum
    floor = [(x, y), (far_x, y), (far_x, far_y), (x, far_y)]
    return np.array([(*place, height) for height in (z, far_z) for place in floor], dtype=float)


def block_car(corners: np.ndarray) -> np.ndarray:
    """Return a car of two blocks (2, 8, 3) that fills an ordered box (8, 3).

    The lower block has the full length and two thirds of the height. The upper block is half as
    long. The length of the car is along the longer side of the floor.
    """
    floor, roof = corners[:4], corners[4:]
    if np.linalg.norm(floor[1] - floor[0]) < np.linalg.norm(floor[2] - floor[1]):
        floor, roof = np.roll(floor, -1, axis=0), np.roll(roof, -1, axis=0)
    waist = floor + (roof - floor) * 2 / 3
    # Corners 0 and 1 are the ends of one long side, corners 3 and 2 of the other.
    other_end = [1, 0, 3, 2]

    def shortened(ring: np.ndarray) -> np.ndarray:
        return 0.75 * ring + 0.25 * ring[other_end]

    cabin = np.concatenate([shortened(waist), shortened(roof)])
    return np.stack([np.concatenate([floor, waist]), cabin])


def rectangle(x: tuple[float, float], y: tuple[float, float], height: float) -> np.ndarray:
    """Return a horizontal rectangle at some height as two triangles (2, 3, 3) that face upwards."""
    ring = np.array([(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])])
    ring = np.column_stack([ring, np.full(4, float(height))])
    return ring[[[0, 1, 2], [0, 2, 3]]]


def plane_patch(
    plane: Sequence[float] | np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the part of the plane a x + b y + c z + d = 0 that is near points (n, 3).

    Returns
    -------
    triangles : ndarray, shape (2, 3, 3)
    grid : ndarray, shape (18, 2, 3)
        Segments of a grid of 8 by 8 cells.
    """
    normal = np.asarray(plane[:3], dtype=float)
    length = np.linalg.norm(normal)
    if len(plane) != 4 or not np.isfinite(plane).all() or length == 0:
        raise ValueError(
            "A plane is four finite numbers (a, b, c, d) with (a, b, c) not all zero; "
            f"yours is {plane!r}."
        )
    normal, distance = normal / length, float(plane[3]) / length
    # The first direction follows x if possible, so that a road's grid is aligned with the road.
    helper = (0, 1, 0) if abs(normal[0]) > 0.9 else (1, 0, 0)
    along = np.asarray(helper) - normal * (normal @ helper)
    along /= np.linalg.norm(along)
    across = np.cross(normal, along)
    origin = -distance * normal
    flat = (points - origin) @ np.stack([along, across], axis=1)
    low, high = (flat.min(axis=0), flat.max(axis=0)) if len(flat) else ([-10, -10], [10, 10])

    def to_space(u: ArrayLike, v: ArrayLike) -> np.ndarray:
        u, v = np.broadcast_arrays(u, v)
        return origin + u[..., None] * along + v[..., None] * across

    corners = to_space(
        np.array([low[0], high[0], high[0], low[0]]), np.array([low[1], low[1], high[1], high[1]])
    )
    steps = np.linspace(0, 1, 9)
    u, v = (low[k] + (high[k] - low[k]) * steps for k in (0, 1))
    grid = [
        np.stack([to_space(u, low[1]), to_space(u, high[1])], axis=1),
        np.stack([to_space(low[0], v), to_space(high[0], v)], axis=1),
    ]
    return corners[[[0, 1, 2], [0, 2, 3]]], np.concatenate(grid)


class Cut(NamedTuple):
    """A rectangle with corners (4, 3), where a node of a kd-tree cuts its cell across `axis`."""

    axis: int
    corners: np.ndarray


def kd_cuts(root: Node | None, minimum: ArrayLike, maximum: ArrayLike, depth: int) -> Iterator[Cut]:
    """Yield the cuts of the first `depth` levels of a kd-tree, parents first.

    The cuts of a two-dimensional tree reach from the bottom of the region to its top. A wrong tree
    is drawn as it is: a node outside its cell cuts at the border, and a loop is followed once.
    """
    waiting, seen = [(root, 0, np.array(minimum, float), np.array(maximum, float))], set()
    while waiting:
        node, level, low, high = waiting.pop(0)
        if node is None or level >= depth or id(node) in seen:
            continue
        seen.add(id(node))
        point = np.ravel(np.asarray(node.point, dtype=float))
        axis = level % min(len(point), 3)
        position = np.clip(point[axis], low[axis], high[axis])
        first, second = (dimension for dimension in range(3) if dimension != axis)
        corners = np.empty((4, 3))
        corners[:, axis] = position
        corners[:, first] = np.array([low, high, high, low])[:, first]
        corners[:, second] = np.array([low, low, high, high])[:, second]
        yield Cut(axis, corners)
        upper, lower = high.copy(), low.copy()
        upper[axis] = lower[axis] = position
        waiting += [(node.left, level + 1, low, upper), (node.right, level + 1, lower, high)]
