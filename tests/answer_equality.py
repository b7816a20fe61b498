"""Compare two answers to an exercise as loosely as the exercise's docstring allows.

A list may replace an array, because the lessons only add a note and deduct no points for it. The
sign of a normal, the order of cells, corners and found indices, and the cluster labels may differ.
"""

import math

import numpy as np
from scipy.spatial import cKDTree

from utils.boxes.containment import distance_outside
from utils.checks.boxes import footprint

ANGLE_TOLERANCE = 6.0  # degrees; a search in steps of five degrees is allowed
TOLERANCE = {"rtol": 1e-6, "atol": 1e-7}


def compare_arrays(answer, expected):
    """Compare shapes, and numbers within a tolerance; empty arrays only need the same length."""
    answer, expected = np.asarray(answer), np.asarray(expected)
    if object in (answer.dtype, expected.dtype):
        return answer.shape == expected.shape and bool(np.all(answer == expected))
    if answer.size == expected.size == 0:
        return (
            len(answer) == len(expected)
            if answer.ndim and expected.ndim
            else answer.ndim == expected.ndim
        )
    return answer.shape == expected.shape and np.allclose(
        answer, expected, **TOLERANCE, equal_nan=True
    )


def compare_models(answer, expected):
    """Compare two lines or planes up to a common sign; either may be None."""
    if answer is None or expected is None:
        return answer is expected
    answer, expected = np.asarray(answer, dtype=float), np.asarray(expected, dtype=float)
    # Single precision is allowed, even if the points are only a few centimetres apart.
    return answer.shape == expected.shape and any(
        np.allclose(answer, sign * expected, rtol=1e-4, atol=1e-4) for sign in (1, -1)
    )


def compare_rows(answer, expected):
    """Compare rows in any order."""
    answer, expected = (np.asarray(array, dtype=float) for array in (answer, expected))
    if answer.shape != expected.shape or answer.size == 0:
        return compare_arrays(answer, expected)
    if not (np.isfinite(answer).all() and np.isfinite(expected).all()):
        return compare_arrays(answer, expected)
    apart = max(
        cKDTree(tree).query(to)[0].max() for tree, to in ((answer, expected), (expected, answer))
    )
    return bool(apart < 1e-6 * (1 + np.abs(expected).max()))


def compare_partitions(answer, expected):
    """Compare clusterings up to their labels; label 0 marks points outside every cluster."""
    answer, expected = np.asarray(answer), np.asarray(expected)
    if answer.shape != expected.shape or not np.array_equal(answer == 0, expected == 0):
        return False
    pairs = {*zip(answer.tolist(), expected.tolist(), strict=True)}
    return len(pairs) == len({mine for mine, _ in pairs}) == len({right for _, right in pairs})


def compare_corners(answer, expected):
    """Compare lists of boxes; the corners of each box may be in any order."""
    answer, expected = np.asarray(answer, dtype=float), np.asarray(expected, dtype=float)
    if answer.shape != expected.shape or answer.size == 0:
        return compare_arrays(answer, expected)
    return all(map(compare_rows, answer, expected))


def compare_axes(answer, expected, points):
    """Accept right-handed, orthonormal axes if the points have the expected variance along each."""
    answer, points = np.asarray(answer, dtype=float), np.asarray(points, dtype=float)[:, :3]
    if answer.shape != (3, 3) or not np.allclose(answer.T @ answer, np.eye(3), atol=1e-6):
        return False
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) == 0:
        return np.linalg.det(answer) > 0
    spreads = [np.var(points @ directions, axis=0) for directions in (answer, expected)]
    size = 1e-6 * max(np.abs(points).max(initial=0), 1.0) ** 2
    return np.linalg.det(answer) > 0 and np.allclose(*spreads, rtol=1e-6, atol=size)


def compare_upright_boxes(answer, expected, cloud, cluster_labels):
    """Accept upright boxes around the same points if each box has an acceptable orientation.

    Sizes are not compared, because every box must end at its outermost points.
    """
    answer, expected = np.asarray(answer, dtype=float), np.asarray(expected, dtype=float)
    if answer.shape != expected.shape or answer.size == 0:
        return compare_arrays(answer, expected)
    labels, cloud = np.asarray(cluster_labels), np.asarray(cloud, dtype=float)
    for mine, right, label in zip(answer, expected, np.unique(labels[labels > 0]), strict=True):
        floor, points = footprint(mine), cloud[labels == label, :3]
        heights = np.sort(mine[:, 2]), np.sort(right[:, 2])
        if floor is None or not np.allclose(*heights, atol=1e-6):
            return False
        if distance_outside(points[:, :2], floor).max() > 1e-4:
            return False
        if not is_filled(points[:, :2], floor):
            return False
        if not (
            has_same_orientation(floor, footprint(right)) or is_hardly_larger(points[:, :2], floor)
        ):
            return False
    return True


def sides_of(rectangle):
    """Return two adjacent sides of a rectangle as vectors."""
    return np.diff(rectangle[:3], axis=0)


def has_same_orientation(first, second):
    """Return whether two rectangles have parallel sides, within `ANGLE_TOLERANCE`."""
    first, second = (
        np.degrees(np.arctan2(*max(sides_of(rectangle), key=np.linalg.norm)[::-1]))
        for rectangle in (first, second)
    )
    return abs((first - second + 45) % 90 - 45) <= ANGLE_TOLERANCE


def is_hardly_larger(points, rectangle):
    """Return whether a rectangle is hardly larger than one with a standard orientation.

    Standard orientations are the orientations of the smallest rectangle, the narrowest one, the
    first principal axis, and the sides closest to the points, as in the lesson. If they
    agree, any other orientation results in a larger rectangle. If they do not, the orientation is
    not defined. If several orientations are equally close, rounding decides, so all are standard.
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
    closeness = (1 / (np.minimum(*inside) + 0.05)).sum(axis=0)
    areas = widths * lengths
    closest = closeness > (1 - 1e-6) * closeness.max()
    good = max(areas.min(), areas[widths.argmin()], areas[-1], areas[closest].max())
    return np.prod(np.linalg.norm(sides_of(rectangle), axis=1)) <= 1.1 * good + 0.1


def is_filled(points, rectangle):
    """Return whether the points fill a rectangle from side to side."""
    for side in sides_of(rectangle):
        length = np.linalg.norm(side)
        if length > 1e-4 and np.ptp(points @ side) / length < length - 1e-4:
            return False
    return True


def compare_fitted_models(answer, expected, points, max_iterations, distance_tolerance, rng=None):
    """Accept any normalised model with its own inliers; None matches only None.

    The model found depends on the random draws. One sample too many, as in
    ``range(max_iterations + 1)``, is accepted because it does no harm. The checks themselves
    reject answers that draw one sample too few or far too many.
    """
    (model, mask), (right, _) = answer, expected
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


def compare_orders(answer, expected, points):
    """Accept an order of all rows in which each part starts with its lower median.

    If points share a coordinate, several orders are right, so any order is accepted.
    """
    order, points = [int(row) for row in answer], np.asarray(points)
    if sorted(order) != sorted(map(int, expected)):
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


def compare_numbers(answer, expected):
    """Compare numbers of iterations; all numbers that are too large to run count as equal."""
    never = [value is None or bool(np.asarray(value) >= 1e9) for value in (answer, expected)]
    return all(never) or compare_arrays(answer, expected)


def compare_indices(answer, expected, tree, target, tolerance):
    """Compare indices in any order; accept any indices in a tree that insertion cannot build.

    Some checks attach points in wrong places to see how far a search goes. An answer that searches
    more of such a tree is slow but not wrong. A point whose distance equals the tolerance may be
    missing, because no points depend on it.
    """
    found, right = sorted(map(int, answer)), sorted(map(int, expected))
    on_border = {
        node.index
        for node in nodes_of(tree.root)
        if math.isclose(math.dist(node.point, target), tolerance)
    }
    found, right = ([index for index in row if index not in on_border] for row in (found, right))
    return found == right or not is_in_order(tree.root)


def nodes_of(root):
    """Yield all nodes of a tree."""
    waiting = [root]
    while waiting:
        node = waiting.pop()
        if node is not None:
            yield node
            waiting += [node.left, node.right]


def is_in_order(root):
    """Return whether insertion could have built the tree (smaller left, equal or larger right)."""
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


def compare_values(answer, expected):
    """Compare any two answers by value, including the attributes of tree nodes."""
    if hasattr(answer, "__dict__"):
        return type(answer).__name__ == type(expected).__name__ and compare_values(
            vars(answer), vars(expected)
        )
    if isinstance(answer, dict) and isinstance(expected, dict):
        return answer.keys() == expected.keys() and all(
            compare_values(answer[key], expected[key]) for key in answer
        )
    if isinstance(answer, np.random.Generator):
        return True  # a right answer may draw different numbers
    if answer is None or expected is None or isinstance(answer, str) or isinstance(expected, str):
        return answer is expected or answer == expected
    return compare_arrays(answer, expected)


COMPARISONS = {
    "insert": lambda answer, expected: True,  # `insert` changes the tree and returns nothing
    "line_through": compare_models,
    "plane_through": compare_models,
    "fit_plane": compare_models,
    "iterations_needed": compare_numbers,
    "voxel_grid": compare_rows,
    "euclidean_clustering": compare_partitions,
    "euclidean_clustering_accelerated": compare_partitions,
    "get_bounding_boxes": compare_corners,
}
COMPARISONS_WITH_ARGUMENTS = {
    "search": compare_indices,
    "median_order": compare_orders,
    "principal_axes": compare_axes,
    "get_oriented_boxes": compare_upright_boxes,
    "ransac_line": compare_fitted_models,
    "ransac_plane": compare_fitted_models,
}


def is_equivalent(exercise, call, answer, expected):
    """Return whether an answer to a call is as good as the expected one.

    If a call raised an exception, its answer is the exception's type.
    """
    if isinstance(answer, type) or isinstance(expected, type):
        return answer is expected
    try:
        if exercise in COMPARISONS_WITH_ARGUMENTS:
            arguments, keywords = call
            return bool(
                COMPARISONS_WITH_ARGUMENTS[exercise](answer, expected, *arguments, **keywords)
            )
        return bool(COMPARISONS.get(exercise, compare_values)(answer, expected))
    except (TypeError, ValueError, IndexError):
        return False
