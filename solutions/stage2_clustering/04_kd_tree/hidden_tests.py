"""Hidden tests of lesson 04. Students see the titles and hints but not the code.

Tests of `search` build the tree themselves, so that the exercises are independent. They send each
tree to the sandbox in one message. All tests but one search within a radius of 1, so that a missing
square root does not affect them. Points on the circle or in the corners of its box occur only in
the tests about them.
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
    observe,
    precondition,
)
from utils.checks.lesson_04.cases import (
    diagonal_points,
    distinct_points,
    is_off_circle,
    is_off_corners,
    nested_points,
)
from utils.checks.lesson_04.insert import require_root
from utils.checks.lesson_04.median_order import (
    assert_halves,
    assert_lower_medians,
    assert_minimal_depth,
)
from utils.checks.lesson_04.search import finds_the_border, searches_both_sides, skips_regions
from utils.checks.lesson_04.search_results import assert_found, assert_pruned, assert_same_tree
from utils.checks.lesson_04.trees import assert_indices, assert_tree, build_tree
from utils.geometry import grow_tree, nodes_by_path, regions_by_index


def median_order_of(points):
    """Return the rows of points in an order whose insertion gives a balanced tree."""

    def parts(rows, axis):
        rows = sorted(rows, key=lambda row: points[row][axis])
        middle = len(rows) // 2
        if rows:
            yield rows[middle]
            yield from parts(rows[:middle], (axis + 1) % len(points[0]))
            yield from parts(rows[middle + 1 :], (axis + 1) % len(points[0]))

    return list(parts(range(len(points)), 0))


def balanced_tree(points):
    """Build a correct tree with the fewest levels."""
    order = median_order_of(points)
    return grow_tree(np.asarray(points)[order], order)


def without_equal_coordinates(points):
    """Return points of a cloud, shape (n, 3), such that no two share a coordinate."""
    first = [np.unique(points[:, axis], return_index=True)[1] for axis in range(3)]
    return points[sorted(set(first[0]) & set(first[1]) & set(first[2]))]


# ---------------------------------------------------------------------------------- insert


def tree_of(student, points, indices=None):
    require_root(student.KdTree)
    tree = student.KdTree()
    call_each(tree.insert, zip(points, indices or range(len(points)), strict=True))
    return tree


@hidden(
    "insert",
    weight=9,
    title="Builds the correct tree from unseen points in the plane",
    hint="At each node, compare one coordinate: x at even depths, y at odd ones.",
)
def test_plane(student, seed):
    points = distinct_points(np.random.default_rng(seed), 40, 2)
    assert_tree(tree_of(student, points), points)


@hidden(
    "insert",
    weight=9,
    title="Builds the correct tree from unseen points in space",
    hint="Compare x, y, z, x, y, z, ... from level to level. The number of axes is len(point).",
)
def test_space(student, seed):
    # The values are rounded to float32, so that answers may store points in single precision.
    street = samples.obstacles_of_street(seed, 80)[:, :3].astype(np.float32)
    points = without_equal_coordinates(street)[:40].astype(float)
    assert_tree(tree_of(student, points), points)


@hidden(
    "insert",
    weight=7,
    title="Works on repeated points and on points with equal coordinates",
    hint="Send a point with an equal coordinate to the right, at every depth.",
)
def test_equal_coordinates(student, seed):
    rng = np.random.default_rng(seed)
    points = diagonal_points(rng.integers(0, 6, 30), 2 + seed % 2)
    assert_tree(tree_of(student, points), points)
    for y in (-2.0, 2.0):
        points = np.array([[1.0, 4.0], [1.0, 4.0 + y], [-3.0, 4.0 + y]])
        assert_tree(tree_of(student, points), points)


@hidden(
    "insert",
    weight=1,
    title="Works on lists, tuples and float32 arrays",
    hint="Read the coordinates one by one, as point[axis].",
)
def test_notations(student, seed):
    points = diagonal_points(np.random.default_rng(seed).permutation(12) / 4, 3)
    for kind in (points.tolist(), list(map(tuple, points.tolist())), points.astype(np.float32)):
        assert_tree(tree_of(student, kind), points, may_be_mirrored=True)


@hidden(
    "insert",
    weight=8,
    title="Stores the index of each point, whatever the index is",
    hint="Pass index to Node unchanged.",
)
def test_indices(student, seed):
    rng = np.random.default_rng(seed)
    points = diagonal_points(rng.permutation(12) / 4)
    indices = rng.permutation(1000)[:12].tolist()
    tree = tree_of(student, points, indices)
    with precondition("every point is in its place"):
        assert_tree(tree, points, indices, may_be_mirrored=True)
    assert_indices(tree, points, indices)


@hidden(
    "insert",
    weight=2,
    title="Adds points to an existing tree without affecting another tree",
    hint="Start every walk at tree.root, and do not store nodes in global variables.",
)
def test_two_trees(student, seed):
    points = diagonal_points(np.random.default_rng(seed).permutation(20) / 4)
    first = tree_of(student, points[:10])
    with precondition("every point is in its place"):
        assert_tree(first, points[:10], may_be_mirrored=True)
    second = student.KdTree()
    for row in range(10, 20):
        first.insert(points[row].copy(), row)
        second.insert(points[row].copy(), row)
    assert_tree(first, points, may_be_mirrored=True)
    assert_tree(second, points[10:], list(range(10, 20)), may_be_mirrored=True)


@hidden(
    "insert",
    weight=1,
    title="Does not change points with three coordinates",
    hint="Read the point, but assign only to the tree.",
)
def test_point(student, seed):
    require_root(student.KdTree)
    points = diagonal_points(np.random.default_rng(seed).permutation(9) / 4, 3)
    tree = student.KdTree()
    for index, point in enumerate(points):
        assert_arguments_unchanged(observe(tree.insert, point, index), point, index)
    with precondition("every point is in its place"):
        assert_tree(tree, points, may_be_mirrored=True)


# ---------------------------------------------------------------------------------- search

RINGS = frozen(np.concatenate([np.geomspace(8, 1.2, 15), np.geomspace(0.9, 0.1, 12)]))


def draw_targets(rng, points, number):
    """Draw targets near points, and drop points on a target's circle or in its box's corners."""
    targets = points[rng.choice(len(points), number, replace=False)]
    targets = targets + rng.normal(0, 0.3, targets.shape)
    for target in targets:
        points = points[is_off_corners(points - target)]
    return points, targets


def require_pruning(KdTree):
    """Require that the search skips regions, because a search of all points needs no tree."""
    with precondition("regions that cannot contain a neighbour are skipped"):
        skips_regions(KdTree)


def assert_searches(student, targets, root):
    tree = build_tree(student.KdTree, root)
    for target in targets:
        assert_found(tree, root, target, 1.0)


@hidden(
    "search",
    weight=5,
    title="Finds the neighbours of unseen targets in the plane",
    hint="Compare your result with a search that skips nothing, and find the node at which your "
    "search skips a neighbour.",
)
def test_search_plane(student, seed):
    require_pruning(student.KdTree)
    for targets, root in plane_scenes(seed):
        assert_searches(student, targets, root)


@functools.cache
def plane_scenes(seed):
    rng = np.random.default_rng(seed)
    scenes = [draw_targets(rng, rng.uniform(-width, width, (250, 2)), 8) for width in (4, 12)]
    return [(targets, balanced_tree(points)) for points, targets in scenes]


@hidden(
    "search",
    weight=8,
    title="Finds the neighbours of targets on an unseen street",
    hint="Compare along axis depth % len(target) at each node.",
)
def test_search_street(student, seed):
    require_pruning(student.KdTree)
    for targets, root in street_scenes(seed):
        assert_searches(student, targets, root)


@functools.cache
def street_scenes(seed):
    rng = np.random.default_rng(seed)
    street = samples.obstacles_of_street(seed, 300)[:, :3].astype(float)
    scenes = [draw_targets(rng, street * scale, 8) for scale in (1.0, 0.4)]
    return [(targets, balanced_tree(points)) for points, targets in scenes]


@hidden(
    "search",
    weight=3,
    title="Works on unbalanced trees with equal coordinates and equal points",
    hint="Search the right side for points with an equal coordinate, in every tree.",
)
def test_search_unbalanced(student, seed):
    rng = np.random.default_rng(seed)
    points, targets = draw_targets(rng, rng.integers(-6, 7, (120, 2)) / 2, 8)
    assert_searches(student, targets, grow_tree(points))
    points, targets = draw_targets(rng, np.sort(rng.uniform(-10, 10, (150, 2)), axis=0), 8)
    assert_searches(student, targets, grow_tree(points))


@hidden(
    "search",
    weight=3,
    title="Leaves out points in the corners of the box, in {}",
    hint="Return a point only if its distance is at most the tolerance. Being in the box is not "
    "enough.",
)
@pytest.mark.parametrize("k", [2, 3], ids=["the plane", "space"])
def test_search_circle(student, seed, k):
    require_pruning(student.KdTree)
    rng = np.random.default_rng(seed + k)
    for _ in range(3):
        points = nested_points(rng, np.linspace(0.97, 0.6, 16), k, is_off_circle, -1)
        assert_searches(student, [np.zeros(k)], grow_tree(points))


@hidden(
    "search",
    weight=8,
    title="Works for small and large tolerances",
    hint="Compare the distance itself with the tolerance, not its square.",
)
def test_search_radius(student, seed):
    require_pruning(student.KdTree)
    rng = np.random.default_rng(seed)
    for tolerance in (0.2, 0.5, 3.0, 40.0):
        points = nested_points(rng, RINGS, 2, is_off_corners, -1)
        root = grow_tree(points * tolerance)
        assert_found(build_tree(student.KdTree, root), root, np.zeros(2), tolerance)


@hidden(
    "search",
    weight=2,
    title="Searches the right side whenever the box ends exactly at the split",
    hint="Search the right side if target[axis] + tolerance >= split.",
)
def test_search_split(student, seed):
    # A point is at distance 1 along an axis. The distant node above it has the same coordinate on
    # that axis, so the box ends exactly at the split, and the point is to the right.
    with precondition("both sides are searched if the circle crosses the split"):
        searches_both_sides(student.KdTree)
    if not finds_the_border(student.KdTree):
        return
    rng = np.random.default_rng(seed)
    for k in (2, 3):
        target = rng.integers(-9, 10, k).astype(float)
        for axis in range(k):
            above = -4.0 - np.arange(axis + 1)[:, None] * np.ones(k)
            above[axis, axis] = 1.0
            root = grow_tree(np.vstack([above, np.eye(k)[[axis]]]) + target)
            assert_found(build_tree(student.KdTree, root), root, target, 1.0)


@hidden(
    "search",
    weight=10,
    title="Skips regions beyond the box at every level",
    hint="Test a separate condition for each child before you visit it.",
)
def test_search_prunes(student, seed):
    for case in traps_and_decoys(seed):
        assert_pruned(student.KdTree, *case)


@functools.cache
def traps_and_decoys(seed):
    """Return arguments of `assert_pruned`, where traps and decoys are defined."""
    rng = np.random.default_rng(seed)
    cases = []
    while len(cases) < 6:
        root = balanced_tree(rng.uniform(-10, 10, (50, 2)))
        regions = {leaf: np.clip(region, -12, 12) for leaf, region in leaves_of(root).items()}
        decoy = sorted(regions)[rng.integers(len(regions))]
        low, high = regions[decoy]
        axis = rng.integers(2)
        if (high - low < 1.7).any() or high[axis] > 11:
            continue
        # The target is near one side of the decoy's region. The decoy's new place is beyond it.
        target = rng.uniform(low + 1.05, high - 0.1)
        target[axis], place = high[axis] - 0.5, target.copy()
        place[axis] = high[axis] + 0.3
        # All splits that hide the trap hide it on the same side, to test one condition at a time.
        hidden_by = hiding_sides(root, target, 1.2)
        traps = [leaf for leaf, letters in hidden_by.items() if letters == {"lr"[len(cases) % 2]}]
        if not traps:
            continue
        trap = traps[rng.integers(len(traps))]
        cases.append((root, target, 1.0, trap, decoy, place))
    return cases


def hiding_sides(root, target, margin):
    """Return, by leaf index, the sides on which splits hide the leaf from the target's box."""
    places = nodes_by_path(root)
    hidden_by = {}
    for path, node in places.items():
        letters = set()
        for depth, letter in enumerate(path):
            gap = target[depth % 2] - places[path[:depth]].point[depth % 2]
            if (gap if letter == "l" else -gap) > margin:
                letters.add(letter)
        if node.left is None and node.right is None:
            hidden_by[node.index] = letters
    return hidden_by


def leaves_of(root):
    """Return the region of each leaf, by index."""
    regions = regions_by_index(root)
    return {index: regions[index] for index in hiding_sides(root, np.zeros(2), 0.0)}


@hidden(
    "search",
    weight=2,
    title="Finds all points, no points or a single point, whatever their indices",
    hint="Return the index that is stored in each node, even if the indices are not 0, 1, 2, ...",
)
def test_search_extremes(student, seed):
    rng = np.random.default_rng(seed)
    points = nested_points(rng, np.geomspace(0.9, 0.1, 20), 3, is_off_corners, -1)
    root = grow_tree(points, rng.permutation(500)[:20].tolist())
    tree = build_tree(student.KdTree, root)
    assert_found(tree, root, np.zeros(3), 1.0)
    assert_found(tree, root, np.array([100.0, 0.0, 0.0]), 1.0)
    single = grow_tree(points[:1])
    assert_found(build_tree(student.KdTree, single), single, points[0] + [0.0, 0.0, 0.5], 1.0)


@hidden(
    "search",
    weight=1,
    title="Works on lists, tuples and float32 arrays",
    hint="Use the coordinates one by one, or convert both points to arrays.",
)
def test_search_notations(student, seed):
    points = nested_points(np.random.default_rng(seed), RINGS, 2, is_off_corners)
    root = grow_tree(points)
    for as_lists, target in (
        (True, [0.0, 0.0]),
        (True, (0.0, 0.0)),
        (False, np.zeros(2, dtype=np.float32)),
    ):
        assert_found(build_tree(student.KdTree, root, as_lists), root, target, 1.0)


@hidden(
    "search",
    weight=1,
    title="Does not change the tree or a target far from the origin",
    hint="Read the tree and the target, but do not assign to them.",
)
def test_search_leaves_the_tree(student, seed):
    target = np.array([20.0, -30.0])
    points = nested_points(np.random.default_rng(seed), RINGS, 2, is_off_corners) + target
    root = grow_tree(points)
    with precondition("the right points are found"):
        assert_found(build_tree(student.KdTree, root), root, target, 1.0)
    tree = build_tree(student.KdTree, root)
    assert_untouched(tree.search, target, 1.0)
    assert_same_tree(tree, points, list(range(len(points))))


# ---------------------------------------------------------------------------- median_order

# Numbers of points for which every part has exactly one median.
FULL = (3, 7, 15, 31, 127)


@hidden(
    "median_order",
    weight=3,
    title="Returns an order that makes a tree with the fewest levels, in {}",
    hint="Use the next axis for both halves of a part, the left one and the right one.",
)
@pytest.mark.parametrize("k", [2, 3], ids=["the plane", "space"])
def test_depth(student, seed, k):
    rng = np.random.default_rng(seed + k)
    for n in (2, 3, 5, 8, 16, 31, 32, 77, 200):
        points = distinct_points(rng, n, k)
        assert_minimal_depth(student.median_order(points.copy()), points)


@hidden(
    "median_order",
    weight=5,
    title="Halves every part of the cloud",
    hint="Put the median before both halves, and treat each half as a new part.",
)
def test_halves(student, seed):
    rng = np.random.default_rng(seed + 30)
    for n in FULL:
        points = distinct_points(rng, n, 2)
        assert_halves(student.median_order(points.copy()), points)


@hidden(
    "median_order",
    weight=3,
    title="Takes medians along {} in turn",
    hint="Sort a part along axis depth % points.shape[1].",
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
    title="Takes the lower of two middle points in every part",
    hint="Take position (m - 1) // 2 of m sorted rows for the lower median, for odd and even m.",
)
def test_lower_medians(student, seed):
    rng = np.random.default_rng(seed + 20)
    for n in (2, 4, 6, 50, 128):
        points = distinct_points(rng, n, 2)
        assert_lower_medians(student.median_order(points.copy()), points)


@hidden(
    "median_order",
    weight=3,
    title="Works on an unseen street",
    hint="Draw the tree that your order makes for a few points of the lesson's scan: each part "
    "must be halved along the axis of its depth.",
)
def test_medians_of_street(student, seed):
    points = samples.obstacles_of_street(seed, 500)[:, :3]
    points = without_equal_coordinates(points)
    points = points[: 2 ** (len(points) + 1).bit_length() // 2 - 1]
    order = student.median_order(points.copy())
    assert_minimal_depth(order, points)
    assert_lower_medians(order, points)


@hidden(
    "median_order",
    weight=2,
    title="Works on float32 arrays and far from the origin",
    hint="Return row numbers of the given array, not of a copy that you have sorted or split.",
)
def test_median_extremes(student, seed):
    rng = np.random.default_rng(seed)
    points = distinct_points(rng, 31, 2).astype(np.float32)
    assert_lower_medians(student.median_order(points.copy()), points)
    points = distinct_points(rng, 15, 2) + 1000
    assert_lower_medians(student.median_order(points.copy()), points)


@hidden(
    "median_order",
    weight=1,
    title="Does not sort the given array",
    hint="Sort row numbers instead.",
)
def test_median_input(student, seed):
    points = distinct_points(np.random.default_rng(seed), 15, 2)
    with precondition("every part begins with its median"):
        assert_halves(student.median_order(points.copy()), points)
    assert_untouched(student.median_order, points)
