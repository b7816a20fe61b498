"""Visible checks of `search`, through `KdTree`."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from utils.checks.assertions import CheckFailed, assert_untouched, frozen, precondition
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.lesson_04.cases import (
    BALANCED_ORDER,
    ELEVEN_POINTS,
    balanced_tree,
    chain_tree,
    distinct_points,
    is_off_circle,
    is_off_corners,
    nested_points,
)
from utils.checks.lesson_04.search_results import (
    as_indices,
    assert_found,
    assert_pruned,
    assert_same_tree,
)
from utils.checks.lesson_04.trees import build_tree
from utils.checks.run_cache import once_per_run
from utils.geometry import SIDES, TreeNode, alternating_axis, grow_tree, nodes_by_path

# Distances of the splits from the target, from 8 times the radius down to a tenth of it.
_SIZES = frozen(np.concatenate([np.geomspace(8, 1.2, 15), np.geomspace(0.9, 0.1, 12)]))
# Any two of these points are at least a quarter of a metre apart along x and along y.
_SCATTERED_POINTS = frozen(4 * distinct_points(np.random.default_rng(46), 11, 2))


@once_per_run
def _assert_at_target(KdTree: Callable) -> None:
    with precondition("a point close to the target is found"):
        finds_the_target(KdTree)


@visible_check(
    "search",
    weight=3,
    title="Finds a point close to the target, wherever it is in the tree",
    why="Clustering searches around every point, 100,000 times per scan. A missed neighbour may "
    "split an obstacle in two.",
    hint="At each node, compare dist(node.point, target) with tolerance, and decide for each side "
    "whether to search it.",
)
def finds_the_target(KdTree: Callable) -> None:
    root = grow_tree(_SCATTERED_POINTS)
    tree = build_tree(KdTree, root)
    for point in _SCATTERED_POINTS:
        assert_found(tree, root, point + [0.03, -0.02], 0.1)


@visible_check(
    "search",
    weight=5,
    title="Searches both sides if the circle crosses the split",
    why="A split may run through a pedestrian. If you search only the target's side of it, you "
    "miss the points on the other side.",
    hint="Write two separate ifs and no else: search the left side if the box begins below the "
    "split, and the right side if it reaches the split or beyond.",
)
def searches_both_sides(KdTree: Callable) -> None:
    # The root is far from the target, but its split is between two neighbours of the target.
    root = grow_tree([[0.0, 3.0], [-0.5, 0.0], [0.5, 0.1]])
    for x in (0.1, -0.1):
        assert_found(build_tree(KdTree, root), root, np.array([x, 0.0]), 1.0)
    for target, tolerance in (([-6.0, 7.0], 3.0), ([-6.5, 7.5], 2.5)):
        assert_found(
            build_tree(KdTree, balanced_tree()), balanced_tree(), np.array(target), tolerance
        )


@visible_check(
    "search",
    weight=3,
    title="Finds points in the circle only, not in the corners of the box",
    why="The corners of the box are 1.4 times as far away as its sides (1.7 times in space). "
    "Points there are not neighbours and would join two obstacles into one.",
    hint="Return a point if its distance, the square root of the sum of squares, is at most "
    "tolerance. The box only decides where to search.",
)
def measures_a_circle(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    points = nested_points(
        np.random.default_rng(3), np.geomspace(0.96, 0.5, 8), 2, is_off_circle, -1
    )
    root = grow_tree(points)
    assert_found(build_tree(KdTree, root), root, np.zeros(2), 1.0)


@visible_check(
    "search",
    weight=6,
    title="Uses the tolerance as the radius, whether small or large",
    why="If the squared distance is compared with 0.5, points up to 0.71 m away are found.",
    hint="Take the square root of the sum of squares, or use dist(node.point, target).",
)
def follows_the_tolerance(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    points = nested_points(
        np.random.default_rng(4), [2.2, 1.6, 1.3, 0.9, 0.8, 0.7, 0.6, 0.3], 2, is_off_corners, -1
    )
    for tolerance in (0.3, 1.0, 3.0):
        root = grow_tree(points * tolerance)
        assert_found(build_tree(KdTree, root), root, np.zeros(2), tolerance)


@note_check(
    "search",
    title="Finds a point whose distance equals the tolerance",
    why="A distance equal to the tolerance is still within it, so write <=. Measured points are "
    "hardly ever at exactly this distance, so your score does not depend on it.",
)
def includes_the_border(KdTree: Callable) -> None:
    points = np.array([[0.0, 2.0], [1.0, 1.0], [2.0, 2.0], [1.0, 3.0], [1.2, 2.5]])
    root = grow_tree(points)
    assert_found(build_tree(KdTree, root), root, np.array([1.0, 2.0]), 1.0)


def finds_the_border(KdTree: Callable) -> bool:
    """Return whether a search finds points at exactly the tolerance.

    If it does not, a box that ends exactly at a split cannot show whether the right side is
    searched.
    """
    try:
        includes_the_border(KdTree)
    except CheckFailed:
        return False
    return True


@visible_check(
    "search",
    weight=2,
    title="Searches the right side even if the box ends exactly at the split",
    why="A point whose coordinate equals the split is on the right. If the box ends there, a "
    "search with > instead of >= misses the point.",
    hint="Search the right side if target[axis] + tolerance >= split, with the equals sign.",
)
def reaches_the_split(KdTree: Callable) -> None:
    with precondition("both sides are searched if the circle crosses the split"):
        searches_both_sides(KdTree)
    if not finds_the_border(KdTree):
        return
    points = np.array([[2.0, 9.0], [-3.0, 3.0], [2.0, 2.0], [1.0, 3.0], [1.2, 2.5]])
    root = grow_tree(points)
    assert_found(build_tree(KdTree, root), root, np.array([1.0, 2.0]), 1.0)


@visible_check(
    "search",
    weight=6,
    title="Works on points with three coordinates",
    why="The points of a scan have three coordinates. A search that compares x at a cut by z "
    "misses neighbours.",
    hint="Compare along axis depth % len(target), as in insert.",
)
def searches_space(KdTree: Callable) -> None:
    points = nested_points(np.random.default_rng(5), _SIZES, 3, is_off_corners)
    # Seen from above, all three are near the target; two of them are far above or below it.
    above = np.array([[0.3, 0.2, 5.0], [0.1, 0.4, 0.2], [0.6, -0.3, -4.0]])
    for root in (grow_tree(points), grow_tree(above)):
        assert_found(build_tree(KdTree, root), root, np.zeros(3), 1.0)


@visible_check(
    "search",
    weight=8,
    title="Skips regions that cannot contain a neighbour",
    why="Skipping regions is the purpose of a tree. A search that visits every node saves nothing.",
    hint="Before you go to a child, compare the split, node.point[axis], with the ends of the box, "
    "target[axis] - tolerance and target[axis] + tolerance.",
)
def skips_regions(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    for target, decoy, place, traps in (
        ([-0.3, 9.0], 2, [0.5, 9.0], (9, 10)),
        ([-2.0, 6.5], 9, [-2.0, 7.3], (6, 10)),
    ):
        for trap in traps:
            assert_pruned(KdTree, balanced_tree(), np.array(target), 1.0, trap, decoy, place)


@visible_check(
    "search",
    weight=1,
    title="Works on an empty tree and on a tree with a single node",
    why="A filter sometimes removes every point, and that must not crash the program.",
    hint="If tree.root is None, return an empty list. If you keep a list of nodes to visit, skip "
    "those that are None.",
)
def handles_an_empty_tree(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    assert_found(build_tree(KdTree, None), None, np.zeros(2), 1.0)
    root = grow_tree([[1.0, 2.0]])
    assert_found(build_tree(KdTree, root), root, np.array([1.1, 2.0]), 0.5)
    assert_found(build_tree(KdTree, root), root, np.array([5.0, 5.0]), 1.0)


@visible_check(
    "search",
    weight=1,
    title="Returns each index once",
    why="If an index is returned twice, a count of the neighbours is too high.",
    hint="Append the index in one place only, where your code visits the node.",
)
def returns_each_once(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    yours = as_indices(build_tree(KdTree, balanced_tree()).search(np.array([-6.0, 7.0]), 3.0))
    repeated = sorted({index for index in yours if yours.count(index) > 1})
    if repeated:
        raise CheckFailed(
            f"Index {repeated[0]} is returned {yours.count(repeated[0])} times.",
            input_text="target (-6, 7), tolerance 3 m",
            yours=_indices_text(yours),
            expected="each index once",
        )


def _indices_text(indices: list[int]) -> str:
    return f"{indices}" if len(indices) <= 12 else f"{len(indices)} indices"


@visible_check(
    "search",
    weight=1,
    title="Accepts targets and points that are lists, tuples or arrays",
    why="Later cells insert points as lists, because search is faster with Python's own numbers.",
    hint="Use dist(p, q), which works for all of them. p - q needs an array: np.asarray(p) - q.",
)
def accepts_any_sequence(KdTree: Callable) -> None:
    root = grow_tree(
        nested_points(np.random.default_rng(6), [3.0, 2.0, 0.8, 0.5, 0.3], 2, is_off_corners, -1)
    )
    for as_lists, target in ((True, [0.0, 0.0]), (True, np.zeros(2)), (False, (0.0, 0.0))):
        assert_found(build_tree(KdTree, root, as_lists), root, target, 1.0)


@visible_check(
    "search",
    weight=1,
    title="Does not change the tree or the target",
    why="The same tree is searched again and again, and the target may be a row of the cloud.",
    hint="Read the nodes and the target, but do not assign to them.",
)
def leaves_the_tree(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    order = list(BALANCED_ORDER)
    tree = build_tree(KdTree, balanced_tree())
    assert_untouched(tree.search, np.array([-6.0, 7.0]), 3.0)
    assert_same_tree(tree, ELEVEN_POINTS[order], order)


@note_check(
    "search",
    title="Works on a tree with more than a thousand levels",
    why="Later in this lesson, you search a tree that has one level per point of a sorted wall. A "
    "function that calls itself raises a RecursionError on that tree; a loop with a list of nodes "
    "to visit does not.",
)
def searches_deep_trees(KdTree: Callable) -> None:
    root = chain_tree(1200)
    assert_found(build_tree(KdTree, root), root, np.array([1199.0, 1199.0]), 0.5)


class _Split(NamedTuple):
    """A node on the path to another node, compared with the box around the target.

    Attributes
    ----------
    low, target, high : float
        The start of the box, the target and the end of the box, along the axis of the split.
    split : float
        Coordinate of the node along this axis.
    is_near : bool
        Whether the point of the node is within the tolerance of the target.
    is_left : bool
        Whether the other node is on the left.
    """

    low: float
    target: float
    high: float
    split: float
    is_near: bool
    is_left: bool


def _visited_indices(
    points: np.ndarray,
    target: np.ndarray,
    tolerance: float,
    rule: Callable[[_Split], bool],
    axis_at: Callable[[int, int], int] = alternating_axis,
    depth_of: Callable[[str], int] = len,
) -> set[int]:
    """Return the indices of the nodes that a search with this rule visits, near or not."""
    places = nodes_by_path(grow_tree(points))

    def passes(path: str, depth: int) -> bool:
        axis = axis_at(depth_of(path[:depth]), len(target))
        return rule(_make_split(places[path[:depth]], axis, path[depth] == "l", target, tolerance))

    return {
        places[path].index
        for path in places
        if all(passes(path, depth) for depth in range(len(path)))
    }


def _make_split(
    node: TreeNode, axis: int, is_left: bool, target: np.ndarray, tolerance: float
) -> _Split:
    at, is_near = target[axis], math.dist(node.point, target) <= tolerance
    return _Split(at - tolerance, at, at + tolerance, node.point[axis], is_near, is_left)


def _reaches_side(node: _Split) -> bool:
    """Return whether the box reaches the side of the other node."""
    return node.low < node.split if node.is_left else node.high >= node.split


def _prediction_from_rule(
    rule: Callable, axis_at: Callable = alternating_axis, depth_of: Callable = len
) -> Callable:
    """Return a function that predicts the near points visited by a search with this rule."""
    return lambda right, points, target, tolerance: (
        right & _visited_indices(points, target, tolerance, rule, axis_at, depth_of)
    )


def _predict_stop_at_first_gap(
    right: set, points: np.ndarray, target: np.ndarray, tolerance: float
) -> set:
    """Predict the result of a level-by-level search that ends at the first missing child."""
    places, found, pending = nodes_by_path(grow_tree(points)), set(), [""]
    for path in pending:  # the list grows inside the loop
        if path not in places:
            break
        node, axis = places[path], alternating_axis(len(path), len(target))
        found.add(node.index)
        pending += [
            path + letter
            for letter in SIDES
            if _reaches_side(_make_split(node, axis, letter == "l", target, tolerance))
        ]
    return right & found


# Two different slips make a search follow a single path: an `else`, or stopping at the first
# missing child in a search that visits the newest entry of its list first.
_ONE_PATH = (
    "Write two ifs, one for each child, without `else` or `elif`. If a node is None, `continue` "
    "with the next one: `break` and `return` end the whole search."
)


def _prediction_from_distance(is_near: Callable) -> Callable:
    """Return the prediction for a search that uses `is_near` to decide which points are near.

    `is_near` takes the absolute differences from the target, shape (k,), the tolerance and the
    depth.
    """

    def predict(right: set, points: np.ndarray, target: np.ndarray, tolerance: float) -> set:
        depths = {node.index: len(path) for path, node in nodes_by_path(grow_tree(points)).items()}
        return {
            index
            for index in _visited_indices(points, target, tolerance, _reaches_side)
            if is_near(np.abs(points[index] - target), tolerance, depths[index])
        }

    return predict


def _same_indices(answer: object, predicted: set[int]) -> bool:
    try:
        return set(as_indices(answer)) == predicted
    except CheckFailed:
        return False


def _grid_points(seed: int, k: int) -> np.ndarray:
    """Return points with whole-number coordinates, many equal and many at exactly the tolerance."""
    return np.random.default_rng(seed).integers(-3, 4, (24, k)).astype(float)


declare_mistakes(
    "search",
    Mistake(
        "Only the side that contains the target is searched.",
        _prediction_from_rule(lambda node: (node.target < node.split) == node.is_left),
        "If the circle crosses the split, search both sides: write two ifs and no else.",
    ),
    Mistake(
        "The search follows a single path: if the box reaches both sides, only the left one is "
        "searched.",
        _prediction_from_rule(lambda node: (node.low < node.split) == node.is_left),
        _ONE_PATH,
    ),
    Mistake(
        "The search follows a single path: if the box reaches both sides, only the right one is "
        "searched.",
        _prediction_from_rule(lambda node: (node.high >= node.split) != node.is_left),
        _ONE_PATH,
    ),
    Mistake(
        "The search ends at the first missing child, before it has visited the remaining nodes.",
        _predict_stop_at_first_gap,
        "Use `continue` to go on with the next node: `break` and `return` end the whole search.",
    ),
    Mistake(
        "The right side is searched only if the left side is searched too.",
        _prediction_from_rule(
            lambda node: _reaches_side(node) and (node.is_left or node.low < node.split)
        ),
        "Give both `if`s the same indentation, so that the second is not inside the first.",
    ),
    Mistake(
        "The left side is searched only if the right side is searched too.",
        _prediction_from_rule(
            lambda node: _reaches_side(node) and (not node.is_left or node.high >= node.split)
        ),
        "Give both `if`s the same indentation, so that the second is not inside the first.",
    ),
    Mistake(
        "The depth does not grow on the way to a left child, so the search compares the same axis "
        "at the child as at its parent.",
        _prediction_from_rule(_reaches_side, depth_of=lambda path: path.count("r")),
        "Give both children depth + 1.",
    ),
    Mistake(
        "The depth does not grow on the way to a right child, so the search compares the same axis "
        "at the child as at its parent.",
        _prediction_from_rule(_reaches_side, depth_of=lambda path: path.count("l")),
        "Give both children depth + 1.",
    ),
    Mistake(
        "The ends of the box are swapped: the function adds the tolerance where it should subtract "
        "it, so a side is searched only if it contains the whole box.",
        _prediction_from_rule(
            lambda node: node.high < node.split if node.is_left else node.low >= node.split
        ),
        "Use target[axis] - tolerance for the left child and target[axis] + tolerance for the "
        "right one.",
    ),
    Mistake(
        "The sides are swapped: the condition for the left child is applied to the right one, and "
        "vice versa.",
        _prediction_from_rule(lambda node: _reaches_side(node._replace(is_left=not node.is_left))),
        "Smaller coordinates are on the left, so search there if the box begins below the split.",
    ),
    Mistake(
        "The function uses `>` instead of `>=`, so it skips the right side if the box ends exactly "
        "at the split.",
        _prediction_from_rule(
            lambda node: _reaches_side(node) and (node.is_left or node.high > node.split)
        ),
        "Points exactly at the split are on the right.",
    ),
    Mistake(
        "Both sides are searched below nodes that are near, and only the target's own side below "
        "all others.",
        _prediction_from_rule(
            lambda node: node.is_near or (node.target < node.split) == node.is_left
        ),
        "Test whether the box reaches a side, not whether the node is near.",
    ),
    Mistake(
        "The search stops at each node that is not near and skips everything below it.",
        _prediction_from_rule(lambda node: node.is_near and _reaches_side(node)),
        "A neighbour of the target may be below a node that is not near, so test both sides of "
        "every node.",
    ),
    Mistake(
        "The tolerance is ignored for the left side, which is searched only if it contains the "
        "target.",
        _prediction_from_rule(
            lambda node: _reaches_side(node) and (not node.is_left or node.target < node.split)
        ),
        "Compare target[axis] - tolerance with the split.",
    ),
    Mistake(
        "The tolerance is ignored for the right side, which is searched only if it contains the "
        "target.",
        _prediction_from_rule(
            lambda node: _reaches_side(node) and (node.is_left or node.target >= node.split)
        ),
        "Compare target[axis] + tolerance with the split.",
    ),
    Mistake(
        "z is never compared, because the function uses 2 instead of len(target).",
        _prediction_from_rule(_reaches_side, lambda depth, k: depth % 2),
    ),
    Mistake(
        "x is compared at every level; the axis should change at each step down.",
        _prediction_from_rule(_reaches_side, lambda depth, k: 0),
        "The axis is depth % len(target), and a child has depth + 1.",
    ),
    Mistake(
        "y is compared at the root, as if the root had depth 1; it should be x.",
        _prediction_from_rule(_reaches_side, lambda depth, k: (depth + 1) % k),
        "The root has depth 0, so its axis is x.",
    ),
    Mistake(
        "The function finds all points in the box, even those in its corners outside the circle.",
        _prediction_from_distance(lambda step, tolerance, depth: step.max() <= tolerance),
        "Compare the distance, dist(node.point, target), with the tolerance.",
    ),
    Mistake(
        "The height is left out: the function measures distances only along x and y.",
        _prediction_from_distance(
            lambda step, tolerance, depth: np.linalg.norm(step[:2]) <= tolerance
        ),
        "Use all coordinates: dist(node.point, target).",
    ),
    Mistake(
        "The squared distance is compared with the tolerance, so 0.5 acts like 0.71.",
        _prediction_from_distance(lambda step, tolerance, depth: step @ step <= tolerance),
        "Take the square root of the sum of squares, or use dist(node.point, target).",
    ),
    Mistake(
        "A single coordinate, along the axis of the split, decides whether a point is near.",
        _prediction_from_distance(
            lambda step, tolerance, depth: step[depth % len(step)] <= tolerance
        ),
        "Compare the distance, dist(node.point, target), with the tolerance.",
    ),
    Mistake(
        "The search returns every node that it visits, whatever its distance.",
        _prediction_from_distance(lambda step, tolerance, depth: True),
        "Compare the distance, dist(node.point, target), with the tolerance.",
    ),
    cases=(
        (_grid_points(13, 2), np.zeros(2), 2.0),
        (_grid_points(12, 2), np.zeros(2), 3.0),
        (_grid_points(13, 3), np.zeros(3), 2.0),
        (_grid_points(52, 3), np.zeros(3), 3.0),
        (_grid_points(49, 2), np.full(2, 2.0), 1.0),
        (_grid_points(62, 2), np.zeros(2), 2.0),
        (_grid_points(64, 2), np.zeros(2), 2.0),
    ),
    right=lambda points, target, tolerance: {
        index for index, point in enumerate(points) if math.dist(point, target) <= tolerance
    },
    is_same=_same_indices,
    call=lambda KdTree, points, target, tolerance: build_tree(KdTree, grow_tree(points)).search(
        target, tolerance
    ),
    class_name="KdTree",
)
