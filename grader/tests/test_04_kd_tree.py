"""Hidden tests of lesson 04. Titles and hints are shown to students; the code is not.

Trees for `search` are planted ready-made where the student's class allows it, so that each
exercise stands on its own; and a tree crosses the pipe in one message.
"""

import copy

import numpy as np
import pytest

from grader.judging import samples
from grader.judging.marks import hidden, visible_checks
from utils.checks.lesson_04 import (
    assert_found,
    assert_lower_medians,
    assert_pruned,
    assert_shallow,
    assert_tree,
    grown,
    leaves_within_reach,
    planted,
    table_of,
)
from utils.checks.vocabulary import CheckFailed, assert_untouched


@visible_checks("insert", "search", "median_order")
def test_visible(student, check):
    check.run(student.median_order if check.exercise == "median_order" else student.KdTree)


def inserted(student, points, indices=None):
    tree = student.KdTree()
    for index, point in zip(indices or range(len(points)), copy.copy(points), strict=True):
        tree.insert(point, index)
    return tree


def distinct(rng, n, k):
    """n points of which no two share a coordinate, in random order; (n, k)."""
    return (np.stack([rng.permutation(4 * n)[:n] for _ in range(k)], axis=1) - 2 * n) / 16 + 0.01


def order_of_medians(points):
    """Rows of points in an order that makes a balanced tree."""

    def parts(rows, axis):
        rows = sorted(rows, key=lambda row: points[row][axis])
        middle = len(rows) // 2
        if rows:
            yield rows[middle]
            yield from parts(rows[:middle], (axis + 1) % len(points[0]))
            yield from parts(rows[middle + 1 :], (axis + 1) % len(points[0]))

    return list(parts(range(len(points)), 0))


def balanced(points):
    """A right tree of little depth."""
    order = order_of_medians(points)
    return grown(np.asarray(points)[order], order)


# ---------------------------------------------------------------------------------- insert


@hidden(
    "insert",
    weight=4,
    title="Right in the plane, for points you have not seen",
    hint="At each node compare one coordinate: x at even depths, y at odd ones.",
)
def test_plane(student, seed):
    points = distinct(np.random.default_rng(seed), 40, 2)
    assert_tree(inserted(student, points), points)


@hidden(
    "insert",
    weight=4,
    title="Right in space: x, y, z, x, y, z, ...",
    hint="The number of axes is len(point).",
)
def test_space(student, seed):
    points = samples.obstacles_of_street(seed, 40)[:, :3]
    assert_tree(inserted(student, points), points)


@hidden(
    "insert",
    weight=3,
    title="Right where coordinates are equal and points repeat",
    hint="Equal is not smaller, so it goes right, at every depth.",
)
def test_equal_coordinates(student, seed):
    points = np.random.default_rng(seed).integers(0, 4, (30, 2)).astype(float)
    assert_tree(inserted(student, points), points)


@hidden(
    "insert",
    weight=2,
    title="Right for lists, tuples and single precision, and any index",
    hint="Keep the point and the index as they are given.",
)
def test_notations(student, seed):
    rng = np.random.default_rng(seed)
    points = distinct(rng, 12, 3)
    indices = rng.permutation(1000)[:12].tolist()
    single = points.astype(np.float32)
    assert_tree(inserted(student, points.tolist(), indices), points, indices)
    assert_tree(inserted(student, [tuple(p) for p in points.tolist()], indices), points, indices)
    assert_tree(inserted(student, single, indices), single, indices)


@hidden(
    "insert",
    weight=2,
    title="Goes on with a tree that exists, and trees do not share nodes",
    hint="All that is known about a tree hangs on its root: nothing may be kept outside.",
)
def test_two_trees(student, seed):
    points = distinct(np.random.default_rng(seed), 20, 2)
    first = planted(student.KdTree, grown(points[:10]))
    second = student.KdTree()
    for row in range(10, 20):
        first.insert(points[row].copy(), row)
        second.insert(points[row].copy(), row)
    assert_tree(first, points)
    assert_tree(second, points[10:], list(range(10, 20)))


# ---------------------------------------------------------------------------------- search


def assert_searches(student, points, root, rng, number=15):
    """Searches of all sizes, at least a thousandth of a metre clear of any point."""
    points = np.asarray(points, dtype=float)
    tree = planted(student.KdTree, root)
    for _ in range(number):
        target = points[rng.integers(len(points))] + rng.normal(0, 0.3, points.shape[1])
        distances = np.sort(np.linalg.norm(points - target, axis=1))
        # Somewhere after the first few neighbours there is a gap: there the circle ends.
        gaps = np.flatnonzero(np.diff(distances) > 4e-3)
        beyond = gaps[gaps >= rng.geometric(0.1)]
        last = beyond[0] if len(beyond) else len(points) - 1
        tolerance = float(distances[last]) + 2e-3
        assert_found(tree, root, target, tolerance)


@hidden(
    "search",
    weight=5,
    title="Right in the plane, for trees and targets you have not seen",
    hint="Compare with a search that leaves nothing out: which point is missing, and at which "
    "node was it cut off?",
)
def test_search_plane(student, seed):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-10, 10, (250, 2))
    assert_searches(student, points, balanced(points), rng)


@hidden(
    "search",
    weight=5,
    title="Right in space, on a street you have not seen",
    hint="The axis at a node is depth % len(target).",
)
def test_search_street(student, seed):
    rng = np.random.default_rng(seed)
    points = samples.obstacles_of_street(seed, 300)[:, :3]
    assert_searches(student, points, balanced(points), rng)


@hidden(
    "search",
    weight=3,
    title="Right in crooked trees, with equal coordinates and equal points",
    hint="Equal stands on the right. A tree that is not balanced is searched in the same way.",
)
def test_search_crooked(student, seed):
    rng = np.random.default_rng(seed)
    points = rng.integers(-6, 7, (120, 2)) / 2
    assert_searches(student, points, grown(points), rng)
    points = np.sort(rng.uniform(-10, 10, (150, 3)), axis=0)
    assert_searches(student, points, grown(points), rng)


@hidden(
    "search",
    weight=4,
    title="Finds what lies at exactly the tolerance, in every direction",
    hint="Right when the box reaches the split (>=); near when the distance is at most the "
    "tolerance (<=).",
)
@pytest.mark.parametrize("k", [2, 3])
def test_search_border(student, seed, k):
    # Whole numbers: all distances along an axis are exact, and 3-4-5 triangles are, too.
    rng = np.random.default_rng(seed + k)
    steps = np.array(np.meshgrid(*[np.arange(-4, 5)] * k)).reshape(k, -1).T.astype(float)
    points = steps[rng.choice(len(steps), 80, replace=False)]
    points = np.vstack([points, 5 * np.eye(k), -5 * np.eye(k), [[3, 4, 0][:k], [-3, -4, 0][:k]]])
    for _ in range(3):
        root = grown(points[rng.permutation(len(points))])
        tree = planted(student.KdTree, root)
        for tolerance in (1.0, 2.0, 5.0):
            assert_found(tree, root, np.zeros(k), tolerance)
            assert_found(tree, root, points[rng.integers(80)], tolerance)


@hidden(
    "search",
    weight=4,
    title="Leaves out what lies beyond the box, at every level",
    hint="Both children need a condition of their own before they are looked at.",
)
def test_search_prunes(student, seed):
    rng = np.random.default_rng(seed)
    tried = 0
    while tried < 6:
        points = rng.uniform(-10, 10, (100, 2 + tried % 2))
        root, tolerance = balanced(points), (1.5, 4.0)[tried % 2]
        target = points[rng.integers(100)] + rng.normal(0, 0.1, 2 + tried % 2)
        traps = pruned_leaves(root, target, tolerance)
        decoys = leaves_within_reach(root, target, tolerance)
        if traps and decoys:
            trap, decoy = traps[rng.integers(len(traps))], decoys[rng.integers(len(decoys))]
            assert_pruned(student.KdTree, root, trap, target, tolerance, decoy)
            tried += 1


def pruned_leaves(root, target, tolerance):
    """Indices of leaves that lie beyond a split that the box does not reach, by a clear margin."""
    leaves, waiting = [], [(root, 0, False)]
    while waiting:
        node, depth, pruned = waiting.pop()
        if node is None:
            continue
        if pruned and node.left is None and node.right is None:
            leaves.append(node.index)
        axis = depth % len(target)
        gap = target[axis] - node.point[axis]
        waiting += [
            (node.left, depth + 1, pruned or gap > 1.2 * tolerance),
            (node.right, depth + 1, pruned or gap < -1.2 * tolerance),
        ]
    return sorted(leaves)


@hidden(
    "search",
    weight=2,
    title="Right for one point, for all points, for any kind of numbers",
    hint="The result holds the index of each node, which need not be its row.",
)
def test_search_extremes(student, seed):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-5, 5, (20, 3))
    root = grown(points, rng.permutation(500)[:20].tolist())
    tree = planted(student.KdTree, root)
    assert_found(tree, root, [0.0, 0.0, 0.0], 50.0)
    assert_found(tree, root, points[7].tolist(), 0.0)
    assert_found(tree, root, points[3].astype(np.float32), 1e-3)
    assert_found(tree, root, [100.0, 0.0, 0.0], 3.0)
    before = table_of(root)
    tree.search(np.zeros(3), 2.0)
    assert_tree_is(tree, before)
    one = grown(points[:1])
    assert_found(planted(student.KdTree, one), one, points[0] + [0.0, 0.0, 1.0], 1.5)


def assert_tree_is(tree, table):
    """A search leaves the top of the tree as it was."""
    points, left, right, indices = table
    root = tree.root
    if root is None or root.index != indices[0] or not np.allclose(root.point, points[0]):
        raise CheckFailed("search changed the tree. Look, and leave it as it is.")


# ---------------------------------------------------------------------------- median_order


@hidden(
    "median_order",
    weight=5,
    title="The least depth, for points you have not seen",
    hint="Does each part go on with the next axis, also when it came from the right?",
)
@pytest.mark.parametrize("k", [2, 3])
def test_depth(student, seed, k):
    rng = np.random.default_rng(seed + k)
    for n in (2, 3, 5, 8, 16, 31, 32, 77, 200):
        points = distinct(rng, n, k)
        assert_shallow(student.median_order(points.copy()), points)


@hidden(
    "median_order",
    weight=5,
    title="The lower median on top of every part",
    hint="Of m sorted rows the lower median is number (m - 1) // 2, for odd and even m.",
)
@pytest.mark.parametrize("k", [2, 3])
def test_medians(student, seed, k):
    rng = np.random.default_rng(seed + 10 + k)
    for n in (2, 4, 6, 15, 50, 128):
        points = distinct(rng, n, k)
        assert_lower_medians(student.median_order(points.copy()), points)


@hidden(
    "median_order",
    weight=3,
    title="Right on a street you have not seen",
    hint="Nothing about one particular array may stand in the function.",
)
def test_medians_of_street(student, seed):
    points = samples.obstacles_of_street(seed, 500)[:, :3]
    keep = np.logical_and.reduce(
        [
            np.isin(np.arange(len(points)), np.unique(points[:, axis], return_index=True)[1])
            for axis in range(3)
        ]
    )
    points = points[keep]
    order = student.median_order(points.copy())
    assert_shallow(order, points)
    assert_lower_medians(order, points)


@hidden(
    "median_order",
    weight=2,
    title="Right for two points and for single precision",
    hint="Return row numbers of the array that came in.",
)
def test_median_extremes(student, seed):
    rng = np.random.default_rng(seed)
    for points in (np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([[1.0, 2.0], [2.0, 1.0]])):
        assert_lower_medians(student.median_order(points.copy()), points)
    points = np.asfortranarray(distinct(rng, 23, 3).astype(np.float32))
    assert_lower_medians(student.median_order(points.copy()), points)
    assert_untouched(student.median_order, points)
    turn = distinct(rng, 30, 2)
    assert_lower_medians(student.median_order(turn + 1000), turn + 1000)
