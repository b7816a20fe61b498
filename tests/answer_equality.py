"""Whether two answers are the same, as far as the docstring of an exercise says what to return.

A list for an array is let be: the lessons note it, and take no points. So is the sign of a normal,
the order of cells, of corners, of what is found, and the numbers that clusters have.
"""

import numpy as np
from scipy.spatial import cKDTree

from utils.boxes.containment import distance_outside
from utils.checks.boxes import footprint

CROOKED = 6.0  # degrees: a search in steps of five is allowed
MICRO = {"rtol": 1e-6, "atol": 1e-7}


def arrays(one, other):
    """The same shape and, nearly, the same numbers; nothing has no shape in a list."""
    one, other = np.asarray(one), np.asarray(other)
    if object in (one.dtype, other.dtype):
        return one.shape == other.shape and bool(np.all(one == other))
    if one.size == other.size == 0:
        return len(one) == len(other) if one.ndim and other.ndim else one.ndim == other.ndim
    return one.shape == other.shape and np.allclose(one, other, **MICRO, equal_nan=True)


def models(one, other):
    """Lines or planes, or None; the sign of all numbers is free."""
    if one is None or other is None:
        return one is other
    one, other = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    # Single precision may do, also where the points lie a hand's breadth apart.
    return one.shape == other.shape and any(
        np.allclose(one, sign * other, rtol=1e-4, atol=1e-4) for sign in (1, -1)
    )


def rows(one, other):
    """The same rows in any order."""
    one, other = (np.asarray(answer, dtype=float) for answer in (one, other))
    if one.shape != other.shape or one.size == 0:
        return arrays(one, other)
    if not (np.isfinite(one).all() and np.isfinite(other).all()):
        return arrays(one, other)
    apart = max(cKDTree(of).query(to)[0].max() for of, to in ((one, other), (other, one)))
    return bool(apart < 1e-6 * (1 + np.abs(other).max()))


def partitions(one, other):
    """The same clusters under other numbers, of which 0 is none."""
    one, other = np.asarray(one), np.asarray(other)
    if one.shape != other.shape or not np.array_equal(one == 0, other == 0):
        return False
    pairs = {*zip(one.tolist(), other.tolist(), strict=True)}
    return len(pairs) == len({mine for mine, _ in pairs}) == len({right for _, right in pairs})


def corners(one, other):
    """The same boxes, each with its corners in any order."""
    one, other = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    if one.shape != other.shape or one.size == 0:
        return arrays(one, other)
    return all(map(rows, one, other))


def axes(one, other, points):
    """Right-handed and orthonormal, with the same spread along each."""
    one, points = np.asarray(one, dtype=float), np.asarray(points, dtype=float)[:, :3]
    if one.shape != (3, 3) or not np.allclose(one.T @ one, np.eye(3), atol=1e-6):
        return False
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) == 0:
        return np.linalg.det(one) > 0
    spreads = [np.var(points @ each, axis=0) for each in (one, other)]
    size = 1e-6 * max(np.abs(points).max(initial=0), 1.0) ** 2
    return np.linalg.det(one) > 0 and np.allclose(*spreads, rtol=1e-6, atol=size)


def snug(one, other, cloud, cluster_labels):
    """Upright boxes around the same points, each turned in one of the ways that are good.

    Sizes follow from that: a box reaches no farther than its points.
    """
    one, other = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    if one.shape != other.shape or one.size == 0:
        return arrays(one, other)
    labels, cloud = np.asarray(cluster_labels), np.asarray(cloud, dtype=float)
    for mine, right, label in zip(one, other, np.unique(labels[labels > 0]), strict=True):
        floor, points = footprint(mine), cloud[labels == label, :3]
        heights = np.sort(mine[:, 2]), np.sort(right[:, 2])
        if floor is None or not np.allclose(*heights, atol=1e-6):
            return False
        if distance_outside(points[:, :2], floor).max() > 1e-4:
            return False
        if not reaches_no_farther(points[:, :2], floor):
            return False
        if not (is_turned_as(floor, footprint(right)) or is_no_looser(points[:, :2], floor)):
            return False
    return True


def sides_of(rectangle):
    """Two sides, as vectors."""
    return np.diff(rectangle[:3], axis=0)


def is_turned_as(one, other):
    """Whether a side of a rectangle runs as one of another does."""
    one, other = (
        np.degrees(np.arctan2(*max(sides_of(rectangle), key=np.linalg.norm)[::-1]))
        for rectangle in (one, other)
    )
    return abs((one - other + 45) % 90 - 45) <= CROOKED


def is_no_looser(points, rectangle):
    """Whether it covers hardly more ground than one that is turned in a good way.

    As the smallest rectangle, as the narrowest, as the first axis, or with its sides near the
    points (Zhang et al., IV 2017). Where these agree, one that is turned otherwise is larger than
    all; where they do not, nothing says how it has to be turned.
    """
    turns = np.arange(0, 180, 0.5)
    if len(points) > 1:
        first = np.linalg.eigh(np.cov(points.T))[1][:, -1]
        turns = np.append(turns, np.degrees(np.arctan2(first[1], first[0])))
    along = np.exp(-1j * np.radians(turns)) * (points @ [1, 1j])[:, None]
    widths, lengths = np.ptp(along.real, axis=0), np.ptp(along.imag, axis=0)
    inside = [
        np.minimum(place - place.min(axis=0), place.max(axis=0) - place)
        for place in (along.real, along.imag)
    ]
    closeness = (1 / np.maximum(np.minimum(*inside), 0.05)).sum(axis=0)
    areas = widths * lengths
    good = max(areas.min(), areas[widths.argmin()], areas[-1], areas[closeness.argmax()])
    return np.prod(np.linalg.norm(sides_of(rectangle), axis=1)) <= 1.1 * good + 0.1


def reaches_no_farther(points, rectangle):
    """Whether the points fill a rectangle from side to side."""
    for side in sides_of(rectangle):
        length = np.linalg.norm(side)
        if length > 1e-4 and np.ptp(points @ side) / length < length - 1e-4:
            return False
    return True


def fitted(one, other, points, max_iterations, distance_tolerance, rng=None):
    """A model and its own inliers, and both or neither; which it is depends on the draws.

    So does one that comes of a sample more than was told, as of ``range(max_iterations + 1)``: it
    is no worse. A sample too few is asked for by checks, and so are many too many.
    """
    (model, mask), (right, _) = one, other
    if model is None or right is None:
        return model is right and not np.any(mask)
    model, points = np.asarray(model, dtype=float), np.asarray(points, dtype=float)
    distances = np.abs(points[:, : len(model) - 1] @ model[:-1] + model[-1])
    clear = np.abs(distances - distance_tolerance) > 1e-9
    return (
        np.isclose(np.linalg.norm(model[:-1]), 1.0)
        and np.shape(mask) == (len(points),)
        and np.array_equal(np.asarray(mask)[clear], (distances <= distance_tolerance)[clear])
    )


def balanced(one, other, points):
    """Every row once, and before all others of its part the lower median along its axis.

    Among points of which some are alike along an axis, more than one part is right: those are let
    be.
    """
    order, points = [int(row) for row in one], np.asarray(points)
    if sorted(order) != sorted(map(int, other)):
        return False
    if any(len({*along}) < len(points) for along in points.T.tolist()):
        return True
    parts = [(order, 0)]
    while parts:
        part, depth = parts.pop()
        if part:
            along = points[part, depth % points.shape[1]]
            if along[0] != np.sort(along)[(len(part) - 1) // 2]:
                return False
            rest = [*zip(part[1:], along[1:], strict=True)]
            parts.append(([row for row, value in rest if value < along[0]], depth + 1))
            parts.append(([row for row, value in rest if value > along[0]], depth + 1))
    return True


def numbers(one, other):
    """The same number, or both so large that nobody can play so many rounds."""
    never = [value is None or bool(np.asarray(value) >= 1e9) for value in (one, other)]
    return all(never) or arrays(one, other)


def found(one, other, tree, target, tolerance):
    """The same indices in any order.

    Checks hang points where no insertion would, to see how far a search looks: in such a tree one
    that looks too far is slow and not wrong.
    """
    return sorted(map(int, one)) == sorted(map(int, other)) or not is_in_order(tree.root)


def is_in_order(root):
    """Whether insertion may have built a tree: left is less, right is not."""
    waiting = [(root, 0, ())]
    while waiting:
        node, depth, sides = waiting.pop()
        if node is None:
            continue
        if any((node.point[axis] < split) != is_less for axis, split, is_less in sides):
            return False
        axis = depth % len(node.point)
        split = node.point[axis]
        for child, is_less in ((node.left, True), (node.right, False)):
            waiting.append((child, depth + 1, (*sides, (axis, split, is_less))))
    return True


def anything(one, other):
    """By value; what trees hold, too."""
    if hasattr(one, "__dict__"):
        return type(one).__name__ == type(other).__name__ and anything(vars(one), vars(other))
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(anything(one[key], other[key]) for key in one)
    if isinstance(one, np.random.Generator):
        return True  # who draws otherwise draws as well
    if one is None or other is None or isinstance(one, str) or isinstance(other, str):
        return one is other or one == other
    return arrays(one, other)


BY_EXERCISE = {
    "insert": lambda one, other: True,  # the tree is what counts
    "line_through": models,
    "plane_through": models,
    "fit_plane": models,
    "iterations_needed": numbers,
    "voxel_grid": rows,
    "euclidean_clustering": partitions,
    "euclidean_clustering_accelerated": partitions,
    "get_bounding_boxes": corners,
}
WITH_THE_ARGUMENTS = {
    "search": found,
    "median_order": balanced,
    "principal_axes": axes,
    "get_oriented_boxes": snug,
    "ransac_line": fitted,
    "ransac_plane": fitted,
}


def alike(exercise, call, answer, expected):
    """Whether an answer to a call is as good as the expected one; what it raises is a type."""
    if isinstance(answer, type) or isinstance(expected, type):
        return answer is expected
    try:
        if exercise in WITH_THE_ARGUMENTS:
            arguments, keywords = call
            return bool(WITH_THE_ARGUMENTS[exercise](answer, expected, *arguments, **keywords))
        return bool(BY_EXERCISE.get(exercise, anything)(answer, expected))
    except (TypeError, ValueError, IndexError):
        return False
