"""Hidden tests of lesson 04. Titles and hints are shown to students; the code is not.

Tests of `search` build the tree themselves, so that the exercises are independent; a tree crosses
the pipe in one message. Unless a test is about the radius, it is 1, which equals its square. Unless
a test is about these places, no point is on the rim or in a corner of the box around the circle.
"""

import functools

import numpy as np
import pytest

from extension import samples
from grader.judging.hidden_tests import hidden
from utils.checks.assertions import (
    assert_arguments_unchanged,
    assert_untouched,
    call_each,
    frozen,
    needs,
    observe,
)
from utils.checks.lesson_04.cases import (
    diagonal_points,
    distinct_points,
    is_off_corners,
    is_off_rim,
    nested_points,
)
from utils.checks.lesson_04.insert import require_root
from utils.checks.lesson_04.median_order import assert_halves, assert_lower_medians, assert_shallow
from utils.checks.lesson_04.search import finds_the_rim, leaves_regions_out, looks_on_both_sides
from utils.checks.lesson_04.search_results import assert_found, assert_pruned, assert_same_tree
from utils.checks.lesson_04.trees import assert_indices, assert_tree, build_tree
from utils.geometry import grown, places_of, regions_of


def order_of_medians(points):
    """Return the rows of points in an order of insertion that gives a balanced tree."""

    def parts(rows, axis):
        rows = sorted(rows, key=lambda row: points[row][axis])
        middle = len(rows) // 2
        if rows:
            yield rows[middle]
            yield from parts(rows[:middle], (axis + 1) % len(points[0]))
            yield from parts(rows[middle + 1 :], (axis + 1) % len(points[0]))

    return list(parts(range(len(points)), 0))


def balanced(points):
    """Return a right tree of minimal depth."""
    order = order_of_medians(points)
    return grown(np.asarray(points)[order], order)


# ---------------------------------------------------------------------------------- insert


def inserted(student, points, indices=None):
    require_root(student.KdTree)
    tree = student.KdTree()
    call_each(tree.insert, zip(points, indices or range(len(points)), strict=True))
    return tree


@hidden(
    "insert",
    weight=9,
    title="Right in the plane, for points you have not seen",
    hint="At each node compare one coordinate: x at even depths, y at odd ones.",
)
def test_plane(student, seed):
    points = distinct_points(np.random.default_rng(seed), 40, 2)
    assert_tree(inserted(student, points), points)


@hidden(
    "insert",
    weight=9,
    title="Right in space: x, y, z, x, y, z, ...",
    hint="The number of axes is len(point).",
)
def test_space(student, seed):
    # float32 values compare alike even if an answer stores points in single precision.
    street = samples.obstacles_of_street(seed, 80)[:, :3].astype(np.float32)
    alone = [np.unique(street[:, axis], return_index=True)[1] for axis in range(3)]
    points = street[sorted(set(alone[0]) & set(alone[1]) & set(alone[2]))][:40].astype(float)
    assert_tree(inserted(student, points), points)


@hidden(
    "insert",
    weight=7,
    title="Right where coordinates are equal and points repeat",
    hint="Equal is not smaller, so it goes right, at every depth.",
)
def test_equal_coordinates(student, seed):
    rng = np.random.default_rng(seed)
    points = diagonal_points(rng.integers(0, 6, 30), 2 + seed % 2)
    assert_tree(inserted(student, points), points)
    for y in (-2.0, 2.0):
        points = np.array([[1.0, 4.0], [1.0, 4.0 + y], [-3.0, 4.0 + y]])
        assert_tree(inserted(student, points), points)


@hidden(
    "insert",
    weight=1,
    title="Right for lists, tuples and single precision",
    hint="Take the coordinates as they are given, one by one.",
)
def test_notations(student, seed):
    points = diagonal_points(np.random.default_rng(seed).permutation(12) / 4, 3)
    for kind in (points.tolist(), list(map(tuple, points.tolist())), points.astype(np.float32)):
        assert_tree(inserted(student, kind), points, either_way=True)


@hidden(
    "insert",
    weight=8,
    title="Keeps whatever index comes with a point",
    hint="Pass it on to Node.",
)
def test_indices(student, seed):
    rng = np.random.default_rng(seed)
    points = diagonal_points(rng.permutation(12) / 4)
    indices = rng.permutation(1000)[:12].tolist()
    tree = inserted(student, points, indices)
    with needs("every point is where it belongs"):
        assert_tree(tree, points, indices, either_way=True)
    assert_indices(tree, points, indices)


@hidden(
    "insert",
    weight=2,
    title="Goes on with a tree that exists, and trees do not share nodes",
    hint="The walk begins at the root of the tree that was passed, and all that is known about "
    "a tree hangs on that.",
)
def test_two_trees(student, seed):
    points = diagonal_points(np.random.default_rng(seed).permutation(20) / 4)
    first = inserted(student, points[:10])
    with needs("every point is where it belongs"):
        assert_tree(first, points[:10], either_way=True)
    second = student.KdTree()
    for row in range(10, 20):
        first.insert(points[row].copy(), row)
        second.insert(points[row].copy(), row)
    assert_tree(first, points, either_way=True)
    assert_tree(second, points[10:], list(range(10, 20)), either_way=True)


@hidden(
    "insert",
    weight=1,
    title="Never writes into the point that it is given",
    hint="Only the tree changes.",
)
def test_point(student, seed):
    require_root(student.KdTree)
    points = diagonal_points(np.random.default_rng(seed).permutation(9) / 4, 3)
    tree = student.KdTree()
    for index, point in enumerate(points):
        assert_arguments_unchanged(observe(tree.insert, point, index), point, index)
    with needs("every point is where it belongs"):
        assert_tree(tree, points, either_way=True)


# ---------------------------------------------------------------------------------- search

RINGS = frozen(np.concatenate([np.geomspace(8, 1.2, 15), np.geomspace(0.9, 0.1, 12)]))


def clear(rng, points, number):
    """Return points and targets, without points on the rim or in a corner around a target."""
    targets = points[rng.choice(len(points), number, replace=False)]
    targets = targets + rng.normal(0, 0.3, targets.shape)
    for target in targets:
        points = points[is_off_corners(points - target)]
    return points, targets


def require_pruning(KdTree):
    """Require that regions are left out: comparing with all points makes no use of the tree."""
    with needs("regions that cannot hold a neighbour are left out"):
        leaves_regions_out(KdTree)


def assert_searches(student, targets, root):
    tree = build_tree(student.KdTree, root)
    for target in targets:
        assert_found(tree, root, target, 1.0)


@hidden(
    "search",
    weight=5,
    title="Right in the plane, for trees and targets you have not seen",
    hint="Compare with a search that leaves nothing out: which point is missing, and at which "
    "node was it cut off?",
)
def test_search_plane(student, seed):
    require_pruning(student.KdTree)
    for targets, root in planes(seed):
        assert_searches(student, targets, root)


@functools.cache
def planes(seed):
    rng = np.random.default_rng(seed)
    scenes = [clear(rng, rng.uniform(-width, width, (250, 2)), 8) for width in (4, 12)]
    return [(targets, balanced(points)) for points, targets in scenes]


@hidden(
    "search",
    weight=8,
    title="Right in space, on a street you have not seen",
    hint="The axis at a node is depth % len(target).",
)
def test_search_street(student, seed):
    require_pruning(student.KdTree)
    for targets, root in streets(seed):
        assert_searches(student, targets, root)


@functools.cache
def streets(seed):
    rng = np.random.default_rng(seed)
    street = samples.obstacles_of_street(seed, 300)[:, :3].astype(float)
    scenes = [clear(rng, street * scale, 8) for scale in (1.0, 0.4)]
    return [(targets, balanced(points)) for points, targets in scenes]


@hidden(
    "search",
    weight=3,
    title="Right in crooked trees, with equal coordinates and equal points",
    hint="Equal stands on the right. A tree that is not balanced is searched in the same way.",
)
def test_search_crooked(student, seed):
    rng = np.random.default_rng(seed)
    points, targets = clear(rng, rng.integers(-6, 7, (120, 2)) / 2, 8)
    assert_searches(student, targets, grown(points))
    points, targets = clear(rng, np.sort(rng.uniform(-10, 10, (150, 2)), axis=0), 8)
    assert_searches(student, targets, grown(points))


@hidden(
    "search",
    weight=3,
    title="Leaves out what is in the corners of the box, in {}",
    hint="A point counts when its distance is at most the tolerance, wherever the box ends.",
)
@pytest.mark.parametrize("k", [2, 3], ids=["the plane", "space"])
def test_search_circle(student, seed, k):
    require_pruning(student.KdTree)
    rng = np.random.default_rng(seed + k)
    for _ in range(3):
        points = nested_points(rng, np.linspace(0.97, 0.6, 16), k, is_off_rim, -1)
        assert_searches(student, [np.zeros(k)], grown(points))


@hidden(
    "search",
    weight=8,
    title="Right for small and for large tolerances",
    hint="Compare a distance with the tolerance, not its square.",
)
def test_search_radius(student, seed):
    require_pruning(student.KdTree)
    rng = np.random.default_rng(seed)
    for tolerance in (0.2, 0.5, 3.0, 40.0):
        points = nested_points(rng, RINGS, 2, is_off_corners, -1)
        root = grown(points * tolerance)
        assert_found(build_tree(student.KdTree, root), root, np.zeros(2), tolerance)


@hidden(
    "search",
    weight=2,
    title="Goes right wherever the box ends exactly at the split",
    hint="Right, when the box reaches the split (>=).",
)
def test_search_split(student, seed):
    # The point at distance 1 along an axis is to the right of a far node with the same coordinate.
    with needs("both sides are searched where the circle crosses the split"):
        looks_on_both_sides(student.KdTree)
    if not finds_the_rim(student.KdTree):
        return
    rng = np.random.default_rng(seed)
    for k in (2, 3):
        target = rng.integers(-9, 10, k).astype(float)
        for axis in range(k):
            above = -4.0 - np.arange(axis + 1)[:, None] * np.ones(k)
            above[axis, axis] = 1.0
            root = grown(np.vstack([above, np.eye(k)[[axis]]]) + target)
            assert_found(build_tree(student.KdTree, root), root, target, 1.0)


@hidden(
    "search",
    weight=10,
    title="Leaves out what lies beyond the box, at every level",
    hint="Both children need a condition of their own before they are looked at.",
)
def test_search_prunes(student, seed):
    for question in traps_and_decoys(seed):
        assert_pruned(student.KdTree, *question)


@functools.cache
def traps_and_decoys(seed):
    """Return arguments of `assert_pruned`: tree, target, tolerance, trap, decoy and its place."""
    rng = np.random.default_rng(seed)
    questions = []
    while len(questions) < 6:
        root = balanced(rng.uniform(-10, 10, (50, 2)))
        regions = {leaf: np.clip(region, -12, 12) for leaf, region in leaves_of(root).items()}
        decoy = sorted(regions)[rng.integers(len(regions))]
        low, high = regions[decoy]
        axis = rng.integers(2)
        if (high - low < 1.7).any() or high[axis] > 11:
            continue
        # The target is near one side of the decoy's region, and the decoy moves beyond that side.
        target = rng.uniform(low + 1.05, high - 0.1)
        target[axis], place = high[axis] - 0.5, target.copy()
        place[axis] = high[axis] + 0.3
        # The trap is hidden only by splits to its left, or only by splits to its right.
        hidden_by = hidden_leaves(root, target, 1.2)
        traps = [
            leaf for leaf, letters in hidden_by.items() if letters == {"lr"[len(questions) % 2]}
        ]
        if not traps:
            continue
        trap = traps[rng.integers(len(traps))]
        questions.append((root, target, 1.0, trap, decoy, place))
    return questions


def hidden_leaves(root, target, margin):
    """Return by leaf index the sides on which the box around a target does not reach the leaf."""
    places = places_of(root)
    hidden_by = {}
    for way, node in places.items():
        letters = set()
        for depth, letter in enumerate(way):
            gap = target[depth % 2] - places[way[:depth]].point[depth % 2]
            if (gap if letter == "l" else -gap) > margin:
                letters.add(letter)
        if node.left is None and node.right is None:
            hidden_by[node.index] = letters
    return hidden_by


def leaves_of(root):
    """Return the regions of the leaves by their index."""
    regions = regions_of(root)
    return {index: regions[index] for index in hidden_leaves(root, np.zeros(2), 0.0)}


@hidden(
    "search",
    weight=2,
    title="Right for one point, for all points, and for any index",
    hint="The result holds the index of each node, which need not be its row.",
)
def test_search_extremes(student, seed):
    rng = np.random.default_rng(seed)
    points = nested_points(rng, np.geomspace(0.9, 0.1, 20), 3, is_off_corners, -1)
    root = grown(points, rng.permutation(500)[:20].tolist())
    tree = build_tree(student.KdTree, root)
    assert_found(tree, root, np.zeros(3), 1.0)
    assert_found(tree, root, np.array([100.0, 0.0, 0.0]), 1.0)
    single = grown(points[:1])
    assert_found(build_tree(student.KdTree, single), single, points[0] + [0.0, 0.0, 0.5], 1.0)


@hidden(
    "search",
    weight=1,
    title="Takes lists, tuples and single precision",
    hint="Take the coordinates as they are given, one by one, or make arrays of both.",
)
def test_search_notations(student, seed):
    points = nested_points(np.random.default_rng(seed), RINGS, 2, is_off_corners)
    root = grown(points)
    for as_lists, target in (
        (True, [0.0, 0.0]),
        (True, (0.0, 0.0)),
        (False, np.zeros(2, dtype=np.float32)),
    ):
        assert_found(build_tree(student.KdTree, root, as_lists), root, target, 1.0)


@hidden(
    "search",
    weight=1,
    title="Never writes into the tree or the target",
    hint="Look, and leave both as they are.",
)
def test_search_leaves_the_tree(student, seed):
    target = np.array([20.0, -30.0])
    points = nested_points(np.random.default_rng(seed), RINGS, 2, is_off_corners) + target
    root = grown(points)
    with needs("the right points are found"):
        assert_found(build_tree(student.KdTree, root), root, target, 1.0)
    tree = build_tree(student.KdTree, root)
    assert_untouched(tree.search, target, 1.0)
    assert_same_tree(tree, points, list(range(len(points))))


# ---------------------------------------------------------------------------- median_order

# With these numbers of points, every part has exactly one median.
FULL = (3, 7, 15, 31, 127)


@hidden(
    "median_order",
    weight=3,
    title="The least depth for points in {}",
    hint="Does each part go on with the next axis, also when it came from the right?",
)
@pytest.mark.parametrize("k", [2, 3], ids=["the plane", "space"])
def test_depth(student, seed, k):
    rng = np.random.default_rng(seed + k)
    for n in (2, 3, 5, 8, 16, 31, 32, 77, 200):
        points = distinct_points(rng, n, k)
        assert_shallow(student.median_order(points.copy()), points)


@hidden(
    "median_order",
    weight=5,
    title="Halves every part",
    hint="The median comes before both halves, and each half is a part of its own.",
)
def test_halves(student, seed):
    rng = np.random.default_rng(seed + 30)
    for n in FULL:
        points = distinct_points(rng, n, 2)
        assert_halves(student.median_order(points.copy()), points)


@hidden(
    "median_order",
    weight=3,
    title="The median along {} in turn",
    hint="The axis of a part is its depth modulo the number of columns.",
)
@pytest.mark.parametrize("k", [2, 3], ids=["two axes", "three axes"])
def test_medians(student, seed, k):
    rng = np.random.default_rng(seed + 10 + k)
    for n in FULL:
        points = distinct_points(rng, n, k)
        assert_lower_medians(student.median_order(points.copy()), points)


@hidden(
    "median_order",
    weight=4,
    title="The lower one of two in the middle, in every part",
    hint="Of m sorted rows the lower median is number (m - 1) // 2, for odd and even m.",
)
def test_lower_medians(student, seed):
    rng = np.random.default_rng(seed + 20)
    for n in (2, 4, 6, 50, 128):
        points = distinct_points(rng, n, 2)
        assert_lower_medians(student.median_order(points.copy()), points)


@hidden(
    "median_order",
    weight=3,
    title="Right on a street you have not seen",
    hint="Draw the tree of your order for a few points of the lesson's own scan: is each part "
    "halved along its own axis?",
)
def test_medians_of_street(student, seed):
    points = samples.obstacles_of_street(seed, 500)[:, :3]
    alone = [np.unique(points[:, axis], return_index=True)[1] for axis in range(3)]
    points = points[sorted(set(alone[0]) & set(alone[1]) & set(alone[2]))]
    points = points[: 2 ** (len(points) + 1).bit_length() // 2 - 1]
    order = student.median_order(points.copy())
    assert_shallow(order, points)
    assert_lower_medians(order, points)


@hidden(
    "median_order",
    weight=2,
    title="Right for single precision, far from the origin, and however the array is stored",
    hint="Return row numbers of the array that came in.",
)
def test_median_extremes(student, seed):
    rng = np.random.default_rng(seed)
    points = np.asfortranarray(distinct_points(rng, 31, 2).astype(np.float32))
    assert_lower_medians(student.median_order(points.copy()), points)
    points = distinct_points(rng, 15, 2) + 1000
    assert_lower_medians(student.median_order(points.copy()), points)


@hidden(
    "median_order",
    weight=1,
    title="Never sorts the array that it is given",
    hint="Sort row numbers.",
)
def test_median_input(student, seed):
    points = distinct_points(np.random.default_rng(seed), 15, 2)
    with needs("the median comes first in every part"):
        assert_halves(student.median_order(points.copy()), points)
    assert_untouched(student.median_order, points)
