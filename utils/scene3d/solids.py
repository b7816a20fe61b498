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
"""Edges of a box whose floor, then roof, go round in the same direction from the same corner."""

QUADS = np.array([(3, 2, 1, 0), (4, 5, 6, 7), *((a, b, b + 4, a + 4) for a, b in RING)])
TRIANGLES = QUADS[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)

LIGHT = np.array([0.35, -0.5, 0.8]) / np.linalg.norm([0.35, -0.5, 0.8])


def ordered(corners: np.ndarray) -> np.ndarray:
    """Boxes (N, 8, 3) with corners in any order: floor anticlockwise, then the roof above it.

    The four lowest corners are the floor, so that a wrong box is drawn as it is.
    """
    corners = np.asarray(corners, dtype=float)
    by_height = np.take_along_axis(
        corners, np.argsort(corners[:, :, 2], axis=1, kind="stable")[..., None], axis=1
    )
    floor, roof = _around(by_height[:, :4]), _around(by_height[:, 4:])
    # The two rings may begin at different corners: turn the roof to fit the floor best.
    turns = np.stack([np.roll(roof, -turn, axis=1) for turn in range(4)])
    gaps = np.linalg.norm(turns - floor, axis=-1).sum(axis=-1)
    best = gaps.argmin(axis=0)
    return np.concatenate([floor, turns[best, np.arange(len(floor))]], axis=1)


def _around(ring: np.ndarray) -> np.ndarray:
    """Corners (N, 4, 3) by their direction from the middle."""
    spokes = ring[:, :, :2] - ring[:, :, :2].mean(axis=1, keepdims=True)
    angles = np.arctan2(spokes[..., 1], spokes[..., 0])
    return np.take_along_axis(ring, np.argsort(angles, axis=1, kind="stable")[..., None], axis=1)


def edges_of(corners: np.ndarray) -> np.ndarray:
    """The twelve edges of each ordered box, shape (12 N, 2, 3)."""
    return corners[:, EDGES].reshape(-1, 2, 3)


def faces_of(corners: np.ndarray) -> np.ndarray:
    """The twelve triangles of each ordered box, shape (12 N, 3, 3)."""
    return corners[:, TRIANGLES].reshape(-1, 3, 3)


def lit(triangles: np.ndarray, colour: np.ndarray) -> np.ndarray:
    """Colours (m, 3) of triangles under one light: brightest where they face it."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    facing = normals / np.maximum(lengths, 1e-12) @ LIGHT
    return np.clip((0.72 + 0.28 * facing)[:, None] * colour, 0, 255).astype(np.uint8)


def upright_box(minimum: Iterable[float], maximum: Iterable[float]) -> np.ndarray:
    """Corners (8, 3) of an axis-aligned box: the floor anticlockwise, then the roof."""
    (x, y, z), (far_x, far_y, far_z) = minimum, maximum
    floor = [(x, y), (far_x, y), (far_x, far_y), (x, far_y)]
    return np.array([(*place, height) for height in (z, far_z) for place in floor], dtype=float)


def block_car(corners: np.ndarray) -> np.ndarray:
    """A car (2, 8, 3) that fills an ordered box: full length below, half of it above two thirds.

    Its length is the longer side of the floor.
    """
    floor, roof = corners[:4], corners[4:]
    if np.linalg.norm(floor[1] - floor[0]) < np.linalg.norm(floor[2] - floor[1]):
        floor, roof = np.roll(floor, -1, axis=0), np.roll(roof, -1, axis=0)
    waist = floor + (roof - floor) * 2 / 3
    # Corners 0 and 1 lie on one long side, 3 and 2 opposite them on the other.
    opposite = [1, 0, 3, 2]

    def shortened(ring: np.ndarray) -> np.ndarray:
        return 0.75 * ring + 0.25 * ring[opposite]

    cabin = np.concatenate([shortened(waist), shortened(roof)])
    return np.stack([np.concatenate([floor, waist]), cabin])


def rectangle(x: tuple[float, float], y: tuple[float, float], height: float) -> np.ndarray:
    """Two triangles (2, 3, 3) that face upwards."""
    ring = np.array([(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])])
    ring = np.column_stack([ring, np.full(4, float(height))])
    return ring[[[0, 1, 2], [0, 2, 3]]]


def plane_patch(
    plane: Sequence[float] | np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The part of a x + b y + c z + d = 0 near points (n, 3): triangles and a grid of segments."""
    normal = np.asarray(plane[:3], dtype=float)
    length = np.linalg.norm(normal)
    if len(plane) != 4 or not np.isfinite(plane).all() or length == 0:
        raise ValueError(
            "A plane is four finite numbers (a, b, c, d) with (a, b, c) not all zero; "
            f"yours is {plane!r}."
        )
    normal, distance = normal / length, float(plane[3]) / length
    # Two directions in the plane: x as far as possible, so that a road's grid follows the road.
    helper = (0, 1, 0) if abs(normal[0]) > 0.9 else (1, 0, 0)
    along = np.asarray(helper) - normal * (normal @ helper)
    along /= np.linalg.norm(along)
    across = np.cross(normal, along)
    origin = -distance * normal
    flat = (points - origin) @ np.stack([along, across], axis=1)
    low, high = (flat.min(axis=0), flat.max(axis=0)) if len(flat) else ([-10, -10], [10, 10])

    def lifted(u: ArrayLike, v: ArrayLike) -> np.ndarray:
        u, v = np.broadcast_arrays(u, v)
        return origin + u[..., None] * along + v[..., None] * across

    corners = lifted(
        np.array([low[0], high[0], high[0], low[0]]), np.array([low[1], low[1], high[1], high[1]])
    )
    steps = np.linspace(0, 1, 9)
    u, v = (low[k] + (high[k] - low[k]) * steps for k in (0, 1))
    grid = [
        np.stack([lifted(u, low[1]), lifted(u, high[1])], axis=1),
        np.stack([lifted(low[0], v), lifted(high[0], v)], axis=1),
    ]
    return corners[[[0, 1, 2], [0, 2, 3]]], np.concatenate(grid)


class Cut(NamedTuple):
    """The rectangle (4, 3) in which a node of a kd-tree divides its region, square to `axis`."""

    axis: int
    corners: np.ndarray


def kd_cuts(root: Node | None, minimum: ArrayLike, maximum: ArrayLike, depth: int) -> Iterator[Cut]:
    """The cuts of the first `depth` levels of a kd-tree, parents first.

    A tree over two dimensions cuts from the floor of the region to its roof. A wrong tree is
    drawn as it is: a node outside its region cuts at the region's border, a loop is walked once.
    """
    waiting, seen = [(root, 0, np.array(minimum, float), np.array(maximum, float))], set()
    while waiting:
        node, level, low, high = waiting.pop(0)
        if node is None or level >= depth or id(node) in seen:
            continue
        seen.add(id(node))
        point = np.ravel(np.asarray(node.point, dtype=float))
        axis = level % min(len(point), 3)
        at = np.clip(point[axis], low[axis], high[axis])
        first, second = (other for other in range(3) if other != axis)
        corners = np.empty((4, 3))
        corners[:, axis] = at
        corners[:, first] = np.array([low, high, high, low])[:, first]
        corners[:, second] = np.array([low, low, high, high])[:, second]
        yield Cut(axis, corners)
        upper, lower = high.copy(), low.copy()
        upper[axis] = lower[axis] = at
        waiting += [(node.left, level + 1, low, upper), (node.right, level + 1, lower, high)]
